//! From runs to findings: how fast each configuration's error falls, where it stops, what it costs.

use serde::Serialize;

use crate::image::Image;
use crate::report::analysis::bias::bias_of;
use crate::report::analysis::statistics::{
    Fit, FitPoint, Interval, bootstrap_means, deviation, fit, mean, percentile_interval, simultaneous_95,
};
use crate::report::measure::experiment::{Budget, Experiment, Measurements, Run};
use crate::report::measure::run_error::Pool;
use crate::report::measure::truth::Reference;

/// Bootstrap replicates of every figure.
const REPLICATES: u32 = 1000;
/// A bias further than this many standard errors from 0 is one.
pub const BIAS_Z: f64 = 5.0;
/// The relative errors (roots of relMSE) whose price is told.
pub const TARGETS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];

/// The runs of one configuration with one budget.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Runs in it.
    pub runs: usize,
    /// Samples a pixel (their harmonic mean, where a time budget reached different ones).
    pub spp: f64,
    /// Wall seconds, mean.
    pub seconds: f64,
    /// CPU seconds, mean.
    pub cpu_seconds: f64,
    /// Mean squared error, mean over runs.
    pub mse: f64,
    /// 95 % bootstrap interval of `mse`.
    pub mse_interval: Option<Interval>,
    /// Relative mean squared error, mean over runs.
    pub relmse: f64,
    /// 95 % bootstrap interval of `relmse`.
    pub relmse_interval: Option<Interval>,
    /// Mean over runs of the bias, and its score from the spread of the runs' own standard errors.
    pub bias_z: f64,
    /// Millions of rays by CPU second.
    pub mrays_per_s: f64,
    /// Share of SIMD lanes that held work.
    pub lanes_used: Option<f64>,
}

/// How relMSE depends on the samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Law {
    /// variance / n: independent samples of an exact estimator.
    Variance {
        /// relMSE of one sample a pixel.
        variance: f64,
    },
    /// constant n^slope, as fitted, where the slope is not -1.
    Power {
        /// relMSE of one sample a pixel.
        constant: f64,
        /// The exponent.
        slope: f64,
    },
    /// floor + variance / n: a biased estimator.
    Floor {
        /// The squared relative bias, which no number of samples lowers.
        floor: f64,
        /// relMSE of one sample a pixel, without it.
        variance: f64,
    },
}

impl Law {
    /// relMSE of `n` samples a pixel.
    pub fn at(self, n: f64) -> f64 {
        match self {
            Law::Variance { variance } => variance / n,
            Law::Power { constant, slope } => constant * n.powf(slope),
            Law::Floor { floor, variance } => floor + variance / n,
        }
    }

    /// Samples a pixel for a relMSE; `None` if there is no such number.
    pub fn samples_for(self, relmse: f64) -> Option<f64> {
        let samples = match self {
            Law::Variance { variance } => variance / relmse,
            Law::Power { constant, slope } => (relmse / constant).powf(1.0 / slope),
            Law::Floor { floor, variance } => variance / (relmse - floor),
        };
        (samples.is_finite() && samples > 0.0).then_some(samples)
    }
}

/// What a relative error costs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Price {
    /// The relative error: the root of relMSE.
    pub error: f64,
    /// Samples a pixel; `null`: not with any number.
    pub samples: Option<f64>,
    /// CPU seconds for them.
    pub cpu_seconds: Option<f64>,
    /// Outside of what was measured.
    pub extrapolated: bool,
}

/// Whether a configuration's expected picture is the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The bias is less than 5 standard errors from 0.
    Unbiased,
    /// It is further.
    Biased,
    /// It is further and dark, of a strategy that is exact, and fewer than a tenth of the pixels carry the noise: rare bright
    /// samples that no run has met look like that. What no sample has found, no standard error knows.
    Undersampled,
}

/// What was found of one configuration in one case.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Index of the case.
    pub case: usize,
    /// Index of the configuration.
    pub configuration: usize,
    /// By budget, ascending; budgets without a finished run are left out.
    pub points: Vec<Point>,
    /// MSE against samples a pixel. The slopes' intervals hold with 95 % for all configurations of the case at once.
    pub mse_by_samples: Option<Fit>,
    /// relMSE against samples a pixel.
    pub relmse_by_samples: Option<Fit>,
    /// relMSE against CPU seconds.
    pub relmse_by_seconds: Option<Fit>,
    /// The law by which errors are predicted.
    pub law: Option<Law>,
    /// CPU seconds by sample a pixel, at the largest budget.
    pub cpu_seconds_by_sample: f64,
    /// 1 / (relMSE x CPU seconds) at the largest budget; `null` unless the verdict is [`Verdict::Unbiased`].
    pub efficiency: Option<f64>,
    /// 95 % interval of `efficiency` from the error; CPU seconds count as known.
    pub efficiency_interval: Option<Interval>,
    /// Mean of picture - reference over all runs and pixels.
    pub bias: f64,
    /// `bias` over the reference's mean.
    pub relative_bias: f64,
    /// Standard error of `bias`, the reference's noise included.
    pub bias_se: f64,
    /// `bias / bias_se`.
    pub bias_z: f64,
    /// Whether the picture is expected to be the reference.
    pub verdict: Verdict,
    /// `verdict` is [`Verdict::Biased`].
    pub biased: bool,
    /// How many pixels would carry the noise of all runs together if all had the same: (sum v)^2 / sum v^2 of variances v.
    /// Few of many: rare bright samples rule, and standard errors cannot be relied on.
    pub effective_pixels: f64,
    /// relMSE of all runs' pictures together less their noise: the squared relative bias of the pixels.
    pub floor: f64,
    /// What [`TARGETS`] cost.
    pub prices: Vec<Price>,
    /// Mean relMSE and its standard error at the largest budget, by region.
    pub regions: Vec<(f64, f64)>,
}

