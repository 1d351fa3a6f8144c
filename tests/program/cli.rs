//! The program from outside: exit codes, messages, files.

use crate::program::{Place, octray, stderr};
use octray::internal::image::Image;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const CORNELL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
/// Settings under which a test render takes a moment.
const SMALL: [&str; 6] = ["--width", "16", "--height", "16", "--spp", "1"];

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Runs the program and demands this exit status, nothing on standard output and `message` on standard error.
fn refused(arguments: &[&str], status: i32, message: &str) {
    let output = octray(arguments);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", stderr(&output));
    assert!(stderr(&output).contains(message), "{arguments:?} should say `{message}`: {}", stderr(&output));
    assert_eq!(stdout(&output), "", "{arguments:?}");
}

impl Place {
    fn is_empty(&self) -> bool {
        fs::read_dir(self.0.path()).unwrap().next().is_none()
    }
    fn scene(&self, name: &str, text: &str) -> String {
        fs::write(self.path(name), text).unwrap();
        self.path(name)
    }
}

/// A small render of the Cornell box with `flags`; the picture.
fn render(place: &Place, name: &str, flags: &[&str]) -> Image {
    let path = place.path(name);
    let arguments = [&["render", CORNELL, "-o", &path], &SMALL[..], flags].concat();
    let output = octray(&arguments);
    assert!(output.status.success(), "{flags:?}: {}", stderr(&output));
    Image::read(&path).unwrap()
}

#[test]
fn bad_flags_end_with_status_2_and_say_why() {
    let place = Place::new();
    let output = place.path("a.png");
    for (flags, message) in [
        (&["--spp", "0"][..], "whole number from 1"),
        (&["--spp", "-3"], "whole number from 1"),
        (&["--spp", "1.5"], "whole number from 1"),
        (&["--time", "0"], "seconds above 0"),
        (&["--time", "nan"], "seconds above 0"),
        (&["--time", "-1"], "seconds above 0"),
        (&["--time", "inf"], "seconds above 0"),
        (&["--target-error", "0"], "an error above 0"),
        (&["--target-error", "-1%"], "an error above 0"),
        (&["--exposure", "nan"], "number of stops"),
        (&["--exposure", "1e9"], "number of stops"),
        (&["--strategy", "magic"], "known: uniform, bsdf, nee-sum"),
        (&["--lights", "sun"], "known: uniform, power"),
        (&["--sampler", "halton"], "known: independent, sobol"),
        (&["--engine", "gpu"], "known: packet, scalar"),
        (&["--max-depth", "-1"], "--max-depth"),
        (&["--rr-depth", "on"], "a depth from 0 on, or `off`"),
        (&["--seed", "4294967296"], "--seed"),
        (&["--threads", "0"], "--threads"),
        (&["--width", "0"], "number of pixels"),
        (&["--height", "65536"], "number of pixels"),
        (&["--crop", "1,2,3"], "4 whole numbers"),
        (&["--crop", "0,0,0,1"], "at least 1"),
        (&["--crop", "nan,0,1,1"], "4 whole numbers"),
        (&["--crop", "-1,0,1,1"], "4 whole numbers"),
        (&["--frobnicate"], "--frobnicate"),
    ] {
        refused(&[&["render", CORNELL, "-o", &output], flags].concat(), 2, message);
    }
    assert!(place.is_empty());
}

#[test]
fn bad_commands_and_missing_arguments_are_status_2() {
    refused(&["rendr"], 2, "a similar subcommand exists: 'render'");
    refused(&["render", CORNELL], 2, "--output");
    refused(&["render", "-o", "a.png"], 2, "SCENE");
    refused(&["trace", CORNELL, "--pixel", "1,1"], 2, "--sample");
}

#[test]
fn the_name_alone_shows_where_to_begin() {
    let output = octray(&[]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(2), String::new()));
    let commands = stdout(&output).lines().filter(|line| line.starts_with("  octray ")).count();
    assert_eq!(commands, 3, "{}", stdout(&output));
    assert!(stdout(&output).starts_with("octray ") && stdout(&output).lines().all(|line| line.len() <= 80));
}

