//! Next event estimation by learned visibility (`--lights nee-plus-plus`): the same tables, rays and pictures in both engines,
//! whatever the threads, passes and crops.

use crate::common::{check_no_trace, first_difference, prepared, rooms, small};
use octray::internal::learn::outcome::Learning;
use octray::internal::learn::visibility::LEAST_SURVIVAL;
use octray::internal::packet::plan::Plan;
use octray::internal::reference::{path_steps, single};
use octray::internal::render::pilot::resolve;
use octray::internal::setup::Setup;
use octray::internal::tables::lights::learned::{ALIKE, LearnedLights};
use octray::internal::tables::lights::visibility::{NO_EMITTER, STEPS, Visibility};
use octray::internal::{packet, trace};
use octray::render;
use octray::scene::camera::CameraPath;
use octray::{Crop, Engine, Guide, Lights, PreparedScene, Sampler, Sequence, Settings, Strategy, Train};

/// Settings of a small picture that learns from so many paths.
fn learning(width: u32, height: u32, spp: u32, paths: u32) -> Settings {
    Settings { lights: Lights::NeePlusPlus, train: Train::Paths(paths), ..small(width, height, spp) }
}

/// What a render with these settings learns.
fn learned(scene: &PreparedScene, settings: &Settings) -> (Option<LearnedLights>, Option<Visibility>, Learning) {
    let Setup { lights, learning, .. } = resolve(scene, settings);
    (lights.learned, lights.visibility, learning.expect("something was to be learned"))
}

/// Scenes with walls between their lights, one of them with a single lamp.
fn scenes() -> Vec<PreparedScene> {
    let mut scenes = vec![rooms(false), rooms(true)];
    scenes.extend(["builtin:lamp_hall:300", "scenes/glossy_plates.toml", "scenes/door_ajar.toml"].map(prepared));
    scenes
}

#[test]
fn engines_learn_and_render_alike() {
    for scene in scenes() {
        for &strategy in Strategy::ALL {
            let sampler = if strategy == Strategy::Nee { Sampler::Independent } else { Sampler::Sobol };
            let packet = Settings { strategy, sampler, ..learning(24, 17, 2, 8192) };
            let scalar = Settings { engine: Engine::Scalar, threads: 3, ..packet.clone() };
            let what = format!("{}, {strategy}", scene.name);
            let (factors, visibility, told) = learned(&scene, &packet);
            let (others_factors, others_visibility, other) = learned(&scene, &scalar);
            assert!(factors == others_factors && visibility == others_visibility, "{what}: tables differ");
            assert_eq!((told.used, &told.why, told.bytes), (other.used, &other.why, other.bytes), "{what}");
            assert_eq!(told.used, strategy.samples_lights(), "{what}: {}", told.why);
            let renders = [render(&scene, &packet), render(&scene, &scalar)];
            assert_eq!(first_difference(&renders[0].film, &renders[1].film), None, "{what}");
            assert_eq!(renders[0].stats.rays, renders[1].stats.rays, "{what}");
        }
    }
}

/// Threads, engine, samples, crop and limits leave no trace in the tables; seed, film, strategy and length of the training do.
#[test]
fn tables_are_a_function_of_the_recipe() {
    let scene = rooms(true);
    let base = learning(40, 30, 4, 4096);
    let tables = |settings: &Settings| {
        let (factors, visibility, _) = learned(&scene, settings);
        (factors.expect("there is a tree"), visibility.expect("shadow rays are traced"))
    };
    let one = tables(&base);
    let crop = Some(Crop { x: 7, y: 3, width: 5, height: 9 });
    for same in [
        Settings { threads: 2, ..base.clone() },
        Settings { threads: 3, ..base.clone() },
        Settings { spp: 1000, target_error: Some(0.1), crop, ..base.clone() },
        Settings { engine: Engine::Scalar, ..base.clone() },
    ] {
        assert!(one == tables(&same), "{same:?}");
    }
    for other in [
        Settings { seed: 1, ..base.clone() },
        Settings { width: Some(20), ..base.clone() },
        Settings { strategy: Strategy::NeeNoEmission, max_depth: Some(2), ..base.clone() },
        Settings { sampler: Sampler::Independent, ..base.clone() },
        Settings { train: Train::Paths(2048), ..base.clone() },
    ] {
        assert!(one != tables(&other), "{other:?}");
    }
}

#[test]
fn crops_threads_and_breaks_leave_no_trace() {
    for (scene, guide) in [(rooms(false), Guide::Off), (prepared("scenes/door_ajar.toml"), Guide::On)] {
        check_no_trace(&scene, &Settings { guide, ..learning(30, 22, 8, 4096) });
    }
}

/// What `octray trace` shows: the same path, ray by ray; roulette ends some of its shadow rays.
#[test]
fn vertex_lists_agree() {
    for scene in scenes() {
        let mut ended = 0;
        for strategy in [Strategy::MisPower, Strategy::MisOneSample] {
            let settings = Settings { strategy, ..learning(32, 24, 1, 16_384) };
            let setup = resolve(&scene, &settings);
            let plan = Plan::new(&setup);
            for i in 0..120 {
                let (pixel, sample) = ((i * 29 % 32, i * 31 % 24), i * 7);
                let mut vertices = Vec::new();
                single::path::trace_path(&setup, pixel, sample, &mut |vertex| vertices.push(vertex));
                ended += vertices.iter().filter(|vertex| vertex.note.contains("roulette has ended")).count();
                let packet = packet::trace::trace_path(&setup, &plan, pixel, sample);
                assert_eq!(trace::first_difference(&path_steps(&vertices), &packet), None, "{} {pixel:?}", scene.name);
            }
        }
        assert!(ended > 0, "{}: roulette ended no shadow ray", scene.name);
    }
}

