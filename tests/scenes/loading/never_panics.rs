//! No text makes loading panic: it ends in a scene that holds what scenes promise, or in one error.

use super::common::{Folder, TOML, TRIANGLE};
use octray::scene::validate;
use proptest::prelude::*;
use std::path::Path;

const OBJ_SEED: &str = "mtllib mesh.mtl\no a\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nv 0.5 .25 -0\nv 0 1 0\nvt 0 0\n\
    vn 0 0 1\nvn 0 0 -1\nusemtl m\nf 1/1/1 2/1/1 3/1/1 4/1/1 5/1/1\nusemtl lamp\nf 1//2 2//2 -1//-1\nl 1 2 3\n\
    f 1 2 3 \\\n4\np 1\n# end\n";
const MTL_SEED: &str = "newmtl m\nKd 0.5 0.5 0.5 # grey\nKs 0 0 0\nNs 10\nNi 1.5\nd 1\nTr 0\nPm 0.5\nillum 2\n\
    map_Kd -o 1 a.png\nnewmtl lamp\nKe 1 2 3\nillum 5\n";
const TOML_SEED: &str = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nvertical_fov = 35.0\n\
    aperture_radius = 0.0\nfocus_distance = 1e3\n[film]\nwidth = 64\nheight = 0x20\n[render]\nspp = 64\n\
    strategy = 'mis-power'\nrr_depth = \"off\"\nseed = 1\n[[mesh]]\nobj = \"mesh.obj\"\nscale = -2.0\n\
    rotate = {axis = [0, 1, 0], degrees = 90}\ntranslate = [0, 0, 0]\n\
    [material.m]\nkind = \"mirror\"\nreflectance = [0.5, 0.5, 0.5]\nemission = [1, 1, 1]\n\
    [environment]\nradiance = [1, 1, 1]\nscale = 1.0\n";
#[rustfmt::skip] // one word a line would be a page
/// What mutations put in: keywords, limits, halves of syntax.
const WORDS: &[&str] = &[
    " ", "\n", "\t", "\\\n", "\\", "#", "/", "//", "-", "-1", "0", "1", "2", "9223372036854775807",
    "-9223372036854775808", "99999999999999999999", "nan", "inf", "-inf", "1e39", "1e-46", "1e999", "f ", "f",
    "v ", "vn ", "vt ", "l 1 2 3\n", "usemtl ", "mtllib ", "newmtl ", "Kd ", "Ke 1", "Ks", "illum ", "illum 7\n",
    "d ", "map_Kd", "[", "]", "[[", "]]", "{", "}", "=", ",", "'", "\"", "\"\"\"", "[camera]\n", "[[mesh]]\n",
    "mesh.obj", "material.m", "true", "1979-05-27", "é", "\u{feff}", "\u{85}", "\r", "\0",
];

#[derive(Clone, Debug)]
enum Edit {
    Insert(usize, usize),
    Delete(usize, usize),
    Overwrite(usize, u8),
    Repeat(usize, usize),
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let edit = prop_oneof![
        4 => (any::<usize>(), any::<usize>()).prop_map(|(at, word)| Edit::Insert(at, word)),
        2 => (any::<usize>(), 1usize..12).prop_map(|(at, count)| Edit::Delete(at, count)),
        1 => (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Edit::Overwrite(at, byte)),
        1 => (any::<usize>(), 1usize..30).prop_map(|(at, count)| Edit::Repeat(at, count)),
    ];
    prop::collection::vec(edit, 1..6)
}

fn mutate(seed: &str, edits: &[Edit]) -> Vec<u8> {
    let mut text = seed.as_bytes().to_vec();
    for edit in edits {
        let place = |at: usize| at % (text.len() + 1);
        match *edit {
            Edit::Insert(at, word) => {
                let at = place(at);
                text.splice(at..at, WORDS[word % WORDS.len()].bytes());
            }
            Edit::Delete(at, count) => {
                let at = place(at);
                text.drain(at..(at + count).min(text.len()));
            }
            Edit::Overwrite(at, byte) => {
                if let Some(old) = text.get_mut(at % seed.len()) {
                    *old = byte;
                }
            }
            Edit::Repeat(at, count) => {
                let at = place(at);
                let part = text[at..(at + count).min(text.len())].to_vec();
                text.splice(at..at, part);
            }
        }
    }
    text
}

/// Loads `scene.toml` and `mesh.obj` of such a folder; what loads must hold what scenes promise.
fn load_both(obj: &[u8], mtl: &[u8], toml: &[u8]) {
    let folder = Folder::new(&[]);
    for (name, bytes) in [("mesh.obj", obj), ("mesh.mtl", mtl), ("scene.toml", toml)] {
        folder.write(name, bytes);
    }
    for name in ["scene.toml", "mesh.obj"] {
        match folder.load(name) {
            Ok(scene) => {
                validate::check(&scene).expect("a loaded scene is sound");
                assert!(
                    scene
                        .environment()
                        .is_none_or(|e| e != &octray::scene::desc::EnvironmentDesc::Constant { radiance: [0.0; 3] })
                );
            }
            Err(message) => assert!(!message.is_empty() && message.lines().count() == 1, "{message:?}"),
        }
    }
}

#[test]
fn the_seeds_themselves_load() {
    let folder = Folder::new(&[("mesh.obj", OBJ_SEED), ("mesh.mtl", MTL_SEED), ("scene.toml", TOML_SEED)]);
    assert_eq!(folder.load("scene.toml").unwrap().geometry().triangles.len(), 6);
    assert_eq!(folder.load("mesh.obj").unwrap().geometry().triangles.len(), 6);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        load_both(&bytes, &bytes, &bytes);
        load_both(OBJ_SEED.as_bytes(), &bytes, TOML.as_bytes());
    }

    #[test]
    fn random_words(words in prop::collection::vec(0..WORDS.len(), 0..40)) {
        let text: String = words.iter().map(|&i| WORDS[i]).collect();
        load_both(format!("{TRIANGLE}{text}").as_bytes(), text.as_bytes(), format!("{TOML}{text}").as_bytes());
    }

    #[test]
    fn mutated_obj_and_mtl(obj in edits(), mtl in edits()) {
        load_both(&mutate(OBJ_SEED, &obj), &mutate(MTL_SEED, &mtl), TOML.as_bytes());
    }

    #[test]
    fn mutated_toml(edits in edits()) {
        load_both(OBJ_SEED.as_bytes(), MTL_SEED.as_bytes(), &mutate(TOML_SEED, &edits));
    }

    #[test]
    fn names(name in "[a-z0-9:.\\-/é ]{0,12}") {
        let _ = octray::scene::builtin::build(&name);
        let _ = octray::scene::SceneDesc::load(Path::new(&name));
    }
}

#[test]
fn deep_nesting_ends_in_an_error() {
    for text in
        ["a = ".to_owned() + &"[".repeat(100_000), "[".to_owned() + &"a.".repeat(20_000) + "a]", "{".repeat(100_000)]
    {
        load_both(TRIANGLE.as_bytes(), b"", text.as_bytes());
    }
}
