//! The point a ray has hit: position, normals on the side the ray came from, and safe places for the next ray to start.

use super::precise::nearest_on_triangle;
use super::texture::interpolate;
use super::{Real, Vec3, vec3};
use crate::fault::{Fault, lost_digits, planted};
use crate::tables::corners::{CornerRecord, FLAT, LIFTED};
use crate::tables::margins::PRECISE_OFFSET;
use crate::tables::triangles::TriangleRecord;

/// Rounding moves a number by at most this fraction of it: 2^-24 in f32.
pub const HALF_ULP: Real = Real::EPSILON * 0.5;

/// Offsets are this many half-ulps of the coordinates that made the point.
///
/// The position is a barycentric sum: its rounding error is below gamma(4) times the sum of |weight x coordinate|
/// (pbrt-v4 section 6.8.5); the triangle test of the next ray adds a few half-ulps of the same sum, along every axis,
/// since its shear mixes them. Measured, as rays that hit again the triangle they leave (3e5 points a mesh, most of
/// them next to edges and corners, cosine and grazing directions; spheres, boxes, spot, bunny, teapot; sizes 1e-6, 1
/// and 1e6, at 0 to 1e3 sizes from the origin): at 0 half-ulps 45 %, at 1 1 %, at 2 7e-4, from 3 on none; a wedge of
/// 10 degrees needs 8. More would only move contact shadows and carry more points through the walls of acute corners.
pub const OFFSET_HALF_ULPS: Real = 8.0;

/// Where a point is made in f64 (it and the start of the next ray are rounded once each), of the coordinates along the normal.
pub const PRECISE_HALF_ULPS: Real = 4.0;

/// By how much of a triangle's coordinates its plane may be missed in f64: 16 ulps. Moved onto a floor at y = 0, a point may be
/// at y = -1e-23.
pub const PLANE: Real = 1.0 / (1u64 << 48) as Real;

/// Shading normals are bent towards the viewer until they make at least this cosine with the ray (or, nearly along the
/// surface, the geometric normal's).
pub const LEAST_FACING: Real = 0.01;

/// A point on a surface.
pub struct SurfacePoint {
    /// The hit, from barycentric weights; on a smooth surface lifted onto it.
    pub position: Vec3,
    /// Unit normal of the triangle, on the side the ray came from: it decides what lies above the surface.
    pub geometric_normal: Vec3,
    /// Unit normal to shade with, less than 90 degrees from the geometric one.
    pub normal: Vec3,
    /// Texture coordinates.
    pub uv: [Real; 2],
    /// The ray hit the front.
    pub front: bool,
    /// Where rays that leave on the side of the geometric normal start.
    pub origin: Vec3,
    /// Where rays that leave on the other side start.
    pub origin_behind: Vec3,
}

/// The point with weights (1-u-v, u, v) on `triangle`, kept off its edges, hit by a ray in direction `direction`.
pub fn surface_point(
    triangle: &TriangleRecord,
    corners: Option<&CornerRecord>,
    u: Real,
    v: Real,
    direction: Vec3,
) -> SurfacePoint {
    surface_point_on(triangle, corners, None, [u, v], direction)
}

/// [`surface_point`]; on a huge triangle, where a barycentric sum is as inexact as the triangle is large, the point is the one
/// that the ray has `found`. Points on triangles that are tested in f64 are kept off the edges in f64: by weights they would
/// move along a sliver by its aspect times as much.
pub fn surface_point_on(
    triangle: &TriangleRecord,
    corners: Option<&CornerRecord>,
    found: Option<Vec3>,
    [u, v]: [Real; 2],
    direction: Vec3,
) -> SurfacePoint {
    let weights = inset_weights(u, v, triangle.inset as Real * HALF_ULP);
    let front_normal = vec3(triangle.normal);
    let front = front_normal.dot(direction) < 0.0;
    let normal = if front { front_normal } else { -front_normal };
    let offset = triangle.offset as Real;
    let (mut position, mut offset) = point_and_offset(&triangle.vertices, weights, offset);
    let precise = triangle.offset == PRECISE_OFFSET;
    if found.is_some() || precise {
        position = nearest_on_triangle(triangle.vertices, found.unwrap_or(position));
    }
    if precise {
        let reach = triangle.vertices.as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
        offset = front_normal.abs().dot(position.abs()) * (PRECISE_HALF_ULPS * HALF_ULP) + reach as Real * PLANE;
    }
    if planted(Fault::WrongOffset) {
        offset = -offset;
    }
    if planted(Fault::AbsoluteEpsilon) {
        offset = 1e-4;
    }
    let away = normal * offset;
    let mut point = SurfacePoint {
        position,
        geometric_normal: normal,
        normal,
        uv: corners.map_or([0.0; 2], |corners| interpolate(&corners.uvs, weights)),
        front,
        origin: position + away,
        origin_behind: position - away,
    };
    if let Some(corners) = corners.filter(|corners| corners.smoothness != FLAT) {
        let normals = corners.normals.map(|n| if front { vec3(n) } else { -vec3(n) });
        point.smooth(corners, &triangle.vertices.map(vec3), normals, weights, away);
    }
    point
}

