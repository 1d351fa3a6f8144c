//! From runs to findings: how fast each configuration's error falls, where it stops, what it costs.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::image::Image;
use crate::report::analysis::bias::{Bias, Floor, bias_of};
use crate::report::analysis::statistics::{
    Estimate, Fit, FitPoint, Interval, deviation, fit, mean, simultaneous_95, student_quantile,
};
use crate::report::measure::experiment::{Experiment, Measurements, Run};
use crate::report::measure::metrics::variance_of_channel_mean;
use crate::report::measure::run_error::Pool;
use crate::report::measure::spectrum::Spectrum;
use crate::report::measure::truth::Reference;

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
    /// 95 % interval of `mse`.
    pub mse_interval: Option<Interval>,
    /// Standard deviation of the runs' MSE.
    pub mse_deviation: f64,
    /// Relative mean squared error, mean over runs.
    pub relmse: f64,
    /// 95 % interval of `relmse`.
    pub relmse_interval: Option<Interval>,
    /// Standard deviation of the runs' relMSE.
    pub relmse_deviation: f64,
    /// relMSE without the worst pixel of every thousand of each run, mean over runs.
    pub relmse_trimmed: f64,
    /// Mean over runs of the bias, and its score from the spread of the runs' own standard errors.
    pub bias_z: f64,
    /// Millions of rays by CPU second.
    pub mrays_per_s: f64,
    /// Share of SIMD lanes that held work in the shading stages.
    pub lanes_used: Option<f64>,
    /// Share of SIMD lanes that held a live ray in the tree's packets.
    pub walk_lanes_used: Option<f64>,
    /// Mean relMSE by region.
    pub regions: Vec<f64>,
    /// The power spectrum of the error, mean over runs, less the reference's noise.
    pub spectrum: Option<Spectrum>,
    /// Share of the squared error in low frequencies, as a multiple of white noise's; `null` where the error is 0.
    pub low_frequencies: Option<f64>,
    /// `relmse` with its standard error.
    #[serde(skip)]
    estimate: Option<Estimate>,
}

/// How relMSE depends on the samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Law {
    /// variance / n: what independent samples do, assumed where there is one budget only.
    Variance {
        /// relMSE of one sample a pixel.
        variance: f64,
    },
    /// constant n^slope, as fitted.
    Power {
        /// relMSE of one sample a pixel.
        constant: f64,
        /// The exponent.
        slope: f64,
    },
    /// floor + constant n^slope: a biased estimator.
    Floor {
        /// The squared relative bias, which no number of samples lowers.
        floor: f64,
        /// relMSE of one sample a pixel, without it.
        constant: f64,
        /// The exponent of what samples lower.
        slope: f64,
    },
}

impl Law {
    /// relMSE of `n` samples a pixel.
    pub fn at(self, n: f64) -> f64 {
        match self {
            Law::Variance { variance } => variance / n,
            Law::Power { constant, slope } => constant * n.powf(slope),
            Law::Floor { floor, constant, slope } => floor + constant * n.powf(slope),
        }
    }

    /// Samples a pixel for a relMSE; `None` if there is no such number.
    pub fn samples_for(self, relmse: f64) -> Option<f64> {
        let samples = match self {
            Law::Variance { variance } => variance / relmse,
            Law::Power { constant, slope } => (relmse / constant).powf(1.0 / slope),
            Law::Floor { floor, constant, slope } => ((relmse - floor) / constant).powf(1.0 / slope),
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
    /// 95 % interval of `cpu_seconds`: of the samples by the fitted law, slope included; the time of a sample counts as known.
    pub interval: Option<Interval>,
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
    /// Index of the configuration; from the number of configurations on, of another renderer.
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
    /// The squared relative bias of the pixels: the relMSE of infinitely many samples, not below 0.
    pub floor: f64,
    /// 95 % interval of `floor`; `null` below three repeats.
    pub floor_interval: Option<Interval>,
    /// What [`TARGETS`], and the error of `--reach`, cost.
    pub prices: Vec<Price>,
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
                let exact = experiment.strategy(configuration).is_none_or(|strategy| !strategy.is_biased());
                findings.push(find(&runs, pool, &reference.image, exact, confidence, &targets));
            }
        }
    }
    findings
}

