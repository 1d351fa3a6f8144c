//! The ray-triangle test: watertight (Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection"), in two forms
//! of the same operations: eight rays against one triangle, one ray against eight triangles.
//!
//! The test decides images, so it has no fused operation, and a scalar twin must perform exactly this, in f32:
//!
//! ```text
//! |d| = absolute values of the direction's components
//! kz = if |d|[0] >= |d|[1] and |d|[0] >= |d|[2] { 0 } else if |d|[1] >= |d|[2] { 1 } else { 2 }   (ties: lowest index)
//! kx = (kz + 1) % 3, ky = (kx + 1) % 3                                            (not swapped where d[kz] < 0)
//! Sx = d[kx] / d[kz], Sy = d[ky] / d[kz], Sz = 1 / d[kz]
//! A = v0 - o, B = v1 - o, C = v2 - o
//! Ax = A[kx] - Sx * A[kz], Ay = A[ky] - Sy * A[kz], Az = Sz * A[kz], and so for B and C
//! U = Cx * By - Cy * Bx, V = Ax * Cy - Ay * Cx, W = Bx * Ay - By * Ax
//! det = (U + V) + W
//! T = (U * Az + V * Bz) + W * Cz
//! t = T / det, u = V / det, v = W / det
//! hit: (U, V, W all >= 0, or all <= 0) and (det < 0 or det > 0) and t > tmin and t <= tmax
//! ```
//!
//! Every comparison is false for NaN. An edge function of 0 counts as inside: neighbours compute it from the same numbers,
//! so no ray passes between them. Of several hits the one of the smallest `t` counts, on equal `t` that of the lowest id.
//! The swap for negative `d[kz]` in the paper only negates U, V and W. Its second computation in f64 is not needed: none of
//! 2.7 M rays aimed at vertices and edges leaked without.
//!
//! Limit: for a ray that lies in a triangle's plane to the last bits of origin *and* direction, all three edge functions
//! are rounding noise; `t` is then only known to lie between the corners along the dominant axis. Such a "hit" beside the
//! triangle is taken or not as boxes around it let the ray in, so every walk tests a ray against the box of a leaf before
//! its triangles. Slivers widen "to the last bits" by their aspect; rays exactly in an axis-parallel plane are not
//! concerned: their determinant is 0.

use crate::bvh::node::LeafBlock;
use crate::bvh::ray::{HitPacket, NO_HIT};
use crate::lanes::{F32x8, Mask8, U32x8, Vec3x8};

/// What the test knows of a ray and a triangle before it divides.
#[derive(Clone, Copy)]
pub(super) struct Edges {
    pub(super) v: F32x8,
    pub(super) w: F32x8,
    pub(super) det: F32x8,
    pub(super) t_scaled: F32x8,
    pub(super) inside: Mask8,
}

/// A corner, relative to the origin and as `[kx, ky, kz]`, in the ray's sheared space.
#[inline(always)]
pub(super) fn sheared(corner: [F32x8; 3], shear: [F32x8; 3]) -> [F32x8; 3] {
    let [x, y, z] = corner;
    [x - shear[0] * z, y - shear[1] * z, shear[2] * z]
}

/// The one sequence of operations behind all forms, from sheared corners on.
#[inline(always)]
pub(super) fn edges([a, b, c]: [[F32x8; 3]; 3]) -> Edges {
    let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (a, b, c);
    let u = cx * by - cy * bx;
    let v = ax * cy - ay * cx;
    let w = bx * ay - by * ax;
    let det = (u + v) + w;
    let t_scaled = (u * az + v * bz) + w * cz;
    // det is not compared with 0: edges of one sign that add up to 0 are all 0, so t is 0 / 0 and fails every comparison.
    // So it does if an edge is NaN, whatever min and max make of that; +-0 is the same to the comparisons.
    let zero = F32x8::ZERO;
    let inside = u.min(v).min(w).ge(zero) | u.max(v).max(w).le(zero);
    Edges { v, w, det, t_scaled, inside }
}

