//! Stages: metals, plastics and glass.

use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use crate::math::INV_2PI;
use crate::packet::bsdf::microfacet::fresnel_dielectric;
use crate::packet::bsdf::{Glossy, MaterialColumns};
use crate::packet::plan::Plan;
use crate::packet::queues::{COUNTS_ONE, COUNTS_ZERO, PathQueue, ShadowQueue, Slots, SurfaceQueue, TileState};
use crate::packet::stages::shade_common::{
    Bounce, add_light_samples, bsdf_words, draw_light, go_on, load_facing_hits, load_hits,
};
use crate::packet::surface::gather_records;
use crate::packet::texture::look_up;
use crate::packet::warp::{sample_uniform_hemisphere, to_local, to_world};
use crate::sampler::{ALL_WORDS, LOBE_WORDS, unit_x8};
use crate::settings::Strategy;
use crate::setup::Setup;

/// Metals, for the strategy with number `STRATEGY`; `event` events lie before this one.
pub fn shade_conductor<const STRATEGY: u8, const DETAIL: bool>(
    setup: &Setup,
    plan: &Plan,
    state: &mut TileState,
    event: u32,
) {
    let TileState { conductor, next, shadow, slots, .. } = state;
    shade_glossy::<crate::packet::bsdf::Conductor, STRATEGY, DETAIL>(
        setup,
        plan,
        (conductor, slots),
        (shadow, next),
        event,
    );
}

/// Plastics, for the strategy with number `STRATEGY`.
pub fn shade_plastic<const STRATEGY: u8, const DETAIL: bool>(
    setup: &Setup,
    plan: &Plan,
    state: &mut TileState,
    event: u32,
) {
    let TileState { plastic, next, shadow, slots, .. } = state;
    shade_glossy::<crate::packet::bsdf::Plastic, STRATEGY, DETAIL>(
        setup,
        plan,
        (plastic, slots),
        (shadow, next),
        event,
    );
}

/// A glossy kind: light sample, BSDF sample, roulette.
#[inline(always)]
fn shade_glossy<G: Glossy, const STRATEGY: u8, const DETAIL: bool>(
    setup: &Setup,
    plan: &Plan,
    (queue, slots): (&SurfaceQueue, &Slots),
    (shadow, next): (&mut ShadowQueue, &mut PathQueue),
    event: u32,
) {
    let strategy = Strategy::ALL[STRATEGY as usize];
    let last = event + 1 == setup.max_depth;
    for first in (0..queue.len).step_by(LANES) {
        let hits = load_facing_hits::<DETAIL>(setup, queue, slots, first);
        let columns = gather_records(&setup.scene.materials, hits.points.material);
        let mut material = MaterialColumns::new(&columns);
        if DETAIL && setup.scene.features.textures {
            material.color = material.color * look_up(&setup.scene.textures, columns[14].to_bits(), hits.points.uv);
        }
        let normal = hits.points.normal;
        let wo = to_local(-hits.direction, normal);
        let mut light_chosen = Mask8::NONE;
        if strategy.samples_lights() && plan.needs.shadow {
            let direct = draw_light::<DETAIL>(setup, strategy, &hits, event);
            light_chosen = direct.chosen;
            let scattered = G::evaluate(&material, wo, to_local(direct.light.direction, normal));
            add_light_samples(plan, strategy, &hits, &direct, (scattered.f_cosine, scattered.pdf_dir), shadow);
        }
        if last && !plan.last_drawn_counts {
            continue;
        }
        let words = bsdf_words::<ALL_WORDS>(setup, &hits, event);
        let u = [unit_x8(words[0]), unit_x8(words[1])];
        let (wi, factor, pdf_dir, valid) = if strategy == Strategy::Uniform {
            let wi = sample_uniform_hemisphere(u);
            let factor = G::evaluate(&material, wo, wi).f_cosine.scale(F32x8::splat(1.0 / INV_2PI));
            (wi, factor, F32x8::splat(INV_2PI), Mask8::ALL)
        } else {
            let sampled = G::sample(&material, wo, u, unit_x8(words[2]));
            (sampled.wi, sampled.factor, sampled.pdf_dir, sampled.valid)
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
            beta: hits.beta * factor,
            pdf_dir,
            cosine: wi.z,
            flags: light_chosen.select_u32(U32x8::splat(COUNTS_ZERO), U32x8::ZERO),
        };
        go_on(setup, plan, &hits, &bounce, words[3], event + 1, next);
    }
}

/// Smooth glass: reflected with the Fresnel probability, else refracted (pbrt-v4 sections 9.3.3 and 9.5).
pub fn shade_dielectric<const STRATEGY: u8, const DETAIL: bool>(
    setup: &Setup,
    plan: &Plan,
    state: &mut TileState,
    event: u32,
) {
    let TileState { dielectric, next, slots, .. } = state;
    if event + 1 == setup.max_depth && !plan.last_delta_counts {
        return;
    }
    let one = F32x8::ONE;
    for first in (0..dielectric.len).step_by(LANES) {
        let hits = load_hits::<DETAIL>(setup, dielectric, slots, first);
        let material = MaterialColumns::new(&gather_records(&setup.scene.materials, hits.points.material));
        let normal = hits.points.normal;
        let words = bsdf_words::<LOBE_WORDS>(setup, &hits, event);
        let eta = hits.points.front.select(material.ior, one / material.ior);
        let incoming = if DETAIL { hits.points.graze(hits.direction) } else { hits.direction };
        let cosine = -incoming.dot(normal);
        let (reflectance, cosine_t) = fresnel_dielectric(cosine, eta);
        let reflects = unit_x8(words[2]).lt(reflectance);
        let reflected = incoming - normal.scale(F32x8::splat(2.0) * incoming.dot(normal));
        let scale = one / eta;
        let refracted = incoming.scale(scale) + normal.scale(cosine * scale - cosine_t);
        let direction = reflects.select_vec3(reflected, refracted);
        // Radiance is divided by the square of the relative index: it comes from another solid angle.
        let factor = reflects.select_vec3(Vec3x8::splat([1.0; 3]), material.color.scale(scale * scale));
        let direction = if DETAIL { hits.points.to_consistent_hemisphere(direction) } else { direction };
        let through = direction.dot(hits.points.geometric_normal).lt(F32x8::ZERO);
        let bounce = Bounce {
            active: hits.active,
            origin: through.select_vec3(hits.points.origin_behind, hits.points.origin),
            direction,
            beta: hits.beta * factor,
            pdf_dir: one,
            cosine: F32x8::ZERO,
            flags: U32x8::splat(COUNTS_ONE),
        };
        go_on(setup, plan, &hits, &bounce, words[3], event + 1, next);
    }
}
