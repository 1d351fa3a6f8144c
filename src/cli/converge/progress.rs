//! What `converge` says: a bar while it runs (lines now and then where there is no terminal), a table at the end.

use crate::cli::output::table;
use crate::report::analysis::findings::Finding;
use crate::report::analysis::summary::{of_case, share_of_best};
use crate::report::measure::experiment::{Experiment, Measurements};
use crate::report::measure::reference::PARTS;
use crate::report::measure::truth::Reference;
use crate::report::write::numbers::{percent, significant, target};
use crate::report::write::words::{last_error, tag};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::Cell;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// Seconds to the first line off a terminal, and between two.
const FIRST_LINE: Duration = Duration::from_secs(10);
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// Where the number of steps is known, and where it is not.
const COUNTED: &str = "{bar:24} {pos}/{len} {msg}, {elapsed} (left: {eta})";
const UNCOUNTED: &str = "{spinner} {pos} {msg}, {elapsed}";

/// How far a call has come, on standard error: a bar on a terminal, else a line every half minute.
pub struct Progress {
    bar: ProgressBar,
    lines: bool,
    start: Instant,
    next_line: Cell<Instant>,
}

impl Progress {
    /// A bar or lines; neither if `quiet`.
    pub fn new(quiet: bool) -> Progress {
        let terminal = std::io::stderr().is_terminal();
        let target =
            if quiet || !terminal { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(8) };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        if let Ok(style) = ProgressStyle::with_template(COUNTED) {
            bar.set_style(style);
        }
        bar.set_message("reference");
        let start = Instant::now();
        Progress { bar, lines: !quiet && !terminal, start, next_line: Cell::new(start + FIRST_LINE) }
    }

    /// So many parts of the reference of a case are done.
    pub fn reference(&self, parts: u32, title: &str) {
        let message = if title.is_empty() {
            "parts of the reference".to_owned()
        } else {
            format!("parts of the reference ({title})")
        };
        self.step(parts as u64, Some(PARTS as u64), message);
    }

    /// So many runs are done.
    pub fn run(&self, done: &Measurements, experiment: &Experiment) {
        let (all, asked) = (done.runs.len(), experiment.asked_of(&done.runs));
        match (all - asked, experiment.reach) {
            // How many it takes to reach an error nobody knows before.
            (beyond @ 1.., Some(error)) => {
                self.step(all as u64, None, format!("runs, {beyond} of them to reach an error of {}", target(error)));
            }
            _ => self.step(asked as u64, Some(experiment.run_count() as u64), "runs".to_owned()),
        }
    }

    /// `all`: how many there will be, where that is known.
    fn step(&self, position: u64, all: Option<u64>, message: String) {
        if self.bar.length() != all {
            self.bar.reset();
            let template = match all {
                Some(all) => {
                    self.bar.set_length(all);
                    COUNTED
                }
                None => {
                    self.bar.unset_length();
                    UNCOUNTED
                }
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                self.bar.set_style(style);
            }
        }
        self.bar.set_position(position);
        if self.lines && Instant::now() >= self.next_line.get() {
            let seconds = self.start.elapsed().as_secs();
            let of = all.map(|all| format!(" of {all}")).unwrap_or_default();
            let _ = writeln!(std::io::stderr(), "{:>3}:{:02}  {position}{of} {message}", seconds / 60, seconds % 60);
            self.next_line.set(Instant::now() + BETWEEN_LINES);
        }
        self.bar.set_message(message);
    }

    /// What is going on now.
    pub fn note(&self, text: &str) {
        self.bar.set_message(text.to_owned());
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// The reference's noise may be this share of the least squared error before it is told: it is subtracted, but not known exactly.
const NOISY: f64 = 0.3;

/// What to say of references whose noise is not small beside the errors that they judge.
pub fn noisy_references(experiment: &Experiment, references: &[Reference], findings: &[Finding]) -> Vec<String> {
    let least = |case: usize| {
        let sound = of_case(findings, case).filter(|finding| tag(finding).is_none());
        sound.map(|finding| finding.last().relmse.max(0.0)).fold(f64::INFINITY, f64::min)
    };
    let told = references.iter().enumerate().filter_map(|(case, reference)| {
        let (noise, least) = (reference.noise().1, least(case));
        let title = experiment.case_title(case);
        let of = if title.is_empty() { String::new() } else { format!(" for {title}") };
        (least.is_finite() && noise > NOISY * least).then(|| {
            format!(
                "the reference{of} has an error of {} itself, beside errors down to {}: give it more samples (--reference-spp)",
                percent(noise.sqrt()),
                percent(least.sqrt())
            )
        })
    });
    told.collect()
}

/// One row a configuration.
pub fn summary(experiment: &Experiment, findings: &[Finding], out: &Path) -> String {
    let mut text = String::new();
    for index in 0..experiment.cases.len() {
        if experiment.cases.len() > 1 {
            text += &format!("{}\n", experiment.case_title(index));
        }
        let head = ["", "spp", "CPU s", "error", "efficiency", "of best", "slope (95 %)", "bias z"];
        let mut rows = vec![head.map(str::to_owned).to_vec()];
        for finding in of_case(findings, index) {
            let last = finding.last();
            let dash = || "-".to_owned();
            let slope = finding.relmse_by_samples.map_or_else(dash, |slope| match slope.interval {
                Some(interval) => {
                    format!("{:.2} ({:.2} to {:.2})", slope.value / 2.0, interval.low / 2.0, interval.high / 2.0)
                }
                None => format!("{:.2}", slope.value / 2.0),
            });
            rows.push(vec![
                experiment.label(finding.configuration),
                if last.spp > 0.0 { format!("{:.0}", last.spp) } else { dash() },
                significant(last.cpu_seconds, 3),
                percent(last_error(finding)),
                finding.efficiency.map_or_else(dash, |efficiency| significant(efficiency, 3)),
                share_of_best(findings, index, finding.configuration).map_or_else(dash, percent),
                if finding.biased { dash() } else { slope },
                format!("{:.1} {}", finding.bias_z, tag(finding).unwrap_or_default()),
            ]);
        }
        text += &table(&rows);
    }
    text + &format!(
        "error: the root of relMSE at the largest budget; slope: that of the error by samples (-0.5: independent samples)\n{}\n",
        out.join("report.html").display()
    )
}
