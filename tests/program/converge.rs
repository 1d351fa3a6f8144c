//! `octray converge` from outside: what it finds on scenes whose answers are known, and what it writes.

use crate::program::{Place, octray, stderr};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use scraper::{Html, Selector};
use serde_json::Value;
use std::fs;
use std::path::Path;

const CORNELL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
const FURNACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.toml");
const LIGHTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/lecture_lights.toml");

impl Place {
    /// Measures `scene` with `flags`; what `converge.json` says.
    fn converge(&self, scene: &str, flags: &[&str]) -> Value {
        let out = self.path("report");
        let output = octray(&[&["converge", scene, "--out", &out], flags].concat());
        assert!(output.status.success(), "{flags:?}: {}", stderr(&output));
        serde_json::from_str(&self.read("converge.json")).unwrap()
    }
    fn read(&self, name: &str) -> String {
        fs::read_to_string(Path::new(&self.path("report")).join(name)).unwrap()
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The findings by strategy.
fn finding<'a>(json: &'a Value, strategy: &str) -> &'a Value {
    let configurations = json["configurations"].as_array().unwrap();
    let index = configurations.iter().position(|c| c["strategy"] == strategy).unwrap();
    json["findings"].as_array().unwrap().iter().find(|f| f["configuration"] == index && f["case"] == 0).unwrap()
}

const SMALL: [&str; 12] = [
    "--width",
    "24",
    "--height",
    "24",
    "--spps",
    "16,1,4,64",
    "--repeats",
    "5",
    "--reference-spp",
    "8192",
    "--sampler",
    "independent",
];

#[test]
fn the_lectures_answers_come_out_on_the_cornell_box() {
    let place = Place::new();
    let json = place.converge(CORNELL, &SMALL);
    // Exact strategies: MSE falls as 1 / n. Seven intervals of 95 %, all of which hold with probability 0.7; these seeds are
    // fixed, and a slope further than 0.15 off would be a fault with any.
    let exact = ["uniform", "bsdf", "nee-average", "nee", "mis-one-sample", "mis-balance", "mis-power"];
    for strategy in exact {
        let found = finding(&json, strategy);
        assert!(found["biased"] == false && number(&found["bias_z"]).abs() < 5.0, "{strategy}: {}", found["bias_z"]);
        let slope = number(&found["mse_by_samples"]["value"]);
        assert!((slope + 1.0).abs() < 0.15, "{strategy}: {slope}");
        assert!(number(&found["efficiency_interval"]["low"]) < number(&found["efficiency"]));
    }
    for (strategy, sign) in [("nee-sum", 1.0), ("nee-no-emission", -1.0)] {
        let found = finding(&json, strategy);
        assert!(found["biased"] == true && number(&found["bias_z"]) * sign > 5.0, "{strategy}: {}", found["bias_z"]);
        assert!(found["efficiency"].is_null() && found["level"]["floor"].is_number());
        assert!(number(&found["floor"]) > 1e-3, "{strategy} levels off: {}", found["floor"]);
        // Its error bends to the level, where that of BSDF sampling, of like noise, goes on falling.
        let slope = |strategy: &str| number(&finding(&json, strategy)["mse_by_samples"]["value"]);
        assert!(slope(strategy) > slope("bsdf") + 0.03, "{strategy}: {} {}", slope(strategy), slope("bsdf"));
    }
    // The order of the lecture: averaging helps, 0/1 weights help more.
    let efficiency = |strategy: &str| number(&finding(&json, strategy)["efficiency"]);
    assert!(efficiency("bsdf") < efficiency("nee-average") && efficiency("nee-average") < efficiency("nee"));

    let csv = place.read("converge.csv");
    let mut lines = csv.lines();
    let head = "strategy,lights,sampler,engine,spp,seed,seconds,cpu_seconds,mse,relmse,bias_z";
    assert!(lines.next().unwrap().starts_with(head), "{csv}");
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), json["runs"].as_array().unwrap().len()), (9 * 4 * 5, 9 * 4 * 5));
    // Interleaved: all strategies at the first budget, then at the next, then again.
    let order: Vec<(&str, &str)> = rows.iter().map(|row| (row[0], row[4])).collect();
    assert_eq!(
        (order[0], order[8], order[9], order[36]),
        (("uniform", "1"), ("mis-power", "1"), ("uniform", "4"), ("uniform", "1"))
    );
    // No seed twice for one strategy.
    let seeds: std::collections::HashSet<&str> = rows.iter().filter(|row| row[0] == "nee").map(|row| row[5]).collect();
    assert_eq!(seeds.len(), 20);
    // A row is a render anyone can make again.
    let nee = rows.iter().find(|row| row[0] == "nee" && row[4] == "16").unwrap();
    let picture = place.path("again.exr");
    let size = ["--width", "24", "--height", "24", "--sampler", "independent"];
    let flags = [&size[..], &["--strategy", "nee", "--spp", "16", "--seed", nee[5], "-o", &picture]].concat();
    assert!(octray(&[&["render", CORNELL], &flags[..]].concat()).status.success());
    let reference = Path::new(&place.path("report")).join("reference.exr").to_str().unwrap().to_owned();
    let diff = octray(&["diff", &picture, &reference, "--json"]);
    let diff: Value = serde_json::from_slice(&diff.stdout).unwrap();
    for (key, column) in [("mse", 8), ("relmse", 9)] {
        let (told, found) = (nee[column].parse::<f64>().unwrap(), number(&diff[key]));
        assert!((told / found - 1.0).abs() < 1e-6, "{key}: {told} {found}");
    }

    // Called again, the reference is taken from the directory and the runs say the same; other settings want another one.
    let again = place.converge(CORNELL, &SMALL);
    let cached = |json: &Value| json["cases"][0]["reference"]["cached"].clone();
    assert_eq!((cached(&json), cached(&again)), (false.into(), true.into()));
    let errors =
        |json: &Value| json["runs"].as_array().unwrap().iter().map(|run| number(&run["mse"])).collect::<Vec<_>>();
    assert_eq!(errors(&json), errors(&again));
    let other = place.converge(CORNELL, &[&SMALL[..], &["--max-depth", "2", "--strategies", "nee"]].concat());
    assert_eq!(cached(&other), false);
}

