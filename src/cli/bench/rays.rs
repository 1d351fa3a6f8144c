//! Real rays: what the packet engine's own queues hold while it renders a scene, tile by tile, in the engine's order; or those
//! of a file.

use crate::bvh::ray::RayQueue;
use crate::bvh::{Bvh, RayKind, Scratch};
use crate::error::{Error, Result};
use crate::files::{memory, read};
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::tile;
use crate::render::{PATHS_AT_ONCE, fill_slots};
use crate::settings::{Crop, Settings};
use crate::setup::Setup;
use crate::tables::PreparedScene;
use std::io::{BufReader, Read};
use std::path::Path;

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
    pub name: String,
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

/// The rays of the first sample of every pixel, by kind (the number behind a name is how many events lie before); kinds without
/// rays are left out. A function of the scene and the settings alone.
pub fn record(scene: &PreparedScene, settings: &Settings) -> Vec<RaySet> {
    let setup = Setup::new(scene, settings);
    let plan = Plan::new(&setup);
    let (mut state, mut counters) = (plan.tile_state(PATHS_AT_ONCE), Counters::default());
    let set = |name: &str, kind| RaySet { name: name.to_owned(), kind, tiles: Vec::new() };
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

/// Bytes of the count before the rays of a file, and of a ray.
const HEAD: u64 = 8;
const RAY: u64 = 32;

/// The rays of a file: their number as u64, then 8 f32 a ray, `ox oy oz tmin dx dy dz tmax`, all little-endian. They are asked
/// about in the order of the file, as many at once as the engine's queues hold. With them, how many are no rays since
/// they hold what is not a number, or a direction of no length.
///
/// # Errors
/// [`Error::Read`]; [`Error::Parse`] if the file is of another length than its count says, or holds no ray.
pub fn read_rays(path: &Path) -> Result<(RaySet, usize)> {
    let failed = |source| Error::Read { path: path.to_owned(), source };
    let fault = |message: String| {
        let layout = "a u64 count, then for every ray 8 f32: ox oy oz tmin dx dy dz tmax, all little-endian";
        Err(Error::parse(path, None, format!("{message}; a file of rays is {layout}")))
    };
    let file = read::open(path)?;
    let about = file.metadata().map_err(failed)?;
    let mut file = BufReader::new(file);
    let mut head = [0; HEAD as usize];
    if about.len() < HEAD {
        return fault(format!("{} bytes long", about.len()));
    }
    file.read_exact(&mut head).map_err(failed)?;
    let count = u64::from_le_bytes(head);
    if count == 0 {
        return fault("holds no ray".into());
    }
    if count.checked_mul(RAY).and_then(|bytes| bytes.checked_add(HEAD)) != Some(about.len()) {
        return fault(format!("{} bytes long, but its first 8 say {count} rays of {RAY} bytes", about.len()));
    }
    memory::claim(about.len(), &path.display().to_string())?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut set = RaySet { name, kind: RayKind::Bounce, tiles: Vec::new() };
    let (mut left, mut broken) = (count as usize, 0);
    while left > 0 {
        let count = left.min(PATHS_AT_ONCE);
        let mut rays = RayQueue::with_len(count);
        for row in 0..count {
            let mut bytes = [[0; 4]; 8];
            file.read_exact(bytes.as_flattened_mut()).map_err(failed)?;
            let numbers @ [ox, oy, oz, tmin, dx, dy, dz, tmax] = bytes.map(f32::from_le_bytes);
            (rays.ox[row], rays.oy[row], rays.oz[row], rays.tmin[row]) = (ox, oy, oz, tmin);
            (rays.dx[row], rays.dy[row], rays.dz[row], rays.tmax[row]) = (dx, dy, dz, tmax);
            let is_ray = numbers[..7].iter().all(|number| number.is_finite()) && !tmax.is_nan();
            broken += usize::from(!is_ray || [dx, dy, dz] == [0.0; 3]);
        }
        set.tiles.push(RayTile { rays, count });
        left -= count;
    }
    Ok((set, broken))
}

impl RaySet {
    /// Finds out what rays of a file are best taken for in this tree: what most of the tiles are.
    pub fn find_kind(&mut self, bvh: &Bvh) {
        let mut scratch = Scratch::default();
        let mut is_camera = |tile: &RayTile| bvh.likely_kind(&tile.rays, tile.count, &mut scratch) == RayKind::Camera;
        let camera = self.tiles.iter().filter(|tile| is_camera(tile)).count();
        self.kind = if 2 * camera >= self.tiles.len() { RayKind::Camera } else { RayKind::Bounce };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(count: u64, rays: &[[f32; 8]]) -> Vec<u8> {
        let numbers = rays.iter().flatten().flat_map(|number| number.to_le_bytes());
        count.to_le_bytes().into_iter().chain(numbers).collect()
    }

    #[test]
    fn files_of_rays_are_read_as_they_are_or_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("some.rays");
        let of = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read_rays(&path)
        };
        let rays: Vec<[f32; 8]> =
            (0..PATHS_AT_ONCE + 3).map(|i| [i as f32, 1.0, 2.0, 0.0, 0.0, 0.6, 0.8, f32::INFINITY]).collect();
        let (set, broken) = of(&file(rays.len() as u64, &rays)).unwrap();
        assert_eq!((set.name.as_str(), set.count(), broken), ("some", rays.len(), 0));
        assert_eq!(set.tiles.iter().map(|tile| tile.count).collect::<Vec<_>>(), [PATHS_AT_ONCE, 3]);
        let last = &set.tiles[1].rays;
        assert_eq!((last.ox[2], last.dz[2], last.tmax[2]), (PATHS_AT_ONCE as f32 + 2.0, 0.8, f32::INFINITY));
        let [mut nan, mut still] = [rays[0]; 2];
        nan[1] = f32::NAN;
        still[4..7].fill(0.0);
        assert_eq!(of(&file(3, &[rays[0], nan, still])).unwrap().1, 2);
        let whole = file(2, &rays[..2]);
        for bytes in [&b""[..], &whole[..7], &whole[..whole.len() - 1], &file(0, &[]), &file(u64::MAX, &rays[..1])] {
            let error = of(bytes).err().unwrap().to_string();
            assert!(error.contains("some.rays: ") && error.contains("ox oy oz tmin"), "{error}");
        }
        assert!(read_rays(directory.path()).is_err() && read_rays(&directory.path().join("none")).is_err());
    }
}
