//! The scenes of this repository, those made in code, and (where they are at hand) files that others wrote.

use super::common::front;
use glam::DVec3;
use octray::scene::SceneDesc;
use octray::scene::desc::Scattering;
use octray::scene::{is_degenerate, validate};
use std::path::{Path, PathBuf};

fn shipped(name: &str) -> SceneDesc {
    let scene = SceneDesc::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)).expect(name);
    assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
    scene
}

/// The triangles of a material.
fn of<'a>(scene: &'a SceneDesc, name: &'a str) -> impl Iterator<Item = usize> + 'a {
    let has = move |&i: &usize| scene.materials[scene.geometry().triangles[i].material as usize].name == name;
    (0..scene.geometry().triangles.len()).filter(has)
}

/// Six times the volume that the fronts of a material's triangles enclose: positive if they face outwards.
fn volume(scene: &SceneDesc, name: &str) -> f64 {
    let corner = |i: usize| DVec3::from(scene.geometry().vertices(i)[0].map(f64::from));
    of(scene, name).map(|i| corner(i).dot(front(scene, i))).sum()
}

#[test]
fn every_shipped_scene_loads() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the scenes folder").flatten() {
        if entry.path().extension().is_some_and(|e| e == "toml") {
            shipped(entry.path().file_name().and_then(|n| n.to_str()).expect("a name"));
            count += 1;
        }
    }
    assert!(count >= 4);
}

#[test]
fn cornell_is_the_published_box() {
    for name in ["cornell.toml", "cornell_mirror.toml"] {
        let scene = shipped(name);
        assert_eq!((scene.geometry().triangles.len(), scene.film, scene.render.spp), (38, (512, 512), Some(64)));
        let lamp: Vec<_> = of(&scene, "lamp").map(|i| front(&scene, i)).collect();
        assert!(lamp.len() == 2 && lamp.iter().all(|n| n.y < 0.0 && n.x == 0.0 && n.z == 0.0), "{lamp:?}");
        assert_eq!(lamp.iter().map(|n| -0.5 * n.y).sum::<f64>(), 130.0 * 105.0);
        let fov = 2.0 * (0.0125f64 / 0.035).atan().to_degrees();
        assert!((scene.camera.vertical_fov - fov).abs() < 1e-5);
        // The blocks' fronts face outwards (their bottoms, on the floor at y = 0, are not there and add nothing).
        assert!(volume(&scene, "tall_block") > 0.0 && volume(&scene, "short_block") > 0.0);
        let tall = scene.materials.iter().find(|m| m.name == "tall_block").unwrap();
        assert_eq!(matches!(tall.scattering, Scattering::Mirror { .. }), name == "cornell_mirror.toml");
    }
}

#[test]
fn the_furnace_is_closed_and_shines_inwards() {
    let scene = shipped("furnace.toml");
    assert_eq!((scene.geometry().triangles.len(), scene.geometry().positions.len()), (12, 8));
    assert_eq!(volume(&scene, "wall"), -6.0 * 8.0);
    let wall = &scene.materials[0];
    assert_eq!((wall.scattering, wall.emission), (Scattering::Diffuse { albedo: [0.5; 3] }, [0.5; 3]));
    assert!(scene.camera.position.iter().all(|x| x.abs() < 1.0), "the eye is inside");
}

#[test]
fn the_lecture_scene_has_its_two_lights() {
    let scene = shipped("lecture_lights.toml");
    assert_eq!((scene.geometry().triangles.len(), of(&scene, "clay").count()), (8_006, 8_000));
    let knot = DVec3::new(0.0, 1.12, 0.0);
    for (name, direction) in [("blue", DVec3::X), ("grey", -DVec3::Y)] {
        for i in of(&scene, name) {
            let corner = DVec3::from(scene.geometry().vertices(i)[0].map(f64::from));
            assert!(front(&scene, i).normalize().dot(direction) > 0.999, "{name}");
            assert!(front(&scene, i).dot(knot - corner) > 0.0, "{name} faces the model");
        }
    }
    assert!(volume(&scene, "clay") > 0.0);
    assert!(of(&scene, "clay").all(|i| scene.geometry().vertices(i).iter().all(|v| v[1] > 0.0)));
}

