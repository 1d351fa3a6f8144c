//! `octray diff` from outside: its figures against other people's arithmetic, its messages for bad input.

use crate::program::{Place, octray, stderr};
use octray::internal::image::{Bounds, Image};
use octray::report::measure::metrics::compare;
use std::fs;
use std::path::Path;
use std::process::Output;

impl Place {
    /// A PFM file, bottom row first as the format has it.
    fn pfm(&self, name: &str, width: u32, height: u32, value: impl Fn(u32, u32, u32) -> f32) -> String {
        let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
        for y in (0..height).rev() {
            for x in 0..width {
                (0..3).for_each(|c| bytes.extend(value(x, y, c).to_le_bytes()));
            }
        }
        fs::write(self.path(name), bytes).unwrap();
        self.path(name)
    }
}

fn json(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn near(value: &serde_json::Value, expected: f64) {
    let found = value.as_f64().unwrap_or_else(|| panic!("{value} where {expected} is expected"));
    assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} and {expected}");
}

#[test]
fn the_figures_are_numpys() {
    let place = Place::new();
    let reference = |x: u32, y: u32, c: u32| ((x * 3 + y * 5 + c * 7) % 11) as f32 / 4.0;
    let b = place.pfm("b.pfm", 7, 5, reference);
    let step = |x: u32, y: u32, c: u32| (((x * 7 + y * 2 + c) % 5) as f32 - 1.0) / 8.0;
    let a = place.pfm("a.pfm", 7, 5, |x, y, c| reference(x, y, c) + step(x, y, c));
    let found = json(&octray(&["diff", &a, &b, "--json"]));
    // numpy 2: y, x, c = np.meshgrid(np.arange(5), np.arange(7), np.arange(3), indexing="ij"), A and B as above in f64:
    // ((A - B)**2).mean(), ((A - B)**2 / (B**2 + 0.01)).mean(), (abs(A - B) / (abs(B) + 0.01)).mean(), A.mean((0, 1)).
    near(&found["mse"], 0.046875);
    near(&found["rmse"], 0.046875f64.sqrt());
    near(&found["relmse"], 0.3534459060699985);
    near(&found["mape"], 1.3870736638223247);
    for (key, means) in [
        ("mean_a", [1.3392857142857142, 1.3607142857142858, 1.3821428571428571]),
        ("mean_b", [1.2142857142857142, 1.2357142857142858, 1.2571428571428571]),
    ] {
        (0..3).for_each(|c| near(&found[key][c], means[c]));
    }
    assert!(found["bias_z"].is_null(), "PFM files have no variance layers");
}

#[test]
fn variance_layers_give_a_score_and_are_subtracted() {
    let place = Place::new();
    let render = |name: &str, seed: &str, strategy: &str| {
        let path = place.path(name);
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
        let film = ["--width", "32", "--height", "32", "--spp", "64", "--seed", seed, "--strategy", strategy];
        // Many samples tell their variance better than four groups of them.
        let sampler = ["--sampler", "independent"];
        assert!(octray(&[&["render", scene, "-o", &path, "--quiet"], &film[..], &sampler].concat()).status.success());
        path
    };
    let [a, b] = [render("a.exr", "1", "nee"), render("b.exr", "2", "mis-balance")];
    let found = json(&octray(&["diff", &a, &b, "--json"]));
    // The definition once more, in another way: whole layers at a time.
    let [image_a, image_b] = [&a, &b].map(|path| Image::read(path).unwrap());
    let channel = |pixels: &[[f32; 3]], c: usize| pixels.iter().map(|pixel| pixel[c] as f64).collect::<Vec<_>>();
    let (mut mse, mut relmse) = (0.0, 0.0);
    for c in 0..3 {
        let (a, b) = (channel(&image_a.pixels, c), channel(&image_b.pixels, c));
        let noise = channel(image_b.variance.as_ref().unwrap(), c);
        mse += a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() - noise.iter().sum::<f64>();
        let relative = a.iter().zip(&b).zip(&noise).map(|((a, b), noise)| ((a - b).powi(2) - noise) / (b * b + 0.01));
        relmse += relative.sum::<f64>();
    }
    let close = |key: &str, expected: f64| {
        let found = found[key].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-9 * expected, "{key}: {found} and {expected}");
    };
    close("mse", mse / (3.0 * 1024.0));
    close("relmse", relmse / (3.0 * 1024.0));
    assert!(found["mse"].as_f64() < found["mse_raw"].as_f64());
    // Exact strategies with other seeds: a fixed pair, its score within three standard errors.
    let z = found["bias_z"].as_f64().unwrap();
    assert!(z.abs() < 3.0, "{z}");
    // Direct light counted twice: far outside.
    let wrong = render("c.exr", "3", "nee-sum");
    let z = json(&octray(&["diff", &wrong, &b, "--json"]))["bias_z"].as_f64().unwrap();
    assert!(z > 10.0, "{z}");
    assert_eq!(compare(&image_a, &image_a).unwrap().mse, 0.0);
}

