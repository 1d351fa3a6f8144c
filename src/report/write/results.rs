//! What is written down: `converge.csv`, one row a run, and `converge.json`, everything.
//!
//! `converge.json` is one [`Results`], field by field under the names of this file:
//!
//! ```text
//! version, simd, command       the build and what to type to get all this again
//! machine                      {cpu, cores, os}
//! film, threads, seed
//! finished                     false while runs are made and after an interrupt: fewer runs than were asked for
//! reach                        the relative error that exact strategies are run to; null: none
//! epsilon, exposure            what is added to b^2 in relMSE; stops at which images are shown and PSNR and FLIP taken
//! budgets                      samples a pixel, or wall seconds, as asked for
//! regions                      [{name, x, y, width, height}]
//! cases[]                      one a scene and light: {scene (its name here), file, light, max_depth (null: unbounded),
//!                              rr_depth (null: off), reference: {kind, ..}, noise_mse, noise_relmse, mean}
//! configurations[]             {strategy, lights, guide, sampler, engine, biased_by_design}
//! others[]                     names of other renderers; as configurations they count on from ours
//! findings[]                   one a case and configuration: the fields of Finding; indices count from 0 in the lists above
//! summaries[]                  one a configuration: {configuration, geometric_mean, worst: [case, share]}
//! runs[]                       one a run: indices, seed, spp, seconds, errors, rays, lanes. `budget` counts on behind the
//!                              budgets where an error is reached for; of another renderer it is its spp, or a number of its own
//! equal_time[]                 the images of the report: {case, configuration, spp, cpu_seconds, mse, relmse, psnr, flip}
//! ```

use std::fmt::Write;

use serde::Serialize;

use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::findings::Finding;
use crate::report::analysis::summary::Summary;
use crate::report::measure::experiment::{Budget, Case, Configuration, Experiment, Measurements, Run};
use crate::report::measure::machine::Machine;
use crate::report::measure::metrics::{self, FLOOR};
use crate::report::measure::run_error::Region;
use crate::report::measure::truth::{Reference, Source};
use crate::report::write::contents::{Contents, State};

/// Everything a `converge` call found.
#[derive(Serialize)]
pub struct Results<'a> {
    version: &'static str,
    simd: &'static str,
    command: &'a str,
    machine: &'a Machine,
    film: (u32, u32),
    /// Worker threads; 0: one for every core.
    threads: usize,
    seed: u32,
    finished: bool,
    reach: Option<f64>,
    epsilon: f64,
    exposure: f64,
    budgets: Vec<serde_json::Value>,
    regions: Vec<RegionRow<'a>>,
    cases: Vec<CaseRow<'a>>,
    configurations: Vec<ConfigurationRow>,
    others: &'a [String],
    findings: &'a [Finding],
    summaries: &'a [Summary],
    runs: Vec<RunRow<'a>>,
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
    scene: &'a str,
    file: &'a str,
    light: &'a str,
    max_depth: Option<u32>,
    rr_depth: Option<u32>,
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
    guide: &'static str,
    sampler: &'static str,
    engine: &'static str,
    biased_by_design: bool,
}

#[derive(Serialize)]
struct RunRow<'a> {
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
    /// Without the worst pixel of every thousand.
    relmse_trimmed: f64,
    /// By region.
    region_relmse: &'a [f64],
    bias: f64,
    bias_se: f64,
    bias_z: f64,
    camera_rays: u64,
    bounce_rays: u64,
    shadow_rays: u64,
    lanes_used: Option<f64>,
    walk_lanes_used: Option<f64>,
    faults: u64,
}

#[derive(Serialize)]
struct ShownRow {
    case: usize,
    configuration: usize,
    spp: u32,
    cpu_seconds: f64,
    mse: f64,
    relmse: f64,
    psnr: Option<f64>,
    flip: f64,
}

