//! `[[light]]` of scene files.

use super::common::{Folder, TOML, TRIANGLE, front, load_toml, warned};
use glam::DVec3;
use octray::scene::SceneDesc;
use octray::scene::desc::{DeltaLight, LightDesc};
use std::f64::consts::PI;

/// The delta lights of [`TOML`] with `more` below it.
fn deltas(more: &str) -> Vec<(String, DeltaLight)> {
    let scene = load_toml(more).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene.delta_lights().map(|desc| (desc.name.clone(), desc.light)).collect()
}

fn fails(light: &str, words: &[&str]) {
    let text = format!("{TOML}[[light]]\n{light}");
    let message = load_toml(&text[TOML.len()..]).expect_err(&text);
    assert!(words.iter().all(|word| message.contains(word)), "{text}\n{message}\nwanted {words:?}");
    assert!(!message.contains('\n') && message.starts_with("scene.toml:"), "{message}");
}

#[test]
fn delta_lights_arrive_as_written() {
    let all = deltas(
        r#"
[[light]]
kind = "point"
position = [1, 2.5, -3]
intensity = [4, 5, 6]
[[light]]
name = "key"
kind = "spot"
position = [1, 2, 3]
look_at = [1, 0, 4]
intensity = [1, 0, 0]
cone_angle = 40
cone_delta_angle = 0
[[light]]
kind = "directional"
direction = [0, -2, 0]
irradiance = [0, 3, 0]
[[light]]
kind = "spot"
position = [0, 0, 9]
direction = [0, 0, -1]
intensity = [1, 1, 1]
"#,
    );
    let spot = |position, direction, intensity, cone_angle, cone_delta_angle| DeltaLight::Spot {
        position,
        direction,
        intensity,
        cone_angle,
        cone_delta_angle,
    };
    let expected = [
        ("light 1", DeltaLight::Point { position: [1.0, 2.5, -3.0], intensity: [4.0, 5.0, 6.0] }),
        ("key", spot([1.0, 2.0, 3.0], [0.0, -2.0, 1.0], [1.0, 0.0, 0.0], 40.0, 0.0)),
        ("light 3", DeltaLight::Directional { direction: [0.0, -2.0, 0.0], irradiance: [0.0, 3.0, 0.0] }),
        ("light 4", spot([0.0, 0.0, 9.0], [0.0, 0.0, -1.0], [1.0; 3], 30.0, 5.0)),
    ];
    assert_eq!(all, expected.map(|(name, light)| (name.to_owned(), light)));
}

#[test]
fn power_is_what_a_light_sends_out_in_all() {
    let all = deltas(
        "[[light]]\nkind = 'point'\nposition = [0, 0, 1]\npower = [4, 0, 8]\n[[light]]\nkind = 'spot'\nposition = [0, 0, 1]\n\
         direction = [0, 0, -1]\ncone_angle = 90\ncone_delta_angle = 0\npower = [4, 0, 8]\n",
    );
    for ((_, light), solid_angle) in all.iter().zip([4.0 * PI, 2.0 * PI]) {
        let [red, green, blue] = light.strength();
        assert!((red - 4.0 / solid_angle).abs() < 1e-12 && green == 0.0 && (blue - 2.0 * red).abs() < 1e-12);
    }
}

/// What the triangles of the material `name` send out, watts in the first channel.
fn flux(scene: &SceneDesc, name: &str) -> f64 {
    let geometry = scene.geometry();
    let of = |i: &usize| scene.materials[geometry.triangles[*i].material as usize].name == name;
    let area: f64 = (0..geometry.triangles.len()).filter(of).map(|i| 0.5 * front(scene, i).length()).sum();
    let material = scene.materials.iter().find(|material| material.name == name).unwrap();
    PI * area * material.emission[0] * if material.two_sided { 2.0 } else { 1.0 }
}

