//! All exact strategies, light selections and samplers have the same expected picture.
//!
//! Per scene, each is compared with `mis-power` at four times the samples, block by block and channel by channel, by a
//! z-test. The significance of the whole file is 0.1 % (Sidak): with about 4,000 comparisons |z| must stay below 5.2. A
//! block counts if both sides have more than 30 effective samples, (sum x)^2 / sum x^2; below that a mean is not normal.
//!
//! In `lecture_lights` rays find the small blue light about once in 2,000: strategies that rely on that are compared on a
//! softened twin, whose blue light is 300 times dimmer, as bright as the grey one; the others on both. Likewise in `sky`,
//! whose sun is found once in 1,500: in its twin the sun is as bright as the sky around it.

mod common;

use common::{SCENES, estimate, exact_strategies, prepared, small};
use octray::scene::desc::EnvironmentDesc;
use octray::{Lights, Sampler, Scene, Settings, Strategy, render};

/// Sharp lobes and caustics: half of the strategies find them about never. tests/materials.rs compares the strategies on
/// every material under a light that all of them find.
const HARD: [&str; 2] = ["scenes/glossy_plates.toml", "scenes/glass.toml"];
const LECTURE: &str = "scenes/lecture_lights.toml";
const SKY: &str = "scenes/sky.toml";
const BLOCKS: u32 = 3;
const SIDE: u32 = 24;
const MOST_SIGMAS: f64 = 5.2;

#[test]
fn exact_strategies_agree_block_by_block() {
    let soft = |path: &&str| !HARD.contains(path);
    let softened = [(LECTURE, true), (SKY, true)];
    for (path, softened) in SCENES.into_iter().filter(soft).map(|path| (path, false)).chain(softened) {
        let mut scene = Scene::load(path).expect("a scene of ours");
        if softened && let Some(EnvironmentDesc::Map(map)) = &mut scene.desc.environment {
            map.texels.iter_mut().for_each(|texel| *texel = texel.map(|c| c.min(3.0)));
        } else if softened {
            let blue = scene.desc.materials.iter_mut().find(|m| m.name == "blue").expect("the small light");
            blue.emission = blue.emission.map(|c| c / 300.0);
        }
        let scene = scene.prepare().expect("a scene of ours");
        let base = Settings { max_depth: Some(4), threads: 0, ..small(SIDE, SIDE, 512) };
        let sampler = Sampler::Independent;
        let reference = render(&scene, &Settings { spp: 2048, seed: 99, sampler, ..base.clone() }).film;
        for strategy in exact_strategies() {
            let by_chance = matches!(strategy, Strategy::Uniform | Strategy::Bsdf | Strategy::NeeAverage);
            if by_chance && [LECTURE, SKY].contains(&path) && !softened {
                continue;
            }
            for (&lights, &sampler) in Lights::ALL.iter().flat_map(|l| Sampler::ALL.iter().map(move |s| (l, s))) {
                let film = render(&scene, &Settings { strategy, lights, sampler, seed: 1, ..base.clone() }).film;
                let (mut compared, mut skipped) = (0, 0);
                for block in 0..BLOCKS * BLOCKS {
                    let size = SIDE / BLOCKS;
                    let (x, y) = (block % BLOCKS * size, block / BLOCKS * size);
                    for channel in 0..3 {
                        let [a, b] = [&film, &reference].map(|f| estimate(f, x..x + size, y..y + size, channel));
                        if a.mean == 0.0 && b.mean == 0.0 {
                            continue;
                        }
                        if a.effective_samples < 30.0 || b.effective_samples < 30.0 {
                            skipped += 1;
                            continue;
                        }
                        compared += 1;
                        // Where nothing is noisy, f32 rounding is what is left.
                        let sigma = (a.error * a.error + b.error * b.error).sqrt() + 1e-6 * b.mean;
                        let z = (a.mean - b.mean) / sigma;
                        let what = format!(
                            "{path} (softened: {softened}), {strategy}, {lights}, {sampler}, block {x},{y}, channel {channel}"
                        );
                        assert!(z.abs() < MOST_SIGMAS, "{what}: {} and {}, z = {z:.1}", a.mean, b.mean);
                    }
                }
                assert!(compared > skipped, "{path}, {strategy}: {skipped} of {} blocks too noisy", compared + skipped);
            }
        }
    }
}

#[test]
fn the_biased_strategies_differ() {
    let scene = prepared("scenes/cornell.toml");
    let base = small(SIDE, SIDE, 256);
    let truth = render(&scene, &base).film.mean_radiance();
    let sum = render(&scene, &Settings { strategy: Strategy::NeeSum, ..base.clone() }).film.mean_radiance();
    let dark = render(&scene, &Settings { strategy: Strategy::NeeNoEmission, ..base }).film.mean_radiance();
    for c in 0..3 {
        assert!(sum[c] > 1.3 * truth[c], "nee-sum is far too bright: {sum:?} for {truth:?}");
        assert!(dark[c] < 0.95 * truth[c], "nee-no-emission loses the lights: {dark:?} for {truth:?}");
    }
}
