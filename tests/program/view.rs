//! A camera, and light, from outside.

use crate::program::{Place, octray, stderr};
use std::fs;

const QUAD: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n";
const SMALL: [&str; 7] = ["--spp", "2", "--width", "24", "--height", "20", "--quiet"];

/// Renders and gives the image's bytes and what was said.
fn rendered(place: &Place, arguments: &[&str]) -> (Vec<u8>, String) {
    let out = place.path("o.pfm");
    let output = octray(&[&["render"], arguments, &SMALL, &["-o", &out]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    (fs::read(out).unwrap(), stderr(&output))
}

fn refused(arguments: &[&str], words: &[&str]) {
    let output = octray(arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}, wanted {words:?}");
}

#[test]
fn flags_are_as_good_as_a_scene_file() {
    let place = Place::new();
    let (obj, toml) = (place.path("q.obj"), place.path("q.toml"));
    fs::write(&obj, QUAD).unwrap();
    let camera = "[camera]\nposition = [1, 2, -3]\nlook_at = [0.5, 0, 0]\nup = [1, 1, 0]\nvertical_fov = 50\n";
    fs::write(&toml, format!("{camera}[[mesh]]\nobj = 'q.obj'\n[environment]\nradiance = [1, 1, 1]\n")).unwrap();
    let (by_file, _) = rendered(&place, &[&toml]);
    let flags = ["--look-from", "1,2,-3", "--look-at", "0.5,0,0", "--up", "1,1,0", "--fov", "50"];
    let (by_flags, said) = rendered(&place, &[&[obj.as_str()], &flags[..]].concat());
    assert!(by_flags == by_file, "a bare OBJ is seen by the camera of the flags");
    assert!(!said.contains("no camera"), "{said}");
    // Over the scene file's own camera, one by one: what is not given stays.
    let (moved, _) = rendered(&place, &[&toml, "--look-from", "-1,-2,3"]);
    fs::write(&toml, fs::read_to_string(&toml).unwrap().replace("[1, 2, -3]", "[-1, -2, 3]")).unwrap();
    assert!(rendered(&place, &[&toml]).0 == moved && moved != by_file);
    refused(
        &["render", &obj, "-o", &place.path("x.pfm"), "--look-from", "1,2,3", "--look-at", "1,2,3"],
        &["same point"],
    );
    refused(&["render", &obj, "-o", &place.path("x.pfm"), "--fov", "180"], &["--fov", "vertical_fov"]);
    refused(&["render", &obj, "-o", &place.path("x.pfm"), "--look-from", "1,2"], &["three numbers"]);
    let frames = ["render", &toml, "-o", &place.path("x#.pfm"), "--frames", "0..1", "--look-at", "0,0,1"];
    refused(&frames, &["stands still", "--frames"]);
    assert!(!std::path::Path::new(&place.path("x.pfm")).exists());
}

#[test]
fn cameras_have_names() {
    let place = Place::new();
    let (obj, toml) = (place.path("q.obj"), place.path("q.toml"));
    fs::write(&obj, QUAD).unwrap();
    let rest = "[[mesh]]\nobj = 'q.obj'\n[environment]\nradiance = [1, 1, 1]\n";
    let front = "position = [0, 0, 4]\nlook_at = [0, 0, 0]\n";
    let side = "position = [4, 1, 2]\nlook_at = [0, 0, 0]\nvertical_fov = 20\n";
    let one = |camera: &str| {
        fs::write(&toml, format!("[camera]\n{camera}{rest}")).unwrap();
        rendered(&place, &[&toml]).0
    };
    let (seen_front, seen_side) = (one(front), one(side));
    fs::write(&toml, format!("[[camera]]\nname = 'front'\n{front}[[camera]]\nname = 'side'\n{side}{rest}")).unwrap();
    assert!(rendered(&place, &[&toml]).0 == seen_front, "the first unless another is chosen");
    assert!(rendered(&place, &[&toml, "--camera", "front"]).0 == seen_front);
    assert!(rendered(&place, &[&toml, "--camera", "side"]).0 == seen_side);
    assert!(rendered(&place, &[&toml, "--camera", "side", "--fov", "25"]).0 != seen_side);
    refused(&["render", &toml, "-o", &place.path("x.pfm"), "--camera", "top"], &["top", "it has front, side"]);
    let bad = |text: &str, words: &[&str]| {
        fs::write(&toml, format!("{text}{rest}")).unwrap();
        refused(&["info", &toml], words);
    };
    bad(&format!("[[camera]]\n{front}[[camera]]\nname = 'side'\n{side}"), &["q.toml:1:", "`name` is missing"]);
    bad(
        &format!("[[camera]]\nname = 'a'\n{front}[[camera]]\nname = 'a'\n{side}"),
        &["q.toml:6:", "two cameras", "`a`"],
    );
    fs::write(&toml, format!("[camera]\n{front}{rest}")).unwrap();
    refused(&["trace", &toml, "--pixel", "1,1", "--sample", "0", "--camera", "front"], &["names none", "[[camera]]"]);
}

#[test]
fn a_studio_lights_what_has_no_light() {
    let place = Place::new();
    let obj = place.path("q.obj");
    fs::write(&obj, QUAD).unwrap();
    let (bare, said) = rendered(&place, &[&obj, "--look-from", "2,2,5"]);
    assert!(said.contains("white environment"), "{said}");
    let (studio, said) = rendered(&place, &[&obj, "--look-from", "2,2,5", "--studio"]);
    assert!(said.is_empty() && studio != bare, "{said}");
    let info = octray(&[
        "converge",
        &obj,
        "--studio",
        "--out",
        &place.path("r"),
        "--strategies",
        "mis-power",
        "--spps",
        "1",
        "--repeats",
        "1",
        "--width",
        "8",
        "--height",
        "8",
        "--reference-spp",
        "4",
        "--quiet",
    ]);
    assert!(info.status.success(), "{}", stderr(&info));
    refused(
        &["render", "scenes/cornell.toml", "--studio", "-o", &place.path("x.pfm")],
        &["--studio", "light of its own"],
    );
    refused(&["render", "scenes/sky.toml", "--studio", "-o", &place.path("x.pfm")], &["--studio", "light of its own"]);
}
