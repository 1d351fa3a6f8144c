//! The bias of many runs together: the one figure that more samples do not lower.

use crate::image::Image;
use crate::report::analysis::statistics::{deviation, mean};
use crate::report::measure::experiment::Run;
use crate::report::measure::metrics::{FLOOR, variance_of_channel_mean};
use crate::report::measure::run_error::Pool;

/// How far the expected picture is from the reference.
pub struct Bias {
    /// Mean of picture - reference over pixels and channels.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Mean of the reference.
    pub reference_mean: f64,
    /// The squared relative bias of the pixels.
    pub floor: f64,
    /// (sum v)^2 / sum v^2 of the pixels' variances v.
    pub effective_pixels: f64,
}

impl Bias {
    /// `mean` over its standard error; 0 where nothing varies.
    pub fn score(&self) -> f64 {
        if self.standard_error > 0.0 { self.mean / self.standard_error } else { 0.0 }
    }
}

/// The bias of all runs together. Its standard error is the larger of two: what the runs know of their own variance, and
/// how far repeats are apart; the reference's noise comes on top. Without a pool (one sample a pixel everywhere) the runs'
/// own figures are combined.
pub fn bias_of(pool: &Pool, groups: &[Vec<&Run>], reference: &Image) -> Bias {
    let pixels = reference.pixels.len() as f64;
    let reference_mean = reference.pixels.iter().flatten().map(|v| *v as f64).sum::<f64>() / (3.0 * pixels);
    let Some(pooled) = pool.image(reference.width, reference.height) else {
        let runs = || groups.iter().flatten();
        let biases: Vec<f64> = runs().map(|run| run.error.bias).collect();
        let squares: f64 = runs().map(|run| run.error.bias_se.powi(2)).sum();
        let standard_error = squares.sqrt() / biases.len() as f64;
        return Bias { mean: mean(&biases), standard_error, reference_mean, floor: 0.0, effective_pixels: pixels };
    };
    let (mut bias, mut floor, mut own_sum, mut own_squares, mut theirs_sum) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let none = [0.0; 3];
    for (i, (a, b)) in pooled.pixels.iter().zip(&reference.pixels).enumerate() {
        let own = pooled.variance.as_ref().map_or(none, |v| v[i]);
        let theirs = reference.variance.as_ref().map_or(none, |v| v[i]);
        let own_variance = variance_of_channel_mean(&own);
        own_sum += own_variance;
        own_squares += own_variance * own_variance;
        theirs_sum += variance_of_channel_mean(&theirs);
        for c in 0..3 {
            let (value, truth) = (a[c] as f64, b[c] as f64);
            bias += (value - truth) / 3.0;
            let noise = own[c] as f64 + theirs[c] as f64;
            floor += ((value - truth).powi(2) - noise) / (truth * truth + FLOOR) / 3.0;
        }
    }
    let own = (own_sum / (pixels * pixels)).max(variance_by_repeats(groups));
    Bias {
        mean: bias / pixels,
        standard_error: (own + theirs_sum / (pixels * pixels)).sqrt(),
        reference_mean,
        floor: (floor / pixels).max(0.0),
        effective_pixels: if own_squares > 0.0 { own_sum * own_sum / own_squares } else { pixels },
    }
}

/// The variance of the mean of a pool, from how far the biases of equally long runs are apart.
fn variance_by_repeats(groups: &[Vec<&Run>]) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    // Runs of one sample a pixel are not in the pool.
    for group in groups.iter().filter(|group| group[0].spp > 1) {
        let biases: Vec<f64> = group.iter().map(|run| run.error.bias).collect();
        let spp: f64 = group.iter().map(|run| run.spp as f64).sum::<f64>();
        squares += (spp * deviation(&biases)).powi(2) / group.len() as f64;
        samples += spp;
    }
    if samples > 0.0 { squares / (samples * samples) } else { 0.0 }
}