impl SurfacePoint {
    /// Gives the point the interpolated normal and, unless its corners lean too far, lifts it onto the smooth surface
    /// that the normals describe, so that the triangle's neighbours throw no facets of shadow on it (Hanika, "Hacking the
    /// Shadow Terminator", Ray Tracing Gems II, chapter 4, 2021). The chapter moves along the corner normals; here
    /// the point moves as far along the geometric one, so that it cannot slide through a wall beside it. Rays that leave on
    /// the other side see the surface curved the other way.
    fn smooth(&mut self, corners: &CornerRecord, vertices: &[Vec3; 3], n: [Vec3; 3], weights: [Real; 3], away: Vec3) {
        let sum = n[0] * weights[0] + n[1] * weights[1] + n[2] * weights[2];
        let interpolated = sum * (1.0 / sum.dot(sum).sqrt());
        if interpolated.dot(self.geometric_normal) > 0.0 {
            self.normal = interpolated;
        }
        if corners.smoothness == LIFTED {
            let (mut above, mut below) = (0.0, 0.0);
            for i in 0..3 {
                let height = (vertices[i] - self.position).dot(n[i]);
                above += weights[i] * if height > 0.0 { height } else { 0.0 };
                below += weights[i] * if height < 0.0 { height } else { 0.0 };
            }
            self.origin_behind = self.position + self.geometric_normal * below - away;
            self.position += self.geometric_normal * above;
            self.origin = self.position + away;
        }
    }

    /// Bends the shading normal until the viewer, in direction `wo`, is above it: glossy surfaces have no answer there.
    pub fn face_forward(&mut self, wo: Vec3) {
        let (cosine, geometric_cosine) = (wo.dot(self.normal), wo.dot(self.geometric_normal));
        let least = if LEAST_FACING < geometric_cosine { LEAST_FACING } else { geometric_cosine };
        if cosine < least {
            let bent = self.normal + wo * (least - cosine);
            self.normal = bent * (1.0 / bent.dot(bent).sqrt());
        }
    }

    /// For glass: a ray's `direction`, bent until the viewer is above the shading normal as [`SurfacePoint::face_forward`] has it. What
    /// is then refracted lies within the critical angle of that normal, as the normals it will meet on its way out expect.
    /// (About a bent normal rays entered balls at angles from which there is no way out but by chance: of 19 million paths
    /// 13 ran to the guard.)
    pub fn graze(&self, direction: Vec3) -> Vec3 {
        let (cosine, geometric_cosine) = (-direction.dot(self.normal), -direction.dot(self.geometric_normal));
        let least = if LEAST_FACING < geometric_cosine { LEAST_FACING } else { geometric_cosine };
        if cosine < least {
            let bent = direction - self.normal * (least - cosine);
            return bent * (1.0 / bent.dot(bent).sqrt());
        }
        direction
    }

    /// `direction`, which the shading normal has led to, on the side of the triangle that was meant: `None` if light
    /// would leak through. Glass and mirrors, which have no other direction, get its mirror image in the triangle's plane;
    /// every strategy treats them alike, so all still agree. Directions with a density end, as light samples from
    /// below do: their mirror images have been drawn with another density.
    pub fn to_consistent_hemisphere(&self, direction: Vec3, delta: bool) -> Option<Vec3> {
        let depth = direction.dot(self.geometric_normal);
        let meant = direction.dot(self.normal) > 0.0;
        match (depth > 0.0) == meant {
            true => Some(direction),
            false if delta => Some(direction - self.geometric_normal * (2.0 * depth)),
            false => None,
        }
    }
}

/// The weights (1-u-v, u, v), each raised to `inset` at least at the cost of the largest: points next to an edge move
/// off it ([`crate::tables::margins`]), all others stay where they are.
fn inset_weights(u: Real, v: Real, inset: Real) -> [Real; 3] {
    let u = if u > inset { u } else { inset };
    let v = if v > inset { v } else { inset };
    let lacking = inset - (1.0 - u - v);
    let lacking = if lacking > 0.0 { lacking } else { 0.0 };
    let (u, v) = if u > v { (u - lacking, v) } else { (u, v - lacking) };
    [1.0 - u - v, u, v]
}

/// A barycentric sum.
pub fn barycentric_point(vertices: &[[f32; 3]; 3], weights: [Real; 3]) -> Vec3 {
    let [a, b, c] = vertices.map(vec3);
    (a * weights[0] + b * weights[1] + c * weights[2]) * lost_digits(Real::EPSILON as f64) as Real
}

/// A barycentric sum, and how far along the normal a ray must start to be off a common triangle for certain; `offset` is
/// [`crate::tables::margins::Margins::offset`].
pub fn point_and_offset(vertices: &[[f32; 3]; 3], weights: [Real; 3], offset: Real) -> (Vec3, Real) {
    let position = barycentric_point(vertices, weights);
    let [a, b, c] = vertices.map(vec3);
    let size = a.abs() * weights[0] + b.abs() * weights[1] + c.abs() * weights[2];
    let half_ulps = (size.x + size.y + size.z) * OFFSET_HALF_ULPS + offset;
    (position, half_ulps * HALF_ULP)
}
