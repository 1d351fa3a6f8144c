//! MTL files, the rules that turn them into materials, and TOML entries over them.

use super::common::*;
use octray::scene::desc::{MaterialDesc, Scattering};

fn diffuse(albedo: [f64; 3]) -> Scattering {
    Scattering::Diffuse { albedo }
}

fn glass(ior: f64) -> Scattering {
    Scattering::Dielectric { ior, transmittance: [1.0; 3] }
}

fn metal(reflectance: [f64; 3], alpha: f64) -> Scattering {
    Scattering::Conductor { alpha, reflectance, complex_ior: None }
}

fn plastic(albedo: [f64; 3], ior: f64, alpha: f64) -> Scattering {
    Scattering::Plastic { albedo, ior, alpha }
}

/// The material `m` of an MTL, and the words its warnings must have (none: no warning but camera and light).
fn material(lines: &str, words: &[&str]) -> MaterialDesc {
    let scene = load_mtl(&format!("newmtl m\n{lines}\n")).expect(lines);
    let told = scene.warnings.iter().filter(|w| !w.starts_with("no camera") && !w.starts_with("nothing emits"));
    assert_eq!(told.count(), usize::from(!words.is_empty()), "{lines}: {:?}", scene.warnings);
    assert!(warned(&scene, words), "{lines}: {:?}", scene.warnings);
    scene.materials[0].clone()
}

#[test]
fn the_first_rule_that_fits_decides() {
    let half = [0.5; 3];
    let cases: &[(&str, Scattering, &[&str])] = &[
        ("Kd 0.5 0.25 1", diffuse([0.5, 0.25, 1.0]), &[]),
        ("Kd 0.5 0.5 0.5\nKs 0 0 0\nNs 10\nd 1\nillum 2", diffuse(half), &[]),
        ("Kd 0.5 0.5 0.5\nKs 0.25 0.5 0.75\nillum 5", Scattering::Mirror { reflectance: [0.25, 0.5, 0.75] }, &[]),
        ("Kd 0.5 0.5 0.5\nillum 5", Scattering::Mirror { reflectance: half }, &[]),
        (
            "Kd 0.5 0.5 0.5\nKs 1 1 1\nPm 1\nd 0\nNi 1.5\nillum 5",
            Scattering::Mirror { reflectance: [1.0; 3] },
            &["d 0 has no effect", "illum 5"],
        ),
        ("Kd 0.5 0.5 0.5\nillum 4", glass(1.5), &[]),
        ("Kd 0.5 0.5 0.5\nNi 1\nillum 6", glass(1.0), &[]),
        ("Kd 0.5 0.5 0.5\nNi 2.5\nTf 0.1 0.1 0.1\nillum 7", glass(2.5), &[]),
        ("Kd 0.5 0.5 0.5\nd 0.5\nNi 1.25", glass(1.25), &[]),
        ("Kd 0.5 0.5 0.5\nTr 0.5\nNi 1.5\nPm 1", glass(1.5), &[]),
        ("Kd 0.5 0.5 0.5\nd 0.5", diffuse(half), &["d 0.5 without Ni", "stays opaque"]),
        ("Kd 0.5 0.5 0.5\nd -halo 0.5\nNi 1.5", glass(1.5), &[]),
        ("Kd 0.5 0.5 0.5\nPm 0.5\nPr 0.5", metal(half, 0.25), &[]),
        ("Kd 0.5 0.5 0.5\nKs 0.25 0.5 1\nPm 1\nNs 6", metal([0.25, 0.5, 1.0], 0.5), &[]),
        ("Kd 0.5 0.5 0.5\nPm 0.4", diffuse(half), &[]),
        ("Kd 0.5 0.5 0.5\nKs 0 0 0.125\nNs 6\nNi 1.75", plastic(half, 1.75, 0.5), &[]),
        ("Kd 0.5 0.5 0.5\nKs 0 0 0.125\nNs 30\nPr 1", plastic(half, 1.5, 1.0), &[]),
        ("Kd 0 0 0\nKs 0 0 0.125", metal([0.0, 0.0, 0.125], 1.0), &[]),
        ("Ks 0.5 0.5 0.5\nNs 198", metal(half, 0.1), &[]),
        ("", diffuse(half), &[]),
    ];
    for (lines, scattering, words) in cases {
        let m = material(lines, words);
        assert_eq!((m.scattering, m.emission), (*scattering, [0.0; 3]), "{lines}");
    }
}

