//! Guided directions: tables and pictures are the same bits whichever engine and however many threads make them, and depend on
//! the recipe alone; their density is one, and is what is drawn from; what is learned leaves no trace in the mean.

use crate::common::{chi_square_z, first_difference, prepared, small};
use octray::internal::reference::single::{Vec3, guide::GuidePlace};
use octray::internal::render::pilot::resolve;
use octray::internal::sampler::{random_words, unit};
use octray::internal::tables::guide::{GUIDED, Guide as Tables};
use octray::{Engine, Guide, Lights, PreparedScene, Roulette, Settings, Strategy, Train, render};

/// A small picture that is guided, whatever is foreseen.
fn guided(paths: u32) -> Settings {
    let train = Train::Paths(paths);
    let base = small(20, 16, 4);
    Settings { guide: Guide::On, roulette: Roulette::Learned, train, max_depth: Some(6), ..base }
}

fn tables(scene: &PreparedScene, settings: &Settings) -> Tables {
    resolve(scene, settings).guide.expect("there are diffuse surfaces")
}

#[test]
fn engines_and_threads_make_the_same_tables_and_pictures() {
    let mut guided_somewhere = 0;
    for path in ["scenes/cornell.toml", "scenes/glass.toml", "scenes/sky.toml", "scenes/leaves.toml"] {
        let scene = prepared(path);
        let strategies = [(Strategy::MisPower, Lights::Learned), (Strategy::MisOneSample, Lights::Tree)];
        for (strategy, lights) in strategies.into_iter().chain([(Strategy::Bsdf, Lights::Uniform)]) {
            for (guide, roulette) in [(Guide::On, Roulette::Learned), (Guide::On, Roulette::Throughput)] {
                let packet = Settings { strategy, lights, guide, roulette, ..guided(4096) };
                let scalar = Settings { engine: Engine::Scalar, threads: 3, ..packet.clone() };
                let learned = tables(&scene, &packet);
                guided_somewhere += learned.leaves.iter().filter(|leaf| **leaf & GUIDED != 0).count();
                assert!(learned == tables(&scene, &scalar), "{path} {strategy} {roulette}: tables");
                let films = [&packet, &scalar].map(|settings| render(&scene, settings).film);
                let difference = first_difference(&films[0], &films[1]);
                assert_eq!(difference, None, "{path} {strategy} {roulette}");
            }
        }
    }
    assert!(guided_somewhere > 0);
}

#[test]
fn roulette_by_albedos_is_the_same_in_both_engines() {
    for path in ["scenes/glass.toml", "scenes/glossy_plates.toml", "scenes/cornell_mirror.toml"] {
        let scene = prepared(path);
        for roulette in [Roulette::Albedo, Roulette::Learned] {
            let packet = Settings { guide: Guide::Off, roulette, ..guided(4096) };
            let scalar = Settings { engine: Engine::Scalar, ..packet.clone() };
            let films = [&packet, &scalar].map(|settings| render(&scene, settings).film);
            assert_eq!(first_difference(&films[0], &films[1]), None, "{path} {roulette}");
        }
    }
}

#[test]
fn tables_depend_on_the_recipe_alone() {
    let scene = prepared("scenes/cornell.toml");
    let one = guided(8192);
    let learned = tables(&scene, &one);
    let crop = Some(octray::Crop { x: 3, y: 5, width: 4, height: 2 });
    for same in [
        Settings { spp: 77, ..one.clone() },
        Settings { crop, threads: 2, ..one.clone() },
        Settings { target_error: Some(0.5), time: Some(std::time::Duration::from_secs(1)), ..one.clone() },
    ] {
        assert!(learned == tables(&scene, &same));
    }
    for other in [
        Settings { seed: 1, ..one.clone() },
        Settings { max_depth: Some(3), ..one.clone() },
        Settings { strategy: Strategy::Nee, ..one.clone() },
        Settings { roulette: Roulette::Albedo, ..one.clone() },
        guided(4096),
    ] {
        assert!(learned != tables(&scene, &other));
    }
    // A crop shows what the whole picture does there.
    let whole = render(&scene, &one).film;
    let part = render(&scene, &Settings { crop, ..one }).film;
    for (x, y) in (0..4).flat_map(|x| (0..2).map(move |y| (x, y))) {
        let (pixel, same) = (part.pixels[(y * 4 + x) as usize], whole.pixels[((y + 5) * 20 + x + 3) as usize]);
        assert_eq!(pixel.sum.map(f64::to_bits), same.sum.map(f64::to_bits));
    }
}

