//! The triangle test of [`crate::simd::native::walks::triangle`] in sixteen lanes: of sixteen rays and one triangle, or of two
//! rays and eight.

use crate::bvh::node::LeafBlock;
use crate::bvh::precise::{PRECISE, PreciseRay};
use crate::bvh::ray::PERMUTATION;
use crate::bvh::rounding::{EDGE_ON, most_moved};
use crate::bvh::sixteen::memory::Row;
use crate::bvh::sixteen::rays::{Rays, negated};
use crate::bvh::sixteen::registers::{load, load_two, to_row};
use std::arch::x86_64::*;

/// What the test knows of a ray and a triangle before it divides.
#[derive(Clone, Copy)]
pub(super) struct Edges {
    pub(super) v: __m512,
    pub(super) w: __m512,
    pub(super) det: __m512,
    pub(super) t_scaled: __m512,
    pub(super) inside: u16,
    u: __m512,
    corners: [[__m512; 3]; 3],
}

/// A corner, relative to the origin and as `[kx, ky, kz]`, in the ray's sheared space.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn sheared([x, y, z]: [__m512; 3], shear: &[__m512; 3]) -> [__m512; 3] {
    [
        _mm512_sub_ps(x, _mm512_mul_ps(shear[0], z)),
        _mm512_sub_ps(y, _mm512_mul_ps(shear[1], z)),
        _mm512_mul_ps(shear[2], z),
    ]
}

/// `a b - c d`, rounded three times.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
fn cross(a: __m512, b: __m512, c: __m512, d: __m512) -> __m512 {
    _mm512_sub_ps(_mm512_mul_ps(a, b), _mm512_mul_ps(c, d))
}

/// The one sequence of operations behind all forms, from sheared corners on.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn edges([a, b, c]: [[__m512; 3]; 3]) -> Edges {
    let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (a, b, c);
    let u = cross(cx, by, cy, bx);
    let v = cross(ax, cy, ay, cx);
    let w = cross(bx, ay, by, ax);
    let det = _mm512_add_ps(_mm512_add_ps(u, v), w);
    let t_scaled = _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(u, az), _mm512_mul_ps(v, bz)), _mm512_mul_ps(w, cz));
    let zero = _mm512_setzero_ps();
    let least = _mm512_min_ps(_mm512_min_ps(u, v), w);
    let most = _mm512_max_ps(_mm512_max_ps(u, v), w);
    let inside = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(least, zero) | _mm512_cmp_ps_mask::<_CMP_LE_OQ>(most, zero);
    Edges { v, w, det, t_scaled, inside, u, corners: [a, b, c] }
}

impl Edges {
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn t(&self) -> __m512 {
        _mm512_div_ps(self.t_scaled, self.det)
    }

    /// Lanes of `lanes` that may see the triangle edge-on, `least_det` being that of the triangle times what the ray reaches.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn may_be_edge_on(&self, lanes: u16, least_det: __m512) -> u16 {
        _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(lanes, _mm512_abs_ps(self.det), least_det)
    }

    /// [`crate::simd::native::walks::triangle::Edges::edge_on`].
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn edge_on(&self) -> u16 {
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = self.corners;
        let larger = |a, b| _mm512_max_ps(_mm512_abs_ps(a), _mm512_abs_ps(b));
        let size = _mm512_max_ps(_mm512_max_ps(larger(ax, ay), larger(bx, by)), larger(cx, cy));
        let least = _mm512_mul_ps(_mm512_set1_ps(EDGE_ON), _mm512_mul_ps(size, size));
        _mm512_cmp_ps_mask::<_CMP_LT_OQ>(_mm512_abs_ps(self.det), least)
    }

    /// [`crate::simd::native::walks::triangle::Edges::near`].
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn near(&self, moved: __m512) -> u16 {
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = self.corners;
        let both = |a, b| _mm512_add_ps(_mm512_abs_ps(a), _mm512_abs_ps(b));
        let sum = _mm512_add_ps(_mm512_add_ps(both(ax, ay), both(bx, by)), both(cx, cy));
        let least = _mm512_min_ps(_mm512_min_ps(self.u, self.v), self.w);
        let most = _mm512_max_ps(_mm512_max_ps(self.u, self.v), self.w);
        let outside = _mm512_max_ps(least, negated(most));
        // What overflowed to NaN is near.
        _mm512_cmp_ps_mask::<_CMP_NLT_UQ>(outside, negated(_mm512_mul_ps(moved, sum)))
    }
}

/// Sixteen rays, ready for triangles.
pub(super) struct Triangles {
    /// Minus the origins. Adding them is subtracting the origins, bit for bit, and lets a coordinate in memory be an operand.
    minus_origin: [__m512; 3],
    /// By `[kx, ky, kz]` of each lane.
    pub(super) minus_own_origin: [__m512; 3],
    pub(super) shear: [__m512; 3],
    /// Lanes of each dominant axis.
    pub(super) lanes_by_axis: [u16; 3],
}

