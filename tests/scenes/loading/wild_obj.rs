//! OBJ and MTL files as programs really write them: names, line ends, encodings, several libraries.

use super::common::*;
use octray::scene::SceneDesc;
use octray::scene::desc::Scattering;
use std::path::{Path, PathBuf};

const RED: [f64; 3] = [1.0, 0.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];
const RED_MTL: &str = "newmtl red\nKd 1 0 0\n";

/// The albedo of a triangle's material.
fn albedo(scene: &SceneDesc, triangle: usize) -> [f64; 3] {
    match scene.materials[scene.geometry().triangles[triangle].material as usize].scattering {
        Scattering::Diffuse { albedo } => albedo,
        other => panic!("{other:?} is not diffuse"),
    }
}

/// The warnings but for those of every bare OBJ.
fn told(scene: &SceneDesc) -> Vec<&str> {
    let told = scene.warnings.iter().map(String::as_str);
    told.filter(|w| !w.starts_with("no camera") && !w.starts_with("nothing emits")).collect()
}

fn assert_red(folder: &Folder, name: &str) {
    let scene = folder.load(name).expect(name);
    assert_eq!((albedo(&scene, 0), told(&scene)), (RED, vec![]), "{name}");
}

/// A picture of one pixel.
fn png(pixel: [u8; 4]) -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(1, 1, image::Rgba(pixel)).write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

#[test]
fn names_of_materials_lose_quotes_and_comments_where_nothing_has_them() {
    let pairs = [
        ("red # wall", "red"),
        ("red", "red # wall"),
        ("red # this", "red # that"),
        ("\"red\"", "red"),
        ("red", "\"red\""),
        ("'red' # wall", "red\t# wall"),
        ("\"re d\"", "re d"),
        ("Material #25", "Material #25"),
        ("\"red\"", "\"red\""),
    ];
    for (used, defined) in pairs {
        let obj = format!("mtllib a.mtl\nusemtl {used}\n{TRIANGLE}");
        let mtl = format!("newmtl {defined}\nKd 1 0 0\n");
        assert_red(&Folder::new(&[("mesh.obj", &obj), ("a.mtl", &mtl)]), "mesh.obj");
    }
    // As written goes first, whatever stands before it.
    let mtl = "newmtl Material\nKd 0 0 1\nnewmtl Material #25\nKd 1 0 0\n";
    let obj = format!("mtllib a.mtl\nusemtl Material #25\n{TRIANGLE}");
    assert_red(&Folder::new(&[("mesh.obj", &obj), ("a.mtl", mtl)]), "mesh.obj");
    // A scene file knows the material by what is left.
    let toml = format!("{TOML}[material.red]\nalbedo = [1, 0, 0]\n[environment]\nradiance = [1, 1, 1]\n");
    for mtl in ["", "newmtl \"red\"\nKd 0 0 1\n"] {
        let obj = format!("mtllib a.mtl\nusemtl red # wall\n{TRIANGLE}");
        let folder = Folder::new(&[("mesh.obj", &obj), ("a.mtl", mtl), ("scene.toml", &toml)]);
        let scene = folder.load("scene.toml").unwrap();
        assert_eq!(albedo(&scene, 0), RED);
        assert!(!warned(&scene, &["no mesh uses"]) && !warned(&scene, &["no MTL defines"]), "{:?}", scene.warnings);
    }
}

#[test]
fn names_of_libraries_lose_quotes_and_comments_where_no_file_has_them() {
    let file_names = ["red.mtl", "two words.mtl", "a #b.mtl", "\"q\".mtl"];
    let lines = [
        ("\"red.mtl\"", 0),
        ("'red.mtl'", 0),
        ("red.mtl # the walls", 0),
        ("\"red.mtl\" # the walls", 0),
        ("none.mtl \"red.mtl\"", 0),
        ("\"two words.mtl\"", 1),
        ("two words.mtl # \"x\"", 1),
        ("none.mtl two words.mtl", 1),
        ("a #b.mtl", 2),
        ("\"q\".mtl", 3),
        ("\"sub\\red.mtl\"", 4),
    ];
    for (line, file) in lines {
        let name = file_names.get(file).unwrap_or(&"sub/red.mtl");
        for keyword in ["mtllib", "MTLLIB", "Mtllib"] {
            let obj = format!("{keyword} {line}\nusemtl red\n{TRIANGLE}");
            let scene = Folder::new(&[("mesh.obj", &obj), (name, RED_MTL)]).load("mesh.obj").unwrap();
            assert_eq!(albedo(&scene, 0), RED, "{line}");
            let missing = told(&scene).into_iter().filter(|w| !w.contains("`none.mtl`")).count();
            assert_eq!(missing, 0, "{line}: {:?}", scene.warnings);
        }
    }
    // Lost is what the line names, not each of its words.
    let scene = load_obj(&format!("mtllib my paints.mtl\nmtllib \"my paints.mtl\"\n{TRIANGLE}")).unwrap();
    assert_eq!(told(&scene).len(), 1, "{:?}", scene.warnings);
    assert!(told(&scene)[0].contains("`my paints.mtl`: grey"), "{:?}", scene.warnings);
}