impl<'a> Results<'a> {
    /// Puts everything together.
    pub fn new(contents: &Contents<'a>) -> Results<'a> {
        let experiment = contents.experiment;
        let settings = &experiment.settings;
        let region = |r: &'a Region| {
            let area = r.area;
            RegionRow { name: &r.name, x: area.x, y: area.y, width: area.width, height: area.height }
        };
        let case = |(case, reference): (&'a Case, &'a Reference)| {
            let (noise_mse, noise_relmse) = reference.noise();
            let mean = metrics::mean(&reference.image.pixels);
            let &Case { max_depth, rr_depth, .. } = case;
            let (scene, file, light) = (&case.scene_name, &case.desc.name, &case.light);
            CaseRow {
                scene,
                file,
                light,
                max_depth,
                rr_depth,
                reference: &reference.source,
                noise_mse,
                noise_relmse,
                mean,
            }
        };
        Results {
            version: env!("CARGO_PKG_VERSION"),
            simd: crate::simd::simd_level(),
            command: contents.command,
            machine: contents.machine,
            film: experiment.film(),
            threads: settings.threads,
            seed: settings.seed,
            finished: contents.state == State::Finished,
            reach: experiment.reach,
            epsilon: FLOOR,
            exposure: experiment.exposure,
            budgets: experiment.budgets.iter().map(budget).collect(),
            regions: experiment.regions.iter().map(region).collect(),
            cases: experiment.cases.iter().zip(contents.references).map(case).collect(),
            configurations: experiment.configurations.iter().map(configuration).collect(),
            others: &experiment.others,
            findings: contents.findings,
            summaries: contents.summaries,
            runs: contents.measured.runs.iter().chain(&experiment.others_runs).map(run).collect(),
            equal_time: contents.shown.iter().map(shown_row).collect(),
        }
    }
}

fn budget(budget: &Budget) -> serde_json::Value {
    match budget {
        Budget::Spp(spp) => serde_json::json!({ "spp": spp }),
        Budget::Time(time) => serde_json::json!({ "seconds": time.as_secs_f64() }),
    }
}

fn configuration(of: &Configuration) -> ConfigurationRow {
    ConfigurationRow {
        strategy: of.strategy.name(),
        lights: of.lights.name(),
        guide: of.guide.name(),
        sampler: of.sampler.name(),
        engine: of.engine.name(),
        biased_by_design: of.strategy.is_biased(),
    }
}

fn run(run: &Run) -> RunRow<'_> {
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
        relmse_trimmed: run.error.relmse_trimmed,
        region_relmse: &run.error.regions,
        bias: run.error.bias,
        bias_se: run.error.bias_se,
        bias_z: run.error.bias_z(),
        camera_rays,
        bounce_rays,
        shadow_rays,
        lanes_used: run.lanes_used,
        walk_lanes_used: run.walk_lanes_used,
        faults: run.faults,
    }
}

fn shown_row(shown: &Shown) -> ShownRow {
    let Shown { case, configuration, spp, cpu_seconds, mse, relmse, psnr, flip, .. } = *shown;
    ShownRow { case, configuration, spp, cpu_seconds, mse, relmse, psnr, flip }
}

/// `converge.csv`: one row a run, in the order in which they ran, then the other renderers'. `mse` and `relmse` have the
/// reference's noise subtracted, so of a run as good as the reference they may come out below 0; means over runs are right.
pub fn csv(experiment: &Experiment, measured: &Measurements) -> String {
    let mut text = String::from("strategy,lights,sampler,engine,spp,seed,seconds,cpu_seconds,mse,relmse,bias_z,light,");
    text += "repeat,rays,lanes_used,walk_lanes_used,relmse_trimmed,guide,scene\n";
    for run in measured.runs.iter().chain(&experiment.others_runs) {
        let name = match experiment.configurations.get(run.configuration) {
            Some(of) => format!("{},{},{},{}", of.strategy, of.lights, of.sampler, of.engine),
            None => format!("{},,,", field(&experiment.label(run.configuration))),
        };
        let guide = experiment.configurations.get(run.configuration).map_or("", |of| of.guide.name());
        let (error, rays) = (&run.error, run.rays.iter().sum::<u64>());
        let [lanes, walks] = [run.lanes_used, run.walk_lanes_used]
            .map(|share| share.map(|share| format!("{share:.4}")).unwrap_or_default());
        let case = &experiment.cases[run.case];
        let _ = writeln!(
            text,
            "{name},{},{},{:.6},{:.6},{:.9e},{:.9e},{:.4},{},{},{rays},{lanes},{walks},{:.9e},{guide},{}",
            run.spp,
            run.seed,
            run.seconds,
            run.cpu_seconds,
            error.mse,
            error.relmse,
            error.bias_z(),
            field(&case.light),
            run.repeat,
            error.relmse_trimmed,
            field(&case.scene_name),
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
