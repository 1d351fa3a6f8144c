//! Stage: surfaces whose directions are drawn from a density. Each hit draws a light sample (whose contribution is finished
//! here and goes to the shadow queue), then the direction to go on in, then plays roulette.

use super::here;
use crate::math::INV_2PI;
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{COUNTS_ZERO, Slots, TileState};
use crate::strategy::TABLE;
use crate::tables::guide::PART;
use here::kernels::bsdf::{Bsdf, Sampled};
use here::kernels::guide::{Going, Places, note};
use here::kernels::records::MaterialColumns;
use here::kernels::stages::shade_common::{Bounce, add_light_samples, draw_light, draw_numbers, go_on, load_hits};
use here::kernels::texture::look_up;
use here::kernels::warp::{
    cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, sample_uniform_hemisphere, to_local, to_world,
};
use here::lanes::{F32x8, LANES, Mask8, U32x8};

/// Hits on surfaces of the kind `B`, for the strategy with number `STRATEGY`. `DETAIL`: some surface of the scene is smooth or
/// textured. `LEARNED`: the kind is diffuse, and its directions are guided, or roulette goes by what was learned of them.
#[inline(always)]
pub fn shade_surface<B: Bsdf, const STRATEGY: usize, const DETAIL: bool, const LEARNED: bool>(
    context: &StageContext,
    state: &mut TileState,
    _: &mut Counters,
) {
    let strategy = const { &TABLE[STRATEGY] };
    let StageContext { setup, decisions, .. } = context;
    let scene = setup.scene;
    let TileState { surfaces, next, shadow, slots, records, steps, .. } = state;
    let (queue, last) = (&surfaces[B::KIND], context.is_last_event());
    for first in (0..queue.len).step_by(LANES) {
        let mut hits = load_hits::<DETAIL>(context, queue, slots, first);
        if DETAIL && B::FACES_FORWARD {
            hits.points.face_forward(-hits.direction);
        }
        hits.find_row(context, !B::KIND.row().pdf_is_cosine);
        let mut bsdf = B::load(&scene.materials, hits.points.material);
        if DETAIL && decisions.textures {
            let texture = MaterialColumns::gather_textures(&scene.materials, hits.points.material);
            *bsdf.color() = *bsdf.color() * look_up(&scene.textures, texture, hits.points.uv);
        }
        let normal = hits.points.normal;
        let wo = to_local(-hits.direction, normal);
        let places = match &setup.guide {
            Some(guide) if LEARNED => Some(Places::find(guide, hits.points.origin, normal)),
            _ => None,
        };
        let wanted =
            (strategy.strategy.samples_lights() && decisions.needs.shadow, !last || decisions.last_drawn_counts);
        let (light_draws, draws) = draw_numbers::<B, LEARNED>(context, strategy.coin, &hits.numbers, wanted);
        let mut light_chosen = Mask8::NONE;
        if let Some(light_draws) = &light_draws {
            let direct = draw_light::<DETAIL>(context, strategy.coin, &hits, light_draws);
            light_chosen = direct.chosen;
            let mut scattered = bsdf.evaluate(wo, to_local(direct.light.direction, normal));
            if let Some(places) = &places {
                scattered.pdf_dir = places.pdf_dir(direct.light.direction, scattered.pdf_dir, false).0;
            }
            add_light_samples(context, strategy.light_sample, &hits, &direct, &scattered, shadow, records);
        }
        let Some(draws) = draws else { continue };
        if let Some(places) = &places {
            let mut direction = to_world(sample_cosine_hemisphere(draws.direction), normal);
            let by_guide = places.guided & draws.lobe.lt(F32x8::splat(PART));
            if by_guide.any() {
                direction = by_guide.select_vec3(places.sample(by_guide, draws.direction), direction);
            }
            let cosine = normal.dot(direction);
            let mut above = hits.active & cosine.gt(F32x8::ZERO);
            if DETAIL {
                above = above & hits.points.in_consistent_hemisphere(direction);
            }
            let pdf_cosine = cosine_hemisphere_pdf_dir(cosine);
            let (pdf_dir, pdf_guide) = places.pdf_dir(direction, pdf_cosine, steps.is_some());
            let color = *bsdf.color();
            let bounce = Bounce {
                active: if last { above.and_not(light_chosen) } else { above },
                origin: hits.points.origin,
                direction,
                beta: hits.beta * color.scale(pdf_cosine / pdf_dir),
                pdf_dir,
                cosine,
                flags: light_chosen.select_u32(U32x8::splat(COUNTS_ZERO), U32x8::ZERO),
            };
            let worth = |slots: &Slots| match decisions.needs.inverse_pixel {
                true => {
                    let inverse = F32x8::gather(&slots.inverse_pixel, hits.slot);
                    (color.max_element(), places.expected(hits.beta * color, inverse))
                }
                false => (color.max_element(), F32x8::ZERO),
            };
            let (alive, throughput) = go_on(context, &hits, &bounce, draws.roulette, next, slots, worth);
            if let (Some(steps), false) = (&mut *steps, last) {
                let (drawn, slot) = (hits.active, hits.slot);
                let going =
                    Going { places, drawn, above, alive, slot, direction, cosine, pdf_dir, pdf_guide, throughput };
                note(&going, steps);
            }
            continue;
        }
        let Sampled { valid, wi, weight, pdf_dir } = if strategy.uniform_directions {
            let wi = sample_uniform_hemisphere(draws.direction);
            let weight = bsdf.evaluate(wo, wi).f_cosine.scale(F32x8::splat(1.0 / INV_2PI));
            Sampled { valid: Mask8::ALL, wi, weight, pdf_dir: F32x8::splat(INV_2PI) }
        } else {
            bsdf.sample(wo, &draws)
        };
        let direction = to_world(wi, normal);
        let mut active = hits.active & valid;
        if DETAIL {
            active = active & hits.points.in_consistent_hemisphere(direction);
        }
        let bounce = Bounce {
            active: if last { active.and_not(light_chosen) } else { active },
            origin: hits.points.origin,
            direction,
            beta: hits.beta * weight,
            pdf_dir,
            cosine: wi.z,
            flags: light_chosen.select_u32(U32x8::splat(COUNTS_ZERO), U32x8::ZERO),
        };
        go_on(context, &hits, &bounce, draws.roulette, next, slots, |_| (weight.max_element(), F32x8::ZERO));
    }
}
