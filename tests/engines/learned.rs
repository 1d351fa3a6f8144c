//! What is learned of lights: the same tables and the same pictures in both engines, whatever the threads, passes and crops.

use crate::common::{check_no_trace, first_difference, prepared, rooms, small};
use octray::internal::lanes::LANES;
use octray::internal::learn::outcome::Learning;
use octray::internal::packet::plan::Plan;
use octray::internal::reference::single::lights::factors;
use octray::internal::reference::single::lights::tree::{Receiver, choose_light, light_probability};
use octray::internal::reference::{path_steps, single};
use octray::internal::render::pilot::resolve;
use octray::internal::sampler::{random_words, unit};
use octray::internal::simd::native::kernels::lights::factors as factors_x8;
use octray::internal::simd::native::kernels::lights::tree as lanes;
use octray::internal::tables::lights::learned::{ALIKE, LearnedLights};
use octray::internal::tables::lights::table::Selection;
use octray::internal::{packet, trace};
use octray::render;
use octray::{Crop, Engine, F32x8, Lights, Mask8, PreparedScene, Sampler, Settings, Strategy, Train, U32x8, Vec3x8};
use single::Vec3;

/// Settings of a small picture that learns from so many paths.
fn learning(width: u32, height: u32, spp: u32, paths: u32) -> Settings {
    Settings { lights: Lights::Learned, train: Train::Paths(paths), ..small(width, height, spp) }
}

/// What a render with these settings learns.
fn learned(scene: &PreparedScene, settings: &Settings) -> (Option<LearnedLights>, Learning) {
    let setup = resolve(scene, settings);
    (setup.lights.learned, setup.learning.expect("something was to be learned"))
}

/// Scenes on which learning pays.
fn scenes() -> Vec<PreparedScene> {
    let mut scenes = vec![rooms(false), rooms(true)];
    scenes.extend(["builtin:lamp_hall:300", "scenes/glossy_plates.toml"].map(prepared));
    scenes
}

/// Both learn the same, and render the same by it.
#[test]
fn engines_learn_and_render_alike() {
    for scene in scenes() {
        let mut used = 0;
        for &strategy in Strategy::ALL {
            let sampler = if strategy == Strategy::Nee { Sampler::Independent } else { Sampler::Sobol };
            let packet = Settings { strategy, sampler, ..learning(24, 17, 2, 2048) };
            let scalar = Settings { engine: Engine::Scalar, threads: 3, ..packet.clone() };
            let what = format!("{}, {strategy}", scene.name);
            let (tables, told) = learned(&scene, &packet);
            let (others, other) = learned(&scene, &scalar);
            assert!(tables == others, "{what}: tables differ");
            assert_eq!((told.forecast, told.used, &told.why), (other.forecast, other.used, &other.why), "{what}");
            let films = [render(&scene, &packet).film, render(&scene, &scalar).film];
            assert_eq!(first_difference(&films[0], &films[1]), None, "{what}");
            used += told.used as u32;
            assert_eq!(told.grid.is_some(), strategy.samples_lights(), "{what}: {}", told.why);
        }
        assert!(used >= 2, "{}: learned by {used} strategies", scene.name);
    }
}

/// Threads, engine, samples, crop and limits leave no trace in the tables; seed, film, strategy and length of the training do.
#[test]
fn tables_are_a_function_of_the_recipe() {
    let scene = rooms(true);
    let base = learning(40, 30, 4, 4096);
    let tables = |settings: &Settings| learned(&scene, settings).0.expect("it pays");
    let one = tables(&base);
    let crop = Some(Crop { x: 7, y: 3, width: 5, height: 9 });
    for same in [
        Settings { threads: 2, ..base.clone() },
        Settings { threads: 3, ..base.clone() },
        Settings { spp: 1000, target_error: Some(0.1), ..base.clone() },
        Settings { time: Some(std::time::Duration::from_secs(1)), crop, ..base.clone() },
    ] {
        assert!(one == tables(&same), "{same:?}");
    }
    for other in [
        Settings { seed: 1, ..base.clone() },
        Settings { width: Some(20), ..base.clone() },
        Settings { strategy: Strategy::MisBalance, ..base.clone() },
        Settings { sampler: Sampler::Independent, ..base.clone() },
        Settings { max_depth: Some(1), ..base.clone() },
        Settings { train: Train::Paths(2048), ..base.clone() },
    ] {
        assert!(one != tables(&other), "{other:?}");
    }
}

