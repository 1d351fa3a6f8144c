//! Many single rays in flight: each visits one node or leaf in turn, and the next one is prefetched as soon as it is known.
//!
//! Rays after a bounce part at once, so packets run nearly empty, and one ray at a time waits: for memory on big trees, for
//! its own arithmetic on small ones. Here the visits of 32 rays overlap. Slots wait in three lists, by what comes next: a
//! node, a leaf, nothing; a step takes a slot from one list and appends it to another without a branch. The ground of every
//! stack is a sentinel that is never culled, so popping does not ask whether there is anything left.

use super::here;
use crate::bvh::node::{LEAF_BIT, LeafBlock, Node, Tables, block_of, holds_precise};
use crate::bvh::prefetch::prefetch;
use crate::bvh::ray::{NO_HIT, PERMUTATION, Ray};
use crate::bvh::rounding::most_moved;
use crate::bvh::rounding::{ROUNDING, WIDENING};
use here::lanes::{F32x8, LANES, Mask8, U32x8};
use here::walks::boxes::safe_inverse8;
use here::walks::packets::{HitPacket, RayPacket};
use here::walks::sort::sort_children;
use here::walks::triangle::{Edges, dominant_axis8, edges, reach, sheared};
use here::walks::walk_single::for_each_precise;

/// Rays in flight: 16 to 32 measured alike, 8 and 64 lose.
const SLOTS: usize = 32;
/// Rays made ready at a time.
pub(super) const CHUNK: usize = 512;
/// A column is a line longer, lest one row of all columns fall into the same few sets of the first cache.
const COLUMN: usize = CHUNK + 16;
/// The word on the ground of a stack: neither node nor leaf.
const DONE: u32 = u32::MAX;

