//! Pictures against truths that are not ours: closed forms. Every statistical bound is 5 standard errors (a false alarm
//! once in 1.7 million comparisons), and seeds are fixed, so a test that passes once passes always.

use crate::common;
use crate::common::{Maker, estimate, exact_strategies, polygon_irradiance, small};
use glam::DVec3;
use octray::scene::desc::{DeltaLight, DeltaLightDesc, EnvironmentDesc, LightDesc, Scattering};
use octray::{Engine, Lights, PreparedScene, Sampler, Settings, Strategy, render};

const SIGMAS: f64 = 5.0;

/// Asserts that the mean of a picture is `truth` within its own noise, and that this noise is below `precision`.
fn assert_mean(scene: &PreparedScene, settings: &Settings, truth: [f64; 3], precision: f64, what: &str) {
    let film = render(scene, settings).film;
    for (channel, truth) in truth.into_iter().enumerate() {
        let got = estimate(&film, 0..film.width, 0..film.height, channel);
        // f32 arithmetic itself may be off by a few 1e-6.
        let bound = SIGMAS * got.error + 1e-5 * truth;
        let difference = (got.mean - truth).abs();
        assert!(difference <= bound, "{what}, channel {channel}: {} +- {}, truth {}", got.mean, got.error, truth);
        assert!(bound <= precision * truth.max(1e-3), "{what}: {bound} is too noisy to prove anything");
    }
}

const ALBEDO: [f64; 3] = [0.75, 0.5, 0.25];
const LIGHT: [[f32; 3]; 4] = [[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]];

/// A floor at y = 0 under a square light at y = 1 that faces down, seen through a pinhole at one point of the floor.
fn floor_under_light(at: [f64; 3]) -> PreparedScene {
    let mut maker = Maker::default();
    let floor = maker.diffuse(ALBEDO, [0.0; 3]);
    let light = maker.diffuse([0.0; 3], [1.0, 2.0, 4.0]);
    maker.quad([[-20.0, 0.0, 20.0], [20.0, 0.0, 20.0], [20.0, 0.0, -20.0], [-20.0, 0.0, -20.0]], floor);
    maker.quad(LIGHT, light);
    maker.seen([at[0] + 6.0, 0.9, at[2] + 1.0], at, 1e-3)
}

fn floor_radiance(at: [f64; 3]) -> [f64; 3] {
    let corners = LIGHT.map(|c| DVec3::from(c.map(f64::from)));
    let irradiance = polygon_irradiance(DVec3::from(at), DVec3::Y, &corners);
    std::array::from_fn(|c| ALBEDO[c] / std::f64::consts::PI * irradiance * [1.0, 2.0, 4.0][c])
}

#[test]
fn lambert_polygon_irradiance_by_every_strategy() {
    for at in [[0.0, 0.0, 0.0], [0.7, 0.0, 0.2], [2.0, 0.0, -1.0]] {
        let (scene, truth) = (floor_under_light(at), floor_radiance(at));
        for strategy in exact_strategies() {
            for max_depth in [Some(1), None] {
                let settings = Settings { strategy, max_depth, ..small(16, 16, 2048) };
                assert_mean(&scene, &settings, truth, 0.12, &format!("{strategy} at {at:?}, depth {max_depth:?}"));
            }
        }
    }
}

