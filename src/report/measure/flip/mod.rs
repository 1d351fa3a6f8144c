//! FLIP: how large the difference between two images looks to someone who flips between them on a display.
//!
//! Written after the papers: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images" (Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2),
//! 2020), and Andersson, Nilsson, Shirley and Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range
//! Images" (Eurographics short papers, 2021). The figures are those of version 1.7 of the authors' program: separable
//! filters with its truncation and normalisation, the upper of two middle luminances as the median, and the same range
//! of exposures. That program computes in f32; tests hold ours to its output.
//!
//! The error of a pixel lies in [0, 1]: 0 where no difference can be seen, 1 between pure green and pure blue over a
//! wide area. It is c^(1 - f): the difference `c` of colours, after what the eye cannot resolve at that distance is
//! filtered away (`color`), raised by the difference `f` of edges and points (`filters`). The mean over pixels is
//! the figure to quote, with the number of pixels per degree.
//!
//! [`ldr`] judges display images: radiance times 2^exposure, cut to [0, 1], not rounded to 8 bits. [`hdr`] takes the
//! largest error of each pixel over all exposures at which the reference can be looked at (`exposure`), so highlights
//! and shadows both count and no exposure has to be chosen.
//!
//! FLIP sees noise as a viewer does, at one size of display. It is no estimate of variance, and it is not additive.

mod color;
mod exposure;
mod filters;
#[cfg(test)]
mod flip_tests;

pub use exposure::{Exposures, exposures};

use crate::image::Image;
use filters::{Filters, Window};
use glam::DVec3;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Pixels per degree of visual angle at 0.7 m from a display that shows 3,840 pixels on 0.7 m: 67.02, the authors'
/// default.
pub const PIXELS_PER_DEGREE: f64 = 3_840.0 * std::f64::consts::PI / 180.0;

/// The error of every pixel of `test` against `reference`, both shown with `exposure` stops; row by row from the top.
///
/// # Panics
/// If the sizes differ. Values must be finite ([`super::metrics::check`]).
pub fn ldr(test: &Image, reference: &Image, exposure: f64, pixels_per_degree: f64) -> Vec<f64> {
    let scale = libm::exp2(exposure);
    let show = |radiance: DVec3| (radiance * scale).clamp(DVec3::ZERO, DVec3::ONE);
    error_map(test, reference, show, &Filters::new(pixels_per_degree))
}

/// The largest error of every pixel of `test` against `reference` over the [`exposures`] of the reference; row by row
/// from the top. Values below 0 count as 0.
///
/// # Panics
/// If the sizes differ. Values must be finite ([`super::metrics::check`]).
pub fn hdr(test: &Image, reference: &Image, pixels_per_degree: f64) -> Vec<f64> {
    let filters = Filters::new(pixels_per_degree);
    let stops: Vec<f64> = exposures(reference).stops().collect();
    let next = AtomicUsize::new(0);
    // Exposures are far apart from each other and alike in work: threads take them in turn. A maximum knows no order.
    let take = || {
        let mut largest = vec![0.0; reference.pixels.len()];
        while let Some(stops) = stops.get(next.fetch_add(1, Ordering::Relaxed)) {
            let scale = libm::exp2(*stops);
            let show = |radiance: DVec3| exposure::tone_map(radiance.max(DVec3::ZERO) * scale);
            keep_larger(&mut largest, &error_map(test, reference, show, &filters));
        }
        largest
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(stops.len());
    std::thread::scope(|scope| {
        // Where the system refuses to start a thread, those that there are do its work.
        let start = |_| std::thread::Builder::new().spawn_scoped(scope, take).ok();
        let others: Vec<_> = (1..threads).map_while(start).collect();
        let mut largest = take();
        for other in others {
            match other.join() {
                Ok(errors) => keep_larger(&mut largest, &errors),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        largest
    })
}

/// The larger of both, pixel by pixel.
fn keep_larger(largest: &mut [f64], errors: &[f64]) {
    for (largest, error) in largest.iter_mut().zip(errors) {
        *largest = error.max(*largest);
    }
}

/// The mean of an error map: the one figure that is quoted. 0 for a map without pixels.
pub fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

/// The error of every pixel of `test` against `reference`; `show` makes displayed linear Rec.709 in [0, 1] of radiance.
fn error_map(test: &Image, reference: &Image, show: impl Fn(DVec3) -> DVec3 + Copy, filters: &Filters) -> Vec<f64> {
    assert_eq!((test.width, test.height), (reference.width, reference.height), "images of one size");
    let mut windows = [test, reference].map(|image| Window::new(image, show, filters));
    let mut errors = Vec::with_capacity(reference.pixels.len());
    for y in 0..reference.height as usize {
        let [test, reference] = windows.each_mut().map(|window| window.row(y));
        let pixels = test.colors.iter().zip(&reference.colors).zip(test.features.iter().zip(&reference.features));
        errors.extend(pixels.map(|((color_a, color_b), (features_a, features_b))| {
            let features = filters::feature_difference(*features_a, *features_b);
            libm::pow(color::difference(*color_a, *color_b), 1.0 - features)
        }));
    }
    errors
}
