//! What all surface stages share: loading eight hits, finishing light samples, going on.

use super::here;
use crate::fault::{Fault, planted};
use crate::learn::records::LightRecords;
use crate::packet::context::StageContext;
use crate::packet::queues::{PathQueue, ShadowQueue, Slots, SurfaceQueue};
use crate::sampler::draws::{BsdfDraws, LightDraws};
use crate::sampler::{ALL_WORDS, LIGHT_WORDS};
use crate::settings::LEAST_ALBEDO;
use crate::strategy::Weight;
use here::kernels::bsdf::{Bsdf, Scattered};
use here::kernels::columns::{SlotLanes, VectorLanes, append_rays};
use here::kernels::lights::delta::are_deltas;
use here::kernels::lights::factors::keys;
use here::kernels::lights::learn::{Samples, record};
use here::kernels::lights::light_sample::LightSamples;
use here::kernels::lights::sample::{environment_words, sample_lights};
use here::kernels::lights::tree::Receivers;
use here::kernels::lights::visibility::play_roulette;
use here::kernels::mis;
use here::kernels::surface::{Found, SurfacePoints, surface_points_on};
use here::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use here::numbers::draws::PathNumbers8;

/// Eight hits with all that shading reads.
pub(super) struct Hits {
    pub active: Mask8,
    pub points: SurfacePoints,
    pub direction: Vec3x8,
    pub beta: Vec3x8,
    pub slot: U32x8,
    pub numbers: PathNumbers8,
    /// Where what was learned of the lights is looked up: keys, and their rows ([`Hits::find_row`]).
    pub key: U32x8,
    pub row: U32x8,
}

impl Hits {
    /// Finds the rows of what was learned of the lights, if anything was. `mirrors`: on surfaces that reflect much light in
    /// about one direction.
    #[inline(always)]
    pub fn find_row(&mut self, context: &StageContext, mirrors: bool) {
        if let Some(learned) = &context.setup.lights.learned {
            let incoming = mirrors.then_some(self.direction);
            self.key = keys(&learned.grid, self.points.origin, self.points.normal, incoming);
            self.row = U32x8::gather(&learned.rows, self.key);
        }
    }
}

/// Hits `first .. first + 8` of a queue.
#[inline(always)]
pub(super) fn load_hits<const DETAIL: bool>(
    context: &StageContext,
    queue: &SurfaceQueue,
    slots: &Slots,
    first: usize,
) -> Hits {
    let StageContext { setup, decisions, .. } = context;
    let active = Mask8::first((queue.len - first).min(LANES));
    // Idle lanes hold what an earlier tile left there; row 0 is always safe to read instead.
    let triangle = active.select_u32(U32x8::load(&queue.triangle, first), U32x8::splat(queue.triangle[0]));
    let slot = active.select_u32(U32x8::load(&queue.slot, first), U32x8::splat(queue.slot[0]));
    let direction = queue.direction.load(first);
    let (u, v) = (F32x8::load(&queue.u, first), F32x8::load(&queue.v, first));
    let scene = setup.scene;
    let found = decisions.needs.positions.then(|| Found { bvh: &scene.bvh, position: queue.position.load(first) });
    let tables = (&scene.triangles[..], decisions.corners(scene));
    let points = surface_points_on::<DETAIL>(tables, found, triangle, u, v, direction);
    let (pixel, sample) = (U32x8::gather(&slots.pixel, slot), U32x8::gather(&slots.sample, slot));
    let numbers = PathNumbers8 { sampler: setup.sampler, seed: setup.seed, pixel, sample };
    Hits { active, points, direction, beta: queue.beta.load(first), slot, numbers, key: U32x8::ZERO, row: U32x8::ZERO }
}

/// Light samples of eight hits.
pub(super) struct DirectLight {
    /// The samples; only lanes of `active` were asked for and can contribute.
    pub light: LightSamples,
    pub active: Mask8,
    /// Lanes that drew one.
    pub drawn: Mask8,
    /// Lanes in which the one-sample strategy's coin chose the light.
    pub chosen: Mask8,
}

/// The numbers of a scattering event: those of the light samples that `lights` draw, and those of the directions to go on in.
/// `coin`: the strategy tosses one between the two.
#[inline(always)]
pub(super) fn draw_numbers<B: Bsdf, const LEARNED: bool>(
    context: &StageContext,
    coin: bool,
    numbers: &PathNumbers8,
    (light, bsdf): (bool, bool),
) -> (Option<LightDraws<U32x8, F32x8>>, Option<BsdfDraws<F32x8>>) {
    let (lights, event) = (&context.setup.lights, context.depth);
    let environment = lights.environment.is_some() || context.decisions.any_environment;
    let all = coin || environment || lights.visibility.is_some();
    match (light, bsdf) {
        (true, true) => {
            let (light, bsdf) = match (LEARNED, all) {
                (true, true) => numbers.light_and_bsdf::<ALL_WORDS, ALL_WORDS>(event),
                (true, false) => numbers.light_and_bsdf::<LIGHT_WORDS, ALL_WORDS>(event),
                (false, true) => B::draws_with_light::<ALL_WORDS>(numbers, event),
                (false, false) => B::draws_with_light::<LIGHT_WORDS>(numbers, event),
            };
            (Some(light), Some(bsdf))
        }
        (true, false) if all => (Some(numbers.light::<ALL_WORDS>(event)), None),
        (true, false) => (Some(numbers.light::<LIGHT_WORDS>(event)), None),
        (false, true) if LEARNED => (None, Some(numbers.bsdf::<ALL_WORDS>(event))),
        (false, true) => (None, Some(B::draws(numbers, event))),
        (false, false) => (None, None),
    }
}

