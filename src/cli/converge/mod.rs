//! `octray converge`: error against run time, for every way to render a scene.

mod against;
mod files;
mod progress;
mod setup;

use crate::cli::args;
use crate::cli::interrupt;
use crate::cli::output::print;
use crate::cli::warn;
use crate::error::Result;
use crate::report::analysis::equal_time;
use crate::report::analysis::findings::analyze;
use crate::report::analysis::summary::summarize;
use crate::report::measure::experiment::{Budget, Experiment, Measurements};
use crate::report::measure::machine::Machine;
use crate::report::measure::reference;
use crate::report::measure::truth::Reference;
use crate::report::write::contents::Contents;
use crate::settings::{Crop, Engine, Lights, Sampler, Settings};
use crate::strategy::Strategy;
use args::{List, RrDepth};
use files::Files;
use progress::Progress;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Flags of `octray converge`.
#[derive(clap::Args)]
pub struct ConvergeArgs {
    /// Scene files (.toml), bare .obj files, or builtin:NAME; several make one report
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,
    /// Directory for report.html, converge.csv, converge.json, plots, images and the reference; made if need be
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[arg(long, value_name = "S,..", default_value = "all", hide_default_value = true,
          help = args::list_help("Strategies", Strategy::ALL, "all"),
          value_parser = |text: &str| args::list(text, Strategy::ALL))]
    strategies: List<Strategy>,
    /// Samples a pixel of the runs
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "1,4,16,64,256", conflicts_with = "times",
          value_parser = args::positive, allow_negative_numbers = true)]
    spps: Vec<u32>,
    /// Wall seconds of the runs, instead of --spps; ended on whole passes
    #[arg(long, value_name = "SECONDS,..", value_delimiter = ',', value_parser = args::seconds, allow_negative_numbers = true)]
    times: Vec<Duration>,
    /// Independent runs of each; intervals need at least two
    #[arg(long, value_name = "R", default_value = "6", value_parser = clap::value_parser!(u32).range(1..=10_000),
          allow_negative_numbers = true)]
    repeats: u32,
    /// Run exact strategies with more and more samples until their error (root of relMSE) is down to E (0.05 or 5%)
    #[arg(long, value_name = "E", value_parser = args::relative_error, allow_hyphen_values = true)]
    reach: Option<f64>,
    /// Another renderer's images beside ours: a CSV file with the columns name, seconds, image, and scene and spp where known;
    /// may be given several times
    #[arg(long, value_name = "FILE.csv")]
    against: Vec<PathBuf>,
    /// Judge by this image instead of a closed form or a long render; noise in its variance layers is subtracted. Once for
    /// every scene, in their order
    #[arg(long, value_name = "FILE", conflicts_with = "reference_spp")]
    reference: Vec<PathBuf>,
    /// Samples a pixel of the rendered reference [default: 16 times the largest of --spps; with --times: 16 times the longest]
    #[arg(long, value_name = "N", value_parser = args::positive, allow_negative_numbers = true)]
    reference_spp: Option<u32>,
    #[arg(long, value_name = "L,..",
          help = args::list_help("Light selections", Lights::ALL, &scene_else(Settings::default().lights)),
          value_parser = |text: &str| args::list(text, Lights::ALL))]
    lights: Option<List<Lights>>,
    #[arg(long, value_name = "S,..",
          help = args::list_help("Samplers", Sampler::ALL, &scene_else(Settings::default().sampler)),
          value_parser = |text: &str| args::list(text, Sampler::ALL))]
    sampler: Option<List<Sampler>>,
    #[arg(long, value_name = "E,..",
          help = args::list_help("Engines", Engine::ALL, Settings::default().engine.name()),
          value_parser = |text: &str| args::list(text, Engine::ALL))]
    engine: Option<List<Engine>>,
    /// Keep the light of this material only (`environment`: of the surroundings); given several times, each is measured by
    /// itself; `all` is the whole scene, `each` every light of the scene in turn after it
    #[arg(long, value_name = "MATERIAL")]
    only_light: Vec<String>,
    /// Also tell the error in this part of the film; may be given several times
    #[arg(long, value_name = "[NAME=]X,Y,W,H", value_parser = setup::region, allow_hyphen_values = true)]
    region: Vec<(String, Crop)>,
    /// Film width in pixels
    #[arg(long, value_name = "W", default_value = "256", value_parser = args::side, allow_negative_numbers = true)]
    width: u32,
    /// Film height in pixels
    #[arg(long, value_name = "H", default_value = "256", value_parser = args::side, allow_negative_numbers = true)]
    height: u32,
    #[arg(long, value_name = "N", help = args::max_depth_help(), allow_negative_numbers = true)]
    max_depth: Option<u32>,
    #[arg(long, value_name = "D|off", help = args::rr_depth_help(),
          value_parser = args::rr_depth, allow_negative_numbers = true)]
    rr_depth: Option<RrDepth>,
    /// Worker threads [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Stops of exposure at which images are shown, and compared as they are seen (PSNR, FLIP)
    #[arg(long, value_name = "EV", default_value = "0", value_parser = args::exposure, allow_negative_numbers = true)]
    exposure: f64,
    /// First of the runs' seeds
    #[arg(long, value_name = "N", default_value = "0", allow_negative_numbers = true)]
    seed: u32,
    /// No progress bar and no table; warnings stay
    #[arg(long)]
    quiet: bool,
}

fn scene_else(default: impl std::fmt::Display) -> String {
    format!("the scene's, else {default}")
}

