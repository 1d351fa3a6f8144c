//! Descriptions that a program has changed: what breaks a rule ends in one error that says what and where, never in a panic.

use octray::scene::desc::{
    CornerDesc, EnvironmentDesc, InstanceDesc, MapDesc, MaskDesc, Scattering, SceneDesc, TextureDesc, TextureUse,
};
use octray::scene::transform::Transform;
use octray::scene::{builtin, validate};
use octray::{Error, PreparedScene};
use proptest::prelude::*;

/// A small hall with a texture, a mask and corners, so that every rule has something to break.
fn sound() -> SceneDesc {
    let mut scene = builtin::build("lamp_hall:100").expect("a builtin scene");
    let texels = vec![[128; 3]; 6];
    scene.textures.push(TextureDesc { name: "tiles.png".into(), width: 3, height: 2, texels });
    scene.masks.push(MaskDesc { name: "leaf.png".into(), width: 1, height: 2, texels: vec![255, 0] });
    let mesh = &mut scene.meshes[0];
    mesh.corners = vec![CornerDesc::default(); mesh.triangles.len()];
    let used = TextureUse { texture: 0, scale: [1.0; 2], offset: [0.0; 2] };
    (scene.materials[0].texture, scene.materials[0].alpha_mask) = (Some(used), Some(used));
    scene
}

/// The message that preparing `sound` with `change` ends in.
fn refused(change: impl FnOnce(&mut SceneDesc)) -> String {
    let mut scene = sound();
    change(&mut scene);
    let from_gate = validate::check(&scene).expect_err("a broken rule").to_string();
    match PreparedScene::new(&scene) {
        Err(error @ Error::Scene { .. }) => {
            assert_eq!((error.exit_status(), error.to_string()), (2, from_gate));
            error.to_string()
        }
        Err(error) => panic!("not an error of the scene: {error}"),
        Ok(_) => panic!("accepted"),
    }
}

/// Asserts that the change is refused with a message that has all these words.
fn breaks(words: &[&str], change: impl FnOnce(&mut SceneDesc)) {
    let message = refused(change);
    assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    assert!(message.starts_with("builtin:lamp_hall:100: ") && message.lines().count() == 1, "{message}");
}

#[test]
fn the_scene_that_is_broken_below_is_sound() {
    assert!(PreparedScene::new(&sound()).is_ok());
}

#[test]
fn bad_triangles_are_named() {
    breaks(&["triangle 5", "vertex 4000000000"], |s| s.meshes[0].triangles[5].vertices[2] = 4_000_000_000);
    breaks(&["triangle 7", "material 99"], |s| s.meshes[0].triangles[7].material = 99);
    breaks(&["triangle 0", "material 0", "0 materials"], |s| s.materials.clear());
    breaks(&["triangle 0", "0 vertices"], |s| s.meshes[0].positions.clear());
    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        breaks(&["vertex 3", "not finite"], |s| s.meshes[0].positions[3][1] = x);
    }
}

#[test]
fn bad_corners_are_named() {
    breaks(&["corners", "entry a triangle"], |s| s.meshes[0].corners.truncate(2));
    for n in [[0.5, 0.0, 0.0], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
        breaks(&["triangle 4", "normals"], |s| s.meshes[0].corners[4].normals[1] = n);
    }
    for u in [f32::NAN, 1e8, f32::NEG_INFINITY] {
        breaks(&["triangle 6", "texture coordinates"], |s| s.meshes[0].corners[6].uvs[2][0] = u);
    }
}

#[test]
fn bad_images_are_named() {
    breaks(&["texture `tiles.png`", "3 x 2", "5 texels"], |s| s.textures[0].texels.truncate(5));
    breaks(&["texture `tiles.png`", "0 x 2"], |s| s.textures[0].width = 0);
    breaks(&["mask `leaf.png`", "1 x 4294967295"], |s| s.masks[0].height = u32::MAX);
    breaks(&["mask `leaf.png`", "0 texels"], |s| s.masks[0].texels.clear());
}

