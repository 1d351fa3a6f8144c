//! How far one image is from another.
//!
//! Image A is judged by image B, the reference; both linear Rec.709. Sums run over all pixels and channels:
//!
//! - `mse`: mean of (a - b)^2; `rmse` its root.
//! - `relmse`: mean of (a - b)^2 / (b^2 + 0.01): the error relative to what is there, held finite where that is black. Its
//!   root reads as a relative error: a relMSE of 0.0025 is 5 %.
//! - `mape`: mean of |a - b| / (|b| + 0.01).
//! - `psnr`: the peak signal-to-noise ratio of the display images in dB, -10 log10 of the mean of (a' - b')^2 over pixels and
//!   channels, where a' is radiance times 2^exposure, cut to [0, 1] and sRGB-encoded: the peak is 1, nothing is rounded to 8
//!   bits. The exposure is 0 in [`compare`]. It says how close two images look on one display, not how far their radiance is
//!   apart: what is brighter than white is cut in both. Noise of the reference is not subtracted.
//! - `bias_z`: the difference of the two mean values, over its standard error. Noise alone stays below 3 in 997 of 1,000
//!   comparisons; a larger figure says that the images have different expected values.
//!
//! A reference that was itself rendered carries noise: E (a - b)^2 = E (a - t)^2 + var b for the truth t, if A and B are
//! independent. Where B says what its variance is, `mse` and `relmse` have that subtracted, and `mse_raw` and `relmse_raw`
//! are the plain figures.

use crate::color::srgb_from_linear;
use crate::image::Image;

/// What is added to b^2 in relMSE, and to |b| in MAPE, so that black pixels count and do not rule.
pub const FLOOR: f64 = 0.01;

/// The error of an image against a reference.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Metrics {
    /// Mean squared error, the reference's noise subtracted; not below 0.
    pub mse: f64,
    /// Its root.
    pub rmse: f64,
    /// Relative mean squared error, the reference's noise subtracted; not below 0.
    pub relmse: f64,
    /// Mean absolute relative error.
    pub mape: f64,
    /// Peak signal-to-noise ratio of the display images at exposure 0, in dB; `null` where they agree exactly.
    pub psnr: Option<f64>,
    /// Mean of image A, per channel.
    pub mean_a: [f64; 3],
    /// Mean of image B, per channel.
    pub mean_b: [f64; 3],
    /// Mean of A - B over pixels and channels.
    pub bias: f64,
    /// The standard error of `bias`, from the images' variance layers; `null` where neither has any.
    pub bias_se: Option<f64>,
    /// `bias / bias_se`.
    pub bias_z: Option<f64>,
    /// `mse` without the subtraction.
    pub mse_raw: f64,
    /// `relmse` without the subtraction.
    pub relmse_raw: f64,
    /// Noise of the reference as it enters `mse_raw`: 0 where it has no variance layers.
    pub noise_mse: f64,
    /// Noise of the reference as it enters `relmse_raw`.
    pub noise_relmse: f64,
}

/// Why two images cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Their sizes differ: (width, height) of A and of B.
    Size((u32, u32), (u32, u32)),
    /// A value that is not finite, or a variance that is not finite and at least 0.
    Value {
        /// In image B.
        in_b: bool,
        /// In the variance layers.
        in_variance: bool,
        /// Column.
        x: u32,
        /// Row, from the top.
        y: u32,
        /// The three channels there.
        value: [f32; 3],
    },
    /// No pixels.
    Empty,
}