/// Runs the command; the exit status.
pub fn run(args: &ConvergeArgs) -> Result<u8> {
    let mut partial = Partial::new();
    let mut experiment = setup::experiment(args)?;
    let others = against::read(&args.against, &experiment)?;
    let given = setup::references_from_files(&args.reference, &experiment)?;
    let files = Files::new(&args.out)?;
    let stop = interrupt::requested()?;
    let progress = Progress::new(args.quiet);
    let references = match given {
        Some(given) => Some(given),
        None => references(args, &experiment, &files, &stop, &progress)?,
    };
    let Some(references) = references else {
        progress.finish();
        warn("stopped before there was a reference: nothing was measured; run the same command again");
        return Ok(1);
    };
    others.join(&mut experiment, &references);
    let experiment = experiment;
    let unfinished = files.unfinished();
    let mut measured = match experiment.kept(&references, &unfinished) {
        Some(kept) => {
            warn(&format!("going on from {} with {} runs", unfinished.display(), kept.runs.len()));
            kept
        }
        None => {
            if unfinished.exists() {
                warn(&format!("{}: of other runs, or damaged: starting anew", unfinished.display()));
            }
            experiment.start()
        }
    };
    let (command, machine, no_runs) =
        (setup::command(), Machine::here(), Measurements { runs: Vec::new(), pools: Vec::new() });
    let nothing = Contents {
        experiment: &experiment,
        references: &references,
        measured: &no_runs,
        findings: &[],
        summaries: &[],
        shown: &[],
        machine: &machine,
        command: &command,
        finished: false,
    };
    let finished = experiment.run(&references, &mut measured, &stop, &mut |done| {
        progress.run(done.runs.len(), &experiment);
        if done.runs.len() >= experiment.configurations.len() && partial.is_due() {
            // What goes wrong here will go wrong at the end as well, and is told then.
            let _ = experiment.keep(&references, done, &unfinished);
            let findings = analyze(&experiment, &references, done);
            let summaries = summarize(&experiment, &findings);
            let so_far = Contents { measured: done, findings: &findings, summaries: &summaries, ..nothing };
            let _ = files.write(&so_far);
            partial.written();
        }
    });
    let findings = analyze(&experiment, &references, &measured);
    // A second wish to stop would end the program: after the first, what there is is written without new images.
    let shown = match finished {
        true => {
            progress.note("images at equal time");
            equal_time::render(&experiment, &references, &findings, &stop)
        }
        false => Vec::new(),
    };
    progress.finish();
    let finished = finished && !stop.load(Ordering::Relaxed);
    if !finished {
        let (done, of) = (measured.runs.len(), experiment.run_count());
        experiment.keep(&references, &measured, &unfinished)?;
        warn(&format!(
            "stopped after {done} of {of} runs: the report holds these, and the same command goes on from there"
        ));
    }
    let summaries = summarize(&experiment, &findings);
    let (findings, shown) = (&findings[..], &shown[..]);
    files.write(&Contents { measured: &measured, findings, summaries: &summaries, shown, finished, ..nothing })?;
    if finished {
        files.remove_unfinished();
    }
    if !args.quiet {
        print(&progress::summary(&experiment, findings, &args.out))?;
    }
    Ok(if finished { 0 } else { 1 })
}

/// When a report of what there is so far is written.
struct Partial {
    began: Instant,
    due: Instant,
}

impl Partial {
    /// The first so long after the call, or as soon as there are runs.
    const FIRST: Duration = Duration::from_secs(20);
    /// Then after so long again, and so that writing takes a small share of the time.
    const AGAIN: Duration = Duration::from_secs(30);
    const SHARE: u32 = 20;

    fn new() -> Partial {
        let now = Instant::now();
        Partial { began: now, due: now + Partial::FIRST }
    }

    fn is_due(&mut self) -> bool {
        self.began = Instant::now();
        self.began >= self.due
    }

    fn written(&mut self) {
        self.due = Instant::now() + (Partial::SHARE * self.began.elapsed()).max(Partial::AGAIN);
    }
}

/// One reference a case; `None` if stopped.
fn references(
    args: &ConvergeArgs,
    experiment: &Experiment,
    files: &Files,
    stop: &AtomicBool,
    progress: &Progress,
) -> Result<Option<Vec<Reference>>> {
    let how = setup::reference_configuration(experiment);
    let budget = reference_budget(args, experiment);
    let mut references = Vec::new();
    for (index, case) in experiment.cases.iter().enumerate() {
        if let Some(found) = reference::closed_form(case, experiment) {
            references.push(found);
            continue;
        }
        let (path, key) = (files.reference(experiment, index), reference::key(case, experiment, how, budget));
        if let Some(kept) = reference::kept(&path, &key, how) {
            references.push(kept);
            continue;
        }
        let title = experiment.case_title(index);
        let heard = |part| progress.reference(part, &title);
        let Some(rendered) = reference::render(case, experiment, how, budget, stop, &heard) else { return Ok(None) };
        reference::keep(&rendered, &key, &path)?;
        references.push(rendered);
    }
    Ok(Some(references))
}

/// How long a rendered reference may be: long enough that its noise is small beside that of the longest runs.
fn reference_budget(args: &ConvergeArgs, experiment: &Experiment) -> Budget {
    match (args.reference_spp, experiment.budgets.last()) {
        (Some(spp), _) => Budget::Spp(spp),
        (None, Some(Budget::Time(time))) => Budget::Time(time.saturating_mul(16)),
        (None, Some(Budget::Spp(spp))) => Budget::Spp(spp.saturating_mul(16)),
        (None, None) => Budget::Spp(reference::PARTS),
    }
}
