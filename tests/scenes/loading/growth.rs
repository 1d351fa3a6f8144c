//! Time and warnings grow with what a scene says at most in proportion: cases of 100,000 entries, each of which took half a minute
//! or told as many warnings while something was done for each entry and each other.

use super::common::*;
use octray::internal::tables::PreparedScene;
use octray::scene::SceneDesc;
use std::fmt::Write;
use std::time::Instant;

const MANY: usize = 100_000;

/// Seconds that no case takes, by far, however busy machine and disk; by themselves the cases take about one.
const SOON: f64 = if cfg!(debug_assertions) { 90.0 } else { 20.0 };

const CAMERA: &str = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n";

/// Loads a file and prepares it, both soon.
fn load_soon(folder: &Folder, name: &str) -> SceneDesc {
    let start = Instant::now();
    let scene = folder.load(name).expect(name);
    let prepared = PreparedScene::new(&scene).expect(name);
    let seconds = start.elapsed().as_secs_f64();
    assert!(seconds < SOON, "{name}: {seconds} s");
    for warnings in [&scene.warnings, &prepared.warnings] {
        assert!(warnings.len() <= 64 && warnings.iter().all(|w| w.len() < 2200), "{name}: {} warnings", warnings.len());
    }
    scene
}

/// `count` times what `write` writes for each number.
fn lines(count: usize, write: impl Fn(usize) -> String) -> String {
    (0..count).map(write).collect()
}

#[test]
fn many_meshes_of_one_file() {
    let mesh = |i: usize| format!("[[mesh]]\nobj = \"mesh.obj\"\ntranslate = [{}, {}, 0]\n", i % 300, i / 300);
    let obj = format!("usemtl m\n{TRIANGLE}f 1 2\n");
    let folder = Folder::new(&[("mesh.obj", &obj), ("scene.toml", &(CAMERA.to_owned() + &lines(MANY, mesh)))]);
    let scene = load_soon(&folder, "scene.toml");
    assert_eq!((scene.meshes.len(), scene.materials.len()), (MANY, MANY));
    let last = MANY - 1;
    assert_eq!(scene.meshes[last].positions[1], [(last % 300 + 1) as f32, (last / 300) as f32, 0.0]);
    assert_eq!(scene.meshes[last].triangles[0].material as usize, last);
    // The file is read once, and so is what it lacks.
    let told: Vec<_> = scene.warnings.iter().filter(|w| w.contains("mesh.obj:6: 1 face(s)")).collect();
    assert!(told.len() == 1 && !told[0].contains("times"), "{:?}", scene.warnings);
    assert!(warned(&scene, &["no MTL defines `m`: grey"]), "{:?}", scene.warnings);
}

#[test]
fn many_meshes_of_different_files() {
    let count = 5_000;
    let mesh = |i: usize| format!("[[mesh]]\nobj = \"{i}.obj\"\ntranslate = [{}, {}, 0]\n", i % 300, i / 300);
    let folder = Folder::new(&[("scene.toml", &(CAMERA.to_owned() + &lines(count, mesh)))]);
    // All of them name one library, which is read once.
    folder.write("all.mtl", lines(count, |i| format!("newmtl m{i}\nKd 0.5 0.5 1.5\n")).as_bytes());
    for i in 0..count {
        let obj = format!("mtllib all.mtl\nmtllib gone.mtl\nusemtl m{i}\n{TRIANGLE}");
        folder.write(&format!("{i}.obj"), obj.as_bytes());
    }
    let scene = load_soon(&folder, "scene.toml");
    assert_eq!((scene.meshes.len(), scene.materials[777].name.as_str()), (count, "m777"));
    assert!(warned(&scene, &["0.obj: cannot read its material file `gone.mtl`"]), "{:?}", scene.warnings);
    assert!(warned(&scene, &["7.obj", "gone.mtl", "(and 4992 more like this)"]), "{:?}", scene.warnings);
    assert!(warned(&scene, &["all.mtl: material `m7`", "clamped (and 4992 more like this)"]), "{:?}", scene.warnings);
    assert_eq!(scene.warnings.len(), 8 + 8 + 1, "{:?}", scene.warnings);
}

