//! Stages: diffuse surfaces and mirrors, one queue and one stage a material kind. Each draws a light sample (whose
//! contribution is finished here and goes to the shadow queue), then the direction to go on in, then plays roulette.

use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use crate::math::INV_2PI;
use crate::packet::plan::Plan;
use crate::packet::queues::{COUNTS_ONE, COUNTS_ZERO, TileState};
use crate::packet::stages::shade_common::{
    Bounce, add_light_samples, bsdf_words, draw_light, go_on, load_facing_hits, load_hits,
};
use crate::packet::texture::look_up;
use crate::packet::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, sample_uniform_hemisphere, to_world};
use crate::sampler::{DIRECTION_WORDS, ROULETTE_WORD, unit_x8};
use crate::settings::Strategy;
use crate::setup::Setup;
use crate::tables::materials::MaterialRecord;

#[inline(always)]
fn colors(materials: &[MaterialRecord], material: U32x8) -> Vec3x8 {
    let at = material.to_array();
    let rows: [[f32; 3]; LANES] = std::array::from_fn(|lane| materials[at[lane] as usize].color);
    let column = |c: usize| F32x8::from_array(std::array::from_fn(|lane| rows[lane][c]));
    Vec3x8::new(column(0), column(1), column(2))
}

/// Diffuse surfaces, for the strategy with number `STRATEGY` and the `sobol` or the `independent` sampler; `event` events lie before this one.
pub fn shade_diffuse<const STRATEGY: u8, const DETAIL: bool>(
    setup: &Setup,
    plan: &Plan,
    state: &mut TileState,
    event: u32,
) {
    let strategy = Strategy::ALL[STRATEGY as usize];
    let TileState { diffuse, next, shadow, slots, .. } = state;
    let last = event + 1 == setup.max_depth;
    for first in (0..diffuse.len).step_by(LANES) {
        let hits = load_hits::<DETAIL>(setup, diffuse, slots, first);
        let mut color = colors(&setup.scene.materials, hits.points.material);
        if DETAIL && setup.scene.features.textures {
            let material = hits.points.material.to_array();
            let texture = U32x8::from_array(material.map(|m| setup.scene.materials[m as usize].texture));
            color = color * look_up(&setup.scene.textures, texture, hits.points.uv);
        }
        let mut light_chosen = Mask8::NONE;
        if strategy.samples_lights() && plan.needs.shadow {
            let direct = draw_light::<DETAIL>(setup, strategy, &hits, event);
            light_chosen = direct.chosen;
            // Lambert: albedo/pi times cosine; cosine/pi is also the density of the BSDF's own sampling.
            let pdf_bsdf = cosine_hemisphere_pdf_dir(direct.light.cosine);
            add_light_samples(plan, strategy, &hits, &direct, (color.scale(pdf_bsdf), pdf_bsdf), shadow);
        }
        if last && !plan.last_drawn_counts {
            continue;
        }
        let words = bsdf_words::<DIRECTION_WORDS>(setup, &hits, event);
        let u = [unit_x8(words[0]), unit_x8(words[1])];
        let (local, factor) = if strategy == Strategy::Uniform {
            let local = sample_uniform_hemisphere(u);
            (local, color.scale(cosine_hemisphere_pdf_dir(local.z)).scale(F32x8::splat(1.0 / INV_2PI)))
        } else {
            (sample_cosine_hemisphere(u), color)
        };
        let direction = to_world(local, hits.points.normal);
        let active = if DETAIL { hits.active & hits.points.in_consistent_hemisphere(direction) } else { hits.active };
        let bounce = Bounce {
            active: if last { active.and_not(light_chosen) } else { active },
            origin: hits.points.origin,
            direction,
            beta: hits.beta * factor,
            pdf_dir: cosine_hemisphere_pdf_dir(local.z),
            cosine: local.z,
            flags: light_chosen.select_u32(U32x8::splat(COUNTS_ZERO), U32x8::ZERO),
        };
        go_on(setup, plan, &hits, &bounce, words[3], event + 1, next);
    }
}

/// Mirrors: the one possible direction. After it light sampling could not have worked, so the next hit counts 1.
pub fn shade_mirror<const STRATEGY: u8, const DETAIL: bool>(
    setup: &Setup,
    plan: &Plan,
    state: &mut TileState,
    event: u32,
) {
    let TileState { mirror, next, slots, .. } = state;
    if event + 1 == setup.max_depth && !plan.last_delta_counts {
        return;
    }
    for first in (0..mirror.len).step_by(LANES) {
        let hits = load_facing_hits::<DETAIL>(setup, mirror, slots, first);
        let normal = hits.points.normal;
        let words = bsdf_words::<ROULETTE_WORD>(setup, &hits, event);
        let reflected = hits.direction - normal.scale(F32x8::splat(2.0) * hits.direction.dot(normal));
        let bounce = Bounce {
            active: hits.active,
            origin: hits.points.origin,
            direction: if DETAIL { hits.points.to_consistent_hemisphere(reflected) } else { reflected },
            beta: hits.beta * colors(&setup.scene.materials, hits.points.material),
            pdf_dir: F32x8::ONE,
            cosine: F32x8::ZERO,
            flags: U32x8::splat(COUNTS_ONE),
        };
        go_on(setup, plan, &hits, &bounce, words[3], event + 1, next);
    }
}
