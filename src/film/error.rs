//! The relative error of many pixels together, estimated from the spread of their own samples.

use crate::fault::{Fault, planted};
use crate::film::sums::Sums;

/// What the error estimate needs of some pixels with equally many samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorSums {
    /// Pixels counted.
    pixels: f64,
    /// Sum of the variances of the pixels' means, channels averaged.
    variance: f64,
    /// Sum of the squares of those variances.
    variance_squares: f64,
    /// Sum of the pixels' means, channels averaged.
    mean: f64,
}

impl ErrorSums {
    /// Of pixels; nothing is known where they do not tell errors.
    pub fn of(pixels: Sums) -> ErrorSums {
        let mut sums = ErrorSums::default();
        if !pixels.tell_errors() {
            return sums;
        }
        for (index, pixel) in pixels.pixels.iter().enumerate() {
            let variance = pixels.variance(index).iter().sum::<f64>() / 3.0;
            let variance = if planted(Fault::SmallErrors) { variance / 16.0 } else { variance };
            sums.variance += variance;
            sums.variance_squares += variance * variance;
            sums.mean += pixel.sum.iter().sum::<f64>() / (3.0 * pixels.spp as f64);
        }
        sums.pixels = pixels.pixels.len() as f64;
        sums
    }

    /// Adds other pixels.
    pub fn add(&mut self, other: &ErrorSums) {
        self.pixels += other.pixels;
        self.variance += other.variance;
        self.variance_squares += other.variance_squares;
        self.mean += other.mean;
    }

    /// The relative error of all these pixels and its standard error, as
    /// [`crate::film::Film::relative_error_estimate`] defines them.
    pub fn estimate(&self) -> Option<(f64, f64)> {
        let ErrorSums { pixels: count, variance, variance_squares, mean } = *self;
        if mean.is_nan() || mean <= 0.0 {
            return None;
        }
        let error = (variance / count).sqrt() / (mean / count);
        // The delta method: a root has half the relative error of its argument.
        let of_variance = (2.0 * variance_squares).sqrt() / variance;
        Some((error, if variance > 0.0 { 0.5 * error * of_variance } else { 0.0 }))
    }
}