#[test]
fn names_of_pictures_may_have_quotes_comments_and_options_on_both_sides() {
    let cases = [
        ("map_Kd red.png", [1.0, 1.0]),
        ("map_Kd \"red.png\"", [1.0, 1.0]),
        ("map_kd 'red.png' # x", [1.0, 1.0]),
        ("MAP_KD red.png # the -s 2 2 wall", [1.0, 1.0]),
        ("map_Kd red.png -s 2 3 1", [2.0, 3.0]),
        ("map_Kd  red.png\t-s 2 3 -o 0 0 0  # x", [2.0, 3.0]),
        ("map_Kd -o 0 0 0 red.png -S 2 3", [2.0, 3.0]),
        ("map_Kd -s 2 3 1 \"red.png\" -o 0", [2.0, 3.0]),
        ("map_Kd two - words -s.png", [1.0, 1.0]),
        ("map_Kd two - words -s.png -s 2", [2.0, 1.0]),
        ("map_Kd \"two - words -s.png\" -s 2", [2.0, 1.0]),
        ("map_Kd sub\\red.png -s 2", [2.0, 1.0]),
    ];
    let files = ["red.png", "two - words -s.png", "sub/red.png"];
    for (line, scale) in cases {
        let obj = format!("mtllib mesh.mtl\nusemtl m\nvt 0 0\n{TRIANGLE}");
        let folder = Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", &format!("newmtl m\n{line}\n"))]);
        files.iter().for_each(|name| folder.write(name, &png([255, 0, 0, 255])));
        let scene = folder.load("mesh.obj").unwrap();
        assert_eq!(told(&scene), [""; 0], "{line}");
        assert_eq!(scene.materials[0].texture.map(|used| used.scale), Some(scale), "{line}");
    }
    // What is missing has the name that was meant.
    for (line, name) in [
        ("map_Kd \"gone.png\"", "gone.png: "),
        ("map_Kd gone.png -s 1 1 1", "gone.png: "),
        ("map_Kd a\\gone #2.png", "gone #2.png: "),
    ] {
        let scene = load_mtl(&format!("newmtl m\n{line}\n")).unwrap();
        assert_eq!(told(&scene).len(), 1, "{line}: {:?}", scene.warnings);
        assert!(told(&scene)[0].contains(name), "{line}: {:?}", scene.warnings);
    }
    assert_eq!(told(&load_mtl("newmtl m\nmap_Kd # none\n").unwrap()), [""; 0]);
}

#[test]
fn keywords_have_any_capitals() {
    let obj = "MTLLIB a.mtl\nUSEMTL red\nV 0 0 0\nV 1 0 0\nv 0 1 0\nVT 0 0\nVN 0 0 -1\nF 1/1/1 2/1/1 -1/1/1\n";
    for mtl in ["NEWMTL red\nKD 1 0 0\nNS 10\n", "Newmtl red\nkd 1 0 0\nKS 0 0 0\nILLUM 2\nD 1\ntr 0\n"] {
        let folder = Folder::new(&[("mesh.obj", obj), ("a.mtl", mtl)]);
        assert_red(&folder, "mesh.obj");
        assert!(folder.load("mesh.obj").unwrap().geometry().triangles[0].flipped, "VN rules");
    }
    let message = load_obj("V 0 0 0\nV 1 x 0\nF 1 1 3\n").unwrap_err();
    assert!(message.starts_with("mesh.obj:3: face corner `3`"), "{message}");
    let message = load_obj("V 0 0 0\nV 1 x 0\nF 1 1 1\n").unwrap_err();
    assert!(message.starts_with("mesh.obj:2: `x`"), "{message}");
}

/// A text in UTF-16.
fn units(text: &str, to: fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(to).collect()
}