/// The findings of every case and configuration that has runs.
pub fn analyze(experiment: &Experiment, references: &[Reference], measured: &Measurements) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (case, reference) in references.iter().enumerate() {
        for configuration in 0..experiment.configurations.len() {
            let of = |run: &&Run| (run.case, run.configuration) == (case, configuration);
            let runs: Vec<&Run> = measured.runs.iter().filter(of).collect();
            if !runs.is_empty() {
                let pool = &measured.pools[case][configuration];
                let exact = !experiment.configurations[configuration].strategy.is_biased();
                let z = simultaneous_95(experiment.configurations.len());
                findings.push(find(&experiment.budgets, &runs, pool, &reference.image, exact, z));
            }
        }
    }
    findings
}

/// The finding of one configuration's runs. `exact`: by design, its expected picture is the truth; `z`: standard errors to
/// both sides of a slope in its interval.
fn find(budgets: &[Budget], runs: &[&Run], pool: &Pool, reference: &Image, exact: bool, z: f64) -> Finding {
    let groups = (0..budgets.len()).map(|budget| runs.iter().filter(|run| run.budget == budget).copied().collect());
    let groups: Vec<Vec<&Run>> = groups.filter(|group: &Vec<&Run>| !group.is_empty()).collect();
    let group_replicates = |tiles: fn(&Run) -> &[f64], stream: u32| -> Vec<Option<Vec<f64>>> {
        let of = |(budget, group): (usize, &Vec<&Run>)| {
            let tiles: Vec<&[f64]> = group.iter().map(|run| tiles(run)).collect();
            bootstrap_means(&tiles, REPLICATES, stream + budget as u32)
        };
        groups.iter().enumerate().map(of).collect()
    };
    let mse_replicates = group_replicates(|run| &run.error.mse_by_tile, 0);
    let relmse_replicates = group_replicates(|run| &run.error.relmse_by_tile, 1 << 16);
    let points: Vec<Point> = (0..groups.len())
        .map(|i| point(&groups[i], mse_replicates[i].as_deref(), relmse_replicates[i].as_deref()))
        .collect();
    let fit_of = |x: fn(&Point) -> f64, y: fn(&Point) -> f64, replicates: &[Option<Vec<f64>>]| {
        let usable = points.iter().zip(replicates).filter(|(point, _)| x(point) > 0.0 && y(point) > 0.0);
        let usable = usable.map(|(point, r)| FitPoint { x: x(point), y: y(point), replicates: r.as_deref() });
        fit(&usable.collect::<Vec<_>>(), z)
    };
    let relmse_by_samples = fit_of(|p| p.spp, |p| p.relmse, &relmse_replicates);
    let bias = bias_of(pool, &groups, reference);
    let verdict = match bias.score() {
        z if z.abs() <= BIAS_Z => Verdict::Unbiased,
        z if z < 0.0 && exact && bias.effective_pixels < 0.1 * reference.pixels.len() as f64 => Verdict::Undersampled,
        _ => Verdict::Biased,
    };
    let biased = verdict == Verdict::Biased;
    let law = law_of(&points, relmse_by_samples.as_ref(), biased.then_some(bias.floor));
    let last = &points[points.len() - 1];
    let last_runs = &groups[groups.len() - 1];
    let efficiency = |relmse: f64| (relmse * last.cpu_seconds).recip();
    let known = verdict == Verdict::Unbiased && last.relmse > 0.0;
    let cpu_seconds_by_sample = last.cpu_seconds / last.spp;
    let region = |i: usize| {
        let values: Vec<f64> = last_runs.iter().map(|run| run.error.regions[i]).collect();
        (mean(&values), deviation(&values) / (values.len() as f64).sqrt())
    };
    Finding {
        case: runs[0].case,
        configuration: runs[0].configuration,
        mse_by_samples: fit_of(|p| p.spp, |p| p.mse, &mse_replicates),
        relmse_by_seconds: fit_of(|p| p.cpu_seconds, |p| p.relmse, &relmse_replicates),
        relmse_by_samples,
        law,
        cpu_seconds_by_sample,
        efficiency: known.then(|| efficiency(last.relmse)),
        efficiency_interval: last
            .relmse_interval
            .filter(|interval| known && interval.low > 0.0)
            .map(|interval| Interval { low: efficiency(interval.high), high: efficiency(interval.low) }),
        bias: bias.mean,
        relative_bias: bias.mean / bias.reference_mean,
        bias_se: bias.standard_error,
        bias_z: bias.score(),
        verdict,
        biased,
        effective_pixels: bias.effective_pixels,
        floor: bias.floor,
        prices: prices(law, &points, cpu_seconds_by_sample),
        regions: (0..last_runs[0].error.regions.len()).map(region).collect(),
        points,
    }
}

