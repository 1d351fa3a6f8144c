//! Long renders: stopped, killed, resumed, extended; in parts, on full disks. Whatever happens, the picture has the bits of one
//! that nothing happened to.
#![cfg(unix)]

use crate::program::{Place, octray, stderr};
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const SMALL: [&str; 6] = ["--width", "48", "--height", "40", "--threads", "2"];

fn begin(arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_octray"));
    command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Waits until there is a file.
fn until(path: &str) {
    let begun = Instant::now();
    while !Path::new(path).exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{path} never came");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn names(place: &Place) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<String> = fs::read_dir(place.0.path()).unwrap().map(name).collect();
    names.sort();
    names
}

fn fine(arguments: &[&str]) -> String {
    let done = octray(arguments);
    assert!(done.status.success(), "{arguments:?}: {}", stderr(&done));
    stderr(&done)
}

fn refused(arguments: &[&str], status: i32, message: &str) {
    let done = octray(arguments);
    let said = stderr(&done);
    assert_eq!(done.status.code(), Some(status), "{arguments:?}: {said}");
    assert!(said.contains(message), "{said}");
}

/// The same scene, never finished by itself.
fn endless<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let render = ["render", "scenes/glass.toml", "-o", output, "--spp", "4000000", "--quiet"];
    [&render[..], &SMALL, more].concat()
}

/// Ends after `spp` samples.
fn of_spp<'a>(output: &'a str, spp: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let render = ["render", "scenes/glass.toml", "-o", output, "--spp", spp, "--quiet"];
    [&render[..], &SMALL, more].concat()
}

#[test]
fn every_wish_to_stop_is_heard_soon_and_the_picture_goes_on() {
    let place = Place::new();
    let (image, state) = (place.path("a.pfm"), place.path("a.pfm.unfinished"));
    fs::write(&image, "the old one").unwrap();
    for (number, signal) in ["INT", "TERM", "HUP", "QUIT"].into_iter().enumerate() {
        let mut render = begin(&endless(&image, &["--every", "50ms"]));
        until(&state);
        // The first checkpoint of the next one is newer.
        std::thread::sleep(Duration::from_millis(200));
        let asked = Instant::now();
        send(&render, signal);
        let ended = render.wait().unwrap();
        assert!(asked.elapsed() < Duration::from_secs(5), "SIG{signal} took {:?}", asked.elapsed());
        let mut said = String::new();
        render.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!(ended.code(), Some(1), "{said}");
        assert!(said.contains("the same command goes on from there") && said.contains("a.partial.pfm"), "{said}");
        assert_eq!(said.contains("going on from"), number > 0, "{said}");
        assert_eq!(fs::read(&image).unwrap(), b"the old one");
        assert_eq!(names(&place), ["a.partial.pfm", "a.pfm", "a.pfm.unfinished"]);
    }
}

