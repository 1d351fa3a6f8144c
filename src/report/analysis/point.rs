//! The runs of one configuration with one budget: means, intervals, and whether these can be relied on.

use serde::Serialize;

use crate::report::analysis::curve::Knot;
use crate::report::analysis::statistics::{Estimate, Interval, deviation, mean};
use crate::report::measure::experiment::Run;
use crate::report::measure::run_error::{TRIMMED, mean_bias};
use crate::report::measure::spectrum::Spectrum;

/// A few pixels rule where the rest has no more than this share of the error.
const OUTLIERS_LEAVE: f64 = 0.25;
/// They rule as well where the variance of the error between runs is that of fewer tiles.
const FEW_TILES: f64 = 3.0;

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
    /// A few pixels rule the error: those of [`TRIMMED`] hold three quarters of it, or its spread between runs is that of fewer
    /// than three tiles. Then neither its mean nor any interval can be relied on: none is given, and the point takes no
    /// part in slopes and prices.
    pub outliers: bool,
    /// `mse` with its standard error.
    #[serde(skip)]
    pub mse_estimate: Option<Estimate>,
    /// `relmse` with its standard error.
    #[serde(skip)]
    pub relmse_estimate: Option<Estimate>,
}

impl Point {
    /// The point of the curve of MSE against samples a pixel.
    pub fn mse_by_samples(&self) -> Option<Knot> {
        self.knot(self.spp, self.mse, self.mse_estimate)
    }

    /// The point of the curve of relMSE against samples a pixel.
    pub fn relmse_by_samples(&self) -> Option<Knot> {
        self.knot(self.spp, self.relmse, self.relmse_estimate)
    }

    /// The point of the curve of relMSE against CPU seconds.
    pub fn relmse_by_seconds(&self) -> Option<Knot> {
        self.knot(self.cpu_seconds, self.relmse, self.relmse_estimate)
    }

    fn knot(&self, cost: f64, value: f64, estimate: Option<Estimate>) -> Option<Knot> {
        (!self.outliers).then_some(Knot { cost, value, error: estimate.map(Estimate::of_logarithm) })
    }
}

/// The mean over runs of what their tiles add up to.
fn estimate(group: &[&Run], tiles: fn(&Run) -> &[f64]) -> Option<Estimate> {
    Estimate::of_strata(&group.iter().map(|run| tiles(run)).collect::<Vec<_>>())
}

/// Means and intervals of one group of runs of images of so many pixels; `shared` is the part of relMSE's variance that is the same in all of them,
/// `noise` the reference's in the spectrum.
pub fn point(runs: &[&Run], pixels: usize, shared: f64, noise: f64) -> Point {
    let spectra: Vec<Spectrum> = runs.iter().map(|run| run.spectrum.clone()).collect();
    let spectrum = Spectrum::mean(&spectra).map(|mean| mean.without_white_noise(noise));
    let values = |value: fn(&Run) -> f64| runs.iter().map(|run| value(run)).collect::<Vec<_>>();
    let of = |value: fn(&Run) -> f64| mean(&values(value));
    let rays = of(|run| run.rays.iter().sum::<u64>() as f64);
    let cpu_seconds = of(|run| run.cpu_seconds);
    let (bias, bias_se) = mean_bias(runs.iter().map(|run| &run.error), noise / pixels as f64);
    let shares = |share: fn(&Run) -> Option<f64>| {
        let known: Option<Vec<f64>> = runs.iter().map(|run| share(run)).collect();
        known.map(|shares| mean(&shares))
    };
    let mse_estimate = estimate(runs, |run| &run.error.mse_by_tile);
    let of_runs = estimate(runs, |run| &run.error.relmse_by_tile);
    let relmse_estimate = of_runs.map(|estimate| estimate.and(shared));
    let (relmse, relmse_trimmed) = (of(|run| run.error.relmse), of(|run| run.error.relmse_trimmed));
    let few_tiles = of_runs.is_some_and(|estimate| {
        estimate.standard_error > 0.0 && estimate.freedom < FEW_TILES * (runs.len() - 1) as f64
    });
    let outliers = pixels >= TRIMMED && (few_tiles || relmse_trimmed < OUTLIERS_LEAVE * relmse);
    let interval =
        |estimate: Option<Estimate>| estimate.filter(|_| !outliers).and_then(Estimate::interval_of_logarithm);
    let regions = 0..runs[0].error.regions.len();
    Point {
        runs: runs.len(),
        spp: of(|run| 1.0 / run.spp as f64).recip(),
        seconds: of(|run| run.seconds),
        cpu_seconds,
        mse: of(|run| run.error.mse),
        mse_interval: interval(mse_estimate),
        mse_deviation: deviation(&values(|run| run.error.mse)),
        relmse,
        relmse_interval: interval(relmse_estimate),
        relmse_deviation: deviation(&values(|run| run.error.relmse)),
        relmse_trimmed,
        bias_z: if bias_se > 0.0 { bias / bias_se } else { 0.0 },
        mrays_per_s: if cpu_seconds > 0.0 { rays / cpu_seconds * 1e-6 } else { 0.0 },
        lanes_used: shares(|run| run.lanes_used),
        walk_lanes_used: shares(|run| run.walk_lanes_used),
        regions: regions.map(|i| mean(&runs.iter().map(|run| run.error.regions[i]).collect::<Vec<_>>())).collect(),
        low_frequencies: spectrum.as_ref().and_then(Spectrum::low_frequency_share),
        spectrum,
        outliers,
        mse_estimate,
        relmse_estimate,
    }
}
