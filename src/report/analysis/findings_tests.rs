//! Synthetic experiments whose answers are known.

use super::*;
use crate::report::measure::run_error::{Measured, TILES, measure};
use crate::sampler::{random_words, unit};

const SIDE: u32 = 32;

/// A picture whose pixels are `mean` + noise of variance `variance / spp`, nearly normal.
fn picture(mean: f64, variance: f64, spp: u32, seed: u32) -> Image {
    let deviation = (variance / spp as f64).sqrt();
    let normal = |i: u32, c: u32| {
        let words = (0..3).flat_map(|block| random_words(i, c, block, seed));
        words.map(|word| unit(word) as f64).sum::<f64>() - 6.0
    };
    let pixel = |i: u32| [0, 1, 2].map(|c| (mean + deviation * normal(i, c)) as f32);
    let count = SIDE * SIDE;
    Image {
        width: SIDE,
        height: SIDE,
        pixels: (0..count).map(pixel).collect(),
        variance: Some(vec![[(variance / spp as f64) as f32; 3]; count as usize]),
        ..Image::default()
    }
}

fn run(image: &Image, reference: &Image, budget: usize, repeat: u32, spp: u32) -> Run {
    let error: Measured = measure(image, reference, &[]);
    assert_eq!(error.mse_by_tile.len(), TILES * TILES);
    Run {
        case: 0,
        configuration: 0,
        budget,
        repeat,
        seed: 0,
        spp,
        seconds: 0.01 * spp as f64,
        cpu_seconds: 0.02 * spp as f64,
        error,
        rays: [spp as u64 * 1000; 3],
        lanes_used: Some(0.5),
        faults: 0,
    }
}

/// The finding of an estimator with this mean and variance of a sample, where the truth is 1; the reference is noisy too.
fn finding(mean: f64, variance: f64, stream: u32) -> Finding {
    let reference = picture(1.0, 1.0, 20_000, 7);
    let spps = [1, 4, 16, 64, 256];
    let (mut runs, mut pool) = (Vec::new(), Pool::new((SIDE * SIDE) as usize));
    for repeat in 0..5 {
        for (budget, spp) in spps.into_iter().enumerate() {
            let image = picture(mean, variance, spp, stream + 10 * repeat + budget as u32);
            pool.add(&image, spp);
            runs.push(run(&image, &reference, budget, repeat, spp));
        }
    }
    let runs: Vec<&Run> = runs.iter().collect();
    find(&spps.map(Budget::Spp), &runs, &pool, &reference, true, simultaneous_95(1))
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} and {expected}");
}

#[test]
fn an_exact_estimator_falls_as_one_over_n_and_has_no_bias() {
    let found = finding(1.0, 0.5, 1000);
    for fit in [found.mse_by_samples, found.relmse_by_samples, found.relmse_by_seconds] {
        let interval = fit.unwrap().slope_interval.unwrap();
        assert!(interval.contains(-1.0) && interval.high - interval.low < 0.03, "{interval:?}");
    }
    assert!(!found.biased && found.bias_z.abs() < 3.0, "{}", found.bias_z);
    assert!(found.floor < 1e-5, "{}", found.floor);
    // relMSE of a sample: 0.5 / 1.01; efficiency at 256 samples: 1 / (0.5 / 1.01 / 256 x 0.02 x 256).
    let Some(Law::Variance { variance }) = found.law else { panic!("{:?}", found.law) };
    near(variance, 0.5 / 1.01, 0.02);
    near(found.efficiency.unwrap(), 1.01 / 0.5 / 0.02, 0.05);
    let interval = found.efficiency_interval.unwrap();
    assert!(interval.contains(found.efficiency.unwrap()) && interval.high / interval.low < 1.2);
    // 5 %: 0.495 / 0.0025 = 198 samples, 3.96 s; 1 %: 4950 samples, beyond what was measured.
    near(found.prices[1].cpu_seconds.unwrap(), 3.96, 0.02);
    assert_eq!(found.prices.iter().map(|p| p.extrapolated).collect::<Vec<_>>(), [false, false, true, true]);
    near(found.points[2].mrays_per_s, 16.0 * 3000.0 / 0.32 * 1e-6, 1e-9);
}

