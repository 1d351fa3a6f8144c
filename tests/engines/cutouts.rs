//! Cut-outs: engines of equal bits, pictures that whole and absent surfaces must equal bit for bit, closed forms of what
//! gets through, bad files. Statistical bounds are 5 standard errors; seeds are fixed.

use crate::common;
use crate::common::{Maker, estimate, exact_strategies, first_difference, polygon_irradiance, small};
use glam::DVec3;
use octray::internal::bvh::{HitQueue, RayQueue, Scratch};
use octray::internal::packet::explain;
use octray::internal::packet::plan::Plan;
use octray::internal::reference::single::intersect::{Ray, intersect_where, stack};
use octray::internal::sampler::{random_words, unit};
use octray::internal::setup::Setup;
use octray::scene::SceneDesc;
use octray::scene::desc::{CornerDesc, EnvironmentDesc, MaskDesc, Scattering, TextureUse};
use octray::{Engine, Lights, PreparedScene, Settings, Strategy, render};
use std::cell::RefCell;
use std::path::Path;

fn mask(name: &str, width: u32, texels: &[u8]) -> MaskDesc {
    let height = texels.len() as u32 / width;
    MaskDesc { name: name.into(), width, height, texels: texels.to_vec() }
}

/// Cuts `material` out by mask number `mask`, `repeats` times over its coordinates.
fn cut(maker: &mut Maker, material: u32, mask: u32, repeats: f64) {
    let used = TextureUse { texture: mask, scale: [repeats; 2], offset: [0.0; 2] };
    maker.desc.materials[material as usize].alpha_mask = Some(used);
}

/// A quad with coordinates 0 to 1 along its first and its last side.
fn card(maker: &mut Maker, corners: [[f32; 3]; 4], material: u32) {
    maker.mesh.corners.resize(maker.mesh.triangles.len(), CornerDesc::default());
    maker.quad(corners, material);
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
        maker.mesh.corners.push(CornerDesc { uvs: [uvs[a], uvs[b], uvs[c]], ..CornerDesc::default() });
    }
}

const CHECKS: [u8; 4] = [255, 0, 0, 255];

/// Cards of every kind, some of them lamps, one upon the other and flat on a wall, in a room under a lamp and a sky.
fn room(extra: impl Fn(&mut Maker)) -> PreparedScene {
    let mut maker = Maker::default();
    maker.desc.masks = vec![
        mask("checks", 2, &CHECKS),
        mask("soft", 3, &[0, 90, 200, 128, 255, 127, 30, 250, 100]),
        mask("whole", 1, &[255]),
        mask("nothing", 1, &[0]),
    ];
    let wall = maker.diffuse([0.7, 0.6, 0.5], [0.0; 3]);
    let lamp = maker.diffuse([0.0; 3], [7.0, 6.0, 5.0]);
    let flat = |y: f32, s: f32| [[-s, y, s], [s, y, s], [s, y, -s], [-s, y, -s]];
    maker.quad(flat(0.0, 4.0), wall);
    maker.quad([[-4.0, 0.0, -2.0], [4.0, 0.0, -2.0], [4.0, 4.0, -2.0], [-4.0, 4.0, -2.0]], wall);
    maker.quad([[-1.0, 3.0, -1.0], [1.0, 3.0, -1.0], [1.0, 3.0, 1.0], [-1.0, 3.0, 1.0]], lamp);
    let kinds = [
        Scattering::Diffuse { albedo: [0.3, 0.8, 0.2] },
        Scattering::Mirror { reflectance: [0.9; 3] },
        Scattering::Conductor { alpha: 0.2, reflectance: [0.9, 0.7, 0.3], complex_ior: None },
        Scattering::Dielectric { ior: 1.5, transmittance: [0.9; 3] },
        Scattering::Plastic { albedo: [0.2, 0.3, 0.8], ior: 1.5, alpha: 0.2 },
        Scattering::Principled { base_color: [0.8, 0.7, 0.3], metallic: 0.5, roughness: 0.4, ior: 1.5 },
    ];
    for (i, kind) in kinds.into_iter().enumerate() {
        let material = maker.material(kind, [0.0; 3]);
        cut(&mut maker, material, i as u32 % 2, 1.5);
        let x = i as f32 - 2.5;
        let corners = [[x, 0.3, 0.5], [x + 1.2, 0.2, 0.0], [x + 1.1, 1.6, -0.4], [x - 0.1, 1.5, 0.3]];
        // Twice: the second has the same hits and higher ids.
        card(&mut maker, corners, material);
        card(&mut maker, corners, wall);
        maker.desc.materials[material as usize].two_sided = i == 0;
    }
    for (two_sided, x) in [(true, -1.5), (false, 1.0)] {
        let star = maker.diffuse([0.3; 3], [4.0, 2.0, 1.0]);
        maker.desc.materials[star as usize].two_sided = two_sided;
        cut(&mut maker, star, 1, 2.0);
        card(&mut maker, [[x, 2.0, 0.2], [x + 0.8, 2.0, 0.2], [x + 0.8, 2.6, 0.5], [x, 2.6, 0.5]], star);
    }
    let decal = maker.diffuse([0.1, 0.1, 0.7], [0.0; 3]);
    cut(&mut maker, decal, 0, 3.0);
    card(&mut maker, [[-4.0, 0.0, -2.0], [4.0, 0.0, -2.0], [4.0, 4.0, -2.0], [-4.0, 4.0, -2.0]], decal);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.2, 0.3, 0.4] }));
    extra(&mut maker);
    maker.mesh.corners.resize(maker.mesh.triangles.len(), CornerDesc::default());
    maker.seen([0.6, 1.7, 6.0], [0.0, 1.3, 0.0], 45.0)
}

