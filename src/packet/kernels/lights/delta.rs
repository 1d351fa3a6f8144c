//! Samples of delta lights, for eight surface points at a time.

use super::here;
use crate::tables::lights::table::LightTable;
use crate::tables::lights::targets::{DELTA, FREE_PART};
use here::kernels::lights::choose::Choice;
use here::kernels::lights::sample::{LightSamples, sample_emitters};
use here::kernels::records::DeltaColumns;
use here::kernels::surface::SurfacePoints;
use here::lanes::{F32x8, Mask8, U32x8, Vec3x8};

/// What arrives from the lights that were chosen, of which some may be emitters. Not inlined, so that scenes without delta lights
/// keep their registers; called cold, they keep them in the right places, too.
#[cold]
#[inline(never)]
pub fn sample_any(lights: &LightTable, points: &SurfacePoints, choice: &Choice, u: [F32x8; 2]) -> LightSamples {
    here::run(
        #[inline(always)]
        || {
            let first = U32x8::splat(lights.records.len() as u32);
            // Lanes of the environment have number 0, whichever light that is.
            let is_emitter = choice.emitter.lt_signed(first);
            let number = is_emitter.select_u32(U32x8::ZERO, choice.emitter - first);
            let a = sample_deltas(&DeltaColumns::gather(lights.deltas, number), points, choice);
            if !is_emitter.any() {
                return a;
            }
            let emitter = is_emitter.select_u32(choice.emitter, U32x8::ZERO);
            let b = sample_emitters(lights, points, &Choice { emitter, ..*choice }, u);
            LightSamples {
                valid: (is_emitter & b.valid) | a.valid.and_not(is_emitter),
                direction: is_emitter.select_vec3(b.direction, a.direction),
                cosine: is_emitter.select(b.cosine, a.cosine),
                radiance: is_emitter.select_vec3(b.radiance, a.radiance),
                pdf_dir: is_emitter.select(b.pdf_dir, a.pdf_dir),
                shadow_direction: is_emitter.select_vec3(b.shadow_direction, a.shadow_direction),
                shadow_tmax: is_emitter.select(b.shadow_tmax, a.shadow_tmax),
                target: is_emitter.select_u32(b.target, a.target),
            }
        },
    )
}

/// Which of the samples that aim at `target` are of delta lights.
#[inline(always)]
pub fn are_deltas(target: U32x8) -> Mask8 {
    (target & U32x8::splat(DELTA)).eq(U32x8::splat(DELTA))
}

/// What arrives from delta lights.
#[inline(always)]
fn sample_deltas(light: &DeltaColumns, points: &SurfacePoints, choice: &Choice) -> LightSamples {
    let zero = F32x8::ZERO;
    let distant = light.distant.eq(U32x8::splat(1));
    let to_light = distant.select_vec3(light.position, light.position - points.origin);
    let distance_squared = to_light.dot(to_light);
    let direction = to_light.scale(F32x8::ONE / distance_squared.sqrt());
    let cosine = points.normal.dot(direction);
    let strength = falloff(light, direction);
    let spread = distant.select(strength, strength / distance_squared);
    LightSamples {
        valid: distance_squared.gt(zero) & cosine.gt(zero) & strength.gt(zero),
        direction,
        cosine,
        radiance: light.strength.scale(spread),
        pdf_dir: choice.probability,
        shadow_direction: to_light,
        shadow_tmax: distant.select(F32x8::splat(f32::INFINITY), F32x8::splat(FREE_PART)),
        target: choice.emitter | U32x8::splat(DELTA),
    }
}

/// How much of their strength lights send against `direction`: a smooth step in the cosine with the axis, counted from 1 down.
#[inline(always)]
fn falloff(light: &DeltaColumns, direction: Vec3x8) -> F32x8 {
    let apart = direction + light.axis;
    let versine = F32x8::splat(0.5) * apart.dot(apart);
    let t = (light.edge - versine) * light.falloff;
    let t = t.lt(F32x8::ZERO).select(F32x8::ZERO, t);
    let t = t.lt(F32x8::ONE).select(t, F32x8::ONE);
    t * t * (F32x8::splat(3.0) - F32x8::splat(2.0) * t)
}