/// Killed at all sorts of moments, in the middle of a pass or of a checkpoint; ended by another engine and another order of
/// outputs; then extended.
#[test]
fn a_render_that_was_killed_again_and_again_has_the_bits_of_one_that_was_not() {
    let place = Place::new();
    let [whole, parts, other, longer] =
        ["whole.pfm", "parts.pfm", "other.pfm", "longer.pfm"].map(|name| place.path(name));
    fine(&of_spp(&whole, "1500", &[]));
    let mut kills = 0;
    for number in 0u64..12 {
        let mut render = begin(&of_spp(&parts, "1500", &["-o", &other, "--every", "20ms"]));
        std::thread::sleep(Duration::from_millis(30 + number * 37 % 200));
        kills += u32::from(render.try_wait().unwrap().is_none());
        let _ = render.kill();
        render.wait().unwrap();
        if number == 6 {
            // A killed run may leave a temporary file; the next one removes it.
            fs::write(place.path(".octray-left.tmp"), "x").unwrap();
        }
    }
    assert!(kills > 0);
    fine(&of_spp(&other, "1500", &["-o", &parts, "--keep-checkpoint", "--engine", "scalar"]));
    assert_eq!(fs::read(&parts).unwrap(), fs::read(&whole).unwrap());
    assert_eq!(fs::read(&other).unwrap(), fs::read(&whole).unwrap());
    let temporary = |name: &&String| name.ends_with(".tmp");
    assert_eq!(names(&place).iter().filter(temporary).count(), 0, "{:?}", names(&place));
    // The state may have been begun under either name.
    let states = names(&place).into_iter().filter(|name| name.ends_with(".unfinished")).collect::<Vec<_>>();
    assert_eq!(states.len(), 1, "{states:?}");
    refused(&of_spp(&parts, "3000", &["-o", &other]), 2, "--resume goes on from it");
    fine(&of_spp(&parts, "3000", &["-o", &other, "--resume"]));
    fine(&of_spp(&longer, "3000", &[]));
    assert_eq!(fs::read(&parts).unwrap(), fs::read(&longer).unwrap());
    assert_eq!(names(&place), ["longer.pfm", "other.pfm", "parts.pfm", "whole.pfm"]);
    refused(&of_spp(&parts, "6000", &["--resume"]), 2, "no such checkpoint to resume");
}

/// One that asks for another picture, or a damaged file, is refused and left as it is.
#[test]
fn what_a_checkpoint_is_not_for_is_said() {
    let place = Place::new();
    let (image, state) = (place.path("a.pfm"), place.path("kept"));
    let keep = ["--checkpoint", state.as_str(), "--keep-checkpoint"];
    fine(&of_spp(&image, "16", &keep));
    let kept = fs::read(&state).unwrap();
    let resume = ["--checkpoint", state.as_str(), "--resume"];
    refused(&of_spp(&image, "32", &[&resume[..], &["--seed", "9"]].concat()), 2, "with seed 0, and this one has 9");
    refused(&of_spp(&image, "8", &resume), 2, "16 samples a pixel, more than 8");
    refused(
        &of_spp(&image, "32", &[&resume[..], &["--shard", "1/2"]].concat()),
        2,
        "with part all, and this one has 1/2",
    );
    for (place, message) in [(3, "damaged"), (kept.len() / 2, "damaged"), (kept.len() - 1, "damaged")] {
        let mut changed = kept.clone();
        changed[place] ^= 1;
        fs::write(&state, &changed).unwrap();
        refused(&of_spp(&image, "32", &resume), 2, message);
        assert_eq!(fs::read(&state).unwrap(), changed);
    }
}

/// A mask is part of the scene, though only its content changes.
#[test]
fn a_scene_whose_files_have_changed_is_another_one() {
    let place = Place::new();
    let [scene, obj, mtl, mask, out] = ["s.toml", "s.obj", "s.mtl", "m.png", "a.pfm"].map(|name| place.path(name));
    fs::write(&scene, "[[mesh]]\nobj = \"s.obj\"\n[environment]\nradiance = [1, 1, 1]\n").unwrap();
    fs::write(&obj, "mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n")
        .unwrap();
    fs::write(&mtl, "newmtl m\nKd 0.5 0.5 0.5\nmap_d m.png\n").unwrap();
    let paint = |grey: [u8; 2]| image::GrayImage::from_raw(2, 1, grey.to_vec()).unwrap().save(&mask).unwrap();
    paint([255, 0]);
    let render = |spp: &str, more: &[&str]| {
        octray(
            &[&["render", &scene, "-o", &out, "--spp", spp, "--quiet", "--keep-checkpoint"][..], &SMALL, more].concat(),
        )
    };
    assert!(render("4", &[]).status.success());
    paint([0, 255]);
    let refused = render("8", &["--resume"]);
    assert!(stderr(&refused).contains("content of the scene"), "{}", stderr(&refused));
    paint([255, 0]);
    assert!(render("8", &["--resume"]).status.success());
}

