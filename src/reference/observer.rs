//! Who is told what happens to a path: `octray trace`, tests, and the search for samples that are not finite.

use super::guide::GuidePlace;
use super::intersect::{Hit, Ray};
use super::lights::choose::{Light, choose};
use super::lights::factors::Place;
use super::lights::light_sample::LightSample;
use super::lights::tree::Receiver;
use super::surface::SurfacePoint;
use super::{Real, Vec3};
use crate::bvh::ray::NO_HIT;
use crate::tables::lights::table::LightTable;
use crate::trace::{
    COIN, END, LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, LIGHT_SAMPLE_IDLE, RAY, ROULETTE, ROULETTE_SURVIVED, TraceVertex,
    TracedLight,
};

/// A path's state.
pub struct Path {
    /// Scattering events so far.
    pub depth: u32,
    /// Throughput.
    pub beta: Vec3,
    /// Radiance gathered so far.
    pub radiance: CompensatedSum,
}

/// A sum of many terms, and what rounding has taken from it.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompensatedSum {
    sum: Vec3,
    lost: Vec3,
}

impl CompensatedSum {
    /// Adds a term together with what the last addition lost (Kahan 1965); what this one loses is exact (Knuth's two-sum).
    pub fn add(&mut self, term: Vec3) {
        let term = term + self.lost;
        let next = self.sum + term;
        let taken = next - self.sum;
        self.lost = (self.sum - (next - taken)) + (term - taken);
        self.sum = next;
    }

    /// The sum.
    pub fn value(&self) -> Vec3 {
        self.sum
    }
}