/// The index of the largest of three magnitudes, the lowest on ties; 2 if they are NaN.
#[inline(always)]
pub(super) fn dominant_axis(x: f32, y: f32, z: f32) -> usize {
    let (x, y, z) = (x.abs(), y.abs(), z.abs());
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// [`dominant_axis`] of eight: where it is 0, where it is 1.
#[inline(always)]
pub(super) fn dominant_axis8(direction: Vec3x8) -> (Mask8, Mask8) {
    let Vec3x8 { x, y, z } = direction.abs();
    let is_x = x.ge(y) & x.ge(z);
    (is_x, y.ge(z).and_not(is_x))
}

/// `[kx, ky, kz]` by `kz`.
pub(super) const PERMUTATION: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// A single ray, ready for triangles: every lane the same.
#[derive(Clone, Copy)]
pub(super) struct OneRay {
    axes: [usize; 3],
    origin: [F32x8; 3],
    shear: [F32x8; 3],
}

impl OneRay {
    #[inline(always)]
    pub(super) fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let axes = PERMUTATION[dominant_axis(direction[0], direction[1], direction[2])];
        let d = axes.map(|axis| direction[axis]);
        Self {
            axes,
            origin: axes.map(|axis| F32x8::splat(origin[axis])),
            shear: [F32x8::splat(d[0] / d[2]), F32x8::splat(d[1] / d[2]), F32x8::splat(1.0 / d[2])],
        }
    }

    /// Against the eight triangles of a block.
    #[inline(always)]
    pub(super) fn edges(&self, block: &LeafBlock) -> Edges {
        let corner = |vertex: usize| -> [F32x8; 3] {
            std::array::from_fn(|k| F32x8::from_array(block.vertices[vertex][self.axes[k]]) - self.origin[k])
        };
        edges([sheared(corner(0), self.shear), sheared(corner(1), self.shear), sheared(corner(2), self.shear)])
    }
}

/// Eight rays, ready for triangles.
#[derive(Clone, Copy)]
pub(super) struct EightRays {
    origin: Vec3x8,
    /// By `[kx, ky, kz]` of each lane.
    shear: [F32x8; 3],
    /// Lanes of each dominant axis.
    pub(super) lanes_by_axis: [Mask8; 3],
}

impl EightRays {
    #[inline(always)]
    pub(super) fn new(origin: Vec3x8, direction: Vec3x8) -> Self {
        let Vec3x8 { x, y, z } = direction;
        let (is_x, is_y) = dominant_axis8(direction);
        let pick = |x: F32x8, y: F32x8, z: F32x8| is_x.select(x, is_y.select(y, z));
        let dz = pick(x, y, z);
        Self {
            origin,
            shear: [pick(y, z, x) / dz, pick(z, x, y) / dz, F32x8::ONE / dz],
            lanes_by_axis: [is_x, is_y, Mask8::ALL.and_not(is_x | is_y)],
        }
    }

    /// Against triangle `lane` of a block, as if `kz` were every ray's: right in the lanes where it is.
    #[inline(always)]
    pub(super) fn edges(&self, block: &LeafBlock, lane: usize, kz: usize) -> Edges {
        let axes = PERMUTATION[kz];
        let origin = [self.origin.x, self.origin.y, self.origin.z];
        let corner = |vertex: usize| -> [F32x8; 3] {
            std::array::from_fn(|k| F32x8::splat(block.vertices[vertex][axes[k]][lane]) - origin[axes[k]])
        };
        edges([sheared(corner(0), self.shear), sheared(corner(1), self.shear), sheared(corner(2), self.shear)])
    }
}

/// The closest hits of eight rays so far. Dividing `v` and `w` waits until the walk is over.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) t: F32x8,
    pub(super) triangle: U32x8,
    v: F32x8,
    w: F32x8,
    det: F32x8,
}

impl Best {
    /// Nothing hit up to `tmax`.
    #[inline(always)]
    pub(super) fn none(tmax: F32x8) -> Self {
        Self { t: tmax, triangle: U32x8::splat(NO_HIT), v: F32x8::ZERO, w: F32x8::ZERO, det: F32x8::ONE }
    }

    /// Takes the hits of triangle `id` among `live` that are closer, or as close and of a lower id.
    #[inline(always)]
    pub(super) fn update(&mut self, edges: &Edges, id: u32, live: Mask8, tmin: F32x8) {
        let t = edges.t_scaled / edges.det;
        let id = U32x8::splat(id);
        // Ids are below 2^31 but for NO_HIT, which as a signed number would be the lowest.
        let lower = id.lt(self.triangle);
        let closer = t.lt(self.t) | (t.eq(self.t) & lower);
        let take = edges.inside & live & t.gt(tmin) & closer;
        self.take(take, t, id, edges);
    }

    /// [`Best::update`] for a triangle whose id is lower than those of all before it: on equal `t` it is the one.
    #[inline(always)]
    pub(super) fn update_descending(&mut self, edges: &Edges, id: u32, live: Mask8, tmin: F32x8) {
        let t = edges.t_scaled / edges.det;
        let take = (edges.inside & live) & (t.gt(tmin) & t.le(self.t));
        self.take(take, t, U32x8::splat(id), edges);
    }

    #[inline(always)]
    fn take(&mut self, take: Mask8, t: F32x8, id: U32x8, edges: &Edges) {
        self.t = take.select(t, self.t);
        self.triangle = take.select_u32(id, self.triangle);
        self.v = take.select(edges.v, self.v);
        self.w = take.select(edges.w, self.w);
        self.det = take.select(edges.det, self.det);
    }

    /// The finished hits; `u` and `v` are 0 where nothing is hit.
    #[inline(always)]
    pub(super) fn hits(&self) -> HitPacket {
        HitPacket { t: self.t, triangle: self.triangle, u: self.v / self.det, v: self.w / self.det }
    }
}
