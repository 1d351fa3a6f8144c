//! Layers and alpha in files: what is asked for stands in them, with its types; what no file can hold is refused.

use crate::program::{Place, octray, stderr};
use exr::image::write::samples::WritableSamples;
use exr::prelude::{AttributeValue, SampleType, Text, read_all_flat_layers_from_file};
use octray::internal::film::Encoding;
use octray::internal::image::Image;
use octray::{Film, Layer, Scene, Settings};
use std::collections::BTreeMap;
use std::fs;

/// The channels of a file: what they are held as, and their values.
fn channels(path: &str) -> BTreeMap<String, (SampleType, Vec<f32>)> {
    let image = read_all_flat_layers_from_file(path).unwrap();
    let [layer] = &image.layer_data[..] else { panic!("{path}: one part") };
    let channels = layer.channel_data.list.iter();
    let of = |channel: &exr::prelude::AnyChannel<exr::prelude::FlatSamples>| {
        (channel.sample_data.sample_type(), channel.sample_data.values_as_f32().collect())
    };
    channels.map(|channel| (channel.name.to_string(), of(channel))).collect()
}

/// A film with all layers; half of its pixels see the environment, or its absence.
fn film(hide_environment: bool) -> Film {
    let scene = Scene::load("scenes/sky.toml").unwrap().prepare().unwrap();
    let (width, height) = (Some(19), Some(37));
    let settings =
        Settings { spp: 8, width, height, layers: Layer::ALL.to_vec(), hide_environment, ..Settings::plain() };
    octray::render(&scene, &settings).film
}

fn fine(arguments: &[&str]) {
    let done = octray(arguments);
    assert!(done.status.success(), "{arguments:?}: {}", stderr(&done));
}

#[test]
fn a_file_holds_what_the_film_has_as_it_is_asked_for() {
    let place = Place::new();
    let path = place.path("a.exr");
    for (half, zip) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut film = film(true);
        film.encoding = Encoding { half, zip };
        film.save(&path).unwrap();
        let found = channels(&path);
        let names = "A Albedo.B Albedo.G Albedo.R B G N.X N.Y N.Z Ns.X Ns.Y Ns.Z R Z variance.B variance.G variance.R";
        assert_eq!(found.keys().map(String::as_str).collect::<Vec<_>>(), names.split(' ').collect::<Vec<_>>());
        for (name, (sample_type, values)) in &found {
            let whole = !half || name == "Z" || name.starts_with("variance");
            assert_eq!(*sample_type, if whole { SampleType::F32 } else { SampleType::F16 }, "{name}");
            for (index, value) in values.iter().enumerate() {
                let (x, y) = (index as u32 % film.width, index as u32 / film.width);
                let layers = &film.layers.pixels[index];
                let at = match name.chars().last() {
                    Some('R' | 'X') => 0,
                    Some('G' | 'Y') => 1,
                    _ => 2,
                };
                let wanted = match name.as_str() {
                    "A" => layers.alpha,
                    "Z" => layers.depth,
                    _ if name.starts_with("Albedo") => layers.albedo[at],
                    _ if name.starts_with("N.") => layers.normal[at],
                    _ if name.starts_with("Ns.") => layers.shading_normal[at],
                    _ if name.starts_with("variance") => film.variance(x, y)[at],
                    _ => film.mean(x, y)[at],
                };
                // Eleven bits; below the normal numbers of f16 steps of 2^-24.
                let near = (value - wanted).abs() <= (wanted.abs() / 2048.0).max(1.0 / 33_554_432.0);
                assert!(*value == wanted || (!whole && near), "{name} {index}: {value}, {wanted} wanted");
            }
        }
        // Our own readers take the picture, and have nothing to say of it.
        let image = Image::read(&path).unwrap();
        assert!(image.warnings.is_empty() && image.metadata == film.metadata, "{:?}", image.warnings);
        assert_eq!(image.variance.as_ref().map(|variance| variance[40]), Some(film.variance(2, 2)));
        // The same film, the same bytes, though attributes live in a table without an order.
        let bytes = fs::read(&path).unwrap();
        for _ in 0..8 {
            film.save(&path).unwrap();
            assert!(fs::read(&path).unwrap() == bytes, "half {half}, zip {zip}");
        }
    }
}