#[test]
fn slips_are_answered_with_what_may_have_been_meant() {
    let place = Place::new();
    let [scene, output] = ["room.toml", "a.exr"].map(|name| place.path(name));
    fs::copy(CORNELL, &scene).unwrap();
    let near = format!("did you mean `{scene}`?");
    for name in ["rom.toml", "Room.toml", "room"] {
        for command in [&["info"][..], &["check"], &["bench"], &["render", "-o", &output]] {
            refused(&[command, &[&place.path(name)]].concat(), 2, &near);
        }
        refused(&["trace", &place.path(name), "--pixel", "1,1", "--sample", "0"], 2, &near);
        refused(&["diff", &place.path("a.pfm"), &place.path("a.pfm")], 2, "cannot read it");
    }
    let silent = octray(&["info", &place.path("elsewhere.toml")]);
    assert!(!stderr(&silent).contains("did you mean"), "{}", stderr(&silent));
    for name in ["builtin:hevy", "heavy", "buildin:heavy"] {
        refused(&["info", name], 2, "did you mean `builtin:heavy`?");
    }
    refused(&["info", "builtin:nonsense"], 2, "no such scene; known: builtin:heavy, builtin:lamp_hall, builtin:rooms");
    for (flags, message) in [
        (&["--strategy", "mispower"][..], "did you mean `mis-power`?"),
        (&["--strategy", "balance"], "did you mean `mis-balance`?"),
        (&["--lights", "treee"], "did you mean `tree`?"),
        (&["--sampler", "sobl"], "did you mean `sobol`?"),
        (&["--engine", "pakcet"], "did you mean `packet`?"),
        (&["--samples", "4"], "--samples"),
        (&["--straegy", "nee"], "a similar argument exists: '--strategy'"),
    ] {
        refused(&[&["render", CORNELL, "-o", &output], flags].concat(), 2, message);
    }
    refused(&[CORNELL], 2, "a command comes first: octray render");
    refused(&["builtin:heavy"], 2, "octray render builtin:heavy -o image.exr");
    refused(&["info", CORNELL, "--json", "a.json"], 2, "with an equals sign only: --json=a.json");
}

