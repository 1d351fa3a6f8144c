//! The points that eight rays have hit: position, normals on the sides the rays came from, and safe places for the next
//! rays to start. What smooth surfaces need is compiled in by `DETAIL`: scenes without them do not pay for it.

use super::here;
use crate::bvh::Bvh;
use crate::bvh::precise::HUGE;
use crate::fault::{Fault, planted};
use crate::tables::corners::{CornerRecord, FLAT, LIFTED};
use crate::tables::triangles::TriangleRecord;
use glam::DVec3;
use here::kernels::records::{CornerColumns, TriangleColumns};
use here::kernels::texture::interpolate;
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8, Vec3x8};

/// Rounding moves a number by at most this fraction of it.
pub const HALF_ULP: f32 = 1.0 / 16_777_216.0;

/// Offsets are this many half-ulps of the coordinates that made the point. The scalar twin's comment has the figures.
pub const OFFSET_HALF_ULPS: f32 = 8.0;

/// Where a point is made in f64 (it and the start of the next ray are rounded once each), of the coordinates along the normal.
pub const PRECISE_HALF_ULPS: f32 = 4.0;

/// By how much of a triangle's coordinates its plane may be missed in f64: 16 ulps.
pub const PLANE: f32 = 1.0 / (1u64 << 48) as f32;

/// There points keep off the edges by 32 half-ulps of their own coordinates across them.
const INSET: f64 = 32.0 / 16_777_216.0;

/// Shading normals are bent towards the viewers until they make at least this cosine with the rays (or, nearly along the
/// surfaces, the geometric normals').
pub const LEAST_FACING: f32 = 0.01;

/// Eight points on surfaces.
#[derive(Clone)]
pub struct SurfacePoints {
    /// The hits, from barycentric weights; on smooth surfaces lifted onto them.
    pub position: Vec3x8,
    /// Unit normals of the triangles, on the sides the rays came from: they decide what lies above the surfaces.
    pub geometric_normal: Vec3x8,
    /// Unit normals to shade with, less than 90 degrees from the geometric ones.
    pub normal: Vec3x8,
    /// Texture coordinates, where `DETAIL` says there can be textures.
    pub uv: [F32x8; 2],
    /// The rays hit fronts.
    pub front: Mask8,
    /// Where rays that leave on the sides of the geometric normals start.
    pub origin: Vec3x8,
    /// Where rays that leave on the other sides start.
    pub origin_behind: Vec3x8,
    /// Material indices.
    pub material: U32x8,
}

/// The points with weights (1-u-v, u, v) on `triangle`, kept off its edges, hit by rays in directions `direction`.
/// With `DETAIL` there is an entry of `corners` a triangle.
#[inline(always)]
pub fn surface_points<const DETAIL: bool>(
    (triangles, corners): (&[TriangleRecord], &[CornerRecord]),
    triangle: U32x8,
    u: F32x8,
    v: F32x8,
    direction: Vec3x8,
) -> SurfacePoints {
    surface_points_on::<DETAIL>((triangles, corners), None, triangle, u, v, direction)
}

/// Where rays have found their hits, `o + t d`, in scenes that have huge triangles.
pub struct Found<'a> {
    /// Knows the huge triangles.
    pub bvh: &'a Bvh,
    /// The points.
    pub position: Vec3x8,
}

/// [`surface_points`], on huge triangles from `found`. Common triangles keep points off their edges by weights, those that are
/// tested in f64 in f64.
#[inline(always)]
pub fn surface_points_on<const DETAIL: bool>(
    (triangles, corners): (&[TriangleRecord], &[CornerRecord]),
    found: Option<Found>,
    triangle: U32x8,
    u: F32x8,
    v: F32x8,
    direction: Vec3x8,
) -> SurfacePoints {
    let record = TriangleColumns::gather(triangles, triangle);
    let weights = inset_weights(u, v, record.inset * F32x8::splat(HALF_ULP));
    let front: Mask8 = record.normal.dot(direction).lt(F32x8::ZERO);
    let normal = front.select_vec3(record.normal, -record.normal);
    let (mut position, mut offset) = point_and_offset(&record.vertices, weights, record.offset);
    let precise = record.offset.lt(F32x8::ZERO);
    let huge = found.as_ref().map_or(0, |found| found.bvh.lanes_of_class(triangle.to_array(), HUGE));
    if (precise | Mask8::from_bits(huge)).any() {
        let points = found.map_or(position, |found| found.position);
        on_precise_triangles(points, (precise, huge), &record, &mut position, &mut offset);
    }
    if planted(Fault::WrongOffset) {
        offset = F32x8::ZERO - offset;
    }
    if planted(Fault::AbsoluteEpsilon) {
        offset = F32x8::splat(1e-4);
    }
    let away = normal.scale(offset);
    let (origin, origin_behind) = (position + away, position - away);
    let mut points = SurfacePoints {
        position,
        geometric_normal: normal,
        normal,
        uv: [F32x8::ZERO; 2],
        front,
        origin,
        origin_behind,
        material: record.material,
    };
    if DETAIL {
        let corners = CornerColumns::gather(corners, triangle);
        points.uv = interpolate(corners.uvs, weights);
        points.smooth(&corners, &record.vertices, weights, away);
    }
    points
}

