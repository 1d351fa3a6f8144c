//! The light tree: what it chooses, how often, and what MIS is told of it.

use crate::common;
use crate::common::Maker;
use glam::{DVec3, Vec3};
use octray::internal::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use octray::internal::reference::single::lights::tree::{
    Receiver, choose_light, environment_eighths, light_probability,
};
use octray::internal::sampler::{random_words, unit};
use octray::internal::simd::native::kernels::lights::tree as lanes;
use octray::internal::tables::lights::table::{Fixed, LightTable, Selection};
use octray::internal::tables::lights::tree::LightTree;
use octray::scene::desc::{DeltaLight, DeltaLightDesc, EnvironmentDesc, LightDesc};
use octray::{Lights, PreparedScene, Settings, Strategy, render};

/// Numbers in [0, 1), by address.
fn numbers(address: u32) -> [f32; 4] {
    random_words(address, 0, 0, 4711).map(unit)
}

fn direction([u, v, ..]: [f32; 4]) -> Vec3 {
    let z = 2.0 * u - 1.0;
    let (sine, cosine) = octray::internal::math::sin_cos_turns(v);
    let radius = (1.0 - z * z).sqrt();
    Vec3::new(radius * cosine, radius * sine, z).normalize()
}

/// `count` triangles of very different places, sizes and strengths that emit, some on both sides, in and about the unit
/// cube; with `environment` a sky beside them.
fn scattered(count: u32, environment: bool) -> PreparedScene {
    let mut maker = Maker::default();
    for i in 0..count {
        let [x, y, z, size] = numbers(i * 4);
        let strength = [0.01, 1.0, 100.0][(i % 3) as usize];
        let material = maker.diffuse([0.5; 3], [strength, 0.5 * strength, 0.1]);
        maker.desc.materials[material as usize].two_sided = i % 5 == 0;
        let size = if i % 17 == 0 { 3.0 } else { 0.001 + 0.2 * size * size };
        let (a, b) = (direction(numbers(i * 4 + 1)) * size, direction(numbers(i * 4 + 2)) * size);
        let p = Vec3::new(x, y, z);
        // Every other one a parallelogram.
        let corners = [p, p + a, p + a + b, p + b].map(|v| v.to_array());
        maker.quad(corners, material);
        if i % 2 == 0 {
            maker.mesh.triangles.pop();
        }
    }
    if environment {
        maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.3, 0.2, 0.9] }));
    }
    maker.seen([0.5, 0.5, 3.0], [0.5; 3], 40.0)
}

/// `count` delta lights of all kinds and of very different strengths in and about the unit cube, beside `lamps` triangles that
/// emit.
fn deltas(count: u32, lamps: u32) -> PreparedScene {
    let mut maker = Maker::default();
    let grey = maker.diffuse([0.5; 3], [0.0; 3]);
    let lamp = maker.diffuse([0.0; 3], [3.0, 1.0, 0.5]);
    maker.cuboid([0.0; 3], [1.0; 3], true, grey);
    for i in 0..lamps {
        let [x, y, z, _] = numbers(7_000 + i);
        maker.quad([[x, y, z], [x + 0.1, y, z], [x + 0.1, y, z + 0.1], [x, y, z + 0.1]], lamp);
    }
    for i in 0..count {
        let [x, y, z, _] = numbers(8_000 + 3 * i).map(f64::from);
        let [a, b, ..] = numbers(8_001 + 3 * i).map(f64::from);
        let direction = direction(numbers(8_002 + 3 * i)).as_dvec3().to_array();
        let strength = [[0.01, 1.0, 50.0][(i % 3) as usize], 0.5, 0.0];
        let position = if i % 7 == 6 { [0.0; 3] } else { [2.0 * x - 0.5, 2.0 * y - 0.5, 2.0 * z - 0.5] };
        let cone_angle = 0.1 + 179.0 * a * a;
        let light = match i % 4 {
            0 => DeltaLight::Point { position, intensity: strength },
            1 => DeltaLight::Directional { direction, irradiance: strength },
            _ => DeltaLight::Spot {
                position,
                direction,
                intensity: strength,
                cone_angle,
                cone_delta_angle: b * cone_angle,
            },
        };
        maker.desc.lights.push(LightDesc::Delta(DeltaLightDesc { name: format!("{i}"), light }));
    }
    maker.seen([0.5, 0.5, 3.0], [0.5; 3], 40.0)
}

