//! The engines against each other: scalar and packets, one thread and several, walk and walk, on the suite's scenes.

use crate::check::item::{Check, Effort};
use crate::check::row::Outcome;
use crate::check::shots::walks_that_differ;
use crate::check::trial::{Trial, small};
use crate::check::twin::Differing;
use crate::check::{geometry, lights, scale, transport};
use crate::error::Result;
use crate::packet;
use crate::packet::plan::Plan;
use crate::reference::{path_steps, single};
use crate::render::render;
use crate::settings::{Lights, PlanChoice, Sampler, Settings, Train};
use crate::setup::Setup;
use crate::strategy::Strategy;
use crate::trace::first_difference;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "engines", what: "scales", run: scales },
    Check { group: "engines", what: "lights", run: lights },
    Check { group: "engines", what: "transport", run: transport },
    Check { group: "engines", what: "geometry", run: geometry },
    Check { group: "engines", what: "paths_in_closed_meshes", run: paths_in_closed_meshes },
    Check { group: "engines", what: "skies", run: skies },
    Check { group: "engines", what: "strategies_lights_and_samplers", run: strategies_lights_and_samplers },
    Check { group: "engines", what: "threads", run: threads },
    Check { group: "engines", what: "walks", run: walks },
    Check { group: "engines", what: "plans", run: plans },
];

/// Scenes by name and numbers.
type Cases = &'static [(&'static str, &'static [f64])];

/// Maps of one texel.
const SKIES: Cases =
    &[("texel", &[64.0, 0.0, 128.0, 3.0]), ("texel", &[64.0, 20.0, 128.0, 0.0]), ("texel", &[1.0, 0.0, 1.0, 0.0])];

/// Both engines on `cases`, by one strategy with weights and one without.
fn compare(effort: &Effort, cases: Cases, usual: u32) -> Result<Outcome> {
    let mut differing = Differing::default();
    for &(name, numbers) in cases {
        let trial = Trial::new(name, numbers)?;
        for (strategy, sampler) in [(Strategy::MisPower, Sampler::Sobol), (Strategy::Nee, Sampler::Independent)] {
            let spp = effort.samples(usual, 2);
            let settings = Settings { strategy, sampler, max_depth: Some(16), ..small(16, spp) };
            differing.engines(&format!("{}, {strategy}", trial.prepared.name), &trial.prepared, &settings);
        }
    }
    Ok(outcome(differing))
}

fn outcome(differing: Differing) -> Outcome {
    let what = format!("samples of {} pictures by both engines, pixels whose bits differ", differing.pictures);
    Outcome::at_most(differing.pixels as f64, 0.0)
        .tried(differing.samples, what)
        .note(differing.what)
        .trace(differing.trace)
}

fn scales(effort: &Effort) -> Result<Outcome> {
    compare(effort, scale::CASES, 2)
}

fn lights(effort: &Effort) -> Result<Outcome> {
    compare(effort, lights::CASES, 2)
}

fn transport(effort: &Effort) -> Result<Outcome> {
    compare(effort, transport::CASES, 2)
}

fn geometry(effort: &Effort) -> Result<Outcome> {
    compare(effort, geometry::CASES, 2)
}

fn skies(effort: &Effort) -> Result<Outcome> {
    compare(effort, SKIES, 4)
}

/// Where hits are decided by the smallest margins and nothing is seen, ray by ray.
fn paths_in_closed_meshes(effort: &Effort) -> Result<Outcome> {
    let meshes: [(&str, &[f64]); 11] = [
        ("corridor", &[1e2]),
        ("corridor", &[1e3]),
        ("corridor", &[1e4]),
        ("corridor", &[1e5]),
        ("corridor", &[1e6]),
        ("hollow", &[1.0, 1.0, 1e3, 1.0, 1.0, 0.0]),
        ("hollow", &[1.0, 1.0, 1e4, 1.0, 1.0, 0.0]),
        ("hollow", &[1.0, 1.0, 1e-7, 0.0, 1.0, 0.0]),
        ("cylinder", &[100.0, 10.0, 1.0]),
        ("spindle", &[300.0]),
        ("room_on_ground", &[1e6]),
    ];
    let (mut differ, mut rays, mut note, mut trace) = (0, 0, String::new(), None);
    for (name, numbers) in meshes {
        let trial = Trial::new(name, numbers)?;
        let settings = Settings { max_depth: Some(60), rr_depth: None, seed: 3, ..small(8, effort.samples(1, 1)) };
        let setup = Setup::new(&trial.prepared, &settings);
        let plan = Plan::new(&setup);
        for (pixel, sample) in (0..64).flat_map(|p| (0..settings.spp).map(move |sample| ((p % 8, p / 8), sample))) {
            let mut vertices = Vec::new();
            single::path::trace_path(&setup, pixel, sample, &mut |vertex| vertices.push(vertex));
            let (scalar, packet) = (path_steps(&vertices), packet::trace::trace_path(&setup, &plan, pixel, sample));
            rays += scalar.len() as u64;
            if let Some((depth, value)) = first_difference(&scalar, &packet) {
                if differ == 0 {
                    note = format!("{}: {value} at depth {depth}", trial.prepared.name);
                    trace = Some(trial.trace(&settings, pixel, sample));
                }
                differ += 1;
            }
        }
    }
    Ok(Outcome::at_most(f64::from(differ), 0.0)
        .tried(rays, "rays in 11 closed meshes by both engines, paths that differ")
        .note(note)
        .trace(trace))
}