macro_rules! ray_columns {
    ($($(#[$doc:meta])* $field:ident: $type:ty,)*) => {
        /// Rays made ready for boxes and triangles, and their closest hits so far, one array a field.
        #[derive(Clone, Debug)]
        struct Rays { $($(#[$doc])* $field: [$type; COLUMN],)* }
        impl Default for Rays {
            fn default() -> Self {
                Self { $($field: [<$type>::default(); COLUMN],)* }
            }
        }
    };
}
ray_columns! {
    inverse_x: f32, inverse_y: f32, inverse_z: f32,
    near_offset_x: f32, near_offset_y: f32, near_offset_z: f32,
    far_offset_x: f32, far_offset_y: f32, far_offset_z: f32,
    /// Origins by `[kx, ky, kz]`.
    origin_x: f32, origin_y: f32, origin_z: f32,
    shear_x: f32, shear_y: f32, shear_z: f32,
    tmin: f32,
    kz: u32,
    /// Closest hit so far, its triangle and what is to be divided for it. For any hit `v` has the bits of an id: at the end of the
    /// ray only triangles of lower ones count.
    t: f32,
    triangle: u32,
    v: f32,
    w: f32,
    det: f32,
}

/// Nodes and leaves still to be visited, and rays.
#[derive(Clone, Debug, Default)]
pub(super) struct Stream {
    rays: Box<Rays>,
    words: Vec<u32>,
    near: Vec<u32>,
    stride: usize,
}

/// What the slots hold.
struct Slots {
    ray: [u32; SLOTS],
    top: [u32; SLOTS],
    next: [u32; SLOTS],
}

/// Slots that wait for the same kind of step.
struct List {
    slots: [u32; SLOTS],
    len: usize,
}

impl List {
    const EMPTY: Self = Self { slots: [0; SLOTS], len: 0 };
    #[inline(always)]
    fn push_if(&mut self, condition: bool, slot: usize) {
        self.slots[self.len % SLOTS] = slot as u32;
        self.len += condition as usize;
    }
}

impl Stream {
    /// Room for stacks of `entries`.
    pub(super) fn reserve(&mut self, entries: usize) {
        let stride = (entries + 1 + LANES).next_multiple_of(LANES);
        if self.stride < stride {
            self.stride = stride;
            self.words.resize(SLOTS * stride, 0);
            self.near.resize(SLOTS * stride, 0);
        }
    }

    /// Makes eight rays ready as rows `first ..` of the chunk; `before`: for any hit, see [`Rays`].
    #[inline(always)]
    pub(super) fn set_packet(&mut self, first: usize, packet: &RayPacket, before: Option<U32x8>, extent: f32) {
        let rays = &mut *self.rays;
        let (o, d) = (packet.origin, packet.direction);
        let extent = F32x8::splat(extent);
        macro_rules! slab {
            ($axis:ident, $inverse:ident, $near:ident, $far:ident) => {
                let inverse = safe_inverse8(d.$axis);
                let widening = F32x8::splat(ROUNDING) * ((o.$axis.abs() + extent) * inverse.abs());
                inverse.store(&mut rays.$inverse, first);
                (o.$axis * inverse + widening).store(&mut rays.$near, first);
                (o.$axis * inverse - widening).store(&mut rays.$far, first);
            };
        }
        slab!(x, inverse_x, near_offset_x, far_offset_x);
        slab!(y, inverse_y, near_offset_y, far_offset_y);
        slab!(z, inverse_z, near_offset_z, far_offset_z);
        let (is_x, is_y) = dominant_axis8(d);
        let pick = |x: F32x8, y: F32x8, z: F32x8| is_x.select(x, is_y.select(y, z));
        let dz = pick(d.x, d.y, d.z);
        pick(o.y, o.z, o.x).store(&mut rays.origin_x, first);
        pick(o.z, o.x, o.y).store(&mut rays.origin_y, first);
        pick(o.x, o.y, o.z).store(&mut rays.origin_z, first);
        (pick(d.y, d.z, d.x) / dz).store(&mut rays.shear_x, first);
        (pick(d.z, d.x, d.y) / dz).store(&mut rays.shear_y, first);
        (F32x8::ONE / dz).store(&mut rays.shear_z, first);
        // Beyond infinity nothing is hit, and no box entered.
        packet.finite().select(packet.tmin, F32x8::splat(f32::INFINITY)).store(&mut rays.tmin, first);
        let kz = is_x.select_u32(U32x8::ZERO, is_y.select_u32(U32x8::splat(1), U32x8::splat(2)));
        kz.store(&mut rays.kz, first);
        packet.tmax.store(&mut rays.t, first);
        U32x8::splat(NO_HIT).store(&mut rays.triangle, first);
        let v = before.map_or(F32x8::ZERO, F32x8::from_bits);
        v.store(&mut rays.v, first);
        F32x8::ZERO.store(&mut rays.w, first);
        F32x8::ONE.store(&mut rays.det, first);
    }

    /// The closest hits of rows `first .. first + 8`.
    #[inline(always)]
    pub(super) fn hits(&self, first: usize) -> HitPacket {
        let rays = &*self.rays;
        let det = F32x8::load(&rays.det, first);
        HitPacket {
            t: F32x8::load(&rays.t, first),
            triangle: U32x8::load(&rays.triangle, first),
            u: F32x8::load(&rays.v, first) / det,
            v: F32x8::load(&rays.w, first) / det,
        }
    }

    /// Which of rows `first .. first + 8` hit anything, after a walk for any hit.
    #[inline(always)]
    pub(super) fn blocked(&self, first: usize) -> u8 {
        (!U32x8::load(&self.rays.triangle, first).eq(U32x8::splat(NO_HIT))).bits()
    }

    /// Walks rows `0 .. count`, to the closest hit or, if `ANY`, to the first that is found.
    #[inline(never)]
    pub(super) fn walk<const ANY: bool>(&mut self, tables: Tables, count: usize, given: impl Fn(usize) -> Ray) {
        here::run(
            #[inline(always)]
            || {
                let Self { rays, words, near, stride } = self;
                let stride = *stride;
                let mut slots = Slots { ray: [0; SLOTS], top: [1; SLOTS], next: [0; SLOTS] };
                let (mut nodes, mut leaves, mut done) = (List::EMPTY, List::EMPTY, List::EMPTY);
                for slot in 0..SLOTS {
                    words[slot * stride] = DONE;
                    near[slot * stride] = f32::NEG_INFINITY.to_bits();
                    done.push_if(true, slot);
                }
                let mut fresh = 0;
                loop {
                    // Finished slots take the next rays.
                    for i in 0..done.len {
                        if fresh == count {
                            break;
                        }
                        let slot = done.slots[i] as usize % SLOTS;
                        (slots.ray[slot], slots.top[slot], slots.next[slot]) = (fresh as u32, 1, 0);
                        fresh += 1;
                        nodes.push_if(true, slot);
                    }
                    done.len = 0;
                    if nodes.len + leaves.len == 0 {
                        return;
                    }
                    let (mut next_nodes, mut next_leaves) = (List::EMPTY, List::EMPTY);
                    macro_rules! pop {
                        ($slot:expr, $top:expr, $best_wide:expr) => {{
                            let at = $slot * stride;
                            let mut top = $top - 1;
                            if !ANY {
                                while f32::from_bits(near[at + top]) > $best_wide {
                                    top -= 1;
                                }
                            }
                            let word = words[at + top];
                            slots.top[$slot] = top as u32;
                            slots.next[$slot] = word;
                            let is_done = word == DONE;
                            let is_leaf = word & LEAF_BIT != 0;
                            done.push_if(is_done, $slot);
                            next_leaves.push_if(is_leaf & !is_done, $slot);
                            next_nodes.push_if(!is_leaf, $slot);
                            if is_leaf {
                                if let Some(block) = tables.leaves.get(block_of(word)) {
                                    prefetch(block);
                                    prefetch(&tables.least_det[block_of(word)]);
                                }
                            } else {
                                prefetch(&tables.nodes[word as usize]);
                            }
                        }};
                    }
                    for i in 0..nodes.len {
                        let slot = nodes.slots[i] as usize % SLOTS;
                        let row = slots.ray[slot] as usize % CHUNK;
                        let node = &tables.nodes[slots.next[slot] as usize];
                        let best_wide = rays.t[row] * WIDENING;
                        let (entry, hit) = rays.test_boxes(row, node, best_wide);
                        let top = slots.top[slot] as usize;
                        let children = U32x8::from_array(node.children);
                        if ANY {
                            children.compress(hit.bits()).store(words, slot * stride + top);
                        } else {
                            let (order, distances) = sort_children(entry, hit);
                            children.permute(order).store(words, slot * stride + top);
                            distances.store(near, slot * stride + top);
                        }
                        pop!(slot, top + hit.count() as usize, best_wide);
                    }
                    for i in 0..leaves.len {
                        let slot = leaves.slots[i] as usize % SLOTS;
                        let row = slots.ray[slot] as usize % CHUNK;
                        let word = slots.next[slot];
                        let found = match rays.test_leaf::<ANY>(row, word, tables) {
                            Some(found) => found,
                            None => rays.test_leaf_carefully::<ANY>(row, word, tables, &given(row)),
                        };
                        // A blocked ray leaves its stack as it is but for the sentinel.
                        let top = if ANY & found { 1 } else { slots.top[slot] as usize };
                        pop!(slot, top, rays.t[row] * WIDENING);
                    }
                    (nodes, leaves) = (next_nodes, next_leaves);
                }
            },
        )
    }
}

impl Rays {
    /// As [`here::walks::boxes::OneRayBoxes::test`].
    #[inline(always)]
    fn test_boxes(&self, row: usize, node: &Node, best_wide: f32) -> (F32x8, Mask8) {
        let (mut entry, mut exit) = (F32x8::splat(crate::math::max(self.tmin[row], 0.0)), F32x8::splat(best_wide));
        macro_rules! slab {
            ($axis:expr, $inverse:ident, $near:ident, $far:ident) => {
                let side = (self.$inverse[row].to_bits() >> 31) as usize;
                let inverse = F32x8::splat(self.$inverse[row]);
                let (low, high) = (node.bounds[$axis][side & 1], node.bounds[$axis][!side & 1]);
                let near = F32x8::from_array(low).loose_mul_sub(inverse, F32x8::splat(self.$near[row]));
                let far = F32x8::from_array(high).loose_mul_sub(inverse, F32x8::splat(self.$far[row]));
                entry = near.max(entry);
                exit = (far * F32x8::splat(WIDENING)).min(exit);
            };
        }
        slab!(0, inverse_x, near_offset_x, far_offset_x);
        slab!(1, inverse_y, near_offset_y, far_offset_y);
        slab!(2, inverse_z, near_offset_z, far_offset_z);
        (entry, entry.le(exit))
    }

    /// Of the triangles of a block.
    #[inline(always)]
    fn edges(&self, row: usize, block: &LeafBlock) -> Edges {
        let [kx, ky, kz] = PERMUTATION[self.kz[row] as usize % 3];
        let splat = F32x8::splat;
        let o = [splat(self.origin_x[row]), splat(self.origin_y[row]), splat(self.origin_z[row])];
        let corner = |vertex: usize| {
            let v = &block.vertices[vertex];
            [F32x8::from_array(v[kx]) - o[0], F32x8::from_array(v[ky]) - o[1], F32x8::from_array(v[kz]) - o[2]]
        };
        let shear = [splat(self.shear_x[row]), splat(self.shear_y[row]), splat(self.shear_z[row])];
        edges([sheared(corner(0), shear), sheared(corner(1), shear), sheared(corner(2), shear)])
    }

    /// Takes the closest hit in the block of leaf `word` if it is closer, or as close and of a lower id; whether anything is
    /// hit. `None` if triangles are precise or may be seen edge-on.
    #[inline(always)]
    fn test_leaf<const ANY: bool>(&mut self, row: usize, word: u32, tables: Tables) -> Option<bool> {
        let leaf = block_of(word);
        if holds_precise(word) {
            return None;
        }
        let block = &tables.leaves[leaf];
        let edges = self.edges(row, block);
        if !edges.inside.any() {
            return Some(false);
        }
        let t = edges.t_scaled / edges.det;
        let in_range = edges.inside & t.gt(F32x8::splat(self.tmin[row])) & t.le(F32x8::splat(self.t[row]));
        if !in_range.any() {
            return Some(false);
        }
        let origin = [self.origin_x[row], self.origin_y[row], self.origin_z[row]];
        let least_det = F32x8::splat(reach(origin, tables.extent) * tables.least_det[leaf]);
        if (in_range & edges.det.abs().lt(least_det)).any() {
            return None;
        }
        Some(self.take::<ANY>(row, block, &edges, in_range))
    }

    /// [`Rays::test_leaf`] where triangles are precise or may be seen edge-on. (All is worked out anew: what is kept for the sake
    /// of a path hardly ever taken would cost the other one its registers.)
    #[cold]
    #[inline(never)]
    fn test_leaf_carefully<const ANY: bool>(&mut self, row: usize, word: u32, tables: Tables, given: &Ray) -> bool {
        here::run(
            #[inline(always)]
            || {
                let block = &tables.leaves[block_of(word)];
                let edges = self.edges(row, block);
                let precise = Mask8::from_bits(tables.precise.get(block_of(word)).copied().unwrap_or(0));
                let near = edges.near(F32x8::splat(most_moved(given.origin, tables.extent)));
                let coarse = (edges.inside & edges.edge_on()).and_not(precise) | (precise & near);
                let found =
                    coarse.any() && self.test_precise::<ANY>(row, block_of(word), &edges, tables, coarse, given);
                self.take::<ANY>(row, block, &edges, edges.inside.and_not(coarse | precise)) | found
            },
        )
    }

    /// Takes the closest hit on the triangles `inside` of a block if it is closer, or as close and of a lower id.
    #[inline(always)]
    fn take<const ANY: bool>(&mut self, row: usize, block: &LeafBlock, edges: &Edges, inside: Mask8) -> bool {
        let t = edges.t_scaled / edges.det;
        let best = F32x8::splat(self.t[row]);
        let ends = if ANY {
            let lower = U32x8::from_array(block.ids).lt_signed(U32x8::splat(self.v[row].to_bits()));
            t.lt(best) | (t.eq(best) & lower)
        } else {
            t.le(best)
        };
        let hits = inside & t.gt(F32x8::splat(self.tmin[row])) & ends;
        let found = hits.any();
        if ANY {
            self.triangle[row] = if found { 0 } else { self.triangle[row] };
        } else if found {
            let nearest = hits.select(t, F32x8::splat(f32::INFINITY)).min_of_lanes();
            let lane = (hits & t.le(F32x8::splat(nearest))).bits().trailing_zeros() as usize & 7;
            let (id, t) = (block.ids[lane], t.to_array()[lane]);
            if t < self.t[row] || id < self.triangle[row] {
                (self.t[row], self.triangle[row]) = (t, id);
                self.v[row] = edges.v.to_array()[lane];
                self.w[row] = edges.w.to_array()[lane];
                self.det[row] = edges.det.to_array()[lane];
            }
        }
        found
    }

    /// The part of [`Rays::test_leaf_carefully`] that f64 has a say in, for the triangles `lanes` of a block.
    #[inline(always)]
    fn test_precise<const ANY: bool>(
        &mut self,
        row: usize,
        block: usize,
        edges: &Edges,
        tables: Tables,
        lanes: Mask8,
        given: &Ray,
    ) -> bool {
        let mut found = false;
        for_each_precise(given, &tables.leaves[block], edges, tables, lanes, |id, hit| {
            let (best, triangle) = (self.t[row], if ANY { self.v[row].to_bits() } else { self.triangle[row] });
            if hit.t > self.tmin[row] && (hit.t < best || (hit.t == best && id < triangle)) {
                found = true;
                if ANY {
                    self.triangle[row] = 0;
                } else {
                    (self.t[row], self.triangle[row]) = (hit.t, id);
                    (self.v[row], self.w[row], self.det[row]) = (hit.u, hit.v, 1.0);
                }
            }
        });
        found
    }
}
