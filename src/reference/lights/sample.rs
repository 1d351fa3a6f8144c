//! Light sampling: choose a light, choose a point or a direction, and say with which density.

use super::alpha_masks::is_opaque;
use super::choose::{Light, choose, probability};
use super::environment::{map_pdf_dir, sample_map, texel_index};
use super::surface::{OFFSET_HALF_ULPS, SurfacePoint, point_and_offset};
use super::texture::{interpolate, look_up};
use super::tree::Receiver;
use super::triangle::solid_angle;
use super::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, sample_uniform_triangle, to_world};
use super::{Real, Vec3, vec3};
use crate::fault::lost_digits;
use crate::sampler::draws::LightDraws;
use crate::tables::lights::table::{EnvironmentLight, LightTable, LightTextures};
use crate::tables::textures::NO_TEXTURE;

/// A light sample as seen from a surface point.
pub struct LightSample {
    /// Unit direction to the light.
    pub direction: Vec3,
    /// Cosine at the surface, above 0.
    pub cosine: Real,
    /// Radiance that arrives if nothing is in between.
    pub radiance: Vec3,
    /// Density per steradian, selection included, above 0.
    pub pdf_dir: Real,
    /// The segment that must be free: from the point's ray origin in this direction (not normalised) ..
    pub shadow_direction: Vec3,
    /// .. up to this parameter.
    pub shadow_tmax: Real,
}

/// Draws a light sample; `None` if it cannot contribute (below the horizon, behind the light).
pub fn sample_light(lights: &LightTable, point: &SurfacePoint, draws: &LightDraws<u32, f32>) -> Option<LightSample> {
    let receiver = Receiver { origin: point.origin, normal: point.normal };
    let (light, probability, word) = choose(lights, &receiver, draws.select);
    let u = draws.point.map(|u| u as Real);
    match light {
        Light::Environment => sample_environment(lights, point, probability, [word, draws.fork()], u),
        Light::Emitter(emitter) => sample_emitter(lights, point, probability, emitter, u),
    }
}

/// Draws a point on the emitter that was chosen with this probability.
fn sample_emitter(
    lights: &LightTable,
    point: &SurfacePoint,
    probability: Real,
    chosen: u32,
    u: [Real; 2],
) -> Option<LightSample> {
    let light = &lights.records[chosen as usize];
    let pdf_area = light.pdf_area() as Real;
    let solid_angle = solid_angle(&light.vertices, pdf_area, point.origin);
    let weights = match &solid_angle {
        Some(solid_angle) => solid_angle.sample(u),
        None => sample_uniform_triangle(u),
    };
    let (position, offset) = point_and_offset(&light.vertices, weights, far_end(point.origin));
    let to_light = position - point.position;
    let distance_squared = to_light.dot(to_light);
    if !(distance_squared > 0.0) {
        return None;
    }
    let direction = to_light * (1.0 / distance_squared.sqrt());
    let cosine = point.normal.dot(direction);
    let front_cosine = -vec3(light.normal).dot(direction);
    // The side that emits towards the point; of a light with two it is the one that faces it.
    let behind = light.two_sided() && front_cosine < 0.0;
    let light_cosine = if behind { -front_cosine } else { front_cosine };
    let light_normal = if behind { -vec3(light.normal) } else { vec3(light.normal) };
    if !(cosine > 0.0 && light_cosine > 0.0) {
        return None;
    }
    let by_area = pdf_area * distance_squared / light_cosine * lost_digits(Real::EPSILON as f64) as Real;
    let pdf_dir = probability * solid_angle.map_or(by_area, |solid_angle| solid_angle.pdf_dir(by_area));
    if !(pdf_dir > 0.0) {
        return None;
    }
    let shadow_direction = (position + light_normal * offset) - point.origin;
    let radiance = emitted(lights, chosen, weights);
    Some(LightSample { direction, cosine, radiance, pdf_dir, shadow_direction, shadow_tmax: 1.0 })
}