#[test]
fn the_report_is_whole_valid_and_self_contained() {
    let place = Place::new();
    let flags = ["--width", "20", "--height", "16", "--spps", "1,4", "--repeats", "2", "--reference-spp", "64"];
    let more = ["--region", "lamp=6,0,8,4", "--region", "0,8,20,8"];
    let json = place.converge(LIGHTS, &[&flags[..], &more, &["--only-light", "each"]].concat());
    assert_eq!(
        json["cases"].as_array().unwrap().iter().map(|case| case["light"].as_str().unwrap()).collect::<Vec<_>>(),
        ["all", "blue", "grey"]
    );
    assert_eq!(json["findings"].as_array().unwrap().len(), 27);
    assert_eq!(json["findings"][0]["points"][1]["regions"].as_array().unwrap().len(), 2);
    let text = place.read("report.html");
    let page = Html::parse_document(&text);
    assert!(page.errors.is_empty(), "{:?}", page.errors);
    let select = |what: &str| {
        let selector = Selector::parse(what).unwrap();
        page.select(&selector).map(|element| element.value().clone()).collect::<Vec<_>>()
    };
    // Every image is in the page, and is one: of each light the reference, whole and its hardest part, and of each
    // configuration a render, a heatmap and that part. Each can be enlarged.
    let images = select("img");
    assert_eq!((images.len(), select("label.zoom input[type=checkbox]").len()), (3 * (2 + 3 * 9), 3 * (2 + 3 * 9)));
    let mut whole = 0;
    for shown in &images {
        let (kind, data) = shown.attr("src").unwrap().split_once(";base64,").unwrap();
        assert!(["data:image/png", "data:image/jpeg"].contains(&kind), "{kind}");
        let decoded = image::load_from_memory(&STANDARD.decode(data).unwrap()).unwrap();
        let size = (decoded.width(), decoded.height());
        assert!(size == (20, 16) || size == (16, 16), "{size:?}");
        whole += (size == (20, 16)) as u32;
        assert!(!shown.attr("alt").unwrap().is_empty());
    }
    assert_eq!(whole, 3 * (1 + 2 * 9));
    // Nothing is fetched, nothing runs.
    for (what, attribute) in [("[src]", "src"), ("[href]", "href"), ("[data]", "data"), ("[srcset]", "srcset")] {
        for element in select(what) {
            let target = element.attr(attribute).unwrap();
            assert!(target.starts_with("data:") || target.starts_with('#'), "{target}");
        }
    }
    for what in ["script", "link", "iframe", "object", "embed", "base", "meta[http-equiv]"] {
        assert!(select(what).is_empty(), "{what}");
    }
    assert!(!text.contains("@import") && !text.contains("url("), "styles fetch nothing");
    let events = Selector::parse("*").unwrap();
    assert!(page.select(&events).all(|element| element.value().attrs().all(|(name, _)| !name.starts_with("on"))));
    // Four figures a light, each for a desk and for a phone; small ones of the lights together and of the regions of each.
    assert_eq!(select("svg.plot:not(.key)").len(), 3 * 4 * 2 + 3 + 3 * 2);
    for what in ["title", "h1", "h2", "table", "pre", "ul"] {
        assert!(!select(what).is_empty(), "{what}");
    }
    assert!(text.contains("prefers-color-scheme:dark") && text.contains("octray converge "), "dark too; the command");
    assert!(!text.contains("NaN") && !text.contains("inf "), "no figure is missing");
    let named = |name: &str, strategies: &[&str]| {
        let svg = place.read(&format!("{name}.svg"));
        let tree = roxmltree::Document::parse(&svg).unwrap();
        let named =
            |strategy: &&str| tree.descendants().any(|node| node.text().is_some_and(|text| text.contains(strategy)));
        assert!(strategies.iter().all(named), "{name}");
    };
    for name in ["error-against-samples", "error-against-seconds-blue", "error-against-samples-grey"] {
        named(name, &["uniform", "nee-sum", "nee-average", "mis-power"]);
    }
    for name in ["efficiency-against-seconds-grey", "error-spectrum"] {
        named(name, &["mis-power"]);
    }
    assert!(Path::new(&place.path("report")).join("mis-balance-grey-error.png").exists());
}