#[test]
fn directories_of_outputs_are_made_once_all_else_is_well() {
    let place = Place::new();
    let [image, stats, json] = ["new/deep/a.pfm", "new/stats/a.json", "other/info.json"].map(|name| place.path(name));
    let json_flag = format!("--json={json}");
    let broken = place.scene("broken.toml", "[film]\nwidth = 0\n");
    let lone = place.scene("lone.toml", "[[mesh]]\nobj = 'none.obj'\n");
    for scene in [&broken, &lone, &place.path("none.toml")] {
        let output = octray(&["render", scene, "-o", &image, "--stats", &stats]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert_eq!(octray(&["info", scene, &json_flag]).status.code(), Some(2));
    }
    let bad_crop = ["render", CORNELL, "-o", &image, "--stats", &stats, "--crop", "9999,0,1,1"];
    assert_eq!(octray(&bad_crop).status.code(), Some(2));
    let lost = place.path("none.pfm");
    let heatmap = place.path("new/map.png");
    assert_eq!(octray(&["diff", &lost, &lost, "--heatmap", &heatmap, &json_flag]).status.code(), Some(2));
    assert!(!Path::new(&place.path("new")).exists() && !Path::new(&place.path("other")).exists());
    let render = octray(&[&["render", CORNELL, "-o", &image, "--stats", &stats], &SMALL[..]].concat());
    assert!(render.status.success(), "{}", stderr(&render));
    let diff = octray(&["diff", &image, &image, "--heatmap", &heatmap, &json_flag]);
    assert!(diff.status.success(), "{}", stderr(&diff));
    assert!([&image, &stats, &heatmap, &json].iter().all(|path| Path::new(path).is_file()));
}

/// `--json` alone is for standard output; its file stands behind an equals sign; what follows is never its value.
#[test]
fn json_is_a_flag_alike_in_every_command() {
    let place = Place::new();
    let [image, file] = ["a.pfm", "a.json"].map(|name| place.path(name));
    render(&place, "a.pfm", &[]);
    let flag = format!("--json={file}");
    let bench = ["--runs", "1", "--size", "8"];
    let trace = ["--pixel", "3,3", "--sample", "0", "--width", "8", "--height", "8"];
    let filter = ["--filter", "slivers"];
    for (command, positional, flags) in [
        ("info", &[CORNELL][..], &[][..]),
        ("check", &[CORNELL], &filter),
        ("bench", &[CORNELL], &bench),
        ("trace", &[CORNELL], &trace),
        ("diff", &[&image, &image], &[]),
    ] {
        let json = |output: &Output| {
            assert_eq!(output.status.code(), Some(0), "{command}: {}", stderr(output));
            serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap_or_else(|e| panic!("{command}: {e}"))
        };
        // Before what is positional, behind it, before another flag, with a dash for a name.
        json(&octray(&[&[command, "--json"], positional, flags].concat()));
        json(&octray(&[&[command], positional, flags, &["--json"]].concat()));
        json(&octray(&[&[command], positional, &["--json"], flags].concat()));
        json(&octray(&[&[command], positional, flags, &["--json=-"]].concat()));
        let output = octray(&[&[command, &flag], positional, flags].concat());
        assert_eq!(output.status.code(), Some(0), "{command}: {}", stderr(&output));
        // The text is printed all the same.
        assert!(!stdout(&output).is_empty() && !stdout(&output).starts_with(['{', '[']), "{command}");
        assert!(serde_json::from_str::<serde_json::Value>(&fs::read_to_string(&file).unwrap()).is_ok(), "{command}");
        fs::remove_file(&file).unwrap();
        // A word behind the bare flag is positional: one too many.
        refused(&[&[command], positional, flags, &["--json", &file]].concat(), 2, "equals sign");
        let help = stdout(&octray(&[command, "--help"]));
        assert!(help.contains("--json[=<FILE>]"), "{command}: {help}");
        for (name, message) in [("b.toml", "that is a scene file"), ("b.EXR", "that is an image")] {
            let flag = format!("--json={}", place.path(name));
            refused(&[&[command], positional, flags, &[&flag]].concat(), 2, message);
        }
    }
}

#[test]
fn times_take_units() {
    let place = Place::new();
    for time in ["20ms", "0.02s", "0.02", "0m0.02s"] {
        let (image, stats) = (place.path("a.pfm"), place.path("a.json"));
        let film = ["--width", "16", "--height", "16", "--stats", &stats];
        assert!(octray(&[&["render", CORNELL, "-o", &image, "--time", time], &film[..]].concat()).status.success());
        let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
        // Whole passes: at least one, and no more than one after the time.
        assert!(stats["render_s"].as_f64() > Some(0.0) && stats["spp"].as_u64() >= Some(1), "{time}: {stats}");
    }
}

#[test]
fn help_and_version_go_to_standard_output() {
    let version = octray(&["--version"]);
    assert!(version.status.success());
    assert_eq!(stdout(&version), format!("octray {} {}\n", env!("CARGO_PKG_VERSION"), octray::simd_level()));
    let help = stdout(&octray(&["render", "--help"]));
    for flag in ["--output", "--spp", "--time", "--strategy", "--lights", "--sampler", "--max-depth", "--rr-depth"] {
        assert!(help.contains(flag), "{flag}");
    }
    for flag in ["--seed", "--engine", "--threads", "--width", "--height", "--crop", "--exposure", "--stats", "--quiet"]
    {
        assert!(help.contains(flag), "{flag}");
    }
}

#[test]
fn outputs_are_checked_before_anything_is_read() {
    let place = Place::new();
    // The scene does not exist: had it been read first, that would be the error.
    let scene = place.path("none.toml");
    let refuse = |name: &str, status: i32, message: &str| {
        refused(&["render", &scene, "-o", &place.path(name)], status, message);
    };
    refuse("a.jpg", 2, "unknown image extension `.jpg`");
    refuse("a", 2, "no extension");
    refuse("missing/a.png", 2, "none.toml: cannot read it");
    let image = place.path("a.png");
    fs::write(place.path("file"), "").unwrap();
    refuse("file/a.png", 1, "file is not a directory");
    refuse("file/missing/a.png", 1, "file is not a directory");
    let stats = place.path("file/a.json");
    refused(&["render", &scene, "-o", &image, "--stats", &stats], 1, "file is not a directory");
    fs::remove_file(place.path("file")).unwrap();
    let [one, other] = ["new/deep/a.png", "./new/./deep/../deep/a.png"].map(|name| place.path(name));
    refused(&["render", &scene, "-o", &one, "-o", &other], 2, "named for two outputs");
    refused(&["render", &scene, "-o", &image, "-o", &image], 2, "named for two outputs");
    refused(&["render", &scene, "-o", &image, "-o", &place.path("./a.png")], 2, "named for two outputs");
    refused(&["render", &scene, "-o", &image, "--stats", &image], 2, "that is an image");
    refused(&["render", &scene, "-o", &image, "--stats", &scene], 2, "--stats");
    refused(&["render", &scene, &image], 2, "images to write are named with -o");
    refused(&["render", &scene, "-o", &image, &image], 2, "images to write are named with -o");
    assert!(place.is_empty());
}

#[test]
#[cfg(target_os = "linux")]
fn a_directory_that_takes_no_files_is_status_1() {
    // Even root makes no files here.
    refused(&["render", CORNELL, "-o", "/proc/a.png"], 1, "/proc/a.png: cannot write it");
}

#[test]
fn bad_scenes_are_status_2_and_name_the_file() {
    let place = Place::new();
    let output = place.path("a.png");
    let missing = place.path("none.toml");
    refused(&["render", &missing, "-o", &output], 2, "none.toml: cannot read it");
    refused(&["info", &missing], 2, "none.toml: cannot read it");
    let broken = place.scene("broken.toml", "[film]\nwidth = 8\nheigth = 8\n");
    refused(&["render", &broken, "-o", &output], 2, "broken.toml:3");
    refused(&["render", "builtin:nonsense", "-o", &output], 2, "nonsense");
    assert!(!Path::new(&output).exists());
}

#[test]
fn crops_and_pixels_outside_the_film_are_status_2() {
    let place = Place::new();
    let output = place.path("a.png");
    for crop in ["16,0,1,1", "0,0,17,1", "0,15,1,2", "4294967295,0,4294967295,1"] {
        let arguments = [&["render", CORNELL, "-o", &output, "--crop", crop], &SMALL[..]].concat();
        refused(&arguments, 2, "does not lie in the film of 16 x 16");
    }
    let film = ["--width", "16", "--height", "16"];
    let trace = [&["trace", CORNELL, "--pixel", "16,0", "--sample", "0"], &film[..]].concat();
    refused(&trace, 2, "does not lie in the film");
}

#[test]
fn json_never_replaces_a_scene() {
    let place = Place::new();
    let scene = place.scene("a.toml", "precious");
    refused(&["bench", &format!("--json={scene}")], 2, "that is a scene file");
    refused(&["render", CORNELL, "-o", &place.path("a.png"), "--stats", &scene], 2, "that is a scene file");
    assert_eq!(fs::read_to_string(scene).unwrap(), "precious");
}

#[test]
fn a_render_writes_every_output_and_a_few_lines() {
    let place = Place::new();
    let names = ["a.exr", "a.png", "a.hdr", "a.pfm"].map(|name| place.path(name));
    let stats = place.path("a.json");
    let outputs = names.iter().flat_map(|name| ["-o", name.as_str()]).collect::<Vec<_>>();
    let output = octray(&[&["render", CORNELL, "--stats", &stats], &outputs[..], &SMALL].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!((lines.len(), lines[0]), (4, &format!("wrote {}", names.join(", "))[..]), "{text}");
    assert!(lines[1].starts_with("  16 x 16 pixels, 1 sample a pixel, mis-power, sobol, "), "{text}");
    assert_eq!(lines[2], "  noise unknown: it takes 4 samples a pixel to tell");
    assert_eq!(lines[3], format!("next: octray diff {} REFERENCE.exr tells its error", names[0]));
    assert_eq!(stderr(&output), "", "no bar where there is no terminal");
    let [exr, _, _, pfm] = names.map(|name| Image::read(name).unwrap());
    assert_eq!(exr.pixels, pfm.pixels);
    assert!(exr.pixels.iter().flatten().any(|value| *value > 0.0));
    for (key, value) in [("strategy", "mis-power"), ("spp", "1"), ("seed", "0")] {
        assert!(exr.metadata.iter().any(|(k, v)| k == key && v == value), "{key}: {:?}", exr.metadata);
    }
    let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
    for key in ["scene", "strategy", "lights", "sampler", "engine", "simd", "threads", "width", "height", "spp", "seed"]
    {
        assert!(!stats[key].is_null(), "{key}");
    }
    for key in ["load_s", "build_s", "render_s", "cpu_s", "mrays_per_s"] {
        assert!(stats[key].is_f64(), "{key}");
    }
    assert_eq!(stats["rays"]["camera"], 256);
    let stages = stats["stages"].as_array().unwrap();
    assert!(stages.iter().all(|stage| stage["lanes_used"].as_u64() <= stage["lanes_possible"].as_u64()));
    assert!(!stages.is_empty() && stages.iter().all(|stage| stage["seconds"].is_f64()));
    let walks = stages.iter().filter(|stage| stage["walk_lanes_used"].as_u64() > Some(0));
    assert!(walks.count() >= 1, "packets through the tree count their lanes");
    assert!(stats["rays"]["bounce"].as_u64() > Some(0) && stats["rays"]["shadow"].as_u64() > Some(0));
    if cfg!(any(target_os = "linux", target_os = "macos", windows)) {
        assert!(stats["peak_rss_bytes"].as_u64() > Some(100_000));
    }
    // A tile is taken, locked and counted; the one worker then finds no other.
    assert_eq!((&stats["tiles"], &stats["shared_operations"]), (&1.into(), &4.into()));
    // One sample a pixel says nothing about its error.
    assert!(stats["relative_error"].is_null() && stats["nonfinite"] == 0);
}

#[test]
fn stats_tell_the_error_with_its_standard_error() {
    let place = Place::new();
    let stats = place.path("a.json");
    render(&place, "a.pfm", &["--stats", &stats, "--crop", "2,2,6,5", "--engine", "scalar"]);
    let read = |path: &str| serde_json::from_str::<serde_json::Value>(&fs::read_to_string(path).unwrap()).unwrap();
    let one = read(&stats);
    assert!(one["relative_error"].is_null() && one["stages"].as_array().unwrap().is_empty());
    assert_eq!(
        (&one["crop"], &one["width"], &one["engine"]),
        (&serde_json::json!([2, 2, 6, 5]), &16.into(), &"scalar".into())
    );
    let path = place.path("b.exr");
    let film = ["--width", "16", "--height", "16", "--spp", "8", "--stats", &stats];
    assert!(octray(&[&["render", CORNELL, "-o", &path], &film[..]].concat()).status.success());
    let eight = read(&stats);
    let [error, its_error] = ["relative_error", "relative_error_se"].map(|key| eight[key].as_f64().unwrap());
    assert!(error > 0.0 && its_error > 0.0 && its_error < error, "{error} {its_error}");
}

/// The summary calls what the samples tell noise, and says what it is; only `diff` and `converge` speak of relative errors.
#[test]
fn the_summary_names_the_noise_and_how_to_go_on() {
    let place = Place::new();
    let (path, stats) = (place.path("a.png"), place.path("a.json"));
    let film = ["--width", "16", "--height", "16", "--stats", &stats];
    let summary = |flags: &[&str]| {
        let output = octray(&[&["render", CORNELL, "-o", &path], &film[..], flags].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let text = stdout(&output);
        assert!(text.lines().count() == 4 && !text.contains("error "), "{text}");
        (text.lines().nth(2).unwrap().to_owned(), text.lines().nth(3).unwrap().to_owned())
    };
    let told = |flags: &[&str]| {
        let (noise, next) = summary(flags);
        let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(&stats).unwrap()).unwrap();
        let measured = stats["relative_error"].as_f64().unwrap();
        let shown: f64 = noise.strip_prefix("  noise ").unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((shown / 100.0 / measured - 1.0).abs() < 0.01, "{noise} {measured}");
        (noise, next)
    };
    let (noise, next) = told(&["--spp", "8"]);
    assert!(noise.contains(" % of the mean radiance") && noise.ends_with("; --spp 32 halves it"), "{noise}");
    assert_eq!(next, "next: -o NAME.exr keeps radiance and noise, which octray diff compares");
    assert!(told(&["--spp", "400", "--target-error", "50%"]).0.ends_with("; the target of 50 % is reached"));
    assert!(told(&["--spp", "8", "--target-error", "1%"]).0.ends_with("; the target of 1 % is not reached"));
    assert!(summary(&["--spp", "1", "--sampler", "independent"]).0.contains("it takes 2 samples"));
    let help = stdout(&octray(&["render", "--help"])).split_whitespace().collect::<Vec<_>>().join(" ");
    for text in
        ["root of the mean variance of the pixels' means over the mean radiance", "the outlier is its own reference"]
    {
        assert!(help.contains(text), "{text}: {help}");
    }
}

#[test]
fn quiet_says_nothing_and_other_flags_reach_the_render() {
    let place = Place::new();
    let path = place.path("a.pfm");
    let output = octray(&[&["render", CORNELL, "-o", &path, "--quiet"], &SMALL[..]].concat());
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    let plain = Image::read(&path).unwrap();
    assert_eq!(plain, render(&place, "b.pfm", &["--seed", "0", "--strategy", "mis-power", "--threads", "2"]));
    assert_eq!(plain, render(&place, "b.pfm", &["--engine", "scalar"]));
    assert_ne!(plain, render(&place, "b.pfm", &["--seed", "1"]));
    assert_ne!(plain, render(&place, "b.pfm", &["--strategy", "bsdf"]));
    assert_ne!(plain, render(&place, "b.pfm", &["--max-depth", "1"]));
    let crop = render(&place, "b.pfm", &["--crop", "3,5,4,2"]);
    assert_eq!((crop.width, crop.height), (4, 2));
    assert_eq!((crop.pixel(0, 0), crop.pixel(3, 1)), (plain.pixel(3, 5), plain.pixel(6, 6)));
}

#[test]
fn flags_go_over_the_scene_and_the_scene_over_defaults() {
    let place = Place::new();
    let scenes = PathBuf::from(CORNELL);
    // A backslash would begin an escape.
    let obj = scenes.with_file_name("cornell.obj").to_string_lossy().replace('\\', "/");
    let text = fs::read_to_string(CORNELL).unwrap().replace("cornell.obj", &obj);
    let text = text.replace("[render]", "[render]\nstrategy = \"nee\"\nseed = 7\nmax_depth = 3\nrr_depth = \"off\"");
    let scene = place.scene("a.toml", &text);
    let settings = |flags: &[&str]| {
        let (image, stats) = (place.path("a.pfm"), place.path("a.json"));
        let output = octray(&[&["render", &scene, "-o", &image, "--stats", &stats], &SMALL[..], flags].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
        ["strategy", "seed", "max_depth", "rr_depth", "lights"].map(|key| stats[key].to_string()).join(" ")
    };
    assert_eq!(settings(&[]), "\"nee\" 7 3 null \"learned\"");
    let flags = ["--strategy", "bsdf", "--seed", "8", "--max-depth", "0", "--rr-depth", "5", "--lights", "power"];
    assert_eq!(settings(&flags), "\"bsdf\" 8 0 5 \"power\"");
}

#[test]
fn time_stops_on_whole_passes_and_equals_the_samples_it_reached() {
    let place = Place::new();
    let (image, stats) = (place.path("a.pfm"), place.path("a.json"));
    let film = ["--width", "16", "--height", "16"];
    let timed = ["render", CORNELL, "-o", &image, "--time", "0.05", "--stats", &stats];
    let output = octray(&[&timed, &film[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
    let spp = stats["spp"].to_string();
    assert!(stats["spp"].as_u64() >= Some(1) && stats["finished"] == true);
    let same = place.path("b.pfm");
    assert!(octray(&[&["render", CORNELL, "-o", &same, "--spp", &spp], &film[..]].concat()).status.success());
    assert_eq!(fs::read(image).unwrap(), fs::read(same).unwrap());
}

#[test]
fn a_black_picture_is_written_with_a_warning() {
    let place = Place::new();
    let path = place.path("a.png");
    // Emission alone, of a corner of the box that shows none.
    let flags = ["--max-depth", "0", "--crop", "0,15,1,1", "--quiet"];
    let output = octray(&[&["render", CORNELL, "-o", &path], &SMALL[..], &flags].concat());
    assert!(output.status.success() && Path::new(&path).exists());
    assert!(stderr(&output).contains("warning: the finished image is all black"), "{}", stderr(&output));
}

#[test]
fn info_lists_tables_plan_and_what_is_left_out() {
    let place = Place::new();
    let text = octray(&["info", CORNELL]);
    assert!(text.status.success(), "{}", stderr(&text));
    for word in ["film", "triangles", "tables", "light records", "plan of mis-power", "left out", "environment"] {
        assert!(stdout(&text).contains(word), "{word}: {}", stdout(&text));
    }
    for (flags, lines) in [
        (
            &[][..],
            [
                "strategy mis-power",
                "light selection learned (here: uniform)",
                "sampler sobol",
                "roulette auto, from depth 3 on",
            ],
        ),
        (
            &["--lights", "power", "--strategy", "nee-sum", "--sampler", "independent", "--rr-depth", "off"],
            [
                "strategy nee-sum (biased)",
                "light selection power (here: power (alias table))",
                "sampler independent",
                "roulette off",
            ],
        ),
        (
            &["--strategy", "bsdf", "--max-depth", "5"],
            ["strategy bsdf", "light selection learned (not used: no light is sampled)", "max depth 5", "seed 0"],
        ),
    ] {
        let text = stdout(&octray(&[&["info", CORNELL], flags].concat()));
        let found: Vec<String> = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        assert!(lines.iter().all(|line| found.iter().any(|found| found == line)), "{lines:?}: {text}");
    }
    let printed = octray(&["info", CORNELL, "--strategy", "bsdf", "--json"]);
    let path = place.path("info.json");
    assert!(octray(&["info", CORNELL, "--strategy", "bsdf", &format!("--json={path}")]).status.success());
    for json in [stdout(&printed), fs::read_to_string(path).unwrap()] {
        let info: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert!(info["features"].is_object() && info["lights"].as_u64() > Some(0), "{json}");
        assert!(info["triangles"].as_u64() > Some(10) && info["simd"] == octray::simd_level());
        assert!(info["tables"].as_array().unwrap().iter().all(|table| table["bytes"].as_u64() > Some(0)));
        assert!(
            info["plan"].as_array().unwrap().iter().all(|row| row["stage"].is_string() && row["variant"].is_string())
        );
        let left_out = info["left_out"].as_array().unwrap();
        assert!(left_out.iter().any(|row| row["what"] == "light sampling" && row["why"].is_string()), "{json}");
    }
}

#[test]
fn trace_tells_a_path_on_which_both_engines_agree() {
    let trace = |flags: &[&str]| octray(&[&["trace", CORNELL, "--pixel", "250,300"], flags].concat());
    for sample in ["0", "1", "17"] {
        let output = trace(&["--sample", sample]);
        assert!(output.status.success(), "{}{}", stdout(&output), stderr(&output));
        let text = stdout(&output);
        assert!(text.contains("both engines agree to the last bit on ") && !text.contains("ray by ray"), "{text}");
        for word in [
            "pixel 250,300 of 512 x 512",
            "Depth 0: a camera ray from",
            "(tall_block: diffuse)",
            "Light sample: triangle",
            "(lamp), chosen with probability 0.5",
            "p_light^2 / (p_light^2 + p_bsdf^2)",
            "So the sample has the radiance",
            "legend",
        ] {
            assert!(text.contains(word), "{word}: {text}");
        }
        let both = stdout(&trace(&["--sample", sample, "--both"]));
        assert!(both.contains("shadow gain       both ") && !both.lines().any(|line| line.starts_with('>')), "{both}");
        let narrow = Command::new(env!("CARGO_BIN_EXE_octray"))
            .args(["trace", CORNELL, "--pixel", "250,300", "--sample", sample, "--both"])
            .env("COLUMNS", "80")
            .output()
            .unwrap();
        assert!(stdout(&narrow).lines().all(|line| line.len() <= 80), "{}", stdout(&narrow));
        assert!(both.lines().all(|line| line.len() <= 120), "{both}");
    }
}

#[test]
fn trace_gives_the_path_as_json() {
    let film = ["--width", "16", "--height", "16", "--sample", "2", "--json"];
    let mut events = std::collections::BTreeSet::new();
    for (x, y) in (0..16).step_by(3).flat_map(|x| (0..16).step_by(3).map(move |y| (x, y))) {
        let pixel = format!("{x},{y}");
        let output = octray(&[&["trace", CORNELL, "--pixel", &pixel], &film[..]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let path: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((&path["agree"], &path["pixel"]), (&true.into(), &serde_json::json!([x, y])));
        assert!(path["first_difference"].is_null() && path["light_selection"] == "learned" && path["rr_depth"] == 3);
        assert_eq!(path["scalar"], path["packet"]);
        let steps = path["steps"].as_array().unwrap();
        let of = |event: &str| steps.iter().filter(|step| step["event"] == event).count();
        assert_eq!(of("ray"), path["scalar"].as_array().unwrap().len());
        let radiance = steps.last().unwrap()["radiance"].as_array().unwrap();
        for (told, found) in radiance.iter().zip(path["radiance"].as_array().unwrap()) {
            assert_eq!(told.as_f64().unwrap() as f32, found.as_f64().unwrap() as f32);
        }
        for step in steps {
            events.insert(step["event"].as_str().unwrap().to_owned());
            match step["event"].as_str().unwrap() {
                "light sample" | "light sample, blocked" => {
                    let light = &step["light"];
                    assert!(light["triangle"]["material"] == "lamp" && light["probability"] == 0.5, "{step}");
                    assert_eq!(step["blocked"], step["event"] == "light sample, blocked");
                    assert!(step["gain"][0].as_f64() > Some(0.0) && step["pdf"].is_f64(), "{step}");
                }
                "hit" => assert!(step["triangle"]["material"].is_string() && step["t"].is_f64(), "{step}"),
                "roulette" | "roulette survived" => assert!(step["survival"].as_f64() > Some(0.0), "{step}"),
                "diffuse" => assert!(step["pdf"].is_f64() && step.get("delta").is_none(), "{step}"),
                _ => {}
            }
        }
    }
    for event in ["light sample", "light sample, blocked", "roulette", "roulette survived", "hit", "miss", "diffuse"] {
        assert!(events.contains(event), "{event}: {events:?}");
    }
}

#[test]
fn bench_rows_have_the_contract_keys() {
    let output = octray(&["bench", CORNELL, "--runs", "1", "--size", "48", "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let rows: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    let rows = rows.as_array().unwrap();
    for row in rows {
        assert!(row["what"].is_string() && row["engine"].is_string() && row["runs"] == 1, "{row}");
        assert!(row["mrays_per_s"].is_f64() || row["ns_per_item"].is_f64(), "{row}");
        assert!(row.get("lanes_used").is_some() && (row["clock"] == "cpu" || row["clock"] == "wall"), "{row}");
    }
    for what in ["camera", "shadow", "bounce 1", "bounce 3"].map(|rays| format!("{rays} closest")) {
        let of = |engine: &str| rows.iter().find(|row| row["what"] == what && row["engine"] == engine).unwrap();
        let packet = of("packet");
        assert!(packet["hits"].as_u64() > Some(0) && packet["walk"].is_string(), "{packet}");
        for engine in ["one ray", "scalar", "obvhs"].map(of) {
            assert!(engine["mrays_per_s"].as_f64() > Some(0.0), "{engine}");
            assert!(engine["engine"] == "obvhs" || engine["hits"] == packet["hits"], "{engine}");
        }
    }
    let renders = rows.iter().filter(|row| row["what"] == "render" && row["mpaths_per_s"].as_f64() > Some(0.0));
    assert_eq!(renders.count(), 2);
    assert!(rows.iter().any(|row| row["what"] == "intersect_shadow" && row["clock"] == "wall"));
    let lights = octray::Lights::ALL.iter().map(|lights| format!("light sample ({})", lights.name()));
    for what in lights.chain(["point by area", "point by solid angle"].map(str::to_owned)) {
        let of = |engine: &str| rows.iter().find(|row| row["what"] == what && row["engine"] == engine).unwrap();
        assert!(of("packet")["lanes_used"].as_f64() > Some(0.0) && of("packet")["clock"] == "cpu", "{what}");
        assert!(["packet", "scalar"].map(of).iter().all(|row| row["ns_per_item"].as_f64() > Some(0.0)), "{what}");
    }
}

#[test]
fn bench_tells_how_renders_scale() {
    let place = Place::new();
    let (plot, file) = (place.path("new/scaling.svg"), place.path("scaling.json"));
    let flag = format!("--json={file}");
    let output = octray(&["bench", CORNELL, "--scaling", "--runs", "1", "--size", "64", "--plot", &plot, &flag]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    let rows: serde_json::Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    let of = |what: &str| rows.as_array().unwrap().iter().filter(|row| row["what"] == what).collect::<Vec<_>>();
    for what in ["triangles", "lights", "bounces", "pixels", "threads"] {
        let rows = of(what);
        assert!(text.contains(&format!(" {what} ")) && rows.len() >= 2, "{what}: {text}");
        for (i, row) in rows.iter().enumerate() {
            assert!(row["ns_per_path"].as_f64() > Some(0.0) && row["wall_s"].as_f64() > Some(0.0), "{row}");
            assert_eq!((row["growth"].is_f64(), row["runs"].as_u64()), (i > 0, Some(1)), "{row}");
            assert_eq!(row["prepare_s"].as_f64() > Some(0.0), what == "triangles" || what == "lights", "{row}");
            assert!(i == 0 || row["size"].as_u64() > rows[i - 1]["size"].as_u64(), "{row}");
            // Three a tile, and at the end of a pass one a worker; helpers and who leads them meet before and after it.
            let [tiles, operations, threads] =
                ["tiles", "shared_operations", "threads"].map(|key| row[key].as_u64().unwrap());
            let (each, once) = if threads == 1 { (1, 0) } else { (4 * threads + 1, threads) };
            let others = operations.checked_sub(3 * tiles + once).unwrap();
            assert!(others > 0 && others.is_multiple_of(each), "{row}");
        }
    }
    assert!(of("threads").iter().all(|row| row["speed_up"].as_f64() > Some(0.0) && row["threads"] == row["size"]));
    assert_eq!(of("pixels").last().unwrap()["film"], serde_json::json!([256, 256]));
    let svg = fs::read_to_string(plot).unwrap();
    assert!(svg.starts_with("<svg ") && svg.contains("bounces 1 to 4") && !svg.contains("NaN"));
}

#[test]
fn flags_of_scaling_that_do_not_go_together_are_refused() {
    let place = Place::new();
    let plot = place.path("a.svg");
    refused(&["bench", CORNELL, "--plot", &plot], 2, "--plot draws what --scaling measures: add --scaling");
    refused(&["bench", CORNELL, "--scaling", "--max-depth", "3"], 2, "--scaling varies --max-depth itself");
    refused(&["bench", CORNELL, "--scaling", "--plot", &place.path("a.png")], 2, "name a .svg file");
    fs::write(place.path("file"), "").unwrap();
    // Before the scene is read.
    let scene = place.path("none.toml");
    refused(&["bench", &scene, "--scaling", "--plot", &place.path("file/a.svg")], 1, "file is not a directory");
    assert!(!Path::new(&plot).exists());
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    use std::process::Stdio;
    let mut child =
        Command::new(env!("CARGO_BIN_EXE_octray")).args(["info", CORNELL]).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}
