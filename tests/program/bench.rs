//! `octray bench` and `--plan` from outside: rays of files, what is left out.

use crate::program::{Place, octray, stderr};
use std::fs;

const CORNELL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");

/// The rows of `octray bench SCENE FLAGS.. --runs 1 --json`.
fn rows(flags: &[&str]) -> Vec<serde_json::Value> {
    let output = octray(&[&["bench", CORNELL, "--runs", "1", "--json"], flags].concat());
    assert!(output.status.success(), "{flags:?}: {}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A file of rays.
fn rays(count: u64, rays: &[[f32; 8]]) -> Vec<u8> {
    let numbers = rays.iter().flatten().flat_map(|number| number.to_le_bytes());
    count.to_le_bytes().into_iter().chain(numbers).collect()
}

#[test]
fn rays_of_files_are_answered_and_added_up() {
    let place = Place::new();
    // Through the open front of the box to the wall behind, at z = 559.2, and one that leaves.
    let straight = |x: f32, y: f32| [x, y, -800.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY];
    let list = [straight(500.0, 500.0), straight(50.0, 500.0), straight(300.0, 520.0), straight(2000.0, 500.0)];
    let mut broken = list;
    broken[3][1] = f32::NAN;
    let [file, other] = ["straight.rays", "broken.rays"].map(|name| place.path(name));
    fs::write(&file, rays(4, &list)).unwrap();
    fs::write(&other, rays(4, &broken)).unwrap();
    let rows = rows(&["--rays", &file, "--rays", &other]);
    assert_eq!(rows.len(), 2 * 2 * 4, "{rows:?}");
    let of = |what: &str| rows.iter().find(|row| row["what"] == what && row["engine"] == "packet").unwrap();
    let closest = of("straight closest");
    assert_eq!((&closest["hits"], &closest["items"]), (&3.into(), &4.into()));
    let sum = closest["sum_t"].as_f64().unwrap();
    assert!((sum - 3.0 * 1359.2).abs() < 0.1, "{closest}");
    assert!(closest["sum_id"].as_u64() > Some(0) && closest["mrays_per_s"].as_f64() > Some(0.0), "{closest}");
    let any = of("straight any");
    assert!(any["hits"] == 3 && any.get("sum_t").is_none() && any["mrays_per_s"].as_f64() > Some(0.0), "{any}");
    assert_eq!(of("broken closest")["hits"], 3);
    let output = octray(&["bench", CORNELL, "--runs", "1", "--rays", &other]);
    assert!(
        stderr(&output).contains("broken.rays: 1 of 4 rays hold what is not a finite number"),
        "{}",
        stderr(&output)
    );
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("broken closest") && text.contains("sum of t"), "{text}");
}

#[test]
fn files_that_hold_no_rays_are_refused() {
    let place = Place::new();
    let path = place.path("x.rays");
    let whole = rays(2, &[[1.0; 8]; 2]);
    let huge = rays(u64::MAX / 32, &[]);
    for (bytes, message) in [
        (&b"abc"[..], "3 bytes long"),
        (&whole[..40], "40 bytes long, but its first 8 say 2 rays"),
        (&rays(0, &[]), "holds no ray"),
        (&huge, "8 bytes long, but its first 8 say"),
    ] {
        fs::write(&path, bytes).unwrap();
        let output = octray(&["bench", CORNELL, "--rays", &path]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(message) && stderr(&output).contains("x.rays"), "{}", stderr(&output));
    }
    let directory = place.path("");
    for (flags, message) in [
        (&["--rays", &directory][..], "only regular files are read"),
        (&["--rays", &place.path("none.rays")], "cannot read it"),
        (&["--rays", &path, "--size", "8"], "cannot be used with"),
    ] {
        let output = octray(&[&["bench", CORNELL], flags].concat());
        assert_eq!(output.status.code(), Some(2), "{flags:?}");
        assert!(stderr(&output).contains(message), "{flags:?}: {}", stderr(&output));
    }
}

#[test]
fn what_is_left_out_is_put_back_part_by_part() {
    let rows = rows(&["--size", "16"]);
    let plans: Vec<&str> = rows.iter().filter_map(|row| row["what"].as_str()?.strip_prefix("render, plan ")).collect();
    let all: Vec<&str> = octray::PlanChoice::ALL[1..].iter().map(|plan| plan.name()).collect();
    assert_eq!(plans, all);
}

#[test]
fn a_general_plan_renders_the_same_picture() {
    let place = Place::new();
    let render = |name: &str, flags: &[&str]| {
        let (path, stats) = (place.path(name), place.path("stats.json"));
        let small =
            ["render", CORNELL, "-o", &path, "--stats", &stats, "--width", "16", "--height", "16", "--spp", "2"];
        let output = octray(&[&small[..], flags].concat());
        assert!(output.status.success(), "{flags:?}: {}", stderr(&output));
        let stats: serde_json::Value = serde_json::from_slice(&fs::read(stats).unwrap()).unwrap();
        (fs::read(path).unwrap(), stats["plan"].as_str().unwrap().to_owned())
    };
    let (own, named) = render("own.exr", &[]);
    assert_eq!(named, "scene");
    for &plan in octray::PlanChoice::ALL {
        assert_eq!(render("other.exr", &["--plan", plan.name()]), (own.clone(), plan.name().into()));
    }
    let output = octray(&["render", CORNELL, "-o", &place.path("x.png"), "--engine", "scalar", "--plan", "general"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("the scalar engine has no plan"), "{}", stderr(&output));
}
