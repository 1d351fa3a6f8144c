//! Light samples of an environment map by what was learned of its patches (`--lights learned`): the same tables and pictures in
//! both engines, and densities that are those of what is drawn.

use crate::common::{check_no_trace, chi_square_z, first_difference, prepared, small, windows};
use octray::internal::learn::outcome::Learning;
use octray::internal::packet::plan::Plan;
use octray::internal::reference::single::lights::environment::map_pdf_dir;
use octray::internal::reference::{path_steps, single};
use octray::internal::render::pilot::resolve;
use octray::internal::sampler::random_words;
use octray::internal::tables::lights::environment::Environment;
use octray::internal::tables::lights::learned::LearnedLights;
use octray::internal::tables::lights::patches::PATCHES;
use octray::internal::tables::lights::table::EnvironmentLight;
use octray::internal::{packet, trace};
use octray::render;
use octray::scene::camera::CameraPath;
use octray::{Engine, Guide, Lights, PreparedScene, Sampler, Sequence, Settings, Strategy, Train};

/// Settings of a small picture that learns from so many paths.
fn learning(width: u32, height: u32, spp: u32, paths: u32) -> Settings {
    Settings { lights: Lights::Learned, train: Train::Paths(paths), max_depth: Some(4), ..small(width, height, spp) }
}

/// What a render with these settings learns.
fn learned(scene: &PreparedScene, settings: &Settings) -> (Option<LearnedLights>, Learning) {
    let setup = resolve(scene, settings);
    (setup.lights.learned, setup.learning.expect("something was to be learned"))
}

fn used(learning: &Learning) -> bool {
    learning.environment.as_ref().is_some_and(|environment| environment.used)
}

#[test]
fn engines_learn_and_render_alike() {
    for lamps in [false, true] {
        let scene = windows(lamps);
        let mut paid = 0;
        for &strategy in Strategy::ALL {
            for guide in [Guide::Off, Guide::On] {
                let sampler = if strategy == Strategy::Nee { Sampler::Independent } else { Sampler::Sobol };
                let packet = Settings { strategy, sampler, guide, ..learning(24, 17, 2, 8192) };
                let scalar = Settings { engine: Engine::Scalar, threads: 3, ..packet.clone() };
                let what = format!("lamps: {lamps}, {strategy}, guide {guide}");
                let (tables, told) = learned(&scene, &packet);
                let (others, other) = learned(&scene, &scalar);
                assert!(tables == others, "{what}: tables differ");
                assert_eq!((&told.environment, told.bytes), (&other.environment, other.bytes), "{what}");
                let films = [render(&scene, &packet).film, render(&scene, &scalar).film];
                assert_eq!(first_difference(&films[0], &films[1]), None, "{what}");
                paid += u32::from(used(&told));
                assert_eq!(told.environment.is_some(), strategy.samples_lights(), "{what}");
            }
        }
        assert!(paid >= 6, "it has paid {paid} times");
    }
}

/// What `octray trace` shows: the same path, ray by ray.
#[test]
fn vertex_lists_agree() {
    for lamps in [false, true] {
        let scene = windows(lamps);
        for strategy in [Strategy::MisPower, Strategy::MisOneSample] {
            let settings = Settings { strategy, ..learning(32, 24, 1, 8192) };
            let setup = resolve(&scene, &settings);
            assert!(used(setup.learning.as_ref().expect("it was to be learned")), "{strategy}");
            let plan = Plan::new(&setup);
            for i in 0..60 {
                let (pixel, sample) = ((i * 29 % 32, i * 31 % 24), i * 7);
                let mut vertices = Vec::new();
                single::path::trace_path(&setup, pixel, sample, &mut |vertex| vertices.push(vertex));
                let packet = packet::trace::trace_path(&setup, &plan, pixel, sample);
                assert_eq!(trace::first_difference(&path_steps(&vertices), &packet), None, "{strategy} {pixel:?}");
            }
        }
    }
}

