//! Sixteen rays at a time through a list of leaves; the twin is [`crate::simd::native::walks::walk_flat`], which says how and why.

use crate::bvh::flat::{Flat, Leaf, Triangle};
use crate::bvh::precise::PreciseRay;
use crate::bvh::ray::{ANY_ID, HitQueue, NO_HIT, RayQueue, WalkCounters};
use crate::bvh::rounding::WIDENING;
use crate::bvh::sixteen::LANES;
use crate::bvh::sixteen::best::{Best, Ends};
use crate::bvh::sixteen::boxes::{Boxes, negative};
use crate::bvh::sixteen::memory::{CORNERS, Memory, Row};
use crate::bvh::sixteen::rays::Rays;
use crate::bvh::sixteen::registers::{gather, load, load_eight, store, to_integers, to_row};
use crate::bvh::sixteen::triangle::{Decided, Edges, Triangles, decided, edges, ones, sheared};
use std::arch::x86_64::*;
use std::ops::Range;

/// Sixteen rays on their way through a list.
struct Search<'a> {
    rays: &'a Rays,
    list: &'a Flat,
    extent: f32,
    boxes: &'a Boxes,
    triangles: &'a Triangles,
    /// Which coordinates of a corner are each ray's `[kx, ky, kz]`.
    axes: [__m512i; 3],
    /// Which bounds of a leaf are each ray's near sides, which its far sides.
    near_side: [__m512i; 3],
    far_side: [__m512i; 3],
    /// Of the rays, for [`crate::simd::native::walks::triangle::least_det`].
    reach: __m512,
}

impl<'a> Search<'a> {
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn new((list, extent): (&'a Flat, f32), rays: &'a Rays, boxes: &'a Boxes, triangles: &'a Triangles) -> Self {
        let [is_x, is_y, _] = triangles.lanes_by_axis;
        let index = |x: i32, y: i32, z: i32| {
            let y_or_z = _mm512_mask_mov_epi32(_mm512_set1_epi32(z), is_y, _mm512_set1_epi32(y));
            _mm512_mask_mov_epi32(y_or_z, is_x, _mm512_set1_epi32(x))
        };
        let [mut near_side, mut far_side] = [[_mm512_setzero_si512(); 3]; 2];
        for k in 0..3 {
            let (low, high) = (_mm512_set1_epi32(2 * k as i32), _mm512_set1_epi32(2 * k as i32 + 1));
            let negative = negative(boxes.inverse[k]);
            near_side[k] = _mm512_mask_mov_epi32(low, negative, high);
            far_side[k] = _mm512_mask_mov_epi32(high, negative, low);
        }
        Self {
            rays,
            list,
            extent,
            boxes,
            triangles,
            axes: [index(1, 2, 0), index(2, 0, 1), index(0, 1, 2)],
            near_side,
            far_side,
            reach: rays.reach(extent),
        }
    }

    /// Which of the rays `lanes` hit the box of a leaf before `best_wide`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn enter(&self, leaf: &Leaf, lanes: u16, best_wide: __m512) -> u16 {
        let bounds = load_eight(&leaf.bounds);
        let side = |of: &[__m512i; 3], k: usize| _mm512_permutexvar_ps(of[k], bounds);
        let near = [side(&self.near_side, 0), side(&self.near_side, 1), side(&self.near_side, 2)];
        let far = [side(&self.far_side, 0), side(&self.far_side, 1), side(&self.far_side, 2)];
        self.boxes.test_sides(near, far, lanes, best_wide).1
    }

