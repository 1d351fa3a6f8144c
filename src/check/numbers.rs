//! Inputs of checks at fixed seeds, and distances in units of the last place.

use crate::sampler::{random_words, unit};
use glam::DVec3;

/// A stream of numbers that depends on its seed alone.
pub struct Numbers {
    seed: u32,
    block: u32,
    words: [u32; 4],
    used: usize,
}

impl Numbers {
    /// The stream of `seed`.
    pub fn new(seed: u32) -> Numbers {
        Numbers { seed, block: 0, words: [0; 4], used: 4 }
    }

    /// 32 random bits.
    pub fn word(&mut self) -> u32 {
        if self.used == 4 {
            self.words = random_words(0xC4EC, self.block, 0, self.seed);
            self.block = self.block.wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        self.words[self.used - 1]
    }

    /// A number in [0, 1), a multiple of 2^-24.
    pub fn unit(&mut self) -> f32 {
        unit(self.word())
    }

    /// A number in [0, 1) with 53 random bits.
    pub fn fine(&mut self) -> f64 {
        let bits = u64::from(self.word()) << 21 ^ u64::from(self.word()) >> 11;
        bits as f64 / (1u64 << 53) as f64
    }

    /// A whole number below `count`.
    pub fn below(&mut self, count: u32) -> u32 {
        ((u64::from(self.word()) * u64::from(count)) >> 32) as u32
    }

    /// A number between the powers `low` and `high` of 10, uniform in its logarithm.
    pub fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(low + (high - low) * self.fine())
    }

    /// A number in [`low`, `high`).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.fine()
    }

    /// A unit vector, uniform over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.fine() - 1.0;
        let (sine, cosine) = (self.fine() * std::f64::consts::TAU).sin_cos();
        let radius = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(radius * cosine, radius * sine, z)
    }
}

/// How many units in the last place of f32 `value` is from `truth`; below the normal numbers the unit is 2^-149. 0 where both
/// are no numbers or the same infinity.
pub fn ulps(value: f64, truth: f64) -> f64 {
    if value == truth || value.is_nan() && truth.is_nan() {
        return 0.0;
    }
    let exponent = truth.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor().clamp(-126.0, 127.0);
    (value - truth).abs() / (exponent - 23.0).exp2()
}

/// Whether `error` is worse than the worst so far: larger, or no number.
pub fn worse(error: f64, worst: f64) -> bool {
    error > worst || error.is_nan() && !worst.is_nan()
}

/// A sum in which no addition is lost: Neumaier's compensated one (1974).
#[derive(Clone, Copy, Debug, Default)]
pub struct Exact {
    sum: f64,
    rest: f64,
}

impl Exact {
    /// Adds a number.
    pub fn add(&mut self, value: f64) {
        let sum = self.sum + value;
        self.rest += if self.sum.abs() >= value.abs() { (self.sum - sum) + value } else { (value - sum) + self.sum };
        self.sum = sum;
    }

    /// What all of them come to.
    pub fn total(self) -> f64 {
        self.sum + self.rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulps_are_counted_at_the_truth() {
        let next = f32::from_bits(1f32.to_bits() + 1);
        assert_eq!(
            (ulps(1.0, 1.0), ulps(f64::from(next), 1.0), ulps(f64::from(f32::from_bits(3)), 0.0)),
            (0.0, 1.0, 3.0)
        );
        assert_eq!(ulps(f64::NAN, f64::NAN), 0.0);
        assert!(ulps(f64::NAN, 1.0).is_nan() && ulps(f64::INFINITY, 1.0) == f64::INFINITY);
    }

    #[test]
    fn small_terms_are_not_lost() {
        let mut sum = Exact::default();
        [1e16, 1.0, -1e16, 1.0].into_iter().for_each(|value| sum.add(value));
        assert_eq!(sum.total(), 2.0);
    }

    #[test]
    fn streams_cover_their_ranges() {
        let mut numbers = Numbers::new(7);
        let values: Vec<f64> = (0..1000).map(|_| numbers.magnitude(-3.0, 2.0)).collect();
        assert!(values.iter().all(|v| (1e-3..100.0).contains(v)) && values.iter().any(|v| *v > 50.0));
        assert!((0..1000).all(|_| numbers.below(3) < 3 && numbers.fine() < 1.0));
        assert!((0..100).all(|_| (numbers.direction().length() - 1.0).abs() < 1e-12));
    }
}
