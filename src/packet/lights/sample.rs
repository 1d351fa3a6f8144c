//! Light sampling for eight surface points at a time.

use crate::lanes::{F32x8, Mask8, U32x8, Vec3x8};
use crate::packet::alpha_masks::opaque;
use crate::packet::lights::environment::{map_pdf_dir, sample_map};
use crate::packet::lights::tree::{Receivers, choose_lights, environment_eighths, light_probabilities};
use crate::packet::lights::triangle::solid_angles;
use crate::packet::surface::{OFFSET_HALF_ULPS, SurfacePoints, gather_records, point_and_offset, vertices};
use crate::packet::texture::{interpolate, look_up};
use crate::packet::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, to_world};
use crate::sampler::unit_x8;
use crate::tables::lights::table::{EnvironmentLight, LightTable, LightTextures, Selection};

/// Eight light samples as seen from eight surface points.
pub struct LightSamples {
    /// Lanes whose sample can contribute; the others hold anything.
    pub valid: Mask8,
    /// Unit directions to the lights.
    pub direction: Vec3x8,
    /// Cosines at the surfaces.
    pub cosine: F32x8,
    /// Radiance that arrives if nothing is in between.
    pub radiance: Vec3x8,
    /// Densities per steradian, selection included.
    pub pdf_dir: F32x8,
    /// The segments that must be free, from the points' ray origins (not normalised).
    pub shadow_direction: Vec3x8,
    /// Where they end.
    pub shadow_tmax: F32x8,
}

/// Draws a light sample for every lane from the words of [`crate::sampler::light_block`].
#[inline(always)]
pub fn sample_lights(lights: &LightTable, points: &SurfacePoints, active: Mask8, words: [U32x8; 4]) -> LightSamples {
    let (word, fork) = (words[0], words[3] << 1);
    let u = [unit_x8(words[1]), unit_x8(words[2])];
    match (lights.environment, lights.records.is_empty()) {
        (None, _) => sample_triangles(lights, points, (active, F32x8::ONE), word, u),
        (Some(environment), true) => {
            let probability = F32x8::splat(lights.environment_probability);
            sample_environment(environment, points, probability, [word, fork], u)
        }
        (Some(environment), false) => {
            let eighths = eighths(lights, &receivers_of(points));
            let sky = (word >> 29).lt_signed(eighths);
            let probability = environment_part(lights, eighths);
            let a = sample_environment(environment, points, probability, [word << 3, fork], u);
            let b = sample_triangles(lights, points, (active.and_not(sky), triangle_part(eighths)), word << 3, u);
            LightSamples {
                valid: (sky & a.valid) | b.valid.and_not(sky),
                direction: sky.select_vec3(a.direction, b.direction),
                cosine: sky.select(a.cosine, b.cosine),
                radiance: sky.select_vec3(a.radiance, b.radiance),
                pdf_dir: sky.select(a.pdf_dir, b.pdf_dir),
                shadow_direction: sky.select_vec3(a.shadow_direction, b.shadow_direction),
                shadow_tmax: sky.select(a.shadow_tmax, b.shadow_tmax),
            }
        }
    }
}

/// The emitters that eight selection words choose where places do not matter.
#[inline(always)]
fn choose_triangles(lights: &LightTable, word: U32x8) -> U32x8 {
    match lights.selection {
        Selection::Tree(_) => unreachable!("the tree chooses by place"),
        Selection::None | Selection::Single => U32x8::ZERO,
        Selection::Uniform => word.multiply_high(U32x8::splat(lights.records.len() as u32)),
        // A table lookup a lane: the scalar rule is the lane rule.
        Selection::Alias(_) => U32x8::from_array(word.to_array().map(|word| lights.choose_triangle(word))),
    }
}

#[inline(always)]
fn receivers_of(points: &SurfacePoints) -> Receivers {
    Receivers { origin: points.origin, normal: points.normal }
}

