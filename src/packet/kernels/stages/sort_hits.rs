//! Stage: hits to queues, by what they hit. Queues come out dense, so shading lanes stay full.

use super::here;
use crate::bvh::ray::{HitQueue, NO_HIT};
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{IndexList, PathQueue, SLOT, SurfaceQueue, TileState};
use crate::tables::materials::MaterialKind;
use crate::tables::triangles::CLASS_EMITS;
use here::kernels::columns::{RowLanes, VectorLanes};
use here::lanes::{F32x8, LANES, Mask8, U32x8};
use here::walks::packets::RayPacket;

/// Sorts the hits of all paths. After the last event surfaces are left alone.
#[inline(always)]
pub fn sort_hits(context: &StageContext, state: &mut TileState, _: &mut Counters) {
    let StageContext { setup, decisions, .. } = context;
    let TileState { paths, hits, misses, emitters, surfaces, .. } = state;
    (misses.len, emitters.len) = (0, 0);
    surfaces.0.iter_mut().for_each(|queue| queue.len = 0);
    let kinds: &[MaterialKind] = if context.is_over() { &[] } else { &decisions.kinds };
    for first in (0..paths.len).step_by(LANES) {
        let active = Mask8::first((paths.len - first).min(LANES));
        let triangle = U32x8::load(&hits.triangle, first);
        let missed = triangle.eq(U32x8::splat(NO_HIT));
        let hit = active.and_not(missed);
        let class = match decisions.only_class {
            Some(class) => U32x8::splat(class as u32),
            None => look_up_classes(&setup.scene.classes, triangle),
        };
        append_index(misses, decisions.needs.misses, first, active & missed);
        let emits = (class & U32x8::splat(CLASS_EMITS as u32)).eq(U32x8::splat(CLASS_EMITS as u32));
        append_index(emitters, decisions.needs.emitters, first, hit & emits);
        let kind = class & U32x8::splat(0x7f);
        for &wanted in kinds {
            let mask = hit & kind.eq(U32x8::splat(wanted as u32));
            append_surfaces(&mut surfaces[wanted], paths, hits, first, mask, decisions.needs.positions);
        }
    }
}

/// The classes of eight triangles; misses get class 0.
#[inline(always)]
pub(super) fn look_up_classes(classes: &[u8], triangle: U32x8) -> U32x8 {
    U32x8::from_array(triangle.to_array().map(|id| classes.get(id as usize).copied().unwrap_or(0) as u32))
}

#[inline(always)]
fn append_index(list: &mut IndexList, needed: bool, first: usize, mask: Mask8) {
    if needed {
        list.append(first, mask.bits());
    }
}

#[inline(always)]
fn append_surfaces(
    queue: &mut SurfaceQueue,
    paths: &PathQueue,
    hits: &HitQueue,
    first: usize,
    mask: Mask8,
    positions: bool,
) {
    let bits = mask.bits();
    if bits == 0 {
        return;
    }
    let at = queue.len;
    U32x8::load(&hits.triangle, first).compress(bits).store(&mut queue.triangle, at);
    F32x8::load(&hits.u, first).compress(bits).store(&mut queue.u, at);
    F32x8::load(&hits.v, first).compress(bits).store(&mut queue.v, at);
    let rays = RayPacket::load(&paths.rays, first);
    queue.direction.append(at, rays.direction, bits);
    if positions {
        let found = rays.origin + rays.direction.scale(F32x8::load(&hits.t, first));
        queue.position.append(at, found, bits);
    }
    queue.beta.append(at, paths.beta.load(first), bits);
    (U32x8::load(&paths.slot, first) & U32x8::splat(SLOT)).compress(bits).store(&mut queue.slot, at);
    queue.len += bits.count_ones() as usize;
}