/// What one delta light brings to the floor at `at`, by hand: pbrt-v4, equations of sections 12.1 to 12.3.
#[test]
fn delta_lights_have_their_closed_forms() {
    let at = DVec3::new(0.7, 0.0, 0.2);
    let (position, strength) = ([0.2, 1.5, -0.4], [3.0, 2.0, 0.5]);
    let to_light = DVec3::from(position) - at;
    let (cosine, distance) = (to_light.normalize().y, to_light.length());
    let axis = DVec3::new(0.3, -1.0, 0.4);
    let angle = axis.angle_between(-to_light).to_degrees();
    let step = |edge: f64, whole: f64| {
        let [edge, whole, at] = [edge, whole, angle].map(|degrees| degrees.to_radians().cos());
        let t = ((at - edge) / (whole - edge)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let spot = |cone_angle: f64, cone_delta_angle: f64| DeltaLight::Spot {
        position,
        direction: axis.to_array(),
        intensity: strength,
        cone_angle,
        cone_delta_angle,
    };
    let by_distance = cosine / (distance * distance);
    let down = DVec3::new(0.5, -2.0, 0.1);
    let lights = [
        (DeltaLight::Point { position, intensity: strength }, by_distance),
        (DeltaLight::Directional { direction: down.to_array(), irradiance: strength }, -down.normalize().y),
        (DeltaLight::Directional { direction: [0.0, 1.0, 0.0], irradiance: strength }, 0.0),
        (spot(angle + 10.0, 0.0), by_distance),
        (spot(angle + 10.0, 5.0), by_distance),
        (spot(angle + 10.0, angle + 10.0), by_distance * step(angle + 10.0, 0.0)),
        (spot(angle + 1.0, 2.0), by_distance * step(angle + 1.0, angle - 1.0)),
        (spot(0.9 * angle, 1.0), 0.0),
        (spot(180.0, 180.0), by_distance * step(180.0, 0.0)),
    ];
    for (light, irradiance) in lights {
        let mut maker = Maker::default();
        let floor = maker.diffuse(ALBEDO, [0.0; 3]);
        // Small, and seen from above: f32 then has the place that is seen to 1e-7.
        maker.quad([[-1.0, 0.0, 1.0], [1.5, 0.0, 1.0], [1.5, 0.0, -1.0], [-1.0, 0.0, -1.0]], floor);
        maker.desc.lights.push(LightDesc::Delta(DeltaLightDesc { name: "it".into(), light }));
        let scene = maker.seen([1.1, 0.9, 0.4], at.to_array(), 1e-3);
        let truth: [f64; 3] = std::array::from_fn(|c| ALBEDO[c] / std::f64::consts::PI * irradiance * strength[c]);
        for &strategy in Strategy::ALL {
            let seen = strategy.samples_lights();
            for (engine, &lights) in
                [Engine::Packet, Engine::Scalar].iter().flat_map(|e| Lights::ALL.iter().map(move |l| (e, l)))
            {
                // The coin of one strategy makes noise, nothing else does.
                let (side, spp) = if strategy == Strategy::MisOneSample { (2, 4096) } else { (8, 16) };
                let sampler = Sampler::Independent;
                let settings = Settings { strategy, engine: *engine, lights, sampler, ..small(side, side, spp) };
                let truth = if seen { truth } else { [0.0; 3] };
                let precision = if strategy == Strategy::MisOneSample { 0.1 } else { 2e-5 };
                let what = format!("{light:?}, {strategy}, {engine}, {lights}");
                assert_mean(&scene, &settings, truth, precision, &what);
            }
        }
    }
}

/// Among lights of other kinds, one of which hides behind a wall, a delta light brings what it brings alone.
#[test]
fn delta_lights_add_up_with_all_others() {
    let at = DVec3::new(0.7, 0.0, 0.2);
    let scene = |which: &[usize]| {
        let mut maker = Maker::default();
        let floor = maker.diffuse(ALBEDO, [0.0; 3]);
        let lamp = maker.diffuse([0.0; 3], if which.contains(&3) { [1.0, 2.0, 4.0] } else { [0.0; 3] });
        maker.quad([[-20.0, 0.0, 20.0], [20.0, 0.0, 20.0], [20.0, 0.0, -20.0], [-20.0, 0.0, -20.0]], floor);
        maker.quad(LIGHT, lamp);
        let lights = [
            DeltaLight::Point { position: [1.5, 0.6, 0.5], intensity: [1.0, 0.5, 2.0] },
            DeltaLight::Directional { direction: [-0.6, -1.0, 0.0], irradiance: [0.5, 2.0, 0.5] },
            // The lamp hides it.
            DeltaLight::Point { position: [-0.6, 2.5, -0.1], intensity: [50.0; 3] },
        ];
        for i in which.iter().copied().filter(|&i| i < 3) {
            maker.desc.lights.push(LightDesc::Delta(DeltaLightDesc { name: format!("{i}"), light: lights[i] }));
        }
        if which.contains(&4) {
            maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.2, 0.1, 0.3] }));
        }
        maker.seen([6.7, 0.9, 1.2], at.to_array(), 1e-3)
    };
    let base = Settings { max_depth: Some(1), threads: 0, ..small(8, 8, 4096) };
    let mean = |which: &[usize], settings: &Settings| {
        let film = render(&scene(which), settings).film;
        std::array::from_fn::<_, 3, _>(|channel| estimate(&film, 0..8, 0..8, channel))
    };
    assert_eq!(mean(&[2], &base).map(|estimate| estimate.mean), [0.0; 3], "it is hidden");
    let alone = [[0].as_slice(), &[1], &[3], &[4]].map(|which| mean(which, &base));
    let all = scene(&[0, 1, 2, 3, 4]);
    for strategy in exact_strategies().filter(|strategy| strategy.samples_lights()) {
        for &lights in Lights::ALL {
            let film = render(&all, &Settings { strategy, lights, seed: 3, ..base.clone() }).film;
            for channel in 0..3 {
                let got = estimate(&film, 0..8, 0..8, channel);
                let truth: f64 = alone.iter().map(|of| of[channel].mean).sum();
                let error = alone.iter().fold(got.error, |sum, of| sum.hypot(of[channel].error));
                assert!(error < 0.02 * truth, "{strategy}, {lights}: too noisy to prove anything");
                let z = (got.mean - truth) / error;
                assert!(
                    z.abs() < SIGMAS,
                    "{strategy}, {lights}, channel {channel}: {} and {truth}, z = {z:.1}",
                    got.mean
                );
            }
        }
    }
}

