//! Real rays: what the packet engine's own queues hold while it renders a scene, tile by tile, in the engine's order.

use crate::bvh::RayKind;
use crate::bvh::ray::RayQueue;
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::tile;
use crate::render::{PATHS_AT_ONCE, fill_slots};
use crate::settings::{Crop, Settings};
use crate::setup::Setup;
use crate::tables::PreparedScene;

/// Pixels of a recorded tile: with one sample each they fill the engine's queues.
const TILE: (u32, u32) = (64, 64);
const _: () = assert!(TILE.0 as usize * TILE.1 as usize == PATHS_AT_ONCE);

/// The rays of one queue of one tile.
pub struct RayTile {
    /// The rays, and padding.
    pub rays: RayQueue,
    /// How many are rays.
    pub count: usize,
}

/// The rays of one kind.
pub struct RaySet {
    /// What they are, in words.
    pub name: &'static str,
    /// What the engine takes them for.
    pub kind: RayKind,
    /// One queue a tile.
    pub tiles: Vec<RayTile>,
}

impl RaySet {
    /// All rays.
    pub fn count(&self) -> usize {
        self.tiles.iter().map(|tile| tile.count).sum()
    }

    fn push(&mut self, rays: &RayQueue, count: usize) {
        if count > 0 {
            let mut rays = rays.clone();
            rays.resize(count);
            self.tiles.push(RayTile { rays, count });
        }
    }
}

/// The rays of the first sample of every pixel, by kind (the number behind a name is how many events lie before); kinds without rays are left out. A function of the scene and the
/// settings alone.
pub fn record(scene: &PreparedScene, settings: &Settings) -> Vec<RaySet> {
    let setup = Setup::new(scene, settings);
    let plan = Plan::new(&setup);
    let (mut state, mut counters) = (plan.tile_state(PATHS_AT_ONCE), Counters::default());
    let set = |name, kind| RaySet { name, kind, tiles: Vec::new() };
    let mut camera = set("camera", RayKind::Camera);
    let mut shadow = set("shadow", RayKind::Shadow);
    let mut shadow_1 = set("shadow 1", RayKind::Bounce);
    let mut bounce_1 = set("bounce 1", RayKind::Bounce);
    let mut bounce_3 = set("bounce 3", RayKind::Bounce);
    let (width, height) = setup.frame.film;
    let corners =
        (0..height).step_by(TILE.1 as usize).flat_map(|y| (0..width).step_by(TILE.0 as usize).map(move |x| (x, y)));
    for (x, y) in corners {
        let area = Crop { x, y, width: TILE.0.min(width - x), height: TILE.1.min(height - y) };
        fill_slots(&mut state.slots, &mut Vec::new(), area, 0, 1);
        let mut clock = tile::begin(&setup, &plan, &mut state, &mut counters);
        for depth in 0..4 {
            match depth {
                0 => camera.push(&state.paths.rays, state.paths.len),
                1 => bounce_1.push(&state.paths.rays, state.paths.len),
                3 => bounce_3.push(&state.paths.rays, state.paths.len),
                _ => {}
            }
            if state.paths.len == 0 || depth == 3 {
                break;
            }
            clock = tile::step(&setup, &plan, &mut state, &mut counters, depth, clock);
            match depth {
                0 => shadow.push(&state.shadow.rays, state.shadow.len),
                1 => shadow_1.push(&state.shadow.rays, state.shadow.len),
                _ => {}
            }
        }
    }
    [camera, shadow, bounce_1, shadow_1, bounce_3].into_iter().filter(|set| set.count() > 0).collect()
}