impl SurfacePoints {
    /// Gives points on smooth surfaces the interpolated normals and, unless their corners lean too far, lifts them onto
    /// the smooth surfaces (after Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4, 2021).
    #[inline(always)]
    fn smooth(&mut self, corners: &CornerColumns, vertices: &[Vec3x8; 3], weights: [F32x8; 3], away: Vec3x8) {
        let zero = F32x8::ZERO;
        let is = |value: u32| corners.smoothness.eq(U32x8::splat(value));
        let n = corners.normals.each(
            #[inline(always)]
            |n| self.front.select_vec3(n, -n),
        );
        let sum = n[0].scale(weights[0]) + n[1].scale(weights[1]) + n[2].scale(weights[2]);
        let interpolated = sum.scale(F32x8::ONE / sum.dot(sum).sqrt());
        let usable = interpolated.dot(self.geometric_normal).gt(zero).and_not(is(FLAT));
        self.normal = usable.select_vec3(interpolated, self.normal);
        let lifted = is(LIFTED);
        if !lifted.any() {
            return;
        }
        let (mut above, mut below) = (zero, zero);
        for i in 0..3 {
            let height = (vertices[i] - self.position).dot(n[i]);
            above = above + weights[i] * height.gt(zero).select(height, zero);
            below = below + weights[i] * height.lt(zero).select(height, zero);
        }
        let behind = self.position + self.geometric_normal.scale(below) - away;
        let position = self.position + self.geometric_normal.scale(above);
        self.origin_behind = lifted.select_vec3(behind, self.origin_behind);
        self.origin = lifted.select_vec3(position + away, self.origin);
        self.position = lifted.select_vec3(position, self.position);
    }

    /// Bends shading normals until the viewers, in directions `wo`, are above them: glossy surfaces have no answer there.
    #[inline(always)]
    pub fn face_forward(&mut self, wo: Vec3x8) {
        let (cosine, geometric_cosine) = (wo.dot(self.normal), wo.dot(self.geometric_normal));
        let least = F32x8::splat(LEAST_FACING).min(geometric_cosine);
        let bent = self.normal + wo.scale(least - cosine);
        let bent = bent.scale(F32x8::ONE / bent.dot(bent).sqrt());
        self.normal = cosine.lt(least).select_vec3(bent, self.normal);
    }

    /// For glass: the rays' directions, bent until the viewers are above the shading normals. What is then refracted lies
    /// within the critical angle of those normals, as the normals it will meet on its way out expect.
    #[inline(always)]
    pub fn graze(&self, direction: Vec3x8) -> Vec3x8 {
        let (cosine, geometric_cosine) = (-direction.dot(self.normal), -direction.dot(self.geometric_normal));
        let least = F32x8::splat(LEAST_FACING).min(geometric_cosine);
        let bent = direction - self.normal.scale(least - cosine);
        let bent = bent.scale(F32x8::ONE / bent.dot(bent).sqrt());
        cosine.lt(least).select_vec3(bent, direction)
    }

    /// Lanes whose direction lies on the side of the triangle that the shading normal meant. The others would leak.
    #[inline(always)]
    pub fn in_consistent_hemisphere(&self, direction: Vec3x8) -> Mask8 {
        let zero = F32x8::ZERO;
        !(direction.dot(self.geometric_normal).gt(zero) ^ direction.dot(self.normal).gt(zero))
    }

    /// Directions of delta lobes; those on the wrong side of the triangle become their mirror images in it.
    #[inline(always)]
    pub fn to_consistent_hemisphere(&self, direction: Vec3x8) -> Vec3x8 {
        let depth = direction.dot(self.geometric_normal);
        let image = direction - self.geometric_normal.scale(F32x8::splat(2.0) * depth);
        self.in_consistent_hemisphere(direction).select_vec3(direction, image)
    }
}