/// The finding of one configuration's runs. `exact`: by design, its expected picture is the truth; `confidence`: of a slope's
/// interval; `targets`: relative errors whose price is asked.
fn find(runs: &[&Run], pool: &Pool, reference: &Image, exact: bool, confidence: f64, targets: &[f64]) -> Finding {
    let mut by_budget: BTreeMap<usize, Vec<&Run>> = BTreeMap::new();
    runs.iter().for_each(|run| by_budget.entry(run.budget).or_default().push(run));
    let groups: Vec<Vec<&Run>> = by_budget.into_values().collect();
    let bias = bias_of(pool, &groups, reference);
    let noise = white_noise(reference);
    let points: Vec<Point> = groups.iter().map(|group| point(group, bias.floor.shared_variance, noise)).collect();
    let mse = |group: &Vec<&Run>| estimate(group, |run| &run.error.mse_by_tile);
    let mse_estimates: Vec<Option<Estimate>> = groups.iter().map(mse).collect();
    let relmse_estimates: Vec<Option<Estimate>> = points.iter().map(|point| point.estimate).collect();
    let fit_of = |x: fn(&Point) -> f64, y: fn(&Point) -> f64, estimates: &[Option<Estimate>]| {
        let usable = points.iter().zip(estimates).filter(|(point, _)| x(point) > 0.0 && y(point) > 0.0);
        let usable = usable.map(|(point, estimate)| FitPoint {
            x: x(point),
            y: y(point),
            error: estimate.map(|estimate| (estimate.relative_error(), estimate.freedom)),
        });
        fit(&usable.collect::<Vec<_>>(), confidence)
    };
    let relmse_by_samples = fit_of(|p| p.spp, |p| p.relmse, &relmse_estimates);
    let verdict = match bias.score() {
        z if z.abs() <= BIAS_Z => Verdict::Unbiased,
        z if z < 0.0 && exact && bias.effective_pixels < 0.1 * reference.pixels.len() as f64 => Verdict::Undersampled,
        _ => Verdict::Biased,
    };
    let biased = verdict == Verdict::Biased;
    let law = match biased && bias.floor.value > 0.0 {
        true => law_with_floor(&points, bias.floor),
        false => law_of(&points, relmse_by_samples.as_ref()),
    };
    let last = &points[points.len() - 1];
    let efficiency = |relmse: f64| (relmse * last.cpu_seconds).recip();
    let known = verdict == Verdict::Unbiased && last.relmse > 0.0 && last.cpu_seconds > 0.0;
    let cpu_seconds_by_sample = last.cpu_seconds / last.spp;
    let relmse_by_seconds = fit_of(|p| p.cpu_seconds, |p| p.relmse, &relmse_estimates);
    let price = |error: f64| match last.spp > 0.0 {
        true => price(error, law, relmse_by_samples.as_ref(), &points),
        false => price_by_seconds(error, relmse_by_seconds.as_ref(), &points),
    };
    Finding {
        case: runs[0].case,
        configuration: runs[0].configuration,
        mse_by_samples: fit_of(|p| p.spp, |p| p.mse, &mse_estimates),
        relmse_by_seconds,
        relmse_by_samples,
        law,
        cpu_seconds_by_sample,
        efficiency: known.then(|| efficiency(last.relmse)),
        efficiency_interval: last.relmse_interval.filter(|_| known).map(|interval| interval.map(efficiency)),
        bias: bias.mean,
        relative_bias: bias.mean / bias.reference_mean,
        bias_se: bias.standard_error,
        bias_z: bias.score(),
        verdict,
        biased,
        effective_pixels: bias.effective_pixels,
        floor: bias.floor.value.max(0.0),
        floor_interval: floor_interval(&bias),
        prices: targets.iter().map(|error| price(*error)).collect(),
        points,
    }
}

