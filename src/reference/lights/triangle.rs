//! Points on a triangle, uniform by the solid angle that it fills as seen from another point: light that arrives from
//! such points has no cosine at the light and no squared distance left to vary.
//!
//! The solid angle is Van Oosterom and Strackee's ("The Solid Angle of a Plane Triangle", IEEE Trans. Biomed. Eng.
//! 1983). The map is Arvo's ("Stratified Sampling of Spherical Triangles", SIGGRAPH 1995): the first number chooses a
//! smaller triangle with a part of the solid angle, the second a point on its new side. How the new vertex is found
//! follows from the first formula and has no cancellation in small triangles (the idea of Peters, "BRDF Importance
//! Sampling for Polygonal Lights", ACM Trans. Graph. 40, 2021): let `a`, `b`, `c` be the unit directions to the
//! vertices, `c'` a direction on the arc from `a` to `c`, and `h` any vector along its bisector with `a`. Then
//! `a + c' = k h`, so that
//!
//! ```text
//! tan(solid angle of a b c' / 2) = det(a, b, c') / (1 + a.b + b.c' + c'.a) = det(a, b, h) / ((a + b).h)
//! ```
//!
//! With `h = alpha a + gamma c` that is linear in alpha and gamma: their ratio, and thereby `c'`, costs one sine and
//! cosine.

use super::warp::sample_uniform_triangle;
use super::{INV_2PI, Real, Vec3, atan2_turns, sin_cos_turns, vec3};
use crate::fault::lost_digits;
use crate::tables::lights::table::{LEAST_HALF_ANGLE, LEAST_TANGENT, MOST_HALF_ANGLE, MOST_REMOTE};

/// A triangle as seen from a point.
pub struct SolidAngle {
    /// Part of the points that are drawn by solid angle, above 0; the others are drawn by area.
    pub part: Real,
    /// Half the solid angle, in turns: 1/2 is a hemisphere.
    pub half_turns: Real,
    /// One over the distances of the vertices.
    inverse_distance: [Real; 3],
    /// Cosines between the directions to vertices 0 and 1, 1 and 2, 2 and 0.
    cosine: [Real; 3],
    /// Magnitude of the determinant of the three unit directions.
    volume: Real,
}

/// The triangle with these vertices and density `pdf_area` (one over its area) as seen from `origin`; `None` if points
/// on it are to be drawn by area: it is small from there, and as well drawn so, or its solid angle is too near to 0, to
/// a hemisphere, or (`origin` on an edge) to a jump for these numbers. On the way to each of these limits more and more
/// points are drawn by area, so that the density is continuous. The answer, and every bit of it, is a function of the
/// arguments alone: light sampling and multiple importance sampling cannot disagree.
pub fn solid_angle(vertices: &[[f32; 3]; 3], pdf_area: Real, origin: Vec3) -> Option<SolidAngle> {
    let [a, b, c] = vertices.map(|vertex| vec3(vertex) - origin);
    let (aa, bb, cc) = (a.dot(a), b.dot(b), c.dot(c));
    let remote = min(min(aa, bb), cc) * pdf_area;
    if !(remote < MOST_REMOTE as Real) {
        return None;
    }
    // The vertices' own differences: those seen from the origin have been rounded once more.
    let [p, q, r] = vertices.map(vec3);
    let normal = (q - p).cross(r - p);
    let inverse_distance = [1.0 / aa.sqrt(), 1.0 / bb.sqrt(), 1.0 / cc.sqrt()];
    let (a, b, c) = (a * inverse_distance[0], b * inverse_distance[1], c * inverse_distance[2]);
    let cosine = [a.dot(b), b.dot(c), c.dot(a)];
    // By the nearest vertex: what its direction has lost by rounding weighs least.
    let [ia, ib, ic] = inverse_distance;
    let (direction, others) = if aa <= bb && aa <= cc {
        (a, ib * ic)
    } else if bb <= cc {
        (b, ic * ia)
    } else {
        (c, ia * ib)
    };
    let volume = (direction.dot(normal) * others).abs();
    let base = 1.0 + cosine[0] + cosine[1] + cosine[2];
    let half_turns = atan2_turns(volume, base);
    // 0 at each limit, 1 at half the largest distance, twice the least angle and tangent, and 6.16 sr.
    let near = (MOST_REMOTE as Real - remote) * (2.0 / MOST_REMOTE as Real);
    let large = (half_turns - LEAST_HALF_ANGLE as Real) * (1.0 / LEAST_HALF_ANGLE as Real);
    let small = (MOST_HALF_ANGLE as Real - half_turns) * (1.0 / (0.5 - MOST_HALF_ANGLE) as Real);
    let certain = (max(volume, base.abs()) - LEAST_TANGENT as Real) * (1.0 / LEAST_TANGENT as Real);
    let part = min(min(near, large), min(small, certain));
    // Not a number where the origin is a vertex.
    if !(part > 0.0) {
        return None;
    }
    let half_turns = half_turns * lost_digits(Real::EPSILON as f64) as Real;
    Some(SolidAngle { part: min(part, 1.0), half_turns, inverse_distance, cosine, volume })
}