#[test]
fn bad_materials_are_named() {
    let name = sound().materials[0].name.clone();
    let named = format!("material 0 `{name}`");
    let with = |words: &[&str], change: &dyn Fn(&mut SceneDesc)| {
        breaks(&[&[named.as_str()], words].concat(), change);
    };
    let used = TextureUse { texture: 0, scale: [1.0; 2], offset: [0.0; 2] };
    let missing = Some(TextureUse { texture: 1, ..used });
    with(&["its texture is number 1", "has 1"], &|s| s.materials[0].texture = missing);
    with(&["its emission texture is number 1"], &|s| s.materials[0].emission_texture = missing);
    with(&["its alpha mask is number 1"], &|s| s.materials[0].alpha_mask = missing);
    with(&["its alpha mask is number 0", "has 0"], &|s| s.masks.clear());
    for scale in [[f64::NAN, 1.0], [1e7, 1.0], [1.0, f64::INFINITY]] {
        with(&["its texture", "scaled"], &|s| s.materials[0].texture = Some(TextureUse { scale, ..used }));
        with(&["its texture", "scaled"], &|s| s.materials[0].texture = Some(TextureUse { offset: scale, ..used }));
    }
    for x in [f64::NAN, -1.0, f64::INFINITY, 1e39] {
        with(&["emission"], &|s| s.materials[0].emission[1] = x);
        let triple = [0.5, x, 0.5];
        let scatterings = [
            ("albedo", Scattering::Diffuse { albedo: triple }),
            ("reflectance", Scattering::Mirror { reflectance: triple }),
            ("alpha", Scattering::Conductor { alpha: x, reflectance: [0.5; 3], complex_ior: None }),
            ("eta", Scattering::Conductor { alpha: 0.1, reflectance: [0.5; 3], complex_ior: Some((triple, [1.0; 3])) }),
            ("k", Scattering::Conductor { alpha: 0.1, reflectance: [0.5; 3], complex_ior: Some(([1.0; 3], triple)) }),
            ("ior", Scattering::Dielectric { ior: x, transmittance: [1.0; 3] }),
            ("transmittance", Scattering::Dielectric { ior: 1.5, transmittance: triple }),
            ("ior", Scattering::Plastic { albedo: [0.5; 3], ior: x, alpha: 0.1 }),
            ("alpha", Scattering::Plastic { albedo: [0.5; 3], ior: 1.5, alpha: x }),
            ("base_color", Scattering::Principled { base_color: triple, metallic: 0.5, roughness: 0.5, ior: 1.5 }),
            ("metallic", Scattering::Principled { base_color: [0.5; 3], metallic: x, roughness: 0.5, ior: 1.5 }),
            ("roughness", Scattering::Principled { base_color: [0.5; 3], metallic: 0.5, roughness: x, ior: 1.5 }),
            ("ior", Scattering::Principled { base_color: [0.5; 3], metallic: 0.5, roughness: 0.5, ior: x }),
        ];
        for (word, scattering) in scatterings {
            with(&[word], &|s| s.materials[0].scattering = scattering);
        }
    }
}

#[test]
fn bad_views_are_named() {
    for x in [f64::NAN, f64::INFINITY, 1e300] {
        breaks(&["camera: position"], |s| s.camera.position[0] = x);
        breaks(&["camera: position, look_at and up"], |s| s.camera.up[2] = x);
        breaks(&["camera: vertical_fov"], |s| s.camera.vertical_fov = x);
        breaks(&["camera: aperture_radius"], |s| s.camera.aperture_radius = x);
        breaks(&["camera: focus_distance"], |s| s.camera.focus_distance = x);
    }
    breaks(&["camera:", "same point"], |s| s.camera.look_at = s.camera.position);
    breaks(&["film", "0 x"], |s| s.film.0 = 0);
    breaks(&["film", "x 70000"], |s| s.film.1 = 70_000);
    breaks(&["render: spp"], |s| s.render.spp = Some(0));
}

#[test]
fn bad_environments_are_named() {
    let with = |map: MapDesc| Some(EnvironmentDesc::Map(map));
    let sky =
        || MapDesc { file: "sky.exr".into(), width: 2, height: 1, texels: vec![[1.0; 3]; 2], rotate: 0.0, scale: 1.0 };
    for x in [f64::NAN, -1.0, f64::INFINITY] {
        breaks(&["environment's radiance"], |s| {
            s.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0, x, 1.0] }));
        });
        breaks(&["sky.exr", "scale"], |s| s.set_environment(with(MapDesc { scale: x, ..sky() })));
        // The other texel's numbers come after: the bad one must not be forgotten over them.
        let texels = vec![[x as f32, 1.0, 1.0], [1.0; 3]];
        breaks(&["sky.exr", "texel 0,0"], |s| s.set_environment(with(MapDesc { texels, ..sky() })));
    }
    breaks(&["sky.exr", "rotate"], |s| s.set_environment(with(MapDesc { rotate: f64::NAN, ..sky() })));
    breaks(&["sky.exr", "2 texels"], |s| s.set_environment(with(MapDesc { width: 3, ..sky() })));
    breaks(&["sky.exr", "0 x 1"], |s| s.set_environment(with(MapDesc { width: 0, texels: Vec::new(), ..sky() })));
    breaks(&["sky.exr", "no texel shines"], |s| {
        s.set_environment(with(MapDesc { texels: vec![[0.0; 3]; 2], ..sky() }));
    });
}

