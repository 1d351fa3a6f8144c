//! Who is told what happens to a path: `octray trace`, tests, and the search for samples that are not finite.

use super::intersect::{Hit, Ray};
use super::lights::sample::LightSample;
use super::{Real, Vec3};
use crate::bvh::ray::NO_HIT;
use crate::trace::{LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, RAY, TraceVertex};

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
    /// The environment it leaves to has added this, weighed so.
    Environment(&'a Ray, Vec3, Real),
    /// It has hit a triangle at a point.
    Hit(&'a Ray, &'a Hit, Vec3),
    /// The emitter it has hit has added this, weighed so.
    Emission(&'a Ray, &'a Hit, Vec3, Vec3, Real),
    /// A light sample from a point adds this, weighed so, unless it is blocked.
    Light(Vec3, &'a LightSample, Vec3, Real, bool),
    /// A surface of the named kind has scattered the path at a point into a direction of this density.
    Bounce(&'static str, &'a Hit, Vec3, Vec3, Real),
    /// Russian roulette has ended it.
    Roulette(&'a Hit, Vec3),
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
        t: 0.0,
        position: wide(position),
        direction: wide(direction),
        beta: wide(path.beta),
        gain: [0.0; 3],
        radiance: wide(path.radiance.value()),
        pdf: 0.0,
        weight: 0.0,
    };
    let hit_at = |event, hit: &Hit, position, direction| TraceVertex {
        triangle: hit.triangle,
        t: hit.t as f64,
        ..at(event, position, direction)
    };
    match event {
        Event::Ray(ray) => at(RAY, ray.origin, ray.direction),
        Event::Miss(ray) => TraceVertex { t: f64::INFINITY, ..at("miss", ray.origin, ray.direction) },
        Event::Environment(ray, gain, weight) => {
            let vertex = at("environment", ray.origin, ray.direction);
            TraceVertex { gain: wide(gain), weight: weight as f64, ..vertex }
        }
        Event::Hit(ray, hit, position) => hit_at("hit", hit, position, ray.direction),
        Event::Emission(ray, hit, position, gain, weight) => {
            let vertex = hit_at("emission", hit, position, ray.direction);
            TraceVertex { gain: wide(gain), weight: weight as f64, ..vertex }
        }
        Event::Light(position, light, gain, weight, blocked) => {
            let vertex =
                at(if blocked { LIGHT_SAMPLE_BLOCKED } else { LIGHT_SAMPLE }, position, light.shadow_direction);
            TraceVertex { gain: wide(gain), pdf: light.pdf_dir as f64, weight: weight as f64, ..vertex }
        }
        Event::Bounce(kind, hit, position, direction, pdf_dir) => {
            TraceVertex { pdf: pdf_dir as f64, ..hit_at(kind, hit, position, direction) }
        }
        Event::Roulette(hit, position) => hit_at("roulette", hit, position, Vec3::ZERO),
    }
}
