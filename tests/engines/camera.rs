//! The thin lens and the pixel filters against closed forms. Bounds are 5 standard errors; seeds are fixed.

use crate::common::{Maker, estimate, first_difference, small};
use octray::scene::desc::PixelFilter;
use octray::{Engine, Film, PreparedScene, Scene, Settings, render};

const PIXELS: u32 = 64;
const FOV: f64 = 20.0;

/// A small emitter on the axis, 8 units before a camera whose lens is in focus at `focus`.
fn lamp(half_side: f32, radius: f64, focus: f64, filter: PixelFilter) -> PreparedScene {
    let mut maker = Maker::default();
    let light = maker.diffuse([0.0; 3], [1.0; 3]);
    let s = half_side;
    maker.quad([[-s, -s, 0.0], [s, -s, 0.0], [s, s, 0.0], [-s, s, 0.0]], light);
    maker.desc.filter = filter;
    maker.seen_through([0.0, 0.0, 8.0], [0.0; 3], FOV, radius, focus)
}

/// Summed radiance, and the mean square of the horizontal distance from the centre, in pixels.
fn moments(film: &Film) -> (f64, f64) {
    let (mut sum, mut square) = (0.0, 0.0);
    for y in 0..film.height {
        for x in 0..film.width {
            let value = film.mean(x, y)[0] as f64;
            let offset = x as f64 + 0.5 - film.width as f64 / 2.0;
            sum += value;
            square += value * offset * offset;
        }
    }
    (sum, square / sum)
}

#[test]
fn a_point_out_of_focus_becomes_the_disk_of_confusion() {
    let pixel = 2.0 * (FOV.to_radians() / 2.0).tan() / PIXELS as f64;
    let settings = small(PIXELS, PIXELS, 4096);
    let (sharp_sum, _) = moments(&render(&lamp(0.05, 0.0, 1.0, PixelFilter::Box), &settings).film);
    for (radius, focus) in [(0.3, 5.0), (0.2, 20.0), (0.5, 6.5)] {
        let (sum, square) = moments(&render(&lamp(0.05, radius, focus, PixelFilter::Box), &settings).film);
        // A point at depth z is spread over a disk of radius R |1/f - 1/z| on a film at distance 1. The mean squares of one
        // coordinate add up: a quarter of the disk's squared radius, a third of the emitter's squared half side, and a
        // twelfth because pixels stand for their centres.
        let disk = radius * (1.0 / focus - 1.0 / 8.0f64).abs() / pixel;
        let half_side = 0.05 / 8.0 / pixel;
        let wanted = disk * disk / 4.0 + half_side * half_side / 3.0 + 1.0 / 12.0;
        assert!(
            (square / wanted - 1.0).abs() < 0.035,
            "R {radius}, focus {focus}: {square} for {wanted} square pixels"
        );
        assert!((sum / sharp_sum - 1.0).abs() < 0.035, "R {radius}, focus {focus}: {sum} for {sharp_sum}");
    }
}

#[test]
fn filters_weigh_an_edge_by_their_distribution() {
    // The left half of the picture glows; the edge runs between two columns of pixels.
    for (filter, share) in [(PixelFilter::Box, [1.0, 1.0, 0.0, 0.0]), (PixelFilter::Tent, [1.0, 0.875, 0.125, 0.0])] {
        let mut maker = Maker::default();
        let light = maker.diffuse([0.0; 3], [1.0; 3]);
        maker.quad([[-9.0, -9.0, 0.0], [0.0, -9.0, 0.0], [0.0, 9.0, 0.0], [-9.0, 9.0, 0.0]], light);
        maker.desc.filter = filter;
        let scene = maker.seen([0.0, 0.0, 8.0], [0.0; 3], FOV);
        let film = render(&scene, &small(16, 16, 4096)).film;
        for (column, wanted) in (6..10).zip(share) {
            let got = estimate(&film, column..column + 1, 0..16, 0);
            let what = format!("{filter:?}, column {column}: {} +- {}, {wanted} wanted", got.mean, got.error);
            assert!((got.mean - wanted).abs() <= 5.0 * got.error + 1e-9, "{what}");
        }
    }
}

#[test]
fn engines_agree_bit_for_bit_through_every_lens_and_filter() {
    for filter in [PixelFilter::Box, PixelFilter::Tent] {
        for aperture_radius in [0.0, 12.0] {
            let mut scene = Scene::load("scenes/cornell_mirror.toml").expect("a scene of ours");
            scene.desc.filter = filter;
            scene.desc.camera.aperture_radius = aperture_radius;
            scene.desc.camera.focus_distance = 1100.0;
            let scene = scene.prepare().expect("a scene of ours");
            let [packet, scalar] = [Engine::Packet, Engine::Scalar]
                .map(|engine| render(&scene, &Settings { engine, ..small(33, 31, 4) }).film);
            assert_eq!(first_difference(&packet, &scalar), None, "{filter:?}, aperture {aperture_radius}");
        }
    }
}
