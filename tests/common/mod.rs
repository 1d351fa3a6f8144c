//! What several test files share: the scenes, small, and comparisons of pictures.
#![allow(dead_code)] // not every test file uses every helper

use octray::{Film, PreparedScene, Scene, Settings};

/// Our scenes; builtin ones small.
pub const SCENES: [&str; 4] = [
    "scenes/cornell.toml",
    "scenes/cornell_mirror.toml",
    "scenes/furnace.toml",
    "builtin:heavy:20000",
];

/// A scene of ours, ready; panics with the reason if it does not load.
pub fn prepared(path: &str) -> PreparedScene {
    Scene::load(path).and_then(|scene| scene.prepare()).unwrap_or_else(|error| panic!("{error}"))
}

/// Settings for a small picture.
pub fn small(width: u32, height: u32, spp: u32) -> Settings {
    Settings { spp, width: Some(width), height: Some(height), threads: 1, ..Settings::default() }
}

/// The first difference between two films' sums, bit for bit.
pub fn first_difference(a: &Film, b: &Film) -> Option<String> {
    assert_eq!((a.width, a.height, a.spp), (b.width, b.height, b.spp));
    let bits = |v: [f64; 3]| v.map(f64::to_bits);
    let differs = |i: &usize| {
        bits(a.pixels[*i].sum) != bits(b.pixels[*i].sum) || bits(a.pixels[*i].sum_squares) != bits(b.pixels[*i].sum_squares)
    };
    let i = (0..a.pixels.len()).find(differs)?;
    let (x, y) = (i % a.width as usize, i / a.width as usize);
    Some(format!("pixel {x},{y}: {:?} and {:?}", a.pixels[i].sum, b.pixels[i].sum))
}
