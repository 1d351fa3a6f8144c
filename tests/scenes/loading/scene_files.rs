//! TOML scene files.

use super::common::*;
use octray::scene::desc::{EnvironmentDesc, Scattering};
use octray::{Guide, Lights, Roulette, Sampler, Strategy, Train};

/// `text` as the whole TOML fails with a message that has all `words`.
fn fails(text: &str, words: &[&str]) {
    let folder = Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", text)]);
    let message = folder.load("scene.toml").expect_err(text);
    assert!(words.iter().all(|word| message.contains(word)), "{text}\n{message}\nwanted {words:?}");
    assert!(!message.contains('\n') && message.starts_with("scene.toml"), "{message}");
}

/// [`TOML`] (5 lines) with `more` below it fails.
fn fails_below(more: &str, words: &[&str]) {
    fails(&format!("{TOML}{more}"), words);
}

#[test]
fn everything_a_file_may_say_arrives() {
    let toml = r#"
[camera]
position = [1, 2.5, -3]
look_at = [0, 0, 0]
up = [0, 0, 1]
vertical_fov = 19.5
aperture_radius = 0
focus_distance = 6.8
[film]
width = 640
height = 48
[render]
spp = 7
strategy = "nee"
lights = "power"
guide = "on"
roulette = "albedo"
train = 4096
sampler = "sobol"
max_depth = 0
rr_depth = "off"
seed = 4294967295
[[mesh]]
obj = "mesh.obj"
[material.default]
kind = "mirror"
reflectance = [0.1, 0.2, 1]
emission = [4, 5, 6]
two_sided = false
[environment]
radiance = [1, 0, 0.5]
scale = 2
"#;
    let scene = Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", toml)]).load("scene.toml").unwrap();
    assert_eq!(scene.camera.position, [1.0, 2.5, -3.0]);
    assert_eq!((scene.camera.up, scene.camera.vertical_fov), ([0.0, 0.0, 1.0], 19.5));
    assert_eq!(scene.film, (640, 48));
    let render = scene.render;
    assert_eq!(
        (render.spp, render.max_depth, render.rr_depth, render.seed),
        (Some(7), Some(0), Some(None), Some(u32::MAX))
    );
    assert_eq!(render.strategy, Some(Strategy::Nee));
    assert_eq!((render.lights, render.sampler), (Some(Lights::Power), Some(Sampler::Sobol)));
    let learning = (render.guide, render.roulette, render.train);
    assert_eq!(learning, (Some(Guide::On), Some(Roulette::Albedo), Some(Train::Paths(4096))));
    assert_eq!(scene.materials[0].scattering, Scattering::Mirror { reflectance: [0.1, 0.2, 1.0] });
    assert_eq!(scene.materials[0].emission, [4.0, 5.0, 6.0]);
    assert_eq!(scene.environment(), Some(&EnvironmentDesc::Constant { radiance: [2.0, 0.0, 1.0] }));
    assert!(scene.name.ends_with("scene.toml") && scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn silence_means_defaults() {
    let scene = load_toml("").unwrap();
    assert_eq!((scene.film, scene.render), ((512, 512), Default::default()));
    assert_eq!((scene.camera.up, scene.camera.vertical_fov), ([0.0, 1.0, 0.0], 35.0));
    assert!(warned(&scene, &["nothing emits", "black"]), "{:?}", scene.warnings);
    assert!(load_toml("[environment]\nradiance = [0, 0, 0]").unwrap().environment().is_none());
    assert_eq!(load_toml("[render]\nrr_depth = 3").unwrap().render.rr_depth, Some(Some(3)));
    assert_eq!(load_toml("[render]\ntrain = 'off'").unwrap().render.train, Some(Train::Off));
    // Without a camera the scene is framed like a bare OBJ, and says so.
    let folder = Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", "[[mesh]]\nobj = \"mesh.obj\"")]);
    assert!(warned(&folder.load("scene.toml").unwrap(), &["no camera"]));
}

