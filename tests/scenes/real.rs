//! Scenes that nobody in this project made. They are not part of the repository: tests look for them beside it, in
//! `../shared/scenes`, and say so where they are not there.

use crate::common::{estimate, first_difference, small};
use octray::scene::desc::CameraDesc;
use octray::{Engine, Film, PreparedScene, Scene, Settings, render};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The path of a shared scene, or `None` and a word about it.
fn shared(path: &str) -> Option<PathBuf> {
    let full = Path::new("../shared/scenes").join(path);
    if !full.exists() {
        println!("skipped: {} is not there", full.display());
        return None;
    }
    Some(full)
}

/// An OBJ seen by a pinhole camera.
fn seen(obj: &Path, position: [f64; 3], look_at: [f64; 3], up: [f64; 3], vertical_fov: f64) -> PreparedScene {
    let mut scene = Scene::from_obj(obj).unwrap_or_else(|error| panic!("{error}"));
    scene.desc.camera = CameraDesc { position, look_at, up, vertical_fov, ..CameraDesc::default() };
    scene.prepare().unwrap_or_else(|error| panic!("{error}"))
}

const UP: [f64; 3] = [0.0, 1.0, 0.0];

/// A render without a sample that is not finite.
fn sane(scene: &PreparedScene, settings: &Settings) -> Film {
    let render = render(scene, settings);
    assert_eq!(render.stats.nonfinite, 0, "{}: {:?}", scene.name, render.stats.nonfinite_samples);
    render.film
}

/// Both engines, the same bits.
fn assert_engines_agree(scene: &PreparedScene, settings: &Settings) {
    let packet = sane(scene, settings);
    let scalar = sane(scene, &Settings { engine: Engine::Scalar, ..settings.clone() });
    assert_eq!(first_difference(&packet, &scalar), None, "{}", scene.name);
}

/// The mean of the whole converged picture is known (65 bounces, by another renderer, to 5 digits).
#[test]
fn the_mean_of_bitterlis_cornell_box() {
    let Some(obj) = shared("obj/cornell-bitterli/bitterli-cornell-box.obj") else { return };
    let scene = seen(&obj, [0.0, 1.0, 6.8], [0.0, 1.0, 0.0], UP, 19.5);
    assert_eq!(scene.warnings, [""; 0]);
    let film = sane(&scene, &Settings { threads: 0, ..small(256, 256, 160) });
    for (channel, truth) in [0.19625, 0.12753, 0.03610].into_iter().enumerate() {
        let got = estimate(&film, 0..256, 0..256, channel);
        println!("channel {channel}: {} +- {}, truth {truth}", got.mean, got.error);
        assert!(got.error < 8e-4 * truth, "channel {channel}: {} is too noisy to prove anything", got.error);
        assert!((got.mean - truth).abs() < 3e-3 * truth, "channel {channel}: {} +- {}", got.mean, got.error);
    }
}

/// McGuire's boxes: the means of our own converged pictures, to 3 %, so that nothing is lost or doubled unseen.
#[test]
fn mcguires_boxes_are_finite_and_as_bright_as_ever() {
    let boxes = [
        ("Original", 1.0, Some([0.1946, 0.1264, 0.0357])),
        ("Empty-CO", 1.0, Some([0.1738, 0.1424, 0.1309])),
        ("Empty-White", 1.0, Some([0.4377; 3])),
        ("Sphere", 0.8, None),
        ("Glossy", 0.8, None),
    ];
    for (name, height, means) in boxes {
        let Some(obj) = shared(&format!("obj/cornell/CornellBox-{name}.obj")) else { return };
        let scene = seen(&obj, [0.0, height, 6.8], [0.0, height, 0.0], UP, 19.5);
        // The bottoms of its boxes name the corners of other faces, which then are in the file twice.
        let doubled = usize::from(name == "Original");
        assert_eq!(
            scene.warnings.iter().filter(|warning| warning.contains("4 triangles were dropped")).count(),
            doubled
        );
        assert_eq!(scene.warnings.len(), doubled, "{name}: {:?}", scene.warnings);
        let film = sane(&scene, &small(96, 96, 64));
        let got = film.mean_radiance();
        // Materials of the other two come one by one: until then only what cannot change is asked.
        let expected = |c: usize| means.map_or(got[c] > 0.005 && got[c] < 1.0, |m| (got[c] / m[c] - 1.0).abs() < 0.03);
        assert!((0..3).all(expected), "{name}: {got:?}, expected {means:?}");
        if name == "Empty-White" {
            let grey = |p: &octray::internal::film::Pixel| p.sum[0] == p.sum[1] && p.sum[1] == p.sum[2];
            assert!(film.pixels.iter().all(grey), "every channel goes through the same operations");
        }
        assert_engines_agree(&scene, &small(24, 24, 2));
    }
}

