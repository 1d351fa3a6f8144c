//! The power spectrum of an error image: at which frequencies the error lies.
//!
//! After Celarek, Jakob, Wimmer and Lehtinen, "Quantifying the Error of Light Transport Algorithms" (Computer Graphics
//! Forum 38(4), 2019): of many short renders the error image of each is transformed, its power averaged over all
//! directions, and the spectra are looked at together. Independent pixels have white noise, a flat spectrum. Paths that
//! share what they find (chains, caches, learned tables, a common scramble) leave blotches: power at low frequencies,
//! which more pixels do not average away and which an eye sees first. Errors pushed to high frequencies are the
//! reverse.
//!
//! **Normalisation.** For an image of N pixels, P(k) = |DFT(k)|^2 / N. The mean of P over all N frequencies is the
//! mean square of the error (Parseval), and white noise of variance v has the expected value v at each. The image is
//! taken as one period: no window, so a step between opposite borders shows as power at low frequencies of its axis.

use crate::image::Image;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use serde::{Deserialize, Serialize};

/// The highest frequency along an axis, in cycles per pixel.
pub const HIGHEST: f64 = 0.5;

/// Frequencies below this, in cycles per pixel, count as low: an eighth of the highest, periods above 16 pixels.
pub const LOW: f64 = HIGHEST / 8.0;

/// The power of an error image, averaged over rings of frequencies.
///
/// The first entry is the mean of the image, at frequency 0. Rings of equal width follow up to [`HIGHEST`], and one
/// last entry for the corners beyond: diagonal frequencies, up to 0.707. Rings that hold no frequency of so small a
/// image are left out, so images of one size have the same entries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// The mean of each ring's frequencies, in cycles per pixel.
    pub frequency: Vec<f64>,
    /// The mean power of each ring, in units of the squared error.
    pub power: Vec<f64>,
    /// How many frequencies each ring holds; their sum is the number of pixels.
    pub count: Vec<u64>,
    /// The mean power of all frequencies below [`LOW`], 0 included, whatever the rings are.
    pub low: f64,
}

impl Spectrum {
    /// The mean square of the error, which all frequencies add up to.
    pub fn mean_square(&self) -> f64 {
        let frequencies = self.count.iter().sum::<u64>() as f64;
        self.power.iter().zip(&self.count).map(|(power, count)| power * *count as f64).sum::<f64>() / frequencies
    }

    /// The share of the mean square that lies below [`LOW`], over the share that white noise has there: 1 for white
    /// noise, above 1 where error hides in low frequencies. `None` where there is no error.
    pub fn low_frequency_share(&self) -> Option<f64> {
        let mean_square = self.mean_square();
        (mean_square > 0.0).then(|| self.low / mean_square)
    }

    /// The spectrum without white noise of this variance, such as that of a rendered reference; not below 0. To be
    /// taken from a mean over runs, where each ring's noise is small.
    pub fn without_white_noise(&self, variance: f64) -> Spectrum {
        let without = |power: f64| (power - variance).max(0.0);
        Spectrum {
            power: self.power.iter().map(|power| without(*power)).collect(),
            low: without(self.low),
            ..self.clone()
        }
    }

    /// The mean over runs of one size and one number of rings; `None` if there are none or they differ in that.
    pub fn mean(spectra: &[Spectrum]) -> Option<Spectrum> {
        let mut mean = spectra.first()?.clone();
        if spectra.iter().any(|other| other.count != mean.count) {
            return None;
        }
        let over_runs =
            |figure: &dyn Fn(&Spectrum) -> f64| spectra.iter().map(figure).sum::<f64>() / spectra.len() as f64;
        mean.power = (0..mean.power.len()).map(|ring| over_runs(&|spectrum| spectrum.power[ring])).collect();
        mean.low = over_runs(&|spectrum| spectrum.low);
        Some(mean)
    }
}