/// How many eighths of the light samples go to the environment if the scene has triangles that emit too.
#[inline(always)]
fn eighths(lights: &LightTable, receivers: &Receivers) -> U32x8 {
    match &lights.selection {
        Selection::Tree(tree) if lights.environment.is_some() => environment_eighths(tree, receivers),
        _ => U32x8::splat(4),
    }
}

/// Under a light tree, the probabilities with which light samples go to the triangles beside an environment.
#[inline(always)]
fn triangle_part(eighths: U32x8) -> F32x8 {
    (U32x8::splat(8) - eighths).to_f32() * F32x8::splat(0.125)
}

/// The probabilities with which light samples go to the environment beside triangles.
#[inline(always)]
fn environment_part(lights: &LightTable, eighths: U32x8) -> F32x8 {
    match &lights.selection {
        Selection::Tree(_) => eighths.to_f32() * F32x8::splat(0.125),
        _ => F32x8::splat(lights.environment_probability),
    }
}

/// The probabilities with which light samples go to the environment.
#[inline(always)]
pub fn environment_probability(lights: &LightTable, receivers: &Receivers) -> F32x8 {
    environment_part(lights, eighths(lights, receivers))
}

/// The radiance that lights (`columns`: their gathered records) emit at points of them; 0 where they are cut out.
#[inline(always)]
pub fn emitted(lights: &LightTable, light: U32x8, columns: &[F32x8; 16], weights: [F32x8; 3]) -> Vec3x8 {
    let radiance = Vec3x8::new(columns[12], columns[13], columns[14]);
    match &lights.textures {
        None => radiance,
        Some(textures) => textured(textures, light, radiance, weights),
    }
}

/// [`emitted`] where lights have textures or are cut out; not inlined, so that other scenes keep their registers.
#[inline(never)]
fn textured(textures: &LightTextures, light: U32x8, radiance: Vec3x8, weights: [F32x8; 3]) -> Vec3x8 {
    let at = light.to_array();
    let corner = |i: usize| F32x8::from_array(at.map(|light| textures.uvs[light as usize][i / 2][i % 2]));
    let uv = interpolate(std::array::from_fn(corner), weights);
    let radiance = radiance * look_up(&textures.textures, U32x8::gather(&textures.texture, light), uv);
    let Some((table, triangle)) = &textures.alpha_masks else { return radiance };
    let opaque = opaque(table, U32x8::gather(triangle, light), weights[1], weights[2]);
    opaque.select_vec3(radiance, Vec3x8::splat([0.0; 3]))
}

/// The probabilities with which light samples go to emitters.
#[inline(always)]
fn selection_probabilities(lights: &LightTable, light: U32x8) -> F32x8 {
    match lights.probabilities[..] {
        [same] => F32x8::splat(same),
        _ => F32x8::gather(&lights.probabilities, light),
    }
}