fn strategies_lights_and_samplers(effort: &Effort) -> Result<Outcome> {
    let mut differing = Differing::default();
    let cases: Cases = &[("room", &[1.0, 0.0, 1.0 / 2048.0]), ("lamps", &[12.0]), ("parted_lamps", &[9.0])];
    for &(name, numbers) in cases {
        let trial = Trial::new(name, numbers)?;
        for &strategy in Strategy::ALL {
            for &lights in Lights::ALL {
                for &sampler in Sampler::ALL {
                    let spp = effort.samples(4, 2);
                    // Long enough to learn something on so small a film.
                    let train = Train::Paths(8192);
                    let settings = Settings { strategy, lights, train, sampler, max_depth: Some(5), ..small(12, spp) };
                    let what = format!("{name}, {strategy}, {lights}, {sampler}");
                    differing.engines(&what, &trial.prepared, &settings);
                }
            }
        }
    }
    Ok(outcome(differing))
}

/// One thread and three, on films of many tiles.
fn threads(effort: &Effort) -> Result<Outcome> {
    let mut differing = Differing::default();
    let cases: [(&str, &[f64]); 4] = [
        ("room", &[1.0, 0.0, 1.0 / 2048.0]),
        ("furnace", &[0.9, 0.1]),
        ("lamps", &[30.0]),
        ("hollow", &[1.0, 1.0, 100.0, 1.0, 1.0, 0.0]),
    ];
    for (name, numbers) in cases {
        let trial = Trial::new(name, numbers)?;
        for sampler in [Sampler::Sobol, Sampler::Independent] {
            let one = Settings { sampler, max_depth: Some(8), ..small(96, effort.samples(3, 1)) };
            let three = Settings { threads: 3, ..one.clone() };
            let films = [&render(&trial.prepared, &one).film, &render(&trial.prepared, &three).film];
            differing.add(name, &trial.prepared, &one, films);
        }
    }
    let Differing { pixels, what, samples, pictures, .. } = differing;
    let tried = format!("samples of {pictures} pictures by 1 and 3 threads, pixels whose bits differ");
    Ok(Outcome::at_most(pixels as f64, 0.0).tried(samples, tried).note(what))
}

/// The plan that each scene needs and the one that any scene may need.
fn plans(effort: &Effort) -> Result<Outcome> {
    let mut differing = Differing::default();
    let cases = [scale::CASES, lights::CASES, transport::CASES, geometry::CASES, SKIES];
    for &(name, numbers) in cases.into_iter().flatten() {
        let trial = Trial::new(name, numbers)?;
        let own = Settings { max_depth: Some(16), ..small(16, effort.samples(2, 1)) };
        let general = Settings { plan: PlanChoice::General, ..own.clone() };
        let films = [&render(&trial.prepared, &own).film, &render(&trial.prepared, &general).film];
        differing.add(&trial.prepared.name, &trial.prepared, &own, films);
    }
    let Differing { pixels, what, samples, pictures, .. } = differing;
    let tried = format!("samples of {pictures} pictures by their own and the general plan, pixels whose bits differ");
    Ok(Outcome::at_most(pixels as f64, 0.0).tried(samples, tried).note(what))
}

/// Every walk through the tree and through the list of leaves, rays at vertices and edges.
fn walks(effort: &Effort) -> Result<Outcome> {
    let (mut differ, mut count, mut notes) = (0, 0, Vec::new());
    for (seed, &(name, numbers)) in geometry::CASES.iter().chain(scale::CASES).enumerate() {
        let trial = Trial::new(name, numbers)?;
        let shot = effort.cases(4_000);
        let different = walks_that_differ(&trial.prepared, shot, seed as u32);
        if different > 0 {
            notes.push(format!("{}: {different}", trial.prepared.name));
        }
        (differ, count) = (differ + different, count + shot);
    }
    let scenes = geometry::CASES.len() + scale::CASES.len();
    Ok(Outcome::at_most(differ as f64, 0.0)
        .tried(count, format!("rays in {scenes} scenes by every walk, hits whose bits differ"))
        .note(notes.join(", ")))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (
            MissingCosine,
            &[
                "engines/scales",
                "engines/lights",
                "engines/transport",
                "engines/geometry",
                "engines/skies",
                "engines/strategies_lights_and_samplers",
                "engines/threads",
            ],
        ),
        (ScalarDensity, &["engines/paths_in_closed_meshes", "engines/geometry"]),
        (ForgottenShadowRays, &["engines/strategies_lights_and_samplers"]),
        (BlindWalk, &["engines/walks"]),
        (BentCorners, &["engines/plans"]),
    ]
};