#[test]
fn engines_agree_bit_for_bit_on_cut_outs() {
    let scene = room(|_| ());
    for &strategy in Strategy::ALL {
        for (lights, max_depth) in [(Lights::Uniform, None), (Lights::Power, Some(2))] {
            let settings = Settings { strategy, lights, max_depth, ..small(41, 33, 4) };
            let packet = render(&scene, &settings);
            let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings });
            let what = format!("{strategy}, {lights}, depth {max_depth:?}");
            assert_eq!(first_difference(&packet.film, &scalar.film), None, "{what}");
            assert_eq!(packet.stats.rays, scalar.stats.rays, "{what}");
            assert_eq!(packet.stats.nonfinite, 0, "{what}");
        }
    }
}

#[test]
fn exact_strategies_agree_on_cut_outs() {
    let scene = room(|_| ());
    let mean = |strategy, lights, spp| {
        let film = render(&scene, &Settings { strategy, lights, max_depth: Some(3), ..small(24, 24, spp) }).film;
        estimate(&film, 0..24, 0..24, 0)
    };
    let truth = mean(Strategy::MisPower, Lights::Uniform, 1024);
    for strategy in exact_strategies() {
        for &lights in Lights::ALL {
            let got = mean(strategy, lights, 256);
            let error = got.error.hypot(truth.error);
            assert!((got.mean - truth.mean).abs() < 5.0 * error, "{strategy}: {} {}", got.mean, truth.mean);
            assert!(error < 0.02 * truth.mean, "{strategy}: too noisy to prove anything");
        }
    }
}

/// A whole mask is as good as none; what is cut away altogether is not there, even flat on a wall whose hits it shares, and
/// in front of a lamp.
#[test]
fn whole_and_empty_masks_leave_no_trace() {
    let cards = |maker: &mut Maker, masked: Option<u32>| {
        let paint = maker.material(Scattering::Plastic { albedo: [0.5; 3], ior: 1.5, alpha: 0.4 }, [0.0; 3]);
        if let Some(mask) = masked {
            cut(maker, paint, mask, 1.0);
        }
        card(maker, [[-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0], [-4.0, 0.0, -4.0]], paint);
        card(maker, [[-1.0, 2.9, -1.0], [1.0, 2.9, -1.0], [1.0, 2.9, 0.3], [-1.0, 2.9, 0.3]], paint);
        card(maker, [[-0.5, 0.2, 1.0], [0.5, 0.2, 1.0], [0.5, 1.4, 1.2], [-0.5, 1.4, 1.2]], paint);
    };
    let (bare, plain) = (room(|_| ()), room(|maker| cards(maker, None)));
    let (whole, empty) = (room(|maker| cards(maker, Some(2))), room(|maker| cards(maker, Some(3))));
    for strategy in [Strategy::MisPower, Strategy::Bsdf, Strategy::Nee] {
        let settings = Settings { strategy, ..small(48, 40, 8) };
        let film = |scene: &PreparedScene| render(scene, &settings).film;
        assert_eq!(first_difference(&film(&whole), &film(&plain)), None, "{strategy}: a whole mask");
        assert_eq!(first_difference(&film(&empty), &film(&bare)), None, "{strategy}: an empty mask");
        assert!(first_difference(&film(&bare), &film(&plain)).is_some(), "the cards are in view");
    }
}