#[test]
fn nothing_to_see_is_one_rule() {
    let words = ["no triangle of positive area", "no environment"];
    let empty = |s: &mut SceneDesc| {
        (s.meshes[0].triangles, s.meshes[0].corners) = (Vec::new(), Vec::new());
        s.set_environment(None);
    };
    breaks(&words, empty);
    breaks(&words, |s| {
        s.set_environment(None);
        s.meshes[0].triangles.iter_mut().for_each(|t| t.vertices[1] = t.vertices[0]);
    });
    let mut surrounded = sound();
    empty(&mut surrounded);
    surrounded.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    assert!(PreparedScene::new(&surrounded).is_ok(), "an environment alone can be seen");
}

/// Writes `value` over one number of the description, chosen by `field` and `index`.
fn spoil(scene: &mut SceneDesc, field: usize, index: usize, value: f64) {
    let (whole, axis) = (value as u32, index % 3);
    let triangle = index % scene.meshes[0].triangles.len().max(1);
    let material = index % scene.materials.len().max(1);
    match field {
        0 => {
            if let Some(p) = scene.meshes[0].positions.get_mut(index % 97) {
                p[axis] = value as f32
            }
        }
        1 => {
            if let Some(t) = scene.meshes[0].triangles.get_mut(triangle) {
                t.vertices[axis] = whole
            }
        }
        2 => {
            if let Some(t) = scene.meshes[0].triangles.get_mut(triangle) {
                t.material = whole
            }
        }
        3 => {
            if let Some(c) = scene.meshes[0].corners.get_mut(triangle) {
                c.normals[axis] = [value as f32, 0.0, 0.0]
            }
        }
        4 => {
            if let Some(c) = scene.meshes[0].corners.get_mut(triangle) {
                c.uvs[axis][0] = value as f32
            }
        }
        5 => {
            if let Some(m) = scene.materials.get_mut(material) {
                m.emission[axis] = value
            }
        }
        6 => {
            let used = TextureUse { texture: whole, scale: [value; 2], offset: [1.0; 2] };
            let Some(material) = scene.materials.get_mut(material) else { return };
            [&mut material.texture, &mut material.emission_texture, &mut material.alpha_mask][axis].replace(used);
        }
        7 => {
            let scattering = [
                Scattering::Plastic { albedo: [value; 3], ior: value, alpha: value },
                Scattering::Principled { base_color: [value; 3], metallic: value, roughness: value, ior: value },
            ][index % 2];
            if let Some(m) = scene.materials.get_mut(material) {
                m.scattering = scattering
            };
        }
        8 => scene.camera.position[axis] = value,
        9 => scene.camera.look_at[axis] = value,
        10 => scene.camera.up[axis] = value,
        11 => (scene.camera.vertical_fov, scene.film.0) = (value, whole),
        12 => scene.textures.iter_mut().for_each(|t| t.width = whole),
        13 => scene.masks.iter_mut().for_each(|m| m.height = whole),
        14 => scene.set_environment(Some(EnvironmentDesc::Constant { radiance: [value; 3] })),
        15 => scene.meshes[0].triangles.truncate(index % 5),
        16 => scene.materials.truncate(index % 5),
        17 => scene.instances[0].mesh = whole,
        18 => {
            let mut rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
            rows[axis][index % 4] = value;
            scene.camera.to_world = Some(rows);
        }
        19 => {
            let mut rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
            rows[axis][index % 4] = value;
            scene.instances.push(InstanceDesc { mesh: 0, transform: Transform::Matrix(rows) });
        }
        _ => scene.meshes[0].corners.truncate(index % 2 * 64),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn spoilt_descriptions_never_panic(
        heavy in any::<bool>(),
        edits in prop::collection::vec((0usize..21, any::<usize>(), 0usize..14), 1..4),
    ) {
        const VALUES: [f64; 14] = [
            0.0, 1.0, 2.0, 0.5, 17.0, -1.0, 1e-30, 1e-12, 1e9, 1e13, 3e38, f64::MAX, f64::NAN, f64::INFINITY,
        ];
        let mut scene = if heavy { builtin::build("heavy:2000").expect("a builtin scene") } else { sound() };
        for (field, index, value) in edits {
            spoil(&mut scene, field, index, VALUES[value]);
        }
        let sound = validate::check(&scene).is_ok();
        match PreparedScene::new(&scene) {
            Ok(_) => prop_assert!(sound),
            Err(Error::Scene { message, .. }) => prop_assert!(!message.is_empty()),
            Err(error) => prop_assert!(false, "not an error of the scene: {error}"),
        }
    }
}