#[test]
fn every_line_end_and_every_encoding_is_read() {
    let obj = format!("# group one\nmtllib a.mtl\n# é\nusemtl red\n{TRIANGLE}");
    let ends: [fn(&str) -> String; 5] = [
        |text| text.to_owned(),
        |text| text.replace('\n', "\r\n"),
        |text| text.replace('\n', "\r"),
        |text| text.replacen('\n', "\r", 3),
        |text| text.replace('\n', "\r\r\n"),
    ];
    for end in ends {
        let (obj, mtl) = (end(&obj), end(RED_MTL));
        let encodings: [fn(&str) -> Vec<u8>; 6] = [
            |text| text.into(),
            |text| format!("\u{feff}{text}").into(),
            |text| units(&format!("\u{feff}{text}"), u16::to_le_bytes),
            |text| units(&format!("\u{feff}{text}"), u16::to_be_bytes),
            |text| units(text, u16::to_le_bytes),
            |text| units(text, u16::to_be_bytes),
        ];
        for encode in encodings {
            let folder = Folder::new(&[]);
            folder.write("mesh.obj", &encode(&obj));
            folder.write("a.mtl", &encode(&mtl));
            assert_red(&folder, "mesh.obj");
        }
    }
    for (obj, mtl, words) in [
        (&b"\xff\xfe\0\0v\0\0\0"[..], &b""[..], "mesh.obj: it is UTF-32"),
        (b"mtllib a.mtl\nv 0 0 0\nf 1 1 1", b"newmtl red\nKd 1 \0 0", "a.mtl:2: a zero byte"),
        (b"\x7fELF\x02\x01\x01\0\0\0\0\0", b"", "mesh.obj:1: a zero byte"),
    ] {
        let folder = Folder::new(&[]);
        folder.write("mesh.obj", obj);
        folder.write("a.mtl", mtl);
        let message = folder.load("mesh.obj").expect_err(words);
        assert!(message.starts_with(words), "{message}");
    }
    // The line is the one that an editor shows.
    let message = load_obj("v 0 0 0\rv 1 0 0\rv x 0 0\rf 1 2 3\r").unwrap_err();
    assert!(message.starts_with("mesh.obj:3: `x`"), "{message}");
}

/// Two libraries that define `paint`, one of them also `red` and `blue`.
fn paints(obj: &str) -> Folder {
    let a = "newmtl paint\nKd 1 0 0\nnewmtl red\nKd 1 0 0\nnewmtl same\nKd 1 0 0\n";
    let b = "newmtl paint\nKd 0 0 1\nnewmtl blue\nKd 0 0 1\nnewmtl same\nKd 1 0 0\n";
    Folder::new(&[("mesh.obj", obj), ("a.mtl", a), ("b.mtl", b)])
}

#[test]
fn the_first_library_that_has_the_name_counts() {
    let face = "f 1 2 3\n";
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (libraries, expected) in [
        ("mtllib a.mtl b.mtl\n", RED),
        ("mtllib b.mtl a.mtl\n", BLUE),
        ("mtllib a.mtl\nmtllib b.mtl\n", RED),
        ("mtllib a.mtl\nv 9 9 9\nmtllib b.mtl\nmtllib a.mtl\n", RED),
    ] {
        let scene =
            paints(&format!("{head}{libraries}usemtl paint\n{face}usemtl same\n{face}")).load("mesh.obj").unwrap();
        assert_eq!(albedo(&scene, 0), expected, "{libraries}");
        let first = if expected == RED { "a.mtl" } else { "b.mtl" };
        assert_eq!(told(&scene).len(), 1, "{:?}", scene.warnings);
        assert!(warned(&scene, &["define `paint` twice", first]), "{:?}", scene.warnings);
        // Nothing is told of what no face uses.
        let scene =
            paints(&format!("{head}{libraries}usemtl red\n{face}usemtl blue\n{face}")).load("mesh.obj").unwrap();
        assert_eq!((albedo(&scene, 0), albedo(&scene, 1), told(&scene)), (RED, BLUE, vec![]), "{libraries}");
    }
    // One file that defines a name twice.
    let mtl = "newmtl m\nKd 1 0 0\nnewmtl m\nKd 0 0 1\n";
    let scene = load_mtl(mtl).unwrap();
    assert!(albedo(&scene, 0) == RED && warned(&scene, &["`m` twice", "mesh.mtl"]), "{:?}", scene.warnings);
    assert_eq!(told(&load_mtl(&format!("{RED_MTL}newmtl m\n{RED_MTL}newmtl m\n")).unwrap()), [""; 0]);
}

