//! From runs to findings: how fast each configuration's error falls, where it stops, what it costs.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::image::Image;
use crate::report::analysis::bias::{Bias, bias_of};
use crate::report::analysis::curve::{Cost, Curve, Slope, Unknown};
use crate::report::analysis::level::Level;
use crate::report::analysis::point::{Point, point};
use crate::report::analysis::statistics::{Interval, LogError, simultaneous_95};
use crate::report::measure::experiment::{Experiment, Measurements, Run};
use crate::report::measure::run_error::Pool;
use crate::report::measure::truth::{Reference, white_noise};
use crate::strategy::Strategy;

/// A bias further than this many standard errors from 0 is one.
pub const BIAS_Z: f64 = 5.0;
/// No lack of bright samples explains a bias further off than this.
const UNDERSAMPLED_Z: f64 = 30.0;
/// The relative errors (roots of relMSE) whose price is told.
pub const TARGETS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];

/// What a relative error costs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Price {
    /// The relative error: the root of relMSE.
    pub error: f64,
    /// Samples a pixel; `null` where the price is unknown, or the samples are.
    pub samples: Option<f64>,
    /// CPU seconds for them.
    pub cpu_seconds: Option<f64>,
    /// 95 % interval of `cpu_seconds` from the errors; the time of a sample counts as known.
    pub interval: Option<Interval>,
    /// Outside of what was measured.
    pub extrapolated: bool,
    /// Why there is no price.
    pub unknown: Option<Unknown>,
}

/// Whether a configuration's expected image is the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The bias is less than 5 standard errors from 0.
    Unbiased,
    /// It is further.
    Biased,
    /// It is further, but not beyond 30, and dark, of a strategy that is exact, and fewer than a tenth of the pixels carry the
    /// noise or no weights bound its samples (all but `mis-*`: in a corner of lamps a light sample of `nee` may bring any
    /// amount): rare bright samples that no run has met look like that. What no sample has found, no standard error knows.
    Undersampled,
}

/// What was found of one configuration in one case.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Index of the case.
    pub case: usize,
    /// Index of the configuration; from the number of configurations on, of another renderer.
    pub configuration: usize,
    /// By budget, ascending; budgets without a finished run are left out.
    pub points: Vec<Point>,
    /// Slope of MSE against samples a pixel. The slopes' intervals hold with 95 % for all configurations of the case at once.
    pub mse_by_samples: Option<Slope>,
    /// Slope of relMSE against samples a pixel.
    pub relmse_by_samples: Option<Slope>,
    /// Slope of relMSE against CPU seconds.
    pub relmse_by_seconds: Option<Slope>,
    /// Where the error of a biased strategy ends, and how it gets there.
    pub level: Option<Level>,
    /// CPU seconds by sample a pixel, at the largest budget.
    pub cpu_seconds_by_sample: f64,
    /// 1 / (relMSE x CPU seconds) at the largest budget; `null` unless the verdict is [`Verdict::Unbiased`] and the strategy
    /// exact by design.
    pub efficiency: Option<f64>,
    /// 95 % interval of `efficiency` from the error; CPU seconds count as known.
    pub efficiency_interval: Option<Interval>,
    /// What configurations are ranked by: `efficiency`, or with `--reach` one by the CPU seconds to that error.
    pub worth: Option<f64>,
    /// 95 % interval of `worth`.
    pub worth_interval: Option<Interval>,
    /// Mean of image - reference over all runs and pixels.
    pub bias: f64,
    /// `bias` over the reference's mean; infinite (`null` in JSON) over a black one.
    pub relative_bias: f64,
    /// Standard error of `bias`, the reference's noise included.
    pub bias_se: f64,
    /// `bias / bias_se`; infinite (`null` in JSON) where nothing varies and the image is not the reference.
    pub bias_z: f64,
    /// Whether the image is expected to be the reference.
    pub verdict: Verdict,
    /// `verdict` is [`Verdict::Biased`].
    pub biased: bool,
    /// How many pixels would carry the noise of all runs together if all had the same: (sum v)^2 / sum v^2 of variances v.
    /// Few of many: rare bright samples rule, and standard errors cannot be relied on.
    pub effective_pixels: f64,
    /// The squared relative bias of the pixels: the relMSE of infinitely many samples, not below 0.
    pub floor: f64,
    /// 95 % interval of `floor`; `null` below three repeats.
    pub floor_interval: Option<Interval>,
    /// What [`TARGETS`], and the error of `--reach`, cost.
    pub prices: Vec<Price>,
    /// relMSE by samples a pixel, or by CPU seconds where the samples are not known.
    #[serde(skip)]
    pub curve: Option<Curve>,
}

