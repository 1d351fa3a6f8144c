//! What `converge` says: a bar while it runs, a table at the end.

use crate::cli::converge::of_case;
use crate::cli::output::table;
use crate::report::analysis::findings::Finding;
use crate::report::measure::experiment::Experiment;
use crate::report::measure::reference::PARTS;
use crate::report::write::words::{significant, tag};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::path::Path;

/// The progress bar, on standard error and only where that is a terminal.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar; hidden if `quiet`.
    pub fn new(quiet: bool) -> Progress {
        let hidden = quiet || !std::io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(8) };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{bar:32} {pos} of {len}  {elapsed} (left: {eta})  {msg}") {
            bar.set_style(style);
        }
        bar.set_message("reference");
        Progress { bar }
    }

    /// So many parts of the reference of a case are done.
    pub fn reference(&self, parts: u32, light: &str) {
        self.bar.set_position(parts as u64);
        self.bar.set_message(format!("parts of the reference (light: {light})"));
    }

    /// So many runs are done.
    pub fn run(&self, done: usize, experiment: &Experiment) {
        let all = experiment.run_count() as u64;
        if self.bar.length() != Some(all) {
            self.bar.reset();
            self.bar.set_length(all);
            self.bar.set_message("runs");
        }
        self.bar.set_position(done as u64);
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

/// One row a configuration.
pub fn summary(experiment: &Experiment, findings: &[Finding], out: &Path) -> String {
    let mut text = String::new();
    for (index, case) in experiment.cases.iter().enumerate() {
        if experiment.cases.len() > 1 {
            text += &format!("light: {}\n", case.light);
        }
        let best = of_case(findings, index).filter_map(|finding| finding.efficiency).fold(0.0, f64::max);
        let head = ["", "spp", "CPU s", "error", "efficiency", "of the best", "slope of MSE", "bias z"];
        let mut rows = vec![head.map(str::to_owned).to_vec()];
        for finding in of_case(findings, index) {
            let Some(last) = finding.points.last() else { continue };
            let percent = |share: f64| format!("{} %", significant(100.0 * share, 3));
            let dash = || "-".to_owned();
            let slope = finding.mse_by_samples.map_or_else(dash, |fit| match fit.slope_interval {
                Some(interval) => format!("{:.3} ({:.3} to {:.3})", fit.law.slope, interval.low, interval.high),
                None => format!("{:.3}", fit.law.slope),
            });
            rows.push(vec![
                experiment.label(finding.configuration),
                format!("{:.0}", last.spp),
                format!("{:.3}", last.cpu_seconds),
                percent(last.relmse.max(0.0).sqrt()),
                finding.efficiency.map_or_else(dash, |efficiency| format!("{efficiency:.3}")),
                finding.efficiency.map_or_else(dash, |efficiency| percent(efficiency / best)),
                slope,
                format!("{:.1} {}", finding.bias_z, tag(finding).unwrap_or_default()),
            ]);
        }
        text += &table(&rows);
    }
    text + &format!("{}\n", out.join("report.html").display())
}