/// `intersect_behind` meets every hit of a ray once, in the order of distance and, at equal distance, of ids: against the
/// list of all hits of the scalar walk.
#[test]
fn rays_meet_all_their_hits_one_after_the_other() {
    let mut maker = Maker::default();
    let grey = maker.diffuse([0.5; 3], [0.0; 3]);
    for i in 0..80u32 {
        let point = |k: u32| random_words(i, k, 3, 5).map(|w| 4.0 * unit(w) - 2.0);
        let corners = [0, 1, 2, 3].map(point).map(|[x, y, z, _]| [x, y, z]);
        maker.quad(corners, grey);
    }
    let scene = maker.seen([0.0, 0.0, 9.0], [0.0; 3], 30.0);
    let (mut met, mut tied, mut scratch, mut walk) = (0, 0, Scratch::default(), stack(&scene.bvh));
    for i in 0..2000u32 {
        let [a, b, c, d] = random_words(i, 0, 7, 5).map(|w| 2.0 * unit(w) - 1.0);
        // Every fourth along an axis and through a vertex, where neighbours tie as well.
        let corner = glam::Vec3::from(scene.triangles[i as usize % scene.triangles.len()].vertices[0]);
        let (origin, direction) = match i % 4 {
            0 => (corner - glam::Vec3::Z * 5.0, glam::Vec3::Z),
            _ => (glam::Vec3::new(5.0 * a, 5.0 * b, 5.0), glam::Vec3::new(c - 2.0 * a, d - 2.0 * b, -5.0)),
        };
        let ray = Ray { origin, direction, tmin: 0.0, tmax: f32::INFINITY };
        let all = RefCell::new(Vec::new());
        let none = intersect_where(&scene.bvh, &ray, &mut walk, |hit| {
            all.borrow_mut().push((hit.t, hit.triangle, hit.u, hit.v));
            false
        });
        assert_eq!(none, None);
        let mut wanted = all.into_inner();
        wanted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        tied += wanted.windows(2).filter(|pair| pair[0].0 == pair[1].0).count();

        let (mut rays, mut hits) = (RayQueue::with_len(1), HitQueue::with_len(1));
        (rays.ox[0], rays.oy[0], rays.oz[0]) = origin.into();
        (rays.dx[0], rays.dy[0], rays.dz[0]) = direction.into();
        scene.bvh.intersect_stream(&rays, 1, &mut hits);
        let mut got = Vec::new();
        while hits.triangle[0] != octray::internal::bvh::ray::NO_HIT {
            got.push((hits.t[0], hits.triangle[0], hits.u[0], hits.v[0]));
            scene.bvh.intersect_behind(&rays, &[0], &mut hits, &mut scratch);
        }
        assert_eq!(got, wanted, "ray {i}");
        met += got.len();
    }
    assert!(met > 10_000 && tied > 400, "{met} hits, {tied} of them tied");
}

/// Eight stripes of equal width along x, the first opaque, the second not, and so on, between the corners of a square of
/// half side 1 at y = 1.
const STRIPES: u32 = 8;

fn opaque_stripes(at: DVec3) -> f64 {
    let edge = |i: u32| -1.0 + 2.0 * f64::from(i) / f64::from(STRIPES);
    let stripe = |i: u32| {
        let (a, b) = (edge(i), edge(i + 1));
        [DVec3::new(a, 1.0, -1.0), DVec3::new(b, 1.0, -1.0), DVec3::new(b, 1.0, 1.0), DVec3::new(a, 1.0, 1.0)]
    };
    (0..STRIPES).step_by(2).map(|i| polygon_irradiance(at, DVec3::Y, &stripe(i))).sum()
}

/// A grey floor at y = 0, seen at one point of it, under a square card of stripes at y = 1 that faces down.
fn under_stripes(at: [f64; 3], emission: [f64; 3], sky: Option<[f64; 3]>) -> PreparedScene {
    let mut maker = Maker::default();
    maker.desc.masks = vec![mask("stripes", 2, &[255, 0])];
    let floor = maker.diffuse([0.5; 3], [0.0; 3]);
    let striped = maker.diffuse([0.0; 3], emission);
    cut(&mut maker, striped, 0, f64::from(STRIPES / 2));
    maker.quad([[-2e3, 0.0, 2e3], [2e3, 0.0, 2e3], [2e3, 0.0, -2e3], [-2e3, 0.0, -2e3]], floor);
    card(&mut maker, [[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]], striped);
    maker.desc.set_environment(sky.map(|radiance| EnvironmentDesc::Constant { radiance }));
    maker.seen([at[0] + 6.0, 0.5, at[2] + 1.0], at, 1e-3)
}

