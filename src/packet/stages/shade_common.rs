//! What all surface stages share: loading eight hits, finishing light samples, going on.

use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use crate::packet::lights::sample::{LightSamples, sample_lights};
use crate::packet::mis;
use crate::packet::plan::Plan;
use crate::packet::queues::{PathQueue, ShadowQueue, Slots, SurfaceQueue, append_rays};
use crate::packet::surface::{SurfacePoints, surface_points};
use crate::sampler::{ALL_WORDS, LIGHT_WORDS, bsdf_block, light_block, sample_words_x8, unit_x8};
use crate::settings::Strategy;
use crate::setup::Setup;

/// Eight hits with all that shading reads.
pub(super) struct Hits {
    pub active: Mask8,
    pub points: SurfacePoints,
    pub direction: Vec3x8,
    pub beta: Vec3x8,
    pub slot: U32x8,
    pub pixel: U32x8,
    pub sample: U32x8,
}

/// Hits `first .. first + 8` of a queue.
#[inline(always)]
pub(super) fn load_hits<const DETAIL: bool>(setup: &Setup, queue: &SurfaceQueue, slots: &Slots, first: usize) -> Hits {
    let active = Mask8::first((queue.len - first).min(LANES));
    // Idle lanes hold what an earlier tile left there; row 0 is always safe to read instead.
    let triangle = active.select_u32(U32x8::load(&queue.triangle, first), U32x8::splat(queue.triangle[0]));
    let slot = active.select_u32(U32x8::load(&queue.slot, first), U32x8::splat(queue.slot[0]));
    let direction = queue.direction.load(first);
    let (u, v) = (F32x8::load(&queue.u, first), F32x8::load(&queue.v, first));
    let points = surface_points::<DETAIL>((&setup.scene.triangles, &setup.scene.corners), triangle, u, v, direction);
    let (pixel, sample) = (U32x8::gather(&slots.pixel, slot), U32x8::gather(&slots.sample, slot));
    Hits { active, points, direction, beta: queue.beta.load(first), slot, pixel, sample }
}

/// [`load_hits`] for surfaces on which the viewer must be above the shading normal.
#[inline(always)]
pub(super) fn load_facing_hits<const DETAIL: bool>(
    setup: &Setup,
    queue: &SurfaceQueue,
    slots: &Slots,
    first: usize,
) -> Hits {
    let mut hits = load_hits::<DETAIL>(setup, queue, slots, first);
    if DETAIL {
        hits.points.face(-hits.direction);
    }
    hits
}

/// Light samples of eight hits.
pub(super) struct DirectLight {
    /// The samples; only lanes of `active` were asked for and can contribute.
    pub light: LightSamples,
    pub active: Mask8,
    /// Lanes in which the one-sample strategy's coin chose the light.
    pub chosen: Mask8,
}

/// Draws the light samples that `strategy` wants.
#[inline(always)]
pub(super) fn draw_light<const DETAIL: bool>(
    setup: &Setup,
    strategy: Strategy,
    hits: &Hits,
    event: u32,
) -> DirectLight {
    let one_sample = strategy == Strategy::MisOneSample;
    let block = light_block(event);
    let words = if one_sample || setup.lights.environment.is_some() {
        sample_words_x8::<ALL_WORDS>(setup.sampler, hits.pixel, hits.sample, block, setup.seed)
    } else {
        sample_words_x8::<LIGHT_WORDS>(setup.sampler, hits.pixel, hits.sample, block, setup.seed)
    };
    let chosen = if one_sample { unit_x8(words[3]).lt(F32x8::splat(0.5)) } else { Mask8::NONE };
    let wanted = if one_sample { hits.active & chosen } else { hits.active };
    let light = sample_lights(&setup.lights, &hits.points, wanted, words);
    let mut active = wanted & light.valid;
    if DETAIL {
        active = active & light.direction.dot(hits.points.geometric_normal).gt(F32x8::ZERO);
    }
    DirectLight { light, active, chosen }
}

/// Puts light samples that can contribute into the shadow queue, finished but for their visibility. `f_cosine`: BSDF times
/// cosine towards the lights; `pdf_bsdf`: the density with which the BSDF itself would have drawn those directions.
#[inline(always)]
pub(super) fn add_light_samples(
    plan: &Plan,
    strategy: Strategy,
    hits: &Hits,
    direct: &DirectLight,
    (f_cosine, pdf_bsdf): (Vec3x8, F32x8),
    shadow: &mut ShadowQueue,
) {
    let light = &direct.light;
    let weight = light_sample_weight(strategy, light.pdf_dir, pdf_bsdf);
    let contribution = (hits.beta * f_cosine * light.radiance).scale(weight / light.pdf_dir);
    let nothing = (contribution.x + contribution.y + contribution.z).eq(F32x8::ZERO);
    let bits = direct.active.and_not(nothing).bits();
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

/// The numbers of eight BSDF samples: two to place the direction, one for the lobe, one for roulette. `NEEDED`: which of
/// them are read ([`crate::sampler::sample_words_x8`]).
#[inline(always)]
pub(super) fn bsdf_words<const NEEDED: u8>(setup: &Setup, hits: &Hits, event: u32) -> [U32x8; 4] {
    sample_words_x8::<NEEDED>(setup.sampler, hits.pixel, hits.sample, bsdf_block(event), setup.seed)
}

/// Eight directions to go on in.
pub(super) struct Bounce {
    /// Lanes that have one.
    pub active: Mask8,
    /// Where the rays start.
    pub origin: Vec3x8,
    /// Unit directions.
    pub direction: Vec3x8,
    /// Throughput after the event.
    pub beta: Vec3x8,
    /// Densities per steradian.
    pub pdf_dir: F32x8,
    /// Cosines between directions and normals.
    pub cosine: F32x8,
    /// Flags of [`crate::packet::queues::PathQueue::slot`].
    pub flags: U32x8,
}

/// Plays roulette after event number `depth` and puts the survivors into the next queue.
#[inline(always)]
pub(super) fn go_on(
    setup: &Setup,
    plan: &Plan,
    hits: &Hits,
    bounce: &Bounce,
    roulette_word: U32x8,
    depth: u32,
    next: &mut PathQueue,
) {
    let survival = bounce.beta.max_element();
    // Below the normal numbers a throughput is as good as none, and would no longer shrink.
    let mut alive = bounce.active & survival.ge(F32x8::splat(f32::MIN_POSITIVE));
    let mut beta = bounce.beta;
    if depth >= setup.rr_depth {
        let survival = survival.min(F32x8::ONE);
        alive = alive & unit_x8(roulette_word).lt(survival);
        beta = beta.scale(F32x8::ONE / survival);
    }
    let (bits, at) = (alive.bits(), next.len);
    append_rays(&mut next.rays, at, bounce.origin, bounce.direction, bits);
    next.beta.append(at, beta, bits);
    if plan.needs.pdf {
        bounce.pdf_dir.compress(bits).store(&mut next.pdf_dir, at);
    }
    if plan.needs.cosine {
        bounce.cosine.compress(bits).store(&mut next.cosine, at);
    }
    if plan.needs.normal {
        next.normal.append(at, hits.points.normal, bits);
    }
    (hits.slot | bounce.flags).compress(bits).store(&mut next.slot, at);
    next.len += bits.count_ones() as usize;
}
