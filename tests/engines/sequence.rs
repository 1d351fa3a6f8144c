//! Frames that learn from those before them: the same bits in both engines, for any number of threads, and whether a frame is
//! rendered alone, in order or out of it; learning leaves no trace in the mean.

use crate::common::{first_difference, prepared, small};
use octray::internal::film::Film;
use octray::scene::camera::{CameraKey, CameraPath};
use octray::{Engine, Guide, Lights, PreparedScene, Roulette, Sequence, Settings, Train};

/// Half a second from the scene's own camera to a place beside it.
fn path(scene: &PreparedScene) -> CameraPath {
    let mut aside = scene.camera;
    let across = (scene.camera.look_at[2] - scene.camera.position[2]).abs();
    aside.position[0] += 0.05 * across;
    let key = |time, camera| CameraKey { time, camera };
    CameraPath::new(vec![key(0.0, scene.camera), key(0.5, aside)]).unwrap()
}

fn sequence(scene: &PreparedScene, train_frames: u32) -> Sequence<'_> {
    Sequence::new(scene, path(scene), 8.0, train_frames)
}

/// Small frames that learn all there is.
fn learning(paths: u32) -> Settings {
    let (guide, roulette, train) = (Guide::On, Roulette::Learned, Train::Paths(paths));
    Settings { guide, roulette, train, max_depth: Some(6), ..small(20, 16, 4) }
}

fn frame(sequence: &mut Sequence, frame: u32, settings: &Settings) -> Film {
    let render = sequence.render(frame, settings, None, &|_| true);
    let learned = render.stats.learning.expect("something is learned");
    assert!(learned.guide.is_some_and(|guide| guide.used));
    render.film
}

#[test]
fn frames_are_the_same_in_both_engines_alone_and_in_any_order() {
    for name in ["scenes/glass.toml", "scenes/door_ajar.toml", "scenes/glossy_plates.toml", "builtin:rooms"] {
        let scene = prepared(name);
        for roulette in [Roulette::Learned, Roulette::Throughput] {
            let packet = Settings { roulette, ..learning(16_384) };
            let mut in_order = sequence(&scene, 4);
            let frames: Vec<Film> = (0..4).map(|at| frame(&mut in_order, at, &packet)).collect();
            let scalar = Settings { engine: Engine::Scalar, threads: 3, ..packet.clone() };
            let mut other = sequence(&scene, 4);
            for at in [3, 0] {
                let alone = frame(&mut other, at, &scalar);
                assert_eq!(first_difference(&frames[at as usize], &alone), None, "{name} {roulette}, frame {at}");
            }
        }
    }
}

#[test]
fn what_was_recorded_for_other_settings_is_not_used() {
    let scene = prepared("scenes/cornell.toml");
    let mut shared = sequence(&scene, 3);
    let base = learning(8192);
    let first = frame(&mut shared, 1, &base);
    for other in [
        Settings { seed: 5, ..base.clone() },
        Settings { max_depth: Some(3), ..base.clone() },
        Settings { width: Some(17), ..base.clone() },
        Settings { train: Train::Paths(4096), ..base.clone() },
        Settings { lights: Lights::Power, ..base.clone() },
    ] {
        let alone = frame(&mut sequence(&scene, 3), 1, &other);
        assert_eq!(first_difference(&frame(&mut shared, 1, &other), &alone), None);
    }
    // The number of samples has no say in what is recorded; a longer window has.
    frame(&mut shared, 1, &Settings { spp: 8, ..base.clone() });
    assert_eq!(first_difference(&frame(&mut shared, 1, &base), &first), None);
    assert!(first_difference(&frame(&mut sequence(&scene, 4), 1, &base), &first).is_some());
}

/// Two means over 200 frames each, by quarters of the film: z below 4.5 for each of four, 3e-5 for all (Sidak).
#[test]
fn sharing_leaves_the_mean_alone() {
    let scene = prepared("scenes/glass.toml");
    let still = |train_frames| Sequence::new(&scene, CameraPath::default(), 24.0, train_frames);
    let (mut shared, mut plain) = (still(8), still(1));
    let learning = Settings { spp: 8, ..learning(8192) };
    let without =
        Settings { guide: Guide::Off, roulette: Roulette::Throughput, lights: Lights::Tree, ..learning.clone() };
    let quarters = |film: &Film| -> [f64; 4] {
        std::array::from_fn(|quarter| {
            let (x0, y0) = (quarter as u32 % 2 * 10, quarter as u32 / 2 * 8);
            let pixels = (y0..y0 + 8).flat_map(|y| (x0..x0 + 10).map(move |x| (x, y)));
            pixels.map(|(x, y)| film.mean(x, y).iter().map(|&c| f64::from(c)).sum::<f64>()).sum()
        })
    };
    let runs = |sequence: &mut Sequence, settings: &Settings| -> Vec<[f64; 4]> {
        (0..200).map(|at| quarters(&sequence.render(at, settings, None, &|_| true).film)).collect()
    };
    let (shared, plain) = (runs(&mut shared, &learning), runs(&mut plain, &without));
    for quarter in 0..4 {
        let moments = |runs: &[[f64; 4]]| {
            let n = runs.len() as f64;
            let mean = runs.iter().map(|run| run[quarter]).sum::<f64>() / n;
            let squares = runs.iter().map(|run| (run[quarter] - mean).powi(2)).sum::<f64>();
            (mean, squares / (n - 1.0) / n)
        };
        let ((a, a_square), (b, b_square)) = (moments(&shared), moments(&plain));
        let z = (a - b) / (a_square + b_square).sqrt();
        assert!(z.abs() < 4.5, "quarter {quarter}: {a} {b}, z {z}");
    }
}
