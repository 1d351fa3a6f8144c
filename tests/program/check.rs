//! `octray check` from outside: rows, JSON, exit status.

use crate::program::{Place, octray, stderr};
use serde_json::Value;
use std::fs;

const FURNACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.toml");

/// The rows that a run prints as JSON, which must have ended well.
fn rows(arguments: &[&str]) -> Vec<Value> {
    let output = octray(&[&["check"], arguments, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
    serde_json::from_slice::<Value>(&output.stdout).unwrap().as_array().unwrap().clone()
}

#[test]
fn a_filter_chooses_rows_and_json_has_them_all() {
    let rows = rows(&["--filter", "mis/"]);
    assert!(rows.len() >= 7, "{}", rows.len());
    for row in &rows {
        assert!(row["name"].as_str().unwrap().starts_with("mis/"), "{row}");
        assert!(row["pass"].as_bool().unwrap() && row["figure"].as_f64() <= row["bound"].as_f64(), "{row}");
        assert!(row["cases"].as_u64().unwrap() > 0 && row["seconds"].as_f64().unwrap() >= 0.0, "{row}");
    }
}

#[test]
fn a_table_has_a_line_a_row_and_a_summary() {
    let output = octray(&["check", "--filter", "mis/zero", "--threads", "1"]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()));
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    // The row's second line holds the rest of what was tried, below its first words.
    assert_eq!(lines.len(), 3, "{text}");
    assert!(lines.iter().all(|line| line.len() <= 120) && lines[1].starts_with(&" ".repeat(80)), "{text}");
    assert!(lines[0].starts_with("pass  mis/zero_and_infinite_densities") && lines[0].contains("<= 0"), "{text}");
    assert!(lines[2].starts_with("1 check,") && lines[2].ends_with("all hold"), "{text}");
}

#[test]
fn json_goes_to_a_file_and_the_table_to_the_screen() {
    let place = Place::new();
    let path = place.path("rows.json");
    let output = octray(&["check", "--filter", "mis/zero", &format!("--json={path}")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(String::from_utf8(output.stdout).unwrap().contains("all hold"));
    let rows: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    assert_eq!(rows[0]["name"], "mis/zero_and_infinite_densities");
}

#[test]
fn filters_without_rows_and_bad_scenes_are_bad_input() {
    for (arguments, message) in [
        (&["--filter", "magic"][..], "the groups are"),
        (&["no_such_scene.toml"], "no_such_scene.toml"),
        (&["--threads", "0"], "--threads"),
        (&["--json=scene.toml"], "that is a scene file"),
    ] {
        let output = octray(&[&["check"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(message), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn what_applies_to_a_scene_holds_for_a_furnace() {
    assert!(!rows(&[FURNACE]).is_empty());
}

/// A failing row names a path of a scene of the suite: `octray trace` takes it.
#[test]
fn trace_takes_the_scenes_of_the_suite() {
    let trace = |scene: &str| octray(&["trace", scene, "--pixel", "1,1", "--sample", "0", "--max-depth", "2"]);
    let output = trace("check:furnace:0.5:5e-1");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("agree to the last bit"));
    for (scene, message) in [("check:furnac", "did you mean"), ("check:furnace:1", "numbers wanted")] {
        let output = trace(scene);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(message), "{}", stderr(&output));
    }
}
