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

/// Errors of a kernel against its truth: the largest, and how they are spread.
#[derive(Clone, Debug)]
pub struct Errors {
    /// How many there are.
    pub count: u64,
    /// The largest, in ulp.
    pub largest: f64,
    /// The largest, relative to the truth.
    pub relative: f64,
    /// The inputs of the largest.
    pub at: String,
    /// Counts by the eighths of octaves from 2^-8 ulp on.
    bins: [u64; BINS],
    /// The same of relative errors, from 2^-40 on.
    relative_bins: [u64; BINS],
}

const BINS: usize = 512;

impl Default for Errors {
    fn default() -> Errors {
        Errors { count: 0, largest: 0.0, relative: 0.0, at: String::new(), bins: [0; BINS], relative_bins: [0; BINS] }
    }
}

impl Errors {
    /// Takes a value in whose truth is known; `at` names the inputs.
    pub fn add(&mut self, value: f32, truth: f64, at: impl FnOnce() -> String) {
        self.add_scaled(value, truth, truth, at);
    }

    /// Takes a value in whose error is measured in ulp of `size`, not of the truth itself: where terms of that size cancel.
    pub fn add_scaled(&mut self, value: f32, truth: f64, size: f64, at: impl FnOnce() -> String) {
        let value = f64::from(value);
        let exponent = size.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor().clamp(-126.0, 127.0);
        let same = value == truth || value.is_nan() && truth.is_nan();
        let error = if same { 0.0 } else { (value - truth).abs() / (exponent - 23.0).exp2() };
        let relative = if same { 0.0 } else { (value - truth).abs() / size.abs().max(f64::from(f32::MIN_POSITIVE)) };
        self.count += 1;
        self.bins[bin(error, -8.0)] += 1;
        self.relative_bins[bin(relative, -40.0)] += 1;
        if worse(relative, self.relative) {
            self.relative = relative;
        }
        if worse(error, self.largest) {
            self.largest = error;
            self.at = at();
        }
    }

    /// What 9,999 of 10,000 errors do not exceed, in ulp and relative.
    pub fn usual(&self) -> [f64; 2] {
        let of = |bins: &[u64; BINS], first: f64| {
            let (mut left, mut at) = (self.count / 10_000, BINS - 1);
            while at > 0 && bins[at] <= left {
                left -= bins[at];
                at -= 1;
            }
            if at == 0 { 0.0 } else { (first + at as f64 / 8.0).exp2() }
        };
        [of(&self.bins, -8.0), of(&self.relative_bins, -40.0)]
    }

    /// All of it in words.
    pub fn note(&self) -> String {
        let [ulp, relative] = self.usual();
        let Errors { largest, relative: most, at, .. } = self;
        format!("largest {largest:.3} ulp ({most:.1e}) at {at}; 99.99 % within {ulp:.3} ulp ({relative:.1e})")
    }
}

/// The bin of an error, upper end included.
fn bin(error: f64, first: f64) -> usize {
    match error {
        error if error <= 0.0 => 0,
        error if error.is_nan() => BINS - 1,
        error => (((error.log2() - first) * 8.0).ceil().max(0.0) as usize).min(BINS - 1),
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
    fn errors_have_a_largest_and_a_spread() {
        let mut errors = Errors::default();
        for i in 0..100_000 {
            let error = if i % 20_000 == 7 { 32.0 } else { 1.0 };
            errors.add(1.0 + error * f32::EPSILON, 1.0, || i.to_string());
        }
        let [ulp, relative] = errors.usual();
        assert_eq!((errors.largest, errors.relative, &errors.at[..]), (32.0, 32.0 * f64::from(f32::EPSILON), "7"));
        assert!((ulp - 1.0).abs() < 0.1 && (relative / f64::from(f32::EPSILON) - 1.0).abs() < 0.1, "{ulp} {relative}");
        errors.add(f32::NAN, 1.0, || "nan".into());
        assert!(errors.largest.is_nan());
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
