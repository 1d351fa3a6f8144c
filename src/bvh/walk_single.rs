//! One ray at a time: eight boxes, eight triangles at once.

use crate::bvh::boxes::{OneRayBoxes, WIDENING};
use crate::bvh::node::{LeafBlock, Tables, block_of, is_leaf};
use crate::bvh::ray::{Hit, Ray};
use crate::bvh::sort::sort_children;
use crate::bvh::triangle::OneRay;
use crate::lanes::{F32x8, LANES, U32x8};

/// Nodes and leaves still to be visited, with their distances.
#[derive(Clone, Debug, Default)]
pub(super) struct Stack {
    words: Vec<u32>,
    near: Vec<u32>,
}

impl Stack {
    /// Room for `entries`, and for the eight that a node stores at once.
    pub(super) fn reserve(&mut self, entries: usize) {
        if self.words.len() < entries + LANES {
            self.words.resize(entries + LANES, 0);
            self.near.resize(entries + LANES, 0);
        }
    }
}

/// The closest hit in a block, if it is closer than `best`, or as close and of a lower id. Hits count behind `tmin`; with
/// `behind` those at `tmin` itself do, too, if their id is higher than that.
#[inline(always)]
fn closest_in_block(ray: &OneRay, block: &LeafBlock, tmin: f32, behind: Option<u32>, best: &mut Hit) -> bool {
    let edges = ray.edges(block);
    let t = edges.t_scaled / edges.det;
    let least = F32x8::splat(tmin);
    let counts = if behind.is_some() { t.ge(least) } else { t.gt(least) };
    let mut hits = (edges.inside & counts & t.le(F32x8::splat(best.t))).bits();
    if hits == 0 {
        return false;
    }
    let (ts, vs, ws, dets) = (t.to_array(), edges.v.to_array(), edges.w.to_array(), edges.det.to_array());
    let mut changed = false;
    while hits != 0 {
        let lane = hits.trailing_zeros() as usize & 7;
        hits &= hits - 1;
        let passed = behind.is_some_and(|id| ts[lane] == tmin && block.ids[lane] <= id);
        if !passed && (ts[lane] < best.t || (ts[lane] == best.t && block.ids[lane] < best.triangle)) {
            *best = Hit { t: ts[lane], triangle: block.ids[lane], u: vs[lane] / dets[lane], v: ws[lane] / dets[lane] };
            changed = true;
        }
    }
    changed
}

/// The closest hit of `ray`.
#[inline(always)]
pub(super) fn closest(tables: Tables, ray: &Ray, stack: &mut Stack) -> Hit {
    closest_of(tables, ray, None, stack)
}

/// The first hit of `ray` behind `hit`, in the order of `t` and, on equal `t`, of ids.
pub(super) fn closest_behind(tables: Tables, ray: &Ray, hit: Hit, stack: &mut Stack) -> Hit {
    closest_of(tables, &Ray { tmin: hit.t, ..*ray }, Some(hit.triangle), stack)
}

/// [`closest`], also at `ray.tmin` itself among the ids above `behind`.
#[inline(always)]
fn closest_of(tables: Tables, ray: &Ray, behind: Option<u32>, stack: &mut Stack) -> Hit {
    let mut best = Hit::none(ray.tmax);
    if !ray.is_finite() {
        return best;
    }
    let boxes = OneRayBoxes::new(ray.origin, ray.direction, ray.tmin, tables.extent);
    let triangles = OneRay::new(ray.origin, ray.direction);
    let (words, near) = (&mut stack.words[..], &mut stack.near[..]);
    let mut best_wide = best.t * WIDENING;
    let mut top = 0;
    let mut next = 0;
    loop {
        if is_leaf(next) {
            if closest_in_block(&triangles, &tables.leaves[block_of(next)], ray.tmin, behind, &mut best) {
                best_wide = best.t * WIDENING;
            }
        } else {
            let node = &tables.nodes[next as usize];
            let (entry, hit) = boxes.test(&node.bounds, F32x8::splat(best_wide));
            let (order, distances) = sort_children(entry, hit);
            U32x8::from_array(node.children).permute(order).store(words, top);
            distances.store(near, top);
            top += hit.count() as usize;
        }
        loop {
            if top == 0 {
                return best;
            }
            top -= 1;
            if f32::from_bits(near[top]) <= best_wide {
                break;
            }
        }
        next = words[top];
    }
}

/// Whether `ray` hits anything.
#[inline(always)]
pub(super) fn any(tables: Tables, ray: &Ray, stack: &mut Stack) -> bool {
    if !ray.is_finite() {
        return false;
    }
    let boxes = OneRayBoxes::new(ray.origin, ray.direction, ray.tmin, tables.extent);
    let triangles = OneRay::new(ray.origin, ray.direction);
    let (tmin, tmax) = (F32x8::splat(ray.tmin), F32x8::splat(ray.tmax));
    let best_wide = F32x8::splat(ray.tmax * WIDENING);
    let words = &mut stack.words[..];
    let mut top = 0;
    let mut next = 0;
    loop {
        if is_leaf(next) {
            let edges = triangles.edges(&tables.leaves[block_of(next)]);
            let t = edges.t_scaled / edges.det;
            if (edges.inside & t.gt(tmin) & t.le(tmax)).any() {
                return true;
            }
        } else {
            let node = &tables.nodes[next as usize];
            let (entry, hit) = boxes.test(&node.bounds, best_wide);
            // Nearest first; streams, which sort nothing here, are the fast walk for any hit.
            let (order, _) = sort_children(entry, hit);
            U32x8::from_array(node.children).permute(order).store(words, top);
            top += hit.count() as usize;
        }
        if top == 0 {
            return false;
        }
        top -= 1;
        next = words[top];
    }
}