#[test]
fn the_principled_scene_has_its_grid() {
    let scene = shipped("principled.toml");
    assert_eq!(scene.geometry().triangles.len(), 3_848);
    for (row, wanted_metallic) in [0.0, 0.5, 1.0].into_iter().enumerate() {
        for (column, wanted_roughness) in [0.1, 0.3, 0.6, 1.0].into_iter().enumerate() {
            let name = format!("ball_{}{}", row + 1, column + 1);
            let ball = scene.materials.iter().find(|m| m.name == name).expect("a ball");
            let Scattering::Principled { base_color, metallic, roughness, ior } = ball.scattering else {
                panic!("{name}: {:?}", ball.scattering)
            };
            assert_eq!((metallic, roughness, ior), (wanted_metallic, wanted_roughness, 1.5), "{name}");
            assert_eq!(base_color, [0.9, 0.55, 0.25], "{name}");
            // From the top down, from the left.
            let points = of(&scene, &name).flat_map(|i| scene.geometry().vertices(i)).collect::<Vec<_>>();
            let middle = points.iter().fold(DVec3::ZERO, |sum, p| sum + DVec3::from(p.map(f64::from)));
            let middle = middle / points.len() as f64;
            let at = DVec3::new(1.05 * (column as f64 - 1.5), 2.46 - 1.05 * row as f64, 0.0);
            assert!(points.len() == 3 * 320 && (middle - at).length() < 1e-3, "{name} at {middle}");
            assert!(of(&scene, &name).all(|i| {
                let corner = DVec3::from(scene.geometry().vertices(i)[0].map(f64::from));
                front(&scene, i).dot(corner - middle) > 0.0
            }));
        }
    }
}

#[test]
fn heavy_has_the_triangles_it_promises() {
    for n in [2_000, 20_000, 100_001] {
        let scene = SceneDesc::load(format!("builtin:heavy:{n}")).unwrap();
        assert_eq!(scene.geometry().triangles.len(), n);
        assert!((0..n).all(|i| !is_degenerate(scene.geometry().vertices(i))));
        let lamps: Vec<_> = of(&scene, "lamp").collect();
        assert_eq!(lamps.len(), 50);
        assert!(lamps.iter().all(|&i| front(&scene, i).normalize().y == -1.0));
        for stone in ["sandstone", "slate", "chalk"] {
            assert!(volume(&scene, stone) > 0.0, "{stone} faces outwards");
        }
        assert!(of(&scene, "ground").all(|i| front(&scene, i).y > 0.0));
    }
    // The same bits on every machine: a digest of the small one, taken when the scene was made.
    let scene = SceneDesc::load("builtin:heavy:2000").unwrap();
    assert_eq!(digest(&scene), HEAVY_DIGEST, "builtin:heavy changed: old measurements no longer compare");
}

const HEAVY_DIGEST: u64 = 0xDC29_987A_AC13_1E61;

/// A number that changes with any bit of the vertices.
fn digest(scene: &SceneDesc) -> u64 {
    scene
        .geometry()
        .positions
        .iter()
        .flatten()
        .fold(0, |d, x| (d ^ u64::from(x.to_bits())).wrapping_mul(0x100_0000_01B3))
}