#[test]
fn many_materials_that_no_mesh_uses_are_one_warning() {
    let entry = |i: usize| format!("[material.unused_{i}]\nalbedo = [0.5, 0.5, 0.5]\n");
    let toml = format!("{TOML}{}", lines(MANY, entry));
    let scene = load_soon(&Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", &toml)]), "scene.toml");
    let told: Vec<_> = scene.warnings.iter().filter(|w| w.contains("no mesh uses")).collect();
    assert_eq!(told.len(), 1, "{:?}", scene.warnings);
    let words =
        ["scene.toml:6: ", "`unused_0`; the nearest in use is `default`", "; nor `unused_7` of line 20 (`default`)"];
    assert!(words.iter().all(|word| told[0].contains(word)), "{told:?}");
    assert!(told[0].ends_with("; nor 99992 more") && !told[0].contains("`unused_8`"), "{told:?}");
}

/// An OBJ of as many triangles, side by side, as materials, `m0` and so on.
fn obj_of_materials(count: usize) -> String {
    let triangle = |i: usize| {
        let (x, y) = (i % 300 * 2, i / 300 * 2);
        format!("v {x} {y} 0\nv {} {y} 0\nv {x} {} 0\nusemtl m{i}\nf -3/1 -2/2 -1/3\n", x + 1, y + 1)
    };
    format!("mtllib mesh.mtl\nvt 0 0\nvt 1 0\nvt 0 1\n{}", lines(count, triangle))
}

/// A picture of one red pixel.
fn red() -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(1, 1, image::Rgb([255, 0, 0])).write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

#[test]
fn many_materials_in_use() {
    // Of every three one is clamped, one has a picture, and one a picture and a mask that are not there.
    let mtl = |i: usize| match i % 3 {
        0 => format!("newmtl m{i}\nKd 1.5 0.{i} 0\nKs -1 0 0\nKe -1 0 0\n"),
        1 => format!("newmtl m{i}\nmap_Kd red.png\nmap_d red.png\n"),
        _ => format!("newmtl m{i}\nmap_Kd -bm 1 gone{i}.png\nmap_d gone{i}.png\n"),
    };
    let entries = lines(MANY, |i| format!("[material.m{i}]\nemission = [0, 0, {i}]\n"));
    let (obj, toml) = (obj_of_materials(MANY), format!("{TOML}{entries}"));
    let folder = Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", &lines(MANY, mtl)), ("scene.toml", &toml)]);
    folder.write("red.png", &red());
    for name in ["mesh.obj", "scene.toml"] {
        let scene = load_soon(&folder, name);
        assert_eq!((scene.materials.len(), scene.textures.len(), scene.masks.len()), (MANY, 1, 1), "{name}");
        assert!(scene.materials[1].texture.is_some() && scene.materials[MANY - 3].alpha_mask.is_some());
        if name == "scene.toml" {
            assert_eq!(scene.materials[MANY - 1].emission[2] as usize, MANY - 1);
        }
        for words in
            [["Kd", "clamped"], ["Ks", "clamped"], ["Ke", "clamped"], ["texture of", "gone"], ["cut-out", "gone"]]
        {
            assert!(warned(&scene, &[words[0], words[1], "more like this"]), "{name}: {words:?} {:?}", scene.warnings);
        }
    }
}

#[test]
fn many_textures() {
    let count = 5_000;
    let mtl = lines(count, |i| format!("newmtl m{i}\nmap_Kd p/{i}.png\nmap_d p/{i}.png\n"));
    let folder = Folder::new(&[("mesh.obj", &obj_of_materials(count)), ("mesh.mtl", &mtl), ("p/0", "")]);
    let red = red();
    (0..count).for_each(|i| folder.write(&format!("p/{i}.png"), &red));
    let scene = load_soon(&folder, "mesh.obj");
    assert_eq!((scene.textures.len(), scene.masks.len()), (count, count));
    assert_eq!(scene.materials[count - 1].texture.map(|used| used.texture as usize), Some(count - 1));
}

#[test]
fn a_library_named_again_and_again_is_read_once() {
    let named = |library: &str| lines(MANY, |_| format!("mtllib {library}\nusemtl p\n")) + TRIANGLE;
    let mtl = format!("newmtl p\nKd 2 0 0\n{}", lines(MANY, |i| format!("newmtl q{i}\n")));
    let files = [("present.obj", &named("rep.mtl")), ("missing.obj", &named("nope.mtl")), ("rep.mtl", &mtl)];
    let folder = Folder::new(&files.map(|(name, text)| (name, text.as_str())));
    for (name, words) in [("present.obj", ["rep.mtl", "clamped"]), ("missing.obj", ["nope.mtl", "grey instead"])] {
        let scene = load_soon(&folder, name);
        let told: Vec<_> = scene.warnings.iter().filter(|w| words.iter().all(|word| w.contains(word))).collect();
        assert!(told.len() == 1 && !told[0].contains("times"), "{:?}", scene.warnings);
    }
}

#[test]
fn names_of_megabytes() {
    let long = "n".repeat(1 << 20);
    // One file of one such name, placed a thousand times: a gigabyte, if every mesh had the name.
    let obj = format!("mtllib {long}\nmtllib mesh.mtl\nusemtl {long}\n{TRIANGLE}usemtl {long}2\nf 1 2 3\n");
    let mut mtl = String::new();
    for name in [format!("{long}1"), long.clone()] {
        let _ = writeln!(mtl, "newmtl {name}\nKd 2 0 0\nmap_Kd {name}.png\nmap_d {name}.png");
    }
    let mut toml = CAMERA.to_owned();
    toml += &lines(1000, |i| format!("[[mesh]]\nobj = \"mesh.obj\"\ntranslate = [0, 0, {i}]\n"));
    toml += &format!("[material.{long}]\nemission = [1, 2, 3]\n");
    toml += &lines(10, |i| format!("[material.{long}{i}{i}]\nemission = [1, 2, 3]\n"));
    let folder = Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", &mtl), ("scene.toml", &toml)]);
    let scene = load_soon(&folder, "scene.toml");
    assert_eq!((scene.materials.len(), scene.materials[0].emission), (2000, [1.0, 2.0, 3.0]));
    assert!(scene.materials.iter().all(|m| m.name.len() < 2200));
    assert!(warned(&scene, &["no mesh uses", "; nor 2 more"]) && warned(&scene, &["no MTL defines"]));
    load_soon(&folder, "mesh.obj");
    let odd = |text: String| Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", &text)]).load("scene.toml");
    for text in
        [format!("{long} = 1\n"), format!("{TOML}{long} = 1\n"), format!("{TOML}[render]\nstrategy = '{long}'\n")]
    {
        assert!(odd(text).is_err());
    }
}
