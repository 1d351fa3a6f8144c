//! The point a ray has hit: position, facing normal, and a safe place for the next ray to start.

use super::{Real, Vec3, vec3};
use crate::scene::prepare::TriangleRecord;

/// Offsets are this many half-ulps (2^-24) of the coordinates that made the point.
///
/// The position is a barycentric sum: its rounding error is below gamma(4) times the sum of |weight x coordinate|
/// (pbrt-v4 section 6.8.5); the triangle test of the next ray adds a few ulps of the same sum, along every axis, since its
/// shear mixes them. 16 half-ulps of the sum over the axes cover both.
pub const OFFSET_HALF_ULPS: Real = 16.0;

/// A point on a surface.
pub struct SurfacePoint {
    /// The hit, from barycentric weights.
    pub position: Vec3,
    /// Unit normal on the side the ray came from.
    pub normal: Vec3,
    /// The ray hit the front.
    pub front: bool,
    /// Where rays that leave on the side of `normal` start.
    pub origin: Vec3,
    /// Where rays that leave on the other side start.
    pub origin_behind: Vec3,
}

/// The point with weights (1-u-v, u, v) on `triangle`, hit by a ray in direction `direction`.
pub fn surface_point(triangle: &TriangleRecord, u: Real, v: Real, direction: Vec3) -> SurfacePoint {
    let weights = [1.0 - u - v, u, v];
    let front_normal = vec3(triangle.normal);
    let front = front_normal.dot(direction) < 0.0;
    let normal = if front { front_normal } else { -front_normal };
    let (position, offset) = point_and_offset(&triangle.vertices, weights);
    let (origin, origin_behind) = (position + normal * offset, position - normal * offset);
    SurfacePoint { position, normal, front, origin, origin_behind }
}

/// A barycentric sum, and how far along the normal a ray must start to be off the surface for certain.
pub fn point_and_offset(vertices: &[[f32; 3]; 3], weights: [Real; 3]) -> (Vec3, Real) {
    let [a, b, c] = vertices.map(vec3);
    let position = a * weights[0] + b * weights[1] + c * weights[2];
    let size = a.abs() * weights[0] + b.abs() * weights[1] + c.abs() * weights[2];
    (position, (size.x + size.y + size.z) * (OFFSET_HALF_ULPS * (Real::EPSILON * 0.5)))
}
