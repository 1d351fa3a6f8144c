//! The bias of many runs together: the one figure that more samples do not lower.

use crate::image::Image;
use crate::report::analysis::statistics::{Estimate, deviation};
use crate::report::measure::experiment::Run;
use crate::report::measure::metrics::{FLOOR, variance_of_channel_mean};
use crate::report::measure::run_error::{PARTS, Pool, TILES, mean_bias, tile_of};
use crate::report::measure::truth::white_noise;

/// Images of single precision agree to this share of their mean.
const ROUNDING: f64 = 1e-6;

/// How far the expected image is from the reference.
pub struct Bias {
    /// Mean of image - reference over pixels and channels.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Mean of the reference.
    pub reference_mean: f64,
    /// The squared relative bias of the pixels: the relMSE of infinitely many samples. Not cut at 0.
    pub floor: Floor,
    /// (sum v)^2 / sum v^2 of the pixels' variances v.
    pub effective_pixels: f64,
}

/// The squared relative bias, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Floor {
    /// The estimate; 0 where there is none.
    pub value: f64,
    /// How certain it is; `None` with fewer than three parts in the pool.
    pub estimate: Option<Estimate>,
    /// The part of any relMSE's variance that comes from the reference's own noise and is the same in all runs.
    pub shared_variance: f64,
}

/// The bias of all runs together. Its standard error is the larger of two: what the runs know of their own variance, and
/// how far repeats are apart; the reference's noise comes on top. Without a pool (one sample a pixel everywhere, or images
/// without variance) the runs' own figures are combined, each by its certainty.
pub fn bias_of(pool: &Pool, groups: &[Vec<&Run>], reference: &Image) -> Bias {
    let pixels = reference.pixels.len() as f64;
    let reference_mean = reference.pixels.iter().flatten().map(|v| *v as f64).sum::<f64>() / (3.0 * pixels);
    let floor = floor_of(pool, reference);
    let Some(pooled) = pool.image(reference.width, reference.height) else {
        let of_reference = white_noise(reference) / pixels;
        let (mean, standard_error) = mean_bias(groups.iter().flatten().map(|run| &run.error), of_reference);
        return Bias { mean, standard_error, reference_mean, floor, effective_pixels: pixels };
    };
    let (mut bias, mut own_sum, mut own_squares, mut theirs_sum) = (0.0, 0.0, 0.0, 0.0);
    for (i, (a, b)) in pooled.pixels.iter().zip(&reference.pixels).enumerate() {
        let own = pooled.variance.as_ref().map_or([0.0; 3], |v| v[i]);
        let own_variance = variance_of_channel_mean(&own);
        own_sum += own_variance;
        own_squares += own_variance * own_variance;
        theirs_sum += variance_of_channel_mean(&noise(reference, i));
        bias += (0..3).map(|c| a[c] as f64 - b[c] as f64).sum::<f64>() / 3.0;
    }
    let own = (own_sum / (pixels * pixels)).max(variance_by_repeats(groups));
    Bias {
        mean: bias / pixels,
        standard_error: (own + theirs_sum / (pixels * pixels)).sqrt(),
        reference_mean,
        floor,
        effective_pixels: if own_squares > 0.0 { own_sum * own_sum / own_squares } else { pixels },
    }
}

impl Bias {
    /// `mean` over its standard error. Where nothing varies: 0 for the reference but for rounding, infinite for anything else.
    pub fn score(&self) -> f64 {
        let rounding = ROUNDING * self.reference_mean.abs();
        match self.standard_error > 0.0 {
            true => self.mean / self.standard_error,
            false if self.mean.abs() <= rounding => 0.0,
            false => f64::INFINITY.copysign(self.mean),
        }
    }
}

/// The reference's variance in pixel `i`.
fn noise(reference: &Image, i: usize) -> [f32; 3] {
    reference.variance.as_ref().map_or([0.0; 3], |variance| variance[i])
}

