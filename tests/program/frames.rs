//! Sequences of frames from outside: cameras that move, names with numbers, frames that are made one by one.

use crate::program::{Place, octray, stderr};
use octray::internal::image::Image;
use std::fs;
use std::path::Path;

const CORNELL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");

impl Place {
    /// The Cornell box with this text as its `[camera]`.
    fn moving(&self, name: &str, camera: &str) -> String {
        let obj = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.obj");
        fs::write(self.path(name), format!("{camera}\n[[mesh]]\nobj = '{obj}'\n")).unwrap();
        self.path(name)
    }

    fn frames(&self, scene: &str, flags: &[&str]) -> std::process::Output {
        let size = ["--width", "12", "--height", "12", "--spp", "4"];
        octray(&[&["render", scene], &size[..], flags].concat())
    }

    fn image(&self, name: &str) -> Image {
        Image::read(self.path(name)).unwrap()
    }
}

const PATH: &str = "[camera]
look_at = [278, 273, 0]
vertical_fov = 39.3
[[camera.key]]
time = 0
position = [278, 273, -800]
[[camera.key]]
time = 0.5
position = [200, 273, -800]
vertical_fov = 50
";

#[test]
fn a_frame_has_the_same_bits_alone_and_in_its_sequence() {
    let place = Place::new();
    let scene = place.moving("moving.toml", PATH);
    let all = place.path("out/all.##.exr");
    let output = place.frames(&scene, &["--frames", "0..3", "--fps", "4", "-o", &all]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("wrote") && text.contains("all.03.exr") && !text.contains("next:"), "{text}");
    let (alone, other) = (place.path("alone.exr"), place.path("other.exr"));
    assert!(place.frames(&scene, &["--frames", "2", "--fps", "4", "-o", &alone]).status.success());
    let frames: Vec<Image> = (0..4).map(|frame| place.image(&format!("out/all.0{frame}.exr"))).collect();
    assert_eq!(frames[2].pixels, place.image("alone.exr").pixels);
    // Frame 2 is at half a second: the last key, and the next frame shows the same with other noise.
    assert!(frames[2].pixels != frames[3].pixels && frames[0].pixels != frames[1].pixels);
    let key = "[camera]\nposition = [200, 273, -800]\nlook_at = [278, 273, 0]\nvertical_fov = 50\n";
    let seed = 0x9e37_79b9u32.wrapping_mul(2).to_string();
    let still = place.moving("still.toml", key);
    assert!(place.frames(&still, &["--seed", &seed, "-o", &other]).status.success());
    // An image trains by itself: so does the frame, if it is told to.
    let trained_alone = ["--frames", "2", "--fps", "4", "--train-frames", "1", "-o", &alone];
    assert!(place.frames(&scene, &trained_alone).status.success());
    assert_eq!(place.image("alone.exr").pixels, place.image("other.exr").pixels);
    assert!(frames[2].pixels != place.image("other.exr").pixels);
    // With nothing learned that is all the same.
    let off = ["--train", "off", "-o", &alone];
    for flags in [&["--frames", "2", "--fps", "4"], &["--frames", "2", "--fps", "4", "--train-frames", "1"][..]] {
        assert!(place.frames(&scene, &[flags, &off].concat()).status.success());
        let frame = place.image("alone.exr").pixels;
        assert!(place.frames(&still, &["--seed", &seed, "--train", "off", "-o", &other]).status.success());
        assert_eq!(frame, place.image("other.exr").pixels);
    }
    // The frame stands in the file; an image by itself is the scene's own camera, here the first key.
    let metadata = |image: &Image| image.metadata.iter().any(|(key, value)| key == "frame" && value == "2");
    assert!(metadata(&frames[2]) && !metadata(&place.image("other.exr")));
    let first = place.path("first.exr");
    assert!(place.frames(&scene, &["--frames", "0", "--train", "off", "-o", &first]).status.success());
    assert!(place.frames(&scene, &["--train", "off", "-o", &other]).status.success());
    assert_eq!(place.image("other.exr").pixels, place.image("first.exr").pixels);
}

