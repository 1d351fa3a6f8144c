//! Light sampling for eight surface points at a time.

use super::here;
use crate::sampler::draws::LightDraws;
use crate::tables::lights::patches::LearnedPatches;
use crate::tables::lights::table::{EnvironmentLight, LightTable, LightTextures};
use crate::tables::lights::targets::{FREE_PART, MISSED};
use here::kernels::alpha_masks::opaque;
use here::kernels::lights::choose::{Choice, Light8, choose, probability};
use here::kernels::lights::delta::sample_any;
use here::kernels::lights::environment::{map_pdf_dir, sample_learned, sample_map};
use here::kernels::lights::tree::Receivers;
use here::kernels::lights::triangle::solid_angles;
use here::kernels::records::LightColumns;
use here::kernels::surface::{SurfacePoints, barycentric_point};
use here::kernels::texture::{interpolate, look_up};
use here::kernels::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, to_world};
use here::lanes::{Each, F32x8, Mask8, U32x8, Vec3x8};
use here::walks::aim::{aim, precise_lanes};

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
    /// The emitters they aim at, with [`MISSED`] where rounding makes them miss, or the delta lights, with
    /// [`DELTA`](crate::tables::lights::targets::DELTA).
    pub target: U32x8,
}

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
    let Some(environment) = lights.environment else { return sample_chosen(lights, points, &choice, draws.point) };
    let words = environment_words(lights, choice.word, draws.fork());
    let learned = lights.learned_patches().map(|patches| (patches, row));
    let a = sample_environment(environment, learned, points, &choice, words, draws.point);
    if lights.count() == 0 {
        return a;
    }
    let b = sample_chosen(lights, points, &choice, draws.point);
    let sky = choice.environment;
    LightSamples {
        valid: (sky & a.valid) | b.valid.and_not(sky),
        direction: sky.select_vec3(a.direction, b.direction),
        cosine: sky.select(a.cosine, b.cosine),
        radiance: sky.select_vec3(a.radiance, b.radiance),
        pdf_dir: sky.select(a.pdf_dir, b.pdf_dir),
        shadow_direction: sky.select_vec3(a.shadow_direction, b.shadow_direction),
        shadow_tmax: sky.select(a.shadow_tmax, b.shadow_tmax),
        target: sky.select_u32(a.target, b.target),
    }
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
fn sample_chosen(lights: &LightTable, points: &SurfacePoints, choice: &Choice, u: [F32x8; 2]) -> LightSamples {
    match lights.deltas {
        [] => sample_emitters(lights, points, choice, u),
        _ => sample_any(lights, points, choice, u),
    }
}

/// Points on the emitters that were chosen.
#[inline(always)]
pub fn sample_emitters(lights: &LightTable, points: &SurfacePoints, choice: &Choice, u: [F32x8; 2]) -> LightSamples {
    let light = LightColumns::gather(&lights.records, choice.emitter);
    let pdf_area = light.pdf_area();
    let solid_angles = solid_angles(&light.vertices, pdf_area, points.origin);
    let weights = solid_angles.sample(u);
    let to_light = barycentric_point(&light.vertices, weights) - points.origin;
    let distance_squared = to_light.dot(to_light);
    let direction = to_light.scale(F32x8::ONE / distance_squared.sqrt());
    let cosine = points.normal.dot(direction);
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
        ends(lights, choice.emitter, &light.vertices, (points.origin, to_light), near)
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
