//! Weights of multiple importance sampling, wherever their densities lie.

use crate::check::item::{Check, Effort};
use crate::check::numbers::{Numbers, ulps, worse};
use crate::check::row::Outcome;
use crate::check::trial::{SIGMAS, Trial, Worst, small};
use crate::error::Result;
use crate::lanes::F32x8;
use crate::reference::single::mis;
use crate::settings::Settings;
use crate::strategy::Strategy;
use std::f64::consts::PI;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "mis", what: "balance_weight", run: balance_weight },
    Check { group: "mis", what: "power_weight", run: power_weight },
    Check { group: "mis", what: "weights_sum_to_one", run: weights_sum_to_one },
    Check { group: "mis", what: "zero_and_infinite_densities", run: zero_and_infinite_densities },
    Check { group: "mis", what: "no_weight_from_no_number", run: no_weight_from_no_number },
    Check { group: "mis", what: "lanes_as_scalars", run: lanes_as_scalars },
    Check { group: "mis", what: "strategies_agree_on_a_lamp", run: strategies_agree_on_a_lamp },
];

type Weigh = fn(f32, f32) -> f32;

/// A density from denormal to the largest f32, now and then one of the ends.
fn density(numbers: &mut Numbers) -> f32 {
    const ENDS: [f32; 6] = [1e-45, 1e-40, f32::MIN_POSITIVE, 1.0, 1e38, f32::MAX];
    match numbers.below(8) {
        0 => ENDS[numbers.below(6) as usize],
        _ => numbers.magnitude(-45.0, 38.5).clamp(1e-45, f64::from(f32::MAX)) as f32,
    }
}

/// Two densities: half of the time of similar size, where weights are neither 0 nor 1.
fn densities(numbers: &mut Numbers) -> (f32, f32) {
    let a = density(numbers);
    match numbers.below(2) {
        0 => (a, density(numbers)),
        _ => (a, (f64::from(a) * numbers.magnitude(-4.0, 4.0)).clamp(1e-45, f64::from(f32::MAX)) as f32),
    }
}

/// The largest error of `weigh` against `truth`, in ulp.
fn weight_error(effort: &Effort, weigh: Weigh, truth: fn(f64, f64) -> f64) -> Outcome {
    let cases = effort.cases(1_000_000);
    let mut numbers = Numbers::new(1);
    let (mut worst, mut at) = (0.0, (0.0, 0.0));
    for _ in 0..cases {
        let (a, b) = densities(&mut numbers);
        let (weight, truth) = (f64::from(weigh(a, b)), truth(f64::from(a), f64::from(b)));
        // Weights below the normal numbers are as good as 0: ratios of densities leave the range of f32 there.
        let sunk = weight.max(truth) < f64::from(f32::MIN_POSITIVE);
        let error = if sunk { 0.0 } else { ulps(weight, truth) };
        if worse(error, worst) {
            (worst, at) = (error, (a, b));
        }
    }
    Outcome::at_most(worst, 4.0)
        .tried(cases, "pairs of densities, 1e-45 to 3.4e38, against f64, in ulp")
        .note(format!("worst at {:e}, {:e}", at.0, at.1))
}

fn balance_weight(effort: &Effort) -> Result<Outcome> {
    Ok(weight_error(effort, mis::balance, |a, b| a / (a + b)))
}

fn power_weight(effort: &Effort) -> Result<Outcome> {
    Ok(weight_error(effort, mis::power, |a, b| 1.0 / (1.0 + (b / a) * (b / a))))
}

/// What both techniques count together: 1, or light is lost or counted twice.
fn weights_sum_to_one(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(1_000_000);
    let mut numbers = Numbers::new(2);
    let mut worst: f64 = 0.0;
    for _ in 0..cases {
        let (a, b) = densities(&mut numbers);
        for weigh in [mis::balance, mis::power] as [Weigh; 2] {
            let off = (f64::from(weigh(a, b)) + f64::from(weigh(b, a)) - 1.0).abs();
            worst = if worse(off, worst) { off } else { worst };
        }
    }
    Ok(Outcome::at_most(worst, 3e-7).tried(cases, "pairs of densities, both heuristics, distance of the sum from 1"))
}

