//! One path alone in its tile, read from the queues after every step of the tile's own loop.

use crate::bvh::ray::RayQueue;
use crate::lanes::LANES;
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::queues::{Columns3, Slots, TileState};
use crate::packet::tile;
use crate::sampler::pixel_address;
use crate::setup::Setup;
use crate::trace::{PathStep, ShadowStep};

/// Follows sample `sample` of pixel (`x`, `y`) and tells of every ray.
pub fn trace_path(setup: &Setup, plan: &Plan, (x, y): (u32, u32), sample: u32) -> Vec<PathStep> {
    let (mut state, mut counters) = (plan.tile_state(LANES), Counters::default());
    state.slots.pixel[0] = pixel_address(x, y);
    state.slots.sample[0] = sample;
    state.slots.len = 1;
    let mut clock = tile::begin(setup, plan, &mut state, &mut counters);
    let mut steps = Vec::new();
    while state.paths.len > 0 {
        clock = tile::step(setup, plan, &mut state, &mut counters, steps.len() as u32, clock);
        steps.push(read_step(&state));
    }
    steps
}

/// The step just done: its ray has been swapped into `next`.
fn read_step(state: &TileState) -> PathStep {
    let TileState { next: traced, hits, shadow, slots: Slots { radiance, .. }, .. } = state;
    let shadow = (shadow.len > 0).then(|| ShadowStep {
        direction: direction(&shadow.rays),
        contribution: first(&shadow.contribution),
        blocked: shadow.blocked[0] & 1 == 1,
    });
    PathStep {
        origin: [traced.rays.ox[0], traced.rays.oy[0], traced.rays.oz[0]],
        direction: direction(&traced.rays),
        beta: first(&traced.beta),
        triangle: hits.triangle[0],
        t: hits.t[0],
        shadow,
        radiance: radiance[0].value(),
    }
}

fn direction(rays: &RayQueue) -> [f32; 3] {
    [rays.dx[0], rays.dy[0], rays.dz[0]]
}

fn first(columns: &Columns3) -> [f32; 3] {
    [columns.x[0], columns.y[0], columns.z[0]]
}