/// `part`: under a light tree, the part of all light samples that go to triangles; only lanes of `active` are asked for.
#[inline(always)]
fn sample_triangles(
    lights: &LightTable,
    points: &SurfacePoints,
    (active, part): (Mask8, F32x8),
    word: U32x8,
    u: [F32x8; 2],
) -> LightSamples {
    let (chosen, probability) = match &lights.selection {
        Selection::Tree(tree) => {
            let (chosen, probability) = choose_lights(tree, &receivers_of(points), active, word);
            (chosen, probability * part)
        }
        _ => {
            let chosen = choose_triangles(lights, word);
            (chosen, selection_probabilities(lights, chosen))
        }
    };
    let columns = gather_records(&lights.records, chosen);
    let vertices = vertices(&columns);
    let solid_angles = solid_angles(&vertices, columns[15].abs(), points.origin);
    let weights = solid_angles.sample(u);
    let (position, offset) = point_and_offset(&vertices, weights, far_end(points.origin));
    let mut light_normal = Vec3x8::new(columns[9], columns[10], columns[11]);
    let to_light = position - points.position;
    let distance_squared = to_light.dot(to_light);
    let direction = to_light.scale(F32x8::ONE / distance_squared.sqrt());
    let cosine = points.normal.dot(direction);
    let mut light_cosine = -light_normal.dot(direction);
    let mut pdf_area = columns[15];
    if lights.two_sided {
        let behind = pdf_area.lt(F32x8::ZERO) & light_cosine.lt(F32x8::ZERO);
        light_cosine = behind.select(-light_cosine, light_cosine);
        light_normal = behind.select_vec3(-light_normal, light_normal);
        pdf_area = pdf_area.abs();
    }
    let by_area = pdf_area * distance_squared / light_cosine;
    let pdf_dir = probability * solid_angles.pdf_dir(by_area);
    let zero = F32x8::ZERO;
    LightSamples {
        direction,
        valid: distance_squared.gt(zero) & cosine.gt(zero) & light_cosine.gt(zero) & pdf_dir.gt(zero),
        cosine,
        radiance: emitted(lights, chosen, &columns, weights),
        pdf_dir,
        shadow_direction: (position + light_normal.scale(offset)) - points.origin,
        shadow_tmax: F32x8::ONE,
    }
}

/// What shadow rays' starts add to the offsets of their ends; see the scalar twin.
#[inline(always)]
fn far_end(origin: Vec3x8) -> F32x8 {
    let size = origin.abs();
    (size.x + size.y + size.z) * F32x8::splat(OFFSET_HALF_ULPS)
}

/// Densities per steradian with which [`sample_lights`] would have drawn, for `receivers`, the points that rays hit at
/// distances `t` on `light`s (`columns`: their gathered records) under `light_cosine`.
#[inline(always)]
pub fn light_pdf_dir(
    lights: &LightTable,
    (receivers, active): (&Receivers, Mask8),
    (light, columns): (U32x8, &[F32x8; 16]),
    t: F32x8,
    light_cosine: F32x8,
) -> F32x8 {
    let probability = match &lights.selection {
        Selection::Tree(tree) => {
            let part = match lights.environment {
                Some(_) => triangle_part(eighths(lights, receivers)),
                None => F32x8::ONE,
            };
            light_probabilities(tree, receivers, active, light) * part
        }
        _ => selection_probabilities(lights, light),
    };
    let pdf_area = columns[15].abs();
    let solid_angles = solid_angles(&vertices(columns), pdf_area, receivers.origin);
    probability * solid_angles.pdf_dir(pdf_area * (t * t) / light_cosine)
}

/// A constant environment is sampled by a cosine hemisphere about the surface normals, a map by its radiance.
/// `probability`: the part of all light samples that come here.
#[inline(always)]
fn sample_environment(
    environment: EnvironmentLight,
    points: &SurfacePoints,
    probability: F32x8,
    words: [U32x8; 2],
    u: [F32x8; 2],
) -> LightSamples {
    let (direction, radiance, map_pdf) = match environment {
        EnvironmentLight::Constant(radiance) => {
            (to_world(sample_cosine_hemisphere(u), points.normal), Vec3x8::splat(radiance), None)
        }
        EnvironmentLight::Map(map, distribution) => {
            let (direction, texels) = sample_map(map, distribution, words, u);
            (direction, texels.radiance, Some(map_pdf_dir(distribution, &texels)))
        }
    };
    // From the rounded directions, as the BSDF will see them.
    let cosine = points.normal.dot(direction);
    let pdf_dir = map_pdf.unwrap_or(cosine_hemisphere_pdf_dir(cosine));
    LightSamples {
        valid: cosine.gt(F32x8::ZERO) & pdf_dir.gt(F32x8::ZERO),
        direction,
        cosine,
        radiance,
        pdf_dir: probability * pdf_dir,
        shadow_direction: direction,
        shadow_tmax: F32x8::splat(f32::INFINITY),
    }
}