/// What a shadow ray's start adds to the offset of its end, for [`point_and_offset`]: the ray arrives as inexactly as it was
/// sent. Without it a light near the origin of coordinates, seen from far away, hides behind itself: a sphere of radius 0.3
/// lost 3 to 10 % of its light at 5 to 7 units.
fn far_end(origin: Vec3) -> Real {
    let size = origin.abs();
    (size.x + size.y + size.z) * OFFSET_HALF_ULPS
}

/// A constant environment is sampled by a cosine hemisphere about the surface normal, a map by its radiance.
fn sample_environment(
    lights: &LightTable,
    point: &SurfacePoint,
    probability: Real,
    words: [u32; 2],
    u: [Real; 2],
) -> Option<LightSample> {
    let (direction, radiance, map_pdf) = match lights.environment? {
        EnvironmentLight::Constant(radiance) => {
            (to_world(sample_cosine_hemisphere(u), point.normal), vec3(radiance), None)
        }
        EnvironmentLight::Map(map, distribution) => {
            let (direction, texel) = sample_map(map, distribution, words, u);
            (direction, vec3(texel.radiance), Some(map_pdf_dir(distribution, &texel)))
        }
    };
    // From the rounded direction, as the BSDF will see it.
    let cosine = point.normal.dot(direction);
    let pdf_dir = map_pdf.unwrap_or(cosine_hemisphere_pdf_dir(cosine));
    if !(cosine > 0.0 && pdf_dir > 0.0) {
        return None;
    }
    Some(LightSample {
        direction,
        cosine,
        radiance,
        pdf_dir: probability * pdf_dir,
        shadow_direction: direction,
        shadow_tmax: Real::INFINITY,
    })
}

/// The radiance that `light` emits at a point of it; 0 where it is cut out.
pub fn emitted(lights: &LightTable, light: u32, weights: [Real; 3]) -> Vec3 {
    let radiance = vec3(lights.records[light as usize].radiance);
    if let Some((table, triangle)) = lights.textures.as_ref().and_then(|textures| textures.alpha_masks.as_ref())
        && !is_opaque(table, triangle[light as usize], weights[1], weights[2])
    {
        return Vec3::ZERO;
    }
    match &lights.textures {
        Some(LightTextures { textures, texture, uvs, .. }) if texture[light as usize] != NO_TEXTURE => {
            radiance * look_up(textures, texture[light as usize], interpolate(&uvs[light as usize], weights))
        }
        _ => radiance,
    }
}

/// Density per steradian with which [`sample_light`] would have drawn, for `receiver`, the point a BSDF ray hit: at
/// distance `t`, on a side of `light` that emits, where the ray's direction makes `light_cosine` with that side's
/// (reversed) normal.
pub fn light_pdf_dir(lights: &LightTable, receiver: &Receiver, light: u32, t: Real, light_cosine: Real) -> Real {
    let probability = probability(lights, receiver, Light::Emitter(light));
    let record = &lights.records[light as usize];
    let pdf_area = record.pdf_area() as Real;
    let by_area = pdf_area * (t * t) / light_cosine * lost_digits(Real::EPSILON as f64) as Real;
    let solid_angle = solid_angle(&record.vertices, pdf_area, receiver.origin);
    probability * solid_angle.map_or(by_area, |solid_angle| solid_angle.pdf_dir(by_area))
}

/// The radiance that a ray in direction `direction` finds when it leaves the scene, and the density per steradian with
/// which [`sample_light`] would have drawn it for `receiver`, where it makes `cosine` with the normal. `None`: nothing
/// there.
pub fn environment_in_direction(
    lights: &LightTable,
    receiver: &Receiver,
    direction: Vec3,
    cosine: Real,
) -> Option<(Vec3, Real)> {
    let (radiance, pdf_dir) = match lights.environment? {
        EnvironmentLight::Constant(radiance) => (vec3(radiance), cosine_hemisphere_pdf_dir(cosine)),
        EnvironmentLight::Map(map, distribution) => {
            let texel = &map.texels[texel_index(map, direction)];
            (vec3(texel.radiance), map_pdf_dir(distribution, texel))
        }
    };
    Some((radiance, probability(lights, receiver, Light::Environment) * pdf_dir))
}
