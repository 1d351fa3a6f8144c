//! Where renders stop: at a target error that is what it says, at an interrupt, and how they go on after one.

use crate::common::{first_difference, prepared, small};
use crate::program::{octray, stderr};
use octray::internal::image::Image;
use octray::{Engine, Film, Sampler, Settings, Strategy, render, render_from};
use std::fs;
// What only the tests of interrupts need, which look into `/proc`.
#[cfg(target_os = "linux")]
use {
    octray::{Crop, internal::film::checkpoint},
    std::path::Path,
    std::process::{Command, Output},
};

const CORNELL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");

/// The error of `film`: root mean square over pixels and channels, by the mean of the truth.
fn true_error(film: &Film, truth: &Film) -> f64 {
    let (mut squares, mut mean) = (0.0, 0.0);
    for y in 0..film.height {
        for x in 0..film.width {
            let (a, b, noise) = (film.mean(x, y), truth.mean(x, y), truth.variance(x, y));
            for c in 0..3 {
                squares += (a[c] as f64 - b[c] as f64).powi(2) - noise[c] as f64;
                mean += b[c] as f64;
            }
        }
    }
    let count = 3.0 * film.pixels.len() as f64;
    (squares.max(0.0) / count).sqrt() / (mean / count)
}

/// Of `seeds` renders that stop at `target`, those whose true error lies in the interval they state, and whose lies below
/// and above it.
fn calibration(scene: &str, strategy: Strategy, size: (u32, u32), target: f64, truth_spp: u32, seeds: u32) -> [u32; 3] {
    let scene = prepared(scene);
    let base = Settings { threads: 0, ..small(size.0, size.1, truth_spp) };
    let truth = render(&scene, &Settings { seed: 1 << 20, ..base.clone() }).film;
    let (mut inside, mut below, mut above) = (0, 0, 0);
    for seed in 0..seeds {
        let settings = Settings { strategy, seed, spp: u32::MAX, target_error: Some(target), ..base.clone() };
        let done = render(&scene, &settings);
        let (error, standard_error) = done.film.relative_error_estimate().unwrap();
        assert!(error <= target && done.film.spp >= 16 && done.stats.finished, "{error} {}", done.film.spp);
        match (true_error(&done.film, &truth) - error) / standard_error {
            z if z < -1.96 => below += 1,
            z if z > 1.96 => above += 1,
            _ => inside += 1,
        }
    }
    [inside, below, above]
}

#[test]
fn the_stated_interval_holds_the_true_error_as_often_as_stated() {
    // 95 of 100, less 3.3 binomial standard deviations (fixed seeds; 99.9 % for a calibrated interval).
    let [inside, below, above] = calibration("scenes/cornell.toml", Strategy::Nee, (24, 24), 0.15, 16_384, 100);
    println!("nee: {inside} inside, {below} below, {above} above");
    assert!(inside >= 88, "{inside} inside, {below} below, {above} above");
}

#[test]
#[ignore = "minutes: cargo test --release --test estimators stopping -- --ignored --nocapture"]
fn the_stated_interval_holds_for_other_strategies_and_scenes() {
    for (scene, strategy, target) in [
        ("scenes/cornell.toml", Strategy::MisPower, 0.05),
        ("scenes/cornell.toml", Strategy::Bsdf, 0.5),
        ("scenes/lecture_lights.toml", Strategy::MisBalance, 0.05),
    ] {
        let [inside, below, above] = calibration(scene, strategy, (32, 24), target, 1 << 14, 100);
        println!("{scene} {strategy}: {inside} inside, {below} below, {above} above");
        assert!(inside >= 88, "{scene} {strategy}: {inside} inside, {below} below, {above} above");
    }
}

