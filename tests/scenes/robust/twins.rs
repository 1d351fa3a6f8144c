//! A scene rendered elsewhere or in other units: the same picture.

use super::shapes::{add, render_sanely, skew, sphere};
use crate::common::{Maker, estimate, first_difference, small};
use glam::DVec3;
use octray::scene::desc::{CameraDesc, EnvironmentDesc, Scattering, SceneDesc};
use octray::{Film, PreparedScene, Settings, Strategy};

/// A room with a lamp, a mirror ball and a stone, of size 2, skewed, its corners rounded to multiples of 2^-11 so
/// that a shift by up to 2^13 units is exact.
fn room() -> SceneDesc {
    let mut maker = Maker::default();
    let wall = maker.diffuse([0.7, 0.6, 0.5], [0.0; 3]);
    let lamp = maker.diffuse([0.0; 3], [9.0, 8.0, 7.0]);
    let mirror = maker.material(Scattering::Mirror { reflectance: [0.9; 3] }, [0.0; 3]);
    maker.cuboid([-1.0; 3], [1.0; 3], true, wall);
    maker.quad([[-0.3, 0.9, -0.3], [0.3, 0.9, -0.3], [0.3, 0.9, 0.3], [-0.3, 0.9, 0.3]], lamp);
    add(&mut maker, &sphere(2), mirror, |p| p * 0.3 + DVec3::new(0.4, -0.6, -0.3));
    add(&mut maker, &sphere(1), wall, |p| p * 0.3 + DVec3::new(-0.4, -0.7, 0.1));
    for position in &mut maker.mesh.positions {
        *position = (skew() * DVec3::from(position.map(f64::from)) * 2048.0).round().as_vec3().to_array();
        *position = position.map(|x| x / 2048.0);
    }
    let eye = skew() * DVec3::new(0.1, 0.0, 0.9);
    maker.desc.camera = CameraDesc {
        position: ((eye * 2048.0).round() / 2048.0).to_array(),
        look_at: (skew() * DVec3::new(0.0, -0.1, -1.0)).to_array(),
        up: [0.0, 1.0, 0.0],
        vertical_fov: 80.0,
        ..CameraDesc::default()
    };
    maker.desc.film = (24, 24);
    maker.desc.name = "a room".into();
    maker.whole()
}

fn moved(scene: &SceneDesc, scale: f64, shift: DVec3) -> PreparedScene {
    let mut scene = scene.clone();
    let place = |p: [f64; 3]| (DVec3::from(p) * scale + shift).to_array();
    scene.meshes[0].positions.iter_mut().for_each(|p| *p = place(p.map(f64::from)).map(|x| x as f32));
    scene.camera.position = place(scene.camera.position);
    scene.camera.look_at = place(scene.camera.look_at);
    PreparedScene::new(&scene).unwrap_or_else(|error| panic!("{error}"))
}

/// Radiance has no unit of length, so a scene in other units is the same scene; by a power of two it has the same bits,
/// since every operation, densities over areas and all, scales without rounding.
#[test]
fn scaling_by_powers_of_two_keeps_every_bit() {
    let room = room();
    for strategy in [Strategy::MisPower, Strategy::MisOneSample, Strategy::Uniform] {
        let settings = Settings { strategy, ..small(24, 24, 8) };
        let unit = render_sanely(&moved(&room, 1.0, DVec3::ZERO), &settings, "unit");
        for power in [-32, -20, -1, 7, 20, 39] {
            let scene = moved(&room, 2f64.powi(power), DVec3::ZERO);
            let film = render_sanely(&scene, &settings, &format!("2^{power}"));
            assert_eq!(first_difference(&unit, &film), None, "{strategy}, 2^{power}");
        }
    }
}

/// Asserts that two pictures of the same samples are the same but for a few paths that took another way: no noise is
/// between them, so their means must be much closer than the noise of either.
fn assert_twins(a: &Film, b: &Film, apart: f64, what: &str) {
    let mut differing = 0;
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        let scale = p.sum[0].abs() + q.sum[0].abs();
        differing += ((p.sum[0] - q.sum[0]).abs() > 1e-3 * scale) as usize;
    }
    let share = differing as f64 / a.pixels.len() as f64;
    let [x, y] = [a, b].map(|film| estimate(film, 0..film.width, 0..film.height, 0));
    let noise = (x.error * x.error + y.error * y.error).sqrt();
    println!("{what}: {:.1} % of the pixels differ, means {} and {} +- {noise}", 100.0 * share, x.mean, y.mean);
    // Where most paths have parted there are two noises.
    let allowed = if share < 0.5 { 0.2 * noise } else { 3.0 * noise };
    assert!((x.mean - y.mean).abs() < allowed, "{what}: {} and {} +- {noise}", x.mean, y.mean);
    assert!(share <= apart, "{what}: {differing} of {} pixels", a.pixels.len());
}

#[test]
fn other_scales_and_places_render_as_their_twins() {
    let room = room();
    let settings = Settings { max_depth: Some(6), ..small(24, 24, 32) };
    let unit = render_sanely(&moved(&room, 1.0, DVec3::ZERO), &settings, "unit");
    for scale in [1e-6, 0.3, 1e6] {
        let film = render_sanely(&moved(&room, scale, DVec3::ZERO), &settings, &format!("x {scale}"));
        assert_twins(&unit, &film, 0.05, &format!("x {scale}"));
    }
    // Shifts by multiples of the grid: all coordinates stay exact, so the twin has the same rounded corners.
    for (sizes, apart) in [(1.0, 0.05), (10.0, 0.05), (100.0, 0.2), (1000.0, 1.0)] {
        let scene = moved(&room, 1.0, DVec3::new(3.25, -3.25, 3.25) * sizes);
        assert_eq!(scene.warnings, [""; 0]);
        let film = render_sanely(&scene, &settings, &format!("{sizes} sizes away"));
        assert_twins(&unit, &film, apart, &format!("{sizes} sizes away"));
    }
}

/// The lit outside of a ball far from the origin: no speckle and no dark spot, every pixel within its own noise.
#[test]
fn a_ball_in_even_light_is_even_wherever_it_lies() {
    for (scale, sizes) in [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 10.0), (1.0, 1000.0)] {
        let mut maker = Maker::default();
        let grey = maker.diffuse([0.5; 3], [0.0; 3]);
        let away = DVec3::new(0.62, -0.57, 0.54).normalize() * 2.0 * sizes;
        add(&mut maker, &sphere(4), grey, |p| (skew() * p + away) * scale);
        maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
        let eye = (away + DVec3::new(0.0, 0.0, 4.0)) * scale;
        let scene = maker.seen(eye.to_array(), (away * scale).to_array(), 20.0);
        let film = render_sanely(&scene, &Settings { strategy: Strategy::Nee, ..small(24, 24, 8) }, "ball");
        // A convex mesh: each sample is 0.5 exactly, but for the ulps of weights.
        for (i, pixel) in film.pixels.iter().enumerate() {
            assert!(
                (pixel.sum[0] / 8.0 - 0.5).abs() < 1e-5,
                "x {scale}, {sizes} away, pixel {i}: {}",
                pixel.sum[0] / 8.0
            );
        }
    }
}