#[test]
fn a_table_and_a_heatmap() {
    let place = Place::new();
    let a = place.pfm("a.pfm", 12, 8, |x, _, _| x as f32 / 12.0);
    let b = place.pfm("b.pfm", 12, 8, |_, _, _| 0.5);
    let (map, file) = (place.path("map.png"), place.path("diff.json"));
    let output = octray(&["diff", &a, &b, "--heatmap", &map]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for word in ["mse", "rmse", "relmse", "relative error", "mape", "mean_a", "mean_b", "bias", "bias_z"] {
        assert!(text.lines().any(|line| line.starts_with(&format!("{word} "))), "{word}: {text}");
    }
    assert!(text.contains(&format!("{map}: the relative error of every pixel, from ")), "{text}");
    let found = json(&octray(&["diff", &a, &b, "--heatmap", &map, "--json"]));
    assert_eq!(found["heatmap"]["file"], map);
    assert!(found["heatmap"]["darkest"].as_f64() < found["heatmap"]["brightest"].as_f64(), "{found}");
    near(&found["relative_error"], found["relmse"].as_f64().unwrap().sqrt());
    let picture = Image::read(&map).unwrap();
    assert!(picture.width > 240 && picture.height == 160, "{} x {}", picture.width, picture.height);
    assert_eq!(octray(&["diff", &a, &b, &format!("--json={file}")]).stdout, octray(&["diff", &a, &b]).stdout);
    assert!(serde_json::from_str::<serde_json::Value>(&fs::read_to_string(file).unwrap()).unwrap()["mse"].is_f64());
}

#[test]
fn an_image_against_itself_is_zero_without_talk_of_noise() {
    let place = Place::new();
    let files = ["a.exr", "a.png", "a.pfm"].map(|name| place.path(name));
    let outputs: Vec<&str> = files.iter().flat_map(|file| ["-o", file.as_str()]).collect();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
    let film = ["--width", "16", "--height", "16", "--spp", "8", "--quiet"];
    assert!(octray(&[&["render", scene], &film[..], &outputs].concat()).status.success());
    let [exr, png, pfm] = &files;
    let text = |a: &str, b: &str| {
        let output = octray(&["diff", a, b]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()), "{a} {b}");
        String::from_utf8(output.stdout).unwrap()
    };
    for (a, b) in [(exr, exr), (png, png), (pfm, pfm), (exr, pfm), (pfm, exr)] {
        let text = text(a, b);
        assert!(text.contains("The images are the same, pixel by pixel.") && !text.contains("noise"), "{text}");
        assert!(text.lines().any(|line| line.starts_with("mse             0.000e+00  ")), "{text}");
        assert_eq!(json(&octray(&["diff", a, b, "--json"]))["identical"], true);
    }
    // The conversion is told of every PNG, beside linear data as a warning where the output is JSON.
    for (a, b) in [(png, exr), (exr, png), (png, png)] {
        let text = text(a, b).split_whitespace().collect::<Vec<_>>().join(" ");
        let told = format!("{png}: decoded from 8-bit sRGB to linear; it was rounded to 8 bits and cut at white");
        assert_eq!(text.matches(&told).count(), 1, "{text}");
        let output = octray(&["diff", a, b, "--json"]);
        assert_eq!(stderr(&output).contains("8-bit sRGB"), a != b);
        assert_eq!(json(&output)["conversions"].as_array().unwrap().len(), 1);
    }
    assert_eq!(json(&octray(&["diff", exr, pfm, "--json"]))["conversions"], serde_json::json!([]));
}