#[test]
fn crops_threads_and_breaks_leave_no_trace() {
    let scene = rooms(false);
    check_no_trace(&scene, &learning(30, 22, 8, 2048));
}

/// What `octray trace` shows: the same path, ray by ray.
#[test]
fn vertex_lists_agree() {
    for scene in scenes() {
        for strategy in [Strategy::MisPower, Strategy::MisOneSample] {
            let settings = Settings { strategy, ..learning(32, 24, 1, 2048) };
            let setup = resolve(&scene, &settings);
            let plan = Plan::new(&setup);
            for i in 0..60 {
                let (pixel, sample) = ((i * 29 % 32, i * 31 % 24), i * 7);
                let mut vertices = Vec::new();
                single::path::trace_path(&setup, pixel, sample, &mut |vertex| vertices.push(vertex));
                let packet = packet::trace::trace_path(&setup, &plan, pixel, sample);
                assert_eq!(trace::first_difference(&path_steps(&vertices), &packet), None, "{} {pixel:?}", scene.name);
            }
        }
    }
}

fn direction(number: u32) -> Vec3 {
    let [x, y, z, _] = random_words(number, 1, 0, 5).map(|word| 2.0 * unit(word) - 1.0);
    Vec3::new(x, y, z).normalize_or(Vec3::Y)
}

/// A place in and about the rooms, and what is looked up there. Some lie on the borders of cells, some normals on those of
/// faces.
fn receiver(learned: &LearnedLights, number: u32) -> (Receiver, Option<Vec3>) {
    let [x, y, z, _] = random_words(number, 2, 0, 5).map(unit);
    let (mut origin, mut normal) = (Vec3::new(13.0 * x - 0.5, 4.0 * y - 0.5, 5.0 * z - 0.5), direction(number));
    if number.is_multiple_of(3) {
        origin = (origin * learned.grid.scale).floor() / learned.grid.scale;
    }
    if number.is_multiple_of(5) {
        normal = Vec3::new(normal.x, normal.x.abs(), -normal.x).normalize_or(Vec3::X);
    }
    let incoming = (number % 2 == 1).then(|| direction(number + 1_000_000));
    let key = factors::key(&learned.grid, origin, normal, incoming);
    (Receiver { origin, normal, row: learned.rows[key as usize] }, incoming)
}

/// Keys, and what is chosen and looked up with them, alone and in lanes.
#[test]
fn lookups_agree_bit_for_bit() {
    let scene = rooms(false);
    let setup = resolve(&scene, &learning(32, 24, 1, 8192));
    let (Selection::Tree(tree), Some(learned)) = (&setup.lights.selection, &setup.lights.learned) else {
        panic!("learning pays")
    };
    let mut known = 0;
    for block in 0..1500 {
        let places: [_; LANES] = std::array::from_fn(|i| receiver(learned, block * 8 + i as u32));
        let column = |get: &dyn Fn(usize) -> f32| F32x8::from_array(std::array::from_fn(get));
        let vector = |get: &dyn Fn(usize) -> Vec3| {
            Vec3x8::new(column(&|i| get(i).x), column(&|i| get(i).y), column(&|i| get(i).z))
        };
        let (origin, normal) = (vector(&|i| places[i].0.origin), vector(&|i| places[i].0.normal));
        let diffuse = factors_x8::keys(&learned.grid, origin, normal, None).to_array();
        let incoming = vector(&|i| places[i].1.unwrap_or(Vec3::X));
        let glossy = factors_x8::keys(&learned.grid, origin, normal, Some(incoming)).to_array();
        let row = U32x8::from_array(places.map(|(receiver, _)| receiver.row));
        let receivers = lanes::Receivers { origin, normal, row };
        let words: [u32; LANES] = std::array::from_fn(|i| random_words(block, i as u32, 0, 7)[0]);
        let active = Mask8::from_bits([0xff, 0x5a, 0x01][(block % 3) as usize]);
        let words_x8 = U32x8::from_array(words);
        let (light, probability) = lanes::choose_lights(tree, Some(learned), &receivers, active, words_x8);
        let found = lanes::light_probabilities(tree, Some(learned), &receivers, active, light).to_array();
        let (light, probability) = (light.to_array(), probability.to_array());
        for i in (0..LANES).filter(|&i| active.bits() >> i & 1 == 1) {
            let (receiver, incoming) = &places[i];
            let key = factors::key(&learned.grid, receiver.origin, receiver.normal, *incoming);
            assert_eq!(if incoming.is_some() { glossy[i] } else { diffuse[i] }, key);
            assert!(key < learned.grid.keys());
            known += (receiver.row > 0) as u32;
            let (chosen, p) = choose_light(tree, Some(learned), receiver, words[i]);
            assert_eq!((light[i], probability[i].to_bits()), (chosen, p.to_bits()));
            assert_eq!(found[i].to_bits(), p.to_bits(), "looked up in lanes");
            assert_eq!(light_probability(tree, Some(learned), receiver, chosen).to_bits(), p.to_bits());
        }
    }
    assert!(known > 500, "{known} places of which something is known");
}

