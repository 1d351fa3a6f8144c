//! Stages: surfaces, one queue and one stage a material kind. Each draws a light sample (whose contribution is finished
//! here and goes to the shadow queue), then the direction to go on in, then plays roulette.

use super::light::sample_lights;
use super::mis;
use super::plan::Plan;
use super::state::{COUNTS_ONE, COUNTS_ZERO, PathQueue, ShadowQueue, Slots, SurfaceQueue, TileState, append_rays};
use super::surface::{SurfacePoints, surface_points};
use super::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, sample_uniform_hemisphere, to_world};
use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use crate::sampler::{bsdf_block, light_block, random_words_x8, unit_x8};
use crate::scene::prepare::MaterialRecord;
use crate::settings::Strategy;
use crate::setup::Setup;

/// Eight hits with all that shading reads.
struct Hits {
    active: Mask8,
    points: SurfacePoints,
    direction: Vec3x8,
    beta: Vec3x8,
    color: Vec3x8,
    slot: U32x8,
    pixel: U32x8,
    sample: U32x8,
}

#[inline(always)]
fn load_hits(setup: &Setup, queue: &SurfaceQueue, slots: &Slots, first: usize) -> Hits {
    let active = Mask8::first((queue.len - first).min(LANES));
    // Idle lanes hold what an earlier tile left there; row 0 is always safe to read instead.
    let triangle = active.select_u32(U32x8::load(&queue.triangle, first), U32x8::splat(queue.triangle[0]));
    let slot = active.select_u32(U32x8::load(&queue.slot, first), U32x8::splat(queue.slot[0]));
    let direction = queue.direction.load(first);
    let (u, v) = (F32x8::load(&queue.u, first), F32x8::load(&queue.v, first));
    let points = surface_points(&setup.scene.triangles, triangle, u, v, direction);
    let color = colors(&setup.scene.materials, points.material);
    let (pixel, sample) = (U32x8::gather(&slots.pixel, slot), U32x8::gather(&slots.sample, slot));
    Hits { active, points, direction, beta: queue.beta.load(first), color, slot, pixel, sample }
}

#[inline(always)]
fn colors(materials: &[MaterialRecord], material: U32x8) -> Vec3x8 {
    let at = material.to_array();
    let rows: [[f32; 3]; LANES] = std::array::from_fn(|lane| materials[at[lane] as usize].color);
    let column = |c: usize| F32x8::from_array(std::array::from_fn(|lane| rows[lane][c]));
    Vec3x8::new(column(0), column(1), column(2))
}

/// Diffuse surfaces, for the strategy with number `STRATEGY`; `event` events lie before this one.
pub fn shade_diffuse<const STRATEGY: u8>(setup: &Setup, plan: &Plan, state: &mut TileState, event: u32) {
    let strategy = Strategy::ALL[STRATEGY as usize];
    let TileState { diffuse, next, shadow, slots, .. } = state;
    let bounces = event + 1 < setup.max_depth || plan.last_diffuse_counts;
    for first in (0..diffuse.len).step_by(LANES) {
        let hits = load_hits(setup, diffuse, slots, first);
        let mut light_chosen = Mask8::NONE;
        if strategy.samples_lights() && plan.needs.shadow {
            let words = random_words_x8(hits.pixel, hits.sample, light_block(event), setup.seed);
            let mut active = hits.active;
            if strategy == Strategy::MisOneSample {
                light_chosen = unit_x8(words[3]).lt(F32x8::splat(0.5));
                active = active & light_chosen;
            }
            sample_direct_light(setup, plan, strategy, &hits, active, words, shadow);
        }
        if bounces {
            let words = random_words_x8(hits.pixel, hits.sample, bsdf_block(event), setup.seed);
            let u = [unit_x8(words[0]), unit_x8(words[1])];
            let (local, beta) = if strategy == Strategy::Uniform {
                let local = sample_uniform_hemisphere(u);
                (local, hits.beta * hits.color.scale(F32x8::splat(2.0) * local.z))
            } else {
                (sample_cosine_hemisphere(u), hits.beta * hits.color)
            };
            let bounce = Bounce {
                direction: to_world(local, hits.points.normal),
                beta,
                pdf_dir: cosine_hemisphere_pdf_dir(local.z),
                flags: light_chosen.select_u32(U32x8::splat(COUNTS_ZERO), U32x8::ZERO),
            };
            let last = event + 1 == setup.max_depth;
            let active = if last { hits.active.and_not(light_chosen) } else { hits.active };
            go_on(setup, plan, &hits, active, bounce, words[3], event + 1, next);
        }
    }
}

