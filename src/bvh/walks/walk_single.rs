//! One ray at a time: eight boxes, eight triangles at once.

use super::here;
use crate::bvh::node::{LeafBlock, Tables, block_of, holds_precise, is_leaf};
use crate::bvh::precise::{PRECISE, PreciseHit, PreciseRay};
use crate::bvh::ray::{Hit, Ray};
use crate::bvh::rounding::WIDENING;
use crate::bvh::rounding::most_moved;
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8};
use here::walks::boxes::OneRayBoxes;
use here::walks::sort::sort_children;
use here::walks::triangle::{Edges, OneRay, reach};

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

/// A ray and what it looks for.
struct Search<'a> {
    ray: &'a Ray,
    /// The ray as it came, where `ray` begins at a hit.
    whole: &'a Ray,
    triangles: OneRay,
    tables: Tables<'a>,
    /// Hits count behind `ray.tmin`; with an id those at `tmin` itself do, too, if their id is higher than that.
    behind: Option<u32>,
}

impl Search<'_> {
    /// The closest hit in the block of leaf `word`, if it is closer than `best`, or as close and of a lower id.
    #[inline(always)]
    fn closest_in_block(&self, word: u32, best: &mut Hit) -> bool {
        if holds_precise(word) {
            return self.closest_carefully(word, best);
        }
        let block = &self.tables.leaves[block_of(word)];
        let edges = self.triangles.edges(block);
        if !edges.inside.any() {
            return false;
        }
        if may_be_edge_on(&edges, self.tables, word, self.whole) {
            return self.closest_carefully(word, best);
        }
        self.closest_of(block, &edges, edges.inside, best)
    }

    /// [`Search::closest_in_block`] where triangles are precise or may be seen edge-on.
    #[cold]
    #[inline(never)]
    fn closest_carefully(&self, word: u32, best: &mut Hit) -> bool {
        here::run(
            #[inline(always)]
            || {
                let block = &self.tables.leaves[block_of(word)];
                let edges = self.triangles.edges(block);
                let coarse = coarse(&edges, self.tables, word, self.whole);
                let mut changed = false;
                for_each_precise(self.whole, block, &edges, self.tables, coarse, |id, hit| {
                    changed |= self.take(Hit { t: hit.t, triangle: id, u: hit.u, v: hit.v }, best);
                });
                changed | self.closest_of(block, &edges, common(&edges, coarse, self.tables, word), best)
            },
        )
    }

    /// The closest hit on the triangles `common` of a block.
    #[inline(always)]
    fn closest_of(&self, block: &LeafBlock, edges: &Edges, common: Mask8, best: &mut Hit) -> bool {
        let t = edges.t_scaled / edges.det;
        let least = F32x8::splat(self.ray.tmin);
        let counts = if self.behind.is_some() { t.ge(least) } else { t.gt(least) };
        let mut hits = (common & counts & t.le(F32x8::splat(best.t))).bits();
        if hits == 0 {
            return false;
        }
        let mut changed = false;
        let (ts, vs, ws, dets) = (t.to_array(), edges.v.to_array(), edges.w.to_array(), edges.det.to_array());
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize & 7;
            hits &= hits - 1;
            let hit =
                Hit { t: ts[lane], triangle: block.ids[lane], u: vs[lane] / dets[lane], v: ws[lane] / dets[lane] };
            changed |= self.take(hit, best);
        }
        changed
    }

    /// `hit` becomes the best if it counts and is closer, or as close and of a lower id.
    #[inline(always)]
    fn take(&self, hit: Hit, best: &mut Hit) -> bool {
        let tmin = self.ray.tmin;
        let counts = hit.t > tmin || self.behind.is_some_and(|id| hit.t == tmin && hit.triangle > id);
        let closer = hit.t < best.t || (hit.t == best.t && hit.triangle < best.triangle);
        if counts && closer {
            *best = hit;
        }
        counts && closer
    }
}

/// The lanes of a block that f64 has a say in: precise triangles that the ray may hit, others that it hits edge-on.
#[inline(always)]
fn coarse(edges: &Edges, tables: Tables, word: u32, ray: &Ray) -> Mask8 {
    let edge_on = edges.inside & edges.edge_on();
    if !holds_precise(word) {
        return edge_on;
    }
    let precise = Mask8::from_bits(tables.precise[block_of(word)]);
    let near = edges.near(F32x8::splat(most_moved(ray.origin, tables.extent)));
    (precise & near) | edge_on.and_not(precise)
}

/// The lanes of a block that f64 has no say in, of those that the ray hits.
#[inline(always)]
fn common(edges: &Edges, coarse: Mask8, tables: Tables, word: u32) -> Mask8 {
    let precise = Mask8::from_bits(tables.precise.get(block_of(word)).copied().unwrap_or(0));
    edges.inside.and_not(coarse | precise)
}

