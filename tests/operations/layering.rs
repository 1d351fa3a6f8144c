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
        &["settings", "strategy", "sampler", "lanes", "math", "color", "error", "clock", "fingerprint", "nearest"],
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

/// The file of `tables` that a path behind `crate::tables::` names, if it is one.
fn table_named(path: &str, names: &[String]) -> Option<String> {
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let path: String = path.chars().take_while(|&c| word(c)).collect();
    names
        .iter()
        .filter(|name| path == **name || path.starts_with(&format!("{name}::")))
        .max_by_key(|n| n.len())
        .cloned()
}

#[test]
fn no_table_names_one_that_is_made_of_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tables");
    let files: Vec<(String, String)> = sources(&root)
        .into_iter()
        .filter(|(path, _)| !path.ends_with("mod.rs"))
        .map(|(path, text)| {
            let inside = path.strip_prefix(&root).expect("below tables").with_extension("");
            (inside.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("::"), text)
        })
        .collect();
    let names: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
    let named = |(name, text): &(String, String)| {
        let paths = code(text).flat_map(|line| line.split("crate::tables::").skip(1));
        (name.clone(), paths.filter_map(|path| table_named(path, &names)).collect::<Vec<_>>())
    };
    let mut left: Vec<(String, Vec<String>)> = files.iter().map(named).collect();
    assert!(left.iter().any(|(name, named)| name == "prepared" && named.contains(&"lights::emitters".into())));
    // Files that name no file that is left go first; in a circle none does.
    while !left.is_empty() {
        let waiting: Vec<String> = left.iter().map(|(name, _)| name.clone()).collect();
        left.retain(|(_, named)| named.iter().any(|other| waiting.contains(other)));
        assert!(left.len() < waiting.len(), "a circle among {left:?}");
    }
}