/// Meshes without lights, under a white sky: at most as bright as the sky, and no mesh is a black hole.
#[test]
fn scanned_and_modelled_meshes_under_a_white_sky() {
    let meshes = [
        ("obj/meshes/spot_triangulated.obj", [0.0, 0.108, 4.71], [0.0, 0.108, 0.19]),
        ("obj/meshes/teapot.obj", [0.217, 1.57, 14.3], [0.217, 1.57, 0.0]),
        ("obj/meshes/suzanne.obj", [-2.49, 1.25, 10.7], [-2.49, 1.25, 4.1]),
        ("noncommercial/stanford-bunny.obj", [-0.017, 0.11, 0.435], [-0.017, 0.11, -0.002]),
    ];
    for (path, position, look_at) in meshes {
        let Some(obj) = shared(path) else { return };
        let scene = seen(&obj, position, look_at, UP, 35.0);
        let film = sane(&scene, &small(64, 64, 16));
        for (i, pixel) in film.pixels.iter().enumerate() {
            let mean = pixel.sum[0] / 16.0;
            // A pit may be dark; a pixel below a twentieth of the sky would be acne on these meshes.
            assert!(mean > 0.05 && mean < 1.0 + 1e-5, "{path}: {mean} in pixel {},{}", i % 64, i / 64);
        }
        assert_engines_agree(&scene, &small(24, 24, 2));
    }
}

/// Whatever is odd about an OBJ: a picture without a sample that is not finite, or one error that says what to do.
#[test]
fn odd_objs_end_in_a_picture_or_in_one_clear_error() {
    let Some(folder) = shared("bad-obj") else { return };
    let (mut pictures, mut errors) = (0, 0);
    for set in ["tinyobjloader", "tobj"] {
        let entries = std::fs::read_dir(folder.join(set)).unwrap_or_else(|error| panic!("{set}: {error}"));
        for path in entries.filter_map(|entry| entry.ok()).map(|entry| entry.path()) {
            if path.extension().is_none_or(|e| e != "obj") {
                continue;
            }
            match Scene::load(&path).and_then(|scene| scene.prepare()) {
                Ok(scene) => {
                    assert_engines_agree(&scene, &small(8, 8, 1));
                    pictures += 1;
                }
                Err(error) => {
                    let message = error.to_string();
                    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    assert!(
                        message.contains(&file) && !message.contains('\n') && error.exit_status() == 2,
                        "{message}"
                    );
                    errors += 1;
                }
            }
        }
    }
    println!("{pictures} pictures, {errors} errors");
    assert!(pictures >= 25 && errors >= 5, "{pictures} pictures, {errors} errors");
}

/// Unpacks a shared archive, if it is there and `tar` can.
fn unpacked(archive: &str) -> Option<tempfile::TempDir> {
    let archive = shared(archive)?;
    let folder = tempfile::tempdir().ok()?;
    let done = Command::new("tar").arg("xJf").arg(&archive).arg("-C").arg(folder.path()).status();
    match done {
        Ok(status) if status.success() => Some(folder),
        other => {
            println!("skipped: tar cannot unpack {}: {other:?}", archive.display());
            None
        }
    }
}

