//! `octray converge`: error against run time, for every way to render a scene.

mod against;
mod files;
mod flags;
mod progress;
mod setup;

use crate::cli::interrupt;
use crate::cli::output::print;
use crate::cli::places;
use crate::cli::resume::remove_unfinished;
use crate::cli::warn;
use crate::error::{Error, Result};
use crate::report::analysis::equal_time;
use crate::report::analysis::findings::analyze;
use crate::report::analysis::summary::summarize;
use crate::report::measure::experiment::{Budget, Experiment, Measurements};
use crate::report::measure::machine::Machine;
use crate::report::measure::parts;
use crate::report::measure::reference::{self, Parts};
use crate::report::measure::truth::Reference;
use crate::report::write::contents::{Contents, State};
use files::Files;
pub use flags::ConvergeArgs;
use progress::Progress;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Runs the command; the exit status.
pub fn run(args: &ConvergeArgs) -> Result<u8> {
    check_shard(args)?;
    let mut partial = Partial::new();
    places::claim_directory(&args.out, files::EXTENSIONS);
    let mut experiment = setup::experiment(args)?;
    let others = places::reading(|| against::read(&args.against, &experiment))?;
    // One that an earlier call has made is not written where it is given.
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
        warn("stopped before there was a reference: nothing was measured; the same command goes on from there");
        return Ok(1);
    };
    let of_parts = match args.merge.is_empty() {
        true => None,
        false => Some(places::reading(|| parts::merged(&mut experiment, &references, &args.merge))?),
    };
    others.join(&mut experiment, &references);
    let experiment = experiment;
    let unfinished = files.unfinished();
    let merged = of_parts.is_some();
    let mut measured = match of_parts.or_else(|| experiment.kept(&references, &unfinished)) {
        Some(of_parts) if merged => of_parts,
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
        state: State::Running,
    };
    let mut kept = Kept::new(args.every);
    let finished = experiment.run(&references, &mut measured, &stop, &mut |done| {
        progress.run(done, &experiment);
        // What goes wrong here will go wrong at the end as well, and is told then.
        kept.when_due(|| {
            let _ = experiment.keep(&references, done, &unfinished);
        });
        let of_all = experiment.shard.is_none() && done.runs.len() >= experiment.configurations.len();
        if of_all && partial.is_due() {
            let findings = analyze(&experiment, &references, done);
            let summaries = summarize(&experiment, &findings);
            let so_far = Contents { measured: done, findings: &findings, summaries: &summaries, ..nothing };
            let _ = files.write(&so_far);
            partial.written();
        }
    });
    if let Some(shard) = experiment.shard {
        progress.finish();
        if !finished {
            experiment.keep(&references, &measured, &unfinished)?;
            let so_far = Contents { measured: &measured, ..nothing }.so_far();
            warn(&format!("stopped after {so_far} of part {shard}: the same command goes on from there"));
            return Ok(1);
        }
        parts::write(&files.part(), &experiment, shard, &references, &measured)?;
        remove_unfinished(&unfinished);
        if !args.quiet {
            print(&format!("wrote {}: part {shard}, {} runs\n", files.part().display(), measured.runs.len()))?;
        }
        return Ok(0);
    }
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
        experiment.keep(&references, &measured, &unfinished)?;
        let so_far = Contents { measured: &measured, ..nothing }.so_far();
        warn(&format!("stopped after {so_far}: the report holds these, and the same command goes on from there"));
    }
    let summaries = summarize(&experiment, &findings);
    let (findings, shown) = (&findings[..], &shown[..]);
    let state = if finished { State::Finished } else { State::Stopped };
    files.write(&Contents { measured: &measured, findings, summaries: &summaries, shown, state, ..nothing })?;
    progress::noisy_references(&experiment, &references, findings).iter().for_each(|warning| warn(warning));
    if finished {
        remove_unfinished(&files.unfinished());
    }
    if !args.quiet {
        print(&progress::summary(&experiment, findings, &args.out))?;
    }
    Ok(if finished { 0 } else { 1 })
}

/// Refuses with `--shard` what needs all runs.
fn check_shard(args: &ConvergeArgs) -> Result<()> {
    let refused = |message: &str| Err(Error::Usage(format!("--shard: {message}")));
    match args.shard {
        None => Ok(()),
        Some(_) if args.reach.is_some() => refused("--reach goes by all runs: give it with --merge"),
        Some(_) if !args.against.is_empty() => refused("--against belongs to the report: give it with --merge"),
        Some(_) if !args.times.is_empty() && args.reference.is_empty() && args.reference_spp.is_none() => {
            refused("a reference by --times is another one on every machine: give --reference or --reference-spp")
        }
        Some(_) => Ok(()),
    }
}

/// When what has been measured is kept.
struct Kept {
    every: Duration,
    last: Instant,
}

impl Kept {
    fn new(every: Duration) -> Kept {
        Kept { every, last: Instant::now() }
    }

    /// Calls `keep` if it is time again.
    fn when_due(&mut self, keep: impl FnOnce()) {
        if self.last.elapsed() >= self.every {
            keep();
            self.last = Instant::now();
        }
    }
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
        let unfinished = files.unfinished_reference(experiment, index);
        let (width, height) = experiment.film();
        let mut parts = Parts::kept(&key, width as usize * height as usize, &unfinished);
        let mut kept = Kept::new(args.every);
        let mut heard = |parts: &Parts| {
            progress.reference(parts.count() as u32, &title);
            // The last part makes the reference, which is kept itself.
            if parts.count() < reference::PARTS as usize {
                kept.when_due(|| {
                    let _ = parts.keep(&key, &unfinished);
                });
            }
        };
        let Some(rendered) = reference::render(case, experiment, how, budget, &mut parts, stop, &mut heard) else {
            if parts.count() > 0 {
                parts.keep(&key, &unfinished)?;
            }
            return Ok(None);
        };
        reference::keep(&rendered, &key, &path)?;
        remove_unfinished(&unfinished);
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