/// Means and intervals of one group of runs.
fn point(runs: &[&Run], mse_replicates: Option<&[f64]>, relmse_replicates: Option<&[f64]>) -> Point {
    let of = |value: fn(&Run) -> f64| mean(&runs.iter().map(|run| value(run)).collect::<Vec<_>>());
    let rays = of(|run| run.rays.iter().sum::<u64>() as f64);
    let cpu_seconds = of(|run| run.cpu_seconds);
    let count = runs.len() as f64;
    let bias_se = of(|run| run.error.bias_se.powi(2)).sqrt() / count.sqrt();
    let lanes: Option<Vec<f64>> = runs.iter().map(|run| run.lanes_used).collect();
    Point {
        runs: runs.len(),
        spp: of(|run| 1.0 / run.spp as f64).recip(),
        seconds: of(|run| run.seconds),
        cpu_seconds,
        mse: of(|run| run.error.mse),
        mse_interval: mse_replicates.map(percentile_interval),
        relmse: of(|run| run.error.relmse),
        relmse_interval: relmse_replicates.map(percentile_interval),
        bias_z: if bias_se > 0.0 { of(|run| run.error.bias) / bias_se } else { 0.0 },
        mrays_per_s: if cpu_seconds > 0.0 { rays / cpu_seconds * 1e-6 } else { 0.0 },
        lanes_used: lanes.map(|lanes| mean(&lanes)),
    }
}

/// The law that predicts errors: with a floor if the picture is biased; -1 as the exponent unless the measured slope
/// excludes it.
fn law_of(points: &[Point], fit: Option<&Fit>, floor: Option<f64>) -> Option<Law> {
    // Inverse-variance weights of relMSE; equal relative weights where there is no interval.
    let usable: Vec<(f64, f64, f64)> = points
        .iter()
        .filter(|p| p.relmse > 0.0)
        .map(|p| {
            let width = p.relmse_interval.map_or(p.relmse, |i| i.high - i.low).max(1e-4 * p.relmse);
            (p.spp, p.relmse, width.powi(-2))
        })
        .collect();
    if usable.is_empty() {
        return None;
    }
    let sum = |term: &dyn Fn(&(f64, f64, f64)) -> f64| usable.iter().map(term).sum::<f64>();
    if let Some(floor) = floor {
        // Least squares for v in r = floor + v / n.
        let variance = sum(&|(n, r, w)| w * (r - floor) / n) / sum(&|(n, _, w)| w / (n * n));
        return Some(Law::Floor { floor, variance: variance.max(0.0) });
    }
    match fit {
        Some(Fit { law, slope_interval: Some(interval), .. }) if !interval.contains(-1.0) => {
            Some(Law::Power { constant: law.constant.exp(), slope: law.slope })
        }
        _ => Some(Law::Variance { variance: sum(&|(n, r, w)| w * r / n) / sum(&|(n, _, w)| w / (n * n)) }),
    }
}

/// What [`TARGETS`] cost under `law`.
fn prices(law: Option<Law>, points: &[Point], cpu_seconds_by_sample: f64) -> Vec<Price> {
    let (first, last) = (&points[0], &points[points.len() - 1]);
    let price = |error: f64| {
        let samples = law.and_then(|law| law.samples_for(error * error)).map(|samples| samples.max(1.0));
        Price {
            error,
            samples,
            cpu_seconds: samples.map(|samples| samples * cpu_seconds_by_sample),
            extrapolated: samples.is_some_and(|n| n < first.spp || n > last.spp),
        }
    };
    TARGETS.map(price).to_vec()
}

/// How many times the samples of `other` it takes `this` to reach the error that `other` has at its largest budget, with
/// its 95 % interval; `None` where one of them is biased.
pub fn sample_ratio(this: &Finding, other: &Finding) -> Option<(f64, Option<Interval>)> {
    if this.verdict != Verdict::Unbiased || other.verdict != Verdict::Unbiased {
        return None;
    }
    let (last, own) = (other.points.last()?, this.points.last()?);
    let ratio = this.law?.samples_for(other.law?.at(last.spp))? / last.spp;
    // Both errors are uncertain by themselves: relative half-widths add as roots of squares.
    let half = |point: &Point| Some((point.relmse_interval?.high / point.relmse_interval?.low).ln() / 2.0);
    let spread = half(last).zip(half(own)).map(|(a, b)| a.hypot(b)).filter(|spread| spread.is_finite());
    Some((ratio, spread.map(|s| Interval { low: ratio * (-s).exp(), high: ratio * s.exp() })))
}

#[cfg(test)]
#[path = "findings_tests.rs"]
mod tests;