#[test]
fn the_biased_strategies_are_biased_as_the_lecture_says() {
    let at = [0.7, 0.0, 0.2];
    let (scene, truth) = (floor_under_light(at), floor_radiance(at));
    let sum = Settings { strategy: Strategy::NeeSum, ..small(16, 16, 2048) };
    assert_mean(&scene, &sum, truth.map(|t| 2.0 * t), 0.05, "nee-sum doubles direct light");
    let no_emission = Settings { strategy: Strategy::NeeNoEmission, ..small(16, 16, 512) };
    assert_mean(&scene, &no_emission, truth, 0.05, "nee-no-emission keeps direct light");

    let mut maker = Maker::default();
    let light = maker.diffuse([0.0; 3], [1.0, 2.0, 4.0]);
    maker.quad(LIGHT, light);
    let lamp = maker.seen([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 10.0);
    assert_eq!(render(&lamp, &no_emission).film.mean_radiance(), [0.0; 3], "nee-no-emission blackens lights");
    for strategy in exact_strategies() {
        let seen = render(&lamp, &Settings { strategy, ..small(4, 4, 4) }).film.mean_radiance();
        assert_eq!(seen, [1.0, 2.0, 4.0], "{strategy}: a light is as bright as it is");
    }
    let behind = {
        let mut maker = Maker::default();
        let light = maker.diffuse([0.0; 3], [1.0, 2.0, 4.0]);
        maker.quad(LIGHT, light);
        maker.seen([0.0, 2.0, 0.0], [0.0, 1.0, 0.0], 10.0)
    };
    assert_eq!(render(&behind, &small(4, 4, 4)).film.mean_radiance(), [0.0; 3], "emission is one-sided");
}

/// A light between a floor and a ceiling that lights both: Lambert's formula holds on either side, and the light is seen
/// from both. Beside it a one-sided light far away keeps its dark back, and power weighs the first one twice.
#[test]
fn a_two_sided_light_shines_on_both_sides() {
    let build = |at: [f64; 3], lookout: [f64; 3]| {
        let mut maker = Maker::default();
        let floor = maker.diffuse(ALBEDO, [0.0; 3]);
        let light = maker.diffuse([0.0; 3], [1.0, 2.0, 4.0]);
        let far = maker.diffuse([0.0; 3], [1.0, 2.0, 4.0]);
        maker.desc.materials[light as usize].two_sided = true;
        for y in [0.0, 2.0] {
            maker.quad([[-9.0, y, 9.0], [9.0, y, 9.0], [9.0, y, -9.0], [-9.0, y, -9.0]], floor);
        }
        maker.quad(LIGHT, light);
        maker.quad([[50.0, 0.0, 0.0], [50.0, 1.0, 0.0], [50.0, 1.0, 1.0], [50.0, 0.0, 1.0]], far);
        maker.seen(lookout, at, 1e-3)
    };
    let truth = floor_radiance([0.7, 0.0, 0.2]);
    for y in [0.0, 2.0] {
        let scene = build([0.7, y, 0.2], [6.7, y + (1.0 - y) * 0.9, 1.2]);
        for strategy in exact_strategies() {
            for lights in [octray::Lights::Uniform, octray::Lights::Power] {
                let settings = Settings { strategy, lights, max_depth: Some(1), ..small(16, 16, 256) };
                assert_mean(&scene, &settings, truth, 0.3, &format!("{strategy}, {lights}, plane at {y}"));
                let small = Settings { max_depth: None, spp: 4, ..settings };
                let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..small.clone() });
                let packet = render(&scene, &small);
                assert_eq!(common::first_difference(&packet.film, &scalar.film), None, "{strategy}, {lights}");
            }
        }
    }
    for y in [0.5, 1.5] {
        let lamp = build([0.1, 1.0, 0.1], [0.1, y, 0.2]);
        assert_eq!(render(&lamp, &small(4, 4, 4)).film.mean_radiance(), [1.0, 2.0, 4.0], "seen from y = {y}");
    }
    let scene = build([0.0; 3], [0.0, 0.5, 0.1]);
    let record = |lights| octray::internal::tables::lights::table::LightTable::new(&scene, lights, false);
    let (uniform, power) = (record(octray::Lights::Uniform), record(octray::Lights::Power));
    let share = |i: usize| power.probability(i as u32) / uniform.probability(i as u32);
    assert!((share(0) / share(2) - 2.0).abs() < 1e-5, "twice the power: {} {}", share(0), share(2));
    assert!(uniform.records[0].two_sided() && !uniform.records[2].two_sided());
}