/// Texels are drawn as often as their densities say, in every patch and in rows of all kinds; what a row gives its patches sums
/// to 1, and none that shines gets nothing.
#[test]
fn texels_are_drawn_as_their_densities_say() {
    let scene = windows(false);
    let (Some(learned), _) = learned(&scene, &learning(32, 24, 1, 16_384)) else { panic!("learning pays") };
    let patches = learned.patches.as_ref().expect("that of patches, too");
    let setup = resolve(&scene, &learning(32, 24, 1, 16_384));
    let Some(EnvironmentLight::Map(map, distribution)) = setup.lights.environment else { panic!("a map") };
    let rows: Vec<u32> = learned.rows.iter().copied().filter(|row| row % 40 == 1).chain([0]).collect();
    assert!(rows.len() > 3, "{} rows", rows.len());
    let mut widest: f64 = 1.0;
    for row in rows {
        let ratio = |patch: usize| f64::from(patches.ratio(row, patch));
        let sum: f64 = (0..PATCHES).map(|patch| ratio(patch) * patches.patches.probability[patch]).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        let shines = |patch: &usize| patches.patches.probability[*patch] > 0.0;
        assert!((0..PATCHES).filter(shines).all(|patch| ratio(patch) > 1e-3), "row {row}");
        widest = (0..PATCHES).map(ratio).fold(widest, f64::max);
        let draws = 400_000;
        let mut counts = vec![0.0; map.texels.len()];
        for i in 0..draws {
            let [word, fork, ..] = random_words(i, row, 1, 3);
            let (texel, drawn) = patches.choose(row, [word, fork]);
            assert_eq!(drawn.to_bits(), patches.ratio_of_texel(row, texel).to_bits());
            counts[texel as usize] += 1.0;
        }
        let expected = |texel: usize| {
            let pdf_dir = map_pdf_dir(distribution, &map.texels[texel]) * patches.ratio_of_texel(row, texel as u32);
            f64::from(draws) * f64::from(pdf_dir) * map.solid_angle(texel)
        };
        let expected: Vec<f64> = (0..counts.len()).map(expected).collect();
        let z = chi_square_z(&counts, &expected);
        // One in 10,000 for each of the rows.
        assert!(z < 3.7, "row {row}: {z:.1}");
    }
    assert!(widest > 3.0, "some place prefers a patch: {widest}");
}

#[test]
fn crops_threads_and_breaks_leave_no_trace() {
    let scene = windows(true);
    check_no_trace(&scene, &learning(30, 22, 8, 4096));
}

/// A frame learns of patches from those before it, and has the same bits rendered alone.
#[test]
fn frames_learn_of_patches() {
    let scene = windows(false);
    let settings = Settings { guide: Guide::Off, ..learning(24, 18, 1, 32_768) };
    let sequence = || Sequence::new(&scene, CameraPath::default(), 24.0, 8);
    let ignore = |_: octray::Progress| true;
    let mut one_by_one = sequence();
    for frame in 0..3 {
        let after = one_by_one.render(frame, &settings, None, &ignore);
        let scalar = Settings { engine: Engine::Scalar, ..settings.clone() };
        let alone = sequence().render(frame, &scalar, None, &ignore);
        assert_eq!(first_difference(&after.film, &alone.film), None, "frame {frame}");
        let told = after.stats.learning.expect("it was to be learned");
        assert!(used(&told), "frame {frame}: {told:?}");
    }
}

/// Where no place sees another part of the sky than others, or nothing is to be learned, the map's own distribution stays.
#[test]
fn without_a_gain_the_map_chooses() {
    let (open, inside) = (prepared("scenes/sky.toml"), windows(false));
    let base = learning(32, 24, 2, 16_384);
    for (scene, settings, why) in [
        (&open, base.clone(), Some("more than 0.85")),
        (&inside, Settings { train: Train::Paths(1), max_depth: Some(1), ..base.clone() }, None),
        (&inside, Settings { train: Train::Off, ..base.clone() }, None),
        (&inside, Settings { strategy: Strategy::Bsdf, ..base.clone() }, None),
    ] {
        assert!(matches!(scene.environment, Some(Environment::Map(_))));
        let with = render(scene, &settings);
        let told = with.stats.learning.expect("it was to be learned");
        assert!(!used(&told), "{told:?}");
        if let Some(why) = why {
            assert!(told.environment.is_some_and(|environment| environment.why.contains(why)));
        }
        let without = render(scene, &Settings { lights: Lights::Tree, ..settings });
        assert_eq!(first_difference(&with.film, &without.film), None, "{}", scene.name);
    }
}
