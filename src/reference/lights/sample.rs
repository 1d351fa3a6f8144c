//! Light sampling: choose a light, choose a point or a direction, and say with which density.

use super::alpha_masks::is_opaque;
use super::choose::{Light, choose, probability};
use super::delta::sample_delta;
use super::environment::{map_pdf_dir, sample_map, sample_texel, texel_index};
use super::intersect::{Ray, hit_triangle};
use super::light_sample::{LightSample, Target};
use super::surface::{SurfacePoint, barycentric_point};
use super::texture::{interpolate, look_up};
use super::tree::Receiver;
use super::triangle::solid_angle;
use super::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, sample_uniform_triangle, to_world};
use super::{Real, Vec3, vec3};
use crate::bvh::precise::PRECISE;
use crate::fault::lost_digits;
use crate::sampler::draws::LightDraws;
use crate::tables::lights::table::{EnvironmentLight, LightTable, LightTextures};
use crate::tables::lights::targets::FREE_PART;
use crate::tables::textures::NO_TEXTURE;

/// Draws a light sample; `None` if it cannot contribute (below the horizon, behind the light). `row`: as [`Receiver::row`].
pub fn sample_light(
    lights: &LightTable,
    point: &SurfacePoint,
    row: u32,
    draws: &LightDraws<u32, f32>,
) -> Option<LightSample> {
    let receiver = Receiver { origin: point.origin, normal: point.normal, row };
    let (light, probability, word) = choose(lights, &receiver, draws.select);
    let u = draws.point.map(|u| u as Real);
    match light {
        Light::Environment => {
            let words = environment_words(lights, word, draws.fork());
            sample_environment(lights, point, row, probability, words, u)
        }
        Light::Emitter(light) => match lights.delta(light) {
            Some(delta) => sample_delta(delta, point, probability),
            None => sample_emitter(lights, point, probability, light, u),
        },
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
    let to_light = barycentric_point(&light.vertices, weights) - point.origin;
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
    if !(cosine > 0.0 && light_cosine > 0.0) {
        return None;
    }
    let by_area = pdf_area * distance_squared / light_cosine * lost_digits(Real::EPSILON as f64) as Real;
    let pdf_dir = probability * solid_angle.map_or(by_area, |solid_angle| solid_angle.pdf_dir(by_area));
    if !(pdf_dir > 0.0) {
        return None;
    }
    let radiance = emitted(lights, chosen, weights);
    let height_squared = light_cosine * light_cosine * distance_squared;
    let (target, shadow_tmax) = match height_squared > lights.targets.far as Real {
        true => (Target::Emitter, FREE_PART as Real),
        false => aim(lights, chosen, point.origin, to_light),
    };
    Some(LightSample {
        direction,
        cosine,
        radiance,
        survival: 1.0,
        pdf_dir,
        delta: false,
        shadow_direction: to_light,
        shadow_tmax,
        target,
    })
}

/// Where a shadow ray to an emitter nearby ends: where closest hits would find that, by the same test; 2^-17 of the way before
/// it, unless the emitter is precise. Rays that always ended a little before the point they were sent to (as everywhere else:
/// pbrt-v4, section 6.8.6) lost 14 % of the light of a lamp 10,000 times longer than wide.
fn aim(lights: &LightTable, chosen: u32, origin: Vec3, direction: Vec3) -> (Target, Real) {
    let (targets, vertices) = (&lights.targets, lights.records[chosen as usize].vertices);
    let id = targets.triangle[chosen as usize];
    let ray = Ray { origin, direction, tmin: 0.0, tmax: Real::INFINITY };
    let class = targets.class(chosen);
    let free_part = if class & PRECISE != 0 { 1.0 } else { FREE_PART as Real };
    match hit_triangle(&ray, vertices, id, class) {
        Some(hit) if hit.t > 0.0 => {
            (if class & PRECISE != 0 { Target::Triangle(id) } else { Target::Emitter }, hit.t * free_part)
        }
        _ => (Target::Missed(targets.passed(chosen)), free_part),
    }
}

/// The words that choose a texel of an environment map, where choosing a light leaves `word`. Where there was something to
/// choose, three of its bits are spent: the first three of `fork` replace them.
pub fn environment_words(lights: &LightTable, word: u32, fork: u32) -> [u32; 2] {
    if lights.count() == 0 { [word, fork] } else { [word | fork >> 29, fork << 3] }
}

/// A constant environment is sampled by a cosine hemisphere about the surface normal, a map by its radiance; by what was learned
/// for `row`, if anything was.
fn sample_environment(
    lights: &LightTable,
    point: &SurfacePoint,
    row: u32,
    probability: Real,
    words: [u32; 2],
    u: [Real; 2],
) -> Option<LightSample> {
    let (direction, radiance, map_pdf) = match lights.environment? {
        EnvironmentLight::Constant(radiance) => {
            (to_world(sample_cosine_hemisphere(u), point.normal), vec3(radiance), None)
        }
        EnvironmentLight::Map(map, distribution) => match lights.learned_patches() {
            None => {
                let (direction, texel) = sample_map(map, distribution, words, u);
                (direction, vec3(texel.radiance), Some(map_pdf_dir(distribution, &texel)))
            }
            Some(patches) => {
                let (index, ratio) = patches.choose(row, words);
                let (direction, texel) = sample_texel(map, index, u);
                let pdf_dir = map_pdf_dir(distribution, &texel) * ratio as Real;
                (direction, vec3(texel.radiance), Some(pdf_dir))
            }
        },
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
        survival: 1.0,
        pdf_dir: probability * pdf_dir,
        delta: false,
        shadow_direction: direction,
        shadow_tmax: Real::INFINITY,
        target: Target::Environment,
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
            let index = texel_index(map, direction);
            let texel = &map.texels[index];
            let pdf_dir = map_pdf_dir(distribution, texel);
            let ratio =
                lights.learned_patches().map(|patches| patches.ratio_of_texel(receiver.row, index as u32) as Real);
            (vec3(texel.radiance), ratio.map_or(pdf_dir, |ratio| pdf_dir * ratio))
        }
    };
    Some((radiance, probability(lights, receiver, Light::Environment) * pdf_dir))
}
