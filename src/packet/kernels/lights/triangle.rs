//! Points on triangles, uniform by the solid angle that they fill as seen from other points, eight at a time. The
//! scalar twin has the derivation.

use super::here;
use crate::math::INV_2PI;
use crate::tables::lights::table::{LEAST_HALF_ANGLE, LEAST_TANGENT, MOST_HALF_ANGLE, MOST_REMOTE};
use here::kernels::warp::sample_uniform_triangle;
use here::lanes::{Each, F32x8, Mask8, Vec3x8, atan2_turns, sin_cos_turns};

/// Eight triangles as seen from eight points.
pub struct SolidAngles {
    /// Parts of the points that are drawn by solid angle, the others by area. 0 where all are: the lane's other fields
    /// then mean nothing.
    pub part: F32x8,
    /// Half the solid angles, in turns: 1/2 is a hemisphere.
    pub half_turns: F32x8,
    /// One over the distances of the vertices.
    inverse_distance: [F32x8; 3],
    /// Cosines between the directions to vertices 0 and 1, 1 and 2, 2 and 0.
    cosine: [F32x8; 3],
    /// Magnitudes of the determinants of the three unit directions.
    volume: F32x8,
}

/// The triangles with these vertices and densities `pdf_area` (one over their areas) as seen from `origin`.
#[inline(always)]
pub fn solid_angles(vertices: &[Vec3x8; 3], pdf_area: F32x8, origin: Vec3x8) -> SolidAngles {
    let (zero, one) = (F32x8::ZERO, F32x8::ONE);
    let [a, b, c] = (*vertices).each(
        #[inline(always)]
        |vertex| vertex - origin,
    );
    let (aa, bb, cc) = (a.dot(a), b.dot(b), c.dot(c));
    let remote = aa.min(bb).min(cc) * pdf_area;
    let reached = remote.lt(F32x8::splat(MOST_REMOTE));
    if !reached.any() {
        let nothing = [zero; 3];
        return SolidAngles { part: zero, half_turns: zero, inverse_distance: nothing, cosine: nothing, volume: zero };
    }
    let [p, q, r] = *vertices;
    let normal = (q - p).cross(r - p);
    let inverse_distance = [one / aa.sqrt(), one / bb.sqrt(), one / cc.sqrt()];
    let (a, b, c) = (a.scale(inverse_distance[0]), b.scale(inverse_distance[1]), c.scale(inverse_distance[2]));
    let cosine = [a.dot(b), b.dot(c), c.dot(a)];
    let [ia, ib, ic] = inverse_distance;
    let (a_first, b_first) = (aa.le(bb) & aa.le(cc), bb.le(cc));
    let direction = a_first.select_vec3(a, b_first.select_vec3(b, c));
    let others = a_first.select(ib * ic, b_first.select(ic * ia, ia * ib));
    let volume = (direction.dot(normal) * others).abs();
    let base = one + cosine[0] + cosine[1] + cosine[2];
    let half_turns = atan2_turns(volume, base);
    let ramp = |x: F32x8, slope: f32| x * F32x8::splat(slope);
    let near = ramp(F32x8::splat(MOST_REMOTE) - remote, 2.0 / MOST_REMOTE);
    let large = ramp(half_turns - F32x8::splat(LEAST_HALF_ANGLE), 1.0 / LEAST_HALF_ANGLE);
    let small = ramp(F32x8::splat(MOST_HALF_ANGLE) - half_turns, 1.0 / (0.5 - MOST_HALF_ANGLE));
    let certain = ramp(volume.max(base.abs()) - F32x8::splat(LEAST_TANGENT), 1.0 / LEAST_TANGENT);
    let part = near.min(large).min(small.min(certain));
    let part = (reached & part.gt(zero)).select(part.min(one), zero);
    SolidAngles { part, half_turns, inverse_distance, cosine, volume }
}

impl SolidAngles {
    /// Lanes in which some points are drawn by solid angle.
    #[inline(always)]
    pub fn chosen(&self) -> Mask8 {
        self.part.gt(F32x8::ZERO)
    }

    /// Barycentric weights of points.
    #[inline(always)]
    pub fn sample(&self, u: [F32x8; 2]) -> [F32x8; 3] {
        let one = F32x8::ONE;
        let chosen = self.chosen();
        if !chosen.any() {
            return sample_uniform_triangle(u);
        }
        let by_solid_angle = u[0].lt(self.part);
        // A part of 1 leaves nothing to draw by area, one of 0 nothing else: those numbers are not used.
        let rest = chosen.select((u[0] - self.part) / (one - self.part), u[0]);
        let by_area = sample_uniform_triangle([by_solid_angle.select(F32x8::ZERO, rest), u[1]]);
        let first = by_solid_angle.select(u[0] / self.part, F32x8::ZERO);
        let weights = self.sample_solid_angle([first, u[1]]);
        [0, 1, 2].each(
            #[inline(always)]
            |i: usize| by_solid_angle.select(weights[i], by_area[i]),
        )
    }

    /// Densities per steradian of [`SolidAngles::sample`] where drawing by area alone would have density `pdf_by_area`.
    #[inline(always)]
    pub fn pdf_dir(&self, pdf_by_area: F32x8) -> F32x8 {
        let (one, chosen) = (F32x8::ONE, self.chosen());
        if !chosen.any() {
            return pdf_by_area;
        }
        let pdf = F32x8::splat(0.5 * INV_2PI) / self.half_turns;
        let mixed = self.part * pdf + (one - self.part) * pdf_by_area;
        chosen.select(self.part.lt(one).select(mixed, pdf), pdf_by_area)
    }

    /// Barycentric weights of points, uniform by solid angle.
    #[inline(always)]
    pub fn sample_solid_angle(&self, u: [F32x8; 2]) -> [F32x8; 3] {
        let (zero, one, two) = (F32x8::ZERO, F32x8::ONE, F32x8::splat(2.0));
        let [ab, bc, ca] = self.cosine;
        // Lanes that are not chosen may hold anything; the sine wants a turn.
        let half_turns = self.chosen().select(self.half_turns, zero);
        let (sine, cosine) = sin_cos_turns(u[0] * half_turns);
        let alpha = self.volume * cosine - (bc + ca) * sine;
        let gamma = (one + ab) * sine;
        let tau = gamma / (alpha + gamma);
        let bend = one - ca;
        let k = two * (one - tau * bend) / (one - two * tau * (one - tau) * bend);
        let (from_a, from_c) = (k * (one - tau) - one, k * tau);
        let bend = one - (from_a * ab + from_c * bc);
        let t = (u[1] * (two - u[1] * bend) / (two - bend)).sqrt();
        let from_b = (one - t) + bend * (t - u[1]);
        let [ia, ib, ic] = self.inverse_distance;
        let weights = [(t * from_a).max(zero) * ia, from_b.max(zero) * ib, (t * from_c).max(zero) * ic];
        let scale = one / (weights[0] + weights[1] + weights[2]);
        let (v, w) = (weights[1] * scale, weights[2] * scale);
        [(one - v - w).max(zero), v, w]
    }
}