#[test]
fn a_closed_form_needs_no_reference() {
    let place = Place::new();
    let flags =
        ["--width", "16", "--height", "16", "--strategies", "bsdf,nee,nee-sum", "--spps", "4,16", "--repeats", "3"];
    let json = place.converge(FURNACE, &flags);
    assert_eq!(json["cases"][0]["reference"]["kind"], "closed_form");
    assert_eq!(json["cases"][0]["mean"], serde_json::json!([1.0, 1.0, 1.0]));
    assert!(!Path::new(&place.path("report")).join("reference.exr").exists());
    assert!(finding(&json, "nee-sum")["biased"] == true && finding(&json, "nee")["biased"] == false);
    // Other pictures serve as well, and are told by their path; a wrong one makes every strategy look biased.
    let wrong = place.path("wrong.pfm");
    let mut bytes = b"PF\n16 16\n-1.0\n".to_vec();
    (0..3 * 256).for_each(|_| bytes.extend(0.5f32.to_le_bytes()));
    fs::write(&wrong, bytes).unwrap();
    let json = place.converge(FURNACE, &[&flags[..], &["--reference", &wrong]].concat());
    assert!(json["cases"][0]["reference"]["path"].as_str().unwrap().ends_with("wrong.pfm"));
    assert!(["bsdf", "nee"].iter().all(|strategy| finding(&json, strategy)["biased"] == true));
    assert!(place.read("report.html").contains("It should have no bias"));
}