/// Every kind of scene a tree is built for, by name.
fn scenes() -> Vec<(&'static str, PreparedScene)> {
    let mut list = vec![
        ("two", scattered(2, false)),
        ("nine", scattered(9, false)),
        ("four hundred", scattered(400, false)),
        ("one beside a sky", scattered(1, true)),
        ("three hundred under a sky", scattered(300, true)),
        ("forty delta lights", deltas(40, 0)),
        ("three hundred delta lights among lamps", deltas(300, 60)),
    ];
    for path in ["scenes/lecture_lights.toml", "scenes/glossy_plates.toml", "builtin:heavy:20000"] {
        list.push((path, common::prepared(path)));
    }
    list
}

/// A place near the scene's lights: in the room, close to a light, or on one.
fn receiver(scene: &PreparedScene, number: u32) -> Receiver {
    let address = 1_000_000 + number * 4;
    let [pick, u, v, height] = numbers(address);
    let triangle = match scene.emitters.len() {
        0 => (pick * scene.triangles.len() as f32) as u32,
        count => scene.emitters[(pick * count as f32) as usize].triangle,
    };
    let triangle = &scene.triangles[triangle as usize];
    let [a, b, c] = triangle.vertices.map(Vec3::from);
    let root = u.sqrt();
    let on_light = a + (b - a) * (1.0 - root) + (c - a) * (root * v);
    let away = [0.0, 1e-6, 1e-2, 1.0, 10.0][(number % 5) as usize] * height;
    Receiver {
        origin: on_light + direction(numbers(address + 1)) * away,
        normal: direction(numbers(address + 2)),
        row: 0,
    }
}

/// The tree of `scene`.
fn with_tree<R>(scene: &PreparedScene, then: impl FnOnce(&LightTree, &LightTable) -> R) -> R {
    let table = LightTable::new(scene, Lights::Tree, false);
    let Selection::Tree(tree) = table.selection else { panic!("{} has a tree", scene.name) };
    then(tree, &table)
}

fn eight(receivers: &[Receiver; LANES]) -> lanes::Receivers {
    let column = |get: &dyn Fn(&Receiver) -> f32| F32x8::from_array(std::array::from_fn(|i| get(&receivers[i])));
    let vector = |get: &dyn Fn(&Receiver) -> Vec3| {
        Vec3x8::new(column(&|r| get(r).x), column(&|r| get(r).y), column(&|r| get(r).z))
    };
    lanes::Receivers { origin: vector(&|r| r.origin), normal: vector(&|r| r.normal), row: U32x8::ZERO }
}

/// Sampling and looking up name the same probability, bit for bit, alone and in lanes.
#[test]
fn what_is_sampled_is_what_mis_looks_up() {
    for (name, scene) in scenes() {
        with_tree(&scene, |tree, _| {
            for block in 0..200 {
                let receivers: [Receiver; LANES] = std::array::from_fn(|i| receiver(&scene, block * 8 + i as u32));
                let words: [u32; LANES] = std::array::from_fn(|i| random_words(block, i as u32, 0, 7)[0]);
                // Alone, in company, and in the company of idle lanes.
                let active = Mask8::from_bits([0xff, 0x5a, 0x01][(block % 3) as usize]);
                let (light, probability) =
                    lanes::choose_lights(tree, None, &eight(&receivers), active, U32x8::from_array(words));
                let found = lanes::light_probabilities(tree, None, &eight(&receivers), active, light).to_array();
                let (light, probability) = (light.to_array(), probability.to_array());
                let eighths = lanes::environment_eighths(tree, &eight(&receivers)).to_array();
                for i in (0..LANES).filter(|&i| active.bits() >> i & 1 == 1) {
                    assert_eq!(eighths[i], environment_eighths(tree, &receivers[i]), "{name}");
                    let (chosen, p) = choose_light(tree, None, &receivers[i], words[i]);
                    assert_eq!((light[i], probability[i].to_bits()), (chosen, p.to_bits()), "{name}");
                    assert_eq!(found[i].to_bits(), p.to_bits(), "{name}: looked up in lanes");
                    let looked_up = light_probability(tree, None, &receivers[i], chosen);
                    assert_eq!(looked_up.to_bits(), p.to_bits(), "{name}: looked up alone");
                    assert!(p > 0.0 && p <= 1.0, "{name}: {p}");
                }
            }
        });
    }
}

