//! The loop: a list of stages over the queues of one tile. It knows no radiance.

use std::time::Instant;

use crate::bvh::RayKind;
use crate::bvh::ray::NO_HIT;
use crate::lanes::{LANES, Mask8, U32x8};
use crate::packet::alpha_masks::pass_alpha_masks;
use crate::packet::counters::{Counters, Stage};
use crate::packet::plan::Plan;
use crate::packet::queues::{ShadowQueue, TileState};
use crate::packet::stages::shade_emitter::shade_emitter;
use crate::packet::stages::sort_hits::sort_hits;
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
}

/// The camera rays of the paths in `state.slots`: they are then in `state.paths`. Returns now, for [`step`].
pub fn begin(setup: &Setup, plan: &Plan, state: &mut TileState, counters: &mut Counters) -> Instant {
    let clock = Instant::now();
    (plan.generate_camera_rays)(setup, state);
    counters.paths += state.slots.len as u64;
    counters.note(Stage::GenerateCameraRays, state.slots.len, clock)
}

/// One round of all stages for the rays in `state.paths`, which lie behind `depth` events. The rays that go on are then
/// in `state.paths`, those that were traced in `state.next`, their hits and shadow rays in `hits` and `shadow`.
pub fn step(
    setup: &Setup,
    plan: &Plan,
    state: &mut TileState,
    counters: &mut Counters,
    depth: u32,
    mut clock: Instant,
) -> Instant {
    (plan.intersect_closest)(setup, state, counters, depth);
    clock = counters.note(Stage::IntersectClosest, state.paths.len, clock);

    let last = depth == setup.max_depth;
    sort_hits(setup, plan, state, !last);
    if depth + 1 == DEPTH_GUARD {
        counters.guarded += plan.surfaces.iter().map(|(stage, _)| state.surface_len(*stage) as u64).sum::<u64>();
    }
    clock = counters.note(Stage::SortHits, state.paths.len, clock);

    if plan.needs.misses {
        (plan.shade_miss)(setup, plan, state);
        clock = counters.note(Stage::ShadeMiss, state.misses.len, clock);
    }
    if plan.needs.emitters {
        shade_emitter(setup, plan, state);
        clock = counters.note(Stage::ShadeEmitter, state.emitters.len, clock);
    }
    state.next.len = 0;
    state.shadow.len = 0;
    for (stage, shade) in plan.surfaces.iter().filter(|_| !last) {
        shade(setup, plan, state, depth);
        clock = counters.note(*stage, state.surface_len(*stage), clock);
    }
    if plan.needs.shadow && !last {
        (plan.intersect_shadow)(setup, state, counters, depth);
        clock = counters.note(Stage::IntersectShadow, state.shadow.len, clock);
    }
    std::mem::swap(&mut state.paths, &mut state.next);
    clock
}

/// A stage that traces rays, which lie behind so many events.
pub type IntersectStage = fn(&Setup, &mut TileState, &mut Counters, u32);

/// The stages that find closest hits and trace shadow rays, in a scene with or without cut-outs.
pub fn variants(alpha_masks: bool) -> (IntersectStage, IntersectStage) {
    match alpha_masks {
        false => (intersect_closest::<false>, intersect_shadow::<false>),
        true => (intersect_closest::<true>, intersect_shadow::<true>),
    }
}

/// Stage: the closest hits of all rays in `paths`.
fn intersect_closest<const ALPHA_MASKS: bool>(
    setup: &Setup,
    state: &mut TileState,
    counters: &mut Counters,
    depth: u32,
) {
    let (kind, count) = if depth == 0 {
        (RayKind::Camera, &mut counters.rays.camera)
    } else {
        (RayKind::Bounce, &mut counters.rays.bounce)
    };
    *count += state.paths.len as u64;
    let TileState { paths, hits, passing, scratch, .. } = state;
    let scene = setup.scene;
    scene.bvh.intersect_queue(kind, &paths.rays, 0..paths.len, hits, scratch, &mut counters.closest_walk);
    if ALPHA_MASKS {
        pass_alpha_masks((&scene.bvh, &scene.alpha_masks), (&paths.rays, paths.len), hits, passing, scratch);
    }
}

/// Stage: shadow rays that nothing blocks add their contribution.
fn intersect_shadow<const ALPHA_MASKS: bool>(
    setup: &Setup,
    state: &mut TileState,
    counters: &mut Counters,
    depth: u32,
) {
    let TileState { shadow, slots, passing, scratch, .. } = state;
    counters.rays.shadow += shadow.len as u64;
    let ShadowQueue { rays, blocked, hits, len, .. } = shadow;
    // Shadow rays of camera hits start close together; later ones are as scattered as the rays that found their origins.
    let kind = if depth == 0 { RayKind::Shadow } else { RayKind::Bounce };
    let scene = setup.scene;
    if ALPHA_MASKS {
        // What blocks a segment may be cut out there, so any hit is not enough.
        scene.bvh.intersect_queue(kind, rays, 0..*len, hits, scratch, &mut counters.shadow_walk);
        pass_alpha_masks((&scene.bvh, &scene.alpha_masks), (rays, *len), hits, passing, scratch);
        blocked.clear();
        let hit = |first: usize| !U32x8::load(&hits.triangle, first).eq(U32x8::splat(NO_HIT)).bits();
        blocked.extend((0..*len).step_by(LANES).map(hit));
    } else {
        scene.bvh.occluded_queue(kind, rays, 0..*len, blocked, scratch, &mut counters.shadow_walk);
    }
    for first in (0..shadow.len).step_by(LANES) {
        let active = Mask8::first((shadow.len - first).min(LANES)).bits();
        let free = active & !shadow.blocked[first / LANES];
        slots.add(U32x8::load(&shadow.slot, first), shadow.contribution.load(first), free);
    }
}
