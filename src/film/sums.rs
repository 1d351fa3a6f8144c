//! What pixels gather: sums and sums of squares, added in sample order, and the variance they tell.

use crate::fault::{Fault, planted};
use crate::sampler::sobol::GROUPS;

/// What one pixel has gathered, per channel (linear Rec.709 radiance, W sr^-1 m^-2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Sum of the samples.
    pub sum: [f64; 3],
    /// Sum of their squares.
    pub sum_squares: [f64; 3],
}

impl Pixel {
    /// Adds one sample; true if it was finite, else it is left out (and still counts as a sample of value 0).
    #[inline(always)]
    pub fn add(&mut self, radiance: [f32; 3]) -> bool {
        self.add_in(1.0, radiance)
    }

    /// [`Pixel::add`] of a sample that counts in a `unit` of radiance, a power of two, W sr^-1 m^-2.
    #[inline(always)]
    pub fn add_in(&mut self, unit: f64, radiance: [f32; 3]) -> bool {
        if !radiance.iter().all(|c| c.is_finite()) && !planted(Fault::TakenThoughNotFinite) {
            return false;
        }
        for (channel, value) in radiance.into_iter().enumerate() {
            let value = value as f64 * unit;
            self.sum[channel] += value;
            self.sum_squares[channel] += value * value;
            if planted(Fault::F32Sum) {
                self.sum[channel] = f64::from(self.sum[channel] as f32);
                self.sum_squares[channel] = f64::from(self.sum_squares[channel] as f32);
            }
        }
        true
    }

    /// Sum of the squared deviations of `n` samples from their mean, in one channel; never below 0, as rounding might have it.
    fn squared_deviations(&self, channel: usize, n: f64) -> f64 {
        (self.sum_squares[channel] - self.sum[channel] * self.sum[channel] / n).max(0.0)
    }
}

/// A pixel's sums by group of the `sobol` sampler: sample `k` is in group `k % 4`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupSums(pub [[f64; 3]; GROUPS as usize]);

impl GroupSums {
    /// Adds sample number `sample`, which is finite.
    #[inline(always)]
    pub fn add(&mut self, sample: u32, radiance: [f32; 3]) {
        self.add_in(1.0, sample, radiance);
    }

    /// [`GroupSums::add`] of a sample that counts in a `unit` of radiance.
    #[inline(always)]
    pub fn add_in(&mut self, unit: f64, sample: u32, radiance: [f32; 3]) {
        let sums = &mut self.0[(sample % GROUPS) as usize];
        for (sum, value) in sums.iter_mut().zip(radiance) {
            *sum += value as f64 * unit;
            if planted(Fault::F32Sum) {
                *sum = f64::from(*sum as f32);
            }
        }
    }

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

/// The sums of some pixels. `groups` is empty, or has one entry a pixel.
#[derive(Clone, Copy)]
pub struct Sums<'a> {
    /// All samples.
    pub pixels: &'a [Pixel],
    /// By group; for samples that are not independent.
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
            None => pixel.squared_deviations(c, n) / (n - 1.0) / n,
            Some(groups) => groups.squared_deviations(c, pixel.sum[c] / n, self.spp) / (GROUPS - 1) as f64 / n,
        })
    }
}
