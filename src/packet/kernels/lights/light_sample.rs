//! What eight light samples are.

use super::here;
use here::lanes::{F32x8, Mask8, U32x8, Vec3x8};

/// Eight light samples as seen from eight surface points.
pub struct LightSamples {
    /// Lanes whose sample can contribute; the others hold anything.
    pub valid: Mask8,
    /// Unit directions to the lights.
    pub direction: Vec3x8,
    /// Cosines at the surfaces.
    pub cosine: F32x8,
    /// Radiance that arrives if nothing is in between, over the probability with which roulette has let it be looked for, once
    /// that was played.
    pub radiance: Vec3x8,
    /// Densities per steradian, selection included; of delta lights the selection alone.
    pub pdf_dir: F32x8,
    /// The segments that must be free, from the points' ray origins (not normalised).
    pub shadow_direction: Vec3x8,
    /// Where they end: where they hit the precise triangles they aim at, a little before common ones.
    pub shadow_tmax: F32x8,
    /// The emitters they aim at, with [`MISSED`](crate::tables::lights::targets::MISSED) where rounding makes them miss, or the delta lights, with
    /// [`DELTA`](crate::tables::lights::targets::DELTA).
    pub target: U32x8,
}

impl LightSamples {
    /// Lane by lane, `if first { a } else { b }`.
    #[inline(always)]
    pub fn select(first: Mask8, a: LightSamples, b: LightSamples) -> LightSamples {
        LightSamples {
            valid: (first & a.valid) | b.valid.and_not(first),
            direction: first.select_vec3(a.direction, b.direction),
            cosine: first.select(a.cosine, b.cosine),
            radiance: first.select_vec3(a.radiance, b.radiance),
            pdf_dir: first.select(a.pdf_dir, b.pdf_dir),
            shadow_direction: first.select_vec3(a.shadow_direction, b.shadow_direction),
            shadow_tmax: first.select(a.shadow_tmax, b.shadow_tmax),
            target: first.select_u32(a.target, b.target),
        }
    }
}