#[test]
fn emission_is_ke_and_odd_writing_is_understood() {
    let lamp = material("Ke 17 12 4", &[]);
    assert_eq!((lamp.scattering, lamp.emission), (diffuse([0.0; 3]), [17.0, 12.0, 4.0]));
    assert_eq!(material("  Kd\t0.5   0.5 0.5 # grey\r", &[]).scattering, diffuse([0.5; 3]));
    assert_eq!(material("Kd .25", &[]).scattering, diffuse([0.25; 3]));
    assert_eq!(material("Kd 2.5e-1 +.25 0.25 extra", &[]).scattering, diffuse([0.25; 3]));
    assert_eq!(material("Kd 0.25 \\\n0.25 0.25", &[]).scattering, diffuse([0.25; 3]));
    assert_eq!(material("Kd spectral file.rfl", &[]).scattering, diffuse([0.5; 3]));
    assert_eq!(material("Kd 1.5 -1 1", &["Kd [1.5, -1.0, 1.0]", "clamped"]).scattering, diffuse([1.0, 0.0, 1.0]));
    assert_eq!(material("Ke 1 -1 1", &["Ke", "below 0"]).emission, [1.0, 0.0, 1.0]);
    assert_eq!(
        material("Kd 0.5 0.5 0.5\nmap_Kd -s 2 2 a b.png", &["a b.png", "texture of material `m`"]).scattering,
        diffuse([0.5; 3])
    );
    assert_eq!(material("Ke 1 1 1\nmap_Ke a.png", &["a.png", "texture of material `m`"]).emission, [1.0; 3]);
}