/// Guided places of a scene, one for every leaf, and normals there.
fn places(learned: &Tables) -> Vec<(GuidePlace<'_>, Vec3)> {
    let normals = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut places: Vec<(GuidePlace, Vec3)> = Vec::new();
    let low = Vec3::from(learned.low);
    for (cell, normal) in (0..16u32.pow(3)).flat_map(|cell| normals.map(|normal| (cell, normal))) {
        let at = [cell % 16, cell / 16 % 16, cell / 256].map(|at| (at * 4 + 2) as f32 / learned.scale);
        let place = GuidePlace::find(learned, low + Vec3::from(at), normal);
        if place.guided && places.iter().all(|(other, _)| other.leaf != place.leaf) {
            places.push((place, normal));
        }
    }
    places
}

/// The direction of these cosine and turn.
fn direction(cosine: f32, turn: f32) -> Vec3 {
    let (sine, cosine_of_turn) = (turn * std::f32::consts::TAU).sin_cos();
    let radius = (1.0 - cosine * cosine).sqrt();
    Vec3::new(radius * cosine_of_turn, radius * sine, cosine)
}

#[test]
fn densities_integrate_to_one() {
    let scene = prepared("scenes/cornell.toml");
    let learned = tables(&scene, &guided(65_536));
    let places = places(&learned);
    assert!(places.len() > 5, "{} leaves are guided", places.len());
    const STEPS: u32 = 256;
    for (place, _) in places.iter().take(8) {
        let mut sum = 0.0;
        for (row, column) in (0..STEPS).flat_map(|row| (0..STEPS).map(move |column| (row, column))) {
            let at = |i: u32| (i as f32 + 0.5) / STEPS as f32;
            sum += f64::from(place.guide_pdf_dir(direction(2.0 * at(row) - 1.0, at(column))));
        }
        let integral = sum * 4.0 * std::f64::consts::PI / f64::from(STEPS * STEPS);
        assert!((integral - 1.0).abs() < 0.01, "leaf {}: {integral}", place.leaf);
    }
}

/// Pearson's test in cells of the whole sphere, and one for draws below the surface. z below 4.3 for each of eight leaves: 7e-5
/// for all together (Sidak).
#[test]
fn directions_are_drawn_from_their_density() {
    let scene = prepared("scenes/cornell.toml");
    let learned = tables(&scene, &guided(65_536));
    const CELLS: u32 = 12;
    const FINE: u32 = 20;
    const DRAWS: u32 = 40_000;
    for (place, normal) in places(&learned).into_iter().take(8) {
        let cell = |d: Vec3| {
            let turn = (d.y.atan2(d.x) / std::f32::consts::TAU).rem_euclid(1.0);
            let along = |x: f32| ((x * CELLS as f32) as u32).min(CELLS - 1);
            (along(d.z * 0.5 + 0.5) * CELLS + along(turn)) as usize
        };
        let mut wanted = vec![0.0; (CELLS * CELLS + 1) as usize];
        let steps = CELLS * FINE;
        for (row, column) in (0..steps).flat_map(|row| (0..steps).map(move |column| (row, column))) {
            let at = |i: u32| (i as f32 + 0.5) / steps as f32;
            let d = direction(2.0 * at(row) - 1.0, at(column));
            let cosine = normal.dot(d);
            if cosine > 0.0 {
                let pdf = f64::from(place.pdf_dir(d, cosine * std::f32::consts::FRAC_1_PI));
                wanted[cell(d)] += pdf * 4.0 * std::f64::consts::PI / f64::from(steps * steps) * f64::from(DRAWS);
            }
        }
        wanted[(CELLS * CELLS) as usize] = f64::from(DRAWS) - wanted.iter().sum::<f64>();
        let mut drawn = vec![0.0; wanted.len()];
        for i in 0..DRAWS {
            let [u, v, choice, _] = random_words(i, 17, place.leaf, 2026).map(unit);
            let sample = place.sample(&scene.materials[0], normal, [u, v], choice);
            drawn[sample.map_or((CELLS * CELLS) as usize, |sample| cell(sample.direction))] += 1.0;
        }
        let z = chi_square_z(&drawn, &wanted);
        assert!(z < 4.3, "leaf {}: z {z}", place.leaf);
    }
}