/// The weights (1-u-v, u, v), each raised to `inset` at least at the cost of the largest: points next to an edge move
/// off it ([`crate::tables::margins`]), all others stay where they are.
#[inline(always)]
fn inset_weights(u: F32x8, v: F32x8, inset: F32x8) -> [F32x8; 3] {
    let (u, v) = (u.max(inset), v.max(inset));
    let lacking = (inset - (F32x8::ONE - u - v)).max(F32x8::ZERO);
    let first = u.gt(v);
    let (u, v) = (first.select(u - lacking, u), first.select(v, v - lacking));
    [F32x8::ONE - u - v, u, v]
}

/// Points and offsets in lanes whose triangles are tested in f64 (`precise`), or huge: there from the `points` where the rays have
/// found them, since a barycentric sum is as inexact as the triangle is large.
#[inline(never)]
fn on_precise_triangles(
    points: Vec3x8,
    (precise, huge): (Mask8, u8),
    record: &TriangleColumns,
    position: &mut Vec3x8,
    offset: &mut F32x8,
) {
    here::run(
        #[inline(always)]
        || {
            let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
            let (vertices, normal, points) = (
                record.vertices.each(
                    #[inline(always)]
                    |v| columns(v),
                ),
                columns(record.normal),
                columns(points),
            );
            let (mut position8, mut offset8) = (columns(*position), offset.to_array());
            for lane in 0..LANES {
                let precise = precise.bits() >> lane & 1 == 1;
                let huge = huge >> lane & 1 == 1;
                if !(precise || huge) {
                    continue;
                }
                let at = |column: [[f32; LANES]; 3]| column.map(|axis| axis[lane]);
                let next_to = at(if huge { points } else { position8 });
                let (point, away) = on_triangle(vertices.map(at), at(normal), next_to);
                for axis in 0..3 {
                    position8[axis][lane] = point[axis];
                }
                if precise {
                    offset8[lane] = away;
                }
            }
            let [x, y, z] = position8.each(F32x8::from_array);
            (*position, *offset) = (Vec3x8::new(x, y, z), F32x8::from_array(offset8));
        },
    )
}

/// The point of a triangle next to `p`, off its edges, in f64, rounded once, and how far from it rays must start; the scalar
/// twin has the reasons.
#[inline(always)]
fn on_triangle(vertices: [[f32; 3]; 3], normal: [f32; 3], p: [f32; 3]) -> ([f32; 3], f32) {
    let v = vertices.map(|v| DVec3::from(v.map(f64::from)));
    let n = (v[1] - v[0]).cross(v[2] - v[0]);
    let p = DVec3::from(p.map(f64::from));
    let mut p = p - n * (n.dot(p - v[0]) / n.dot(n));
    let edges = [v[2] - v[1], v[0] - v[2], v[1] - v[0]];
    let [a, b, c] = edges.map(|edge| edge.dot(edge));
    let longest = if a >= b && a >= c {
        0
    } else if b >= c {
        1
    } else {
        2
    };
    for i in [longest, (longest + 1) % 3, (longest + 2) % 3] {
        let (from, edge) = (v[(i + 1) % 3], edges[i]);
        let inward = n.cross(edge);
        let length = inward.dot(inward).sqrt();
        let inward = inward * (1.0 / length);
        let margin = INSET * inward.abs().dot(p.abs());
        let most = length / edge.dot(edge) * (1.0 / 16.0);
        let lacking = (if margin < most { margin } else { most }) - inward.dot(p - from);
        if lacking > 0.0 {
            p += inward * lacking;
        }
    }
    let point = p.to_array().map(|x| x as f32);
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| normal[k].abs() * point[k].abs());
    let reach = vertices.iter().flatten().fold(0.0, |most: f32, x| if x.abs() > most { x.abs() } else { most });
    (point, ((x + y) + z) * (PRECISE_HALF_ULPS * HALF_ULP) + reach * PLANE)
}

/// Barycentric sums.
#[inline(always)]
pub fn barycentric_point([a, b, c]: &[Vec3x8; 3], weights: [F32x8; 3]) -> Vec3x8 {
    a.scale(weights[0]) + b.scale(weights[1]) + c.scale(weights[2])
}

/// Barycentric sums, and how far along the normals rays must start to be off common triangles for certain; `offset` is
/// [`crate::tables::margins::Margins::offset`].
#[inline(always)]
pub fn point_and_offset(vertices: &[Vec3x8; 3], weights: [F32x8; 3], offset: F32x8) -> (Vec3x8, F32x8) {
    let [a, b, c] = *vertices;
    let position = barycentric_point(vertices, weights);
    let size = a.abs().scale(weights[0]) + b.abs().scale(weights[1]) + c.abs().scale(weights[2]);
    let half_ulps = (size.x + size.y + size.z) * F32x8::splat(OFFSET_HALF_ULPS) + offset;
    (position, half_ulps * F32x8::splat(HALF_ULP))
}