/// Lambert's formula, stripe by stripe: of a sky behind black stripes the gaps' light arrives, of stripes that emit their
/// own; of a lamp right behind black stripes what its part behind the gaps sends.
#[test]
fn the_light_of_stripes_is_lamberts() {
    for at in [[0.0; 3], [0.3, 0.0, 0.2], [1.4, 0.0, -0.7]] {
        let opaque = opaque_stripes(DVec3::from(at));
        let pi = std::f64::consts::PI;
        let cases = [
            ("a sky behind stripes", under_stripes(at, [0.0; 3], Some([1.0; 3])), pi - opaque),
            ("stripes that emit", under_stripes(at, [1.0; 3], None), opaque),
            ("both", under_stripes(at, [2.0; 3], Some([1.0; 3])), pi + opaque),
        ];
        for (name, scene, irradiance) in &cases {
            let truth = 0.5 / pi * irradiance;
            for strategy in exact_strategies() {
                for &lights in Lights::ALL {
                    let settings = Settings { strategy, lights, max_depth: Some(1), ..small(16, 16, 1024) };
                    let got = estimate(&render(scene, &settings).film, 0..16, 0..16, 1);
                    let bound = 5.0 * got.error + 1e-5 * truth;
                    let what = format!("{name} at {at:?}, {strategy}, {lights}: {} +- {}", got.mean, got.error);
                    assert!((got.mean - truth).abs() < bound, "{what}, truth {truth}");
                    assert!(bound < 0.06 * truth, "{what} is too noisy to prove anything");
                }
            }
        }
    }
}

/// The part of a lamp that a camera sees through a card is the part that the mask leaves open. About a single opaque texel of
/// four the bilinear mask is (1 - |x|) (1 - |y|): it is one half or more over 2 - 2 ln 2 texels.
#[test]
fn a_card_lets_its_open_part_through() {
    let mut maker = Maker::default();
    maker.desc.masks = vec![mask("a quarter is whole", 2, &[0, 255, 0, 0])];
    let lamp = maker.diffuse([0.0; 3], [1.0; 3]);
    let black = maker.diffuse([0.0; 3], [0.0; 3]);
    cut(&mut maker, black, 0, 16.0);
    maker.quad([[-9.0, -9.0, -1.0], [9.0, -9.0, -1.0], [9.0, 9.0, -1.0], [-9.0, 9.0, -1.0]], lamp);
    card(&mut maker, [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]], black);
    // The film is the card: half of its height is 1 at the distance 1.
    let scene = maker.seen([0.0, 0.0, 1.0], [0.0; 3], 90.0);
    let film = render(&scene, &small(64, 64, 64)).film;
    let got = estimate(&film, 0..64, 0..64, 0);
    let open = 1.0 - (1.0 - std::f64::consts::LN_2) / 2.0;
    assert!((got.mean - open).abs() < 5.0 * got.error + 1e-6, "{} +- {}, truth {open}", got.mean, got.error);
    assert!(got.error < 1e-3);
}

#[test]
fn plans_name_cut_outs_where_there_are_some() {
    let left_out = |scene: &PreparedScene| {
        let setup = Setup::new(scene, &Settings::default());
        let plan = Plan::new(&setup);
        let past = explain::stages(&setup, &plan)
            .iter()
            .filter(|s| s.variant.contains("past cut-outs"))
            .map(|s| s.stage)
            .collect();
        let tables = scene.tables().iter().any(|table| table.0 == "cut-outs");
        (explain::left_out(&setup).iter().any(|left| left.what == "cut-outs"), past, tables)
    };
    assert_eq!(left_out(&common::prepared("scenes/cornell.toml")), (true, Vec::<&str>::new(), false));
    let both = vec!["intersect_closest", "intersect_shadow"];
    assert_eq!(left_out(&common::prepared("scenes/leaves.toml")), (false, both, true));
}

const OBJ: &str = "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
const TOML: &str = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n[[mesh]]\nobj = \"m.obj\"\n";

