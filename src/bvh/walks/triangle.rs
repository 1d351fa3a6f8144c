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
//! hit: (U, V, W all >= 0, or all <= 0) and (det < 0 or det > 0) and t > tmin and t <= tmax,
//!      and where |det| < 2^-6 m m, m the largest of |Ax|, |Ay|, |Bx|, |By|, |Cx|, |Cy|, if f64 says so, too
//! ```
//!
//! Every comparison is false for NaN. An edge function of 0 counts as inside: neighbours compute it from the same numbers,
//! so no ray passes between them. Of several hits the one of the smallest `t` counts, on equal `t` that of the lowest id.
//! The swap for negative `d[kz]` in the paper only negates U, V and W. Its second computation in f64 is not needed: none of
//! 2.7 M rays aimed at vertices and edges leaked without.
//!
//! Near an edge rounding may move the projected corners by a few half-ulps of their distances, for all triangles of a corner
//! alike. Seen nearly edge-on, it may do more: `t` then lies between those of the corners, but the ray may pass them by. So
//! where `det` is below 2^-6 of the largest squared |x| or |y| of the sheared corners, the ray counts as one seen edge-on, and
//! [`crate::bvh::precise`] decides. Above that, the point of the ray at `t` is next to the triangle (the identity
//! `U A + V B + W C = 0` holds up to the rounding of U, V and W), by less than boxes are widened in the test of a ray, so no
//! box is missed that holds a hit. (The bound for the worst rounding is a few times what boxes are widened by; boxes that are
//! larger by all of it, 2^-12 of their triangles, took 5 % longer, since every ray then enters the box it leaves.)

use super::here;
use crate::bvh::node::LeafBlock;
use crate::bvh::precise::{PreciseHit, PreciseRay};
use crate::bvh::ray::{NO_HIT, PERMUTATION, dominant_axis};
use crate::bvh::rounding::EDGE_ON;
use here::lanes::{Each, F32x8, Mask8, U32x8, Vec3x8};
use here::walks::packets::{HitPacket, RayPacket};

/// What the test knows of a ray and a triangle before it divides.
#[derive(Clone, Copy)]
pub(super) struct Edges {
    pub(super) v: F32x8,
    pub(super) w: F32x8,
    pub(super) det: F32x8,
    pub(super) t_scaled: F32x8,
    pub(super) inside: Mask8,
    u: F32x8,
    corners: [[F32x8; 3]; 3],
}

/// How far a ray reaches from `origin` in a scene that reaches to `extent`.
#[inline(always)]
pub(super) fn reach([x, y, z]: [f32; 3], extent: f32) -> f32 {
    let max = crate::math::max;
    max(max(x.abs(), y.abs()), max(z.abs(), extent))
}

/// [`reach`] of eight.
#[inline(always)]
pub(super) fn reach8(origin: Vec3x8, extent: f32) -> F32x8 {
    origin.abs().max_element().max(F32x8::splat(extent))
}

impl Edges {
    /// Rays that see the triangle so nearly edge-on that this test is too coarse; asked for where it is hit.
    #[inline(always)]
    pub(super) fn edge_on(&self) -> Mask8 {
        // Not `map`, which is a call here.
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = self.corners;
        let size = ax.abs().max(ay.abs()).max(bx.abs().max(by.abs())).max(cx.abs().max(cy.abs()));
        self.det.abs().lt(F32x8::splat(EDGE_ON) * (size * size))
    }

    /// Rays that are blocked by triangle `id` before `tmax`, or at `tmax` itself if `id` is below that of `before`.
    #[inline(always)]
    pub(super) fn blocked(&self, rays: &RayPacket, before: U32x8, id: u32) -> Mask8 {
        let t = self.t_scaled / self.det;
        let ends = t.lt(rays.tmax) | (t.eq(rays.tmax) & U32x8::splat(id).lt_signed(before));
        self.inside & t.gt(rays.tmin) & ends
    }

    /// Rays that may hit the triangle if its corners lie up to `moved` elsewhere: no precise hit is among the others.
    #[inline(always)]
    pub(super) fn near(&self, moved: F32x8) -> Mask8 {
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = self.corners;
        let sum = (ax.abs() + ay.abs()) + (bx.abs() + by.abs()) + (cx.abs() + cy.abs());
        let least = self.u.min(self.v).min(self.w);
        let most = self.u.max(self.v).max(self.w);
        // Not `ge`: what overflowed to NaN is near.
        !least.max(-most).lt(-(moved * sum))
    }
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
    Edges { v, w, det, t_scaled, inside, u, corners: [a, b, c] }
}

