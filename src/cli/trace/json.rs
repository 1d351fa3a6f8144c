//! What `octray trace --json` gives.

use crate::bvh::ray::NO_HIT;
use crate::cli::trace::Traced;
use crate::trace::{LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, LIGHT_SAMPLE_IDLE, PathStep, TraceVertex, TracedLight};
use serde::Serialize;

/// All of it. Vectors are scene units or linear Rec.709; radiances count in `radiance_unit` W sr^-1 m^-2.
#[derive(Serialize)]
pub struct Told<'a> {
    scene: &'a str,
    /// Columns and rows.
    film: (u32, u32),
    pixel: (u32, u32),
    sample: u32,
    seed: u32,
    strategy: &'static str,
    light_selection: &'static str,
    sampler: &'static str,
    /// `null`: unbounded.
    max_depth: Option<u32>,
    /// `null`: off.
    rr_depth: Option<u32>,
    radiance_unit: f64,
    /// That of the sample.
    radiance: [f32; 3],
    /// Both engines agree to the last bit.
    agree: bool,
    /// Where they part.
    first_difference: Option<Difference>,
    /// What the scalar reference did.
    steps: Vec<Step<'a>>,
    /// The rays of both engines.
    scalar: Vec<Ray>,
    packet: Vec<Ray>,
}

#[derive(Serialize)]
struct Difference {
    depth: usize,
    value: &'static str,
}

/// A triangle and the name of its material.
#[derive(Serialize)]
struct Triangle<'a> {
    id: u32,
    material: Option<&'a str>,
}

/// The light of a light sample.
#[derive(Serialize)]
struct Light<'a> {
    /// `null`: the environment, or a delta light.
    triangle: Option<Triangle<'a>>,
    /// A delta light's number and kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    delta_light: Option<(u32, &'static str)>,
    /// Of choosing it.
    probability: f64,
}

/// One step; what does not belong to its event is left out.
#[derive(Serialize)]
struct Step<'a> {
    depth: u32,
    event: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangle: Option<Triangle<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    light: Option<Light<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    t: Option<f64>,
    position: [f64; 3],
    direction: [f64; 3],
    throughput: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    emitted: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bsdf: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pdf: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pdf_other: Option<f64>,
    /// A delta lobe: it has no density.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    delta: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    weight: Option<f64>,
    /// Of surviving roulette: of the path or, if below 1, of a light sample's shadow ray.
    #[serde(skip_serializing_if = "Option::is_none")]
    survival: Option<f64>,
    /// What the step adds, or would if it were not blocked.
    #[serde(skip_serializing_if = "Option::is_none")]
    gain: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    blocked: Option<bool>,
    radiance: [f64; 3],
    #[serde(skip_serializing_if = "str::is_empty")]
    note: &'static str,
}

/// One ray as an engine has it.
#[derive(Serialize)]
struct Ray {
    origin: [f32; 3],
    direction: [f32; 3],
    throughput: [f32; 3],
    /// `null`: none was hit.
    triangle: Option<u32>,
    t: Option<f32>,
    shadow: Option<Shadow>,
    radiance: [f32; 3],
}

#[derive(Serialize)]
struct Shadow {
    direction: [f32; 3],
    contribution: [f32; 3],
    blocked: bool,
}

impl<'a> Told<'a> {
    /// All of `traced`.
    pub(super) fn new(traced: &'a Traced) -> Told<'a> {
        let settings = traced.settings;
        Told {
            scene: &traced.scene.name,
            film: traced.film,
            pixel: traced.pixel,
            sample: traced.sample,
            seed: settings.seed,
            strategy: settings.strategy.name(),
            light_selection: settings.lights.name(),
            sampler: settings.sampler.name(),
            max_depth: settings.max_depth,
            rr_depth: settings.rr_depth,
            radiance_unit: traced.radiance_unit,
            radiance: traced.radiance(),
            agree: traced.difference.is_none(),
            first_difference: traced.difference.map(|(depth, value)| Difference { depth, value }),
            steps: traced.vertices.iter().map(|vertex| step(traced, vertex)).collect(),
            scalar: traced.scalar.iter().map(ray).collect(),
            packet: traced.packet.iter().map(ray).collect(),
        }
    }
}

fn step<'a>(traced: &'a Traced, vertex: &TraceVertex) -> Step<'a> {
    let triangle = |id: u32| (id != NO_HIT).then(|| Triangle { id, material: traced.material(id) });
    let is_light = [LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, LIGHT_SAMPLE_IDLE].contains(&vertex.event);
    let brings = [LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, "emission", "environment"].contains(&vertex.event);
    let probability = vertex.probability;
    Step {
        depth: vertex.depth,
        event: vertex.event,
        triangle: triangle(vertex.triangle),
        light: vertex.light.map(|light| Light {
            triangle: match light {
                TracedLight::Triangle(id) => triangle(id),
                _ => None,
            },
            delta_light: match light {
                TracedLight::Delta(number) => Some((number, traced.delta_kinds[number as usize])),
                _ => None,
            },
            probability,
        }),
        t: (vertex.triangle != NO_HIT).then_some(vertex.t),
        position: vertex.position,
        direction: vertex.direction,
        throughput: vertex.beta,
        emitted: brings.then_some(vertex.emitted),
        bsdf: (vertex.bsdf != [0.0; 3]).then_some(vertex.bsdf),
        pdf: (vertex.pdf > 0.0 && vertex.pdf.is_finite()).then_some(vertex.pdf),
        pdf_other: brings.then_some(vertex.pdf_other),
        delta: vertex.pdf == f64::INFINITY,
        weight: brings.then_some(vertex.weight),
        survival: match is_light {
            true => (vertex.survival < 1.0).then_some(vertex.survival),
            false => (probability > 0.0).then_some(probability),
        },
        gain: brings.then_some(vertex.gain),
        blocked: is_light.then_some(vertex.event == LIGHT_SAMPLE_BLOCKED),
        radiance: vertex.radiance,
        note: vertex.note,
    }
}

fn ray(step: &PathStep) -> Ray {
    let shadow = |shadow: crate::trace::ShadowStep| Shadow {
        direction: shadow.direction,
        contribution: shadow.contribution,
        blocked: shadow.blocked,
    };
    Ray {
        origin: step.origin,
        direction: step.direction,
        throughput: step.beta,
        triangle: (step.triangle != NO_HIT).then_some(step.triangle),
        t: step.t.is_finite().then_some(step.t),
        shadow: step.shadow.map(shadow),
        radiance: step.radiance,
    }
}