/// The mean over runs of what their tiles add up to.
fn estimate(group: &[&Run], tiles: fn(&Run) -> &[f64]) -> Option<Estimate> {
    Estimate::of_strata(&group.iter().map(|run| tiles(run)).collect::<Vec<_>>())
}

/// The interval of the floor, not below 0.
fn floor_interval(bias: &Bias) -> Option<Interval> {
    let interval = bias.floor.estimate?.interval();
    Some(interval.map(|end| end.max(0.0)))
}

/// The mean variance of the reference's pixels, channels averaged: white noise in the spectrum of every error.
fn white_noise(reference: &Image) -> f64 {
    let variances = reference.variance.iter().flatten().map(variance_of_channel_mean);
    variances.sum::<f64>() / reference.pixels.len() as f64
}

/// Means and intervals of one group of runs; `shared` is the part of relMSE's variance that is the same in all of them,
/// `noise` the reference's in the spectrum.
fn point(runs: &[&Run], shared: f64, noise: f64) -> Point {
    let spectra: Vec<Spectrum> = runs.iter().map(|run| run.spectrum.clone()).collect();
    let spectrum = Spectrum::mean(&spectra).map(|mean| mean.without_white_noise(noise));
    let values = |value: fn(&Run) -> f64| runs.iter().map(|run| value(run)).collect::<Vec<_>>();
    let of = |value: fn(&Run) -> f64| mean(&values(value));
    let rays = of(|run| run.rays.iter().sum::<u64>() as f64);
    let cpu_seconds = of(|run| run.cpu_seconds);
    let bias_se = of(|run| run.error.bias_se.powi(2)).sqrt() / (runs.len() as f64).sqrt();
    let shares = |share: fn(&Run) -> Option<f64>| {
        let known: Option<Vec<f64>> = runs.iter().map(|run| share(run)).collect();
        known.map(|shares| mean(&shares))
    };
    let estimate_of_relmse = estimate(runs, |run| &run.error.relmse_by_tile).map(|estimate| estimate.and(shared));
    let regions = 0..runs[0].error.regions.len();
    Point {
        runs: runs.len(),
        spp: of(|run| 1.0 / run.spp as f64).recip(),
        seconds: of(|run| run.seconds),
        cpu_seconds,
        mse: of(|run| run.error.mse),
        mse_interval: estimate(runs, |run| &run.error.mse_by_tile).and_then(Estimate::interval_of_logarithm),
        mse_deviation: deviation(&values(|run| run.error.mse)),
        relmse: of(|run| run.error.relmse),
        relmse_interval: estimate_of_relmse.and_then(Estimate::interval_of_logarithm),
        relmse_deviation: deviation(&values(|run| run.error.relmse)),
        relmse_trimmed: of(|run| run.error.relmse_trimmed),
        bias_z: if bias_se > 0.0 { of(|run| run.error.bias) / bias_se } else { 0.0 },
        mrays_per_s: if cpu_seconds > 0.0 { rays / cpu_seconds * 1e-6 } else { 0.0 },
        lanes_used: shares(|run| run.lanes_used),
        walk_lanes_used: shares(|run| run.walk_lanes_used),
        regions: regions.map(|i| mean(&runs.iter().map(|run| run.error.regions[i]).collect::<Vec<_>>())).collect(),
        low_frequencies: spectrum.as_ref().and_then(Spectrum::low_frequency_share),
        spectrum,
        estimate: estimate_of_relmse,
    }
}

/// The fitted power law; of a single budget what independent samples do.
fn law_of(points: &[Point], fit: Option<&Fit>) -> Option<Law> {
    let falls = fit.filter(|fit| fit.law.slope < 0.0);
    if let Some(Fit { law, .. }) = falls {
        return Some(Law::Power { constant: law.constant.exp(), slope: law.slope });
    }
    let last = points.iter().rev().find(|point| point.relmse > 0.0 && point.spp > 0.0)?;
    Some(Law::Variance { variance: last.relmse * last.spp })
}

