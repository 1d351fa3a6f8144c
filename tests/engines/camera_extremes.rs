//! Cameras at the ends of their numbers: every picture is finite and there, and where f32 directions are too coarse for the
//! pixels it is said.

use crate::common::{Maker, first_difference, small};
use glam::DVec3;
use octray::internal::camera::{Camera, LEAST_PIXEL_ANGLE, warnings};
use octray::scene::SceneDesc;
use octray::scene::desc::{CameraDesc, EnvironmentDesc, PixelFilter};
use octray::{Engine, PreparedScene, Settings, render};

/// A grey triangle far off to one side, in even light of radiance 1.
fn sky(camera: CameraDesc) -> SceneDesc {
    let mut maker = Maker::default();
    let grey = maker.diffuse([0.5; 3], [0.0; 3]);
    maker.quad([[3.0, 0.0, -4.0], [4.0, 0.0, -4.0], [4.0, 1.0, -4.0], [3.0, 1.0, -4.0]], grey);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    (maker.desc.name, maker.desc.camera, maker.desc.film) = ("sky".into(), camera, (8, 8));
    maker.whole()
}

/// Both engines give the same finite picture, in which nothing is darker than the triangle.
fn assert_there(camera: CameraDesc, (width, height): (u32, u32)) -> octray::Film {
    let scene = PreparedScene::new(&sky(camera)).unwrap_or_else(|error| panic!("{error}: {camera:?}"));
    let [packet, scalar] = [Engine::Packet, Engine::Scalar].map(|engine| {
        let settings = Settings { engine, max_depth: Some(1), ..small(width, height, 4) };
        let render = render(&scene, &settings);
        assert_eq!(render.stats.nonfinite, 0, "{camera:?}");
        render.film
    });
    assert_eq!(first_difference(&packet, &scalar), None, "{camera:?}");
    let dark = packet.pixels.iter().filter(|pixel| !(0.3 * 4.0..=4.01).contains(&pixel.sum[0])).count();
    assert_eq!(dark, 0, "{camera:?}");
    packet
}

#[test]
fn lenses_of_every_size_give_pictures() {
    let eye = CameraDesc { position: [0.2, 0.3, 2.0], look_at: [0.0, 0.1, 0.3], ..CameraDesc::default() };
    for focus_distance in [1e-38f64, 1e-30, 1e-20, 1e-12, 1e-6, 1.0, 1e6, 1e13, 1e20, 1e30, 3e38] {
        for ratio in [1e-30, 1e-6, 0.5, 1000.0f64] {
            let aperture_radius = (ratio * focus_distance).min(1e11);
            for vertical_fov in [1e-3, 35.0, 179.999, 180.0 - 1e-13] {
                let camera = CameraDesc { vertical_fov, aperture_radius, focus_distance, ..eye };
                assert_there(camera, (4, 3));
                let [x, y, z] = [1e-6, 1e6, 1.0];
                let rows = [[x, 0.0, 0.0, 0.2], [0.0, y, 0.0, 0.3], [0.0, 0.0, z, 2.0]];
                let aperture_radius = aperture_radius.min(1e5);
                assert_there(CameraDesc { to_world: Some(rows), aperture_radius, ..camera }, (4, 3));
            }
        }
    }
}

/// A plane in focus beyond everything: rays through one point of the film are parallel, wherever exactly it is.
#[test]
fn focus_far_away_is_focus_at_infinity() {
    let film = |exponent: i32| {
        let focus_distance = 2f64.powi(exponent);
        assert_there(
            CameraDesc { position: [1.0, 0.3, 2.0], aperture_radius: 0.2, focus_distance, ..CameraDesc::default() },
            (24, 16),
        )
    };
    let far = film(127);
    for exponent in [41, 60, 90, 110] {
        assert_eq!(first_difference(&film(exponent), &far), None, "2^{exponent}");
    }
}

#[test]
fn lenses_that_cannot_be_are_refused() {
    let fault = |aperture_radius: f64, focus_distance: f64| {
        let camera = CameraDesc { aperture_radius, focus_distance, ..CameraDesc::default() };
        PreparedScene::new(&sky(camera)).err().map(|error| error.to_string()).unwrap_or_default()
    };
    for (aperture, focus) in [(1.0, 1e-30), (1e-3, 0.9e-6), (1e30, 1.0), (1e11, 1e7)] {
        assert!(fault(aperture, focus).contains("aperture_radius is more than 1000 times"), "{aperture} {focus}");
    }
    for (aperture, focus) in [(1e13, 1e13), (1e30, 1e30), (3e38, 3e38)] {
        assert!(fault(aperture, focus).contains("the camera reaches to"), "{aperture} {focus}");
    }
}

