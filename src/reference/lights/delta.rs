//! Delta lights: point, spot and directional lights (pbrt-v4, sections 12.1 to 12.3). Their light comes from one direction, so
//! nothing is left to draw, and no density but the probability of the choice.

use super::light_sample::{LightSample, Target};
use super::surface::SurfacePoint;
use super::{Real, Vec3, vec3};
use crate::tables::lights::deltas::DeltaRecord;
use crate::tables::lights::targets::FREE_PART;

/// What arrives from `light`, which was chosen with this probability; `None` if it cannot contribute (below the horizon, outside
/// the cone).
pub fn sample_delta(light: &DeltaRecord, point: &SurfacePoint, probability: Real) -> Option<LightSample> {
    let distant = light.distant != 0;
    let to_light = if distant { vec3(light.position) } else { vec3(light.position) - point.origin };
    let distance_squared = to_light.dot(to_light);
    if !(distance_squared > 0.0) {
        return None;
    }
    let direction = to_light * (1.0 / distance_squared.sqrt());
    let cosine = point.normal.dot(direction);
    let strength = falloff(light, direction);
    if !(cosine > 0.0 && strength > 0.0) {
        return None;
    }
    let spread = if distant { strength } else { strength / distance_squared };
    Some(LightSample {
        direction,
        cosine,
        radiance: vec3(light.strength) * spread,
        survival: 1.0,
        pdf_dir: probability,
        delta: true,
        shadow_direction: to_light,
        shadow_tmax: if distant { Real::INFINITY } else { FREE_PART as Real },
        target: if distant { Target::Environment } else { Target::Emitter },
    })
}

/// How much of its strength the light sends against `direction`: a smooth step (pbrt-v4, section 12.2.1) in the cosine with the
/// axis. Counted from 1 down, as 1 - cos = |w - axis|^2 / 2, small cones keep their digits in f32.
fn falloff(light: &DeltaRecord, direction: Vec3) -> Real {
    let apart = direction + vec3(light.axis);
    let versine = 0.5 * apart.dot(apart);
    let t = (light.edge as Real - versine) * light.falloff as Real;
    let t = if t < 0.0 { 0.0 } else { t };
    let t = if t < 1.0 { t } else { 1.0 };
    t * t * (3.0 - 2.0 * t)
}
