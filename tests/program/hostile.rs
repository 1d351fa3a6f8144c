//! Files made to harm: each ends in one error, at once, and in little memory. Ours are written here; those of others are in
//! `../shared`.
#![cfg(target_os = "linux")]

use crate::program::{Place, stderr};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Runs the program under a limit on its address space, in megabytes, and wants status 2 and one line that says `message`.
fn refused(arguments: &[&str], megabytes: u32, message: &str) {
    let begun = Instant::now();
    let quoted: Vec<String> = arguments.iter().map(|word| format!("'{word}'")).collect();
    let program = env!("CARGO_BIN_EXE_octray");
    let command = format!("ulimit -v {}; exec {program} {}", megabytes * 1000, quoted.join(" "));
    let done = Command::new("bash").args(["-c", &command]).output().unwrap();
    let said = stderr(&done);
    assert_eq!(done.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(said.contains(message) && said.lines().count() == 1 && !said.contains('\u{1b}'), "{arguments:?}: {said}");
    // A second on an idle machine.
    assert!(begun.elapsed().as_secs() < 10, "{arguments:?} took {:?}", begun.elapsed());
}

/// An EXR file of one layer with the channels R, G and B, whose header says what it likes and which ends behind it.
fn exr(window: [i32; 4], compression: u8, samples: u32) -> Vec<u8> {
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        bytes.extend(format!("{name}\0{kind}\0").bytes());
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    };
    let mut channels = Vec::new();
    for name in ["B", "G", "R"] {
        channels.extend(format!("{name}\0").bytes());
        channels.extend(samples.to_le_bytes());
        channels.extend([0; 4]);
        channels.extend([1u32.to_le_bytes(), 1u32.to_le_bytes()].concat());
    }
    channels.push(0);
    let window: Vec<u8> = window.iter().flat_map(|side| side.to_le_bytes()).collect();
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[compression]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    bytes.push(0);
    bytes
}

#[test]
fn images_that_promise_more_than_they_hold_are_refused_at_once() {
    let place = Place::new();
    let refuse = |name: &str, bytes: &[u8], message: &str| {
        let path = place.path(name);
        fs::write(&path, bytes).unwrap();
        refused(&["diff", &path, &path], 200, message);
    };
    for (number, window) in [
        [0, 0, i32::MAX - 1, i32::MAX - 1],
        [0, 0, 65_535, 65_535],
        [-1_000_000, -1_000_000, 1_000_000, 1_000_000],
        [0, 0, i32::MAX - 1, 0],
        [0, 0, 30_000, 30_000],
    ]
    .into_iter()
    .enumerate()
    {
        for compression in 0..8 {
            for samples in 0..3 {
                refuse(&format!("a{number}.exr"), &exr(window, compression, samples), "exr: ");
            }
        }
    }
    for (number, header) in
        ["PF\n3340214413 1380655685\n-1.0\n", "PF\n4294967295 4294967295\n1\n", "Pf\n1073741824 1\n-1\n"]
            .iter()
            .enumerate()
    {
        refuse(&format!("a{number}.pfm"), header.as_bytes(), "bytes where ");
    }
    // A PNG of 16,384 x 16,384 zeros is a file of 33 kilobytes, and no lie: it takes memory that is not there.
    let image = ::image::GrayImage::new(16_384, 16_384);
    let path = place.path("large.png");
    image.save(&path).unwrap();
    refused(&["--max-memory", "500M", "diff", &path, &path], 4000, "of memory");
    refuse("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n", "a.hdr: ");
}

#[test]
fn shared_cases_end_in_one_error() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/cases/hostile"));
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    let place = Place::new();
    let at = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    for name in ["exr_alloc_abort.exr", "exr_hang.exr", "exr_huge_window.exr", "pfm_overflow.pfm"] {
        refused(&["diff", &at(name), &at(name)], 200, name);
    }
    refused(&["info", &at("mtllib_dev_zero.obj")], 200, "only regular files are read");
    let scene = place.path("s.toml");
    fs::write(place.path("s.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n").unwrap();
    let jpeg = at("jpeg_truncated.jpg");
    fs::write(&scene, format!("[[mesh]]\nobj = \"s.obj\"\n[material.m]\nkind = \"diffuse\"\ntexture = \"{jpeg}\"\n"))
        .unwrap();
    refused(&["info", &scene], 200, "s.toml:5: ");
    refused(&["info", &at("escape_injection.obj")], 200, "PWNED");
}