#[test]
fn times_and_lists_are_budgets_and_configurations() {
    let place = Place::new();
    let film = ["--width", "16", "--height", "16", "--strategies", "nee", "--repeats", "2"];
    let lists = ["--times", "0.02,0.01", "--lights", "power,uniform", "--engine", "all", "--threads", "1"];
    let json = place.converge(CORNELL, &[&film[..], &lists].concat());
    assert_eq!(json["budgets"], serde_json::json!([{ "seconds": 0.01 }, { "seconds": 0.02 }]));
    let names: Vec<String> =
        json["configurations"].as_array().unwrap().iter().map(|c| format!("{} {}", c["lights"], c["engine"])).collect();
    assert_eq!(names.len(), 4);
    assert!(names.contains(&"\"power\" \"scalar\"".to_owned()), "{names:?}");
    assert!(place.read("report.html").contains("nee power scalar"));
    assert_eq!(place.read("converge.csv").lines().count(), 1 + 2 * 2 * 4);
}

#[test]
fn several_scenes_make_one_page_with_means_over_them() {
    let place = Place::new();
    let flags = ["--width", "16", "--height", "16", "--spps", "4,16", "--repeats", "3", "--reference-spp", "512"];
    let more = [CORNELL, FURNACE, "--strategies", "bsdf,mis-power,nee-sum"];
    let json = place.converge(LIGHTS, &[&more[..], &flags].concat());
    let cases = json["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    assert!(
        cases[1]["scene"] == "cornell"
            && cases[1]["file"].as_str().unwrap().ends_with("cornell.toml")
            && cases[0]["light"] == "all"
    );
    assert_eq!(
        (&cases[0]["reference"]["kind"], &cases[2]["reference"]["kind"]),
        (&"rendered".into(), &"closed_form".into())
    );
    // Geometric means of the shares of the best, and the least share with its scene.
    let findings = json["findings"].as_array().unwrap();
    let efficiency = |case: usize, configuration: usize| {
        let found = findings.iter().find(|f| f["case"] == case && f["configuration"] == configuration).unwrap();
        found["efficiency"].as_f64()
    };
    let share = |case: usize, configuration: usize| {
        let best = (0..3).filter_map(|other| efficiency(case, other)).fold(0.0, f64::max);
        efficiency(case, configuration).unwrap() / best
    };
    for configuration in [0, 1] {
        let shares = [0, 1, 2].map(|case| share(case, configuration));
        let summary = &json["summaries"][configuration];
        let mean = shares.iter().product::<f64>().cbrt();
        assert!((number(&summary["geometric_mean"]) / mean - 1.0).abs() < 1e-9, "{summary} {mean}");
        let worst = summary["worst"][0].as_u64().unwrap() as usize;
        // Numbers lose their last bit on the way through JSON.
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(near(shares[worst], least) && near(number(&summary["worst"][1]), least), "{summary} {shares:?}");
    }
    assert!(json["summaries"][2]["geometric_mean"].is_null(), "nee-sum is biased");
    let page = place.read("report.html");
    assert!(page.contains("lecture_lights, cornell, furnace") && page.contains("geometric mean"));
    for name in ["error-against-seconds-furnace.svg", "nee-sum-cornell.png", "reference-lecture_lights.exr"] {
        assert!(Path::new(&place.path("report")).join(name).exists(), "{name}");
    }
    let csv = place.read("converge.csv");
    assert!(
        csv.lines().next().unwrap().ends_with(",scene") && csv.lines().nth(1).unwrap().ends_with(",lecture_lights")
    );
    // Every scene needs a reference of its own.
    let one = place.path("report/reference-cornell.exr");
    let two = [CORNELL, LIGHTS, "--out", &place.path("other"), "--reference", &one, "--width", "16", "--height", "16"];
    let output = octray(&[&["converge"], &two[..]].concat());
    assert!(output.status.code() == Some(2) && stderr(&output).contains("1 for 2 cases"), "{}", stderr(&output));
}