impl Triangles {
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn new(rays: &Rays) -> Self {
        let [x, y, z] = rays.direction;
        let (size_x, size_y, size_z) = (_mm512_abs_ps(x), _mm512_abs_ps(y), _mm512_abs_ps(z));
        let greater = |a, b| _mm512_cmp_ps_mask::<_CMP_GE_OQ>(a, b);
        let is_x = greater(size_x, size_y) & greater(size_x, size_z);
        let is_y = greater(size_y, size_z) & !is_x;
        let pick = |x, y, z| _mm512_mask_mov_ps(_mm512_mask_mov_ps(z, is_y, y), is_x, x);
        let dz = pick(x, y, z);
        let [ox, oy, oz] = rays.origin;
        let [ox, oy, oz] = [negated(ox), negated(oy), negated(oz)];
        Self {
            minus_origin: [ox, oy, oz],
            minus_own_origin: [pick(oy, oz, ox), pick(oz, ox, oy), pick(ox, oy, oz)],
            shear: [
                _mm512_div_ps(pick(y, z, x), dz),
                _mm512_div_ps(pick(z, x, y), dz),
                _mm512_div_ps(_mm512_set1_ps(1.0), dz),
            ],
            lanes_by_axis: [is_x, is_y, !(is_x | is_y)],
        }
    }

    /// Against triangle `triangle` of a block, as if `KZ` were every ray's dominant axis: right in the lanes where it is.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn edges<const KZ: usize>(&self, block: &LeafBlock, triangle: usize) -> Edges {
        let axes = PERMUTATION[KZ];
        let corner = |vertex: usize| {
            let at = |k: usize| {
                let coordinate = _mm512_set1_ps(block.vertices[vertex][axes[k]][triangle & 7]);
                _mm512_add_ps(coordinate, self.minus_origin[axes[k]])
            };
            sheared([at(0), at(1), at(2)], &self.shear)
        };
        edges([corner(0), corner(1), corner(2)])
    }

    /// The dominant axis of a lane.
    #[inline(always)]
    fn axis(&self, lane: usize) -> usize {
        let [is_x, is_y, _] = self.lanes_by_axis.map(|lanes| usize::from(lanes >> lane & 1));
        2 - 2 * is_x - is_y
    }

    /// The rays of two lanes against the eight triangles of a block each. `from` names, lane by lane, which of the two is meant.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn edges_of_two(&self, block: &LeafBlock, lanes: [usize; 2], from: __m512i) -> Edges {
        let [low, high] = lanes.map(|lane| PERMUTATION[self.axis(lane) % 3]);
        let own = |values: &[__m512; 3], k: usize| _mm512_permutexvar_ps(from, values[k]);
        let shear = [own(&self.shear, 0), own(&self.shear, 1), own(&self.shear, 2)];
        let corner = |vertex: usize| {
            let at = |k: usize| {
                let coordinates = load_two(&block.vertices[vertex][low[k]], &block.vertices[vertex][high[k]]);
                _mm512_add_ps(coordinates, own(&self.minus_own_origin, k))
            };
            sheared([at(0), at(1), at(2)], &shear)
        };
        edges([corner(0), corner(1), corner(2)])
    }
}

/// What is known of rays and a triangle when f64 has had its say: who hits it, at any `t`, and what a closest hit keeps of that.
pub(super) struct Decided {
    pub(super) hit: u16,
    pub(super) t: __m512,
    pub(super) v: __m512,
    pub(super) w: __m512,
    pub(super) det: __m512,
}

/// What the rays of `lanes` hit of a triangle of class `class`, of which they know `edges`: in f64 if it is precise, and where it
/// is seen edge-on. For lanes that it is hit by in f32, `t` is that of the twins of eight lanes, operation by operation.
#[cold]
#[inline(never)]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn decided(
    rays: &Rays,
    extent: f32,
    (vertices, class): ([[f32; 3]; 3], u8),
    edges: &Edges,
    lanes: u16,
) -> Decided {
    let [ox, oy, oz] = [to_row(rays.origin[0]).0, to_row(rays.origin[1]).0, to_row(rays.origin[2]).0];
    let [dx, dy, dz] = [to_row(rays.direction[0]).0, to_row(rays.direction[1]).0, to_row(rays.direction[2]).0];
    let ray = |i: usize| PreciseRay::new([ox[i], oy[i], oz[i]], [dx[i], dy[i], dz[i]]);
    let [mut t, mut v, mut w, mut det] = [to_row(edges.t()), to_row(edges.v), to_row(edges.w), to_row(edges.det)];
    let mut hit = 0;
    if class & PRECISE != 0 {
        let moved = Row(std::array::from_fn(|i| most_moved([ox[i], oy[i], oz[i]], extent)));
        for lane in ones(lanes & edges.near(load(&moved))) {
            if let Some(found) = ray(lane).hit(vertices, class) {
                hit |= 1 << lane;
                (t.0[lane], v.0[lane], w.0[lane], det.0[lane]) = (found.t, found.u, found.v, 1.0);
            }
        }
    } else {
        let (inside, tmin) = (lanes & edges.inside, to_row(rays.tmin).0);
        let edge_on = inside & edges.edge_on();
        hit = inside & !edge_on;
        for lane in ones(edge_on) {
            if let Some(at) = ray(lane).edge_on(vertices, t.0[lane], tmin[lane]) {
                hit |= 1 << lane;
                t.0[lane] = at;
            }
        }
    }
    Decided { hit, t: load(&t), v: load(&v), w: load(&w), det: load(&det) }
}

/// The numbers of the bits that are set, from the lowest.
#[inline(always)]
pub(super) fn ones(mut bits: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize & 15;
        let left = bits != 0;
        bits &= bits.wrapping_sub(1);
        left.then_some(lane)
    })
}