/// At the world's origin, where the columns lie that a node does not use, there was no end to the choice.
#[test]
fn places_with_zeros_for_coordinates_are_places() {
    for (name, scene) in scenes() {
        with_tree(&scene, |tree, _| {
            for (number, zeros) in (0..64).flat_map(|number| (0..8).map(move |zeros| (number, zeros))) {
                let at = |i: usize| if zeros >> i & 1 == 1 { 0.0 } else { [0.5, -1.0, 2.0][i] };
                let origin = Vec3::new(at(0), at(1), at(2));
                let of = |i: u32| direction(numbers(5_000_000 + 8 * number + i));
                let receivers: [Receiver; LANES] =
                    std::array::from_fn(|i| Receiver { origin, normal: of(i as u32), row: 0 });
                let words: [u32; LANES] = std::array::from_fn(|i| random_words(number, i as u32, 0, 8)[0]);
                let (light, probability) =
                    lanes::choose_lights(tree, None, &eight(&receivers), Mask8::ALL, U32x8::from_array(words));
                for i in 0..LANES {
                    let (chosen, p) = choose_light(tree, None, &receivers[i], words[i]);
                    assert_eq!(
                        (light.to_array()[i], probability.to_array()[i].to_bits()),
                        (chosen, p.to_bits()),
                        "{name}"
                    );
                    assert!(p > 0.0 && p <= 1.0, "{name}: {p}");
                }
            }
        });
    }
}

/// What there is to choose adds up to 1.
#[test]
fn probabilities_sum_to_one() {
    for (name, scene) in scenes() {
        with_tree(&scene, |tree, table| {
            for number in 0..40 {
                let receiver = receiver(&scene, number);
                let lights = 0..table.count() as u32;
                let sum: f64 = lights.map(|light| f64::from(light_probability(tree, None, &receiver, light))).sum();
                assert!((sum - 1.0).abs() < 1e-5, "{name}: {sum}");
            }
        });
    }
}

/// No light that shines on a place has probability 0 there: rays in f64 from the place to points all over every light.
#[test]
fn no_light_that_contributes_is_left_out() {
    for (name, scene) in scenes() {
        with_tree(&scene, |tree, table| {
            let (mut shining, mut dark) = (0, 0);
            let step = table.records.len().div_ceil(150).max(1);
            for number in 0..60 {
                let receiver = receiver(&scene, number);
                let (origin, normal) = (receiver.origin.as_dvec3(), receiver.normal.as_dvec3());
                for (index, light) in table.records.iter().enumerate().step_by(step) {
                    let [a, b, c] = light.vertices.map(|v| DVec3::from(v.map(f64::from)));
                    let shines = (0..45).any(|i| {
                        let (u, v) = ((i % 9) as f64 / 8.0, (i / 9) as f64 / 4.0);
                        let to_light = a + (b - a) * (u * (1.0 - v)) + (c - a) * v - origin;
                        let facing = -DVec3::from(light.normal.map(f64::from)).dot(to_light);
                        let facing = if light.two_sided() { facing.abs() } else { facing };
                        // What is nearer to the horizon than f32 can tell need not count.
                        let tiny = 1e-5 * to_light.length() + 1e-6 * origin.abs().max_element();
                        normal.dot(to_light) > tiny && facing > tiny
                    });
                    let probability = light_probability(tree, None, &receiver, index as u32);
                    shining += shines as u32;
                    dark += (probability == 0.0) as u32;
                    assert!(!shines || probability > 0.0, "{name}: light {index} for place {number}");
                }
                for (light, desc) in (table.records.len() as u32..).zip(scene.delta_lights.lights()) {
                    let (to_light, axis, cone) = match *desc {
                        DeltaLight::Point { position, .. } => (DVec3::from(position) - origin, DVec3::Z, 181.0),
                        DeltaLight::Directional { direction, .. } => (-DVec3::from(direction), DVec3::Z, 181.0),
                        DeltaLight::Spot { position, direction, cone_angle, .. } => {
                            (DVec3::from(position) - origin, DVec3::from(direction), cone_angle)
                        }
                    };
                    let tiny = 1e-5 * to_light.length() + 1e-6 * origin.abs().max_element();
                    let inside = axis.angle_between(-to_light).to_degrees() < cone;
                    // Directional lights are seen from the scene, not from beside it.
                    let near = (origin - 0.5).abs().max_element() < 0.6;
                    let near = near || !matches!(desc, DeltaLight::Directional { .. });
                    let shines = normal.dot(to_light) > tiny && inside && near;
                    let probability = light_probability(tree, None, &receiver, light);
                    shining += shines as u32;
                    dark += (probability == 0.0) as u32;
                    assert!(!shines || probability > 0.0, "{name}: {desc:?} for place {number}");
                }
            }
            assert!(shining > 20, "{name}: the test has seen {shining} lights shine");
            assert!(dark > 10 || name.contains("one"), "{name}: only {dark} lights are left out");
        });
    }
}

