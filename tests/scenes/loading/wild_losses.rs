//! What a material loses on its way into a scene is said, and nothing is said of what loses nothing.

use super::common::*;
use octray::scene::SceneDesc;
use octray::scene::desc::Scattering;

/// What loading an MTL of one material says, but for what every bare OBJ is told.
fn told(lines: &str) -> (SceneDesc, Vec<String>) {
    let obj = format!("mtllib mesh.mtl\nusemtl m\nvt 0 0\n{TRIANGLE}");
    let folder = Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", &format!("newmtl m\n{lines}\n"))]);
    for (name, pixels) in [
        ("red.png", vec![[255, 0, 0, 255]]),
        ("hole.png", vec![[9, 9, 9, 0], [9, 9, 9, 255]]),
        ("whole.png", vec![[9, 9, 9, 255], [90, 9, 9, 128]]),
        ("none.png", vec![[255, 255, 255, 127], [255, 255, 255, 0]]),
    ] {
        let mut png = std::io::Cursor::new(Vec::new());
        let picture = image::RgbaImage::from_fn(pixels.len() as u32, 1, |x, _| image::Rgba(pixels[x as usize]));
        picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
        folder.write(name, &png.into_inner());
    }
    let scene = folder.load("mesh.obj").expect(lines);
    let other = |w: &&String| !w.starts_with("no camera") && !w.starts_with("nothing emits");
    let told = scene.warnings.iter().filter(other).cloned().collect();
    (scene, told)
}

/// The one warning of an MTL has these words; without words there is none.
fn assert_told(lines: &str, words: &[&str]) -> SceneDesc {
    let (scene, told) = told(lines);
    assert_eq!(told.len(), usize::from(!words.is_empty()), "{lines}: {told:?}");
    assert!(told.iter().all(|told| words.iter().all(|word| told.contains(word))), "{lines}: {told:?}");
    scene
}

#[test]
fn pictures_that_their_material_cannot_show() {
    assert_told("Kd 0.8 0.8 0.8\nPm 1\nmap_Kd red.png", &["red.png: map_Kd has no effect", "`m`", "a conductor"]);
    assert_told("Kd 0.8 0.8 0.8\nillum 5\nmap_Kd red.png", &["map_Kd has no effect", "a mirror"]);
    assert_told("d 0.5\nNi 1.5\nmap_Kd red.png", &["map_Kd has no effect", "a dielectric"]);
    assert_told("Kd 0.8 0.8 0.8\nKs 0.1 0.1 0.1\nmap_Kd red.png", &[]);
    assert_told("Kd 0.8 0.8 0.8\nPm 1\nmap_Ke red.png\nmap_d hole.png", &[]);
}

#[test]
fn masks_that_mask_nothing_or_everything() {
    let scene = assert_told("Kd 0.8 0.8 0.8\nmap_d hole.png", &[]);
    assert!(scene.materials[0].alpha_mask.is_some());
    assert_told("Kd 0.8 0.8 0.8\nmap_d red.png", &["red.png: as a cut-out it masks nothing", "alpha channel"]);
    assert_told("Kd 0.8 0.8 0.8\nmap_d whole.png", &["whole.png: as a cut-out it masks nothing"]);
    assert_told("Kd 0.8 0.8 0.8\nmap_d none.png", &["none.png: as a cut-out it masks everything"]);
}

#[test]
fn lines_that_are_not_read_are_counted_by_keyword() {
    let lines = "map_Bump a.png\nmap_bump a.png\nnorm a.png\nmap_Ks a.png\nmap_ns a.png\nmap_Ka a.png\ndisp a.png\n\
                 map_x a.png\nmap_Y a.png";
    let (_, told) = told(lines);
    let expected = [
        "map_Bump is not read: 2 line(s)",
        "norm is not read: 1 line(s)",
        "map_Ks is not read",
        "map_Ns is not read",
        "disp is not read",
        "mesh.mtl:9: 2 line(s) of map_ keywords that are unknown have no effect, the first `map_x`",
    ];
    assert_eq!(told.len(), expected.len(), "{told:?}");
    for words in expected {
        assert!(told.iter().any(|told| told.contains(words)), "{words}: {told:?}");
    }
    // However many materials, one of each.
    let many: String = (0..1000).map(|i| format!("newmtl m{i}\nmap_Bump {i}.png\n")).collect();
    let told = load_mtl(&many).unwrap().warnings;
    assert!(
        told.iter().any(|w| w.contains("map_Bump is not read: 1000 line(s)") && !w.contains("more like")),
        "{told:?}"
    );
    let coloured = load_obj("v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n").unwrap();
    assert!(warned(&coloured, &["mesh.obj: colours of vertices are not read"]));
}

