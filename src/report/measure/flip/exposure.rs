//! The exposures at which a reference of high dynamic range can be looked at (the paper of 2021).
//!
//! The first shows the brightest pixel, the last the pixel of median luminance at 0.85 of the display, after a fit of
//! the ACES film curve (Narkowicz 2015, its exposure of 0.6 taken back). Between them lies about one exposure a stop,
//! at least two.

use crate::color::luminance;
use crate::image::Image;
use glam::DVec3;

/// The curve (a x^2 + b x) / (c x^2 + d x + e).
const A: f64 = 0.6 * 0.6 * 2.51;
const B: f64 = 0.6 * 0.03;
const C: f64 = 0.6 * 0.6 * 2.43;
const D: f64 = 0.6 * 0.59;
const E: f64 = 0.14;

/// The display value at which the brightest pixel, then the median one, is shown.
const TARGET: f64 = 0.85;

/// Luminances below this count as this, 2^-23: half-black references have a last exposure, as version 1.7 has it. That
/// gives up on references that are black; ours shows their errors at this one exposure.
const DARKEST: f64 = f32::EPSILON as f64;

/// A range of exposures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// The first, in stops.
    pub start: f64,
    /// The last, in stops.
    pub stop: f64,
    /// How many there are, evenly spaced; at least 2.
    pub count: usize,
}

impl Exposures {
    /// All of them, in stops.
    pub fn stops(self) -> impl Iterator<Item = f64> {
        let step = (self.stop - self.start) / (self.count - 1) as f64;
        // Equal ends are one exposure.
        let count = if step == 0.0 { 1 } else { self.count };
        (0..count).map(move |i| self.start + i as f64 * step)
    }
}

/// The exposures for `reference`, of which values below 0 count as 0.
pub fn exposures(reference: &Image) -> Exposures {
    let visible = |pixel: &[f32; 3]| luminance(pixel.map(|v| (v as f64).max(0.0)));
    let mut luminances: Vec<f64> = reference.pixels.iter().map(visible).collect();
    luminances.sort_unstable_by(f64::total_cmp);
    let at = |index: usize| luminances.get(index).copied().unwrap_or(0.0).max(DARKEST);
    let shown = scene_value(TARGET);
    let exposure = |luminance: f64| libm::log2(shown / luminance);
    let (start, stop) = (exposure(at(luminances.len().saturating_sub(1))), exposure(at(luminances.len() / 2)));
    Exposures { start, stop, count: (stop - start).ceil().max(2.0) as usize }
}

/// The scene value that the curve maps to `display`: the larger root of a quadratic equation.
fn scene_value(display: f64) -> f64 {
    let (a, b, c) = (A - display * C, B - display * D, -display * E);
    let middle = -0.5 * b / a;
    middle + (middle * middle - c / a).sqrt()
}

/// Linear Rec.709, not below 0, to linear display values in [0, 1].
pub fn tone_map(rgb: DVec3) -> DVec3 {
    // As a function of 1 / x where x is large, whose square may overflow.
    let curve = |x: f64| {
        if x > 1.0 {
            let inverse = 1.0 / x;
            (A + B * inverse) / (C + (D + E * inverse) * inverse)
        } else {
            (A * x + B) * x / ((C * x + D) * x + E)
        }
    };
    DVec3::new(curve(rgb.x), curve(rgb.y), curve(rgb.z)).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f32]) -> Image {
        let pixels = values.iter().map(|value| [*value; 3]).collect();
        Image { width: values.len() as u32, height: 1, pixels, ..Image::default() }
    }

    #[test]
    fn the_curve_meets_its_inverse() {
        for display in [0.1, 0.5, TARGET, 0.99] {
            assert!((tone_map(DVec3::splat(scene_value(display))).x - display).abs() < 1e-12);
        }
        assert_eq!(tone_map(DVec3::ZERO), DVec3::ZERO);
        assert_eq!(tone_map(DVec3::splat(1e300)), DVec3::ONE);
        let [below, above] = [1.0, 1.0 + 1e-12].map(|x| tone_map(DVec3::splat(x)).x);
        assert!((below - above).abs() < 1e-11, "the two forms meet");
    }

    /// Start, stop and count that version 1.7 of the authors' program tells for these references.
    #[test]
    fn ranges_are_those_of_the_authors() {
        let ramp = |floor: f32| (1..=64).map(|i| i as f32 / 64.0).chain([floor; 192]).collect::<Vec<f32>>();
        let one_of_256 = |value: f32| [value].into_iter().chain([0.0; 255]).collect::<Vec<f32>>();
        for (values, start, stop, count) in [
            (vec![1.0], 1.083_297, 1.083_297, 2),
            // The upper of two middle values is the median.
            (vec![2.0, 1.0], 0.083_297, 0.083_297, 2),
            (vec![0.25, 0.5, 1.0, 1.0], 1.083_297, 1.083_297, 2),
            (ramp(0.0), 1.083_297, 24.083_298, 23),
            (ramp(0.001), 1.083_297, 11.049_082, 10),
            (one_of_256(4.0), -0.916_703, 24.083_298, 25),
        ] {
            let found = exposures(&grey(&values));
            assert!((found.start - start).abs() < 1e-5 && (found.stop - stop).abs() < 1e-5, "{found:?}");
            assert_eq!(found.count, count);
            let stops: Vec<f64> = found.stops().collect();
            assert_eq!(stops.len(), if start == stop { 1 } else { count });
            assert!((stops[stops.len() - 1] - stop).abs() < 1e-5);
        }
    }

    #[test]
    fn black_and_empty_references_have_one_exposure() {
        for values in [vec![0.0; 4], vec![], vec![-1.0, 1e-30]] {
            let found = exposures(&grey(&values));
            assert_eq!((found.stops().count(), found.start), (1, found.stop));
            assert!(found.start.is_finite());
        }
    }
}
