//! All exact strategies, light selections and samplers have the same expected picture.
//!
//! Per scene, each is compared with `mis-power` at four times the samples, block by block and as a whole, channel by
//! channel, by a z-test. The significance of the whole file is 0.1 % (Sidak): with up to 40,000 comparisons |z| must stay
//! below 5.6. A block counts if both sides have more than 30 effective samples, (sum x)^2 / sum x^2; below that a mean is
//! not normal.
//!
//! Where a strategy finds a part of the light about never, that number says nothing (it sees only what was found): such
//! strategies are compared on a softened twin of the scene, the others on both.
//! - `lecture_lights`: rays find the small blue light once in 2,000. Twin: it is 300 times dimmer, as bright as the grey one.
//! - `sky`: rays find its sun once in 1,500. Twin: the sun is as bright as the sky around it.
//! - `glossy_plates`: only weighing by density works for sharp plates and small lamps. Twin: plates of alpha 0.4, and no
//!   lamp brighter than 5.
//! - `lights`: rays find none of its delta lights. There is no twin: strategies without light samples are left out.
//! - `door_ajar`: rays that pass the gap seldom find the lamp behind it. Twin: all of the corridor glows, as bright as the lamp.

use crate::common::{SCENES, estimate, exact_strategies, prepared, small};
use octray::scene::desc::{EnvironmentDesc, LightDesc, Scattering};
use octray::{Film, Lights, PreparedScene, Sampler, Scene, Settings, Strategy, render};

const LECTURE: &str = "scenes/lecture_lights.toml";
const SKY: &str = "scenes/sky.toml";
const PLATES: &str = "scenes/glossy_plates.toml";
const AJAR: &str = "scenes/door_ajar.toml";
const LIGHTS: &str = "scenes/lights.toml";
const BLOCKS: u32 = 3;
const SIDE: u32 = 24;
const MOST_SIGMAS: f64 = 5.6;

/// Whether `strategy` finds all the light of the scene often enough.
fn finds_all(path: &str, strategy: Strategy) -> bool {
    match path {
        LECTURE | SKY | AJAR => !matches!(strategy, Strategy::Uniform | Strategy::Bsdf | Strategy::NeeAverage),
        PLATES | "scenes/principled.toml" => strategy.is_mis(),
        // No ray finds its delta lights.
        LIGHTS => strategy.samples_lights(),
        _ => true,
    }
}

/// The softened twin of a scene, if it needs one.
fn softened(path: &str) -> Option<PreparedScene> {
    let mut scene = Scene::load(path).expect("a scene of ours");
    match path {
        LECTURE => {
            let blue = scene.desc.materials.iter_mut().find(|m| m.name == "blue").expect("the small light");
            blue.emission = blue.emission.map(|c| c / 300.0);
        }
        SKY => {
            let [LightDesc::Environment(EnvironmentDesc::Map(map))] = &mut scene.desc.lights[..] else {
                panic!("a map")
            };
            map.texels.iter_mut().for_each(|texel| *texel = texel.map(|c| c.min(3.0)));
        }
        PLATES => {
            for material in &mut scene.desc.materials {
                if let Scattering::Conductor { alpha, .. } = &mut material.scattering {
                    *alpha = 0.4;
                }
                material.emission = material.emission.map(|c| c.min(5.0));
            }
        }
        AJAR => {
            for material in scene.desc.materials.iter_mut().filter(|m| ["corridor", "lamp"].contains(&m.name.as_str()))
            {
                material.emission = [1.0; 3];
            }
        }
        _ => return None,
    }
    Some(scene.prepare().expect("a scene of ours"))
}

/// Compares two pictures of one scene, all of it and block by block; how many means were compared, and how many blocks had
/// too few effective samples.
fn compare(film: &Film, reference: &Film, what: &str) -> (u32, u32) {
    let (mut compared, mut skipped) = (0, 0);
    let size = SIDE / BLOCKS;
    let blocks = (0..BLOCKS * BLOCKS).map(|block| (block % BLOCKS * size, block / BLOCKS * size, size));
    for (x, y, size) in blocks.chain([(0, 0, SIDE)]) {
        for channel in 0..3 {
            let [a, b] = [film, reference].map(|f| estimate(f, x..x + size, y..y + size, channel));
            if a.mean == 0.0 && b.mean == 0.0 {
                continue;
            }
            if a.effective_samples <= 30.0 || b.effective_samples <= 30.0 {
                skipped += 1;
                continue;
            }
            compared += 1;
            // Where nothing is noisy, f32 rounding is what is left.
            let sigma = a.error.hypot(b.error) + 1e-6 * b.mean;
            let z = (a.mean - b.mean) / sigma;
            let place = format!("{what}, {size} pixels from {x},{y}, channel {channel}");
            assert!(z.abs() < MOST_SIGMAS, "{place}: {} and {}, z = {z:.1}", a.mean, b.mean);
        }
    }
    (compared, skipped)
}

#[test]
fn exact_strategies_agree_block_by_block() {
    let mut total = 0;
    for path in SCENES {
        let twin = softened(path).map(|scene| (scene, true));
        for (scene, soft) in [(prepared(path), false)].into_iter().chain(twin) {
            let base = Settings { max_depth: Some(4), threads: 0, ..small(SIDE, SIDE, 256) };
            let independent = Settings { sampler: Sampler::Independent, ..base.clone() };
            let reference = render(&scene, &Settings { spp: 1024, seed: 99, ..independent }).film;
            for strategy in exact_strategies().filter(|&strategy| soft || finds_all(path, strategy)) {
                // Of 449 lights of the scene of all kinds, one is a delta light: chosen alike, these are met about never.
                let selections = Lights::ALL.iter().filter(|&&lights| path != LIGHTS || lights != Lights::Uniform);
                for (&lights, &sampler) in selections.flat_map(|l| Sampler::ALL.iter().map(move |s| (l, s))) {
                    let film = render(&scene, &Settings { strategy, lights, sampler, seed: 1, ..base.clone() }).film;
                    let what = format!("{path} (softened: {soft}), {strategy}, {lights}, {sampler}");
                    let (compared, skipped) = compare(&film, &reference, &what);
                    println!("{what}: {compared} means compared, {skipped} too noisy");
                    assert!(compared > skipped, "{what}: {skipped} of {} too noisy", compared + skipped);
                    total += compared;
                }
            }
        }
    }
    assert!((9000..40_000).contains(&total), "{total} comparisons: the bound is made for 40,000 at most");
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