/// What cannot be written at the end does not cost what was rendered.
#[test]
fn a_finished_render_outlives_its_output() {
    let place = Place::new();
    let [image, whole, preview] = ["a.pfm", "b.pfm", "p.pfm"].map(|name| place.path(name));
    fine(&of_spp(&whole, "2000", &[]));
    let render = begin(&of_spp(&image, "2000", &["--preview", &preview, "--preview-every", "1ms"]));
    until(&preview);
    fs::create_dir(&image).unwrap();
    let done = render.wait_with_output().unwrap();
    let said = stderr(&done);
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("it is a directory") && said.contains("is kept in"), "{said}");
    fs::remove_dir(&image).unwrap();
    fine(&of_spp(&image, "2000", &[]));
    assert_eq!(fs::read(&image).unwrap(), fs::read(&whole).unwrap());
    assert_eq!(names(&place), ["a.pfm", "b.pfm", "p.pfm"]);
}

/// Where the system allows no more threads, those that there are do the work. (Limits on processes do not hold for root.)
#[test]
#[cfg(target_os = "linux")]
fn threads_that_cannot_be_started_are_done_without() {
    let place = Place::new();
    let image = place.path("a.pfm");
    let program = env!("CARGO_BIN_EXE_octray");
    fs::set_permissions(place.0.path(), std::os::unix::fs::PermissionsExt::from_mode(0o777)).unwrap();
    let limited = ["--reuid=65534", "--clear-groups", "prlimit", "--nproc=1:1"];
    let reaches =
        Command::new("setpriv").args(limited).args(["test", "-x", program, "-a", "-r", "scenes/furnace.toml"]).status();
    if !reaches.is_ok_and(|status| status.success()) {
        println!("skipped: no other user can be one here, or reach {program}");
        return;
    }
    let render = ["render", "scenes/furnace.toml", "-o", &image, "--spp", "4", "--quiet", "--threads", "8"];
    let done = Command::new("setpriv").args(limited).arg(program).args(render).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    assert!(stderr(&done).contains("only 1 of 8 threads could be started"), "{}", stderr(&done));
    let whole = place.path("b.pfm");
    fine(&["render", "scenes/furnace.toml", "-o", &whole, "--spp", "4", "--quiet"]);
    assert_eq!(fs::read(&image).unwrap(), fs::read(&whole).unwrap());
}

/// A folder that vanishes is made again.
#[test]
fn a_vanished_folder_costs_nothing() {
    let place = Place::new();
    let [image, whole, preview] = ["new/a.pfm", "b.pfm", "p.pfm"].map(|name| place.path(name));
    fine(&of_spp(&whole, "2000", &[]));
    let render = begin(&of_spp(&image, "2000", &["--preview", &preview, "--preview-every", "1ms"]));
    until(&preview);
    fs::remove_dir_all(place.path("new")).unwrap();
    let done = render.wait_with_output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    assert_eq!(fs::read(&image).unwrap(), fs::read(&whole).unwrap());
}