#[test]
fn unknown_keys_name_the_nearest() {
    fails("[camra]\n", &["scene.toml:1:", "unknown key `camra`", "did you mean `camera`"]);
    fails_below("[film]\n\nwidht = 3", &["scene.toml:8:", "`widht` in [film]", "`width`"]);
    fails_below("[render]\nstratgy = 'nee'", &["scene.toml:7:", "`strategy`"]);
    fails_below("[render]\nrrdepth = 1", &["`rr_depth`"]);
    fails_below("rotation = 1", &["scene.toml:6:", "[[mesh]]", "`rotate`"]);
    fails_below("rotate = {axes = [0, 1, 0], degrees = 1}", &["scene.toml:6:", "`axis`"]);
    fails_below("[material.floor]\nalbdo = [0, 0, 0]", &["scene.toml:7:", "[material.floor]", "`albedo`"]);
    fails_below("[environment]\nradiane = [0, 0, 0]", &["`radiance`"]);
    fails("[camera]\nlookat = [0, 0, 0]", &["scene.toml:2:", "`look_at`"]);
    for word in ["fov", "vfov", "fovy", "FOV"] {
        fails(&format!("[camera]\n{word} = 40"), &["scene.toml:2:", "did you mean `vertical_fov`?"]);
    }
    // Only what may stand there: all of it where nothing is near.
    fails("[film]\nvertical_fov = 40", &["[film]; known here: width, height, filter"]);
    fails_below("[environment]\nfile = 'a.hdr'", &["[environment]; known here: ", "map"]);
}

#[test]
fn material_keys_must_fit_the_kind_and_their_range() {
    let fails_for = |entry: &str, words: &[&str]| fails_below(&format!("[material.a]\n{entry}"), words);
    fails_for("kind = 'metal'", &["scene.toml:7:", "unknown kind", "\"conductor\"", "\"plastic\""]);
    fails_for("kind = 'conductor'\nior = 1.5", &["scene.toml:8:", "a conductor has no `ior`", "`alpha`"]);
    fails_for("kind = 'dielectric'\nalbedo = [0, 0, 0]", &["scene.toml:8:", "a dielectric has no `albedo`"]);
    fails_for("kind = 'conductor'\neta = [1, 1, 1]", &["scene.toml:8:", "`eta` needs `k`"]);
    fails_for("kind = 'conductor'\nk = [1, 1, 1]", &["scene.toml:8:", "`k` needs `eta`"]);
    let both = "kind = 'conductor'\nreflectance = [1, 1, 1]\neta = [1, 1, 1]\nk = [1, 1, 1]";
    fails_for(both, &["scene.toml:8:", "exclude each other"]);
    fails_for("kind = 'conductor'\neta = [1, 1, 1]\nk = [1, -1, 1]", &["scene.toml:9:", "k is"]);
    for (entry, word) in [
        ("kind = 'conductor'\nalpha = 1.5", "alpha"),
        ("kind = 'conductor'\nalpha = -0.5", "alpha"),
        ("kind = 'conductor'\neta = [0, 1, 1]\nk = [1, 1, 1]", "eta"),
        ("kind = 'dielectric'\nior = 0", "ior"),
        ("kind = 'plastic'\nior = 1", "ior"),
        ("kind = 'plastic'\nalpha = 2", "alpha"),
        ("kind = 'principled'\nbase_color = [1, 1, 2]", "`base_color`"),
        ("kind = 'principled'\nmetallic = 1.5", "metallic is 1.5"),
        ("kind = 'principled'\nroughness = -1", "roughness is -1"),
        ("kind = 'principled'\nior = 0.9", "ior is 0.9; it must lie in [1, 20]"),
        ("kind = 'principled'\nalbedo = [1, 1, 1]", "a principled has no `albedo`; it has `base_color`"),
        ("kind = 'principled'\nalpha = 0.5", "a principled has no `alpha`; it has"),
    ] {
        fails_for(entry, &["scene.toml:8:", word]);
    }
    fails_for("kind = 'dielectric'\ntransmittance = [1, 1, 2]", &["scene.toml:8:", "transmittance"]);
}

