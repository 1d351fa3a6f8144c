//! The house: who may name whom. Reads the sources, so a wrong import fails here and not in a review.

mod imports;

use imports::{Graph, Names, Sources, circle, code, named, offered, tree, way};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// All source files, by their path below `src`.
fn texts() -> BTreeMap<String, String> {
    fn add(folder: &Path, below: &str, texts: &mut BTreeMap<String, String>) {
        for entry in fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("a readable entry").path();
            let name = format!("{below}{}", path.file_name().expect("a name").to_string_lossy());
            if path.is_dir() {
                add(&path, &format!("{name}/"), texts);
            } else if name.ends_with(".rs") {
                texts.insert(name, fs::read_to_string(&path).expect("readable source"));
            }
        }
    }
    let mut texts = BTreeMap::new();
    add(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "", &mut texts);
    assert!(texts.len() > 20, "the sources were found");
    texts
}

/// The room of a file: the first part of its path.
fn room(path: &str) -> &str {
    path.split('/').next().expect("a name").trim_end_matches(".rs")
}

#[test]
fn only_lanes_names_wide() {
    for (path, text) in texts().iter().filter(|(path, _)| room(path) != "lanes") {
        assert!(!code(text).contains("wide::"), "{path} names wide");
    }
}

#[test]
fn the_engines_know_nothing_of_each_other() {
    for (path, text) in texts() {
        let forbidden: &[&str] = match room(&path) {
            "reference" => &["packet", "lanes", "F32x8"],
            "packet" => &["reference"],
            _ => &[],
        };
        // Test modules, too.
        let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        for line in lines {
            for word in forbidden {
                assert!(!line.contains(word), "{path} names {word}: {line}");
            }
        }
    }
}

#[test]
fn what_the_threads_of_a_render_share_is_counted() {
    // Training has threads of its own.
    let others = |path: &str| !["render/shared.rs", "render/pilot.rs"].contains(&path);
    let rooms = ["render", "packet", "reference", "sampler", "film"];
    for (path, text) in texts().iter().filter(|(path, _)| rooms.contains(&room(path)) && others(path)) {
        for word in ["Mutex", "RwLock", "fetch_", "compare_exchange", "AtomicU", "AtomicI"] {
            assert!(
                !code(text).contains(word),
                "{path} names {word}: what threads share is of a type of render/shared.rs"
            );
        }
    }
}

/// Top to bottom: a file may name files below its own layer, and those in it. A folder in a folder that has a layer of its
/// own is in that, not in its parent's.
const LAYERS: [&[&str]; 11] = [
    &["main"],
    &["cli"],
    &["report", "report/write", "check"],
    &["report/analysis"],
    &["report/measure"],
    &["render", "api"],
    &["packet", "reference"],
    &["import", "setup", "learn", "trace", "stats", "film", "image", "camera"],
    &["tables"],
    &["scene", "bvh"],
    &[
        "settings",
        "strategy",
        "sampler",
        "lanes",
        "simd",
        "math",
        "color",
        "error",
        "clock",
        "fault",
        "files",
        "fingerprint",
        "nearest",
        "named_choice",
        "shown",
    ],
];

/// The crate's roots, which name every room and are named by none: those of the engine's SIMD levels, too, which hold parts of
/// several rooms. (What is compiled there counts as the room's that it lies in.)
const ROOTS: [&str; 4] = ["lib.rs", "internal.rs", "simd/native.rs", "simd/avx2.rs"];

/// The layer of a file: that of the innermost folder which has one.
fn layer(path: &str) -> Option<usize> {
    let mut folders: Vec<&str> = path.match_indices('/').map(|(at, _)| &path[..at]).collect();
    if folders.is_empty() {
        folders.push(room(path));
    }
    folders.iter().rev().find_map(|folder| LAYERS.iter().position(|rooms| rooms.contains(folder)))
}

#[test]
fn nothing_imports_upwards() {
    let graph = Sources::new(&texts()).graph();
    assert!(graph["packet/plan.rs"].contains("packet/decisions.rs"), "imports are followed to their files");
    for (path, imports) in graph.iter().filter(|(path, _)| !ROOTS.contains(&path.as_str())) {
        let level = layer(path).unwrap_or_else(|| panic!("{path} is in no layer"));
        for other in imports.iter().filter(|other| !ROOTS.contains(&other.as_str())) {
            let below = layer(other).unwrap_or_else(|| panic!("{other} is in no layer"));
            assert!(below >= level, "{path} names {other}, which lies above it");
        }
    }
}

#[test]
fn files_name_each_other_in_no_circle() {
    let graph = Sources::new(&texts()).graph();
    if let Some(files) = circle(&graph) {
        panic!("files name each other in a circle: {}", files.join(" -> "));
    }
}