#[test]
fn a_render_that_goes_on_has_the_bits_of_one_that_never_stopped() {
    let scene = prepared("scenes/cornell.toml");
    for &sampler in Sampler::ALL {
        for &engine in Engine::ALL {
            let settings = |spp: u32| Settings { sampler, engine, ..small(21, 17, spp) };
            let whole = render(&scene, &settings(23));
            let part = render(&scene, &settings(9)).film;
            let on = render_from(&scene, &settings(23), Some(part.clone()), &|_| true);
            assert_eq!(first_difference(&whole.film, &on.film), None, "{sampler} {engine}");
            assert_eq!(whole.film.to_image(), on.film.to_image(), "{sampler} {engine}");
            // Nothing left to do: the picture as it is.
            let same = render_from(&scene, &settings(9), Some(part.clone()), &|_| true);
            assert_eq!((first_difference(&same.film, &part), same.stats.rays.total()), (None, 0));
        }
    }
}

#[test]
fn a_target_error_stops_and_equals_the_samples_it_reached() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
    let (image, stats) = (path("a.pfm"), path("a.json"));
    let film = ["--width", "24", "--height", "24"];
    let output =
        octray(&[&["render", CORNELL, "-o", &image, "--target-error", "20%", "--stats", &stats], &film[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
    let error = stats["relative_error"].as_f64().unwrap();
    let [low, high] = [0, 1].map(|i| stats["relative_error_interval"][i].as_f64().unwrap());
    assert!(error <= 0.2 && low < error && error < high, "{stats}");
    assert!(stats["finished"] == true && stats["target_error"] == 0.2 && stats["resumed_from_spp"] == 0);
    let (same, spp) = (path("b.pfm"), stats["spp"].to_string());
    assert!(octray(&[&["render", CORNELL, "-o", &same, "--spp", &spp], &film[..]].concat()).status.success());
    assert_eq!(fs::read(image).unwrap(), fs::read(same).unwrap());
    // The first of several limits stops.
    let image = path("c.exr");
    let few = ["--spp", "3", "--target-error", "0.0001"];
    assert!(octray(&[&["render", CORNELL, "-o", &image], &few[..], &film].concat()).status.success());
    assert!(Image::read(image).unwrap().metadata.iter().any(|(key, value)| key == "spp" && value == "3"));
    // A black picture has no relative error; it is not waited for.
    let black = ["--target-error", "0.01", "--max-depth", "0", "--crop", "0,23,1,1"];
    let output = octray(&[&["render", CORNELL, "-o", &path("d.pfm")], &black[..], &film].concat());
    assert!(output.status.success() && stderr(&output).contains("all black"), "{}", stderr(&output));
}

/// Starts the program, waits until it listens to interrupts, interrupts it.
#[cfg(target_os = "linux")]
fn interrupted(arguments: &[&str], patience: std::time::Duration) -> Output {
    use std::process::Stdio;
    let mut child = Command::new(env!("CARGO_BIN_EXE_octray"))
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let listens = || {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0");
        u64::from_str_radix(caught.trim(), 16).is_ok_and(|mask| mask & 2 != 0)
    };
    while !listens() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    std::thread::sleep(patience);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupted_render_writes_what_it_has_and_goes_on() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
    let (image, state) = (path("a.exr"), path("a.exr.unfinished"));
    let flags = ["render", CORNELL, "--width", "33", "--height", "20", "-o"];
    let render = |image: &str, more: &[&str]| octray(&[&flags[..], &[image], more].concat());

    let endless = [&flags[..], &[&image, "--spp", "4000000000"]].concat();
    let output = interrupted(&endless, std::time::Duration::from_millis(200));
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let message = stderr(&output);
    assert!(message.contains("of 4000000000 samples a pixel; the same command goes on from there"), "{message}");
    let samples = message.split("stopped after ").nth(1).unwrap().split(" of ").next().unwrap();
    let numbers: Vec<u32> = samples.split(" to ").map(|number| number.parse().unwrap()).collect();
    let most = *numbers.last().unwrap();
    // The picture so far has a name of its own, so that an older image stays until there is another.
    let written = Image::read(path("a.partial.exr")).unwrap();
    assert!(written.metadata.iter().any(|(key, value)| key == "spp" && *value == samples));
    assert!(!Path::new(&image).exists());

    // Another render would lose this one's work: it is refused, and so is one that asks for less.
    for (flags, message) in [
        (&["--strategy", "bsdf"][..], "with strategy mis-power, and this one has bsdf"),
        (&["--seed", "3"], "with seed 0, and this one has 3"),
        (&["--height", "21"], "with film 33 x 20, and this one has 33 x 21"),
        (&["--spp", "1"], "ask for more samples or delete that file"),
    ] {
        let flags = [&["--spp", "4000000000"][..], flags].concat();
        let flags = if flags.contains(&"1") { vec!["--spp", "1"] } else { flags };
        let height = flags.contains(&"--height");
        let output = match height {
            true => octray(&["render", CORNELL, "--width", "33", "--height", "21", "-o", &image]),
            false => render(&image, &flags),
        };
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{flags:?}: {}", stderr(&output));
    }

    // On to a number of samples that ends: the same file as without a break, and nothing left beside it.
    let more = (most + 11).to_string();
    let output = render(&image, &["--spp", &more, "--engine", "scalar", "--threads", "2"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains(&format!("with {samples} samples a pixel")), "{}", stderr(&output));
    let whole = path("b.exr");
    assert!(render(&whole, &["--spp", &more]).status.success());
    assert_eq!(fs::read(&image).unwrap(), fs::read(whole).unwrap());
    assert!(!Path::new(&state).exists() && !Path::new(&path("a.partial.exr")).exists());

    // So is the state of a version that names other things.
    let settings = [("version".to_owned(), "0.0.1".to_owned())];
    let film = Film { spp: 1, ..Film::new(Crop { x: 0, y: 0, width: 33, height: 20 }) };
    checkpoint::write(Path::new(&state), &settings, (1.0, false), &film).unwrap();
    let output = render(&image, &["--spp", "2"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("an unfinished render of another version of octray"), "{}", stderr(&output));

    // A damaged state is named, and kept.
    fs::write(&state, "damaged").unwrap();
    let output = render(&image, &["--spp", "2"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("a.exr.unfinished: not an unfinished render, or a damaged one"),
        "{}",
        stderr(&output)
    );
    assert!(Path::new(&state).exists());
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupted_converge_reports_what_it_has_and_goes_on() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("report").to_str().unwrap().to_owned();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.toml");
    let flags =
        ["converge", scene, "--out", &out, "--strategies", "bsdf,nee", "--width", "16", "--height", "16", "--repeats"];
    let rows = || {
        let text = fs::read_to_string(format!("{out}/converge.csv")).unwrap();
        // All but the times of the runs.
        let fields = |line: &str| {
            let fields: Vec<&str> = line.split(',').collect();
            [&fields[..6], &fields[8..]].concat().join(",")
        };
        text.lines().skip(1).map(fields).collect::<Vec<_>>()
    };
    let output = interrupted(&[&flags[..], &["10000"]].concat(), std::time::Duration::from_millis(300));
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("the same command goes on from there"), "{}", stderr(&output));
    let first = rows();
    let json = fs::read_to_string(format!("{out}/converge.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(
        json["finished"] == false
            && fs::read_to_string(format!("{out}/report.html")).unwrap().contains("Stopped after")
    );
    // On to the end of a repeat that ends; the runs of the first call are not made again.
    let repeats = (first.len() / 10 + 2).to_string();
    let output = octray(&[&flags[..], &[&repeats]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains(&format!("with {} runs", first.len())), "{}", stderr(&output));
    let all = rows();
    assert_eq!((&all[..first.len()], all.len()), (&first[..], (first.len() / 10 + 2) * 10));
    assert!(!Path::new(&format!("{out}/converge.unfinished")).exists());
}
