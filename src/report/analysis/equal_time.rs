//! Pictures at equal time: what every configuration makes of the same CPU seconds.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::film::Film;
use crate::render::render_with;
use crate::report::analysis::findings::Finding;
use crate::report::measure::experiment::{Budget, Experiment};
use crate::report::measure::metrics::relative_errors;
use crate::report::measure::run_error::measure;
use crate::report::measure::truth::Reference;

/// A picture of the report.
pub struct Shown {
    /// Index of the case.
    pub case: usize,
    /// Index of the configuration.
    pub configuration: usize,
    /// Samples a pixel that fit into the time.
    pub spp: u32,
    /// CPU seconds it took.
    pub cpu_seconds: f64,
    /// Its relMSE.
    pub relmse: f64,
    /// The picture.
    pub film: Film,
    /// The relative error of every pixel.
    pub errors: Vec<f64>,
}

/// The CPU seconds of all pictures of one case: the least that any configuration's largest budget takes.
fn seconds(findings: &[&Finding]) -> f64 {
    let last = |finding: &&Finding| finding.points.last().map(|point| point.cpu_seconds);
    findings.iter().filter_map(last).fold(f64::INFINITY, f64::min)
}

/// Renders a picture of every finding's configuration, with a seed that no run has; fewer if `stop` is set.
pub fn render(
    experiment: &Experiment,
    references: &[Reference],
    findings: &[Finding],
    stop: &AtomicBool,
) -> Vec<Shown> {
    let mut shown = Vec::new();
    let seed = experiment.settings.seed.wrapping_sub(1);
    for (case, reference) in references.iter().enumerate() {
        let of_case: Vec<&Finding> = findings.iter().filter(|finding| finding.case == case).collect();
        let seconds = seconds(&of_case);
        for finding in of_case {
            let spp = (seconds / finding.cpu_seconds_by_sample).round().clamp(1.0, 1e6) as u32;
            let configuration = experiment.configurations[finding.configuration];
            let settings = experiment.settings_of(configuration, Budget::Spp(spp), seed);
            let render = render_with(&experiment.cases[case].scene, &settings, &|_| !stop.load(Ordering::Relaxed));
            if stop.load(Ordering::Relaxed) {
                return shown;
            }
            let image = render.film.to_image();
            shown.push(Shown {
                case,
                configuration: finding.configuration,
                spp,
                cpu_seconds: render.stats.cpu_s,
                relmse: measure(&image, &reference.image, &[]).relmse,
                errors: relative_errors(&image, &reference.image),
                film: render.film,
            });
        }
    }
    shown
}
