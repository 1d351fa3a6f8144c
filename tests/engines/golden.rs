//! Golden pictures: a change that means to change no picture changes no hash in `tests/engines/golden.txt`.
//!
//! Every shipped and builtin scene is rendered by every strategy, samplers taking turns with light selections: the matrix
//! that `.ci/run` compares between engines and builds; and once with all that is learned. A change that means to change pictures records the hashes anew, in a
//! commit of its own that says why: `OCTRAY_RECORD_GOLDEN=1 cargo test --release --test engines golden`.

use crate::common;
use std::fmt::Write;

use octray::internal::fingerprint::Fingerprint;
use octray::{Film, Lights, Sampler, Scene, Settings, Strategy, Train, render};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/engines/golden.txt");

/// A hash of the means and variances of all pixels, as an image file holds them.
fn hash(film: &Film) -> u64 {
    let mut hash = Fingerprint::default();
    for (x, y) in (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y))) {
        let values = film.mean(x, y).into_iter().chain(film.variance(x, y));
        hash.bytes(&values.flat_map(|value| value.to_bits().to_le_bytes()).collect::<Vec<u8>>());
    }
    hash.value()
}

#[test]
fn pictures_have_their_golden_hashes() {
    let mut lines = String::new();
    for name in common::SCENES.into_iter().chain(["builtin:lamp_hall"]) {
        let scene = Scene::load(name).unwrap_or_else(|error| panic!("{error}"));
        let prepared = scene.prepare().unwrap_or_else(|error| panic!("{error}"));
        for &strategy in Strategy::ALL {
            for (lights, sampler) in [(Lights::Tree, Sampler::Sobol), (Lights::Power, Sampler::Independent)] {
                let (width, height) = (Some(45), Some(37));
                let small =
                    Settings { width, height, spp: 3, max_depth: Some(12), ..scene.settings().without_learning() };
                let film = render(&prepared, &Settings { strategy, lights, sampler, ..small }).film;
                writeln!(lines, "{:016x} {name} {strategy} {lights} {sampler}", hash(&film)).unwrap();
            }
        }
        let (width, height, train) = (Some(45), Some(37), Train::Paths(4096));
        let learned = Settings { width, height, train, spp: 3, max_depth: Some(12), ..scene.settings() };
        writeln!(lines, "{:016x} {name} all that is learned", hash(&render(&prepared, &learned).film)).unwrap();
    }
    if std::env::var_os("OCTRAY_RECORD_GOLDEN").is_some() {
        std::fs::write(FILE, &lines).unwrap();
    }
    let golden = std::fs::read_to_string(FILE).unwrap();
    let differing: Vec<_> = lines.lines().zip(golden.lines()).filter(|(now, then)| now != then).collect();
    assert!(differing.is_empty(), "{} pictures have changed, the first of them: {:?}", differing.len(), differing[0]);
    assert_eq!(lines.lines().count(), golden.lines().count(), "as many pictures as hashes");
}
