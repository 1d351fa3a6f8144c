//! What pixels gather: sums, added in sample order, and what tells their variance: sums of squares, or sums by group. Each is a
//! table of its own, and only the one that is needed is there: a pixel takes 48 bytes, or 120 with groups.

use crate::fault::{Fault, planted};
use crate::sampler::sobol::GROUPS;

/// The sum of a pixel's samples, per channel (linear Rec.709 radiance, W sr^-1 m^-2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Sum of the samples.
    pub sum: [f64; 3],
}

/// The sum of the squares of a pixel's samples, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SquareSums(pub [f64; 3]);

/// Adds one sample, per channel.
#[inline(always)]
fn add(sums: &mut [f64; 3], sample: [f64; 3]) {
    for (sum, value) in sums.iter_mut().zip(sample) {
        *sum += value;
        if planted(Fault::F32Sum) {
            *sum = f64::from(*sum as f32);
        }
    }
}

/// A pixel's sums by group of the `sobol` sampler: sample `k` is in group `k % 4`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupSums(pub [[f64; 3]; GROUPS as usize]);

impl GroupSums {
    /// Sum of the squared deviations of the groups' means from `mean`, that of all `spp` samples, each as often as the group
    /// has samples. Over (groups - 1), the variance of a sample, were samples independent; of the mean, over `spp` more.
    fn squared_deviations(&self, channel: usize, mean: f64, spp: u32) -> f64 {
        let of_group = |(group, sums): (usize, &[f64; 3])| {
            let size = (spp - group as u32).div_ceil(GROUPS) as f64;
            let deviation = sums[channel] / size - mean;
            size * deviation * deviation
        };
        self.0.iter().enumerate().map(of_group).sum()
    }
}

/// The sums of some pixels, to be added to. One of `squares` and `groups` has an entry a pixel, the other is empty.
#[derive(Default)]
pub struct SumsMut<'a> {
    /// All samples.
    pub pixels: &'a mut [Pixel],
    /// Of the squares; for samples that are independent.
    pub squares: &'a mut [SquareSums],
    /// By group; for samples that are not.
    pub groups: &'a mut [GroupSums],
}

impl SumsMut<'_> {
    /// Adds to pixel `index` its sample number `sample`, which counts in a `unit` of radiance, a power of two, W sr^-1 m^-2;
    /// true if it was finite, else it is left out (and still counts as a sample of value 0).
    #[inline(always)]
    pub fn add(&mut self, unit: f64, index: usize, sample: u32, radiance: [f32; 3]) -> bool {
        if !radiance.iter().all(|c| c.is_finite()) && !planted(Fault::TakenThoughNotFinite) {
            return false;
        }
        let values = radiance.map(|value| value as f64 * unit);
        add(&mut self.pixels[index].sum, values);
        match self.groups.get_mut(index) {
            Some(groups) => add(&mut groups.0[(sample % GROUPS) as usize], values),
            None => add(&mut self.squares[index].0, values.map(|value| value * value)),
        }
        true
    }

    /// The sums after `spp` samples a pixel.
    pub fn after(&self, spp: u32) -> Sums<'_> {
        Sums { pixels: self.pixels, squares: self.squares, groups: self.groups, spp }
    }
}

/// The sums of some pixels. One of `squares` and `groups` has an entry a pixel, the other is empty.
#[derive(Clone, Copy)]
pub struct Sums<'a> {
    /// All samples.
    pub pixels: &'a [Pixel],
    /// Of the squares; for samples that are independent.
    pub squares: &'a [SquareSums],
    /// By group; for samples that are not.
    pub groups: &'a [GroupSums],
    /// Samples in every pixel.
    pub spp: u32,
}

impl Sums<'_> {
    /// Samples a pixel from which on its error is known.
    fn least(&self) -> u32 {
        if self.groups.is_empty() { 2 } else { GROUPS }
    }

    /// Whether there are enough samples to estimate errors.
    pub fn tell_errors(&self) -> bool {
        self.spp >= self.least()
    }

    /// The estimated variance of the mean of pixel `index`, per channel. Where group sizes differ (`spp` is no multiple of
    /// 4) it is right for independent samples and a little too large for better ones.
    ///
    /// Only if [`Sums::tell_errors`].
    pub(super) fn variance(&self, index: usize) -> [f64; 3] {
        let (pixel, n) = (&self.pixels[index], self.spp as f64);
        std::array::from_fn(|c| match self.groups.get(index) {
            None => squared_deviations(pixel.sum[c], self.squares[index].0[c], n) / (n - 1.0) / n,
            Some(groups) => groups.squared_deviations(c, pixel.sum[c] / n, self.spp) / (GROUPS - 1) as f64 / n,
        })
    }
}

/// Sum of the squared deviations of `n` samples from their mean; never below 0, as rounding might have it.
fn squared_deviations(sum: f64, squares: f64, n: f64) -> f64 {
    (squares - sum * sum / n).max(0.0)
}