/// Loads an OBJ with this MTL, or a TOML over it with `more` below.
fn load(mtl: &str, more: Option<&str>) -> Result<SceneDesc, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let write = |name: &str, text: &[u8]| std::fs::write(path(name), text).expect("a file");
    write("m.obj", OBJ.as_bytes());
    write("m.mtl", mtl.as_bytes());
    write("bad.png", b"no picture");
    let (rgba, luma) = (|x, _| image::Rgba([200, 10, 20, 7 + x as u8]), |_, y| image::Luma([40 + y as u8]));
    image::RgbaImage::from_fn(2, 1, rgba).save(path("alpha.png")).expect("a picture");
    image::GrayImage::from_fn(1, 2, luma).save(path("grey mask.png")).expect("a picture");
    write("m.toml", format!("{TOML}{}", more.unwrap_or_default()).as_bytes());
    SceneDesc::load(path(if more.is_some() { "m.toml" } else { "m.obj" })).map_err(|e| {
        assert_eq!(e.exit_status(), 2);
        e.to_string()
    })
}

#[test]
fn mtl_and_toml_name_masks() {
    let at = |scale, offset| Some(TextureUse { texture: 0, scale, offset });
    let scene = load("newmtl m\nKd 0.5 0.5 0.25\nmap_d -s 2 3 -o 0.5 grey mask.png\n", None).unwrap();
    assert_eq!(scene.materials[0].alpha_mask, at([2.0, 3.0], [0.5, 0.0]));
    assert_eq!((scene.masks.len(), &scene.masks[0].texels[..]), (1, &[40, 41][..]), "grey, from the top, not sRGB");
    assert_eq!(scene.textures.len(), 0, "a mask is no texture");
    let scene = load("newmtl m\nmap_d alpha.png\nmap_Kd alpha.png\n", None).unwrap();
    assert_eq!((&scene.masks[0].texels[..], scene.textures.len()), (&[7, 8][..], 1), "alpha, where there is one");
    for mtl in ["newmtl m\nKd 1 1 1\nmap_d gone.png\n", "newmtl m\nKd 1 1 1\nmap_d bad.png\n"] {
        let scene = load(mtl, None).unwrap();
        assert_eq!(scene.materials[0].alpha_mask, None);
        let warned = scene.warnings.iter().any(|w| w.contains("cannot read the cut-out of material `m`"));
        assert!(warned, "{:?}", scene.warnings);
    }
    let plain = "newmtl m\nKd 0.5 0.5 0.5\n";
    for kind in ["diffuse", "mirror", "conductor", "dielectric", "plastic", "principled"] {
        let more = format!("[material.m]\nkind = '{kind}'\ncutout = 'alpha.png'\n");
        assert_eq!(load(plain, Some(&more)).unwrap().materials[0].alpha_mask, at([1.0; 2], [0.0; 2]), "{kind}");
    }
    let scene = load("newmtl m\nmap_d alpha.png\n", Some("[material.m]\ncutout = 'grey mask.png'\n")).unwrap();
    assert_eq!(scene.masks.len(), 1, "the entry's mask replaces the MTL's");
    for (more, words) in
        [("gone.png", ["m.toml:7:", "cutout `gone.png`"]), ("bad.png", ["m.toml:7:", "cutout `bad.png`"])]
    {
        let message = load(plain, Some(&format!("[material.m]\ncutout = '{more}'\n"))).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

/// The mask of `scenes/leaves.toml`: a leaf as wide as 3.1 y (1 - y)^2 at height y, on a stem.
fn leaf() -> image::GrayImage {
    image::GrayImage::from_fn(64, 128, |column, row| {
        let x = (f64::from(column) + 0.5) / 64.0 - 0.5;
        let y = 1.0 - (f64::from(row) + 0.5) / 128.0;
        let blade = if y > 0.08 { 3.1 * y * (1.0 - y) * (1.0 - y) } else { 0.0 };
        let stem: f64 = if y < 0.2 { 0.02 } else { 0.0 };
        image::Luma([(127.5 + (blade.max(stem) - x.abs()) * 64.0 * 40.0).clamp(0.0, 255.0) as u8])
    })
}

fn leaf_file() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/leaf.png")
}

#[test]
fn the_leaf_is_what_its_function_makes() {
    assert_eq!(image::open(leaf_file()).expect("scenes/leaf.png").to_luma8(), leaf());
}

#[test]
#[ignore = "writes a file of the repository: cargo test --test engines make_the_leaf -- --ignored"]
fn make_the_leaf() {
    leaf().save(leaf_file()).expect("scenes/leaf.png");
}
