//! What is written down: `converge.csv`, one row a run, and `converge.json`, everything.
//!
//! `converge.json` is one [`Results`], field by field under the names of this file:
//!
//! ```text
//! version, simd, command       the build and what to type to get all this again
//! machine                      {cpu, cores, os}
//! scene, film, threads, seed, max_depth (null: unbounded), rr_depth (null: off)
//! finished                     false after an interrupt: fewer runs than were asked for
//! budgets                      samples a pixel, or wall seconds, as asked for
//! regions                      [{name, x, y, width, height}]
//! cases[]                      one a light: {light, reference: {kind, ..}, noise_mse, noise_relmse, mean}
//! configurations[]             {strategy, lights, sampler, engine, biased_by_design}
//! findings[]                   one a case and configuration: the fields of Finding; indices count from 0 in the lists above
//! runs[]                       one a run: indices, seed, spp, seconds, errors, rays, lanes
//! equal_time[]                 the pictures of the report: {case, configuration, spp, cpu_seconds, relmse}
//! ```

use std::fmt::Write;

use serde::Serialize;

use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::findings::Finding;
use crate::report::measure::experiment::{Budget, Experiment, Measurements, Run};
use crate::report::measure::machine::Machine;
use crate::report::measure::metrics::FLOOR;
use crate::report::measure::truth::{Reference, Source};

/// Everything a `converge` call found.
#[derive(Serialize)]
pub struct Results<'a> {
    version: &'static str,
    simd: &'static str,
    /// What was typed.
    pub command: &'a str,
    /// Where it ran.
    pub machine: &'a Machine,
    /// The scene's name.
    pub scene: &'a str,
    film: (u32, u32),
    /// Worker threads; 0: one for every core.
    pub threads: usize,
    seed: u32,
    max_depth: Option<u32>,
    rr_depth: Option<u32>,
    /// All runs were made.
    pub finished: bool,
    budgets: Vec<serde_json::Value>,
    regions: Vec<RegionRow<'a>>,
    cases: Vec<CaseRow<'a>>,
    configurations: Vec<ConfigurationRow>,
    /// See [`Finding`].
    pub findings: &'a [Finding],
    runs: Vec<RunRow>,
    equal_time: Vec<ShownRow>,
}

#[derive(Serialize)]
struct RegionRow<'a> {
    name: &'a str,
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

#[derive(Serialize)]
struct CaseRow<'a> {
    light: &'a str,
    reference: &'a Source,
    /// What the reference's noise adds to every MSE, and was subtracted.
    noise_mse: f64,
    /// What it adds to every relMSE, and was subtracted.
    noise_relmse: f64,
    mean: [f64; 3],
}

#[derive(Serialize)]
struct ConfigurationRow {
    strategy: &'static str,
    lights: &'static str,
    sampler: &'static str,
    engine: &'static str,
    biased_by_design: bool,
}

#[derive(Serialize)]
struct RunRow {
    case: usize,
    configuration: usize,
    budget: usize,
    repeat: u32,
    seed: u32,
    spp: u32,
    seconds: f64,
    cpu_seconds: f64,
    mse: f64,
    relmse: f64,
    bias: f64,
    bias_se: f64,
    bias_z: f64,
    camera_rays: u64,
    bounce_rays: u64,
    shadow_rays: u64,
    lanes_used: Option<f64>,
    faults: u64,
}

#[derive(Serialize)]
struct ShownRow {
    case: usize,
    configuration: usize,
    spp: u32,
    cpu_seconds: f64,
    relmse: f64,
}

/// The noise of a reference as it enters MSE and relMSE.
pub fn noise(reference: &Reference) -> (f64, f64) {
    let image = &reference.image;
    let Some(variance) = &image.variance else { return (0.0, 0.0) };
    let (mut mse, mut relmse) = (0.0, 0.0);
    for (v, b) in variance.iter().flatten().zip(image.pixels.iter().flatten()) {
        mse += *v as f64;
        relmse += *v as f64 / ((*b as f64).powi(2) + FLOOR);
    }
    let count = 3.0 * image.pixels.len() as f64;
    (mse / count, relmse / count)
}