/// Whether a ray may see a triangle of a block edge-on that it hits.
#[inline(always)]
fn may_be_edge_on(edges: &Edges, tables: Tables, word: u32, ray: &Ray) -> bool {
    let least_det = F32x8::splat(reach(ray.origin, tables.extent) * tables.least_det[block_of(word)]);
    (edges.inside & edges.det.abs().lt(least_det)).any()
}

/// Tells of the hits that a ray has on triangles `lanes` of a block, precise ones and others that it sees edge-on, at any `t`.
#[inline(never)]
pub(super) fn for_each_precise(
    ray: &Ray,
    block: &LeafBlock,
    edges: &Edges,
    tables: Tables,
    lanes: Mask8,
    mut take: impl FnMut(u32, PreciseHit),
) {
    here::run(
        #[inline(always)]
        || {
            let precise = PreciseRay::new(ray.origin, ray.direction);
            let mut bits = lanes.bits();
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize & 7;
                bits &= bits - 1;
                let id = block.ids[lane];
                let class = tables.classes.get(id as usize).copied().unwrap_or(0);
                let hit = if class & PRECISE != 0 {
                    precise.hit(block.corners(lane), class)
                } else {
                    let [t_scaled, v, w, det] = [edges.t_scaled, edges.v, edges.w, edges.det].each(
                        #[inline(always)]
                        |x| x.to_array()[lane],
                    );
                    let t = precise.edge_on(block.corners(lane), t_scaled / det, ray.tmin);
                    t.map(|t| PreciseHit { t, u: v / det, v: w / det })
                };
                if let Some(hit) = hit {
                    take(id, hit);
                }
            }
        },
    )
}

/// The closest hit of `ray`.
#[inline(always)]
pub(super) fn closest(tables: Tables, ray: &Ray, stack: &mut Stack) -> Hit {
    closest_of(tables, (ray, ray), None, stack)
}

/// The first hit of `ray` behind `hit`, in the order of `t` and, on equal `t`, of ids.
#[inline(always)]
pub(super) fn closest_behind(tables: Tables, ray: &Ray, hit: Hit, stack: &mut Stack) -> Hit {
    closest_of(tables, (&Ray { tmin: hit.t, ..*ray }, ray), Some(hit.triangle), stack)
}

/// [`closest`], also at `ray.tmin` itself among the ids above `behind`; `whole` is the ray as it came.
#[inline(always)]
fn closest_of(tables: Tables, (ray, whole): (&Ray, &Ray), behind: Option<u32>, stack: &mut Stack) -> Hit {
    let mut best = Hit::none(ray.tmax);
    if !ray.is_finite() {
        return best;
    }
    let boxes = OneRayBoxes::new(ray.origin, ray.direction, ray.tmin, tables.extent);
    let search = Search { ray, whole, triangles: OneRay::new(ray.origin, ray.direction), tables, behind };
    let (words, near) = (&mut stack.words[..], &mut stack.near[..]);
    let mut best_wide = best.t * WIDENING;
    let mut top = 0;
    let mut next = 0;
    loop {
        if is_leaf(next) {
            if search.closest_in_block(next, &mut best) {
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

/// Whether `ray` hits anything before its `tmax`, or at `tmax` itself a triangle of an id below `before`.
#[inline(always)]
pub(super) fn any(tables: Tables, ray: &Ray, before: u32, stack: &mut Stack) -> bool {
    any_where(tables, ray, before, stack, |_| true)
}

/// [`any`], of the triangles that `counts` says count.
#[inline(always)]
pub(super) fn any_where(
    tables: Tables,
    ray: &Ray,
    before: u32,
    stack: &mut Stack,
    counts: impl Fn(u32) -> bool,
) -> bool {
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
            let block = &tables.leaves[block_of(next)];
            let edges = triangles.edges(block);
            if holds_precise(next) || edges.inside.any() {
                let careful = holds_precise(next) || may_be_edge_on(&edges, tables, next, ray);
                let coarse = if careful { coarse(&edges, tables, next, ray) } else { Mask8::NONE };
                let common = common(&edges, coarse, tables, next);
                let mut blocked = false;
                if coarse.any() {
                    for_each_precise(ray, block, &edges, tables, coarse, |id, hit| {
                        let ends = hit.t < ray.tmax || (hit.t == ray.tmax && id < before);
                        blocked |= hit.t > ray.tmin && ends && counts(id);
                    });
                }
                let t = edges.t_scaled / edges.det;
                let ids = U32x8::from_array(block.ids);
                let ends = t.lt(tmax) | (t.eq(tmax) & ids.lt(U32x8::splat(before)));
                let mut hits = (common & t.gt(tmin) & ends).bits();
                while hits != 0 && !blocked {
                    blocked = counts(block.ids[hits.trailing_zeros() as usize & 7]);
                    hits &= hits - 1;
                }
                if blocked {
                    return true;
                }
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