impl SolidAngle {
    /// Barycentric weights of a point.
    pub fn sample(&self, u: [Real; 2]) -> [Real; 3] {
        if u[0] < self.part {
            self.sample_solid_angle([u[0] / self.part, u[1]])
        } else {
            sample_uniform_triangle([(u[0] - self.part) / (1.0 - self.part), u[1]])
        }
    }

    /// Density per steradian of [`SolidAngle::sample`] where drawing by area alone would have density `pdf_by_area`.
    pub fn pdf_dir(&self, pdf_by_area: Real) -> Real {
        let pdf = 0.5 * INV_2PI / self.half_turns;
        if self.part < 1.0 { self.part * pdf + (1.0 - self.part) * pdf_by_area } else { pdf }
    }

    /// Barycentric weights of a point, uniform by solid angle.
    pub fn sample_solid_angle(&self, u: [Real; 2]) -> [Real; 3] {
        let [ab, bc, ca] = self.cosine;
        // The bisector h = (1 - tau) a + tau c of the smaller triangle's new side.
        let (sine, cosine) = sin_cos_turns(u[0] * self.half_turns);
        let alpha = self.volume * cosine - (bc + ca) * sine;
        let gamma = (1.0 + ab) * sine;
        let tau = gamma / (alpha + gamma);
        // Its new vertex c' = from_a a + from_c c, the mirror image of a in h.
        let bend = 1.0 - ca;
        let k = 2.0 * (1.0 - tau * bend) / (1.0 - 2.0 * tau * (1.0 - tau) * bend);
        let (from_a, from_c) = (k * (1.0 - tau) - 1.0, k * tau);
        // A point from_b b + t c' between b and c', whose cosine with b is uniform.
        let bend = 1.0 - (from_a * ab + from_c * bc);
        let t = (u[1] * (2.0 - u[1] * bend) / (2.0 - bend)).sqrt();
        let from_b = (1.0 - t) + bend * (t - u[1]);
        // Where that direction meets the triangle.
        let [ia, ib, ic] = self.inverse_distance;
        let weights = [max(t * from_a, 0.0) * ia, max(from_b, 0.0) * ib, max(t * from_c, 0.0) * ic];
        let scale = 1.0 / (weights[0] + weights[1] + weights[2]);
        let (v, w) = (weights[1] * scale, weights[2] * scale);
        [max(1.0 - v - w, 0.0), v, w]
    }
}

/// The crate's minimum.
fn min(a: Real, b: Real) -> Real {
    if a < b { a } else { b }
}

/// The crate's maximum.
fn max(a: Real, b: Real) -> Real {
    if a > b { a } else { b }
}