/// What happens to a path.
pub enum Event<'a> {
    /// A ray is to be traced.
    Ray(&'a Ray),
    /// It has hit nothing.
    Miss(&'a Ray),
    /// The environment it leaves to has been found.
    Environment(&'a Ray, Found),
    /// It has hit a triangle at a point.
    Hit(&'a Ray, &'a Hit, Vec3),
    /// The triangle it has hit at a point emits.
    Emission(&'a Ray, &'a Hit, Vec3, Found),
    /// A coin has chosen the light sample (true) or the BSDF sample.
    Coin(bool),
    /// A light was chosen, and its sample can bring nothing, for a reason.
    LightIdle(Choice<'a>, &'static str),
    /// A light sample; `gain` is added unless it is `blocked`.
    Light {
        /// How its light was chosen.
        choice: Choice<'a>,
        /// The sample.
        light: &'a LightSample,
        /// BSDF times cosine towards it.
        f_cosine: Vec3,
        /// The density with which the BSDF sample would have its direction.
        pdf_bsdf: Real,
        /// Its MIS weight.
        weight: Real,
        /// What it brings.
        gain: Vec3,
        /// Something is in between.
        blocked: bool,
    },
    /// A surface of the named kind has scattered the path at a point.
    Bounce(&'static str, &'a Hit, Vec3, Bounce<'a>),
    /// The direction drawn at a surface leads nowhere, for a reason; where the surface looks up what was learned of directions.
    Lost(Option<GuidePlace<'a>>, &'static str),
    /// Russian roulette has let it go on with this probability.
    Survival(&'a Hit, Vec3, Real),
    /// Russian roulette has ended it; it would have gone on with this probability.
    Roulette(&'a Hit, Vec3, Real),
    /// It ends for a reason.
    End(&'static str),
}

/// Emission that a ray has found.
pub struct Found {
    /// Its radiance.
    pub radiance: Vec3,
    /// What the path gains.
    pub gain: Vec3,
    /// Its MIS weight.
    pub weight: Real,
    /// The density with which a light sample would have had this direction.
    pub pdf_light: Real,
    /// The density with which it was drawn; `None` where no density applies.
    pub pdf_bsdf: Option<Real>,
    /// How it was found, in words.
    pub how: &'static str,
}

/// A direction that a surface has scattered the path into.
pub struct Bounce<'a> {
    /// The direction.
    pub direction: Vec3,
    /// BSDF times cosine over the density.
    pub weight: Vec3,
    /// The density per steradian.
    pub pdf_dir: Real,
    /// The lobe is a delta: the density is none.
    pub delta: bool,
    /// The cosine between direction and normal.
    pub cosine: Real,
    /// Where the surface looks up what was learned of directions, if it does.
    pub place: Option<GuidePlace<'a>>,
}

/// The choice of a light, as far as it takes to make it again: only who observes asks which it was.
#[derive(Clone, Copy)]
pub struct Choice<'a> {
    /// The lights.
    pub lights: &'a LightTable<'a>,
    /// The point that asks.
    pub point: &'a SurfacePoint,
    /// Where it looks up what was learned.
    pub place: Place,
    /// The selection word.
    pub word: u32,
    /// What chooses texels of an environment map beside it.
    pub fork: u32,
}

impl Choice<'_> {
    /// The light, and the probability with which it was chosen.
    fn made(&self) -> (TracedLight, f64) {
        let receiver = Receiver { origin: self.point.origin, normal: self.point.normal, row: self.place.row };
        let (light, probability, _) = choose(self.lights, &receiver, self.word);
        let emitters = self.lights.records.len() as u32;
        let light = match light {
            Light::Environment => TracedLight::Environment,
            Light::Emitter(light) if light < emitters => {
                TracedLight::Triangle(self.lights.targets.triangle[light as usize])
            }
            Light::Emitter(light) => TracedLight::Delta(light - emitters),
        };
        (light, probability as f64)
    }
}

/// Is told every step of a path.
pub trait Observer {
    /// `path` is the state after the event.
    fn note(&mut self, path: &Path, event: Event);
}

/// Nobody is told.
pub struct Unobserved;

impl Observer for Unobserved {
    #[inline(always)]
    fn note(&mut self, _: &Path, _: Event) {}
}

/// Functions of trace records write the events down.
impl<F: FnMut(TraceVertex)> Observer for F {
    fn note(&mut self, path: &Path, event: Event) {
        self(vertex(path, event));
    }
}

/// The trace record of an event.
fn vertex(path: &Path, event: Event) -> TraceVertex {
    let wide = |v: Vec3| [v.x as f64, v.y as f64, v.z as f64];
    let at = |event: &'static str, position: Vec3, direction: Vec3| TraceVertex {
        depth: path.depth,
        event,
        triangle: NO_HIT,
        light: None,
        t: 0.0,
        position: wide(position),
        direction: wide(direction),
        beta: wide(path.beta),
        gain: [0.0; 3],
        radiance: wide(path.radiance.value()),
        emitted: [0.0; 3],
        bsdf: [0.0; 3],
        pdf: 0.0,
        pdf_other: 0.0,
        weight: 0.0,
        probability: 0.0,
        survival: 1.0,
        note: "",
    };
    let hit_at = |event, hit: &Hit, position, direction| TraceVertex {
        triangle: hit.triangle,
        t: hit.t as f64,
        ..at(event, position, direction)
    };
    let found = |vertex: TraceVertex, found: Found| TraceVertex {
        gain: wide(found.gain),
        weight: found.weight as f64,
        emitted: wide(found.radiance),
        pdf: found.pdf_bsdf.unwrap_or(0.0) as f64,
        pdf_other: found.pdf_light as f64,
        note: found.how,
        ..vertex
    };
    let nowhere = |event| at(event, Vec3::ZERO, Vec3::ZERO);
    match event {
        Event::Ray(ray) => at(RAY, ray.origin, ray.direction),
        Event::Miss(ray) => TraceVertex { t: f64::INFINITY, ..at("miss", ray.origin, ray.direction) },
        Event::Environment(ray, what) => found(at("environment", ray.origin, ray.direction), what),
        Event::Hit(ray, hit, position) => hit_at("hit", hit, position, ray.direction),
        Event::Emission(ray, hit, position, what) => found(hit_at("emission", hit, position, ray.direction), what),
        Event::Coin(light) => TraceVertex { note: if light { "light" } else { "BSDF" }, ..nowhere(COIN) },
        Event::LightIdle(choice, note) => {
            let (light, probability) = choice.made();
            TraceVertex {
                light: Some(light),
                probability,
                note,
                ..at(LIGHT_SAMPLE_IDLE, choice.point.position, Vec3::ZERO)
            }
        }
        Event::Light { choice, light, f_cosine, pdf_bsdf, weight, gain, blocked } => {
            let event = if blocked { LIGHT_SAMPLE_BLOCKED } else { LIGHT_SAMPLE };
            let (chosen, probability) = choice.made();
            TraceVertex {
                light: Some(chosen),
                gain: wide(gain),
                emitted: wide(light.radiance),
                bsdf: wide(f_cosine),
                pdf: light.pdf_dir as f64,
                pdf_other: pdf_bsdf as f64,
                weight: weight as f64,
                probability,
                survival: light.survival as f64,
                ..at(event, choice.point.position, light.shadow_direction)
            }
        }
        Event::Bounce(kind, hit, position, bounce) => TraceVertex {
            bsdf: wide(bounce.weight),
            pdf: if bounce.delta { f64::INFINITY } else { bounce.pdf_dir as f64 },
            ..hit_at(kind, hit, position, bounce.direction)
        },
        Event::Survival(hit, position, probability) => {
            let vertex = hit_at(ROULETTE_SURVIVED, hit, position, Vec3::ZERO);
            TraceVertex { probability: probability as f64, ..vertex }
        }
        Event::Roulette(hit, position, probability) => {
            TraceVertex { probability: probability as f64, ..hit_at(ROULETTE, hit, position, Vec3::ZERO) }
        }
        Event::Lost(_, note) | Event::End(note) => TraceVertex { note, ..nowhere(END) },
    }
}
