//! What is learned, from outside: flags, statistics, what `info` says.

use crate::program::{Place, octray, stderr};

const GLOSSY: &str = "scenes/glossy_plates.toml";

fn json(text: &[u8]) -> serde_json::Value {
    serde_json::from_slice(text).unwrap()
}

#[test]
fn renders_tell_what_learning_came_to() {
    let place = Place::new();
    let (image, stats) = (place.path("a.pfm"), place.path("a.json"));
    let size = ["--width", "24", "--height", "16", "--spp", "1", "--quiet"];
    let render = |more: &[&str]| {
        let output = octray(&[&["render", GLOSSY, "-o", &image, "--stats", &stats], &size[..], more].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        json(&std::fs::read(&stats).unwrap())
    };
    let told = render(&["--lights", "learned", "--train", "8192"]);
    let learning = &told["learning"];
    assert_eq!((&told["lights"], &told["train"]), (&"learned".into(), &"8192".into()));
    assert_eq!(learning["used"], true, "{learning}");
    assert!(learning["forecast"].as_f64() < Some(0.85) && learning["paths"].as_u64() <= Some(8192), "{learning}");
    assert!(learning["cpu_seconds"].as_f64() > Some(0.0) && learning["bytes"].as_u64() > Some(1000), "{learning}");
    assert!(told["cpu_s"].as_f64() >= learning["cpu_seconds"].as_f64(), "training is rendering: {told}");
    let told = render(&["--lights", "learned", "--train", "off"]);
    assert_eq!((&told["learning"]["used"], &told["learning"]["grid"]), (&false.into(), &serde_json::Value::Null));
    assert!(render(&["--lights", "tree", "--guide", "off"])["learning"].is_null());
    for wrong in ["0", "-1", "many", ""] {
        let output = octray(&["render", GLOSSY, "-o", &image, "--train", wrong]);
        assert_eq!(output.status.code(), Some(2), "--train {wrong:?}");
        assert!(stderr(&output).contains("`auto` or `off`"), "{}", stderr(&output));
    }
}

#[test]
fn info_lists_tables_forecast_and_why() {
    let output = octray(&["info", GLOSSY, "--lights", "learned", "--train", "8192", "--json"]);
    let info = json(&output.stdout);
    assert_eq!(info["learning"]["used"], true);
    assert!(info["light_selection_used"].as_str().unwrap().contains("learned"), "{info}");
    let tables = info["tables"].as_array().unwrap();
    let bytes =
        |name: &str| tables.iter().find(|table| table["name"] == name).and_then(|table| table["bytes"].as_u64());
    assert!(bytes("learned light factors") > Some(1000), "{info}");
    let told = |arguments: &[&str]| String::from_utf8_lossy(&octray(arguments).stdout).into_owned();
    let text = told(&["info", GLOSSY, "--lights", "learned", "--train", "8192"]);
    assert!(text.contains("learned\n  training render") && text.contains("used: foreseen second moment"), "{text}");
    let text = told(&["info", "scenes/cornell.toml", "--lights", "learned"]);
    assert!(text.contains("not used: there is nothing to choose from"), "{text}");
    assert!(!told(&["info", GLOSSY, "--lights", "tree", "--guide", "off"]).contains("training render"));
}

#[test]
fn visibility_is_told_and_its_shadow_rays_are_counted() {
    let place = Place::new();
    let (image, stats) = (place.path("a.pfm"), place.path("a.json"));
    let told = |lights: &str| {
        let size = ["--width", "32", "--height", "32", "--spp", "2", "--guide", "off", "--quiet"];
        let render = ["render", "builtin:rooms", "-o", &image, "--stats", &stats, "--lights", lights];
        let output = octray(&[&render[..], &size[..]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        json(&std::fs::read(&stats).unwrap())
    };
    let (tree, map) = (told("tree"), told("nee-plus-plus"));
    let rays = |told: &serde_json::Value| told["rays"]["shadow"].as_u64().unwrap();
    assert!(rays(&map) < rays(&tree) * 9 / 10, "{} shadow rays of {}", rays(&map), rays(&tree));
    assert_eq!((&map["lights"], &map["learning"]["used"]), (&"nee-plus-plus".into(), &true.into()));
    let info = |arguments: &[&str]| String::from_utf8_lossy(&octray(arguments).stdout).into_owned();
    let text = info(&["info", "builtin:rooms", "--lights", "nee-plus-plus", "--guide", "off"]);
    assert!(text.contains("light tree, weighed by visibility; roulette of shadow rays by visibility"), "{text}");
    assert!(text.contains("used: asked for") && text.contains("visibility of cells"), "{text}");
    let text = info(&["info", "scenes/door_ajar.toml", "--lights", "nee-plus-plus", "--guide", "off"]);
    assert!(text.contains("used: asked for (roulette alone); "), "{text}");
    let text = info(&["info", "scenes/sky.toml", "--lights", "nee-plus-plus", "--guide", "off"]);
    assert!(text.contains("not used: there is no light but the environment"), "{text}");
}

/// An unfinished render goes on with the tables that it began with, so it must have the same training.
#[test]
fn parts_of_a_render_share_their_training() {
    use octray::internal::setup::frame::Frame;
    use octray::internal::setup::recipe::Recipe;
    use octray::{Lights, Settings, Train};
    let recipe = |lights, train| {
        let settings = Settings { lights, train, ..Settings::plain() };
        Recipe::new("a scene", &settings, &Frame::new(&settings, (4, 4)).unwrap())
    };
    let learned = recipe(Lights::Learned, Train::Auto);
    assert_ne!(learned, recipe(Lights::Learned, Train::Paths(4096)));
    assert_ne!(learned, recipe(Lights::Learned, Train::Off));
    assert_ne!(learned, recipe(Lights::Tree, Train::Auto));
    assert_eq!(recipe(Lights::Tree, Train::Auto), recipe(Lights::Tree, Train::Paths(4096)));
}