#[test]
fn a_biased_estimator_is_caught_and_levels_off() {
    // 3 % too bright, noise of one sample 0.7: nothing that a single picture of 1 sample would show.
    let found = finding(1.03, 0.5, 2000);
    assert!(found.biased && found.bias_z > 20.0, "{}", found.bias_z);
    near(found.relative_bias, 0.03, 0.03);
    near(found.floor, 0.03 * 0.03 / 1.01, 0.05);
    let Some(Law::Floor { floor, variance }) = found.law else { panic!("{:?}", found.law) };
    assert_eq!(floor, found.floor);
    near(variance, 0.5 / 1.01, 0.02);
    assert_eq!(found.efficiency, None);
    let reached: Vec<bool> = found.prices.iter().map(|price| price.samples.is_some()).collect();
    assert_eq!(reached, [true, true, false, false], "a floor of 3 % is above 2 %");
    assert!(!found.relmse_by_samples.unwrap().slope_interval.unwrap().contains(-1.0));
}

#[test]
fn rare_bright_samples_that_nobody_has_met_are_told_from_bias() {
    // Half of the light comes in samples so rare that no run met them: what is left is calm but for one pixel.
    let reference = picture(1.0, 0.0, 1, 7);
    let mut pool = Pool::new((SIDE * SIDE) as usize);
    let image = |seed: u32| {
        let mut image = picture(0.5, 1e-6, 16, seed);
        image.pixels[5] = [3.0; 3];
        image.variance.as_mut().unwrap()[5] = [6.0; 3];
        image
    };
    let images = [image(1), image(2)];
    images.iter().for_each(|image| pool.add(image, 16));
    let runs = [0, 1].map(|repeat| run(&images[repeat as usize], &reference, 0, repeat, 16));
    let runs: Vec<&Run> = runs.iter().collect();
    let verdict = |exact: bool| {
        let found = find(&[Budget::Spp(16)], &runs, &pool, &reference, exact, simultaneous_95(1));
        assert!(found.bias_z < -BIAS_Z && found.effective_pixels < 1.1 && found.efficiency.is_none());
        found.verdict
    };
    assert_eq!((verdict(true), verdict(false)), (Verdict::Undersampled, Verdict::Biased));
}

#[test]
fn repeats_that_are_far_apart_widen_the_standard_error() {
    let reference = picture(1.0, 0.0, 1, 7);
    let images = [picture(1.1, 1e-4, 16, 1), picture(0.9, 1e-4, 16, 2)];
    let mut pool = Pool::new((SIDE * SIDE) as usize);
    images.iter().for_each(|image| pool.add(image, 16));
    let runs = [0, 1].map(|repeat| run(&images[repeat as usize], &reference, 0, repeat, 16));
    let found = find(&[Budget::Spp(16)], &runs.iter().collect::<Vec<_>>(), &pool, &reference, true, simultaneous_95(1));
    // Means 0.1 and -0.1: a deviation of 0.1 sqrt(2), of their mean 0.1.
    near(found.bias_se, 0.1, 0.01);
    assert_eq!(found.verdict, Verdict::Unbiased);
}

#[test]
fn sample_ratios_compare_errors() {
    let (noisy, calm) = (finding(1.0, 6.0, 3000), finding(1.0, 0.5, 1000));
    let (ratio, interval) = sample_ratio(&noisy, &calm).unwrap();
    near(ratio, 12.0, 0.05);
    assert!(interval.unwrap().contains(12.0), "{interval:?}");
    assert_eq!(sample_ratio(&finding(1.5, 0.5, 4000), &calm), None);
}

#[test]
fn laws_and_their_inverses() {
    for law in [
        Law::Variance { variance: 2.0 },
        Law::Power { constant: 3.0, slope: -1.5 },
        Law::Floor { floor: 0.001, variance: 2.0 },
    ] {
        near(law.samples_for(law.at(37.0)).unwrap(), 37.0, 1e-9);
    }
    assert_eq!(Law::Floor { floor: 0.01, variance: 1.0 }.samples_for(0.01), None);
    assert_eq!(Law::Floor { floor: 0.01, variance: 1.0 }.samples_for(0.005), None);
}

#[test]
fn a_single_run_has_figures_and_no_intervals() {
    let reference = picture(1.0, 0.0, 1, 7);
    let image = picture(1.0, 0.5, 4, 9);
    let run = run(&image, &reference, 0, 0, 4);
    let mut pool = Pool::new((SIDE * SIDE) as usize);
    pool.add(&image, 4);
    let found = find(&[Budget::Spp(4)], &[&run], &pool, &reference, true, simultaneous_95(1));
    assert!(found.points[0].relmse > 0.0 && found.points[0].relmse_interval.is_none());
    assert!(found.relmse_by_samples.is_none() && found.efficiency.is_some() && found.efficiency_interval.is_none());
    assert!(found.prices[0].extrapolated && found.prices[0].samples.is_some());
}
