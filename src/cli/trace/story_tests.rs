//! Stories of many paths: whole, as wide as the terminal, and true.

use super::*;
use crate::api::Scene;
use crate::cli::trace::follow;
use crate::setup::Setup;
use crate::strategy::Strategy;
use std::collections::BTreeSet;

/// Calls `judge` for samples of a few pixels of a scene of ours, by all of `strategies`.
fn paths(scene: &str, strategies: &[Strategy], mut judge: impl FnMut(&Traced)) {
    let path = format!("{}/scenes/{scene}.toml", env!("CARGO_MANIFEST_DIR"));
    let scene = Scene::load(path).unwrap();
    let prepared = scene.prepare().unwrap();
    for &strategy in strategies {
        let film = (Some(8), Some(8));
        let settings = crate::Settings { strategy, width: film.0, height: film.1, ..scene.settings() };
        let setup = Setup::new(&prepared, &settings);
        for pixel in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))).step_by(3) {
            (0..2).for_each(|sample| judge(&follow(&scene.desc, &settings, &setup, pixel, sample)));
        }
    }
}

#[test]
fn a_weight_of_almost_1_is_told_from_1() {
    assert_eq!([1.0, 0.0, 0.5, 1.0 - 3.8e-6, 1.99].map(weight), ["1", "0", "0.5", "1 - 3.8e-6", "1.99"]);
}

/// Every kind of step is told, no line is wider than the terminal, and no number is missing.
#[test]
fn stories_hold_every_step_and_fit() {
    let mut told = BTreeSet::new();
    for scene in ["cornell", "cornell_mirror", "glass", "glossy_plates", "sky"] {
        paths(scene, Strategy::ALL, |traced| {
            told.extend(traced.vertices.iter().map(|vertex| vertex.event));
            for columns in [80, 120] {
                let text = story(traced, columns);
                let wide = text.lines().find(|line| line.chars().count() > columns);
                assert!(wide.is_none() && !text.contains("NaN") && !text.contains(NO_BREAK), "{wide:?} in\n{text}");
            }
            let text = story(traced, 100);
            let count = |what: &str| text.matches(what).count();
            let events = |event: &str| traced.vertices.iter().filter(|vertex| vertex.event == event).count();
            assert_eq!(count("\nDepth "), traced.scalar.len(), "{text}");
            assert_eq!(count("BLOCKED"), events(LIGHT_SAMPLE_BLOCKED), "{text}");
            assert_eq!(count("nothing is in between"), events(LIGHT_SAMPLE), "{text}");
            assert_eq!(count(": delta, factor"), traced.vertices.iter().filter(|v| v.pdf == f64::INFINITY).count());
            assert_eq!(count("  Roulette"), events(ROULETTE) + events(ROULETTE_SURVIVED), "{text}");
            // A story has an end.
            let last = traced.vertices.last().unwrap().event;
            assert!(["miss", "environment", ROULETTE, END].contains(&last), "{last}: {text}");
        });
    }
    for event in KNOWN.iter().chain(&["diffuse", "mirror", "dielectric"]) {
        assert!(told.contains(event), "{event} in none of {told:?}");
    }
}

/// What is told is what happened: gains are made of the factors that are told, and add up to the radiance.
#[test]
fn the_factors_told_make_the_gain_and_gains_make_the_radiance() {
    let near = |a: f64, b: f64| (a - b).abs() <= 2e-6 * (a.abs() + b.abs());
    for scene in ["cornell", "glossy_plates", "sky"] {
        paths(scene, Strategy::ALL, |traced| {
            let (mut beta, mut sum) = ([1.0; 3], [0.0; 3]);
            for vertex in &traced.vertices {
                let light = [LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED].contains(&vertex.event);
                for c in 0..3 {
                    let factors = vertex.beta[c] * vertex.emitted[c] * vertex.weight;
                    let made = match light {
                        true => factors * vertex.bsdf[c] / vertex.pdf,
                        false => factors,
                    };
                    assert!(near(vertex.gain[c], made), "{vertex:?}");
                    if vertex.event != LIGHT_SAMPLE_BLOCKED {
                        sum[c] += vertex.gain[c];
                    }
                    let bounced = !KNOWN.contains(&vertex.event);
                    let survived = vertex.event == ROULETTE_SURVIVED;
                    let after = match (bounced, survived) {
                        (true, _) => beta[c] * vertex.bsdf[c],
                        (_, true) => beta[c] / vertex.probability,
                        _ => beta[c],
                    };
                    assert!(near(vertex.beta[c], after), "{vertex:?}");
                    assert!((vertex.radiance[c] - sum[c]).abs() <= 1e-5 * sum[c], "{vertex:?} {sum:?}");
                }
                let certain = vertex.weight == 0.0 || vertex.pdf > 0.0 || vertex.note == "certain";
                assert!(certain && (0.0..=1.0).contains(&vertex.probability), "{vertex:?}");
                beta = vertex.beta;
            }
        });
    }
}