/// The findings of every case and configuration that has runs.
pub fn analyze(experiment: &Experiment, references: &[Reference], measured: &Measurements) -> Vec<Finding> {
    let mut targets = TARGETS.to_vec();
    targets.extend(experiment.reach);
    targets.sort_by(|a, b| b.total_cmp(a));
    targets.dedup();
    let confidence = simultaneous_95(experiment.entries());
    let none = Pool::default();
    let mut findings = Vec::new();
    for (case, reference) in references.iter().enumerate() {
        for configuration in 0..experiment.entries() {
            let of = |run: &&Run| (run.case, run.configuration) == (case, configuration);
            let runs: Vec<&Run> = measured.runs.iter().chain(&experiment.others_runs).filter(of).collect();
            if !runs.is_empty() {
                let pool = measured.pools[case].get(configuration).unwrap_or(&none);
                let strategy = experiment.strategy(configuration);
                let scene = &experiment.cases[case].scene;
                let exact = strategy.is_none_or(|strategy| !strategy.is_biased() && scene.is_seen_by(strategy));
                let bounded = strategy.is_none_or(Strategy::is_mis);
                let ask = Ask { exact, bounded, confidence, targets: &targets, reach: experiment.reach };
                findings.push(find(&runs, pool, &reference.image, &ask));
            }
        }
    }
    findings
}

/// What is asked of a configuration's runs.
struct Ask<'a> {
    /// By design, its expected image is the truth.
    exact: bool,
    /// Its weights come from the densities of both techniques, which keeps samples from being rare and bright.
    bounded: bool,
    /// Confidence of a slope's interval.
    confidence: f64,
    /// Relative errors whose price is asked.
    targets: &'a [f64],
    /// The one by which configurations are ranked; `None`: by efficiency.
    reach: Option<f64>,
}