fn ior(scene: &SceneDesc) -> Option<f64> {
    match scene.materials[0].scattering {
        Scattering::Dielectric { ior, .. } | Scattering::Plastic { ior, .. } => Some(ior),
        _ => None,
    }
}

#[test]
fn ni_is_what_it_says() {
    let of_f32 = |x: f32| Some(f64::from(x));
    let cases: &[(&str, Option<f64>, &[&str])] = &[
        // Glass.
        ("d 0.5\nNi 1.0", Some(1.0), &[]),
        ("d 0.5\nNi 1.001", of_f32(1.001), &[]),
        ("Tr 0.5\nNi 1", Some(1.0), &[]),
        ("illum 7\nNi 1", Some(1.0), &[]),
        ("illum 7", Some(1.5), &[]),
        ("d 0.5\nNi 0.75", Some(0.75), &["Ni 0.75 is below 1"]),
        ("d 0.5\nNi 0", Some(1.5), &["Ni 0 ", "1.5 instead"]),
        ("illum 4\nNi -1", Some(1.5), &["Ni -1 ", "1.5 instead"]),
        ("illum 4\nNi 100", Some(20.0), &["Ni 100 ", "20 instead"]),
        // Coats, of which 1 is what nobody has chosen.
        ("Kd 1 1 1\nKs 1 1 1\nNi 1", Some(1.5), &[]),
        ("Kd 1 1 1\nKs 1 1 1\nNi 1.005", Some(1.01), &[]),
        ("Kd 1 1 1\nKs 1 1 1\nNi 0.5", Some(1.5), &["Ni 0.5 ", "1.5 instead"]),
        // Of what has no index nothing is said.
        ("Kd 1 1 1\nNi 0", None, &[]),
    ];
    for (lines, expected, words) in cases {
        assert_eq!(ior(&assert_told(lines, words)), *expected, "{lines}");
    }
    // Other kinds by the scene file: no coat of 1, no glass of 1 that nobody asked for.
    let obj = format!("mtllib mesh.mtl\nusemtl m\n{TRIANGLE}");
    for (mtl, kind, expected) in [
        ("newmtl m\nd 0.5\nNi 1\n", "plastic", 1.5),
        ("newmtl m\nd 0.5\nNi 1\n", "dielectric", 1.0),
        ("newmtl m\nd 0.5\nNi 0.5\n", "plastic", 1.5),
        ("newmtl m\nKd 1 1 1\nNi 1\n", "dielectric", 1.5),
    ] {
        let toml = format!("{TOML}[material.m]\nkind = '{kind}'\n");
        let folder = Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", mtl), ("scene.toml", &toml)]);
        assert_eq!(ior(&folder.load("scene.toml").unwrap()), Some(expected), "{mtl} {kind}");
    }
}

#[test]
fn d_counts_where_tr_contradicts_it() {
    let cases: &[(&str, bool, &[&str])] = &[
        ("d 1\nTr 1\nNi 1.5", false, &["d 1 and Tr 1 contradict each other", "d counts"]),
        ("Tr 1\nd 1\nNi 1.5", false, &["d counts"]),
        ("d 0\nTr 0\nNi 1.5", true, &["d 0 and Tr 0 contradict"]),
        ("d 0.5\nTr 0\nNi 1.5", true, &["d counts"]),
        ("d 1\nTr 0\nNi 1.5", false, &[]),
        ("d 0.3\nTr 0.7\nNi 1.5", true, &[]),
        ("Tr 1\nNi 1.5", true, &[]),
        ("Tr 0\nNi 1.5", false, &[]),
        ("d 0.3", false, &["d 0.3 without Ni", "stays opaque"]),
        ("Tr 0.7\nPm 1", false, &["Tr 0.7 without Ni", "stays opaque"]),
        ("d 1", false, &[]),
    ];
    for (lines, glass, words) in cases {
        let scene = assert_told(&format!("Kd 0.8 0.1 0.1\n{lines}"), words);
        assert_eq!(matches!(scene.materials[0].scattering, Scattering::Dielectric { .. }), *glass, "{lines}");
    }
}