/// A lamp at the origin of coordinates, its own numbers tiny, seen from far away: rays arrive there with the rounding of
/// where they come from, and must not run into the lamp before its surface.
#[test]
fn a_lamp_at_the_origin_does_not_hide_itself() {
    for s in [0.03f32, 0.3] {
        let depth = 7.0;
        let mut maker = Maker::default();
        let floor = maker.diffuse(ALBEDO, [0.0; 3]);
        let light = maker.diffuse([0.0; 3], [1e3; 3]);
        let y = -depth as f32;
        maker.quad([[-20.0, y, 20.0], [20.0, y, 20.0], [20.0, y, -20.0], [-20.0, y, -20.0]], floor);
        maker.cuboid([-s, -s, -s], [s, s, s], false, light);
        let at = [2.5, -depth, 1.5];
        let scene = maker.seen([at[0] + 3.0, 1.0 - depth, at[2]], at, 1e-3);
        // From there the front, the right and the bottom are in sight.
        let faces = [
            [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]],
            [[1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0]],
            [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, -1.0, 1.0]],
        ];
        let size = f64::from(s);
        let faces = faces.map(|face| face.map(|corner: [f64; 3]| size * DVec3::from(corner)));
        let irradiance: f64 = faces.iter().map(|face| polygon_irradiance(DVec3::from(at), DVec3::Y, face)).sum();
        let truth = ALBEDO.map(|albedo| albedo / std::f64::consts::PI * irradiance * 1e3);
        for strategy in [Strategy::Nee, Strategy::MisBalance, Strategy::MisPower] {
            for &lights in octray::Lights::ALL {
                let settings = Settings { strategy, lights, max_depth: Some(1), ..small(16, 16, 256) };
                assert_mean(&scene, &settings, truth, 2e-2, &format!("{strategy}, {lights}, size {size}"));
            }
        }
    }
}

#[test]
fn a_tiny_light_follows_the_inverse_square_law() {
    let mut maker = Maker::default();
    let floor = maker.diffuse([0.5; 3], [0.0; 3]);
    let light = maker.diffuse([0.0; 3], [1e6; 3]);
    maker.quad([[-20.0, 0.0, 20.0], [20.0, 0.0, 20.0], [20.0, 0.0, -20.0], [-20.0, 0.0, -20.0]], floor);
    let s = 5e-4;
    maker.quad([[-s, 2.0, -s], [s, 2.0, -s], [s, 2.0, s], [-s, 2.0, s]], light);
    let scene = maker.seen([5.0, 1.0, 0.0], [1.5, 0.0, 0.0], 1e-3);
    let area = (2.0 * s as f64).powi(2);
    let distance_squared: f64 = 2.0 * 2.0 + 1.5 * 1.5;
    let cosine = 2.0 / distance_squared.sqrt();
    let truth = 0.5 / std::f64::consts::PI * 1e6 * area * cosine * cosine / distance_squared;
    for strategy in [Strategy::Nee, Strategy::MisBalance, Strategy::MisPower] {
        let settings = Settings { strategy, max_depth: Some(1), ..small(8, 8, 256) };
        assert_mean(&scene, &settings, [truth; 3], 2e-3, strategy.name());
    }
}