#[test]
fn values_out_of_range_are_refused_with_their_line() {
    let camera = |lines: &str| format!("[camera]\nposition = [0, 0, 5]\n{lines}\n");
    fails(&camera("look_at = [0, 0, 5]"), &["scene.toml:2:", "same point"]);
    fails(&camera("look_at = [0, 0, 0]\nup = [0, 0, -2]"), &["scene.toml:4:", "parallel"]);
    fails(&camera("look_at = [0, 0, 0]\nup = [0, 0, 0]"), &["scene.toml:4:", "up is zero"]);
    for fov in ["0", "180", "-5", "nan", "inf", "1e999"] {
        fails(&camera(&format!("look_at = [0, 0, 0]\nvertical_fov = {fov}")), &["scene.toml:4:", "vertical_fov"]);
    }
    fails(&camera("look_at = [0, 0, 0]\naperture_radius = -1"), &["scene.toml:4:", "aperture_radius"]);
    fails(&camera("look_at = [0, 0, 0]\naperture_radius = inf"), &["scene.toml:4:", "aperture_radius"]);
    fails(&camera("look_at = [0, 0, 0]\nfocus_distance = 0"), &["scene.toml:4:", "focus_distance"]);
    fails(&camera("look_at = [0, 0, inf]"), &["scene.toml:3:", "look_at", "finite"]);
    fails(&camera("look_at = [0, 0, 1e39]"), &["scene.toml:3:", "look_at", "finite"]);
    fails(&camera(""), &["scene.toml:1:", "`look_at` is missing"]);
    for side in ["width = 0", "height = 65536", "width = -1", "height = 99999999999999999999"] {
        fails_below(&format!("[film]\n{side}"), &["scene.toml:7:", "1 to 65535"]);
    }
    fails_below("[render]\nspp = 0", &["scene.toml:7:", "`spp` is 0", "1 to"]);
    fails_below("[render]\nseed = -1", &["scene.toml:7:", "`seed` is -1"]);
    fails_below("[render]\ntrain = 0", &["scene.toml:7:", "`train` is 0"]);
    fails_below("[render]\ntrain = 'long'", &["scene.toml:7:", "`auto` or `off`"]);
    fails_below("[render]\nguide = 'maybe'", &["scene.toml:7:", "unknown", "auto"]);
    fails_below("[render]\nrr_depth = 'never'", &["scene.toml:7:", "\"off\""]);
    fails_below("[render]\nstrategy = 'mis'", &["scene.toml:7:", "unknown strategy `mis`", "mis-power"]);
    for albedo in ["[0, 0, 1.1]", "[-0.1, 0, 0]"] {
        fails_below(&format!("[material.a]\nalbedo = {albedo}"), &["scene.toml:7:", "between 0 and 1"]);
    }
    fails_below("[material.a]\nkind = 'mirror'\nreflectance = [2, 0, 0]", &["scene.toml:8:", "between 0 and 1"]);
    fails_below("[material.a]\nemission = [0, -1, 0]", &["scene.toml:7:", "negative"]);
    fails_below("[material.a]\nemission = [0, inf, 0]", &["scene.toml:7:", "finite"]);
    for text in ["1.1e30", "2e31", "3e38"] {
        let most = |line: &'static str| [line, "1e30", "largest radiance that works"];
        fails_below(&format!("[material.a]\nemission = [0, {text}, 0]"), &most("scene.toml:7:"));
        fails_below(&format!("[environment]\nradiance = [0, {text}, 0]"), &most("scene.toml:7:"));
        fails_below(&format!("[environment]\nradiance = [1, 0, 0]\nscale = {text}"), &most("scene.toml:8:"));
        let message = load_mtl(&format!("newmtl m\nKe 0 {text} 0\n")).expect_err(text);
        assert!(message.starts_with("mesh.mtl:2: `Ke") && message.contains("1e30"), "{message}");
    }
    assert!(load_mtl("newmtl m\nKe 1e30 1e30 0\n").is_ok());
    fails_below("[environment]\nradiance = [0, -1, 0]", &["scene.toml:7:", "negative"]);
    fails_below("[environment]\nradiance = [0, 1, 0]\nscale = -1", &["scene.toml:8:", "negative"]);
    fails_below("[environment]\nradiance = [0, 1e30, 0]\nscale = 1e30", &["scene.toml:8:", "1e30"]);
    fails_below("[environment]\nscale = 1", &["scene.toml:6:", "`radiance` or `map` is missing"]);
    fails_below("scale = 0", &["scene.toml:6:", "`scale` is 0"]);
    fails_below("rotate = {axis = [0, 0, 0], degrees = 1}", &["scene.toml:6:", "`axis` is zero"]);
    fails_below("rotate = {degrees = 1}", &["scene.toml:6:", "`axis` is missing"]);
}

