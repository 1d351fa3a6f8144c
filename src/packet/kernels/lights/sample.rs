//! Light sampling for eight surface points at a time.

use super::here;
use crate::sampler::draws::LightDraws;
use crate::tables::lights::patches::LearnedPatches;
use crate::tables::lights::table::{EnvironmentLight, LightTable, LightTextures};
use crate::tables::lights::targets::{FREE_PART, MISSED};
use here::kernels::alpha_masks::opaque;
use here::kernels::lights::choose::{Choice, Light8, choose, probability};
use here::kernels::lights::delta::sample_deltas;
use here::kernels::lights::environment::{map_pdf_dir, sample_learned, sample_map};
use here::kernels::lights::light_sample::LightSamples;
use here::kernels::lights::tree::Receivers;
use here::kernels::lights::triangle::solid_angles;
use here::kernels::records::LightColumns;
use here::kernels::surface::{SurfacePoints, barycentric_point};
use here::kernels::texture::{interpolate, look_up};
use here::kernels::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, to_world};
use here::lanes::{Each, F32x8, Mask8, U32x8, Vec3x8};
use here::walks::aim::{aim, precise_lanes};

/// Draws a light sample for every lane; only lanes of `active` are asked for. `row`: as [`Receivers::row`].
#[inline(always)]
pub fn sample_lights(
    lights: &LightTable,
    points: &SurfacePoints,
    row: U32x8,
    active: Mask8,
    draws: &LightDraws<U32x8, F32x8>,
) -> LightSamples {
    let receivers = Receivers { origin: points.origin, normal: points.normal, row };
    let choice = choose(lights, &receivers, active, draws.select);
    let Some(environment) = lights.environment else { return sample_chosen(lights, &receivers, &choice, draws.point) };
    let words = environment_words(lights, choice.word, draws.fork());
    let learned = lights.learned_patches().map(|patches| (patches, row));
    let a = sample_environment(environment, learned, points, &choice, words, draws.point);
    if lights.count() == 0 {
        return a;
    }
    let b = sample_chosen(lights, &receivers, &choice, draws.point);
    LightSamples::select(choice.environment, a, b)
}

/// The radiance that lights (`record`: their records) emit at points of them; 0 where they are cut out.
#[inline(always)]
pub fn emitted(lights: &LightTable, light: U32x8, record: &LightColumns, weights: [F32x8; 3]) -> Vec3x8 {
    let radiance = record.radiance;
    match &lights.textures {
        None => radiance,
        Some(textures) => textured(textures, light, radiance, weights),
    }
}

/// [`emitted`] where lights have textures or are cut out; not inlined, so that other scenes keep their registers.
#[inline(never)]
fn textured(textures: &LightTextures, light: U32x8, radiance: Vec3x8, weights: [F32x8; 3]) -> Vec3x8 {
    here::run(
        #[inline(always)]
        || {
            let at = light.to_array();
            let corner = |i: usize| F32x8::from_array(at.map(|light| textures.uvs[light as usize][i / 2][i % 2]));
            let uv = interpolate(
                [0, 1, 2, 3, 4, 5].each(
                    #[inline(always)]
                    |i| corner(i),
                ),
                weights,
            );
            let radiance = radiance * look_up(&textures.textures, U32x8::gather(&textures.texture, light), uv);
            let Some((table, triangle)) = &textures.alpha_masks else { return radiance };
            let opaque = opaque(table, U32x8::gather(triangle, light), weights[1], weights[2]);
            opaque.select_vec3(radiance, Vec3x8::splat([0.0; 3]))
        },
    )
}

/// What arrives from the lights that were chosen.
#[inline(always)]
fn sample_chosen(lights: &LightTable, receivers: &Receivers, choice: &Choice, u: [F32x8; 2]) -> LightSamples {
    match lights.deltas {
        [] => sample_emitters(lights, receivers, choice, u),
        // A copy, so that the choice need not lie in memory elsewhere.
        _ => sample_any(lights, receivers, Choice { ..*choice }, u),
    }
}

/// [`sample_chosen`] where some lights are delta lights. Not inlined, so that other scenes keep their registers; called cold, they
/// keep them in the right places, too.
#[cold]
#[inline(never)]
fn sample_any(lights: &LightTable, receivers: &Receivers, choice: Choice, u: [F32x8; 2]) -> LightSamples {
    here::run(
        #[inline(always)]
        || {
            let first = U32x8::splat(lights.records.len() as u32);
            // Lanes of the environment have number 0, whichever light that is.
            let is_emitter = choice.emitter.lt_signed(first);
            let number = is_emitter.select_u32(U32x8::ZERO, choice.emitter - first);
            let deltas = sample_deltas(lights.deltas, number, receivers, &choice);
            if !is_emitter.any() {
                return deltas;
            }
            let emitter = is_emitter.select_u32(choice.emitter, U32x8::ZERO);
            let emitters = sample_emitters(lights, receivers, &Choice { emitter, ..choice }, u);
            LightSamples::select(is_emitter, emitters, deltas)
        },
    )
}