/// Whatever the tree would choose keeps at least 1/32 of its share at every level that has factors, and probabilities still
/// add up to 1.
#[test]
fn every_light_keeps_a_share() {
    let scene = rooms(false);
    let setup = resolve(&scene, &learning(32, 24, 1, 8192));
    let (Selection::Tree(tree), Some(learned)) = (&setup.lights.selection, &setup.lights.learned) else {
        panic!("learning pays")
    };
    for &word in &learned.words {
        assert!(word == ALIKE || word.to_le_bytes().iter().all(|&byte| byte >= 8), "{word:x}");
        assert!(word == ALIKE || word.to_le_bytes().contains(&255), "{word:x}");
    }
    assert!(learned.words[..learned.slot_count as usize].iter().all(|&word| word == ALIKE), "row 0 knows nothing");
    let count = setup.lights.records.len() as u32;
    let mut least = 1.0f64;
    for number in 0..2000 {
        let (receiver, _) = receiver(learned, number);
        let with = |light| f64::from(light_probability(tree, Some(learned), &receiver, light));
        let without = |light| f64::from(light_probability(tree, None, &receiver, light));
        let sum: f64 = (0..count).map(with).sum();
        assert!(sum == 0.0 || (sum - 1.0).abs() < 1e-5, "{sum}");
        for light in (0..count).filter(|&light| without(light) > 0.0) {
            least = least.min(with(light) / without(light));
        }
    }
    assert!(least > 1.0 / 1100.0, "a light has {least} of what the tree gave it");
    assert!(least < 0.5, "factors matter");
}

/// Where nothing pays, or nothing is to be learned, the picture is the tree's.
#[test]
fn without_a_gain_the_tree_chooses() {
    let cornell = prepared("scenes/cornell.toml");
    let lecture = prepared("scenes/lecture_lights.toml");
    let hidden = rooms(false);
    let base = learning(40, 30, 2, 16_384);
    for (scene, settings, why) in [
        (&cornell, base.clone(), "nothing to choose from"),
        (&lecture, base.clone(), "more than 0.85"),
        (&hidden, Settings { train: Train::Off, ..base.clone() }, "switched off"),
        (&hidden, Settings { train: Train::Paths(1), ..base.clone() }, "too little light"),
        (&hidden, Settings { strategy: Strategy::Bsdf, ..base.clone() }, "no light is sampled"),
        (&hidden, Settings { max_depth: Some(0), ..base.clone() }, "no light is sampled"),
    ] {
        let render_learned = render(scene, &settings);
        let told = render_learned.stats.learning.expect("it was to be learned");
        assert!(!told.used && told.why.contains(why), "{}: {}", scene.name, told.why);
        let tree = render(scene, &Settings { lights: Lights::Tree, ..settings });
        assert_eq!(first_difference(&render_learned.film, &tree.film), None, "{}: {why}", scene.name);
        assert_eq!(tree.stats.learning, None);
    }
    let told = learned(&hidden, &base).1;
    assert!(told.used && told.forecast < Some(0.7) && told.paths > 15_000 && told.bytes > 1000, "{told:?}");
}

/// Films of any shape are covered; a training of one path, or on a film of one pixel, is none that fails.
#[test]
fn films_of_any_shape_can_be_learned() {
    let scene = rooms(true);
    for (width, height) in [(1, 1), (1, 300), (300, 1), (7, 5)] {
        for train in [Train::Auto, Train::Paths(1), Train::Paths(3000)] {
            let packet = Settings { lights: Lights::Learned, train, ..small(width, height, 1) };
            let scalar = Settings { engine: Engine::Scalar, ..packet.clone() };
            let films = [render(&scene, &packet).film, render(&scene, &scalar).film];
            assert_eq!(first_difference(&films[0], &films[1]), None, "{width} x {height}, {train}");
        }
    }
}
