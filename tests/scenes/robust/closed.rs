//! Closed meshes: what is inside stays inside.

use super::shapes::{Mesh, add, cube, prism, render_sanely, skew, sphere, wedge};
use crate::common::{Maker, small};
use glam::DVec3;
use octray::internal::reference::{double, single};
use octray::internal::sampler::{random_words, unit};
use octray::scene::desc::EnvironmentDesc;
use octray::{PreparedScene, Settings, Strategy, render};

/// `mesh` around a camera, `shift` of its sizes from the origin, perfectly white, in surroundings of radiance 1: every
/// bit of light is a path that has left.
fn leaking(mesh: &Mesh, shift: f64) -> PreparedScene {
    let mut maker = Maker::default();
    let white = maker.diffuse([1.0; 3], [0.0; 3]);
    let away = DVec3::new(0.62, -0.57, 0.54).normalize() * 2.0 * shift;
    add(&mut maker, mesh, white, |p| skew() * p + away);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    let inside = skew() * (mesh.0.iter().sum::<DVec3>() / mesh.0.len() as f64) + away;
    let ahead = inside + DVec3::new(0.3, 0.2, -1.0) * (1.0 + 1e-3 * inside.length());
    maker.seen(inside.to_array(), ahead.to_array(), 90.0)
}

/// Paths that left, of how many rays.
fn leaks(mesh: &Mesh, shift: f64, spp: u32) -> (f64, u64) {
    let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(200), rr_depth: None, ..small(32, 32, spp) };
    let render = render(&leaking(mesh, shift), &settings);
    assert_eq!(render.stats.nonfinite, 0);
    (render.film.mean_radiance()[0] * render.stats.paths as f64, render.stats.rays.bounce)
}

#[test]
fn nothing_leaves_a_closed_mesh_up_to_a_thousand_sizes_from_the_origin() {
    for (name, mesh) in [("cube", cube()), ("sphere", sphere(3)), ("wedge of 45 degrees", wedge(45.0))] {
        for shift in [0.0, 1.0, 10.0, 100.0, 1000.0] {
            let (left, rays) = leaks(&mesh, shift, 5);
            assert_eq!(left, 0.0, "{name} at {shift}, of {rays} rays");
            assert!(rays > 1_000_000, "{name} at {shift}: {rays} rays prove little");
        }
    }
}

/// A box of twelve triangles, `size` along the axes, turned if `skewed`, seen from inside towards a corner; white, in
/// surroundings of radiance 1.
fn corridor(size: [f64; 3], skewed: bool) -> PreparedScene {
    let mut maker = Maker::default();
    let white = maker.diffuse([1.0; 3], [0.0; 3]);
    let turn = if skewed { skew() } else { glam::DMat3::IDENTITY };
    let scale = DVec3::from(size) * 0.5;
    add(&mut maker, &cube(), white, |p| turn * (p * scale));
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    let eye = turn * (scale * DVec3::new(0.31, 0.07, 0.53));
    let ahead = eye + turn * DVec3::new(0.3, 0.2, -1.0) * scale.min_element();
    maker.seen(eye.to_array(), ahead.to_array(), 90.0)
}

/// Leaks of both engines, which must agree to the last bit.
fn corridor_leaks(scene: &PreparedScene, spp: u32, what: &str) -> (f64, u64) {
    let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(200), rr_depth: None, ..small(16, 16, spp) };
    let film = render_sanely(scene, &Settings { spp: 1, ..settings.clone() }, what);
    assert_eq!(film.mean_radiance(), [0.0; 3], "{what}, one sample");
    let render = render(scene, &settings);
    (render.film.mean_radiance()[0] * render.stats.paths as f64, render.stats.rays.bounce)
}

/// Barycentric `t` is as wrong as the triangle is long and thin: of a corridor of 1 x 1 x 1000 every 8,000th ray left, of one
/// of 1 x 1 x 10,000 every 30th, and the engines saw different corridors.
#[test]
fn nothing_leaves_a_corridor_however_long_nor_a_box_however_thin() {
    for length in [1e1, 1e2, 1e3, 1e4, 1e5, 1e6] {
        for across in 0..3 {
            let mut size = [1.0; 3];
            size[across] = length;
            let what = format!("corridor {size:?}");
            let (left, rays) = corridor_leaks(&corridor(size, false), 6, &what);
            assert_eq!(left, 0.0, "{what}, of {rays} rays");
            assert!(rays > 250_000, "{what}: {rays} rays prove little");
        }
    }
    for length in [1e1, 1e2, 1e3, 1e4] {
        let what = format!("skewed corridor of length {length}");
        let (left, rays) = corridor_leaks(&corridor([1.0, 1.0, length], true), 12, &what);
        assert_eq!(left, 0.0, "{what}, of {rays} rays");
    }
    for height in [1e-3, 1e-5, 1e-7] {
        let what = format!("box of height {height}");
        let (left, rays) = corridor_leaks(&corridor([1.0, height, 1.0], false), 6, &what);
        assert_eq!(left, 0.0, "{what}, of {rays} rays");
    }
}

/// Before slivers had offsets of their own, every twentieth ray left the first of these; of the last, every seventh did.
#[test]
fn nothing_leaves_prisms_of_slivers() {
    for (sides, radius, shift) in [(16, 0.01, 0.0), (16, 0.01, 10.0), (100, 0.02, 0.0), (1000, 0.02, 0.0)] {
        let (left, rays) = leaks(&prism(sides, radius), shift, 5);
        assert_eq!(left, 0.0, "{sides} sides, radius {radius}, at {shift}, of {rays} rays");
    }
}