/// A lamp of `rings` x `2 rings` facets inscribed in the sphere of radius 1 about `centre`; the radius of the largest sphere
/// that fits into it.
fn sphere_lamp(maker: &mut Maker, centre: DVec3, rings: u32, material: u32) -> f64 {
    let at = |ring: u32, step: u32| {
        let (theta, phi) =
            (std::f64::consts::PI / rings as f64 * ring as f64, std::f64::consts::PI / rings as f64 * step as f64);
        (centre + DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())).as_vec3().to_array()
    };
    let first = maker.mesh.triangles.len();
    for ring in 0..rings {
        for step in 0..2 * rings {
            maker.quad([at(ring, step), at(ring, step + 1), at(ring + 1, step + 1), at(ring + 1, step)], material);
        }
    }
    let height = |triangle: &octray::scene::desc::TriangleDesc| {
        let [a, b, c] = triangle.vertices.map(|v| DVec3::from(maker.mesh.positions[v as usize].map(f64::from)));
        let normal = (b - a).cross(c - a);
        // Without area at the poles: no face.
        if normal.length() < 1e-9 { 1.0 } else { (a - centre).dot(normal.normalize()) }
    };
    maker.mesh.triangles[first..].iter().map(height).fold(1.0, f64::min)
}

/// A sphere of radiance 1 and radius r whose centre stands d away at an angle theta from the normal, wholly above the
/// plane, gives the irradiance pi (r / d)^2 cos theta. The tessellated lamp lies between two spheres, and so does what it
/// gives.
#[test]
fn a_sphere_lights_a_plane_as_its_closed_form_says() {
    let build = |at: DVec3| {
        let mut maker = Maker::default();
        let floor = maker.diffuse([0.5; 3], [0.0; 3]);
        let lamp = maker.diffuse([0.0; 3], [1.0; 3]);
        maker.quad([[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]], floor);
        let inner = sphere_lamp(&mut maker, DVec3::new(0.0, 2.0, 0.0), 48, lamp);
        (maker.seen([at.x + 6.0, 0.4, at.z + 1.0], at.to_array(), 1e-3), inner)
    };
    for at in [DVec3::ZERO, DVec3::new(1.5, 0.0, 0.5), DVec3::new(-3.0, 0.0, 2.0)] {
        let (scene, inner) = build(at);
        assert!(inner > 0.997, "a fine sphere: {inner}");
        let to_centre = DVec3::new(0.0, 2.0, 0.0) - at;
        let form = |radius: f64| {
            let irradiance =
                std::f64::consts::PI * radius * radius / to_centre.length_squared() * to_centre.y / to_centre.length();
            0.5 / std::f64::consts::PI * irradiance
        };
        for strategy in exact_strategies() {
            for &lights in octray::Lights::ALL {
                let settings = Settings { strategy, lights, max_depth: Some(1), ..small(16, 16, 1024) };
                let got = estimate(&render(&scene, &settings).film, 0..16, 0..16, 0);
                let what = format!("{strategy}, {lights} at {at}: {} +- {}", got.mean, got.error);
                let (low, high) = (form(inner) - SIGMAS * got.error, form(1.0) + SIGMAS * got.error);
                assert!((low..=high).contains(&got.mean), "{what}, truth {} to {}", form(inner), form(1.0));
                assert!(SIGMAS * got.error < 0.1 * form(1.0), "{what} is too noisy to prove anything");
            }
        }
    }
}

/// A closed box whose walls emit 1 - albedo: radiance 1 everywhere, 1 - albedo^(N+1) after N events.
fn furnace(albedo: [f64; 3]) -> PreparedScene {
    let mut maker = Maker::default();
    let wall = maker.diffuse(albedo, albedo.map(|a| 1.0 - a));
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.5, 2.0], true, wall);
    maker.seen([0.1, 0.2, 0.3], [0.5, 0.4, -1.0], 70.0)
}