/// The squared relative bias of the pool's expected image.
///
/// Of independent parts k and l with errors d_k and d_l against the reference, the expectation of d_k d_l is the squared
/// bias and the reference's variance, whatever the parts' own noise is: so it is the mean over all pairs of different parts,
/// weighed by their samples, less the reference's noise. Its standard error comes from leaving out each part in turn (the
/// jackknife), tile by tile, and from [`shared_variance`].
fn floor_of(pool: &Pool, reference: &Image) -> Floor {
    let parts: Vec<(f64, &[[f64; 3]])> = pool.parts().collect();
    let (width, height) = (reference.width as usize, reference.height as usize);
    let share = 1.0 / (3.0 * reference.pixels.len() as f64);
    // By tile: of all parts, then without each of them.
    let mut tiles = vec![[0.0; 1 + PARTS]; TILES * TILES];
    let mut shared = 0.0;
    let subsets: Vec<Vec<usize>> = std::iter::once((0..parts.len()).collect())
        .chain((0..parts.len()).map(|left_out| (0..parts.len()).filter(|part| *part != left_out).collect()))
        .collect();
    for (i, truth) in reference.pixels.iter().enumerate() {
        let tile = tile_of(i, width, height);
        let (truth, variance) = (truth.map(f64::from), noise(reference, i).map(f64::from));
        let weight = truth.map(|value| share / (value * value + FLOOR));
        let errors: Vec<(f64, [f64; 3])> = parts
            .iter()
            .map(|(samples, sums)| (*samples, std::array::from_fn(|c| sums[i][c] / samples - truth[c])))
            .collect();
        for (sum, subset) in tiles[tile].iter_mut().zip(&subsets) {
            let channel = |c: usize| weight[c] * (mean_of_pairs(&errors, subset, |error| error[c]) - variance[c]);
            *sum += (0..3).map(channel).sum::<f64>();
        }
        shared += shared_variance(&errors, &subsets[0], truth, weight, variance);
    }
    let shared_variance = shared.max(0.0);
    if parts.len() < 2 {
        return Floor { shared_variance, ..Floor::default() };
    }
    let value = tiles.iter().map(|tile| tile[0]).sum();
    let estimate = (parts.len() > 2).then(|| {
        let count = parts.len() as f64;
        let jackknife =
            tiles.iter().map(|tile| deviation(&tile[1..=parts.len()]).powi(2) * (count - 1.0).powi(2) / count);
        Estimate::of_variances(value, jackknife, parts.len()).and(shared_variance)
    });
    Floor { value, estimate, shared_variance }
}

/// What one pixel adds to the variance of a relMSE by the noise of the reference alone, which is the same in all runs.
///
/// A pixel's part w (d - e)^2 for error d, noise e and weight w = s / (b^2 + 0.01), which e moves too, has the derivative
/// -2 w d (1 + b d w / s) by e; the channels' noise counts as fully correlated. The square of what is linear is taken over
/// pairs of parts, so that their own noise does not enter; of w e^2 the variance is 2 w^2 (var e)^2.
fn shared_variance(
    errors: &[(f64, [f64; 3])],
    all: &[usize],
    truth: [f64; 3],
    weight: [f64; 3],
    variance: [f64; 3],
) -> f64 {
    let of_noise: f64 = (0..3).map(|c| weight[c] * variance[c]).sum();
    let linear = |error: [f64; 3]| {
        let channel = |c: usize| {
            let relative = truth[c] * error[c] / (truth[c] * truth[c] + FLOOR);
            2.0 * weight[c] * error[c] * (1.0 + relative) * variance[c].sqrt()
        };
        (0..3).map(channel).sum::<f64>()
    };
    mean_of_pairs(errors, all, linear) + 2.0 * of_noise * of_noise
}

/// The mean of f(d_k) f(d_l) over pairs of different parts, weighed by samples; 0 below two parts.
fn mean_of_pairs(errors: &[(f64, [f64; 3])], subset: &[usize], value: impl Fn([f64; 3]) -> f64) -> f64 {
    let (mut products, mut weights) = (0.0, 0.0);
    for (position, &k) in subset.iter().enumerate() {
        for &l in &subset[position + 1..] {
            let weight = errors[k].0 * errors[l].0;
            products += weight * value(errors[k].1) * value(errors[l].1);
            weights += weight;
        }
    }
    if weights > 0.0 { products / weights } else { 0.0 }
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
