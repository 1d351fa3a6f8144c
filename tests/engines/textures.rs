//! Textures: exact colours in the right places, engines of equal bits, strategies of equal means, bad files.
//! Statistical bounds are 5 standard errors; seeds are fixed.

use crate::common::{Maker, estimate, exact_strategies, first_difference, small};
use octray::internal::color::linear_from_srgb;
use octray::scene::SceneDesc;
use octray::scene::desc::{CornerDesc, EnvironmentDesc, Scattering, TextureDesc, TextureUse};
use octray::{Engine, Lights, PreparedScene, Settings, Strategy, render};

/// Four texels a side, no two alike; the top row first.
fn picture() -> TextureDesc {
    let texel = |i: u32| [(16 * i + 8) as u8, (250 - 15 * i) as u8, (i * i) as u8];
    TextureDesc { name: "picture".into(), width: 4, height: 4, texels: (0..16).map(texel).collect() }
}

fn linear(texel: [u8; 3]) -> [f64; 3] {
    texel.map(|c| linear_from_srgb(c as f64 / 255.0))
}

/// A unit square in the plane z = 0 with coordinates from 0 to `repeats`, lit by white from everywhere.
pub fn poster(repeats: f32, scattering: Scattering, emits: bool) -> Maker {
    let mut maker = Maker::default();
    let used = Some(TextureUse { texture: 0, scale: [1.0; 2], offset: [0.0; 2] });
    let paper = maker.material(scattering, if emits { [1.0; 3] } else { [0.0; 3] });
    let material = &mut maker.desc.materials[paper as usize];
    if emits {
        material.emission_texture = used
    } else {
        material.texture = used
    }
    maker.desc.textures = vec![picture()];
    maker.quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], paper);
    let uv = |v: u32| {
        let [x, y, _] = maker.mesh.positions[v as usize];
        [x * repeats, y * repeats]
    };
    maker.mesh.corners = (maker.mesh.triangles.iter())
        .map(|t| CornerDesc { uvs: t.vertices.map(uv), ..CornerDesc::default() })
        .collect();
    maker
}

/// What a pixel-sized look straight at (x, y) of the square finds.
fn look_at(scene: impl Fn() -> Maker, x: f64, y: f64) -> [f64; 3] {
    let mut maker = scene();
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    let scene = maker.seen([x, y, 2.0], [x, y, 0.0], 1e-4);
    render(&scene, &Settings { strategy: Strategy::Nee, max_depth: Some(1), ..small(1, 1, 4) }).film.mean_radiance()
}

fn close(a: [f64; 3], b: [f64; 3], what: &str) {
    let apart = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
    assert!(apart < 2e-5, "{what}: {a:?}, not {b:?}");
}

#[test]
fn texels_have_their_colours_and_places() {
    let white = Scattering::Diffuse { albedo: [1.0; 3] };
    let texel = |column: usize, row: usize| linear(picture().texels[4 * row + column]);
    for (repeats, x0, y0) in [(1.0, 0.0, 0.0), (3.0, 1.0, 2.0)] {
        let look =
            |u: f64, v: f64| look_at(|| poster(repeats as f32, white, false), (x0 + u) / repeats, (y0 + v) / repeats);
        for row in 0..4 {
            for column in 0..4 {
                // v = 0 is the bottom of the picture.
                let (u, v) = ((column as f64 + 0.5) / 4.0, 1.0 - (row as f64 + 0.5) / 4.0);
                close(look(u, v), texel(column, row), &format!("texel {column},{row}, {repeats} times"));
            }
        }
        let mean = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| 0.5 * (a[c] + b[c]));
        close(look(0.25, 0.875), mean(texel(0, 0), texel(1, 0)), "half-way along a row");
        close(look(0.125, 0.5), mean(texel(0, 1), texel(0, 2)), "half-way along a column");
    }
    // Over the seam of the second repeat the last column meets the first.
    let seam = look_at(|| poster(3.0, white, false), 1.0 / 3.0, 0.875 / 3.0);
    close(seam, std::array::from_fn(|c| 0.5 * (texel(3, 0)[c] + texel(0, 0)[c])), "the seam");
    let emitted = look_at(|| poster(1.0, Scattering::Diffuse { albedo: [0.0; 3] }, true), 0.375, 0.625);
    close(emitted, texel(1, 1), "emission");
    let scaled = || {
        let mut maker = poster(1.0, white, false);
        let used = TextureUse { texture: 0, scale: [2.0, 1.0], offset: [0.25, 0.5] };
        maker.desc.materials[0].texture = Some(used);
        maker
    };
    close(look_at(scaled, 0.0625, 0.375), texel(1, 0), "scaled and shifted");
}

