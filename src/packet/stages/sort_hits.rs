//! Stage: hits to queues, by what they hit. Queues come out dense, so shading lanes stay full.

use crate::bvh::ray::{HitQueue, NO_HIT};
use crate::lanes::{F32x8, LANES, Mask8, U32x8};
use crate::packet::plan::Plan;
use crate::packet::queues::{IndexList, PathQueue, SLOT, SurfaceQueue, TileState};
use crate::setup::Setup;
use crate::tables::materials::MaterialKind;
use crate::tables::triangles::CLASS_EMITS;

/// Sorts the hits of all paths. Without `scatter` (after the last event) surfaces are left alone.
pub fn sort_hits(setup: &Setup, plan: &Plan, state: &mut TileState, scatter: bool) {
    let TileState { paths, hits, misses, emitters, diffuse, mirror, conductor, dielectric, plastic, .. } = state;
    for list in [&mut *misses, &mut *emitters] {
        list.len = 0;
    }
    for queue in [&mut *diffuse, &mut *mirror, &mut *conductor, &mut *dielectric, &mut *plastic] {
        queue.len = 0;
    }
    for first in (0..paths.len).step_by(LANES) {
        let active = Mask8::first((paths.len - first).min(LANES));
        let triangle = U32x8::load(&hits.triangle, first);
        let missed = triangle.eq(U32x8::splat(NO_HIT));
        let hit = active.and_not(missed);
        let class = match plan.only_class {
            Some(class) => U32x8::splat(class as u32),
            None => look_up(&setup.scene.classes, triangle),
        };
        append_index(misses, plan.needs.misses, first, active & missed);
        let emits = (class & U32x8::splat(CLASS_EMITS as u32)).eq(U32x8::splat(CLASS_EMITS as u32));
        append_index(emitters, plan.needs.emitters, first, hit & emits);
        let kind = class & U32x8::splat(0x7f);
        let of_kind = |wanted: MaterialKind| hit & kind.eq(U32x8::splat(wanted as u32));
        if scatter {
            append_surfaces(diffuse, plan.needs.diffuse, paths, hits, first, of_kind(MaterialKind::Diffuse));
            append_surfaces(mirror, plan.needs.mirror, paths, hits, first, of_kind(MaterialKind::Mirror));
            append_surfaces(conductor, plan.needs.conductor, paths, hits, first, of_kind(MaterialKind::Conductor));
            append_surfaces(dielectric, plan.needs.dielectric, paths, hits, first, of_kind(MaterialKind::Dielectric));
            append_surfaces(plastic, plan.needs.plastic, paths, hits, first, of_kind(MaterialKind::Plastic));
        }
    }
}

/// The classes of eight triangles; misses get class 0.
#[inline(always)]
fn look_up(classes: &[u8], triangle: U32x8) -> U32x8 {
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
    needed: bool,
    paths: &PathQueue,
    hits: &HitQueue,
    first: usize,
    mask: Mask8,
) {
    let bits = mask.bits();
    if !needed || bits == 0 {
        return;
    }
    let at = queue.len;
    U32x8::load(&hits.triangle, first).compress(bits).store(&mut queue.triangle, at);
    F32x8::load(&hits.u, first).compress(bits).store(&mut queue.u, at);
    F32x8::load(&hits.v, first).compress(bits).store(&mut queue.v, at);
    queue.direction.append(at, paths.rays.packet(first).direction, bits);
    queue.beta.append(at, paths.beta.load(first), bits);
    (U32x8::load(&paths.slot, first) & U32x8::splat(SLOT)).compress(bits).store(&mut queue.slot, at);
    queue.len += bits.count_ones() as usize;
}