#[test]
fn joined_files_keep_their_own_libraries() {
    let face = "f 1 2 3\n";
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let cases = [
        // Each part has its own.
        (format!("mtllib a.mtl\n{head}usemtl paint\n{face}mtllib b.mtl\nusemtl paint\n{face}"), [RED, BLUE]),
        (format!("{head}mtllib b.mtl\nusemtl paint\n{face}mtllib a.mtl\nusemtl paint\n{face}"), [BLUE, RED]),
        // A face keeps its material where only a library follows.
        (format!("mtllib a.mtl\n{head}usemtl paint\n{face}mtllib b.mtl\n{face}"), [RED, RED]),
        // The library stands below.
        (format!("{head}usemtl paint\n{face}{face}mtllib a.mtl\n"), [RED, RED]),
        // What the nearest lacks another has.
        (format!("mtllib a.mtl\n{head}usemtl blue\n{face}mtllib b.mtl\nusemtl red\n{face}"), [BLUE, RED]),
        (format!("mtllib a.mtl\n{head}usemtl red\n{face}mtllib a.mtl\nusemtl red\n{face}"), [RED, RED]),
    ];
    for (obj, expected) in cases {
        let scene = paints(&obj).load("mesh.obj").unwrap();
        assert_eq!(([0, 1].map(|i| albedo(&scene, i)), told(&scene)), (expected, vec![]), "{obj}");
    }
    // One library again and again is one material and one run of faces.
    let obj = format!("{head}{}", format!("mtllib a.mtl\nusemtl paint\n{face}").repeat(181));
    let scene = paints(&obj).load("mesh.obj").unwrap();
    assert_eq!((scene.materials.len(), scene.meshes[0].positions.len()), (1, 3));
}

#[test]
fn very_many_libraries_and_names_take_no_longer_than_their_text() {
    let count = 20_000;
    let lines: String = (0..count).map(|i| format!("mtllib {}a.mtl\n", "./".repeat(i % 100))).collect();
    let uses: String = (0..count).map(|i| format!("usemtl gone{i}\nf 1 2 3\nmtllib b.mtl b{i}.mtl\n")).collect();
    let obj = format!("{lines}{TRIANGLE}{uses}");
    let start = std::time::Instant::now();
    let scene = paints(&obj).load("mesh.obj").unwrap();
    assert!(start.elapsed().as_secs_f64() < 10.0, "{:?}", start.elapsed());
    assert!(scene.warnings.len() <= 64);
}

#[test]
fn devices_and_names_that_steer_terminals_are_refused() {
    let steering = "\u{1b}]0;PWNED\u{7}\u{1b}[31mx";
    for line in [format!("mtllib {steering}.mtl"), format!("mtllib a.mtl \"{steering}\""), "mtllib a\u{9b}b".into()] {
        let message = load_obj(&format!("{TRIANGLE}{line}\n")).expect_err(&line);
        assert!(message.starts_with("mesh.obj:5: ") && message.contains("no control characters"), "{message}");
    }
    for keyword in ["map_Kd", "map_Ke", "map_d", "MAP_D"] {
        let message = load_mtl(&format!("newmtl m\n{keyword} {steering}.png\n")).expect_err(keyword);
        assert!(message.starts_with("mesh.mtl:2: ") && message.contains("no control characters"), "{message}");
        if cfg!(target_os = "linux") {
            for name in ["/dev/zero", "\"/dev/zero\"", "-s 1 1 1 /dev/zero", "/dev/zero -s 2 2 2"] {
                let message = load_mtl(&format!("newmtl m\nnewmtl n\n{keyword} {name}\n")).expect_err(name);
                assert!(message.starts_with("mesh.mtl:3: ") && message.contains("/dev/zero is a device"), "{message}");
            }
        }
    }
}

/// The folder of cases from elsewhere, or `None` and a word about it.
fn cases(name: &str) -> Option<PathBuf> {
    let full = Path::new("../shared/cases/public").join(name);
    if !full.exists() {
        println!("skipped: {} is not there", full.display());
        return None;
    }
    Some(full)
}

#[test]
fn files_that_were_misread_once_are_read() {
    let Some(folder) = cases("mtl_names") else { return };
    for name in ["capital", "comment", "option_behind", "quoted_lib", "quoted_map"] {
        let scene = SceneDesc::load(folder.join(name).with_extension("obj")).unwrap();
        let [r, g, _] = albedo(&scene, 0);
        assert!(r > g || scene.materials[0].texture.is_some(), "{name}");
    }
    let Some(folder) = cases("line_ends") else { return };
    for (name, red) in [("cr", false), ("cr_mtl", true), ("stray_cr", true), ("utf16", false)] {
        let scene = SceneDesc::load(folder.join(name).with_extension("obj")).unwrap();
        assert_eq!((albedo(&scene, 0)[0] > 0.7, scene.geometry().triangles.len()), (red, 2), "{name}");
    }
    let Some(folder) = cases("mtllib_order") else { return };
    for name in ["list", "joined"] {
        let scene = SceneDesc::load(folder.join(name).with_extension("obj")).unwrap();
        assert!(albedo(&scene, 0)[0] > 0.7, "{name}");
    }
}