#[test]
fn outputs_never_replace_inputs() {
    let place = Place::new();
    let [scene, obj, map, link, dangling] =
        ["s.toml", "s.obj", "e.pfm", "link.json", "out.png"].map(|name| place.path(name));
    fine(&of_spp(&map, "1", &[]));
    fs::write(&scene, "[[mesh]]\nobj = \"s.obj\"\n[environment]\nmap = \"e.pfm\"\n").unwrap();
    fs::write(&obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let kept = [&scene, &obj, &map].map(|path| fs::read(path).unwrap());
    std::os::unix::fs::symlink(&scene, &link).unwrap();
    let render = |output: &str, more: &[&str]| {
        [&["render", &scene, "-o", output, "--spp", "1", "--quiet"][..], more]
            .concat()
            .iter()
            .map(|&s| s.to_owned())
            .collect::<Vec<_>>()
    };
    let image = place.path("a.png");
    let json = format!("--json={map}");
    for arguments in [
        render(&map, &[]),
        render(&image, &["--stats", &link]),
        render(&image, &["--preview", &map]),
        render(&image, &["--checkpoint", &obj]),
        vec!["diff".to_owned(), map.clone(), map.clone(), json],
    ] {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let done = octray(&arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {}", stderr(&done));
        assert_eq!([&scene, &obj, &map].map(|path| fs::read(path).unwrap()), kept);
    }
    let twice = format!("--json={image}.json");
    refused(&["render", &scene, "-o", &image, "-o", &image], 2, "named for two outputs");
    refused(&["render", &scene, "-o", &image, "--checkpoint", &image], 2, "named for two outputs");
    let partial = place.path("a.partial.png");
    refused(&["render", &scene, "-o", &image, "-o", &partial], 2, "named for two outputs");
    refused(&["bench", &scene, "--scaling", &twice.replace("json.json", "x"), "--plot", &image], 2, "");
    // A link to what is not there yet is followed.
    std::os::unix::fs::symlink("real.png", &dangling).unwrap();
    fine(&["render", &scene, "-o", &dangling, "--spp", "1", "--quiet"]);
    assert!(fs::symlink_metadata(&dangling).unwrap().is_symlink() && Path::new(&place.path("real.png")).is_file());
}

#[test]
fn only_regular_files_are_read() {
    let place = Place::new();
    let pipe = place.path("pipe.toml");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    refused(&["info", &pipe], 2, "it is a pipe; only regular files are read");
    let obj = place.path("a.obj");
    fs::write(&obj, "mtllib /dev/zero\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    refused(&["info", &obj], 2, "/dev/zero: cannot read it: it is a device; only regular files are read");
    fs::write(&obj, "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert!(fine(&["info", &obj]).contains("cannot read its material file"));
}

/// What files say reaches a terminal as text, and no more of it than can be read.
#[test]
fn messages_obey_nobody_and_have_an_end() {
    let place = Place::new();
    let obj = place.path("a.obj");
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    fs::write(&obj, format!("{corners}usemtl \u{1b}]0;PWNED\u{7}x\nf 1 2 3\n")).unwrap();
    let said = fine(&["info", &obj]);
    assert!(said.contains(r"\u{1b}]0;PWNED\u{7}x") && !said.contains('\u{1b}'), "{said}");
    // Nobody gives a file such a name.
    fs::write(&obj, format!("mtllib \u{1b}]0;PWNED\u{7}x.mtl\n{corners}f 1 2 3\n")).unwrap();
    let done = octray(&["info", &obj]);
    let said = stderr(&done);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains(r"\u{1b}]0;PWNED\u{7}x.mtl") && !said.contains('\u{1b}'), "{said}");
    fs::write(&obj, format!("v 0 0 {}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "9".repeat(5_000_000))).unwrap();
    let done = octray(&["info", &obj]);
    assert_eq!(done.status.code(), Some(2));
    assert!(stderr(&done).len() < 4000 && stderr(&done).contains("bytes ..."), "{} bytes", stderr(&done).len());
    let unknown = octray(&["render", "\u{1b}[31m.toml"]);
    assert!(!stderr(&unknown).contains('\u{1b}'), "{}", stderr(&unknown));
}

/// A limit on the size of files ends a write, not the program; the old file stays.
#[test]
fn a_limit_on_files_is_an_error_of_the_file() {
    let place = Place::new();
    let (image, program) = (place.path("a.pfm"), env!("CARGO_BIN_EXE_octray"));
    fs::write(&image, "old").unwrap();
    let command =
        format!("ulimit -f 16; exec {program} render scenes/cornell.toml -o {image} --spp 1 --width 100 --quiet");
    let done = Command::new("bash").args(["-c", &command]).output().unwrap();
    assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
    assert_eq!((fs::read(&image).unwrap(), names(&place)), (b"old".to_vec(), vec!["a.pfm".to_owned()]));
}

#[test]
fn memory_that_is_not_there_is_said_before_the_work() {
    let place = Place::new();
    let image = place.path("a.pfm");
    let large = ["render", "scenes/cornell.toml", "-o", &image, "--width", "16384", "--height", "16384"];
    refused(&[&large[..], &["--max-memory", "1G"]].concat(), 2, "a film of 16384 x 16384 pixels needs 32 GB of memory");
    let program = env!("CARGO_BIN_EXE_octray");
    let command = format!("ulimit -v 4000000; exec {program} {}", large.join(" "));
    let done = Command::new("bash").args(["-c", &command]).output().unwrap();
    assert_eq!(done.status.code(), Some(2), "{}", stderr(&done));
    assert_eq!(names(&place), Vec::<String>::new());
}

/// Parts in any order, of any number, of a crop, by any engine: the bits of one machine.
#[test]
fn parts_merge_to_the_picture_of_one_machine() {
    let place = Place::new();
    for (count, more) in [
        (3, &["--spp", "20"][..]),
        (7, &["--spp", "3", "--crop", "5,9,30,21", "--sampler", "independent"]),
        (2, &["--spp", "9", "--train", "4096", "--guide", "on", "--lights", "learned"]),
    ] {
        let whole = place.path("whole.exr");
        let render = |output: &str, own: &[&str]| {
            fine(&[&["render", "scenes/door_ajar.toml", "-o", output, "--quiet"][..], &SMALL, more, own].concat());
        };
        render(&whole, &[]);
        let parts: Vec<String> = (1..=count).map(|number| place.path(&format!("part.{number}"))).collect();
        for (number, path) in (1..).zip(&parts) {
            let engine = if number == 2 { "scalar" } else { "packet" };
            render(path, &["--shard", &format!("{number}/{count}"), "--engine", engine]);
        }
        let merged = place.path("merged.exr");
        let reversed: Vec<&str> = parts.iter().rev().map(String::as_str).collect();
        fine(&[&["merge"][..], &reversed, &["-o", &merged]].concat());
        assert_eq!(fs::read(&merged).unwrap(), fs::read(&whole).unwrap());
        // One is missing, one is there twice, one is damaged, one is of another picture.
        fs::remove_file(&merged).unwrap();
        refused(
            &[&["merge"][..], &reversed[1..], &["-o", &merged]].concat(),
            2,
            &format!("part {count} of {count} is missing"),
        );
        let list = octray(&[&["merge", "--list"][..], &reversed[1..]].concat());
        let said = String::from_utf8_lossy(&list.stdout).into_owned();
        assert!(list.status.code() == Some(1) && said.contains("is missing"), "{said}");
        refused(&[&["merge", "-o", &merged, &parts[0]][..], &reversed].concat(), 2, "part 1 of");
        let other = place.path("other");
        render(&other, &["--shard", &format!("1/{count}"), "--seed", "5"]);
        refused(&[&["merge", "-o", &merged][..], &reversed, &[&other]].concat(), 2, "its seed is 5, and not 0");
        let mut damaged = fs::read(&parts[0]).unwrap();
        let middle = damaged.len() / 2;
        damaged[middle] ^= 1;
        fs::write(&parts[0], damaged).unwrap();
        refused(
            &[&["merge", "-o", &merged][..], &reversed].concat(),
            2,
            "part.1: not a part of a render, or a damaged one",
        );
        assert!(!Path::new(&merged).exists());
    }
}

#[test]
fn parts_refuse_what_needs_the_whole_picture() {
    for (flags, message) in [
        (&["--time", "1s"][..], "--time ends all pixels at once"),
        (&["--target-error", "1%"], "goes by the noise of the whole image"),
        (&["--preview", "p.png"], "shows whole images"),
        (&["-o", "b"], "a part is one file"),
    ] {
        refused(&[&["render", "scenes/cornell.toml", "-o", "a", "--shard", "1/2"][..], flags].concat(), 2, message);
    }
    refused(&["render", "scenes/cornell.toml", "-o", "a", "--shard", "3/2"], 2, "give K/N");
}

/// More parts than tiles: some are empty, and count all the same.
#[test]
fn parts_may_be_empty_and_go_on_when_they_are_stopped() {
    let place = Place::new();
    let (whole, merged) = (place.path("whole.png"), place.path("merged.png"));
    let film = ["--width", "30", "--height", "17", "--spp", "5", "--quiet"];
    fine(&[&["render", "scenes/cornell.toml", "-o", &whole][..], &film].concat());
    let parts: Vec<String> = (1..=6).map(|number| place.path(&number.to_string())).collect();
    for (number, path) in (1..).zip(&parts) {
        fine(&[&["render", "scenes/cornell.toml", "-o", path, "--shard", &format!("{number}/6")][..], &film].concat());
    }
    let all: Vec<&str> = parts.iter().map(String::as_str).collect();
    fine(&[&["merge", "-o", &merged][..], &all].concat());
    assert_eq!(fs::read(&merged).unwrap(), fs::read(&whole).unwrap());
    // A part that is killed goes on as an image does.
    let (part, of_whole) = (place.path("p"), place.path("w"));
    let long = |output: &str| {
        of_spp(output, "4000", &["--shard", "1/2", "--every", "10ms"]).iter().map(|&s| s.to_owned()).collect::<Vec<_>>()
    };
    let arguments = long(&part);
    let mut render = begin(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    until(&place.path("p.unfinished"));
    render.kill().unwrap();
    render.wait().unwrap();
    fine(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    fine(&long(&of_whole).iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(fs::read(&part).unwrap(), fs::read(&of_whole).unwrap());
}

#[test]
fn programs_read_progress_as_json() {
    let place = Place::new();
    let (image, preview) = (place.path("a.pfm"), place.path("p.png"));
    let more =
        ["--progress", "json", "--every", "1ms", "--preview", &preview, "--preview-every", "1ms", "--log", "info"];
    let said = fine(&of_spp(&image, "600", &more));
    let events: Vec<serde_json::Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |kind: &str| events.iter().filter(|event| event["event"] == kind).collect::<Vec<_>>();
    assert!(!of("progress").is_empty() && !of("checkpoint").is_empty() && !of("info").is_empty(), "{said}");
    let shares: Vec<f64> = of("progress").iter().map(|event| event["done"].as_f64().unwrap()).collect();
    assert!(shares.is_sorted() && shares.iter().all(|share| (0.0..=1.0).contains(share)), "{said}");
    let last = events.last().unwrap();
    assert!(
        last["event"] == "finished" && last["samples_per_pixel"] == 600 && last["files"][0] == image.as_str(),
        "{said}"
    );
    assert!(Path::new(&preview).is_file());
}

#[test]
fn shells_and_man_get_what_they_read() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let text = octray(&["completions", shell]);
        assert!(text.status.success() && String::from_utf8_lossy(&text.stdout).contains("keep-checkpoint"), "{shell}");
    }
    let folder = place.path("man/man1");
    fine(&["man", "--out", &folder]);
    let page = fs::read_to_string(format!("{folder}/octray-render.1")).unwrap();
    assert!(page.contains(".TH") && page.contains("checkpoint"), "{page}");
    assert!(fs::read_to_string(format!("{folder}/octray.1")).unwrap().contains("octray"));
}

/// The table of a report without the times of its runs.
fn rows(folder: &str) -> Vec<String> {
    let text = fs::read_to_string(format!("{folder}/converge.csv")).unwrap();
    let fields = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        [&fields[..6], &fields[8..]].concat().join(",")
    };
    text.lines().skip(1).map(fields).collect()
}

#[test]
fn parts_of_converge_merge_into_one_report() {
    let place = Place::new();
    let flags = ["--strategies", "bsdf,nee", "--width", "16", "--height", "16", "--spps", "1,4", "--quiet"];
    let converge = |out: &str, more: &[&str]| {
        octray(&[&["converge", "scenes/furnace.toml", "--out", out][..], &flags, more].concat())
    };
    let whole = place.path("whole");
    assert!(converge(&whole, &["--repeats", "5"]).status.success());
    let parts: Vec<String> = (1..=3).map(|number| place.path(&format!("{number}"))).collect();
    for (number, out) in (1..).zip(&parts) {
        let done = converge(out, &["--repeats", "5", "--shard", &format!("{number}/3")]);
        assert!(done.status.success(), "{}", stderr(&done));
    }
    let files: Vec<String> = parts.iter().map(|out| format!("{out}/converge.part")).collect();
    let merge = |files: &[&String], more: &[&str]| {
        let files: Vec<&str> = files.iter().map(|file| file.as_str()).collect();
        converge(&place.path("merged"), &[more, &["--merge"], &files].concat())
    };
    let all: Vec<&String> = files.iter().rev().collect();
    let done = merge(&all, &["--repeats", "5"]);
    assert!(done.status.success(), "{}", stderr(&done));
    assert_eq!(rows(&place.path("merged")), rows(&whole));
    assert!(fs::read_to_string(place.path("merged/report.html")).unwrap().contains("20 runs"));
    for (done, message) in [
        (merge(&all[1..], &["--repeats", "5"]), "1 of 3 parts are missing: 3"),
        (merge(&[all[0], all[0]], &["--repeats", "5"]), "leave one out"),
        (merge(&all, &["--repeats", "5", "--seed", "9"]), "a part of other runs"),
        (merge(&all, &["--repeats", "7"]), "not complete"),
        (converge(&whole, &["--shard", "1/2", "--reach", "0.1"]), "--reach goes by all runs"),
    ] {
        assert_eq!(done.status.code(), Some(2), "{}", stderr(&done));
        assert!(stderr(&done).contains(message), "{}", stderr(&done));
    }
    let mut damaged = fs::read(&files[0]).unwrap();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(&files[0], damaged).unwrap();
    let done = merge(&all, &["--repeats", "5"]);
    assert!(done.status.code() == Some(2) && stderr(&done).contains("damaged"), "{}", stderr(&done));
}

/// Runs that were made are not made again, however the program ended.
#[test]
fn converge_goes_on_after_a_kill() {
    let place = Place::new();
    let (whole, killed) = (place.path("whole"), place.path("killed"));
    let flags = ["--strategies", "bsdf,nee", "--width", "24", "--height", "24", "--spps", "1,16", "--quiet"];
    let of = |out: &str| {
        let all = [
            "converge",
            "scenes/cornell.toml",
            "--out",
            out,
            "--reference-spp",
            "256",
            "--repeats",
            "40",
            "--every",
            "1ms",
        ];
        [&all[..], &flags].concat().iter().map(|&word| word.to_owned()).collect::<Vec<_>>()
    };
    fine(&of(&whole).iter().map(String::as_str).collect::<Vec<_>>());
    let mut went_on = false;
    for number in 0u64..8 {
        let arguments = of(&killed);
        let mut run = begin(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        std::thread::sleep(Duration::from_millis(60 + number * 53 % 170));
        let _ = run.kill();
        let ended = run.wait_with_output().unwrap();
        went_on |= stderr(&ended).contains("going on from");
    }
    let said = fine(&of(&killed).iter().map(String::as_str).collect::<Vec<_>>());
    assert!(went_on || said.contains("going on from"), "{said}");
    assert_eq!(rows(&killed), rows(&whole));
    let left: Vec<String> = fs::read_dir(&killed)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".tmp") || name.ends_with(".unfinished"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}