/// The error image of `a` against `b`: a - b, averaged over the channels; row by row.
///
/// The images have the same size and finite values ([`super::metrics::check`]).
pub fn error_image(a: &Image, b: &Image) -> Vec<f64> {
    let error = |(pixel_a, pixel_b): (&[f32; 3], &[f32; 3])| {
        (0..3).map(|c| pixel_a[c] as f64 - pixel_b[c] as f64).sum::<f64>() / 3.0
    };
    a.pixels.iter().zip(&b.pixels).map(error).collect()
}

/// The spectrum of an error image of any size, in `bins` rings up to [`HIGHEST`].
///
/// # Panics
/// If `error` does not hold `width * height` values, or there are no values or no rings.
pub fn error_spectrum(error: &[f64], width: usize, height: usize, bins: usize) -> Spectrum {
    assert!(error.len() == width * height && !error.is_empty() && bins > 0, "{width} x {height} values, {bins} rings");
    let power = power(error, width, height);
    // The mean, the rings, the corners.
    let mut rings = vec![Ring::default(); bins + 2];
    let mut low = Ring::default();
    for (index, power) in power.into_iter().enumerate() {
        let [x, y] =
            [(index % width, width), (index / width, height)].map(|(k, size)| k.min(size - k) as f64 / size as f64);
        let frequency = x.hypot(y);
        let ring = match frequency {
            0.0 => 0,
            // The highest frequency of an axis belongs to its last ring.
            f if f <= HIGHEST => ((f / HIGHEST * bins as f64) as usize).min(bins - 1) + 1,
            _ => bins + 1,
        };
        rings[ring].add(frequency, power);
        if frequency < LOW {
            low.add(frequency, power);
        }
    }
    rings.retain(|ring| ring.count > 0);
    Spectrum {
        frequency: rings.iter().map(|ring| ring.frequency / ring.count as f64).collect(),
        power: rings.iter().map(|ring| ring.power / ring.count as f64).collect(),
        count: rings.iter().map(|ring| ring.count).collect(),
        low: low.power / low.count as f64,
    }
}

/// Sums over the frequencies of a ring.
#[derive(Clone, Copy, Default)]
struct Ring {
    frequency: f64,
    power: f64,
    count: u64,
}

impl Ring {
    fn add(&mut self, frequency: f64, power: f64) {
        self.frequency += frequency;
        self.power += power;
        self.count += 1;
    }
}

/// |DFT|^2 / N at every frequency, row by row from frequency (0, 0).
fn power(error: &[f64], width: usize, height: usize) -> Vec<f64> {
    let mut planner = FftPlanner::new();
    let mut values: Vec<Complex<f64>> = error.iter().map(|error| Complex::new(*error, 0.0)).collect();
    // A buffer of several rows is transformed row by row.
    planner.plan_fft_forward(width).process(&mut values);
    let mut values = transposed(&values, width);
    planner.plan_fft_forward(height).process(&mut values);
    let count = error.len() as f64;
    transposed(&values, height).iter().map(|value| value.norm_sqr() / count).collect()
}