#[test]
fn crops_keep_their_place_and_are_compared_where_they_overlap() {
    let place = Place::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
    let render = |name: &str, flags: &[&str]| {
        let path = place.path(name);
        let small = ["--width", "24", "--spp", "4", "--quiet"];
        assert!(octray(&[&["render", scene, "-o", &path], &small[..], flags].concat()).status.success());
        path
    };
    let film = ["--height", "20"];
    let crop = |name: &str, crop: &str| render(name, &[&film[..], &["--crop", crop]].concat());
    let whole = render("whole.exr", &film);
    let (one, two) = (crop("one.exr", "3,5,10,8"), crop("two.exr", "9,2,8,6"));
    let image = Image::read(&one).unwrap();
    assert_eq!((image.data(), image.display()), (bounds(3, 5, 10, 8), bounds(0, 0, 24, 20)));
    assert_eq!(Image::read(&whole).unwrap().windows, None, "the whole film is a plain file");
    assert_eq!(image.pixel(0, 0), Image::read(&whole).unwrap().pixel(3, 5));
    for (a, b, compared) in [(&one, &whole, [3, 5, 10, 8]), (&whole, &two, [9, 2, 8, 6]), (&one, &two, [9, 5, 4, 3])] {
        let found = json(&octray(&["diff", a, b, "--json"]));
        // The very same samples: no error before the reference's noise is subtracted.
        assert_eq!((&found["mse_raw"], &found["mape"]), (&0.0.into(), &0.0.into()), "{found}");
        assert_eq!(found["compared"], serde_json::json!(compared));
        assert_eq!(found["display_window"], serde_json::json!([0, 0, 24, 20]));
    }
    let map = place.path("map.png");
    let text = String::from_utf8(octray(&["diff", &one, &two, "--heatmap", &map]).stdout).unwrap();
    assert!(
        text.starts_with("compared: the 4 x 3 pixels at 9,5 that both have, of a display window of 24 x 20\n"),
        "{text}"
    );
    let refused = |a: &str, b: &str, message: &str| {
        let output = octray(&["diff", a, b]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(message), "{}", stderr(&output));
        assert_eq!((stderr(&output).lines().count(), output.stdout.len()), (1, 0), "{}", stderr(&output));
    };
    let apart = crop("apart.exr", "13,5,2,2");
    refused(&one, &apart, "apart.exr 2 x 2 at 13,5: they have no pixel in common");
    let tall = render("tall.exr", &["--height", "21", "--crop", "3,5,10,8"]);
    refused(&one, &tall, "has a display window of 24 x 20 at 0,0 and");
    let reference = ["--reference", &one, "--width", "10", "--height", "8"];
    let output = octray(&[&["converge", scene, "--out", &place.path("report")], &reference[..]].concat());
    assert!(output.status.code() == Some(2) && stderr(&output).contains("it is a crop"), "{}", stderr(&output));
}

fn bounds(x: i32, y: i32, width: u32, height: u32) -> Bounds {
    Bounds { x, y, width, height }
}

#[test]
fn bad_input_is_one_error_with_status_2() {
    let place = Place::new();
    let a = place.pfm("a.pfm", 4, 3, |_, _, _| 1.0);
    let wide = place.pfm("wide.pfm", 3, 4, |_, _, _| 1.0);
    let hole = place.pfm("hole.pfm", 4, 3, |x, y, _| if (x, y) == (2, 1) { f32::NAN } else { 1.0 });
    let endless = place.pfm("inf.pfm", 4, 3, |x, y, c| if (x, y, c) == (0, 2, 1) { f32::INFINITY } else { 1.0 });
    let text = place.path("text.exr");
    fs::write(&text, "not a picture").unwrap();
    let none = place.path("none.exr");
    let refused = |arguments: &[&str], status: i32, message: &str| {
        let output = octray(&[&["diff"], arguments].concat());
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{arguments:?}: {}", stderr(&output));
        assert_eq!((stderr(&output).lines().count(), output.stdout.len()), (1, 0), "{}", stderr(&output));
    };
    refused(&[&a, &wide], 2, "a.pfm has 4 x 3 pixels and");
    refused(&[&a, &hole], 2, "hole.pfm: the value of pixel 2,1 is (NaN, NaN, NaN)");
    refused(&[&endless, &a], 2, "inf.pfm: the value of pixel 0,2 is (1, inf, 1)");
    refused(&[&none, &a], 2, "none.exr: cannot read it");
    refused(&[&a, &text], 2, "text.exr: ");
    refused(&[&a, &place.path("b.jpg")], 2, "unknown image extension `.jpg`");
    refused(&[&a, &a, "--heatmap", &place.path("map.exr")], 2, "a heatmap is a PNG");
    refused(&[&a, &a, "--heatmap", &place.path("a.pfm/map.png")], 1, "is not a directory");
    assert_eq!(octray(&["diff", &a]).status.code(), Some(2));
    assert!(!Path::new(&place.path("map.exr")).exists());
    // A PNG may be compared, and may not be overwritten by its own heatmap.
    let png = place.path("a.png");
    assert!(octray(&["diff", &a, &a, "--heatmap", &png]).status.success());
    refused(&[&png, &png, "--heatmap", &png], 2, "an output would replace it, and this command reads it");
}