/// Means of 24 independent trainings and renders against as many without anything learned, of each quarter of the picture: z below 4
/// (0.05 % for the 8 figures together).
#[test]
fn guiding_leaves_the_mean_alone() {
    for path in ["scenes/cornell.toml", "scenes/glass.toml"] {
        let scene = prepared(path);
        let quarters = |settings: &Settings| {
            let film = render(&scene, settings).film;
            let mut sums = [0.0; 4];
            for (i, pixel) in film.pixels.iter().enumerate() {
                let (x, y) = (i % 20 / 10, i / 20 / 8);
                sums[2 * y + x] += pixel.sum[1] / f64::from(film.spp);
            }
            sums
        };
        const SEEDS: u32 = 24;
        let of = |learned: bool| -> Vec<[f64; 4]> {
            let one = Settings { spp: 32, ..guided(4096) };
            let plain = Settings { guide: Guide::Off, roulette: Roulette::Throughput, seed: 900, ..one.clone() };
            let base = if learned { one } else { plain };
            (0..SEEDS).map(|seed| quarters(&Settings { seed: base.seed + seed, ..base.clone() })).collect()
        };
        let moments = |runs: &[[f64; 4]], quarter: usize| {
            let n = f64::from(SEEDS);
            let mean = runs.iter().map(|run| run[quarter]).sum::<f64>() / n;
            let squares = runs.iter().map(|run| (run[quarter] - mean).powi(2)).sum::<f64>();
            (mean, squares / (n - 1.0) / n)
        };
        let (with, without) = (of(true), of(false));
        for quarter in 0..4 {
            let ((a, va), (b, vb)) = (moments(&with, quarter), moments(&without, quarter));
            let z = (a - b) / (va + vb).sqrt();
            assert!(z.abs() < 4.0, "{path}, quarter {quarter}: {a} and {b}, z {z}");
        }
    }
}

#[test]
fn guiding_is_off_where_it_cannot_help_or_is_not_foreseen_to() {
    let scene = prepared("scenes/cornell.toml");
    let outcome = |settings: &Settings| resolve(&scene, settings).learning.and_then(|learning| learning.guide);
    let why = |settings: Settings| outcome(&settings).expect("asked for").why;
    assert_eq!(outcome(&small(8, 8, 1)), None);
    assert!(why(Settings { train: Train::Off, ..guided(1) }).contains("switched off"));
    assert!(why(Settings { strategy: Strategy::Uniform, ..guided(1) }).contains("uniformly"));
    assert!(why(Settings { max_depth: Some(1), ..guided(1) }).contains("one event"));
    assert!(why(Settings { max_depth: Some(0), ..guided(1) }).contains("scatters"));
    // What light samples find by themselves leaves nothing to be gained, so the picture is the one without.
    let scene = prepared("scenes/lecture_lights.toml");
    let auto = Settings { guide: Guide::Auto, roulette: Roulette::Auto, ..guided(16_384) };
    let setup = resolve(&scene, &auto);
    assert_eq!(setup.roulette, Roulette::Throughput);
    let learning = setup.learning.and_then(|learning| learning.guide).expect("asked for");
    assert!(!learning.used && setup.guide.is_none(), "{learning:?}");
    let plain = Settings { guide: Guide::Off, roulette: Roulette::Throughput, ..auto.clone() };
    assert_eq!(first_difference(&render(&scene, &auto).film, &render(&scene, &plain).film), None);
    // Light that only bounces bring is found by guiding.
    let scene = prepared("scenes/door_ajar.toml");
    let setup = resolve(&scene, &auto);
    assert_eq!(setup.roulette, Roulette::Learned);
    let learning = setup.learning.and_then(|learning| learning.guide).expect("asked for");
    assert!(learning.guides && learning.guided > 0 && setup.guide.is_some(), "{learning:?}");
}
