//! Samples of delta lights, for eight surface points at a time.

use super::here;
use crate::tables::lights::deltas::DeltaRecord;
use crate::tables::lights::targets::{DELTA, FREE_PART};
use here::kernels::lights::choose::Choice;
use here::kernels::lights::light_sample::LightSamples;
use here::kernels::lights::tree::Receivers;
use here::kernels::records::DeltaColumns;
use here::lanes::{F32x8, Mask8, U32x8, Vec3x8};

/// Which of the samples that aim at `target` are of delta lights.
#[inline(always)]
pub fn are_deltas(target: U32x8) -> Mask8 {
    (target & U32x8::splat(DELTA)).eq(U32x8::splat(DELTA))
}

/// What arrives from the rows `number` of `lights`, which were chosen.
#[inline(always)]
pub fn sample_deltas(lights: &[DeltaRecord], number: U32x8, receivers: &Receivers, choice: &Choice) -> LightSamples {
    let zero = F32x8::ZERO;
    let light = DeltaColumns::gather(lights, number);
    let distant = light.distant.eq(U32x8::splat(1));
    let to_light = distant.select_vec3(light.position, light.position - receivers.origin);
    let distance_squared = to_light.dot(to_light);
    let direction = to_light.scale(F32x8::ONE / distance_squared.sqrt());
    let cosine = receivers.normal.dot(direction);
    let strength = falloff(&light, direction);
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