impl<'a> Results<'a> {
    /// Puts everything together.
    #[allow(clippy::too_many_arguments)] // each is one of the lists of the file
    pub fn new(
        experiment: &'a Experiment,
        references: &'a [Reference],
        measured: &Measurements,
        findings: &'a [Finding],
        shown: &[Shown],
        machine: &'a Machine,
        command: &'a str,
        finished: bool,
    ) -> Results<'a> {
        let settings = &experiment.settings;
        let region = |r: &'a crate::report::measure::run_error::Region| {
            let area = r.area;
            RegionRow { name: &r.name, x: area.x, y: area.y, width: area.width, height: area.height }
        };
        let case = |(case, reference): (&'a crate::report::measure::experiment::Case, &'a Reference)| {
            let (noise_mse, noise_relmse) = noise(reference);
            let mean = crate::report::measure::metrics::mean(&reference.image.pixels);
            CaseRow { light: &case.light, reference: &reference.source, noise_mse, noise_relmse, mean }
        };
        Results {
            version: env!("CARGO_PKG_VERSION"),
            simd: crate::lanes::simd_level(),
            command,
            machine,
            scene: &experiment.cases[0].desc.name,
            film: experiment.film(),
            threads: settings.threads,
            seed: settings.seed,
            max_depth: settings.max_depth,
            rr_depth: settings.rr_depth,
            finished,
            budgets: experiment.budgets.iter().map(budget).collect(),
            regions: experiment.regions.iter().map(region).collect(),
            cases: experiment.cases.iter().zip(references).map(case).collect(),
            configurations: experiment.configurations.iter().map(configuration).collect(),
            findings,
            runs: measured.runs.iter().map(run).collect(),
            equal_time: shown.iter().map(shown_row).collect(),
        }
    }
}

fn budget(budget: &Budget) -> serde_json::Value {
    match budget {
        Budget::Spp(spp) => serde_json::json!({ "spp": spp }),
        Budget::Time(time) => serde_json::json!({ "seconds": time.as_secs_f64() }),
    }
}

fn configuration(of: &crate::report::measure::experiment::Configuration) -> ConfigurationRow {
    ConfigurationRow {
        strategy: of.strategy.name(),
        lights: of.lights.name(),
        sampler: of.sampler.name(),
        engine: of.engine.name(),
        biased_by_design: of.strategy.is_biased(),
    }
}

fn run(run: &Run) -> RunRow {
    let [camera_rays, bounce_rays, shadow_rays] = run.rays;
    RunRow {
        case: run.case,
        configuration: run.configuration,
        budget: run.budget,
        repeat: run.repeat,
        seed: run.seed,
        spp: run.spp,
        seconds: run.seconds,
        cpu_seconds: run.cpu_seconds,
        mse: run.error.mse,
        relmse: run.error.relmse,
        bias: run.error.bias,
        bias_se: run.error.bias_se,
        bias_z: run.error.bias_z(),
        camera_rays,
        bounce_rays,
        shadow_rays,
        lanes_used: run.lanes_used,
        faults: run.faults,
    }
}

fn shown_row(shown: &Shown) -> ShownRow {
    let Shown { case, configuration, spp, cpu_seconds, relmse, .. } = *shown;
    ShownRow { case, configuration, spp, cpu_seconds, relmse }
}

/// `converge.csv`: one row a run, in the order in which they ran. `mse` and `relmse` have the reference's noise subtracted,
/// so of a run as good as the reference they may come out below 0; means over runs are right.
pub fn csv(experiment: &Experiment, measured: &Measurements) -> String {
    let mut text = String::from("strategy,lights,sampler,engine,spp,seed,seconds,cpu_seconds,mse,relmse,bias_z,light,");
    text += "repeat,rays,lanes_used\n";
    for run in &measured.runs {
        let of = experiment.configurations[run.configuration];
        let (error, rays) = (&run.error, run.rays.iter().sum::<u64>());
        let lanes = run.lanes_used.map(|lanes| format!("{lanes:.4}")).unwrap_or_default();
        let light = field(&experiment.cases[run.case].light);
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{:.6},{:.6},{:.9e},{:.9e},{:.4},{light},{},{rays},{lanes}",
            of.strategy,
            of.lights,
            of.sampler,
            of.engine,
            run.spp,
            run.seed,
            run.seconds,
            run.cpu_seconds,
            error.mse,
            error.relmse,
            error.bias_z(),
            run.repeat,
        );
    }
    text
}

/// A text field of a CSV file (RFC 4180): in quotes where it has to be.
fn field(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn odd_names_stay_one_field() {
        assert_eq!(["lamp", "a,b", "say \"x\""].map(super::field), ["lamp", "\"a,b\"", "\"say \"\"x\"\"\""]);
    }
}