#[test]
fn a_curved_furnace_has_the_radiance_of_its_series() {
    for (name, mesh) in [("sphere", sphere(3)), ("prism", prism(12, 0.2)), ("wedge", wedge(60.0))] {
        let mut maker = Maker::default();
        let wall = maker.diffuse([0.5; 3], [0.5; 3]);
        add(&mut maker, &mesh, wall, |p| skew() * p);
        maker.mesh.triangles.iter_mut().for_each(|t| t.flipped = true);
        let inside = skew() * (mesh.0.iter().sum::<DVec3>() / mesh.0.len() as f64);
        let scene = maker.seen(inside.to_array(), (inside + DVec3::new(0.2, 0.3, -1.0)).to_array(), 90.0);
        // Without light samples every path of n events finds exactly 0.5 (1 + 1/2 + .. + 2^-n), whatever it meets.
        let settings = Settings { strategy: Strategy::Bsdf, rr_depth: None, max_depth: Some(30), ..small(16, 16, 16) };
        let film = render_sanely(&scene, &settings, name);
        assert!(film.pixels.iter().all(|p| p.sum.iter().all(|&sum| (sum / 16.0 - 1.0).abs() < 1e-6)), "{name}");
    }
}

/// Rays that leave a triangle do not hit it again: of both number types, at every scale and place, most of them from
/// next to edges and corners and half of them grazing.
#[test]
fn no_ray_hits_again_the_triangle_it_leaves() {
    let places = [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1.0), (1.0, 10.0), (1.0, 100.0), (1.0, 1000.0)];
    for (name, mesh) in [("cube", cube()), ("sphere", sphere(4)), ("prism", prism(64, 0.5)), ("wedge", wedge(30.0))] {
        for (scale, shift) in places {
            let mut maker = Maker::default();
            let grey = maker.diffuse([0.5; 3], [0.0; 3]);
            let away = DVec3::new(0.62, -0.57, 0.54).normalize() * 2.0 * shift;
            add(&mut maker, &mesh, grey, |p| (skew() * p + away) * scale);
            let scene = maker.seen([0.0, 0.0, 1.0], [0.0; 3], 30.0);
            let (mut stack32, mut stack64) =
                (single::intersect::stack(&scene.bvh), double::intersect::stack(&scene.bvh));
            for i in 0..4000 {
                let Some(Leaving { triangle, u, v, direction }) = leaving(&scene, i) else { continue };
                let record = &scene.triangles[triangle as usize];
                let at = single::surface::surface_point(record, None, u, v, -direction.as_vec3());
                let ray = single::intersect::Ray {
                    origin: at.origin,
                    direction: direction.as_vec3(),
                    tmin: 0.0,
                    tmax: f32::INFINITY,
                };
                let hit = single::intersect::intersect(&scene.bvh, &ray, &mut stack32);
                assert!(hit.is_none_or(|hit| hit.triangle != triangle), "{name} x {scale} at {shift}, f32, ray {i}");
                let at = double::surface::surface_point(record, None, u as f64, v as f64, -direction);
                let ray = double::intersect::Ray { origin: at.origin, direction, tmin: 0.0, tmax: f64::INFINITY };
                let hit = double::intersect::intersect(&scene.bvh, &ray, &mut stack64);
                assert!(hit.is_none_or(|hit| hit.triangle != triangle), "{name} x {scale} at {shift}, f64, ray {i}");
            }
        }
    }
}

/// A ray that leaves a point of a triangle.
struct Leaving {
    triangle: u32,
    u: f32,
    v: f32,
    direction: DVec3,
}

fn leaving(scene: &PreparedScene, i: u32) -> Option<Leaving> {
    let number = |block: u32| random_words(i, 0, block, 1).map(|word| unit(word) as f64);
    let ([which, near, side, mode], mut weights) = (number(0), number(1));
    // A quarter anywhere, a quarter next to an edge, half next to a corner; as near as 1e-8.
    let corner = ((side * 3.0) as usize).min(2);
    let factor = 10f64.powf(-8.0 * near);
    for (k, weight) in weights.iter_mut().take(3).enumerate() {
        if mode >= 0.5 && k != corner || mode < 0.25 && k == corner {
            *weight *= factor;
        }
    }
    let sum: f64 = weights[..3].iter().sum();
    let (u, v) = ((weights[1] / sum) as f32, (weights[2] / sum) as f32);
    let triangle = (which * scene.triangles.len() as f64) as u32;
    let normal = DVec3::from(scene.triangles[triangle as usize].normal.map(f64::from));
    let [turn, height, grazing, inside] = number(2);
    let normal = if inside < 0.5 { -normal } else { normal };
    let cosine = if grazing < 0.5 { 10f64.powf(-4.0 * height) } else { height.sqrt().max(1e-4) };
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (s, c) = (turn * std::f64::consts::TAU).sin_cos();
    let direction = (tangent * c + bitangent * s) * (1.0 - cosine * cosine).max(0.0).sqrt() + normal * cosine;
    (u + v <= 1.0).then_some(Leaving { triangle, u, v, direction })
}