/// What posters in rooms are made of.
pub const PAPERS: [Scattering; 2] = [
    Scattering::Plastic { albedo: [0.9; 3], ior: 1.5, alpha: 0.3 },
    Scattering::Principled { base_color: [0.9; 3], metallic: 0.6, roughness: 0.5, ior: 1.5 },
];

/// A textured lamp over a textured floor, a glossy poster beside it.
pub fn room(paper: Scattering) -> PreparedScene {
    let mut maker = poster(2.0, paper, false);
    let used = |texture| Some(TextureUse { texture, scale: [1.5, -0.7], offset: [0.1, 0.2] });
    maker.desc.textures.push(TextureDesc {
        name: "lamp".into(),
        width: 2,
        height: 1,
        texels: vec![[255, 255, 255], [10, 0, 120]],
    });
    let floor = maker.diffuse([0.8, 0.9, 1.0], [0.0; 3]);
    let lamp = maker.diffuse([0.2; 3], [8.0, 6.0, 4.0]);
    let bulb = maker.diffuse([0.2; 3], [3.0; 3]);
    maker.desc.materials[floor as usize].texture = used(0);
    maker.desc.materials[lamp as usize].emission_texture = used(1);
    maker.quad([[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]], floor);
    maker.quad([[-1.0, 1.5, -1.0], [1.0, 1.5, -1.0], [1.0, 1.5, 1.0], [-1.0, 1.5, 1.0]], lamp);
    maker.quad([[2.0, 1.0, -1.0], [2.2, 1.0, -1.0], [2.2, 1.0, -0.8], [2.0, 1.0, -0.8]], bulb);
    let uv = |v: u32| {
        let [x, _, z] = maker.mesh.positions[v as usize];
        [0.5 * x + 0.5, 0.5 * z + 0.5]
    };
    let more: Vec<CornerDesc> = (maker.mesh.triangles[2..].iter())
        .map(|t| CornerDesc { uvs: t.vertices.map(uv), ..CornerDesc::default() })
        .collect();
    maker.mesh.corners.extend(more);
    maker.seen([1.5, 1.2, 3.5], [0.3, 0.6, 0.0], 50.0)
}

#[test]
fn engines_agree_bit_for_bit_on_textures() {
    for paper in PAPERS {
        let scene = room(paper);
        for &strategy in Strategy::ALL {
            for (lights, max_depth) in [(Lights::Uniform, None), (Lights::Power, Some(2))] {
                let settings = Settings { strategy, lights, max_depth, ..small(33, 27, 4) };
                let packet = render(&scene, &settings);
                let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings });
                let what = format!("{paper:?}, {strategy}, {lights}, depth {max_depth:?}");
                assert_eq!(first_difference(&packet.film, &scalar.film), None, "{what}");
                assert_eq!(packet.stats.nonfinite, 0, "{what}");
            }
        }
    }
}

#[test]
fn exact_strategies_agree_on_textured_lights() {
    for paper in PAPERS {
        let scene = room(paper);
        let mean = |strategy, lights| {
            let film = render(&scene, &Settings { strategy, lights, max_depth: Some(2), ..small(24, 24, 512) }).film;
            estimate(&film, 0..24, 0..24, 0)
        };
        let truth = mean(Strategy::MisPower, Lights::Uniform);
        for strategy in exact_strategies() {
            for lights in [Lights::Uniform, Lights::Power] {
                let got = mean(strategy, lights);
                let error = (got.error * got.error + truth.error * truth.error).sqrt();
                assert!((got.mean - truth.mean).abs() < 5.0 * error, "{strategy}: {} {}", got.mean, truth.mean);
                assert!(error < 0.02 * truth.mean, "{strategy}: too noisy to prove anything");
            }
        }
    }
}

const OBJ: &str = "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
const TOML: &str = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n[[mesh]]\nobj = \"m.obj\"\n";