/// The finding of one configuration's runs.
fn find(runs: &[&Run], pool: &Pool, reference: &Image, ask: &Ask) -> Finding {
    let mut by_budget: BTreeMap<usize, Vec<&Run>> = BTreeMap::new();
    runs.iter().for_each(|run| by_budget.entry(run.budget).or_default().push(run));
    let groups: Vec<Vec<&Run>> = by_budget.into_values().collect();
    let bias = bias_of(pool, &groups, reference);
    let (pixels, noise) = (reference.pixels.len(), white_noise(reference));
    let of_group = |group: &Vec<&Run>| point(group, pixels, bias.floor.shared_variance, noise);
    let points: Vec<Point> = groups.iter().map(of_group).collect();
    let verdict = match bias.score() {
        z if z.abs() <= BIAS_Z => Verdict::Unbiased,
        z if z < 0.0
            && z > -UNDERSAMPLED_Z
            && ask.exact
            && (!ask.bounded || bias.effective_pixels < 0.1 * reference.pixels.len() as f64) =>
        {
            Verdict::Undersampled
        }
        _ => Verdict::Biased,
    };
    let by_samples = Curve::new(points.iter().filter_map(Point::relmse_by_samples));
    let by_seconds = Curve::new(points.iter().filter_map(Point::relmse_by_seconds));
    let mse_by_samples = Curve::new(points.iter().filter_map(Point::mse_by_samples));
    let slope = |curve: &Option<Curve>| curve.as_ref().and_then(|curve| curve.slope(ask.confidence));
    let last = &points[points.len() - 1];
    let efficiency = |relmse: f64| (relmse * last.cpu_seconds).recip();
    let known = verdict == Verdict::Unbiased && ask.exact && last.relmse > 0.0 && last.cpu_seconds > 0.0;
    let biased = verdict == Verdict::Biased;
    let mut finding = Finding {
        case: runs[0].case,
        configuration: runs[0].configuration,
        mse_by_samples: slope(&mse_by_samples),
        relmse_by_samples: slope(&by_samples),
        relmse_by_seconds: slope(&by_seconds),
        level: (biased && bias.floor.value > 0.0).then(|| Level::of(&points, bias.floor)),
        cpu_seconds_by_sample: last.cpu_seconds / last.spp,
        efficiency: known.then(|| efficiency(last.relmse)),
        efficiency_interval: last.relmse_interval.filter(|_| known).map(|interval| interval.map(efficiency)),
        worth: None,
        worth_interval: None,
        bias: bias.mean,
        // A black reference makes any light infinitely much.
        relative_bias: if bias.mean == 0.0 { 0.0 } else { bias.mean / bias.reference_mean },
        bias_se: bias.standard_error,
        bias_z: bias.score(),
        verdict,
        biased,
        effective_pixels: bias.effective_pixels,
        floor: bias.floor.value.max(0.0),
        floor_interval: floor_interval(&bias),
        prices: Vec::new(),
        curve: if last.spp > 0.0 { by_samples } else { by_seconds },
        points,
    };
    finding.prices = ask.targets.iter().map(|error| finding.price(*error, None)).collect();
    (finding.worth, finding.worth_interval) = match ask.reach {
        None => (finding.efficiency, finding.efficiency_interval),
        Some(error) => {
            let price = finding.price(error, None);
            let usable = ask.exact && verdict == Verdict::Unbiased;
            let rate = price.cpu_seconds.filter(|seconds| usable && *seconds > 0.0).map(f64::recip);
            (rate, rate.and(price.interval).map(|interval| interval.map(f64::recip)))
        }
    };
    finding
}

impl Finding {
    /// What the relative error `error` costs, which is uncertain by `uncertain` in the logarithm of its square.
    pub fn price(&self, error: f64, uncertain: Option<LogError>) -> Price {
        self.price_of(error, self.cost(error * error, uncertain))
    }

    /// The price of the relative error `error` at this cost.
    fn price_of(&self, error: f64, cost: Result<Cost, Unknown>) -> Price {
        let unknown = Price {
            error,
            samples: None,
            cpu_seconds: None,
            interval: None,
            extrapolated: false,
            unknown: Some(Unknown::TooUncertain),
        };
        match cost {
            Err(reason) => Price { unknown: Some(reason), ..unknown },
            Ok(Cost { value, interval, extrapolated }) if self.has_samples() => Price {
                samples: Some(value),
                cpu_seconds: Some(self.cpu_seconds_of(value)),
                interval: interval.map(|interval| interval.map(|samples| self.cpu_seconds_of(samples))),
                extrapolated,
                unknown: None,
                ..unknown
            },
            Ok(Cost { value, interval, extrapolated }) => {
                Price { cpu_seconds: Some(value), interval, extrapolated, unknown: None, ..unknown }
            }
        }
    }