/// Radiances whose squares leave the range of f32: every file is finite, `diff` reads it, figures are numbers, and one warning
/// says what was replaced.
#[test]
fn pictures_of_extreme_radiance_are_written_and_compared() {
    let place = Place::new();
    fs::write(place.path("a.obj"), "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nf 1 2 3 4\n").unwrap();
    let camera = "[camera]\nposition = [0, 1, 3]\nlook_at = [0, 0.5, 0]\n[film]\nwidth = 8\nheight = 8\n";
    let lamp = "[[mesh]]\nobj = 'a.obj'\n[[mesh]]\nobj = 'b.obj'\n";
    let obj = "usemtl lamp\nv -0.5 1 -0.5\nv 0.5 1 -0.5\nv 0.5 1 0.5\nf 1 2 3\n";
    fs::write(place.path("b.obj"), obj).unwrap();
    for (radiance, beyond) in [
        ("1e30", true),
        ("1e25", true),
        ("1e23", true),
        ("1e15", false),
        ("1", false),
        ("1e-10", false),
        ("1e-25", true),
        ("1e-36", true),
    ] {
        let toml = format!("{camera}{lamp}[material.lamp]\nemission = [{radiance}, {radiance}, 0]\n");
        fs::write(place.path("s.toml"), toml).unwrap();
        let scene = place.path("s.toml");
        let files = ["x.exr", "x.pfm", "x.hdr", "x.png"].map(|name| place.path(name));
        let outputs: Vec<&str> = files.iter().flat_map(|file| ["-o", file.as_str()]).collect();
        let stats = place.path("stats.json");
        let render = octray(&[&["render", &scene, "--spp", "16", "--quiet", "--stats", &stats], &outputs[..]].concat());
        assert!(render.status.success(), "{radiance}: {}", stderr(&render));
        let warned = stderr(&render).lines().filter(|line| line.contains("image files hold f32")).count();
        assert_eq!(warned, beyond as usize, "{radiance}: {}", stderr(&render));
        for file in &files {
            let image = Image::read(file).unwrap();
            let variance = image.variance.as_deref().unwrap_or_default();
            assert!(image.pixels.iter().chain(variance).flatten().all(|x| x.is_finite()), "{radiance}: {file}");
            if file.ends_with(".exr") {
                let noisy = variance.iter().flatten().filter(|v| **v > 0.0).count();
                assert!(noisy > 10, "{radiance}: a picture with noise says that it has");
            }
            let found = json(&octray(&["diff", file, file, "--json"]));
            for key in ["mse", "rmse", "relmse", "mape", "bias"] {
                assert_eq!(found[key].as_f64(), Some(0.0), "{radiance}: {key} of {file}");
            }
        }
        let found = json(&octray(&["diff", &files[0], &files[1], "--json"]));
        assert!(found["bias_se"].as_f64().is_some_and(|se| se > 0.0), "{radiance}: {found}");
        let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(&stats).unwrap()).unwrap();
        let brightness = stats["mean_radiance"][0].as_f64().unwrap() / radiance.parse::<f64>().unwrap();
        assert!((0.01..1.0).contains(&brightness), "{radiance}: {}", stats["mean_radiance"]);
        let error = stats["relative_error"].as_f64().unwrap();
        assert!((1e-4..1.0).contains(&error) && stats["nonfinite"] == 0, "{radiance}: {error}");
    }
}

/// The same for tiny pixels: render, info and trace say it, with the film that is asked for.
#[test]
fn tiny_pixels_are_warned_about_by_every_command_that_has_a_film() {
    let place = Place::new();
    fs::write(place.path("a.obj"), "v -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3\n").unwrap();
    let scene = |fov: &str| {
        let name = place.path(&format!("{fov}.toml"));
        let camera = format!("[camera]\nposition = [3, 2, 1]\nlook_at = [0, 0, 0]\nvertical_fov = {fov}\n");
        let rest = "[film]\nwidth = 16\nheight = 16\n[[mesh]]\nobj = 'a.obj'\n[environment]\nradiance = [1, 1, 1]\n";
        fs::write(&name, camera + rest).unwrap();
        name
    };
    let warned = |arguments: &[&str]| stderr(&octray(arguments)).matches("f32 directions").count();
    let (tiny, fine) = (scene("1e-4"), scene("1e-3"));
    let (stats, out) = (place.path("s.json"), place.path("o.pfm"));
    for (scene, flags, count) in [(&tiny, &[][..], 1), (&fine, &[][..], 0), (&fine, &["--height", "160"][..], 1)] {
        let render = ["render", scene, "-o", &out, "--spp", "1", "--quiet", "--stats", &stats];
        assert_eq!(warned(&[&render[..], flags].concat()), count, "{scene} {flags:?}");
        assert_eq!(fs::read_to_string(&stats).unwrap().matches("f32 directions").count(), count);
        let trace = ["trace", scene, "--pixel", "1,1", "--sample", "0"];
        assert_eq!(warned(&[&trace[..], flags].concat()), count, "{scene} {flags:?}");
    }
    assert_eq!((warned(&["info", &tiny]), warned(&["info", &fine])), (1, 0));
}
