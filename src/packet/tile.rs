//! The loop: the stages of the plan over the queues of one tile. It knows no radiance.

use std::time::Instant;

use crate::packet::context::StageContext;
use crate::packet::counters::{Counters, Stage};
use crate::packet::plan::Plan;
use crate::packet::queues::{Slots, TileState};
use crate::settings::DEPTH_GUARD;
use crate::setup::Setup;

/// Follows the paths in `state.slots` (pixel and sample set, radiance 0) to their ends; their radiance is then in the slots.
pub fn trace_paths(setup: &Setup, plan: &Plan, state: &mut TileState, counters: &mut Counters) {
    let mut clock = begin(setup, plan, state, counters);
    let mut depth = 0;
    while state.paths.len > 0 {
        clock = step(setup, plan, state, counters, depth, clock);
        depth += 1;
    }
    if let (Some(steps), Some(guide)) = (&mut state.steps, &setup.guide) {
        let Slots { pixel, radiance, len, .. } = &state.slots;
        steps.end_paths(guide, (0..*len).map(|slot| (pixel[slot], radiance[slot].value())));
    }
}

/// The camera rays of the paths in `state.slots`: they are then in `state.paths`. Returns now, for [`step`].
pub fn begin(setup: &Setup, plan: &Plan, state: &mut TileState, counters: &mut Counters) -> Instant {
    let clock = Instant::now();
    let context = StageContext { setup, decisions: &plan.decisions, depth: 0 };
    let Slots { pixel, albedo, inverse_pixel, len, .. } = &mut state.slots;
    albedo.fill(1.0);
    if let Some(guide) = setup.guide.as_ref().filter(|_| plan.decisions.needs.inverse_pixel) {
        for (inverse, &pixel) in inverse_pixel.iter_mut().zip(&pixel[..*len]) {
            *inverse = guide.pixels.inverse(pixel);
        }
    }
    (plan.generate_camera_rays)(&context, state, counters);
    counters.paths += state.slots.len as u64;
    counters.note(Stage::GenerateCameraRays, state.slots.len, clock)
}

/// One round of the plan's stages for the rays in `state.paths`, which lie behind `depth` events. The rays that go on are
/// then in `state.paths`, those that were traced in `state.next`, their hits and shadow rays in `hits` and `shadow`.
pub fn step(
    setup: &Setup,
    plan: &Plan,
    state: &mut TileState,
    counters: &mut Counters,
    depth: u32,
    mut clock: Instant,
) -> Instant {
    let context = StageContext { setup, decisions: &plan.decisions, depth };
    state.next.len = 0;
    state.shadow.len = 0;
    for &(stage, run) in plan.round.iter().filter(|(stage, _)| !(context.is_over() && stage.scatters())) {
        run(&context, state, counters);
        clock = counters.note(stage, items(stage, state), clock);
    }
    if depth + 1 == DEPTH_GUARD {
        counters.guarded += state.surfaces.0.iter().map(|queue| queue.len as u64).sum::<u64>();
    }
    if let Some(steps) = &mut state.steps {
        steps.set_out(|slot| state.slots.radiance[slot].value());
    }
    std::mem::swap(&mut state.paths, &mut state.next);
    clock
}

/// How many items a stage has just worked on.
fn items(stage: Stage, state: &TileState) -> usize {
    match stage {
        Stage::GenerateCameraRays | Stage::AddToFilm => state.slots.len,
        Stage::IntersectClosest | Stage::SortHits => state.paths.len,
        Stage::ShadeMiss => state.misses.len,
        Stage::ShadeEmitter => state.emitters.len,
        Stage::Shade(kind) => state.surfaces[kind].len,
        Stage::IntersectShadow => state.shadow.len,
    }
}