fn paths(names: Vec<Names>) -> Vec<String> {
    names.iter().map(|name| name.join("::")).collect()
}

#[test]
fn groups_of_imports_are_read() {
    let mut names = Vec::new();
    let rest = tree("crate::{a, b::c, d::{self, E as F},\n    g::*}; rest", &[], &mut names);
    assert_eq!(paths(names), ["crate::a", "crate::b::c", "crate::d", "crate::d::E", "crate::g"]);
    assert_eq!(rest, "; rest");
    let text = "use crate::{\n    a::{B, C},\n};\nfn f() -> crate::x::Y<u8> { super::z::f::<u8>(::std::crate_::q) }";
    assert_eq!(paths(named(text)), ["crate::a::B", "crate::a::C", "crate::x::Y", "super::z::f"]);
    let (offers, own) = offered("mod a;\npub use a::{B, c::D};\nuse crate::e::F;\npub(super) use crate::g;");
    assert_eq!(paths(offers), ["a::B", "a::c::D", "crate::g"]);
    assert_eq!(paths(named(&own)), ["crate::e::F"]);
}

#[test]
fn comments_and_test_modules_are_no_code() {
    let text = "// crate::a\nuse crate::b; // crate::c\n#[cfg(test)]\nfn d() {}\n#[cfg(test)]\nmod tests {\n    use crate::e;\n}";
    assert_eq!(paths(named(&code(text))), ["crate::b"]);
}

fn sources(files: &[(&str, &str)]) -> Graph {
    let texts = files.iter().map(|(path, text)| (path.to_string(), text.to_string())).collect();
    Sources::new(&texts).graph()
}

#[test]
fn circles_of_files_are_found() {
    let innocent = sources(&[
        ("lib.rs", "mod a;\nmod b;\npub use a::A;"),
        ("a/mod.rs", "mod c;\npub use c::A;"),
        ("a/c.rs", "use crate::b::B;\npub struct A;"),
        ("b.rs", "pub struct B;"),
    ]);
    assert_eq!(circle(&innocent), None);
    assert!(innocent["a/c.rs"].contains("b.rs") && innocent["a/mod.rs"].is_empty());
    // Through what `a` and `lib.rs` offer of `c`.
    let guilty = sources(&[
        ("lib.rs", "mod a;\nmod b;\npub use a::A;"),
        ("a/mod.rs", "mod c;\npub use c::A;"),
        ("a/c.rs", "use crate::b::B;\npub struct A;"),
        ("b.rs", "pub struct B(crate::A);"),
    ]);
    assert_eq!(circle(&guilty), Some(["a/c.rs", "b.rs", "a/c.rs"].map(str::to_string).to_vec()));
    assert_eq!(way(&guilty, "b.rs", "a/c.rs"), Some(["b.rs", "a/c.rs"].map(str::to_string).to_vec()));
}

#[test]
fn files_compiled_twice_are_followed_in_both_modules() {
    let graph = sources(&[
        ("lib.rs", "mod r;\nmod simd;"),
        ("r/mod.rs", "pub mod one;\npub mod two;"),
        ("r/one.rs", "#[path = \"x.rs\"]\npub mod x;\n#[path = \"y/mod.rs\"]\npub mod y;\npub type Real = f32;"),
        ("r/two.rs", "#[path = \"x.rs\"]\npub mod x;\n#[path = \"y/mod.rs\"]\npub mod y;\npub type Real = f64;"),
        ("r/x.rs", "use super::Real;\nuse super::y::Y;"),
        ("r/y/mod.rs", "pub mod z;\nuse super::Real;"),
        ("r/y/z.rs", "use super::super::x::f;"),
        ("simd/mod.rs", "pub mod one;\npub mod two;"),
        ("simd/one.rs", "#[path = \"../k/x.rs\"]\npub mod x;\n#[path = \"../l/one.rs\"]\npub mod l;"),
        ("simd/two.rs", "#[path = \"../k/x.rs\"]\npub mod x;\n#[path = \"../l/two.rs\"]\npub mod l;"),
        ("k/x.rs", "use super::here;\nuse here::l::Lanes;"),
        ("l/one.rs", ""),
        ("l/two.rs", ""),
    ]);
    assert_eq!(
        graph["k/x.rs"].iter().filter(|path| path.starts_with("l/")).collect::<Vec<_>>(),
        ["l/one.rs", "l/two.rs"]
    );
    assert_eq!(graph["r/x.rs"].iter().collect::<Vec<_>>(), ["r/one.rs", "r/two.rs", "r/y/mod.rs"]);
    assert_eq!(graph["r/y/z.rs"].iter().collect::<Vec<_>>(), ["r/x.rs"]);
}