/// Mirrors: the one possible direction. After it light sampling could not have worked, so the next hit counts 1.
pub fn shade_mirror<const STRATEGY: u8>(setup: &Setup, plan: &Plan, state: &mut TileState, event: u32) {
    let TileState { mirror, next, slots, .. } = state;
    if event + 1 == setup.max_depth && !plan.last_delta_counts {
        return;
    }
    for first in (0..mirror.len).step_by(LANES) {
        let hits = load_hits(setup, mirror, slots, first);
        let normal = hits.points.normal;
        let words = random_words_x8(hits.pixel, hits.sample, bsdf_block(event), setup.seed);
        let bounce = Bounce {
            direction: hits.direction - normal.scale(F32x8::splat(2.0) * hits.direction.dot(normal)),
            beta: hits.beta * hits.color,
            pdf_dir: F32x8::ONE,
            flags: U32x8::splat(COUNTS_ONE),
        };
        go_on(setup, plan, &hits, hits.active, bounce, words[3], event + 1, next);
    }
}

/// Draws light samples and puts those that can contribute into the shadow queue, finished but for their visibility.
#[inline(always)]
fn sample_direct_light(
    setup: &Setup,
    plan: &Plan,
    strategy: Strategy,
    hits: &Hits,
    active: Mask8,
    words: [U32x8; 4],
    shadow: &mut ShadowQueue,
) {
    let light = sample_lights(&setup.lights, &hits.points, words);
    // BSDF times cosine is albedo times cos/pi, and cos/pi is also the density of the BSDF's own sampling.
    let pdf_bsdf = cosine_hemisphere_pdf_dir(light.cosine);
    let weight = light_sample_weight(strategy, light.pdf_dir, pdf_bsdf);
    let contribution = (hits.beta * hits.color * light.radiance).scale(pdf_bsdf * weight / light.pdf_dir);
    let nothing = (contribution.x + contribution.y + contribution.z).eq(F32x8::ZERO);
    let bits = (active & light.valid).and_not(nothing).bits();
    let at = shadow.len;
    append_rays(&mut shadow.rays, at, hits.points.origin, light.shadow_direction, bits);
    if plan.shadow_tmax.is_none() {
        light.shadow_tmax.compress(bits).store(&mut shadow.rays.tmax, at);
    }
    shadow.contribution.append(at, contribution, bits);
    hits.slot.compress(bits).store(&mut shadow.slot, at);
    shadow.len += bits.count_ones() as usize;
}

/// What a light sample counts (design table, column "light samples").
#[inline(always)]
fn light_sample_weight(strategy: Strategy, pdf_light: F32x8, pdf_bsdf: F32x8) -> F32x8 {
    match strategy {
        Strategy::Uniform | Strategy::Bsdf => F32x8::ZERO,
        Strategy::NeeSum | Strategy::NeeNoEmission | Strategy::Nee => F32x8::ONE,
        Strategy::NeeAverage => F32x8::splat(0.5),
        Strategy::MisOneSample => F32x8::splat(2.0) * mis::balance(pdf_light, pdf_bsdf),
        Strategy::MisBalance => mis::balance(pdf_light, pdf_bsdf),
        Strategy::MisPower => mis::power(pdf_light, pdf_bsdf),
    }
}

/// Eight directions to go on in.
struct Bounce {
    direction: Vec3x8,
    /// Throughput after the event.
    beta: Vec3x8,
    pdf_dir: F32x8,
    flags: U32x8,
}

/// Plays roulette and puts the survivors into the next queue.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn go_on(
    setup: &Setup,
    plan: &Plan,
    hits: &Hits,
    active: Mask8,
    bounce: Bounce,
    roulette_word: U32x8,
    depth: u32,
    next: &mut PathQueue,
) {
    let survival = bounce.beta.max_element();
    // Below the normal numbers a throughput is as good as none, and would no longer shrink.
    let mut alive = active & survival.ge(F32x8::splat(f32::MIN_POSITIVE));
    let mut beta = bounce.beta;
    if depth >= setup.rr_depth {
        let survival = survival.min(F32x8::ONE);
        alive = alive & unit_x8(roulette_word).lt(survival);
        beta = beta.scale(F32x8::ONE / survival);
    }
    let (bits, at) = (alive.bits(), next.len);
    append_rays(&mut next.rays, at, hits.points.origin, bounce.direction, bits);
    next.beta.append(at, beta, bits);
    if plan.needs.pdf {
        bounce.pdf_dir.compress(bits).store(&mut next.pdf_dir, at);
    }
    (hits.slot | bounce.flags).compress(bits).store(&mut next.slot, at);
    next.len += bits.count_ones() as usize;
}
