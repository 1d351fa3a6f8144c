//! The house: who may name whom. Reads the sources, so a wrong import fails here and not in a review.

use std::fs;
use std::path::{Path, PathBuf};

fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = fs::read_to_string(&path).expect("readable source");
            files.push((path, text));
        }
    }
    files
}

/// Source lines that are code: no comment lines.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.trim_start().starts_with("//"))
}

fn all() -> Vec<(PathBuf, String)> {
    sources(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").as_path())
}

fn room(path: &Path) -> String {
    let inside = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).expect("below src");
    let first = inside.components().next().expect("a name").as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_string()
}

#[test]
fn only_lanes_names_wide() {
    let files = all();
    assert!(files.len() > 20, "the sources were found");
    for (path, text) in files.iter().filter(|(path, _)| room(path) != "lanes") {
        assert!(!code(text).any(|line| line.contains("wide::")), "{} names wide", path.display());
    }
}

#[test]
fn the_engines_know_nothing_of_each_other() {
    for (path, text) in all() {
        let forbidden: &[&str] = match room(&path).as_str() {
            "reference" => &["packet", "lanes", "F32x8"],
            "packet" => &["reference"],
            _ => &[],
        };
        for word in forbidden {
            assert!(!code(&text).any(|line| line.contains(word)), "{} names {word}", path.display());
        }
    }
}

#[test]
fn nothing_imports_upwards() {
    // Top to bottom; a room may name rooms below its own layer, and neighbours in it.
    let layers: [&[&str]; 9] = [
        &["main"],
        &["cli"],
        &["report"],
        &["render", "api"],
        &["packet", "reference"],
        &["import", "setup", "trace", "stats", "film", "image", "camera"],
        &["tables"],
        &["scene", "bvh"],
        &["settings", "sampler", "lanes", "math", "color", "error", "clock", "fingerprint", "nearest"],
    ];
    let layer = |name: &str| layers.iter().position(|rooms| rooms.contains(&name));
    for (path, text) in all() {
        let own = room(&path);
        if own == "lib" {
            continue;
        }
        let level = layer(&own).unwrap_or_else(|| panic!("{} is in no layer", path.display()));
        for line in code(&text) {
            for part in line.split("crate::").skip(1) {
                let named: String = part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if let Some(other) = layer(&named) {
                    assert!(other >= level, "{} ({own}) names {named}, which lies above it: {line}", path.display());
                }
            }
        }
    }
}
