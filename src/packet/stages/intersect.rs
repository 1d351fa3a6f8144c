//! Stages: rays through the tree; what is cut out of triangles lets them pass.

use crate::bvh::RayKind;
use crate::bvh::ray::NO_HIT;
use crate::lanes::{LANES, Mask8, U32x8};
use crate::packet::alpha_masks::pass_alpha_masks;
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{ShadowQueue, TileState};

/// Stage: the closest hits of all rays in `paths`.
pub fn intersect_closest<const ALPHA_MASKS: bool>(
    context: &StageContext,
    state: &mut TileState,
    counters: &mut Counters,
) {
    let (kind, count) = if context.depth == 0 {
        (RayKind::Camera, &mut counters.rays.camera)
    } else {
        (RayKind::Bounce, &mut counters.rays.bounce)
    };
    *count += state.paths.len as u64;
    let TileState { paths, hits, passing, scratch, .. } = state;
    let scene = context.setup.scene;
    scene.bvh.intersect_queue(kind, &paths.rays, 0..paths.len, hits, scratch, &mut counters.closest_walk);
    if ALPHA_MASKS {
        pass_alpha_masks((&scene.bvh, &scene.alpha_masks), (&paths.rays, paths.len), hits, passing, scratch);
    }
}

/// Stage: shadow rays that nothing blocks add their contribution.
pub fn intersect_shadow<const ALPHA_MASKS: bool>(
    context: &StageContext,
    state: &mut TileState,
    counters: &mut Counters,
) {
    let TileState { shadow, slots, passing, scratch, .. } = state;
    counters.rays.shadow += shadow.len as u64;
    let ShadowQueue { rays, blocked, hits, len, .. } = shadow;
    // Shadow rays of camera hits start close together; later ones are as scattered as the rays that found their origins.
    let kind = if context.depth == 0 { RayKind::Shadow } else { RayKind::Bounce };
    let scene = context.setup.scene;
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