/// Factors and probabilities keep their floors, and of cells that hold no emitter nothing is known.
#[test]
fn every_light_and_every_shadow_ray_keeps_a_chance() {
    let (factors, visibility, told) = learned(&rooms(false), &learning(32, 24, 1, 16_384));
    let (factors, visibility) = (factors.expect("there is a tree"), visibility.expect("shadow rays are traced"));
    assert!(told.why.contains("% of them blocked") && told.forecast.is_none(), "{}", told.why);
    for &word in &factors.words {
        let bytes = word.to_le_bytes();
        assert!(word == ALIKE || bytes.contains(&255) && bytes.iter().all(|&byte| byte >= 8), "{word:x}");
    }
    let least = (f64::from(STEPS) * LEAST_SURVIVAL) as u32;
    let (mut ended, mut cells) = (0, 0);
    for cell in 0..visibility.grid.cells() {
        // All that is looked up of a cell is one row.
        let faces = &factors.rows[6 * cell as usize..6 * (cell as usize + 1)];
        assert!(faces.iter().all(|row| *row == faces[0]));
        cells += u32::from(faces[0] > 0);
        for light in 0..visibility.grid.cells() {
            let steps = visibility.steps(visibility.pair(cell, light));
            let known = visibility.numbers[light as usize] != NO_EMITTER;
            assert!((least..=256).contains(&steps) && (known || steps == 256));
            if known && visibility.numbers[cell as usize] != NO_EMITTER {
                assert_eq!(steps, visibility.steps(visibility.pair(light, cell)), "the same both ways round");
            }
            ended += u32::from(steps == least);
        }
    }
    assert!(ended > 10 && cells > 20, "{ended} pairs at the least probability, {cells} cells with factors");
}

#[test]
fn fewer_shadow_rays_are_traced() {
    for (scene, most) in
        [(rooms(false), 0.8), (prepared("builtin:rooms"), 0.8), (prepared("scenes/door_ajar.toml"), 0.4)]
    {
        let settings = learning(48, 36, 4, 65_536);
        let rays = |lights| render(&scene, &Settings { lights, ..settings.clone() }).stats.rays;
        let (tree, map) = (rays(Lights::Tree), rays(Lights::NeePlusPlus));
        // Nothing else of a path depends on its light samples.
        assert_eq!((tree.camera, tree.bounce), (map.camera, map.bounce), "{}", scene.name);
        let part = map.shadow as f64 / tree.shadow as f64;
        assert!(part < most, "{}: {part:.2} of the shadow rays", scene.name);
    }
}

/// Where nothing can be learned, the picture is the tree's.
#[test]
fn without_a_map_the_tree_chooses() {
    let sky = prepared("scenes/sky.toml");
    let hidden = rooms(false);
    let base = learning(40, 30, 2, 16_384);
    for (scene, settings, why) in [
        (&sky, base.clone(), "no light but the environment"),
        (&hidden, Settings { train: Train::Off, ..base.clone() }, "switched off"),
        (&hidden, Settings { strategy: Strategy::Bsdf, ..base.clone() }, "no light is sampled"),
        (&hidden, Settings { max_depth: Some(0), ..base.clone() }, "no light is sampled"),
    ] {
        let map = render(scene, &settings);
        let told = map.stats.learning.expect("it was to be learned");
        assert!(!told.used && told.why.contains(why), "{}: {}", scene.name, told.why);
        let tree = render(scene, &Settings { lights: Lights::Tree, ..settings });
        assert_eq!(first_difference(&map.film, &tree.film), None, "{}: {why}", scene.name);
    }
}

/// Films of any shape are covered; a training of one path, or on a film of one pixel, is none that fails.
#[test]
fn films_of_any_shape_can_be_learned() {
    let scene = rooms(true);
    for (width, height) in [(1, 1), (1, 300), (300, 1), (7, 5)] {
        for train in [Train::Auto, Train::Paths(1), Train::Paths(3000)] {
            let packet = Settings { lights: Lights::NeePlusPlus, train, ..small(width, height, 1) };
            let scalar = Settings { engine: Engine::Scalar, ..packet.clone() };
            let films = [render(&scene, &packet).film, render(&scene, &scalar).film];
            assert_eq!(first_difference(&films[0], &films[1]), None, "{width} x {height}, {train}");
        }
    }
}

/// Every frame of a sequence makes a map of its own.
#[test]
fn frames_train_afresh() {
    let scene = rooms(false);
    let settings = learning(20, 16, 2, 4096);
    let frames = |train_frames| {
        let mut sequence = Sequence::new(&scene, CameraPath::default(), 24.0, train_frames);
        [0, 1].map(|frame| sequence.render(frame, &settings, None, &|_| true))
    };
    for (shared, alone) in frames(32).iter().zip(&frames(1)) {
        assert_eq!(first_difference(&shared.film, &alone.film), None);
        assert_eq!(shared.stats.learning.as_ref().map(|learning| (learning.used, learning.frames)), Some((true, 1)));
    }
}