    /// Shears the corners of a leaf.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn shear_corners(&self, leaf: &Leaf, sheared_corners: &mut [[Row; 3]; CORNERS]) {
        let corners = &self.list.corners[leaf.corners.start as usize..leaf.corners.end as usize];
        for (to, corner) in sheared_corners.iter_mut().zip(corners) {
            let corner = load_eight(corner);
            let at = |k: usize| {
                _mm512_add_ps(_mm512_permutexvar_ps(self.axes[k], corner), self.triangles.minus_own_origin[k])
            };
            let [x, y, z] = sheared([at(0), at(1), at(2)], &self.triangles.shear);
            store(&mut to[0], x);
            store(&mut to[1], y);
            store(&mut to[2], z);
        }
    }

    /// The rays `lanes` on a triangle of a leaf, every one of which is asked whether it is seen edge-on.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn decided(&self, leaf: &Leaf, triangle: &Triangle, edges: &Edges, lanes: u16) -> Decided {
        decided(self.rays, self.extent, (triangle.vertices(self.list, leaf), 0), edges, lanes)
    }

    /// The closest hits, every one of which is asked whether it is seen edge-on.
    #[cold]
    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn closest_carefully(&self, corners: &mut [[Row; 3]; CORNERS]) -> Best {
        let mut best = Best::none(self.rays.tmax);
        for leaf in &self.list.leaves {
            let live = self.enter(leaf, self.rays.active, _mm512_mul_ps(best.t, _mm512_set1_ps(WIDENING)));
            if live != 0 {
                self.shear_corners(leaf, corners);
                for triangle in leaf.triangles(self.list) {
                    let edges = edges_of(triangle, corners);
                    best.update_decided(&self.decided(leaf, triangle, &edges, live), triangle.id, self.rays.tmin);
                }
            }
        }
        best
    }

    /// Which of the rays `live` are blocked by a leaf whose triangles some may see edge-on.
    #[cold]
    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn blocked_carefully(&self, leaf: &Leaf, corners: &[[Row; 3]; CORNERS], live: u16) -> u16 {
        let Rays { tmin, tmax, .. } = *self.rays;
        let ends = Ends { tmin, tmax, before: _mm512_set1_epi32(ANY_ID as i32) };
        leaf.triangles(self.list).iter().fold(0, |blocked, triangle| {
            let hits = self.decided(leaf, triangle, &edges_of(triangle, corners), live);
            blocked | ends.blocked(hits.hit, hits.t, _mm512_set1_epi32(triangle.id as i32))
        })
    }

    /// Whether the hits of all `lanes` are as they are if they are seen edge-on.
    #[cold]
    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn stand(&self, best: &Best, lanes: u16) -> bool {
        let (t, triangle, tmin) = (to_row(best.t).0, to_integers(best.triangle), to_row(self.rays.tmin).0);
        let [ox, oy, oz] = [0, 1, 2].map(|k| to_row(self.rays.origin[k]).0);
        let [dx, dy, dz] = [0, 1, 2].map(|k| to_row(self.rays.direction[k]).0);
        ones(lanes).all(|i| {
            let ray = PreciseRay::new([ox[i], oy[i], oz[i]], [dx[i], dy[i], dz[i]]);
            let vertices = self.list.vertices(triangle[i]);
            vertices.and_then(|vertices| ray.edge_on(vertices, t[i], tmin[i])) == Some(t[i])
        })
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn closest(&self, corners: &mut [[Row; 3]; CORNERS]) -> (Best, u64) {
        let mut best = Best::none(self.rays.tmax);
        let mut used = 0;
        for leaf in &self.list.leaves {
            let live = self.enter(leaf, self.rays.active, _mm512_mul_ps(best.t, _mm512_set1_ps(WIDENING)));
            if live != 0 {
                used += u64::from(live.count_ones());
                self.shear_corners(leaf, corners);
                for triangle in leaf.triangles(self.list) {
                    best.update_descending(&edges_of(triangle, corners), triangle.id, live, self.rays.tmin);
                }
            }
        }
        // Of the closest hit alone it is asked whether it is seen edge-on, for the twin's reasons.
        let hit = _mm512_cmpneq_epi32_mask(best.triangle, _mm512_set1_epi32(NO_HIT as i32)) & self.rays.active;
        let least_det = _mm512_mul_ps(gather(&self.list.least_det, hit, best.triangle), self.reach);
        let edge_on = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(hit, _mm512_abs_ps(best.det), least_det);
        if edge_on != 0 && !self.stand(&best, edge_on) {
            best = self.closest_carefully(corners);
        }
        (best, used)
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn any(&self, corners: &mut [[Row; 3]; CORNERS], counters: &mut WalkCounters) -> u16 {
        let Rays { tmin, tmax, active, .. } = *self.rays;
        let best_wide = _mm512_mul_ps(tmax, _mm512_set1_ps(WIDENING));
        let mut open = active;
        for leaf in &self.list.leaves {
            let live = self.enter(leaf, open, best_wide);
            counters.lanes_possible += LANES as u64;
            if live != 0 {
                counters.lanes_used += u64::from(live.count_ones());
                self.shear_corners(leaf, corners);
                let (mut blocked, mut edge_on) = (0, 0);
                let least_det = _mm512_mul_ps(self.reach, _mm512_set1_ps(leaf.least_det));
                for triangle in leaf.triangles(self.list) {
                    let edges = edges_of(triangle, corners);
                    let t = edges.t();
                    let behind = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(edges.inside & live, t, tmin);
                    let hit = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(behind, t, tmax);
                    blocked |= hit;
                    edge_on |= edges.may_be_edge_on(hit, least_det);
                }
                if edge_on != 0 {
                    blocked = self.blocked_carefully(leaf, corners, live);
                }
                open &= !blocked;
                if open == 0 {
                    break;
                }
            }
        }
        active & !open
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
fn edges_of(triangle: &Triangle, corners: &[[Row; 3]; CORNERS]) -> Edges {
    let corner = |number: u8| {
        let [x, y, z] = &corners[number as usize % CORNERS];
        [load(x), load(y), load(z)]
    };
    let [a, b, c] = triangle.corners;
    edges([corner(a), corner(b), corner(c)])
}

/// Closest hits of rays `rows` of a queue.
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn closest(
    list: (&Flat, f32),
    (queue, rows): (&RayQueue, Range<usize>),
    hits: &mut HitQueue,
    memory: &mut Memory,
    counters: &mut WalkCounters,
) {
    for first in rows.clone().step_by(LANES) {
        let count = (rows.end - first).min(LANES);
        let rays = Rays::of(queue, first, count);
        let mut best = Best::none(rays.given);
        if rays.active != 0 {
            let used;
            let (boxes, triangles) = (Boxes::new(&rays, list.1), Triangles::new(&rays));
            (best, used) = Search::new(list, &rays, &boxes, &triangles).closest(&mut memory.corners);
            counters.lanes_used += used;
            counters.lanes_possible += (LANES * list.0.leaves.len()) as u64;
        }
        best.store(&rays, hits, first, count);
    }
}

/// Which of the rays `rows` of a queue hit anything, see [`crate::bvh::sixteen::Sixteen::any_in_list`].
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn any(
    list: (&Flat, f32),
    (queue, rows): (&RayQueue, Range<usize>),
    blocked: &mut [u8],
    memory: &mut Memory,
    counters: &mut WalkCounters,
) {
    for first in rows.clone().step_by(LANES) {
        let count = (rows.end - first).min(LANES);
        let rays = Rays::of(queue, first, count);
        let bits = match rays.active {
            0 => 0,
            _ => {
                let (boxes, triangles) = (Boxes::new(&rays, list.1), Triangles::new(&rays));
                Search::new(list, &rays, &boxes, &triangles).any(&mut memory.corners, counters)
            }
        };
        let bytes = &mut blocked[first / 8..(first + count).div_ceil(8)];
        bytes.copy_from_slice(&bits.to_le_bytes()[..bytes.len()]);
    }
}