/// Compares `a` with the reference `b`.
pub fn compare(a: &Image, b: &Image) -> Result<Metrics, Fault> {
    check(a, b)?;
    let count = a.pixels.len() as f64;
    let (mut squares, mut relative_squares, mut relative) = (0.0, 0.0, 0.0);
    let (mut noise, mut relative_noise) = (0.0, 0.0);
    let (mut sum_a, mut sum_b) = ([0.0; 3], [0.0; 3]);
    for (i, (pixel_a, pixel_b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        let variance_b = b.variance.as_ref().map_or([0.0; 3], |variance| variance[i]);
        for c in 0..3 {
            let (value_a, value_b) = (pixel_a[c] as f64, pixel_b[c] as f64);
            let (difference, weight) = (value_a - value_b, 1.0 / (value_b * value_b + FLOOR));
            squares += difference * difference;
            relative_squares += difference * difference * weight;
            relative += difference.abs() / (value_b.abs() + FLOOR);
            noise += variance_b[c] as f64;
            relative_noise += variance_b[c] as f64 * weight;
            sum_a[c] += value_a;
            sum_b[c] += value_b;
        }
    }
    let [mse_raw, relmse_raw, mape, noise_mse, noise_relmse] =
        [squares, relative_squares, relative, noise, relative_noise].map(|sum| sum / (3.0 * count));
    let mse = (mse_raw - noise_mse).max(0.0);
    let (mean_a, mean_b) = (sum_a.map(|sum| sum / count), sum_b.map(|sum| sum / count));
    let bias = (0..3).map(|c| (sum_a[c] - sum_b[c]) / (3.0 * count)).sum();
    let bias_se = standard_error(a, b);
    Ok(Metrics {
        mse,
        rmse: mse.sqrt(),
        relmse: (relmse_raw - noise_relmse).max(0.0),
        mape,
        psnr: psnr(a, b, 0.0),
        mean_a,
        mean_b,
        bias,
        bias_se,
        bias_z: bias_se.filter(|se| *se > 0.0).map(|se| bias / se),
        mse_raw,
        relmse_raw,
        noise_mse,
        noise_relmse,
    })
}

/// The standard error of the difference of the images' means over pixels and channels; `None` if neither has variance
/// layers (one without counts as exact).
///
/// Pixels are independent; the channels of one are not, since one path brings light of all three colours. Their covariances
/// are not stored, so they count as fully correlated (Cauchy and Schwarz: never too small, and nearly right for light that
/// is nearly grey).
fn standard_error(a: &Image, b: &Image) -> Option<f64> {
    let layers = [&a.variance, &b.variance];
    let layers: Vec<&Vec<[f32; 3]>> = layers.into_iter().flatten().collect();
    if layers.is_empty() {
        return None;
    }
    let variance: f64 = layers.iter().flat_map(|layer| layer.iter()).map(variance_of_channel_mean).sum();
    Some(variance.sqrt() / a.pixels.len() as f64)
}

/// The variance of the mean of three fully correlated channels with these variances.
pub fn variance_of_channel_mean(variance: &[f32; 3]) -> f64 {
    let deviation = variance.iter().map(|v| (*v as f64).sqrt()).sum::<f64>() / 3.0;
    deviation * deviation
}

/// The peak signal-to-noise ratio of the display images of `a` and `b` after `exposure` stops, in dB; `None` where they agree
/// exactly.
///
/// The images have the same size and finite values ([`check`]).
pub fn psnr(a: &Image, b: &Image, exposure: f64) -> Option<f64> {
    let scale = libm::exp2(exposure);
    let display = |radiance: f32| srgb_from_linear((radiance as f64 * scale).clamp(0.0, 1.0));
    let channels = |image: &'_ Image| image.pixels.iter().flatten().map(|value| display(*value)).collect::<Vec<f64>>();
    let (a, b) = (channels(a), channels(b));
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares > 0.0).then(|| -10.0 * libm::log10(squares / b.len() as f64))
}

/// The relative error of every pixel: the root of the mean over channels of (a - b)^2 / (b^2 + 0.01).
pub fn relative_errors(a: &Image, b: &Image) -> Vec<f64> {
    let error = |(pixel_a, pixel_b): (&[f32; 3], &[f32; 3])| {
        let channel = |c: usize| {
            let (value_a, value_b) = (pixel_a[c] as f64, pixel_b[c] as f64);
            (value_a - value_b).powi(2) / (value_b * value_b + FLOOR)
        };
        ((channel(0) + channel(1) + channel(2)) / 3.0).sqrt()
    };
    a.pixels.iter().zip(&b.pixels).map(error).collect()
}