/// Loads an OBJ with this MTL, or a TOML over it with `more` below.
fn load(mtl: &str, more: Option<&str>) -> Result<SceneDesc, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).expect("a file");
    write("m.obj", OBJ.as_bytes());
    write("m.mtl", mtl.as_bytes());
    write("bad.png", b"no picture");
    let pixels = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([x as u8 * 200, 10, 20]));
    pixels.save(folder.path().join("a b.png")).expect("a picture");
    write("m.toml", format!("{TOML}{}", more.unwrap_or_default()).as_bytes());
    let file = if more.is_some() { "m.toml" } else { "m.obj" };
    SceneDesc::load(folder.path().join(file)).map_err(|e| {
        assert_eq!(e.exit_status(), 2);
        e.to_string()
    })
}

#[test]
fn mtl_and_toml_name_textures() {
    let warned = |scene: &SceneDesc, word: &str| scene.warnings.iter().any(|w| w.contains(word));
    let albedo = |scene: &SceneDesc| match scene.materials[0].scattering {
        Scattering::Diffuse { albedo } => albedo,
        Scattering::Principled { base_color, .. } => base_color,
        other => panic!("{other:?}"),
    };
    let scene = load("newmtl m\nKd 0.5 0.5 0.25\nmap_Kd -s 2 3 -o 0.5 a b.png\n", None).unwrap();
    let wanted = TextureUse { texture: 0, scale: [2.0, 3.0], offset: [0.5, 0.0] };
    assert_eq!(scene.materials[0].texture, Some(wanted));
    assert_eq!(albedo(&scene), [0.5, 0.5, 0.25], "Kd multiplies");
    assert_eq!((scene.textures.len(), &scene.textures[0].texels[..]), (1, &[[0, 10, 20], [200, 10, 20]][..]));
    assert_eq!(scene.meshes[0].corners[0].uvs, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let scene = load("newmtl m\nKd 0 0 0\nmap_Kd -bm 1 a b.png\nmap_Ke a b.png", None).unwrap();
    assert_eq!((albedo(&scene), scene.materials[0].emission), ([1.0; 3], [1.0; 3]), "black: the picture alone");
    assert!(scene.materials[0].emission_texture.is_some() && warned(&scene, "-bm have no effect"));
    for (mtl, wanted) in [("Kd 0.25 0.5 1\nmap_Kd gone.png", [0.25, 0.5, 1.0]), ("map_Kd bad.png", [0.5; 3])] {
        let scene = load(&format!("newmtl m\n{mtl}\n"), None).unwrap();
        assert_eq!((albedo(&scene), scene.materials[0].texture), (wanted, None), "{mtl}");
        assert!(warned(&scene, "cannot read the texture of material `m`"), "{:?}", scene.warnings);
    }
    let plain = "newmtl m\nKd 0.5 0.5 0.5\n";
    let scene = load(plain, Some("[material.m]\ntexture = 'a b.png'\n")).unwrap();
    assert!(scene.materials[0].texture.is_some() && albedo(&scene) == [1.0; 3]);
    let scene = load("newmtl m\nmap_Kd a b.png", Some("[material.m]\nalbedo = [0.1, 0.2, 0.3]\n")).unwrap();
    assert_eq!((scene.materials[0].texture, albedo(&scene)), (None, [0.1, 0.2, 0.3]), "a named albedo replaces it");
    for (more, wanted) in [("", [1.0; 3]), ("base_color = [0.5, 0.25, 1]\n", [0.5, 0.25, 1.0])] {
        let more = format!("[material.m]\nkind = 'principled'\n{more}texture = 'a b.png'\n");
        let scene = load(plain, Some(&more)).unwrap();
        assert!(scene.materials[0].texture.is_some() && albedo(&scene) == wanted, "a named base_color multiplies");
    }
    for (more, words) in [
        ("texture = 'gone.png'", ["m.toml:7:", "texture `gone.png`"]),
        ("texture = 'bad.png'", ["m.toml:7:", "texture `bad.png`"]),
        ("kind = 'mirror'\ntexture = 'a b.png'", ["m.toml:8:", "only diffuse, plastic and principled"]),
    ] {
        let message = load(plain, Some(&format!("[material.m]\n{more}\n"))).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}