#[test]
fn zip_loses_nothing_and_saves_room() {
    let place = Place::new();
    let [plain, zipped] = ["plain.exr", "zipped.exr"].map(|name| place.path(name));
    let mut film = film(true);
    film.save(&plain).unwrap();
    film.encoding.zip = true;
    film.save(&zipped).unwrap();
    assert!(channels(&plain) == channels(&zipped));
    assert!(fs::metadata(&zipped).unwrap().len() < fs::metadata(&plain).unwrap().len() * 9 / 10);
}

#[test]
fn settings_are_typed_attributes() {
    let place = Place::new();
    let path = place.path("a.exr");
    film(true).save(&path).unwrap();
    let header = read_all_flat_layers_from_file(&path).unwrap();
    let attributes = &header.layer_data[0].attributes.other;
    let of = |key: &str| attributes[&Text::from(key)].clone();
    assert_eq!((of("octray/spp"), of("octray/seed")), (AttributeValue::I32(8), AttributeValue::I32(0)));
    for (key, value) in [("strategy", "mis-power"), ("max_depth", "unbounded"), ("environment", "hidden")] {
        assert_eq!(of(&format!("octray/{key}")), AttributeValue::Text(Text::from(value)), "{key}");
    }
}

#[test]
fn f16_is_cut_and_told() {
    let place = Place::new();
    let scene = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[film]\nwidth = 4\nheight = 3\n[environment]\nradiance = [7e4, 1, 0]\n";
    let (toml, path) = (place.path("a.toml"), place.path("a.exr"));
    fs::write(&toml, format!("{scene}[[mesh]]\nobj = \"a.obj\"\n")).unwrap();
    fs::write(place.path("a.obj"), "v 0 0 9\nv 1 0 9\nv 0 1 9\nf 1 2 3\n").unwrap();
    let done = octray(&["render", &toml, "-o", &path, "--spp", "2", "--half"]);
    assert!(done.status.success() && stderr(&done).contains("12 pixels are brighter than 65504"), "{}", stderr(&done));
    assert_eq!(Image::read(&path).unwrap().pixels, [[65504.0, 1.0, 0.0]; 12]);
    let done = octray(&["render", &toml, "-o", &path, "--spp", "2"]);
    assert!(!stderr(&done).contains("65504") && Image::read(&path).unwrap().pixels == [[7e4, 1.0, 0.0]; 12]);
}

#[test]
fn png_has_alpha_and_the_colour_of_what_is_there() {
    let place = Place::new();
    let path = place.path("a.png");
    let film = film(true);
    film.save(&path).unwrap();
    let image = image::open(&path).unwrap();
    let image::DynamicImage::ImageRgba8(image) = image else { panic!("no alpha") };
    let mut partly = 0;
    for (index, pixel) in image.pixels().enumerate() {
        let (alpha, [r, ..]) = (film.layers.pixels[index].alpha, film.mean(index as u32 % 19, index as u32 / 19));
        assert_eq!(pixel.0[3], (alpha * 255.0).round() as u8);
        let shown = octray::internal::color::srgb8(if alpha > 0.0 { r / alpha } else { 0.0 }, 0.0);
        assert_eq!(pixel.0[0], shown, "{index}");
        partly += u32::from(alpha > 0.0 && alpha < 1.0);
    }
    assert!(partly > 3, "{partly} pixels at edges");
    // A film whose environment is seen has none.
    self::film(false).save(&path).unwrap();
    assert!(matches!(image::open(&path).unwrap(), image::DynamicImage::ImageRgb8(_)));
}