    /// Samples a pixel (CPU seconds, where these are not known) for a relMSE.
    fn cost(&self, relmse: f64, uncertain: Option<LogError>) -> Result<Cost, Unknown> {
        let (first, last) = (&self.points[0], &self.points[self.points.len() - 1]);
        let cost = |point: &Point| if self.has_samples() { point.spp } else { point.cpu_seconds };
        let cost = match (self.verdict, &self.level, &self.curve) {
            (Verdict::Undersampled, ..) | (Verdict::Biased, None, _) => Err(Unknown::TooUncertain),
            (Verdict::Biased, Some(level), _) => {
                let value = level.samples_for(relmse).ok_or(Unknown::Never)?.max(0.0);
                let value = if value == 0.0 { first.spp } else { value };
                Ok(Cost { value, interval: None, extrapolated: !(first.spp..=last.spp).contains(&value) })
            }
            (Verdict::Unbiased, _, Some(curve)) => curve.cost_of(relmse, uncertain),
            // Without any error from the first budget on.
            (Verdict::Unbiased, _, None) if self.points.iter().all(|point| point.relmse <= 0.0 && !point.outliers) => {
                Ok(Cost { value: cost(first), interval: None, extrapolated: false })
            }
            (Verdict::Unbiased, _, None) => Err(Unknown::TooUncertain),
        }?;
        // No render has less than one sample a pixel.
        let least = if self.has_samples() { 1.0 } else { 0.0 };
        let at_least = |value: f64| value.max(least);
        Ok(Cost {
            value: at_least(cost.value),
            interval: cost.interval.map(|interval| interval.map(at_least)),
            extrapolated: cost.extrapolated && !(cost.value < least && first.spp <= least),
        })
    }

    fn has_samples(&self) -> bool {
        self.points[0].spp > 0.0
    }

    /// CPU seconds of so many samples a pixel: by the budgets next to them, since a render of few samples takes longer for
    /// each; outside of the budgets each sample takes what it does at the nearest.
    fn cpu_seconds_of(&self, samples: f64) -> f64 {
        let points = &self.points;
        let right = points.iter().position(|point| point.spp >= samples);
        match right {
            Some(right) if right > 0 => {
                let (a, b) = (&points[right - 1], &points[right]);
                let part = (samples / a.spp).ln() / (b.spp / a.spp).ln();
                a.cpu_seconds * (b.cpu_seconds / a.cpu_seconds).powf(part)
            }
            Some(_) => points[0].cpu_seconds / points[0].spp * samples,
            None => self.cpu_seconds_by_sample * samples,
        }
    }

    /// The last budget's point.
    pub fn last(&self) -> &Point {
        &self.points[self.points.len() - 1]
    }
}

/// The interval of the floor, not below 0.
fn floor_interval(bias: &Bias) -> Option<Interval> {
    let interval = bias.floor.estimate?.interval();
    Some(interval.map(|end| end.max(0.0)))
}

/// A cost as a multiple of another configuration's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// The ratio.
    pub value: f64,
    /// Its 95 % interval: that of the cost, the other's error included.
    pub interval: Option<Interval>,
    /// Outside of what was measured.
    pub extrapolated: bool,
}

/// What it takes `this` to come to the error that `other` has at its largest budget, as multiples of what that takes: samples
/// (`None` where they are not known) and CPU seconds. `None` where one of them is biased, or the price is unknown.
pub fn ratios(this: &Finding, other: &Finding) -> Option<(Option<Ratio>, Ratio)> {
    let last = other.last();
    let comparable = this.verdict == Verdict::Unbiased && other.verdict == Verdict::Unbiased;
    if !comparable || last.relmse <= 0.0 || last.outliers {
        return None;
    }
    let uncertain = last.relmse_estimate.map(|estimate| estimate.of_logarithm());
    let cost = this.cost(last.relmse, uncertain).ok()?;
    let price = this.price_of(last.relmse.sqrt(), Ok(cost));
    let ratio = |value: f64, interval: Option<Interval>, by: f64| Ratio {
        value: value / by,
        interval: interval.map(|interval| interval.map(|end| end / by)),
        extrapolated: cost.extrapolated,
    };
    let samples = (this.has_samples() && other.has_samples()).then(|| ratio(cost.value, cost.interval, last.spp));
    Some((samples, ratio(price.cpu_seconds?, price.interval, last.cpu_seconds)))
}

#[cfg(test)]
#[path = "findings_tests.rs"]
mod tests;