#[test]
fn the_furnace_has_the_radiance_of_its_series() {
    let albedo = [0.25, 0.5, 0.75];
    let scene = furnace(albedo);
    for strategy in exact_strategies() {
        for max_depth in [Some(0), Some(1), Some(2), Some(5), None] {
            for rr_depth in [Some(1), Some(4), None] {
                let settings = Settings { strategy, max_depth, rr_depth, ..small(16, 16, 64) };
                let order = max_depth.map_or(f64::INFINITY, |n| n as f64 + 1.0);
                let truth = albedo.map(|a: f64| 1.0 - a.powf(order));
                let what = format!("{strategy}, depth {max_depth:?}, roulette {rr_depth:?}");
                assert_mean(&scene, &settings, truth, 0.25, &what);
            }
        }
    }
}

#[test]
fn roulette_is_unbiased_wherever_it_starts() {
    let (dark, bright) = ([0.25, 0.5, 0.75], [0.8, 0.6, 0.3]);
    for (albedo, sampler) in [(dark, Sampler::Independent), (dark, Sampler::Sobol), (bright, Sampler::Sobol)] {
        let scene = furnace(albedo);
        // Not `nee`: near the corners of a box that shines everywhere its light samples have no finite variance.
        for strategy in [Strategy::Bsdf, Strategy::MisBalance, Strategy::MisPower] {
            for rr_depth in [Some(0), Some(1), Some(2), Some(3), Some(5), Some(8), None] {
                let settings = Settings { strategy, rr_depth, sampler, ..small(16, 16, 64) };
                let what = format!("{strategy}, roulette {rr_depth:?}, {sampler}, albedo {albedo:?}");
                assert_mean(&scene, &settings, [1.0; 3], 0.15, &what);
            }
        }
    }
}

/// What a render says of its own error is true: over many seeds the mean of the picture is as far from the truth as often
/// as stated, the mean squared error is what the estimate of it is in the mean, and the estimate is as precise as it says.
#[test]
fn stated_errors_are_as_large_as_true_ones() {
    const SEEDS: u32 = 300;
    let scene = furnace([0.5; 3]);
    let truth = 1.0 - 0.5f64.powi(3);
    for (sampler, spp) in [
        (Sampler::Independent, 16),
        (Sampler::Sobol, 4),
        (Sampler::Sobol, 16),
        (Sampler::Sobol, 18),
        (Sampler::Sobol, 64),
    ] {
        let (mut within, mut true_square, mut stated_square, mut stated) = ([0.0; 2], 0.0, 0.0, Vec::new());
        for seed in 0..SEEDS {
            let settings = Settings { sampler, seed, max_depth: Some(2), ..small(8, 8, spp) };
            let film = render(&scene, &settings).film;
            let (relative, precision) = film.relative_error_estimate().expect("enough samples");
            let mean = film.mean_radiance()[0];
            let square = |p: u32| (f64::from(film.mean(p % 8, p / 8)[0]) - truth).powi(2);
            true_square += (0..64).map(square).sum::<f64>() / 64.0 / f64::from(SEEDS);
            stated_square += (relative * mean).powi(2) / f64::from(SEEDS);
            stated.push((relative * mean, precision * mean));
            // All pixels are independent, so the error of their mean is an eighth of theirs.
            let sigmas = (mean - truth).abs() / (relative * mean / 8.0);
            for (share, most) in within.iter_mut().zip([1.0, 2.0]) {
                *share += f64::from(sigmas < most) / f64::from(SEEDS);
            }
        }
        let what = format!("{sampler}, {spp} samples");
        for (share, wanted) in within.into_iter().zip([0.6827, 0.9545]) {
            let sigmas: f64 = (share - wanted) / f64::sqrt(wanted * (1.0 - wanted) / f64::from(SEEDS));
            println!("{what}: {share:.3} within, {wanted} wanted");
            assert!(sigmas.abs() < 4.0, "{what}: {share} within, {wanted} wanted");
        }
        let ratio = stated_square / true_square;
        println!("{what}: stated over true mean squared error {ratio:.3}");
        // 19,200 squared errors of nearly normal means: a standard error of about 1 %. Sizes of groups that differ cost some.
        let slack = if spp % 4 == 0 { 0.06 } else { 0.2 };
        assert!((ratio - 1.0).abs() < slack, "{what}: stated over true mean squared error is {ratio:.3}");
        let close = stated.iter().filter(|(error, precision)| (error - true_square.sqrt()).abs() < 2.0 * precision);
        let share = close.count() as f64 / f64::from(SEEDS);
        println!("{what}: {share:.3} within two stated errors of the error");
        assert!(share > 0.9, "{what}: the error lies within two of its own errors in {share} of all runs");
    }
}

