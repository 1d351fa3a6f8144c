//! The truth that runs are compared with.

use serde::Serialize;

use crate::image::Image;
use crate::report::measure::metrics::{FLOOR, variance_of_channel_mean};

/// The mean variance of the reference's pixels, channels averaged: white noise in the spectrum of every error.
pub fn white_noise(reference: &Image) -> f64 {
    let variances = reference.variance.iter().flatten().map(variance_of_channel_mean);
    variances.sum::<f64>() / reference.pixels.len() as f64
}

/// Where a reference comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Source {
    /// Worked out on paper; exact.
    ClosedForm,
    /// Read from a file; exact unless the file has variance layers.
    File {
        /// Its path.
        path: String,
    },
    /// Rendered, with seeds that no run has.
    Rendered {
        /// The strategy; it is exact.
        strategy: &'static str,
        /// Its light selection.
        lights: &'static str,
        /// Its sampler.
        sampler: &'static str,
        /// Samples a pixel.
        spp: u32,
        /// Wall seconds it took.
        seconds: f64,
        /// CPU seconds it took.
        cpu_seconds: f64,
        /// It was taken from an earlier call.
        cached: bool,
    },
}

/// A reference.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The image; its variance layers are its noise, none: exact.
    pub image: Image,
    /// Where it comes from.
    pub source: Source,
}

impl Reference {
    /// Its noise as it enters every MSE and relMSE; 0 where it is exact.
    pub fn noise(&self) -> (f64, f64) {
        let Some(variance) = &self.image.variance else { return (0.0, 0.0) };
        let (mut mse, mut relmse) = (0.0, 0.0);
        for (v, b) in variance.iter().flatten().zip(self.image.pixels.iter().flatten()) {
            mse += *v as f64;
            relmse += *v as f64 / ((*b as f64).powi(2) + FLOOR);
        }
        let count = 3.0 * self.image.pixels.len() as f64;
        (mse / count, relmse / count)
    }
}