#[test]
fn other_renderers_stand_beside_ours() {
    let place = Place::new();
    let film = ["--width", "16", "--height", "16"];
    let rows = |text: &str| {
        let path = place.path("others.csv");
        fs::write(&path, text).unwrap();
        path
    };
    // Another renderer, played by ourselves: `bsdf` by its images alone, twice as slow as the file says.
    let mut text = String::from("# made for this test\nimage, seconds ,name,spp,scene\n");
    for (spp, seed) in [(4, 1), (4, 2), (4, 3), (16, 4), (16, 5), (16, 6)] {
        let name = format!("other-{spp}-{seed}.exr");
        let (spp_text, seed) = (spp.to_string(), seed.to_string());
        let image = place.path(&name);
        let flags = ["render", CORNELL, "-o", &image, "--strategy", "bsdf", "--spp", &spp_text, "--seed", &seed];
        assert!(octray(&[&flags[..], &film].concat()).status.success());
        text += &format!("{name},{},\"the other, louder\",{spp},cornell\n", 0.5 * spp as f64);
    }
    let csv = rows(&text);
    let flags = ["--strategies", "bsdf,nee", "--spps", "4,16", "--repeats", "3", "--reference-spp", "4096"];
    let json = place.converge(CORNELL, &[&film[..], &flags, &["--against", &csv]].concat());
    assert_eq!(json["others"], serde_json::json!(["the other, louder"]));
    let findings = json["findings"].as_array().unwrap();
    let other = findings.iter().find(|f| f["configuration"] == 2).unwrap();
    let bsdf = findings.iter().find(|f| f["configuration"] == 0).unwrap();
    let relmse = |finding: &Value, point: usize| number(&finding["points"][point]["relmse"]);
    assert!((relmse(other, 1) / relmse(bsdf, 1) - 1.0).abs() < 0.5 && other["points"][1]["runs"] == 3);
    assert_eq!(number(&other["points"][1]["cpu_seconds"]), 8.0);
    assert!(number(&other["efficiency"]) < number(&bsdf["efficiency"]) && other["biased"] == false);
    let page = place.read("report.html");
    assert!(page.contains("as efficient as the other, louder, by efficiency") && page.contains("Of other renderers"));
    assert!(place.read("error-against-seconds.svg").contains("the other, louder"));
    let table = place.read("converge.csv");
    assert!(table.lines().last().unwrap().starts_with("\"the other, louder\",,,,16,"), "{table}");
    // Without samples the images stand by their seconds.
    let csv = rows(&text.replace(",4,cornell", ",,").replace(",16,cornell", ",,"));
    let json = place.converge(CORNELL, &[&film[..], &flags, &["--against", &csv]].concat());
    let other = json["findings"].as_array().unwrap().iter().find(|f| f["configuration"] == 2).unwrap().clone();
    assert_eq!(other["points"].as_array().unwrap().len(), 6);
    assert!(other["prices"][0]["samples"].is_null() && number(&other["prices"][0]["cpu_seconds"]) > 8.0);
    // What is wrong is told with its line, before anything is rendered.
    let refused = |text: &str, message: &str| {
        let csv = rows(text);
        let out = place.path("refused");
        let output = octray(&[&["converge", CORNELL, "--out", &out, "--against", &csv], &film[..]].concat());
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(message) && !Path::new(&out).exists(), "{message}: {}", stderr(&output));
    };
    refused("name,seconds\n", "others.csv:1: no column `image`");
    refused("name,seconds,image\n", "no rows");
    refused("name,seconds,image\na,0,x.exr\n", "others.csv:2: seconds `0`: give a number above 0");
    refused("name,seconds,image,spp\na,1,x.exr,-3\n", "others.csv:2: spp `-3`");
    refused(
        "name,seconds,image,scene\na,1,x.exr,kitchen\n",
        "others.csv:2: scene `kitchen` is not measured; known: cornell",
    );
    refused("name,seconds,image\nmis-power,1,x.exr\n", "others.csv:2: the name `mis-power` is that of a strategy");
    refused(
        "name,seconds,image,spp\na,1,x.exr,4\nb,1,x.exr,\na,1,x.exr,\n",
        "others.csv:4: `a` has spp in one of the lines 2 and 4",
    );
    refused("name,seconds,image\na,1\n", "others.csv:2");
    refused("name,seconds,image\na,1,none.exr\n", "none.exr: cannot read it");
}