/// The floor and a power law for what is above it, of the budgets that are clearly above it.
fn law_with_floor(points: &[Point], floor: Floor) -> Option<Law> {
    let of_floor = floor.estimate.map_or(0.0, |estimate| estimate.standard_error);
    let above = |point: &Point| {
        let rest = point.relmse - floor.value;
        let deviation = point.estimate.map_or(0.05 * point.relmse, |estimate| estimate.standard_error).hypot(of_floor);
        let error = Some((deviation / rest, f64::INFINITY));
        (rest > 2.0 * deviation).then_some(FitPoint { x: point.spp, y: rest, error })
    };
    let above: Vec<FitPoint> = points.iter().filter_map(above).collect();
    if let Some(Fit { law, .. }) = fit(&above, 0.95).filter(|fit| fit.law.slope < 0.0) {
        return Some(Law::Floor { floor: floor.value, constant: law.constant.exp(), slope: law.slope });
    }
    let constant = above.first().map_or(0.0, |point| point.y * point.x);
    Some(Law::Floor { floor: floor.value, constant, slope: -1.0 })
}

/// What the relative error `error` costs under `law`, which is that of `fit` where it is a power law.
fn price(error: f64, law: Option<Law>, fit: Option<&Fit>, points: &[Point]) -> Price {
    let (first, last) = (&points[0], &points[points.len() - 1]);
    let by_sample = last.cpu_seconds / last.spp;
    let samples = law.and_then(|law| law.samples_for(error * error)).map(|samples| samples.max(1.0));
    let interval =
        fit.filter(|_| matches!(law, Some(Law::Power { .. }))).and_then(|fit| fit.inverse(error * error, 0.0).1);
    Price {
        error,
        samples,
        cpu_seconds: samples.map(|samples| samples * by_sample),
        interval: interval.map(|samples| samples.map(|samples| samples.max(1.0) * by_sample)),
        extrapolated: samples.is_some_and(|n| n < first.spp || n > last.spp),
    }
}

/// What the relative error `error` costs a renderer whose samples are not known.
fn price_by_seconds(error: f64, fit: Option<&Fit>, points: &[Point]) -> Price {
    let found = fit.map(|fit| fit.inverse(error * error, 0.0));
    let measured = points[0].cpu_seconds..=points[points.len() - 1].cpu_seconds;
    Price {
        error,
        samples: None,
        cpu_seconds: found.map(|(cpu_seconds, _)| cpu_seconds),
        interval: found.and_then(|(_, interval)| interval),
        extrapolated: found.is_some_and(|(cpu_seconds, _)| !measured.contains(&cpu_seconds)),
    }
}

/// How many times the samples of `other` it takes `this` to reach the error that `other` has at its largest budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRatio {
    /// The ratio.
    pub value: f64,
    /// Its 95 % interval: that of the line fitted to `this`, slope included, and of the error of `other`.
    pub interval: Option<Interval>,
    /// `this` was not run with so many samples.
    pub extrapolated: bool,
}

/// The ratio of samples for the error of `other`; `None` where one of them is biased.
pub fn sample_ratio(this: &Finding, other: &Finding) -> Option<SampleRatio> {
    if this.verdict != Verdict::Unbiased || other.verdict != Verdict::Unbiased {
        return None;
    }
    let (last, own_last) = (other.points.last()?, this.points.last()?);
    let samples = this.law?.samples_for(last.relmse)?;
    let interval = match (this.law?, last.estimate, own_last.estimate) {
        (Law::Power { .. }, Some(estimate), _) => {
            this.relmse_by_samples?.inverse(last.relmse, estimate.relative_error()).1
        }
        // One budget: both errors are uncertain by themselves.
        (Law::Variance { .. }, Some(theirs), Some(own)) => {
            let half = theirs.relative_error().hypot(own.relative_error());
            let half = student_quantile(0.95, theirs.freedom.min(own.freedom)) * half;
            Some(Interval::around_log(samples, half))
        }
        _ => None,
    };
    Some(SampleRatio {
        value: samples / last.spp,
        interval: interval.map(|samples| samples.map(|samples| samples / last.spp)),
        extrapolated: samples > own_last.spp || samples < this.points[0].spp,
    })
}

#[cfg(test)]
#[path = "findings_tests.rs"]
mod tests;