#[test]
fn fields_of_view_next_to_0_and_180_degrees_give_pictures() {
    for vertical_fov in [1e-300, 1e-40, 1e-20, 1e-7, 179.0, 179.999, 179.999_999_9, 180.0 - 1e-12, 180.0f64.next_down()]
    {
        for film in [(4, 3), (600, 1), (1, 600)] {
            for look_at in [[0.0, 0.0, -1.0], [0.3, -0.2, -0.7]] {
                let camera = CameraDesc { position: [0.0, 0.0, 1.0], look_at, vertical_fov, ..CameraDesc::default() };
                assert_there(camera, film);
            }
        }
    }
    for (position, look_at) in [
        ([0.0, 0.0, 1e-30], [0.0; 3]),
        ([1e-30, 0.0, 0.0], [0.0, 1e-30, 2e-30]),
        ([0.0, 0.0, 1e11], [0.0, 1e10, 0.0]),
        ([0.0, 0.0, 1.0], [1e30, 0.0, -3e38]),
    ] {
        assert_there(CameraDesc { position, look_at, ..CameraDesc::default() }, (4, 3));
    }
    for tilt in [1.1e-6, 1e-3] {
        let camera = CameraDesc { look_at: [tilt, 1.0, 1.0], up: [0.0, 1e-30, 0.0], ..CameraDesc::default() };
        assert_there(camera, (4, 3));
    }
}

/// The warning's figure: over oblique views at the limit, the f32 direction lies within half a pixel of the true one.
#[test]
fn pixels_below_2_to_the_minus_22_are_warned_about() {
    let fov = |angle: f64, height: u32| (2.0 * (0.5 * angle * f64::from(height)).atan()).to_degrees();
    let at = |angle: f64, height: u32, look_at: [f64; 3]| CameraDesc {
        vertical_fov: fov(angle, height),
        look_at,
        position: [0.0; 3],
        ..CameraDesc::default()
    };
    let mut worst: f64 = 0.0;
    for i in 1..400u32 {
        let turn = f64::from(i) * 2.399_963;
        let view = DVec3::new(turn.cos(), 0.004 * f64::from(i) - 0.8, turn.sin());
        for height in [16, 512] {
            let camera = at(LEAST_PIXEL_ANGLE * 1.001, height, view.to_array());
            assert_eq!(warnings(&camera, height), [""; 0]);
            assert_eq!(warnings(&at(LEAST_PIXEL_ANGLE * 0.999, height, view.to_array()), height).len(), 1);
            let f32s = Camera::new(&camera, PixelFilter::Box, height, height);
            let (x, y) = (0.37 * f64::from(height), 0.71 * f64::from(height));
            let vec = |v: [f32; 3]| glam::Vec3::from(v);
            let found = vec(f32s.corner) + vec(f32s.right) * x as f32 + vec(f32s.down) * y as f32;
            // The same direction in f64, by the camera's own description.
            let forward = view.normalize();
            let right = forward.cross(DVec3::Y).normalize();
            let down = forward.cross(right);
            let (x, y) = (f64::from(x as f32) - 0.5 * f64::from(height), f64::from(y as f32) - 0.5 * f64::from(height));
            let wanted = (forward + (right * x + down * y) * LEAST_PIXEL_ANGLE * 1.001).normalize();
            let error = found.as_dvec3().normalize().cross(wanted).length() / (LEAST_PIXEL_ANGLE * 1.001);
            worst = worst.max(error);
        }
    }
    assert!(worst > 0.1 && worst < 0.5, "{worst} pixels");
    // A matrix may stretch one axis; what a pixel spans beside forward counts.
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1e-4, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let stretched = CameraDesc { to_world: Some(rows), ..at(1e-3, 100, [0.0, 0.0, -1.0]) };
    assert_eq!(
        (warnings(&stretched, 100).len(), warnings(&CameraDesc { to_world: None, ..stretched }, 100).len()),
        (1, 0)
    );
    // The library hears of it with the render; what decides is the film that is rendered.
    let scene = PreparedScene::new(&sky(at(1e-6, 10, [0.1, 0.2, -0.7]))).unwrap_or_else(|error| panic!("{error}"));
    let said = |height: u32| render(&scene, &small(4, height, 1)).stats.warnings;
    assert_eq!(said(10), [""; 0]);
    assert!(said(100)[0].starts_with("a pixel is 1.0e-7 rad large; below 2.4e-7 (2^-22)"), "{:?}", said(100));
}