#[test]
fn what_no_file_can_hold_is_refused_before_anything_is_done() {
    let place = Place::new();
    let [exr, png, hdr, pfm] = ["a.exr", "a.png", "a.hdr", "a.pfm"].map(|name| place.path(name));
    let render = |more: &[&str]| octray(&[&["render", "scenes/glass.toml", "--spp", "1"][..], more].concat());
    for (flags, message) in [
        (&["-o", &pfm, "--layers", "albedo"][..], "layers are in .exr files alone: add -o NAME.exr"),
        (&["-o", &png, "-o", &hdr, "--layers", "all"], "--layers: "),
        (&["-o", &hdr, "--hide-environment"], "alpha is in .exr and .png files alone"),
        (&["-o", &png, "--half"], "--half: "),
        (&["-o", &pfm, "--zip"], "--zip: "),
        (&["-o", &exr, "--layers", "depht"], "did you mean `depth`?"),
        (&["-o", &exr, "--layers-through-specular"], "--layers"),
        (&["-o", &exr, "--shard", "1/2", "--half"], "--half: parts are no images: give it to octray merge"),
    ] {
        let done = render(flags);
        assert_eq!(done.status.code(), Some(2), "{flags:?}: {}", stderr(&done));
        assert!(stderr(&done).contains(message), "{flags:?}: {}", stderr(&done));
    }
    assert_eq!(fs::read_dir(place.0.path()).unwrap().count(), 0);
    // Beside a file that can, others hold radiance.
    let small = ["--width", "8", "--height", "6", "--quiet"];
    fine(
        &[&["render", "scenes/glass.toml", "--spp", "1", "-o", &exr, "-o", &pfm, "--layers", "normal"][..], &small]
            .concat(),
    );
    assert!(!channels(&exr).contains_key("variance.R") && channels(&exr).contains_key("Ns.Y"));
    assert_eq!(Image::read(&exr).unwrap().pixels, Image::read(&pfm).unwrap().pixels);
}

#[test]
fn parts_and_renders_that_go_on_have_the_layers_of_one() {
    let place = Place::new();
    let [whole, merged, first, second, stats] =
        ["whole.exr", "merged.exr", "1.part", "2.part", "stats.json"].map(|name| place.path(name));
    let render = |more: &[&str]| {
        let layers = ["--layers", "all", "--layers-through-specular", "--hide-environment", "--train", "off"];
        let small = ["--width", "40", "--height", "33", "--quiet"];
        fine(&[&["render", "scenes/glass.toml"][..], &small, &layers, more].concat());
    };
    render(&["-o", &whole, "--spp", "8", "--stats", &stats]);
    render(&["-o", &first, "--spp", "8", "--shard", "1/2"]);
    render(&["-o", &second, "--spp", "8", "--shard", "2/2", "--engine", "scalar"]);
    fine(&["merge", &first, &second, "-o", &merged]);
    assert!(fs::read(&merged).unwrap() == fs::read(&whole).unwrap());
    let pfm = place.path("a.pfm");
    let told = stderr(&octray(&["merge", &first, &second, "-o", &pfm]));
    assert!(told.contains("which are left out: .exr files hold them"), "{told}");
    // The same of a render that goes on, whatever it wanted before.
    fine(&[
        "render",
        "scenes/glass.toml",
        "-o",
        &merged,
        "--spp",
        "3",
        "--width",
        "40",
        "--height",
        "33",
        "--quiet",
        "--hide-environment",
        "--train",
        "off",
        "--keep-checkpoint",
    ]);
    render(&["-o", &merged, "--spp", "8", "--resume"]);
    assert!(fs::read(&merged).unwrap() == fs::read(&whole).unwrap());
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(&stats).unwrap()).unwrap();
    assert!(stats["layers_s"].as_f64().unwrap() > 0.0 && stats["hide_environment"] == true);
    assert_eq!(stats["layers"], serde_json::json!(["albedo", "normal", "depth", "variance"]));
}
