//! Images at equal time: what every configuration makes of the same CPU seconds.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::image::Image;
use crate::render::render_with;
use crate::report::analysis::findings::Finding;
use crate::report::analysis::summary::of_case;
use crate::report::measure::experiment::{Budget, Experiment};
use crate::report::measure::flip;
use crate::report::measure::metrics::{psnr, relative_errors};
use crate::report::measure::run_error::measure;
use crate::report::measure::truth::Reference;

/// An image of the report.
pub struct Shown {
    /// Index of the case.
    pub case: usize,
    /// Index of the configuration.
    pub configuration: usize,
    /// Samples a pixel that fit into the time.
    pub spp: u32,
    /// CPU seconds it took.
    pub cpu_seconds: f64,
    /// Its mean squared error.
    pub mse: f64,
    /// Its relMSE.
    pub relmse: f64,
    /// Its peak signal-to-noise ratio as it is seen, in dB; `None` where it is the reference.
    pub psnr: Option<f64>,
    /// Its mean HDR-FLIP.
    pub flip: f64,
    /// The image.
    pub image: Image,
    /// The relative error of every pixel.
    pub errors: Vec<f64>,
}

/// The CPU seconds of all images of one case: the least that any configuration's largest budget takes.
fn seconds(experiment: &Experiment, findings: &[&Finding]) -> f64 {
    let own = findings.iter().filter(|finding| experiment.strategy(finding.configuration).is_some());
    let budget = experiment.budgets.len() - 1;
    let last =
        |finding: &&&Finding| finding.points.get(budget).or(finding.points.last()).map(|point| point.cpu_seconds);
    own.filter_map(|finding| last(&finding)).fold(f64::INFINITY, f64::min)
}

/// An image of every finding's configuration: our own rendered with a seed that no run has, fewer if `stop` is set; of
/// another renderer the one whose time is nearest.
pub fn render(
    experiment: &Experiment,
    references: &[Reference],
    findings: &[Finding],
    stop: &AtomicBool,
) -> Vec<Shown> {
    let mut shown = Vec::new();
    let seed = experiment.settings.seed.wrapping_sub(1);
    for (case, reference) in references.iter().enumerate() {
        let of_case: Vec<&Finding> = of_case(findings, case).collect();
        let seconds = seconds(experiment, &of_case);
        for finding in of_case {
            let Some(&configuration) = experiment.configurations.get(finding.configuration) else {
                shown.extend(nearest(experiment, finding, seconds, &reference.image));
                continue;
            };
            let spp = (seconds / finding.cpu_seconds_by_sample).round().clamp(1.0, 1e6) as u32;
            let of = &experiment.cases[case];
            let settings = experiment.settings_of(of, configuration, Budget::Spp(spp), seed);
            let render = render_with(&of.scene, &settings, &|_| !stop.load(Ordering::Relaxed));
            if stop.load(Ordering::Relaxed) {
                return shown;
            }
            let image = render.film.to_image();
            shown.push(new(experiment, finding, spp, render.stats.cpu_s, image, &reference.image));
        }
    }
    shown
}

/// The image of another renderer that took about `seconds`.
fn nearest(experiment: &Experiment, finding: &Finding, seconds: f64, reference: &Image) -> Option<Shown> {
    let runs = experiment.others_runs.iter().zip(&experiment.others_images);
    let own = runs.filter(|(run, _)| (run.case, run.configuration) == (finding.case, finding.configuration));
    let distance = |cpu_seconds: f64| (cpu_seconds / seconds).ln().abs();
    let (run, image) = own.min_by(|(a, _), (b, _)| distance(a.cpu_seconds).total_cmp(&distance(b.cpu_seconds)))?;
    Some(new(experiment, finding, run.spp, run.cpu_seconds, image.clone(), reference))
}

fn new(
    experiment: &Experiment,
    finding: &Finding,
    spp: u32,
    cpu_seconds: f64,
    image: Image,
    reference: &Image,
) -> Shown {
    let measured = measure(&image, reference, &[]);
    Shown {
        case: finding.case,
        configuration: finding.configuration,
        spp,
        cpu_seconds,
        mse: measured.mse,
        relmse: measured.relmse,
        psnr: psnr(&image, reference, experiment.exposure),
        flip: flip::mean(&flip::hdr(&image, reference, flip::PIXELS_PER_DEGREE)),
        errors: relative_errors(&image, reference),
        image,
    }
}