#[test]
fn the_lamp_hall_has_its_lamps_each_on_a_wall_and_none_over_another() {
    for n in [100, 2_000, 12_345] {
        let scene = SceneDesc::load(format!("builtin:lamp_hall:{n}")).unwrap();
        let shines = |i: &usize| scene.materials[scene.geometry().triangles[*i].material as usize].emission != [0.0; 3];
        let corners = |i: usize| scene.geometry().vertices(i).map(|v| DVec3::from(v.map(f64::from)));
        let (lamps, walls): (Vec<_>, Vec<_>) = (0..scene.geometry().triangles.len()).partition(shines);
        assert_eq!(lamps.len(), 2 * n);
        assert!((0..scene.geometry().triangles.len()).all(|i| !is_degenerate(scene.geometry().vertices(i))));
        assert!(volume(&scene, "clay") > 0.0, "the stones face outwards");
        // Each lamp lies just in front of a wall, floor, ceiling or pillar that faces the same way.
        for &lamp in &lamps {
            let (normal, middle) = (front(&scene, lamp).normalize(), corners(lamp).iter().sum::<DVec3>() / 3.0);
            let carries = |&wall: &usize| {
                let (facing, points) = (front(&scene, wall).normalize(), corners(wall));
                let gap = (middle - points[0]).dot(facing);
                let inside =
                    (0..3).all(|k| (points[(k + 1) % 3] - points[k]).cross(middle - points[k]).dot(facing) >= -1e-6);
                facing.dot(normal) > 0.9999 && (0.01..0.03).contains(&gap) && inside
            };
            assert!(walls.iter().any(carries), "lamp triangle {lamp} at {middle} shines from nowhere");
        }
        // Lamps of one wall share a plane: two triangles of different lamps must not overlap. Their boxes do not.
        let mut boxes: Vec<(DVec3, DVec3)> = (lamps.chunks_exact(2))
            .map(|pair| {
                let points = pair.iter().flat_map(|&i| corners(i));
                points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
            })
            .collect();
        boxes.sort_by(|a, b| a.0.z.total_cmp(&b.0.z));
        for (i, a) in boxes.iter().enumerate() {
            let reach = boxes[i + 1..].iter().take_while(|b| b.0.z <= a.1.z);
            assert!(reach.into_iter().all(|b| !(b.0.cmple(a.1) & a.0.cmple(b.1)).all()), "lamps overlap: {a:?}");
        }
    }
    let scene = SceneDesc::load("builtin:lamp_hall").unwrap();
    assert_eq!(digest(&scene), LAMP_HALL_DIGEST, "builtin:lamp_hall changed: old measurements no longer compare");
}

const LAMP_HALL_DIGEST: u64 = 0xF244_F27A_460D_E47D;

/// What the rooms are is tested in `hidden_lights`.
#[test]
fn the_rooms_are_the_same_on_every_machine() {
    let scene = SceneDesc::load("builtin:rooms").unwrap();
    assert_eq!(scene.geometry().triangles.len(), 18_048);
    assert!((0..18_048).all(|i| !is_degenerate(scene.geometry().vertices(i))));
    assert!(["clay", "glazed", "bronze"].iter().all(|ball| volume(&scene, ball) > 0.0), "the balls face outwards");
    assert_eq!(digest(&scene), ROOMS_DIGEST, "builtin:rooms changed: old measurements no longer compare");
}

const ROOMS_DIGEST: u64 = 0xE121_CF76_52C2_2B2D;

#[test]
fn unknown_builtins_name_the_known() {
    for name in [
        "builtin:",
        "builtin:hevy",
        "builtin:heavy:x",
        "builtin:heavy:1",
        "builtin:heavy:99999999999",
        "builtin:lamp_hall:9",
        "builtin:rooms:0",
        "builtin:rooms:101",
    ] {
        let error = SceneDesc::load(name).unwrap_err();
        let message = error.to_string();
        assert!(
            error.exit_status() == 2
                && message.starts_with(name)
                && ["heavy", "lamps", "number of rooms"].iter().any(|word| message.contains(word)),
            "{message}"
        );
    }
}

/// A folder of files that others wrote; it lies beside the repository on some machines only.
fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(folder);
    if !path.is_dir() {
        eprintln!("skipped: {} is not on this machine", path.display());
        return None;
    }
    Some(path)
}