/// The columns of rows of `width`, as rows.
fn transposed(values: &[Complex<f64>], width: usize) -> Vec<Complex<f64>> {
    (0..width).flat_map(|x| values[x..].iter().step_by(width)).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// White noise of variance 1 and nearly normal: sums of 12 numbers of a 64-bit counter hash (SplitMix64).
    fn white(count: usize, seed: u64) -> Vec<f64> {
        let hash = |index: u64| {
            let mut z = index.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(seed << 40);
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..count as u64).map(|i| (0..12).map(|j| hash(12 * i + j + 1)).sum::<f64>() - 6.0).collect()
    }

    fn picture(width: usize, height: usize, value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        (0..width * height).map(|i| value(i % width, i / width)).collect()
    }

    const SIZES: [(usize, usize); 9] =
        [(1, 1), (2, 1), (1, 7), (8, 8), (5, 3), (17, 13), (64, 48), (97, 31), (30, 101)];

    #[test]
    fn all_frequencies_add_up_to_the_mean_square() {
        for (width, height) in SIZES {
            let error = white(width * height, 7);
            let mean_square = error.iter().map(|e| e * e).sum::<f64>() / error.len() as f64;
            for bins in [1, 3, 32] {
                let spectrum = error_spectrum(&error, width, height, bins);
                assert!((spectrum.mean_square() / mean_square - 1.0).abs() < 1e-12, "{width} x {height}");
                assert_eq!(spectrum.count.iter().sum::<u64>(), (width * height) as u64);
                assert!(spectrum.frequency.is_sorted() && spectrum.frequency[0] == 0.0);
                assert!(spectrum.count.iter().all(|count| *count > 0) && spectrum.frequency.len() <= bins + 2);
            }
        }
    }

    /// The transform from its definition.
    #[test]
    fn power_is_that_of_the_definition() {
        for (width, height) in [(1, 1), (4, 4), (5, 3), (1, 7), (6, 11)] {
            let error = white(width * height, 9);
            let found = power(&error, width, height);
            for (i, found) in found.iter().enumerate() {
                let (kx, ky) = (i % width, i / width);
                let phase = |j: usize| {
                    let turns = (kx * (j % width)) as f64 / width as f64 + (ky * (j / width)) as f64 / height as f64;
                    TAU * turns
                };
                let sum =
                    |wave: &dyn Fn(f64) -> f64| error.iter().enumerate().map(|(j, e)| e * wave(phase(j))).sum::<f64>();
                let expected = (sum(&f64::cos).powi(2) + sum(&f64::sin).powi(2)) / error.len() as f64;
                assert!((found - expected).abs() < 1e-11, "{width} x {height}, {kx} {ky}: {found} {expected}");
            }
        }
    }

    #[test]
    fn white_noise_is_flat() {
        let (width, height, runs) = (72, 50, 40);
        let spectra: Vec<Spectrum> =
            (0..runs).map(|seed| error_spectrum(&white(width * height, seed + 1), width, height, 12)).collect();
        let mean = Spectrum::mean(&spectra).unwrap();
        // Power at one frequency is exponential, at those that are their own mirror chi-square of one degree: deviation
        // at most sqrt(2) of the mean, and mirrors are equal, so a ring has half as many independent values. 4.5
        // deviations over 15 figures, the first of which has the widest tail (chi-square, 40 degrees): a false alarm in
        // one of 1,000 sets of seeds.
        for ((frequency, power), count) in mean.frequency.iter().zip(&mean.power).zip(&mean.count) {
            let deviation = (2.0 / (*count * runs) as f64).sqrt();
            assert!((power - 1.0).abs() < 4.5 * deviation, "{power} at {frequency}, deviation {deviation}");
        }
        // An ellipse of half axes 72 / 16 and 50 / 16.
        let low_count = 44;
        assert!((mean.low_frequency_share().unwrap() - 1.0).abs() < 4.5 * (2.0 / (low_count * runs) as f64).sqrt());
    }

    #[test]
    fn a_wave_is_in_one_ring_and_a_constant_in_the_first_entry() {
        for (width, height, kx, ky) in [(64, 64, 5, 0), (60, 45, 0, 4), (33, 21, 3, 2), (32, 32, 16, 0), (16, 16, 8, 8)]
        {
            let turns = |x, y| (kx * x) as f64 / width as f64 + (ky * y) as f64 / height as f64;
            let error = picture(width, height, |x, y| 3.0 * (TAU * turns(x, y)).cos());
            let spectrum = error_spectrum(&error, width, height, 16);
            let at = (kx as f64 / width as f64).hypot(ky as f64 / height as f64);
            // A wave of amplitude 3 has the mean square 4.5, and at the highest frequency, all signs alternating, 9.
            let square = if 2 * kx == width { 9.0 } else { 4.5 };
            let full: Vec<usize> = (0..spectrum.power.len()).filter(|i| spectrum.power[*i] > 1e-12).collect();
            assert_eq!(full.len(), 1, "{width} x {height}");
            let ring = full[0];
            let total = spectrum.power[ring] * spectrum.count[ring] as f64 / (width * height) as f64;
            assert!((total - square).abs() < 1e-12, "{total}");
            let (start, end) =
                ((16.0 * at / HIGHEST).floor().min(15.0) / 32.0, (16.0 * at / HIGHEST).floor() / 32.0 + 1.0 / 32.0);
            let inside = (start..=end).contains(&spectrum.frequency[ring]);
            assert!(inside || at > HIGHEST && ring == spectrum.power.len() - 1, "{at} {:?}", spectrum.frequency[ring]);
        }
        for (width, height) in SIZES {
            let spectrum = error_spectrum(&picture(width, height, |_, _| -0.5), width, height, 8);
            assert!((spectrum.power[0] - 0.25 * (width * height) as f64).abs() < 1e-10);
            assert!(spectrum.power[1..].iter().all(|power| *power < 1e-20));
            assert!((spectrum.mean_square() - 0.25).abs() < 1e-12);
        }
    }

    #[test]
    fn error_in_low_frequencies_is_found() {
        let (width, height) = (96, 64);
        let noise = white(width * height, 3);
        let around = |x: usize, y: usize, reach: usize| {
            let rows = (0..=2 * reach).map(|i| (y + height + i - reach) % height);
            rows.flat_map(|y| (0..=2 * reach).map(move |i| (y, (x + width + i - reach) % width)))
                .map(|(y, x)| noise[y * width + x])
                .sum::<f64>()
        };
        let share = |error: &[f64]| error_spectrum(error, width, height, 16).low_frequency_share().unwrap();
        // Averages of 7 x 7 pixels: their power is all but below 1/7, and a low frequency has 49 times the mean, less
        // what the filter takes: sinc^2 at half of LOW is about 0.6 for both axes.
        let blurred = share(&picture(width, height, |x, y| around(x, y, 3)));
        assert!((15.0..49.0).contains(&blurred), "{blurred}");
        // What the blur left out has nothing there.
        let sharp = picture(width, height, |x, y| noise[y * width + x] - around(x, y, 3) / 49.0);
        assert!(share(&sharp) < 0.3, "{}", share(&sharp));
        // An image that is too bright by its noise's deviation: half of the mean square is at frequency 0.
        let biased: Vec<f64> = noise.iter().map(|e| e + 1.0).collect();
        assert!(share(&biased) > 10.0);
        assert_eq!(error_spectrum(&[0.0; 12], 4, 3, 4).low_frequency_share(), None);
    }

    #[test]
    fn means_and_subtraction() {
        let spectra = [1, 2].map(|seed| error_spectrum(&white(15 * 11, seed), 15, 11, 6));
        let mean = Spectrum::mean(&spectra).unwrap();
        assert!((mean.power[2] - (spectra[0].power[2] + spectra[1].power[2]) / 2.0).abs() < 1e-15);
        assert!((mean.mean_square() - (spectra[0].mean_square() + spectra[1].mean_square()) / 2.0).abs() < 1e-14);
        assert_eq!(Spectrum::mean(&spectra[..1]).as_ref(), Some(&spectra[0]));
        let other = error_spectrum(&white(15 * 12, 1), 15, 12, 6);
        assert_eq!((Spectrum::mean(&[]), Spectrum::mean(&[mean.clone(), other])), (None, None));
        let less = mean.without_white_noise(mean.low);
        assert!(less.low == 0.0 && less.power.iter().all(|power| *power >= 0.0));
        // JSON may lose a last bit; what was read goes together with what was not.
        let read: Spectrum = serde_json::from_str(&serde_json::to_string(&mean).unwrap()).unwrap();
        assert!(read.power.iter().zip(&mean.power).all(|(read, written)| (read / written - 1.0).abs() < 1e-15));
        assert!(Spectrum::mean(&[read, mean]).is_some());
    }

    #[test]
    fn an_error_image_is_the_mean_over_channels() {
        let image = |pixels: &[[f32; 3]]| Image { width: 2, height: 1, pixels: pixels.to_vec(), ..Image::default() };
        let (a, b) = (image(&[[1.0, 2.0, 3.0], [0.0; 3]]), image(&[[0.5, 2.0, 0.5], [0.0, 0.0, 3.0]]));
        assert_eq!(error_image(&a, &b), [1.0, -1.0]);
    }
}