/// Rays that hit again the triangle they have just left: what acne and leaks are made of.
fn false_hits(scene: &PreparedScene, settings: &Settings) -> (u64, u64) {
    let setup = octray::internal::setup::Setup::new(scene, settings);
    let (mut bounces, mut again) = (0, 0);
    for pixel in (0..setup.frame.film.0 * setup.frame.film.1).map(|i| (i % setup.frame.film.0, i / setup.frame.film.0))
    {
        let mut last = u32::MAX;
        octray::internal::reference::single::path::trace_path(
            &setup,
            pixel,
            0,
            &mut |vertex: octray::internal::trace::TraceVertex| {
                if vertex.event == "hit" {
                    bounces += 1;
                    again += (vertex.triangle == last) as u64;
                    last = vertex.triangle;
                }
            },
        );
    }
    (again, bounces)
}

#[test]
#[ignore = "unpacks 8 MB and takes seconds: cargo test --release --test scenes real -- --ignored"]
fn sponza() {
    let Some(folder) = unpacked("noncommercial/dabrovic-sponza.tar.xz") else { return };
    let obj = folder.path().join("dabrovic-sponza/dabrovic-sponza.obj");
    let (eye, at) = ([2.25067, 8.24132, -0.04925], [3.15037, 7.8048, -0.05018]);
    assert_interior(&seen(&obj, eye, at, [0.4365, 0.8997, -0.0029], 64.596), 96, 54);
}

#[test]
#[ignore = "unpacks 32 MB and takes seconds: cargo test --release --test scenes real -- --ignored"]
fn the_wooden_staircase() {
    let Some(folder) = unpacked("obj/wooden-staircase.tar.xz") else { return };
    let obj = folder.path().join("wooden-staircase/wooden-staircase.obj");
    let (eye, at) = ([0.03242, 1.52673, 4.88197], [0.02477, 1.57179, 3.88301]);
    assert_interior(&seen(&obj, eye, at, [0.00034, 0.99898, 0.04505], 58.544), 54, 96);
}

fn assert_interior(scene: &PreparedScene, width: u32, height: u32) {
    let settings = Settings { max_depth: Some(16), ..small(width, height, 4) };
    let film = sane(scene, &settings);
    assert!(film.mean_radiance().iter().all(|&mean| mean > 0.1 && mean < 20.0), "{:?}", film.mean_radiance());
    assert_engines_agree(scene, &Settings { max_depth: Some(16), ..small(16, 16, 1) });
    let bsdf = Settings { strategy: octray::Strategy::Bsdf, rr_depth: None, ..settings };
    let (again, bounces) = false_hits(scene, &bsdf);
    println!("{}: {again} of {bounces} rays hit the triangle they had left", scene.name);
    // Slivers of an aspect beyond 2,000 are out of f32's reach; both buildings have some.
    assert!(again as f64 <= 1e-4 * bounces as f64, "{again} of {bounces}");
}

/// The glTF scenes: both engines see the same, something is there, and the truck keeps its textures and instances.
#[test]
fn gltf_scenes_render_alike_in_both_engines() {
    for name in ["Box", "BoxTextured", "BoxVertexColors", "CesiumMilkTruck"] {
        let Some(path) = shared(&format!("gltf/{name}.glb")) else { return };
        let mut scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        scene.desc.film = (48, 48);
        let (meshes, instances) = (scene.desc.meshes.len(), scene.desc.instances.len());
        match name {
            // Wheels are one mesh at two nodes.
            "CesiumMilkTruck" => assert_eq!((meshes, instances, scene.desc.textures.len()), (4, 5, 1)),
            _ => assert_eq!(scene.desc.geometry().triangles.len(), 12, "{name}"),
        }
        let prepared = scene.prepare().unwrap_or_else(|error| panic!("{error}"));
        assert_engines_agree(&prepared, &Settings { spp: 4, max_depth: Some(6), ..scene.settings() });
    }
}