/// Lights come as often as the probabilities say: chi-square at 0.01 % for the file's 10 x 6 cases together (Sidak).
#[test]
fn frequencies_are_the_probabilities() {
    const DRAWS: u32 = 40_000;
    for (name, scene) in scenes() {
        with_tree(&scene, |tree, table| {
            for number in 0..6 {
                let receiver = receiver(&scene, number);
                let mut counts = vec![0.0; table.count()];
                for draw in 0..DRAWS {
                    let word = random_words(draw, number, 1, 99)[0];
                    counts[choose_light(tree, None, &receiver, word).0 as usize] += 1.0;
                }
                let lights = 0..table.count() as u32;
                let probability = |light| f64::from(light_probability(tree, None, &receiver, light));
                let expected: Vec<f64> = lights.map(|light| f64::from(DRAWS) * probability(light)).collect();
                let certain = expected.iter().filter(|&&expected| expected >= 8.0).count() < 2;
                if certain {
                    continue;
                }
                let z = common::chi_square_z(&counts, &expected);
                assert!(z < 4.7, "{name}, place {number}: z = {z:.1}");
            }
        });
    }
}

/// Lamps around lamps, five shells of them, each smaller by 8 and weaker by 1e4 than the one around it: far off the innermost
/// have the least share at every level of the tree.
fn nested() -> PreparedScene {
    let mut maker = Maker::default();
    for shell in 0..5 {
        let size = 8f32.powi(-shell);
        let radiance = 64f64.powi(shell) * 1e-4f64.powi(shell);
        let material = maker.diffuse([0.5; 3], [radiance; 3]);
        for i in 0..40u32 {
            let p = direction(numbers(9_000 + shell as u32 * 40 + i)) * size;
            let corners = [p, p + Vec3::X * 0.1 * size, p + Vec3::Z * 0.1 * size].map(|v| v.to_array());
            maker.quad([corners[0], corners[1], corners[2], corners[2]], material);
            maker.mesh.triangles.pop();
        }
    }
    maker.seen([0.5, -3.0, 9.0], [0.0; 3], 60.0)
}

/// However small a light's probability is, it is drawn as often as is stated: all words that can choose the light, which lie
/// together, are tried. (A word has 32 bits, of which a light of probability 2^-28 sees no more than 4.)
#[test]
fn the_least_likely_lights_are_drawn_as_often_as_is_stated() {
    let scene = nested();
    with_tree(&scene, |tree, table| {
        let mut order: Vec<u32> = (0..table.records.len() as u32).collect();
        // Lights in the order in which words choose them: that of their paths, the root's three bits first.
        let digits = |light: u32| (0..21).map(move |level| tree.paths[light as usize] >> (3 * level) & 7);
        order.sort_by(|&a, &b| digits(a).cmp(digits(b)));
        let (mut drawn, mut stated, mut lights, mut never) = ([0.0; 2], [0.0; 2], 0, 0);
        for number in 0..10u32 {
            let [x, y, z, _] = numbers(70_000 + number);
            let origin = Vec3::new(4.0 * x - 2.0, -2.0 - 3.0 * y, 4.0 * z - 2.0);
            let receiver = Receiver { origin, normal: Vec3::Y, row: 0 };
            let mut before = 0.0;
            for &light in &order {
                let p = f64::from(light_probability(tree, None, &receiver, light));
                let words = p * 2f64.powi(32);
                if words > 2.0 && p < 2f64.powi(-21) {
                    let start = before * 2f64.powi(32);
                    let (first, last) = (start - words - 1024.0, start + 2.0 * words + 1024.0);
                    let all = (first.max(0.0) as u64)..=(last.min(4_294_967_295.0) as u64);
                    let count = all.filter(|&word| choose_light(tree, None, &receiver, word as u32).0 == light).count();
                    let size = (p < 2f64.powi(-25)) as usize;
                    drawn[size] += count as f64;
                    stated[size] += words;
                    lights += 1;
                    never += (count == 0 && words > 8.0) as u32;
                }
                before += p;
            }
        }
        println!("drawn {drawn:?}, stated {stated:?} words of {lights} lights; {never} never drawn");
        assert!(lights > 100 && never == 0, "{lights} lights, {never} never drawn");
        for (drawn, stated) in drawn.into_iter().zip(stated) {
            // One light shares the luck of its neighbours: their words hang together.
            assert!(
                stated > 100.0 && (drawn / stated - 1.0).abs() < 0.02 + 8.0 / f64::sqrt(stated),
                "{drawn}, {stated}"
            );
        }
    });
}

