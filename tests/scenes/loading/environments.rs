//! Environment maps named by TOML files.

use super::common::*;
use octray::scene::desc::{EnvironmentDesc, MapDesc, SceneDesc};
use octray::{Crop, Film};

/// [`TOML`] with `[environment]` and `lines` below it, beside a map of 2 x 1 texels in four formats.
fn with_map(texels: [[f32; 3]; 2], lines: &str) -> Result<SceneDesc, String> {
    let toml = format!("{TOML}[environment]\n{lines}");
    let folder = Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", &toml), ("broken.exr", "v/1\u{1}no")]);
    let mut film = Film::new(Crop { x: 0, y: 0, width: 2, height: 1 });
    film.spp = 1;
    for (pixel, texel) in film.pixels.iter_mut().zip(texels) {
        pixel.sum = texel.map(f64::from);
    }
    for name in ["sky.exr", "sky.hdr", "sky.pfm", "sky.png"] {
        film.save(folder.path(name)).expect("a map");
    }
    folder.load("scene.toml")
}

const PLAIN: [[f32; 3]; 2] = [[1.0, 0.5, 0.25], [0.0, 1.0, 1.0]];

fn map(scene: SceneDesc) -> MapDesc {
    match scene.environment().cloned() {
        Some(EnvironmentDesc::Map(map)) => map,
        other => panic!("no map: {other:?}"),
    }
}

#[test]
fn a_map_arrives_from_every_format() {
    for name in ["sky.exr", "sky.hdr", "sky.pfm", "sky.png"] {
        let scene = with_map(PLAIN, &format!("map = '{name}'\nrotate = -30\nscale = 2.5")).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let map = map(scene);
        assert_eq!((map.width, map.height, map.rotate, map.scale), (2, 1, -30.0, 2.5));
        let far = map.texels.iter().flatten().zip(PLAIN.iter().flatten()).any(|(a, b)| (a - b).abs() > 4e-3);
        assert!(!far && map.file.ends_with(name), "{name}: {:?}", map.texels);
    }
    assert_eq!(map(with_map(PLAIN, "map = 'sky.exr'").unwrap()).scale, 1.0);
}

#[test]
fn what_cannot_be_a_map_is_refused_with_its_line() {
    let fails = |texels, lines: &str, words: &[&str]| {
        let message = with_map(texels, lines).expect_err(lines);
        assert!(words.iter().all(|word| message.contains(word)), "{lines}\n{message}\nwanted {words:?}");
        assert!(!message.contains('\n') && message.starts_with("scene.toml:"), "{message}");
    };
    fails(PLAIN, "map = 'gone.exr'", &["scene.toml:7:", "gone.exr", "cannot read it"]);
    fails(PLAIN, "scale = 1\nmap = 'broken.exr'", &["scene.toml:8:", "broken.exr"]);
    fails(PLAIN, "map = 'mesh.obj'", &["scene.toml:7:", "mesh.obj", ".exr, .png, .hdr or .pfm"]);
    fails(PLAIN, "map = ''", &["scene.toml:7:", "`map` is empty"]);
    fails(PLAIN, "map = 3", &["scene.toml:7:", "a text in quotes"]);
    fails(PLAIN, "rotate = 3", &["scene.toml:6:", "`radiance` or `map` is missing"]);
    fails(PLAIN, "radiance = [1, 1, 1]\nmap = 'sky.exr'", &["scene.toml:8:", "exclude each other"]);
    fails(PLAIN, "radiance = [1, 1, 1]\nrotate = 3", &["scene.toml:8:", "`rotate` turns a `map`"]);
    fails(PLAIN, "map = 'sky.exr'\nscale = -1", &["scene.toml:8:", "negative"]);
    fails(PLAIN, "map = 'sky.exr'\nrotate = inf", &["scene.toml:8:", "finite"]);
    fails([[1e38; 3]; 2], "map = 'sky.exr'\nscale = 1e9", &["scene.toml:7:", "sky.exr", "must be finite"]);
    fails([[f32::INFINITY; 3]; 2], "map = 'sky.pfm'", &["scene.toml:7:", "sky.pfm", "texel 0,0 is infinite"]);
    fails([[1e-30; 3]; 2], "map = 'sky.exr'\nscale = 1e-12", &["scene.toml:7:", "no texel shines"]);
}

#[test]
fn negative_texels_count_0_and_black_maps_are_none() {
    let scene = with_map([[-1.0, 2.0, f32::NAN], [1.0; 3]], "map = 'sky.pfm'").unwrap();
    assert!(warned(&scene, &["sky.pfm", "1 texels are negative"]));
    assert_eq!(map(scene).texels, [[0.0, 2.0, 0.0], [1.0; 3]]);
    for (texels, lines) in [([[0.0; 3]; 2], "map = 'sky.exr'"), (PLAIN, "map = 'sky.exr'\nscale = 0")] {
        let scene = with_map(texels, lines).unwrap();
        assert!(scene.environment().is_none() && warned(&scene, &["sky.exr", "black"]));
    }
}

/// Files with a few bytes changed, or cut short: an error or some map, never a panic.
#[test]
fn damaged_maps_never_panic() {
    let folder = Folder::new(&[("mesh.obj", TRIANGLE)]);
    let mut film = Film::new(Crop { x: 0, y: 0, width: 9, height: 5 });
    film.spp = 1;
    film.pixels.iter_mut().enumerate().for_each(|(i, pixel)| pixel.sum = [i as f64, 1.0, 0.25]);
    let mut loaded = 0;
    for name in ["sky.exr", "sky.hdr", "sky.pfm", "sky.png"] {
        film.save(folder.path(name)).expect("a map");
        folder.write("scene.toml", format!("{TOML}[environment]\nmap = '{name}'").as_bytes());
        let whole = std::fs::read(folder.path(name)).expect("the map");
        for i in 0..600u32 {
            let mut bytes = whole.clone();
            // Headers are where structure is: half of all damage goes to the first 100 bytes.
            let words = octray::internal::sampler::random_words(i, whole.len() as u32, 1, 2);
            let reach = if i % 2 == 0 { bytes.len().min(100) } else { bytes.len() };
            for (word, flip) in [(words[0], words[1]), (words[2], words[3])] {
                bytes[word as usize % reach] ^= (flip >> 24) as u8;
            }
            if i % 5 == 0 {
                bytes.truncate(words[1] as usize % whole.len());
            }
            folder.write(name, &bytes);
            loaded += folder.load("scene.toml").is_ok() as u32;
        }
    }
    assert!(loaded > 100, "damage to pixels alone is no error: {loaded}");
}