fn objs(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten().map(|e| e.path());
    let mut objs: Vec<_> = entries.filter(|p| p.extension().is_some_and(|e| e == "obj")).collect();
    objs.sort();
    objs
}

#[test]
fn bad_objs_end_in_one_error_or_a_sound_scene() {
    let Some(folder) = shared("bad-obj") else { return };
    /// File, and its triangles or a part of its error.
    const EXPECTED: &[(&str, Result<usize, &str>)] = &[
        ("invalid-relative-texture-index.obj", Err(":2: face corner `1/-1`")),
        ("invalid-relative-vertex-index.obj", Err(":1: face corner `-4`")),
        ("issue-140-zero-face-idx.obj", Err(":16: face corner `0/0/0`")),
        ("invalid_index.obj", Err(":12: face corner `7`")),
        ("test-nan.obj", Err(":12: `nan`")),
        ("invalid-face-definition.obj", Err("no triangles")),
        ("lines.obj", Err("no triangles")),
        ("line-prim.obj", Err("no triangles")),
        ("points-prim.obj", Err("no triangles")),
        ("issue-356-leading-spaces-newmtl.obj", Err("no triangles")),
        ("missing_material_file.obj", Ok(36)),
        ("mtl filename with whitespace issue46.obj", Ok(12)),
        ("issue-161-inconsistent-f.obj", Ok(12)),
        ("issue-295-trianguation-failure.obj", Ok(28)),
        ("issue-319-002.obj", Ok(14)),
        ("issue-330.obj", Ok(3)),
        ("cube-vertex-w-component.obj", Ok(12)),
    ];
    let (mut seen, mut expected) = (0, 0);
    for path in ["tinyobjloader", "tobj"].iter().flat_map(|f| objs(&folder.join(f))) {
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let outcome = SceneDesc::load(&path).map_err(|e| e.to_string());
        seen += 1;
        match &outcome {
            Ok(scene) => {
                validate::check(scene).expect(name);
            }
            Err(message) => assert_eq!(message.lines().count(), 1, "{message}"),
        }
        if let Some((_, wanted)) = EXPECTED.iter().find(|(file, _)| *file == name) {
            expected += 1;
            match (wanted, &outcome) {
                (Ok(count), Ok(scene)) => assert_eq!(scene.geometry().triangles.len(), *count, "{name}"),
                (Err(part), Err(message)) => assert!(message.contains(part), "{message}"),
                _ => panic!("{name}: wanted {wanted:?}, got {:?}", outcome.map(|s| s.geometry().triangles.len())),
            }
        }
    }
    assert!(seen > 30 && expected == EXPECTED.len(), "{seen} files, {expected} of {} known ones", EXPECTED.len());
}

#[test]
fn real_scenes_have_the_counts_their_list_names() {
    let Some(folder) = shared("obj") else { return };
    let counts = [
        ("cornell/CornellBox-Original.obj", 36, 2),
        ("cornell/CornellBox-Empty-CO.obj", 12, 2),
        ("cornell/CornellBox-Empty-White.obj", 12, 2),
        ("cornell/CornellBox-Sphere.obj", 2188, 2),
        ("cornell/CornellBox-Glossy.obj", 1112, 2),
        ("cornell-bitterli/bitterli-cornell-box.obj", 36, 2),
        ("meshes/spot_triangulated.obj", 5856, 0),
        ("meshes/teapot.obj", 6320, 0),
        ("meshes/suzanne.obj", 968, 0),
    ];
    for (name, triangles, lights) in counts {
        let scene = SceneDesc::load(folder.join(name)).expect(name);
        let emits = |i: &usize| scene.materials[scene.geometry().triangles[*i].material as usize].emission != [0.0; 3];
        let lamps: Vec<_> = (0..scene.geometry().triangles.len()).filter(emits).collect();
        assert_eq!((scene.geometry().triangles.len(), lamps.len()), (triangles, lights), "{name}");
        assert!(lamps.iter().all(|&i| front(&scene, i).y < 0.0), "{name}: its lamp shines down");
    }
}