#[test]
fn a_path_may_stand_in_a_file_of_its_own() {
    let place = Place::new();
    let path = place.path("walk.toml");
    fs::write(&path, PATH.replace("[camera]\n", "").replace("camera.key", "key")).unwrap();
    let (own, scene) = (place.path("own.exr"), place.path("scene.exr"));
    let moving = place.moving("moving.toml", PATH);
    assert!(place.frames(CORNELL, &["--camera-path", &path, "--frames", "6", "-o", &own]).status.success());
    assert!(place.frames(&moving, &["--frames", "6", "-o", &scene]).status.success());
    assert_eq!(place.image("own.exr").pixels, place.image("scene.exr").pixels);
}

#[test]
fn frames_that_are_there_are_left_out_when_asked() {
    let place = Place::new();
    let scene = place.moving("moving.toml", PATH);
    let images = place.path("####.pfm");
    fs::write(place.path("0001.pfm"), "kept").unwrap();
    let flags = ["--frames", "0..2", "-o", &images, "--skip-existing", "--stats", &place.path("####.json")];
    assert!(place.frames(&scene, &flags).status.success());
    assert_eq!(fs::read_to_string(place.path("0001.pfm")).unwrap(), "kept");
    let there = |name: &str| Path::new(&place.path(name)).exists();
    assert!(there("0000.pfm") && there("0002.pfm") && there("0002.json") && !there("0001.json"));
    assert!(place.frames(&scene, &flags[..4]).status.success());
    assert_ne!(fs::read(place.path("0001.pfm")).unwrap(), b"kept");
}

#[test]
fn what_is_wrong_with_any_frame_is_told_before_the_first() {
    let place = Place::new();
    let refused = |camera: &str, flags: &[&str], message: &str| {
        let scene = place.moving("scene.toml", camera);
        let out = place.path("out/####.exr");
        let output = place.frames(&scene, &[flags, &["-o", &out]].concat());
        assert_eq!(output.status.code(), Some(2), "{message}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{message}: {}", stderr(&output));
        assert!(!Path::new(&place.path("out")).exists());
    };
    let moving = ["--frames", "0..1"];
    let still = "[camera]\nposition = [1, 2, 3]\nlook_at = [0, 0, 0]\n";
    refused(
        &format!("{still}[[camera.key]]\nposition = [0, 0, 1]\n"),
        &moving,
        "scene.toml:4: [[key]]: `time` is missing",
    );
    refused(&format!("{still}[[camera.key]]\ntime = 0\nfov = 3\n"), &moving, "scene.toml:6: unknown key `fov`");
    refused(
        &format!("{still}[[camera.key]]\ntime = 1\n[[camera.key]]\ntime = 1\n"),
        &moving,
        "two keys have the time 1",
    );
    refused(&format!("{still}[camera.key]\ntime = 1\n"), &moving, "double brackets");
    refused("[camera]\nlook_at = [0, 0, 0]\n[[camera.key]]\ntime = 1\n", &moving, "`position` is missing");
    refused(
        &format!("{still}[[camera.key]]\ntime = 1\nposition = [0, 0, 0]\n"),
        &moving,
        "position and look_at are the same",
    );
    // Each key is fine, what lies between two is not.
    let through = "[camera]\nlook_at = [0, 0, 0]\n[[camera.key]]\ntime = 0\nposition = [0, 0, 2]\n[[camera.key]]\n\
                   time = 1\nposition = [0, 0, -2]\n";
    refused(through, &["--frames", "0..2", "--fps", "2"], "frame 1: camera: position and look_at are the same point");
    refused(still, &["--frames", "2..1"], "frame 2 comes after 1");
    refused(still, &["--frames", "0..1", "--fps", "0"], "frames a second above 0");
    refused(still, &["--skip-existing"], "--frames");
    refused(still, &["--frames", "0..1", "--train-frames", "0"], "--train-frames");
    refused(still, &["--train-frames", "4"], "--frames");
    refused(still, &["--camera-path", &place.path("none.toml")], "none.toml: cannot read it");
    let scene = place.moving("scene.toml", still);
    let output = place.frames(&scene, &["--frames", "0..1", "-o", &place.path("a.exr")]);
    assert!(
        output.status.code() == Some(2) && stderr(&output).contains("put #### for its number"),
        "{}",
        stderr(&output)
    );
    // A camera that stands still is no fault, but may be one.
    let output = place.frames(&scene, &["--frames", "0..1", "-o", &place.path("##.exr")]);
    assert!(output.status.success() && stderr(&output).contains("the camera does not move"), "{}", stderr(&output));
}