#[test]
fn faults_name_the_line_of_the_mtl() {
    let cases = [
        ("newmtl m\nKd 0.5 0.5", "mesh.mtl:2: `Kd` needs three numbers"),
        ("newmtl m\n\nKd", "mesh.mtl:3: `Kd` needs three numbers"),
        ("newmtl m\nKe nan 0 0", "mesh.mtl:2: `Ke nan`"),
        ("newmtl m\nKs 1 one 1", "mesh.mtl:2: `Ks one`"),
        ("newmtl m\nd", "mesh.mtl:2: `d` needs a number"),
        ("newmtl m\nillum 2.5", "mesh.mtl:2: `illum 2.5`"),
        ("newmtl m\nillum 256", "mesh.mtl:2: `illum 256`"),
        ("newmtl", "mesh.mtl:1: `newmtl` needs a name"),
    ];
    for (mtl, words) in cases {
        let message = load_mtl(mtl).expect_err(mtl);
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn libraries_may_be_many_and_have_blanks() {
    let (red, green) = ("newmtl red\nKd 1 0 0\n", "newmtl green\nKd 0 1 0\n");
    let tail = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl green\nf 1 2 3\n";
    let cases = [
        ("mtllib a.mtl b.mtl", ["a.mtl", "b.mtl"]),
        ("mtllib\ta.mtl\nmtllib  b.mtl ", ["a.mtl", "b.mtl"]),
        ("mtllib two words.mtl\nmtllib b.mtl", ["two words.mtl", "b.mtl"]),
        ("mtllib two\\ words.mtl b.mtl", ["two words.mtl", "b.mtl"]),
        ("mtllib sub\\a.mtl\nmtllib ./b.mtl", ["sub/a.mtl", "b.mtl"]),
    ];
    for (lines, names) in cases {
        let obj = format!("{lines}\n{tail}");
        let scene = Folder::new(&[("mesh.obj", &obj), (names[0], red), (names[1], green)]).load("mesh.obj").unwrap();
        let albedos: Vec<_> = scene.materials.iter().map(|m| m.scattering).collect();
        assert_eq!(albedos, [diffuse([1.0, 0.0, 0.0]), diffuse([0.0, 1.0, 0.0])], "{lines}");
        assert!(!warned(&scene, &["grey"]), "{:?}", scene.warnings);
    }
}

#[test]
fn what_no_mtl_defines_is_grey_and_said() {
    let obj = format!("mtllib gone.mtl\nusemtl m\n{TRIANGLE}");
    let scene = load_obj(&obj).unwrap();
    assert_eq!(scene.materials[0].scattering, diffuse([0.5; 3]));
    assert!(warned(&scene, &["gone.mtl", "cannot read", "grey"]) && warned(&scene, &["no MTL defines `m`"]));
    // Names may hold anything but a line's end.
    let obj = format!("mtllib mesh.mtl\nusemtl  Material #25 / é \n{TRIANGLE}");
    let mtl = " newmtl Material #25 / é\n\tKd 1 0 0";
    let scene = Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", mtl)]).load("mesh.obj").unwrap();
    assert_eq!(scene.materials[0].scattering, diffuse([1.0, 0.0, 0.0]));
    // No `usemtl` at all is no fault.
    assert!(!warned(&load_obj(TRIANGLE).unwrap(), &["grey"]));
}

/// The materials of an OBJ with `glass`, `mirror` and `lamp`, under the TOML entries `more`.
fn overridden(more: &str) -> Result<octray::scene::SceneDesc, String> {
    let mtl = "newmtl glass\nKd 0.1 0.1 0.1\nillum 7\nnewmtl mirror\nKs 1 1 1\nillum 5\n\
        newmtl lamp\nKd 0.3 0.3 0.3\nKe 1 2 3\n";
    let obj = format!(
        "mtllib mesh.mtl\nusemtl glass\n{TRIANGLE}usemtl mirror\nf 1 2 3\nusemtl lamp\nf 1 2 3\nusemtl new\nf 1 2 3\n"
    );
    Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", mtl), ("scene.toml", &format!("{TOML}{more}"))]).load("scene.toml")
}

#[test]
fn toml_entries_override_the_keys_they_name() {
    let scene = overridden("[material.lamp]\nalbedo = [0.7, 0.6, 0.5]\n").unwrap();
    assert_eq!(scene.materials[2].scattering, diffuse([0.7, 0.6, 0.5]));
    assert_eq!(scene.materials[2].emission, [1.0, 2.0, 3.0], "Ke survives");
    assert_eq!(scene.materials[0].scattering, glass(1.5));
    assert!(warned(&scene, &["no MTL defines `new`"]));

    let scene = overridden("[material.lamp]\nemission = [0, 0, 0]\n[material.new]\nemission = [1, 1, 1]\n").unwrap();
    assert_eq!(scene.materials[2].scattering, diffuse([0.3f32 as f64; 3]));
    assert_eq!(scene.materials[2].emission, [0.0; 3]);
    assert_eq!((scene.materials[3].scattering, scene.materials[3].emission), (diffuse([0.5; 3]), [1.0; 3]));
    assert!(!warned(&scene, &["no MTL defines"]), "{:?}", scene.warnings);

    let scene =
        overridden("[material.glass]\nkind = 'mirror'\n[material.mirror]\nkind = 'diffuse'\nalbedo = [0, 0, 1]\n")
            .unwrap();
    assert_eq!(scene.materials[0].scattering, Scattering::Mirror { reflectance: [0.1f32 as f64; 3] });
    assert_eq!(scene.materials[1].scattering, diffuse([0.0, 0.0, 1.0]));

    let scene = overridden("[material.mirror]\nreflectance = [0.5, 0.5, 0.5]\n").unwrap();
    assert_eq!(scene.materials[1].scattering, Scattering::Mirror { reflectance: [0.5; 3] });
    let scene = overridden("[material.glass]\nior = 1.25\ntransmittance = [1, 0.5, 1]\n").unwrap();
    assert_eq!(scene.materials[0].scattering, Scattering::Dielectric { ior: 1.25, transmittance: [1.0, 0.5, 1.0] });
    let gold = "[material.lamp]\nkind = 'conductor'\nalpha = 0.25\neta = [0.1, 0.4, 1.4]\nk = [4, 2.4, 1.6]\n";
    let complex_ior = Some(([0.1, 0.4, 1.4], [4.0, 2.4, 1.6]));
    let Scattering::Conductor { alpha, complex_ior: got, .. } = overridden(gold).unwrap().materials[2].scattering
    else {
        panic!("a conductor")
    };
    assert_eq!((alpha, got), (0.25, complex_ior));
    let coat = "[material.new]\nkind = 'plastic'\nalbedo = [0.25, 0.5, 1]\nior = 1.75\nalpha = 0.125\n";
    assert_eq!(overridden(coat).unwrap().materials[3].scattering, plastic([0.25, 0.5, 1.0], 1.75, 0.125));
    let brass = "[material.new]\nkind = 'principled'\nbase_color = [1, 0.75, 0.25]\nmetallic = 0.75\nroughness = 0.5\nior = 1.25\n";
    let wanted = Scattering::Principled { base_color: [1.0, 0.75, 0.25], metallic: 0.75, roughness: 0.5, ior: 1.25 };
    assert_eq!(overridden(brass).unwrap().materials[3].scattering, wanted);
    let silent = Scattering::Principled { base_color: [0.5; 3], metallic: 0.0, roughness: 1.0, ior: 1.5 };
    assert_eq!(overridden("[material.new]\nkind = 'principled'\n").unwrap().materials[3].scattering, silent);

    let message = overridden("[material.mirror]\nalbedo = [0.5, 0.5, 0.5]\n").unwrap_err();
    assert!(message.contains("scene.toml:6:") && message.contains("add a `kind`"), "{message}");
}

/// Pm and Pr mean the same as glTF's factors; Pm alone makes no MTL material principled.
#[test]
fn a_principled_entry_takes_the_rest_from_its_mtl() {
    let with = |lines: &str, more: &str| {
        let mtl = format!("newmtl m\n{lines}\n");
        let obj = format!("mtllib mesh.mtl\nusemtl m\n{TRIANGLE}");
        let toml = format!("{TOML}[material.m]\nkind = 'principled'\n{more}");
        let folder = Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", &mtl), ("scene.toml", &toml)]);
        folder.load("scene.toml").unwrap().materials[0].scattering
    };
    let (base_color, roughness) = ([0.5, 0.25, 1.0], 0.5);
    let lines = "Kd 0.5 0.25 1\nPm 0.25\nPr 0.5\nNi 1.75";
    let expected = |metallic, ior| Scattering::Principled { base_color, metallic, roughness, ior };
    assert_eq!(with(lines, ""), expected(0.25, 1.75));
    assert_eq!(with(lines, "metallic = 1\nior = 1\n"), expected(1.0, 1.0));
    assert_eq!(with("Kd 0.5 0.25 1\nPm 7\nPr 0.5", ""), expected(1.0, 1.5));
}

#[test]
fn an_entry_that_no_mesh_uses_is_a_warning() {
    let scene = overridden("[material.lmp]\nemission = [1, 1, 1]\n").unwrap();
    assert!(warned(&scene, &["scene.toml:6:", "`lmp`", "nearest in use is `lamp`"]), "{:?}", scene.warnings);
}