#[test]
fn wrong_types_are_refused_with_their_line() {
    fails("camera = 3", &["scene.toml:1:", "[camera] must be a table, not an integer"]);
    fails("[[film]]\n", &["scene.toml:1:", "[film] may stand only once"]);
    fails("[mesh]\nobj = 'mesh.obj'", &["scene.toml:1:", "[[mesh]]", "double brackets"]);
    fails("mesh = [1]", &["scene.toml:1:", "double brackets"]);
    fails("material = 1", &["[material] must be a table"]);
    fails("[material]\nfloor = 1", &["scene.toml:2:", "[material.floor] must be a table"]);
    fails("[camera]\nposition = 'here'", &["scene.toml:2:", "three numbers", "not a string"]);
    fails("[camera]\nposition = [1, 2]", &["scene.toml:2:", "three numbers", "it has 2"]);
    fails("[camera]\nposition = [1, 2, true]", &["scene.toml:2:", "a number, not a boolean"]);
    fails_below("[film]\nwidth = 1.5", &["scene.toml:7:", "a whole number, not a float"]);
    fails_below("[render]\nstrategy = 1", &["scene.toml:7:", "a text in quotes, not an integer"]);
    fails_below("[render]\nrr_depth = 1.5", &["scene.toml:7:", "whole number"]);
    fails_below("rotate = 90", &["scene.toml:6:", "must be a table"]);
    fails_below("[material.a]\ntwo_sided = 1", &["scene.toml:7:", "true or false"]);
    fails_below("[material.a]\nkind = 'glass'", &["scene.toml:7:", "unknown kind", "\"mirror\""]);
    fails_below(
        "[material.a]\nkind = 'mirror'\nalbedo = [0, 0, 0]",
        &["scene.toml:8:", "a mirror has no `albedo`", "`reflectance`"],
    );
    fails_below(
        "[material.a]\nkind = 'diffuse'\nreflectance = [0, 0, 0]",
        &["scene.toml:8:", "a diffuse has no `reflectance`", "`albedo`"],
    );
    fails_below("[material.default]\nreflectance = [0, 0, 0]", &["scene.toml:6:", "add a `kind`"]);
}

#[test]
fn what_is_not_toml_or_not_there_is_refused() {
    fails("[camera\n", &["scene.toml:1:", "not TOML"]);
    fails("a = 1\nb = = 2", &["scene.toml:2:", "not TOML"]);
    fails("a = 1\na = 2", &["scene.toml:2:", "duplicate"]);
    fails("", &["no triangles", "[[mesh]]"]);
    fails("[[mesh]]", &["scene.toml:1:", "`obj` is missing"]);
    fails("[[mesh]]\nobj = ''", &["scene.toml:2:", "`obj` is empty"]);
    let folder = Folder::new(&[("gone.toml", "[[mesh]]\nobj = 'gone.obj'"), ("picture.png", "")]);
    assert!(folder.load("gone.toml").unwrap_err().starts_with("gone.toml:1: [[mesh]]: gone.obj: cannot read it: "));
    folder.write("later.toml", b"[[mesh]]\nobj = 'mesh.obj'\n\n[[mesh]]\nobj = 'gone.obj'\n");
    folder.write("mesh.obj", TRIANGLE.as_bytes());
    assert!(folder.load("later.toml").unwrap_err().starts_with("later.toml:4: [[mesh]]: gone.obj: cannot read it: "));
    assert!(folder.load("none.toml").unwrap_err().starts_with("none.toml: cannot read it"));
    assert!(folder.load("picture.png").unwrap_err().contains("octray reads .toml, .obj, .gltf and .glb files"));
    folder.write("latin1.toml", b"# one\n# caf\xe9\n");
    assert!(folder.load("latin1.toml").unwrap_err().contains("latin1.toml:2: not UTF-8"));
}

#[test]
fn paths_are_relative_to_the_file_that_names_them() {
    let toml = "[[mesh]]\nobj = 'parts/mesh.obj'\n[environment]\nradiance = [1, 1, 1]\n";
    let obj = format!("mtllib ../mtl/a.mtl\nusemtl m\n{TRIANGLE}");
    let files = [("scene.toml", toml), ("parts/mesh.obj", &obj), ("mtl/a.mtl", "newmtl m\nKd 0.25 0.5 1\n")];
    let scene = Folder::new(&files).load("scene.toml").unwrap();
    assert_eq!(scene.materials[0].scattering, Scattering::Diffuse { albedo: [0.25, 0.5, 1.0] });
}

#[test]
fn several_meshes_follow_each_other() {
    let scene = load_toml("[[mesh]]\nobj = 'mesh.obj'\ntranslate = [0, 0, 1]\n").unwrap();
    assert_eq!(scene.geometry().triangles.len(), 2);
    assert_eq!(scene.geometry().vertices(0)[1], [1.0, 0.0, 0.0]);
    assert_eq!(scene.geometry().vertices(1)[1], [1.0, 0.0, 1.0]);
}