/// Points on the emitters that were chosen.
#[inline(always)]
fn sample_emitters(lights: &LightTable, receivers: &Receivers, choice: &Choice, u: [F32x8; 2]) -> LightSamples {
    let light = LightColumns::gather(&lights.records, choice.emitter);
    let pdf_area = light.pdf_area();
    let solid_angles = solid_angles(&light.vertices, pdf_area, receivers.origin);
    let weights = solid_angles.sample(u);
    let to_light = barycentric_point(&light.vertices, weights) - receivers.origin;
    let distance_squared = to_light.dot(to_light);
    let direction = to_light.scale(F32x8::ONE / distance_squared.sqrt());
    let cosine = receivers.normal.dot(direction);
    let mut light_cosine = -light.normal.dot(direction);
    if lights.two_sided {
        let behind = light.two_sided() & light_cosine.lt(F32x8::ZERO);
        light_cosine = behind.select(-light_cosine, light_cosine);
    }
    let by_area = pdf_area * distance_squared / light_cosine;
    let pdf_dir = choice.probability * solid_angles.pdf_dir(by_area);
    let zero = F32x8::ZERO;
    let valid = distance_squared.gt(zero) & cosine.gt(zero) & light_cosine.gt(zero) & pdf_dir.gt(zero);
    let height_squared = light_cosine * light_cosine * distance_squared;
    let near = valid.and_not(height_squared.gt(F32x8::splat(lights.targets.far)));
    let (shadow_tmax, target) = if near.any() {
        ends(lights, choice.emitter, &light.vertices, (receivers.origin, to_light), near)
    } else {
        (F32x8::splat(FREE_PART), choice.emitter)
    };
    LightSamples {
        direction,
        valid,
        cosine,
        radiance: emitted(lights, choice.emitter, &light, weights),
        pdf_dir,
        shadow_direction: to_light,
        shadow_tmax,
        target,
    }
}

/// Where shadow rays end and what they are sent to; those of `near` where closest hits would find the emitters, by the same
/// test.
#[inline(never)]
fn ends(
    lights: &LightTable,
    emitter: U32x8,
    vertices: &[Vec3x8; 3],
    (origin, to_light): (Vec3x8, Vec3x8),
    near: Mask8,
) -> (F32x8, U32x8) {
    here::run(
        #[inline(always)]
        || {
            let classes = lights.targets.classes(emitter.to_array());
            let (hit, t) = aim(origin, to_light, vertices, near, classes);
            let end = (near & hit).select(t, F32x8::ONE);
            let precise = match classes {
                Some(classes) => precise_lanes(classes),
                None => Mask8::NONE,
            };
            (
                precise.select(end, end * F32x8::splat(FREE_PART)),
                near.and_not(hit).select_u32(emitter | U32x8::splat(MISSED), emitter),
            )
        },
    )
}

/// Densities per steradian with which [`sample_lights`] would have drawn, for `receivers`, the points that rays hit at
/// distances `t` on emitters `light` (`record`: their records) under `light_cosine`.
#[inline(always)]
pub fn light_pdf_dir(
    lights: &LightTable,
    (receivers, active): (&Receivers, Mask8),
    (light, record): (U32x8, &LightColumns),
    t: F32x8,
    light_cosine: F32x8,
) -> F32x8 {
    let probability = probability(lights, receivers, active, Light8::Emitters(light));
    let pdf_area = record.pdf_area();
    let solid_angles = solid_angles(&record.vertices, pdf_area, receivers.origin);
    probability * solid_angles.pdf_dir(pdf_area * (t * t) / light_cosine)
}

/// The words that choose texels of an environment map, where choosing a light leaves `word`. Where there was something to
/// choose, three of its bits are spent: the first three of `fork` replace them.
#[inline(always)]
pub fn environment_words(lights: &LightTable, word: U32x8, fork: U32x8) -> [U32x8; 2] {
    if lights.count() == 0 { [word, fork] } else { [word | fork >> 29, fork << 3] }
}

/// A constant environment is sampled by a cosine hemisphere about the surface normals, a map by its radiance, and by what was
/// `learned` of its patches for these rows.
#[inline(always)]
fn sample_environment(
    environment: EnvironmentLight,
    learned: Option<(&LearnedPatches, U32x8)>,
    points: &SurfacePoints,
    choice: &Choice,
    words: [U32x8; 2],
    u: [F32x8; 2],
) -> LightSamples {
    let (direction, radiance, map_pdf) = match environment {
        EnvironmentLight::Constant(radiance) => {
            (to_world(sample_cosine_hemisphere(u), points.normal), Vec3x8::splat(radiance), None)
        }
        EnvironmentLight::Map(map, distribution) => match learned {
            None => {
                let (direction, texels) = sample_map(map, distribution, words, u);
                (direction, texels.radiance, Some(map_pdf_dir(distribution, &texels)))
            }
            Some((patches, row)) => {
                let (direction, texels, ratio) = sample_learned(map, patches, row, words, u);
                (direction, texels.radiance, Some(map_pdf_dir(distribution, &texels) * ratio))
            }
        },
    };
    // From the rounded directions, as the BSDF will see them.
    let cosine = points.normal.dot(direction);
    let pdf_dir = map_pdf.unwrap_or(cosine_hemisphere_pdf_dir(cosine));
    LightSamples {
        valid: cosine.gt(F32x8::ZERO) & pdf_dir.gt(F32x8::ZERO),
        direction,
        cosine,
        radiance,
        pdf_dir: choice.probability * pdf_dir,
        shadow_direction: direction,
        shadow_tmax: F32x8::splat(f32::INFINITY),
        target: U32x8::ZERO,
    }
}