#[test]
fn an_error_is_reached_when_asked_for() {
    let place = Place::new();
    let flags = ["--width", "16", "--height", "16", "--spps", "1,4", "--repeats", "3", "--reference-spp", "16384"];
    let json = place.converge(CORNELL, &[&flags[..], &["--strategies", "bsdf,nee,nee-sum", "--reach", "30%"]].concat());
    assert_eq!(json["reach"], 0.3);
    for (strategy, reached) in [("bsdf", true), ("nee", true), ("nee-sum", false)] {
        let found = finding(&json, strategy);
        let last = found["points"].as_array().unwrap().last().unwrap();
        assert_eq!(number(&last["relmse"]).sqrt() <= 0.3, reached, "{strategy}: {last}");
        assert_eq!(last["runs"], if reached { 2 } else { 3 });
        let price = found["prices"].as_array().unwrap().iter().find(|price| price["error"] == 0.3).unwrap();
        assert!(!reached || price["extrapolated"] == false, "{price}");
    }
    let runs = json["runs"].as_array().unwrap();
    assert!(runs.len() > 2 * 3 * 3);
    // No seed twice.
    let seeds: std::collections::HashSet<_> =
        runs.iter().filter(|run| run["configuration"] == 0).map(|run| run["seed"].to_string()).collect();
    assert_eq!(seeds.len(), runs.iter().filter(|run| run["configuration"] == 0).count());
}

#[test]
fn bad_flags_are_one_error_before_any_work() {
    let place = Place::new();
    let out = place.path("report");
    let refused = |flags: &[&str], status: i32, message: &str| {
        let output = octray(&[&["converge", CORNELL, "--out", &out], flags].concat());
        assert_eq!(output.status.code(), Some(status), "{flags:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{flags:?} should say `{message}`: {}", stderr(&output));
        assert!(output.stdout.is_empty() && !Path::new(&out).join("report.html").exists());
    };
    refused(&["--strategies", "nee,magic"], 2, "known: uniform, bsdf, nee-sum");
    refused(&["--lights", "sun"], 2, "known: uniform, power");
    refused(&["--sampler", ""], 2, "known: independent");
    refused(&["--engine", "gpu"], 2, "known: packet, scalar");
    refused(&["--spps", "1,0"], 2, "whole number from 1");
    refused(&["--times", "0"], 2, "seconds above 0");
    refused(&["--times", "1", "--spps", "4"], 2, "cannot be used with");
    refused(&["--repeats", "0"], 2, "--repeats");
    refused(&["--region", "250,0,10,10"], 2, "--region 250,0,10,10: crop 250,0,10,10 does not lie in the film");
    refused(&["--region", "a=1,2"], 2, "4 whole numbers");
    refused(&["--only-light", "sun"], 2, "nothing of that name shines");
    refused(&["--reference", &place.path("none.exr")], 2, "none.exr: cannot read it");
    let picture = place.path("a.pfm");
    assert!(
        octray(&["render", CORNELL, "-o", &picture, "--width", "8", "--height", "6", "--spp", "1"]).status.success()
    );
    refused(&["--reference", &picture], 2, "it has 8 x 6 pixels and the film 256 x 256");
    let hole = place.path("hole.pfm");
    let values = [1.0f32, f32::NAN, 1.0].map(f32::to_le_bytes).concat();
    fs::write(&hole, [b"PF\n1 1\n-1.0\n", &values[..]].concat()).unwrap();
    refused(&["--reference", &hole, "--width", "1", "--height", "1"], 2, "the value of pixel 0,0 is (1, NaN, 1)");
    let missing = octray(&["converge", &place.path("none.toml"), "--out", &out]);
    assert!(missing.status.code() == Some(2) && stderr(&missing).contains("none.toml: cannot read it"));
    assert_eq!(octray(&["converge", CORNELL]).status.code(), Some(2));
    // A file where the directory should be, and one that takes no files: outputs that cannot be written.
    let taken = [Some(picture.as_str()), cfg!(target_os = "linux").then_some("/proc/report")];
    for taken in taken.into_iter().flatten() {
        let output = octray(&["converge", CORNELL, "--out", taken]);
        assert_eq!(output.status.code(), Some(1), "{taken}: {}", stderr(&output));
        assert!(stderr(&output).contains("cannot write it"), "{taken}: {}", stderr(&output));
    }
}