/// [`dominant_axis`] of eight: where it is 0, where it is 1.
#[inline(always)]
pub(super) fn dominant_axis8(direction: Vec3x8) -> (Mask8, Mask8) {
    let Vec3x8 { x, y, z } = direction.abs();
    let is_x = x.ge(y) & x.ge(z);
    (is_x, y.ge(z).and_not(is_x))
}

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
            origin: axes.each(
                #[inline(always)]
                |axis| F32x8::splat(origin[axis]),
            ),
            shear: [F32x8::splat(d[0] / d[2]), F32x8::splat(d[1] / d[2]), F32x8::splat(1.0 / d[2])],
        }
    }

    /// Against the eight triangles of a block.
    #[inline(always)]
    pub(super) fn edges(&self, block: &LeafBlock) -> Edges {
        let corner = |vertex: usize| -> [F32x8; 3] {
            [0, 1, 2].each(
                #[inline(always)]
                |k: usize| F32x8::from_array(block.vertices[vertex][self.axes[k]]) - self.origin[k],
            )
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
            [0, 1, 2].each(
                #[inline(always)]
                |k: usize| F32x8::splat(block.vertices[vertex][axes[k]][lane]) - origin[axes[k]],
            )
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
    pub(super) det: F32x8,
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

    /// As [`Best::update`] leaves it for the rays of `lanes`, which see the triangle edge-on.
    #[cold]
    #[inline(never)]
    pub(super) fn updated_edge_on(
        mut self,
        rays: &RayPacket,
        vertices: [[f32; 3]; 3],
        (edges, id): (&Edges, u32),
        lanes: Mask8,
    ) -> Self {
        here::run(
            #[inline(always)]
            || {
                let edge_on = edge_on_t(rays, vertices, edges, lanes);
                let t = edge_on.1;
                let closer = t.lt(self.t) | (t.eq(self.t) & U32x8::splat(id).lt(self.triangle));
                self.take(edge_on.0 & t.gt(rays.tmin) & closer, t, U32x8::splat(id), edges);
                self
            },
        )
    }

    /// As [`Best::update`] leaves it for the rays of `lanes`, decided in f64. By value, so that the hits of a walk that never
    /// comes here stay in registers.
    #[cold]
    #[inline(never)]
    pub(super) fn updated_precisely(
        mut self,
        rays: &RayPacket,
        vertices: [[f32; 3]; 3],
        (id, class): (u32, u8),
        lanes: Mask8,
    ) -> Self {
        here::run(
            #[inline(always)]
            || {
                let tmin = rays.tmin.to_array();
                let [mut t, mut v, mut w, mut det] = [self.t, self.v, self.w, self.det].each(F32x8::to_array);
                let mut triangle = self.triangle.to_array();
                for_each_precise_hit(rays, vertices, class, lanes, |lane, hit| {
                    if hit.t > tmin[lane] && (hit.t < t[lane] || (hit.t == t[lane] && id < triangle[lane])) {
                        (t[lane], v[lane], w[lane], det[lane], triangle[lane]) = (hit.t, hit.u, hit.v, 1.0, id);
                    }
                });
                [self.t, self.v, self.w, self.det] = [t, v, w, det].each(F32x8::from_array);
                self.triangle = U32x8::from_array(triangle);
                self
            },
        )
    }

    /// The finished hits; `u` and `v` are 0 where nothing is hit.
    #[inline(always)]
    pub(super) fn hits(&self) -> HitPacket {
        HitPacket { t: self.t, triangle: self.triangle, u: self.v / self.det, v: self.w / self.det }
    }
}

/// Which rays of `lanes` hit a triangle before `tmax`, or at `tmax` itself if its id is below that of `before`, in f64.
#[cold]
#[inline(never)]
pub(super) fn blocked_precisely(
    rays: &RayPacket,
    before: U32x8,
    vertices: [[f32; 3]; 3],
    (id, class): (u32, u8),
    lanes: Mask8,
) -> Mask8 {
    here::run(
        #[inline(always)]
        || {
            let (tmin, tmax, before) = (rays.tmin.to_array(), rays.tmax.to_array(), before.to_array());
            let mut blocked = 0;
            for_each_precise_hit(rays, vertices, class, lanes, |lane, hit| {
                let ends = hit.t < tmax[lane] || (hit.t == tmax[lane] && (id as i32) < before[lane] as i32);
                blocked |= ((hit.t > tmin[lane] && ends) as u8) << lane;
            });
            Mask8::from_bits(blocked)
        },
    )
}

/// Which rays of `lanes` hit a triangle that they see edge-on, and where.
#[inline(always)]
fn edge_on_t(rays: &RayPacket, vertices: [[f32; 3]; 3], edges: &Edges, lanes: Mask8) -> (Mask8, F32x8) {
    let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
    let (origin, direction) = (columns(rays.origin), columns(rays.direction));
    let (mut hit, mut t, tmin) = (0, (edges.t_scaled / edges.det).to_array(), rays.tmin.to_array());
    let lanes = lanes.bits();
    for (lane, t) in t.iter_mut().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1) {
        let ray = PreciseRay::new(origin.map(|axis| axis[lane]), direction.map(|axis| axis[lane]));
        if let Some(at) = ray.edge_on(vertices, *t, tmin[lane]) {
            (hit, *t) = (hit | 1 << lane, at);
        }
    }
    (Mask8::from_bits(hit), F32x8::from_array(t))
}

/// Which rays of `lanes` are blocked, before `tmax`, or at `tmax` itself if its id is below that of `before`, by a triangle that
/// they see edge-on.
#[cold]
#[inline(never)]
pub(super) fn blocked_edge_on(
    rays: &RayPacket,
    before: U32x8,
    vertices: [[f32; 3]; 3],
    (edges, id): (&Edges, u32),
    lanes: Mask8,
) -> Mask8 {
    here::run(
        #[inline(always)]
        || {
            let (hit, t) = edge_on_t(rays, vertices, edges, lanes);
            hit & t.gt(rays.tmin) & (t.lt(rays.tmax) | (t.eq(rays.tmax) & U32x8::splat(id).lt_signed(before)))
        },
    )
}

/// Tells of the hits in f64 that the rays of `lanes` have on a triangle, at any `t`.
#[inline(always)]
fn for_each_precise_hit(
    rays: &RayPacket,
    vertices: [[f32; 3]; 3],
    class: u8,
    lanes: Mask8,
    mut tell: impl FnMut(usize, PreciseHit),
) {
    let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
    let (origin, direction) = (columns(rays.origin), columns(rays.direction));
    let mut bits = lanes.bits();
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize & 7;
        bits &= bits - 1;
        let ray = PreciseRay::new(origin.map(|axis| axis[lane]), direction.map(|axis| axis[lane]));
        if let Some(hit) = ray.hit(vertices, class) {
            tell(lane, hit);
        }
    }
}
