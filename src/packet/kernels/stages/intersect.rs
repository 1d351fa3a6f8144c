//! Stages: rays through the tree; what is cut out of triangles lets them pass.

use super::here;
use crate::bvh::ray::{ANY_ID, NO_HIT};
use crate::bvh::{RayKind, Scratch, Segments};
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{ShadowQueue, TileState};
use crate::tables::lights::targets::{DELTA, MISSED};
use here::kernels::alpha_masks::{is_there, pass_alpha_masks};
use here::kernels::columns::{SlotLanes, VectorLanes};
use here::kernels::lights::visibility::record;
use here::lanes::{F32x8, LANES, Mask8, U32x8};

/// Stage: the closest hits of all rays in `paths`.
#[inline(always)]
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
        let masks = context.decisions.alpha_masks(scene);
        pass_alpha_masks((&scene.bvh, masks), (&paths.rays, paths.len), hits, passing, scratch);
    }
}

/// Stage: shadow rays that nothing blocks add their contribution.
#[inline(always)]
pub fn intersect_shadow<const ALPHA_MASKS: bool>(
    context: &StageContext,
    state: &mut TileState,
    counters: &mut Counters,
) {
    let TileState { shadow, slots, passing, scratch, records, sightings, .. } = state;
    counters.rays.shadow += shadow.len as u64;
    let ShadowQueue { rays, target, before, blocked, hits, len, .. } = shadow;
    let targets = &context.setup.lights.targets;
    let aimed = targets.aimed;
    if aimed {
        before.clear();
        let common = MISSED | DELTA;
        before.extend(
            target[..*len].iter().map(|&light| if light & common != 0 { ANY_ID } else { targets.before(light) }),
        );
        before.resize(len.next_multiple_of(LANES), 0);
    }
    // Shadow rays of camera hits start close together; later ones are as scattered as the rays that found their origins.
    let kind = if context.depth == 0 { RayKind::Shadow } else { RayKind::Bounce };
    let scene = context.setup.scene;
    if ALPHA_MASKS {
        // What blocks a segment may be cut out there, so any hit is not enough.
        scene.bvh.intersect_queue(kind, rays, 0..*len, hits, scratch, &mut counters.shadow_walk);
        let masks = context.decisions.alpha_masks(scene);
        pass_alpha_masks((&scene.bvh, masks), (rays, *len), hits, passing, scratch);
        blocked.clear();
        for first in (0..*len).step_by(LANES) {
            let triangle = U32x8::load(&hits.triangle, first);
            let mut hit = !triangle.eq(U32x8::splat(NO_HIT));
            if aimed {
                // What the rays aim at does not block them, nor what comes after it in the order of closest hits.
                let before_end = F32x8::load(&hits.t, first).lt(F32x8::load(&rays.tmax, first));
                hit = hit & (before_end | triangle.lt_signed(U32x8::load(before, first)));
            }
            blocked.push(hit.bits());
        }
    } else if aimed {
        let segments = Segments::aimed(rays, before);
        scene.bvh.occluded_queue(kind, segments, 0..*len, blocked, scratch, &mut counters.shadow_walk);
    } else {
        scene.bvh.occluded_queue(kind, &*rays, 0..*len, blocked, scratch, &mut counters.shadow_walk);
    }
    if std::mem::take(&mut shadow.missed) {
        pass_missed_targets::<ALPHA_MASKS>(context, shadow, scratch);
    }
    for first in (0..shadow.len).step_by(LANES) {
        let active = Mask8::first((shadow.len - first).min(LANES)).bits();
        let free = active & !shadow.blocked[first / LANES];
        slots.add(U32x8::load(&shadow.slot, first), shadow.contribution.load(first), free);
    }
    if let Some(records) = records {
        for (row, lesson) in shadow.lessons.drain(..).enumerate() {
            records.note(&lesson, shadow.blocked[row / LANES] >> (row % LANES) & 1 == 0);
        }
    }
    if let (Some(records), Some(visibility)) = (sightings, &context.setup.lights.visibility) {
        record(visibility, &shadow.rays, &shadow.blocked, shadow.len, records);
    }
}

/// Shadow rays that rounding makes miss the triangles they aim at end at the points they were sent to, and neither those
/// triangles nor the emitters in the same plane beside them block them. There is hardly ever one.
#[inline(always)]
fn pass_missed_targets<const ALPHA_MASKS: bool>(
    context: &StageContext,
    shadow: &mut ShadowQueue,
    scratch: &mut Scratch,
) {
    let scene = context.setup.scene;
    for first in (0..shadow.len).step_by(LANES) {
        let active = Mask8::first((shadow.len - first).min(LANES));
        let missed = (active & U32x8::load(&shadow.target, first).lt_signed(U32x8::ZERO)).bits();
        for row in (first..first + LANES).filter(|row| missed >> (row - first) & 1 == 1) {
            let passed = context.setup.lights.targets.passed(shadow.target[row] & !MISSED);
            let blocked = if ALPHA_MASKS {
                // What is passed may lie before what is not.
                let (masks, ShadowQueue { rays, hits, .. }) = (context.decisions.alpha_masks(scene), &mut *shadow);
                loop {
                    let hit = hits.triangle[row];
                    if hit == NO_HIT || !passed.contains(&hit) && is_there(masks, hits, row) {
                        break hit != NO_HIT;
                    }
                    scene.bvh.intersect_behind(rays, &[row as u32], hits, scratch);
                }
            } else {
                scene.bvh.occluded_but(&shadow.rays, row, &passed, scratch)
            };
            let bit = 1 << (row - first);
            let bits = &mut shadow.blocked[first / LANES];
            *bits = if blocked { *bits | bit } else { *bits & !bit };
        }
    }
}