/// Draws the light samples that a strategy wants; `coin`: it tosses one between them and BSDF samples.
#[inline(always)]
pub(super) fn draw_light<const DETAIL: bool>(
    context: &StageContext,
    coin: bool,
    hits: &Hits,
    draws: &LightDraws<U32x8, F32x8>,
) -> DirectLight {
    let lights = &context.setup.lights;
    let chosen = if coin { draws.coin() } else { Mask8::NONE };
    let wanted = if coin { hits.active & chosen } else { hits.active };
    let mut light = sample_lights(lights, &hits.points, hits.row, wanted, draws);
    let mut active = wanted & light.valid;
    if DETAIL {
        active = active & light.direction.dot(hits.points.geometric_normal).gt(F32x8::ZERO);
    }
    if let Some(visibility) = &lights.visibility {
        active = play_roulette(visibility, hits.points.origin, &mut light, active, draws.roulette());
    }
    DirectLight { light, active, drawn: wanted, chosen }
}

/// Puts light samples that can contribute into the shadow queue, finished but for their visibility. `rule`: what they count;
/// `scattered`: towards the lights.
#[inline(always)]
pub(super) fn add_light_samples(
    context: &StageContext,
    rule: Weight,
    hits: &Hits,
    direct: &DirectLight,
    scattered: &Scattered,
    shadow: &mut ShadowQueue,
    records: &mut Option<LightRecords>,
) {
    let light = &direct.light;
    let mut weight = mis::weigh(rule, light.pdf_dir, scattered.pdf_dir);
    if !context.setup.lights.deltas.is_empty() {
        weight = are_deltas(light.target).select(F32x8::splat(rule.of_delta_light()), weight);
    }
    let contribution = (hits.beta * scattered.f_cosine * light.radiance).scale(weight / light.pdf_dir);
    let nothing = (contribution.x + contribution.y + contribution.z).eq(F32x8::ZERO);
    let bits = direct.active.and_not(nothing).bits();
    if let Some(records) = records {
        let lights = &context.setup.lights;
        // Drawn again, so that other renders need not keep them.
        let draws = hits.numbers.light::<ALL_WORDS>(context.depth);
        let spent = if lights.count() == 0 { draws.select } else { draws.select << 3 };
        let [word, _] = environment_words(lights, spent, draws.fork());
        let samples = Samples {
            lights,
            receivers: Receivers { origin: hits.points.origin, normal: hits.points.normal, row: hits.row },
            key: hits.key,
            sample: light,
            gain: (scattered.f_cosine * light.radiance).scale(weight / light.pdf_dir),
            word,
            drawn: direct.drawn,
            traced: Mask8::from_bits(bits),
        };
        record(&samples, &mut shadow.lessons, records);
    }
    let at = shadow.len;
    append_rays(&mut shadow.rays, at, hits.points.origin, light.shadow_direction, bits);
    if context.decisions.shadow_tmax.is_none() {
        light.shadow_tmax.compress(bits).store(&mut shadow.rays.tmax, at);
        light.target.compress(bits).store(&mut shadow.target, at);
        shadow.missed |= light.target.lt_signed(U32x8::ZERO).bits() & bits != 0;
    }
    shadow.contribution.append(at, contribution, bits);
    hits.slot.compress(bits).store(&mut shadow.slot, at);
    shadow.len += bits.count_ones() as usize;
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

/// Plays roulette after the event of this round and puts the survivors into the next queue; who survives, and throughputs.
/// `worth`: where roulette goes by albedos, the largest components of these, and what is expected of the paths at least.
#[inline(always)]
pub(super) fn go_on(
    context: &StageContext,
    hits: &Hits,
    bounce: &Bounce,
    roulette: F32x8,
    next: &mut PathQueue,
    slots: &mut Slots,
    worth: impl FnOnce(&Slots) -> (F32x8, F32x8),
) -> (Mask8, Vec3x8) {
    let needs = &context.decisions.needs;
    let mut survival = bounce.beta.max_element();
    // Below the normal numbers a throughput is as good as none, and would no longer shrink.
    let mut alive = bounce.active & survival.ge(F32x8::splat(f32::MIN_POSITIVE));
    let mut beta = bounce.beta;
    let mut albedos = F32x8::ONE;
    if needs.albedo {
        let (albedo, expected) = worth(slots);
        albedos = (F32x8::gather(&slots.albedo, hits.slot) * albedo).max(F32x8::splat(LEAST_ALBEDO));
        survival = albedos.max(expected);
    }
    if context.depth + 1 >= context.setup.rr_depth {
        let survival = survival.min(F32x8::ONE);
        alive = alive & roulette.lt(survival);
        let gain = if planted(Fault::BiasedRoulette) { F32x8::splat(0.99) } else { F32x8::ONE };
        beta = beta.scale(gain / survival);
        albedos = albedos / survival;
    }
    if needs.albedo {
        slots.set_albedo(hits.slot, albedos, alive.bits());
    }
    let (bits, at) = (alive.bits(), next.len);
    append_rays(&mut next.rays, at, bounce.origin, bounce.direction, bits);
    next.beta.append(at, beta, bits);
    if needs.pdf {
        bounce.pdf_dir.compress(bits).store(&mut next.pdf_dir, at);
    }
    if needs.cosine {
        bounce.cosine.compress(bits).store(&mut next.cosine, at);
    }
    if needs.normal {
        next.normal.append(at, hits.points.normal, bits);
    }
    if needs.row {
        hits.row.compress(bits).store(&mut next.row, at);
    }
    (hits.slot | bounce.flags).compress(bits).store(&mut next.slot, at);
    next.len += bits.count_ones() as usize;
    (alive, beta)
}