/// A technique that cannot find a path counts 0 and the other 1, exactly; an infinite density takes everything.
fn zero_and_infinite_densities(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(100_000);
    let mut numbers = Numbers::new(3);
    let mut wrong = 0;
    for _ in 0..cases {
        let p = density(&mut numbers);
        for weigh in [mis::balance, mis::power] as [Weigh; 2] {
            let right = weigh(p, 0.0) == 1.0 && weigh(f32::INFINITY, p) == 1.0 && weigh(p, f32::INFINITY) == 0.0;
            wrong += u64::from(!right);
        }
    }
    Ok(Outcome::at_most(wrong as f64, 0.0).tried(cases, "densities against 0 and infinity, wrong weights"))
}

/// Densities that are no numbers, 0 against 0 and infinity against infinity give no weight that would pass for one: such
/// samples are counted and reported.
fn no_weight_from_no_number(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(100_000);
    let mut numbers = Numbers::new(4);
    let mut wrong = 0;
    for _ in 0..cases {
        let p = density(&mut numbers);
        let pairs = [(f32::NAN, p), (p, f32::NAN), (f32::NAN, 0.0), (0.0, 0.0), (f32::INFINITY, f32::INFINITY)];
        for weigh in [mis::balance, mis::power] as [Weigh; 2] {
            wrong += pairs.iter().filter(|&&(a, b)| !weigh(a, b).is_nan()).count() as u64;
        }
    }
    Ok(Outcome::at_most(wrong as f64, 0.0).tried(cases, "densities with NaN, 0/0, inf/inf, weights that are numbers"))
}

fn lanes_as_scalars(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(500_000);
    let mut numbers = Numbers::new(5);
    let mut differ = 0;
    for _ in 0..cases.div_ceil(8) {
        let mut pairs = [(0.0f32, 0.0f32); 8];
        for pair in &mut pairs {
            *pair = match numbers.below(16) {
                0 => (f32::INFINITY, density(&mut numbers)),
                1 => (density(&mut numbers), 0.0),
                _ => densities(&mut numbers),
            };
        }
        let (a, b) = (F32x8::from_array(pairs.map(|pair| pair.0)), F32x8::from_array(pairs.map(|pair| pair.1)));
        let lanes = [
            crate::simd::native::kernels::mis::balance(a, b).to_array(),
            crate::simd::native::kernels::mis::power(a, b).to_array(),
        ];
        for (lane, &(a, b)) in pairs.iter().enumerate() {
            differ += u64::from(lanes[0][lane].to_bits() != mis::balance(a, b).to_bits());
            differ += u64::from(lanes[1][lane].to_bits() != mis::power(a, b).to_bits());
        }
    }
    Ok(Outcome::at_most(differ as f64, 0.0).tried(cases, "pairs of densities, weights whose bits differ"))
}

/// Every exact strategy gives the radiance of Lambert's formula on a floor under a square lamp, seen from straight below,
/// from near by, where densities are large, to far away.
fn strategies_agree_on_a_lamp(effort: &Effort) -> Result<Outcome> {
    let spp = effort.samples(256, 64);
    let (mut worst, mut samples) = (Worst::default(), 0);
    for (half, height) in [(0.5, 0.01), (0.5, 0.1), (0.5, 1.0), (0.1, 2.0)] {
        let trial = Trial::new("lamp", &[half, height, 1.0, 0.5, 0.0])?;
        let truth = 0.5 / PI * level_square(half, height);
        for &strategy in Strategy::ALL.iter().filter(|strategy| !strategy.is_biased()) {
            let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
            let mean = trial.mean(&settings, truth);
            samples += u64::from(spp) * 256;
            worst.add(&format!("{strategy}, height {height}"), mean, 1e-4);
        }
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples of 7 strategies at 4 heights, in standard errors")
        .and(worst.nonfinite == 0, "samples are not finite")
        .note(worst.what)
        .trace(worst.trace))
}

/// The irradiance from a level square of radiance 1 and half the side `half`, `height` straight above: four right-angled
/// corners (Howell, configuration B-3, times 4 pi).
fn level_square(half: f64, height: f64) -> f64 {
    let x = half / height;
    let root = (1.0 + x * x).sqrt();
    4.0 * x / root * (x / root).atan()
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (SwappedPdf, &["mis/balance_weight", "mis/power_weight", "mis/zero_and_infinite_densities"]),
        (DensityTwice, &["mis/weights_sum_to_one", "mis/strategies_agree_on_a_lamp"]),
        (WeightOfNoNumber, &["mis/no_weight_from_no_number", "mis/lanes_as_scalars"]),
    ]
};