/// The mean of `pixels`, per channel.
pub fn mean(pixels: &[[f32; 3]]) -> [f64; 3] {
    let sum = |c: usize| pixels.iter().map(|pixel| pixel[c] as f64).sum::<f64>();
    [0, 1, 2].map(|c| sum(c) / pixels.len().max(1) as f64)
}

/// Whether `a` and `b` can be compared at all.
pub fn check(a: &Image, b: &Image) -> Result<(), Fault> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(Fault::Size((a.width, a.height), (b.width, b.height)));
    }
    if a.pixels.is_empty() {
        return Err(Fault::Empty);
    }
    for (in_b, image) in [(false, a), (true, b)] {
        let place = |index: usize| (index as u32 % image.width, index as u32 / image.width);
        let finite = |value: &[f32; 3]| value.iter().all(|v| v.is_finite());
        if let Some(i) = image.pixels.iter().position(|value| !finite(value)) {
            let (x, y) = place(i);
            return Err(Fault::Value { in_b, in_variance: false, x, y, value: image.pixels[i] });
        }
        let usable = |value: &[f32; 3]| value.iter().all(|v| v.is_finite() && *v >= 0.0);
        if let Some(variance) = &image.variance
            && let Some(i) = variance.iter().position(|value| !usable(value))
        {
            let (x, y) = place(i);
            return Err(Fault::Value { in_b, in_variance: true, x, y, value: variance[i] });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, pixels: &[[f32; 3]]) -> Image {
        Image { width, height: pixels.len() as u32 / width, pixels: pixels.to_vec(), ..Image::default() }
    }

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} and {expected}");
    }

    #[test]
    fn two_pixels_worked_by_hand() {
        // Differences 1, 0, 0 at references 2, 0, 1; then 0, 0.5, -1 at references 1, 0, 3.
        let a = image(2, &[[3.0, 0.0, 1.0], [1.0, 0.5, 2.0]]);
        let b = image(2, &[[2.0, 0.0, 1.0], [1.0, 0.0, 3.0]]);
        let m = compare(&a, &b).unwrap();
        close(m.mse, (1.0 + 0.25 + 1.0) / 6.0);
        close(m.rmse, (2.25f64 / 6.0).sqrt());
        close(m.relmse, (1.0 / 4.01 + 0.25 / 0.01 + 1.0 / 9.01) / 6.0);
        close(m.mape, (1.0 / 2.01 + 0.5 / 0.01 + 1.0 / 3.01) / 6.0);
        assert_eq!((m.mean_a, m.mean_b), ([2.0, 0.25, 1.5], [1.5, 0.0, 2.0]));
        close(m.bias, (1.0 + 0.5 - 1.0) / 6.0);
        assert_eq!((m.bias_se, m.bias_z, m.mse_raw), (None, None, m.mse));
        close(relative_errors(&a, &b)[0], (1.0f64 / 4.01 / 3.0).sqrt());
    }

    #[test]
    fn the_noise_of_the_reference_is_subtracted_and_gives_the_standard_error() {
        let mut a = image(1, &[[1.5; 3], [2.5; 3]]);
        let mut b = image(1, &[[1.0; 3], [2.0; 3]]);
        b.variance = Some(vec![[0.04; 3], [0.09; 3]]);
        a.variance = Some(vec![[0.12; 3], [0.11; 3]]);
        let m = compare(&a, &b).unwrap();
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        near(m.mse_raw, 0.25);
        near(m.mse, 0.25 - 0.065);
        near(m.noise_relmse, (0.04 / 1.01 + 0.09 / 4.01) / 2.0);
        near(m.relmse, m.relmse_raw - m.noise_relmse);
        // Grey pixels: the variance of the mean of the image is (0.04 + 0.09 + 0.12 + 0.11) / 2^2.
        near(m.bias_se.unwrap(), 0.3);
        near(m.bias_z.unwrap(), 0.5 / 0.3);
        // Variances of (0.01, 0.04, 0.09), fully correlated: deviations 0.1, 0.2, 0.3 have the mean 0.2.
        near(variance_of_channel_mean(&[0.01, 0.04, 0.09]), 0.04);
        // The same image twice: the difference is 0, whatever the noise is said to be.
        let same = compare(&b, &b).unwrap();
        assert_eq!((same.mse, same.relmse, same.mape, same.bias_z), (0.0, 0.0, 0.0, Some(0.0)));
    }

    #[test]
    fn psnr_is_of_display_images() {
        // Display values 1 and 0 in one of six channels: a mean square of 1/6.
        let (a, b) = (image(2, &[[1.0, 0.0, 0.5], [0.0; 3]]), image(2, &[[0.0, 0.0, 0.5], [0.0; 3]]));
        close(psnr(&a, &b, 0.0).unwrap(), 10.0 * 6f64.log10());
        assert_eq!(compare(&a, &b).unwrap().psnr, psnr(&a, &b, 0.0));
        // Linear light of 0.2 and 0.4 on the display, everywhere: 20 log10(1 / 0.2).
        let grey = |display: f64| image(1, &[[crate::color::linear_from_srgb(display) as f32; 3]; 5]);
        assert!((psnr(&grey(0.2), &grey(0.4), 0.0).unwrap() - 20.0 * 5f64.log10()).abs() < 1e-5);
        // Beyond white and below black all is one; an exposure brings it back.
        let (bright, brighter, below) = (image(1, &[[2.0; 3]]), image(1, &[[3.0; 3]]), image(1, &[[-1.0; 3]]));
        assert_eq!(psnr(&bright, &brighter, 0.0), None);
        assert!(psnr(&bright, &brighter, -2.0).is_some());
        assert_eq!(psnr(&below, &image(1, &[[0.0; 3]]), 5.0), None);
        assert_eq!(psnr(&a, &a, 0.0), None);
        let text = serde_json::to_string(&compare(&bright, &brighter).unwrap()).unwrap();
        assert!(text.contains("\"psnr\":null"), "{text}");
        // The exposure is a factor before the cut.
        let brighter = |image: &Image| Image {
            pixels: image.pixels.iter().map(|p| p.map(|v| v * 4.0)).collect(),
            ..image.clone()
        };
        let (a, b) = (grey(0.1), grey(0.15));
        assert_eq!(psnr(&a, &b, 2.0), psnr(&brighter(&a), &brighter(&b), 0.0));
        assert_eq!(psnr(&a, &b, 0.0), psnr(&b, &a, 0.0));
    }

    #[test]
    fn what_cannot_be_compared_is_told() {
        let a = image(2, &[[0.0; 3]; 4]);
        assert_eq!(compare(&a, &image(4, &[[0.0; 3]; 4])), Err(Fault::Size((2, 2), (4, 1))));
        assert_eq!(compare(&Image::default(), &Image::default()), Err(Fault::Empty));
        let mut b = a.clone();
        b.pixels[3] = [0.0, f32::INFINITY, 0.0];
        let found = Fault::Value { in_b: true, in_variance: false, x: 1, y: 1, value: [0.0, f32::INFINITY, 0.0] };
        assert_eq!(compare(&a, &b), Err(found));
        b = a.clone();
        b.variance = Some(vec![[0.0; 3], [0.0, 0.0, -1.0], [0.0; 3], [0.0; 3]]);
        let found = Fault::Value { in_b: false, in_variance: true, x: 1, y: 0, value: [0.0, 0.0, -1.0] };
        assert_eq!(compare(&b, &a), Err(found));
    }
}