#[test]
fn lamps_send_out_what_they_say_wherever_they_are() {
    // Far from the origin f32 rounds a small lamp to another shape, of the same flux.
    for position in ["[0, 0, 0]", "[5e3, -7e3, 1e3]"] {
        let scene = load_toml(&format!(
            "[[light]]\nname = 'ball'\nkind = 'sphere'\nposition = {position}\nradius = 0.02\npower = [7, 1, 1]\n[[light]]\n\
             name = 'shiny'\nkind = 'sphere'\nposition = {position}\nradius = 0.5\nradiance = [7, 1, 1]\n[[light]]\n\
             name = 'plate'\nkind = 'disk'\nposition = {position}\ndirection = [1, 2, -2]\nradius = 0.02\npower = [7, 1, 1]\n\
             [[light]]\nname = 'both'\nkind = 'disk'\nposition = {position}\nlook_at = [1, 2, -2]\nradius = 2\n\
             radiance = [7, 1, 1]\ntwo_sided = true\n"
        ))
        .unwrap();
        for (name, expected) in
            [("ball", 7.0), ("shiny", 7.0 * PI * PI), ("plate", 7.0), ("both", 2.0 * 7.0 * PI * 4.0 * PI)]
        {
            let got = flux(&scene, name);
            assert!((got / expected - 1.0).abs() < 1e-5, "{name} at {position}: {got}, {expected}");
        }
        assert_eq!(scene.geometry().triangles.len(), 1 + 2 * 1280 + 2 * 64, "behind those of the meshes");
        assert_eq!(scene.geometry().vertices(0), [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }
}

#[test]
fn a_disk_shines_where_it_looks() {
    let disk = |more: &str| {
        let text = format!(
            "[[light]]\nname = 'd'\nkind = 'disk'\nposition = [1, 1, 1]\nradius = 1\nradiance = [1, 1, 1]\n{more}"
        );
        let scene = load_toml(&text).unwrap();
        front(&scene, 1).normalize()
    };
    assert!(disk("direction = [0, -3, 0]").distance(-DVec3::Y) < 1e-6);
    assert!(disk("look_at = [1, 1, 7]").distance(DVec3::Z) < 1e-6);
}

#[test]
fn any_light_is_light() {
    assert!(!warned(
        &load_toml("[[light]]\nkind = 'directional'\ndirection = [0, 0, -1]\nirradiance = [1, 1, 1]").unwrap(),
        &["nothing emits"]
    ));
    // A bare file keeps its camera's frame, whatever lamps stand about.
    let mesh = "[[mesh]]\nobj = 'mesh.obj'\n";
    let lamp = "[[light]]\nkind = 'sphere'\nposition = [0, 900, 0]\nradius = 9\nradiance = [1, 1, 1]\n";
    let camera =
        |text: &str| Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", text)]).load("scene.toml").unwrap().camera;
    assert_eq!(camera(&format!("{mesh}{lamp}")), camera(mesh));
    // An environment beside them stays what it is.
    let sky =
        "[environment]\nradiance = [1, 2, 3]\n[[light]]\nkind = 'point'\nposition = [0, 0, 1]\nintensity = [1, 1, 1]\n";
    let mut scene = load_toml(sky).unwrap();
    assert_eq!((scene.lights.len(), scene.delta_lights().count()), (2, 1));
    scene.set_environment(None);
    assert!(matches!(scene.lights[..], [LightDesc::Delta(_)]) && scene.environment().is_none());
}

#[test]
fn what_is_wrong_with_a_light_is_said_at_its_line() {
    let point = "kind = 'point'\nposition = [0, 0, 1]\n";
    let spot = "kind = 'spot'\nposition = [0, 0, 1]\nintensity = [1, 1, 1]\n";
    let ball = "kind = 'sphere'\nposition = [0, 0, 1]\n";
    fails("position = [0, 0, 1]", &["scene.toml:6:", "[[light]]", "`kind` is missing"]);
    fails(
        "kind = 'area'",
        &["scene.toml:7:", "unknown kind \"area\"", "\"point\", \"spot\", \"directional\", \"sphere\""],
    );
    fails(point, &["scene.toml:6:", "`intensity` or `power` is missing"]);
    fails(&format!("{point}radius = 1"), &["scene.toml:9:", "a point light has no `radius`", "`intensity`"]);
    fails(&format!("{point}intensty = [1, 1, 1]"), &["scene.toml:9:", "did you mean `intensity`?"]);
    fails(&format!("{point}intensity = [1, -1, 1]"), &["scene.toml:9:", "must not be negative"]);
    fails(&format!("{point}intensity = [1e31, 1, 1]"), &["scene.toml:9:", "at most 1e30"]);
    fails(&format!("{point}intensity = [1, 1, 1]\npower = [1, 1, 1]"), &["scene.toml:10:", "exclude each other"]);
    fails(spot, &["scene.toml:6:", "`look_at` or `direction` is missing"]);
    fails(&format!("{spot}look_at = [0, 0, 1]"), &["scene.toml:10:", "where the light is"]);
    fails(&format!("{spot}direction = [0, 0, 0]"), &["scene.toml:10:", "`direction` is [0.0, 0.0, 0.0]"]);
    fails(&format!("{spot}direction = [0, 0, 1]\nlook_at = [0, 0, 2]"), &["scene.toml:11:", "exclude each other"]);
    fails(&format!("{spot}direction = [0, 0, 1]\ncone_angle = 200"), &["scene.toml:11:", "cone_angle is 200"]);
    fails(&format!("{spot}direction = [0, 0, 1]\ncone_angle = 0"), &["scene.toml:11:", "cone_angle is 0"]);
    fails(
        &format!("{spot}direction = [0, 0, 1]\ncone_angle = 20\ncone_delta_angle = 30"),
        &["scene.toml:12:", "cone_delta_angle is 30", "20 degrees"],
    );
    fails("kind = 'directional'\nirradiance = [1, 1, 1]", &["scene.toml:6:", "`direction` is missing"]);
    fails(&format!("{ball}radius = 0\nradiance = [1, 1, 1]"), &["scene.toml:9:", "`radius` is 0"]);
    fails(&format!("{ball}radius = -1\nradiance = [1, 1, 1]"), &["scene.toml:9:", "`radius` is -1"]);
    fails(&format!("{ball}radius = 1e-30\nradiance = [1, 1, 1]"), &["scene.toml:6:", "too small", "point light"]);
    fails(&format!("{ball}radius = 1e-14\npower = [1e9, 1, 1]"), &["scene.toml:10:", "`power`"]);
    let folder = Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", "light = 3\n[[mesh]]\nobj = 'mesh.obj'")]);
    let single = folder.load("scene.toml").unwrap_err();
    assert!(single.contains("[[light]], with double brackets"), "{single}");
    let far = load_toml("[[light]]\nkind = 'point'\nposition = [0, 2e12, 0]\nintensity = [1, 1, 1]").unwrap();
    let message = octray::PreparedScene::new(&far).err().unwrap().to_string();
    assert!(message.contains("a light reaches to 2.0e12"), "{message}");
}
