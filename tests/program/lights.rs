//! Delta lights from outside: who sees them, and what is said of it.

use crate::program::{Place, octray, stderr};
use serde_json::Value;

const LIGHTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/lights.toml");

fn json(arguments: &[&str]) -> Value {
    let output = octray(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn who_cannot_see_a_delta_light_is_warned() {
    let place = Place::new();
    let out = place.path("a.pfm");
    let small = ["render", LIGHTS, "--width", "8", "--height", "8", "--spp", "1", "-o", &out, "--quiet", "--strategy"];
    for strategy in ["uniform", "bsdf", "nee-average", "nee", "mis-power"] {
        let output = octray(&[&small[..], &[strategy]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let warned = stderr(&output).contains("does not see the 3 point, spot or directional light(s)");
        assert_eq!(warned, ["uniform", "bsdf"].contains(&strategy), "{strategy}: {}", stderr(&output));
    }
}

#[test]
fn info_counts_them_and_a_trace_names_them() {
    let info = json(&["info", LIGHTS, "--json"]);
    assert_eq!(info["features"]["delta_lights"], 3);
    assert_eq!(info["lights"], 3 + 1280 + 64);
    let trace =
        ["trace", LIGHTS, "--pixel", "256,400", "--lights", "uniform", "--width", "512", "--height", "512", "--sample"];
    let samples: Vec<String> = (0..400).map(|sample| sample.to_string()).collect();
    let mut seen = std::collections::BTreeSet::new();
    for sample in &samples {
        let told = json(&[&trace[..], &[sample, "--json"]].concat());
        assert_eq!(told["agree"], true);
        for step in told["steps"].as_array().unwrap().iter().filter(|step| step["gain"].is_array()) {
            if let Some(light) = step["light"]["delta_light"].as_array() {
                assert_eq!(step["weight"], 1.0, "all of its light: {step}");
                seen.insert(light[1].as_str().unwrap().to_owned());
                let story = octray(&[&trace[..], &[sample.as_str()]].concat());
                let story = String::from_utf8_lossy(&story.stdout).replace(['\n', '\u{a0}'], " ");
                let story = story.split_whitespace().collect::<Vec<_>>().join(" ");
                assert!(
                    story.contains("no ray can hit a delta light")
                        && story.contains("(spot)") | story.contains("(point)") | story.contains("(directional)"),
                    "{story}"
                );
            }
        }
        if seen.len() > 1 {
            return;
        }
    }
    panic!("of the delta lights only {seen:?} were seen");
}

#[test]
fn a_report_says_why_a_strategy_is_dark() {
    let place = Place::new();
    let out = place.path("report");
    let output = octray(&[
        "converge",
        LIGHTS,
        "--out",
        &out,
        "--strategies",
        "bsdf,mis-power",
        "--width",
        "12",
        "--height",
        "12",
        "--spps",
        "4,16,64",
        "--repeats",
        "4",
        "--reference-spp",
        "1024",
        "--max-depth",
        "3",
        "--quiet",
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("bsdf does not see the 3 point, spot or directional light(s)"),
        "{}",
        stderr(&output)
    );
    let page = std::fs::read_to_string(std::path::Path::new(&out).join("report.html")).unwrap();
    assert!(page.contains("no ray can hit the point, spot and directional lights of this scene"));
    let alone = octray(&[
        "converge",
        LIGHTS,
        "--out",
        &place.path("alone"),
        "--strategies",
        "mis-power",
        "--width",
        "8",
        "--height",
        "8",
        "--spps",
        "4",
        "--repeats",
        "2",
        "--reference-spp",
        "64",
        "--max-depth",
        "2",
        "--quiet",
        "--only-light",
        "sun",
    ]);
    assert!(alone.status.success(), "{}", stderr(&alone));
    let unknown = octray(&["converge", LIGHTS, "--out", &place.path("none"), "--only-light", "moon"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(stderr(&unknown).contains("its lights: ball, plate, sun, spot, bulb"), "{}", stderr(&unknown));
}