#[test]
fn a_mirror_in_the_furnace_is_invisible() {
    let mut maker = Maker::default();
    let wall = maker.diffuse([0.5; 3], [0.5; 3]);
    let mirror = maker.material(Scattering::Mirror { reflectance: [1.0; 3] }, [0.0; 3]);
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], true, wall);
    maker.cuboid([-0.4, -0.4, -0.8], [0.1, 0.3, -0.5], false, mirror);
    let scene = maker.seen([0.1, 0.2, 0.8], [-0.1, 0.0, -1.0], 50.0);
    for strategy in exact_strategies() {
        let settings = Settings { strategy, ..small(16, 16, 256) };
        assert_mean(&scene, &settings, [1.0; 3], 0.1, strategy.name());
    }
}

#[test]
fn a_constant_environment_lights_a_convex_object_evenly() {
    let mut maker = Maker::default();
    let stone = maker.diffuse(ALBEDO, [0.0; 3]);
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], false, stone);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0, 2.0, 3.0] }));
    let scene = maker.seen([3.0, 2.5, 4.0], [0.3, 0.1, 0.2], 10.0);
    let truth: [f64; 3] = std::array::from_fn(|c| ALBEDO[c] * [1.0, 2.0, 3.0][c]);
    for strategy in exact_strategies() {
        let settings = Settings { strategy, ..small(16, 16, 256) };
        assert_mean(&scene, &settings, truth, 0.05, strategy.name());
    }
    // Light samples are drawn exactly in proportion to what they bring: no noise at all is left.
    let film = render(&scene, &Settings { strategy: Strategy::Nee, ..small(8, 8, 64) }).film;
    let spread = estimate(&film, 0..8, 0..8, 0);
    assert!(spread.error < 1e-6 * spread.mean, "{} +- {}", spread.mean, spread.error);
}

#[test]
fn an_environment_beside_a_light_adds_up() {
    let at = [0.7, 0.0, 0.2];
    let mut maker = Maker::default();
    let floor = maker.diffuse(ALBEDO, [0.0; 3]);
    let light = maker.diffuse([0.0; 3], [1.0, 2.0, 4.0]);
    // (Not larger: on a floor of 9,000 f32 places the hit so coarsely that the radiance is off by 0.1 %.)
    maker.quad([[-20.0, 0.0, 20.0], [20.0, 0.0, 20.0], [20.0, 0.0, -20.0], [-20.0, 0.0, -20.0]], floor);
    maker.quad(LIGHT, light);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.5; 3] }));
    let scene = maker.seen([at[0] + 6.0, 0.9, at[2] + 1.0], at, 1e-3);
    let corners = LIGHT.map(|c| DVec3::from(c.map(f64::from)));
    let irradiance = polygon_irradiance(DVec3::from(at), DVec3::Y, &corners);
    // The light's dark back hides what it covers of the sky.
    let sky = 0.5 * (std::f64::consts::PI - irradiance);
    let truth = std::array::from_fn(|c| ALBEDO[c] / std::f64::consts::PI * (irradiance * [1.0, 2.0, 4.0][c] + sky));
    for strategy in exact_strategies() {
        for lights in [octray::Lights::Uniform, octray::Lights::Power] {
            let settings = Settings { strategy, lights, max_depth: Some(1), ..small(16, 16, 1024) };
            assert_mean(&scene, &settings, truth, 0.06, &format!("{strategy}, {lights}"));
        }
    }
}

#[test]
fn a_path_without_end_meets_the_guard_in_both_engines() {
    let mut maker = Maker::default();
    let white = maker.diffuse([1.0; 3], [0.0; 3]);
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], true, white);
    let scene = maker.seen([0.0, 0.1, 0.2], [1.0, 0.3, 0.0], 60.0);
    for engine in [Engine::Packet, Engine::Scalar] {
        let settings = Settings { engine, ..small(1, 1, 1) };
        assert_eq!(render(&scene, &settings).stats.guarded, 1, "{engine}");
        let bounded = Settings { max_depth: Some(100), ..settings };
        assert_eq!(render(&scene, &bounded).stats.guarded, 0, "{engine}: a depth that was asked for is no guard");
    }
}
