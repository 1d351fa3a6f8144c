//! Light choice by what was learned is unbiased: no sample of the picture has shaped its own density.

use crate::common::{rooms, small, windows};
use octray::{Engine, Film, Lights, PreparedScene, Sampler, Settings, Strategy, Train, render};

/// Blocks of 4 x 4 pixels along each side of the film.
const BLOCKS: u32 = 4;
const SIDE: u32 = 4 * BLOCKS;
/// Renders that learn, each from a training of its own.
const SEEDS: u32 = 60;

/// The mean over channels and pixels of each block, and of the film.
fn means(film: &Film) -> Vec<f64> {
    let mut means = vec![0.0; (BLOCKS * BLOCKS) as usize + 1];
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        let value = film.mean(x, y).into_iter().map(f64::from).sum::<f64>() / 3.0;
        means[(y / 4 * BLOCKS + x / 4) as usize] += value / 16.0;
        *means.last_mut().expect("the film's") += value / f64::from(SIDE * SIDE);
    }
    means
}

/// Means over renders and their variances.
fn over(renders: impl Iterator<Item = Vec<f64>>) -> Vec<(f64, f64)> {
    let all: Vec<Vec<f64>> = renders.collect();
    let n = all.len() as f64;
    (0..all[0].len())
        .map(|i| {
            let mean = all.iter().map(|means| means[i]).sum::<f64>() / n;
            let squares = all.iter().map(|means| (means[i] - mean).powi(2)).sum::<f64>();
            (mean, squares / (n - 1.0) / n)
        })
        .collect()
}

/// How far renders that learn are from renders by the tree, in standard errors: of each block, then of the film. They have so
/// many samples a pixel.
fn distances(scene: &PreparedScene, settings: &Settings, (spp, of_tree): (u32, u32)) -> Vec<f64> {
    let used = std::cell::Cell::new(0);
    let with = |lights: Lights, spp: u32, seeds: u32| {
        over((0..seeds).map(|seed| {
            let render = render(scene, &Settings { lights, spp, seed: 100 * spp + seed, ..settings.clone() });
            let paid = render.stats.learning.is_some_and(|learning| {
                learning.used || learning.environment.is_some_and(|environment| environment.used)
            });
            used.set(used.get() + u32::from(paid));
            means(&render.film)
        }))
    };
    let learned = with(settings.lights, spp, SEEDS);
    // A training this short may foresee too little now and then.
    assert!(used.get() > SEEDS * 3 / 4, "learning has paid {} of {SEEDS} times", used.get());
    let tree = with(Lights::Tree, of_tree, 8);
    learned.iter().zip(&tree).map(|((a, va), (b, vb))| (a - b) / (va + vb).sqrt()).collect()
}

/// 60 renders, each with tables of its own, against renders by the tree: a bias of the film's mean, or of blocks of it, would
/// show beyond their errors. With fixed seeds; each of the two bounds would fail a sound program once in 1,000 choices of them.
#[test]
fn learned_choice_is_unbiased() {
    check_means(Lights::Learned, 2048, (4, 128));
}

/// The same where visibility weighs the choice, and shadow rays survive roulette by it. The map must know enough pairs of cells
/// that see each other in part: without what survivors stand for, the mean square is 30 in the scene without a window.
#[test]
fn roulette_of_shadow_rays_is_unbiased() {
    check_means(Lights::NeePlusPlus, 16_384, (32, 1024));
}

/// The same where patches of an environment map are weighed, which rooms see through windows.
#[test]
fn learned_patches_are_unbiased() {
    check_means_of([windows(false), windows(true), windows(false)], Lights::Learned, 16_384, (4, 128));
}

fn check_means(lights: Lights, paths: u32, samples: (u32, u32)) {
    check_means_of([rooms(false), rooms(true), rooms(false)], lights, paths, samples);
}

fn check_means_of(scenes: [PreparedScene; 3], lights: Lights, paths: u32, samples: (u32, u32)) {
    for (scene, (strategy, sampler)) in scenes.into_iter().zip([
        (Strategy::MisPower, Sampler::Sobol),
        (Strategy::MisPower, Sampler::Independent),
        (Strategy::Nee, Sampler::Sobol),
    ]) {
        let settings = Settings {
            strategy,
            lights,
            sampler,
            train: Train::Paths(paths),
            max_depth: Some(3),
            engine: Engine::Packet,
            ..small(SIDE, SIDE, 1)
        };
        let distances = distances(&scene, &settings, samples);
        let (film, blocks) = distances.split_last().expect("blocks and the film");
        // The mean square of 16 numbers with errors told by 60 and 8 renders is below 3.2 in all but 0.1 % of cases.
        let square = blocks.iter().map(|z| z * z).sum::<f64>() / blocks.len() as f64;
        assert!(film.abs() < 4.0, "{lights}, {strategy}, {sampler}: the film is {film:.1} standard errors off");
        assert!(square < 3.2, "{lights}, {strategy}, {sampler}: mean square {square:.2} of {blocks:.1?}");
    }
}