/// Copies of one light, lights in a row, and more lights than a tree of even splits could separate by place.
#[test]
fn a_tree_can_be_built_over_anything() {
    let build = |count: u32, at: &dyn Fn(u32) -> Vec3| {
        let mut maker = Maker::default();
        let material = maker.diffuse([0.5; 3], [1.0; 3]);
        for i in 0..count {
            let p = at(i);
            let corners = [p, p + Vec3::X, p + Vec3::new(1.0, 0.0, -1.0), p - Vec3::Z].map(|v| v.to_array());
            maker.quad(corners, material);
        }
        maker.seen([0.5, -3.0, 9.0], [0.5, 0.0, 0.0], 60.0)
    };
    for (name, count, at) in [
        ("nearly copies", 3_000, &(|i: u32| Vec3::Y * (i as f32 * 1e-30)) as &dyn Fn(u32) -> Vec3),
        ("a row", 3_000, &|i| Vec3::new(i as f32, 0.0, 0.0)),
        ("ever closer", 3_000, &|i| Vec3::new(0.5f32.powi((i % 100) as i32), 0.0, i as f32 * 1e-30)),
    ] {
        let scene = build(count, at);
        with_tree(&scene, |tree, table| {
            assert_eq!(table.records.len(), 2 * count as usize, "{name}");
            assert!(tree.nodes.len() < count as usize, "{name}: {} nodes", tree.nodes.len());
            let receiver = Receiver { origin: Vec3::new(0.3, 2.0, 0.1), normal: -Vec3::Y, row: 0 };
            let lights = 0..table.records.len() as u32;
            let sum: f64 = lights.map(|light| f64::from(light_probability(tree, None, &receiver, light))).sum();
            assert!((sum - 1.0).abs() < 1e-4, "{name}: {sum}");
        });
    }
}

/// One lamp, be it one triangle or a parallelogram of two, leaves nothing to choose: no tree, and the pictures of `tree` and
/// `uniform` are the same bits.
#[test]
fn one_lamp_needs_no_tree() {
    let scene = common::prepared("scenes/cornell.toml");
    let table = LightTable::new(&scene, Lights::Tree, false);
    assert!(matches!(table.selection, Selection::Fixed(Fixed::Uniform(2))), "two triangles, alike");
    let settings = |lights| Settings { lights, ..common::small(16, 16, 4) };
    let [tree, uniform] = [Lights::Tree, Lights::Uniform].map(|lights| render(&scene, &settings(lights)).film);
    assert_eq!(common::first_difference(&tree, &uniform), None);
}

/// Of 400 lamps in 20 closed rooms only the 20 beside a place matter there: choosing by place has far less error than
/// choosing by power or alike, and all have the same mean.
#[test]
fn a_tree_finds_the_lamps_that_matter() {
    let mut maker = Maker::default();
    let wall = maker.diffuse([0.5; 3], [0.0; 3]);
    let lamp = maker.diffuse([0.0; 3], [9.0, 6.0, 3.0]);
    for room in 0..20 {
        let x = 4.0 * room as f32;
        maker.cuboid([x, 0.0, 0.0], [x + 3.9, 3.0, 4.0], true, wall);
        for i in 0..20 {
            let (cx, cz) = (x + 0.4 + 0.7 * (i % 5) as f32, 0.5 + 0.9 * (i / 5) as f32);
            maker.quad([[cx, 2.9, cz], [cx + 0.1, 2.9, cz], [cx + 0.1, 2.9, cz + 0.1], [cx, 2.9, cz + 0.1]], lamp);
        }
    }
    let scene = maker.seen([42.0, 1.5, 3.8], [42.0, 0.8, 0.0], 60.0);
    let settings =
        |lights| Settings { lights, strategy: Strategy::Nee, max_depth: Some(1), ..common::small(24, 24, 256) };
    let error = |lights| {
        let film = render(&scene, &settings(lights)).film;
        common::estimate(&film, 0..24, 0..24, 1)
    };
    let [tree, power] = [Lights::Tree, Lights::Power].map(error);
    let sigma = tree.error.hypot(power.error);
    assert!((tree.mean - power.mean).abs() < 4.5 * sigma, "{} and {}", tree.mean, power.mean);
    let gain = (power.error / tree.error).powi(2);
    println!("error per sample: {gain:.1} times less than by power");
    assert!(gain > 10.0, "only {gain:.1} times less error than by power");
}
