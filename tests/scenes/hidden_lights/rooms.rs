//! `builtin:rooms`.

use super::closed::{assert_tight, corners, enclosed, material, of};
use crate::common::{estimate, polygon_irradiance, small};
use glam::DVec3;
use octray::internal::sampler::{random_words, unit};
use octray::scene::SceneDesc;
use octray::scene::desc::{CameraDesc, Scattering};
use octray::{F32x8, Lights, Mask8, RayPacket, Scene, Settings, Strategy, Vec3x8, render};
use std::collections::{HashMap, HashSet};

const PITCH: f64 = 5.0;
const REACH: f64 = 2.35;

fn rooms(side: u32) -> SceneDesc {
    SceneDesc::load(format!("builtin:rooms:{side}")).unwrap_or_else(|error| panic!("{error}"))
}

fn is_wall(name: &str) -> bool {
    ["floor", "ceiling", "frame"].contains(&name) || name.starts_with("wall")
}

/// Which room a point is in, counted from the camera's.
fn place(p: DVec3) -> [i32; 2] {
    [p.x, p.z].map(|x| (x / PITCH).round() as i32)
}

/// A rectangle of a wall, floor or lamp, from its two triangles.
fn rectangles(scene: &SceneDesc, wanted: impl Fn(&str) -> bool) -> Vec<[DVec3; 4]> {
    let triangles = of(scene, wanted);
    let rectangle = |pair: &[usize]| {
        let ([a, b, c], [_, _, d]) = (corners(scene, pair[0]), corners(scene, pair[1]));
        [a, b, c, d]
    };
    triangles.chunks_exact(2).map(rectangle).collect()
}

#[test]
fn the_rooms_are_one_closed_surface() {
    for side in [1, 2, 3, 6] {
        let scene = rooms(side);
        let (count, doors) = (f64::from(side * side), f64::from(2 * side * (side - 1)));
        let volume = count * (2.0 * REACH) * (2.0 * REACH) * 3.0 + doors * 1.0 * 2.1 * (PITCH - 2.0 * REACH);
        let enclosed = enclosed(&scene, &of(&scene, is_wall));
        assert!((enclosed / volume - 1.0).abs() < 1e-5, "{side}: {enclosed}, {volume}");
        if side != 2 {
            assert_tight(scene);
        }
    }
}

#[test]
fn every_room_has_one_lamp_and_the_cameras_the_weakest() {
    for (side, first) in [(1, 0), (2, -1), (3, -1), (6, -3), (9, -4)] {
        let scene = rooms(side);
        let lamps = of(&scene, |name| name.starts_with("lamp"));
        let mut strengths = HashMap::new();
        for pair in lamps.chunks_exact(2) {
            let emission = scene.materials[scene.geometry().triangles[pair[0]].material as usize].emission;
            let [a, b, c] = corners(&scene, pair[0]);
            assert!((b - a).cross(c - a).normalize().y == -1.0, "it shines down");
            assert!(strengths.insert(place((a + c) / 2.0), (emission[0] / 6.0).round() as u32).is_none());
        }
        let within = |i: &i32| (first..first + side as i32).contains(i);
        assert!(strengths.len() as u32 == side * side && strengths.keys().flatten().all(within));
        assert_eq!((strengths[&[0, 0]], place(DVec3::from(scene.camera.position))), (1, [0, 0]));
        for (&[i, k], strength) in &strengths {
            for beside in [[i + 1, k], [i, k + 1]] {
                assert_ne!(strengths.get(&beside), Some(strength), "{i}, {k}");
            }
        }
        let all: HashSet<u32> = strengths.into_values().collect();
        assert!(side < 6 || all == HashSet::from([1, 2, 5, 10, 20, 50, 100]), "{all:?}");
    }
}

/// The walk goes through doorways and meets nothing, and ends two rooms on.
#[test]
fn the_camera_walks_through_doorways() {
    for side in [2, 6] {
        let scene = rooms(side);
        let eye = |step: u32| DVec3::from(scene.camera_path.at(f64::from(step) / 30.0).unwrap().position);
        assert_eq!((place(eye(0)), place(eye(150)), place(eye(240))), ([0, 0], [0, -1], [-1, -1]));
        let prepared = Scene::from(scene.clone()).prepare().unwrap();
        for step in 0..240 {
            // From where it is to where it will be, and a step to either side.
            let (here, next) = (eye(step), eye(step + 1));
            let aside = (next - here).cross(DVec3::Y).normalize_or_zero() * 0.2;
            for toward in [next - here, aside, -aside].map(|toward| toward.as_vec3().to_array()) {
                let rays = RayPacket {
                    origin: Vec3x8::splat(here.as_vec3().to_array()),
                    direction: Vec3x8::splat(toward),
                    tmin: F32x8::splat(0.0),
                    tmax: F32x8::splat(1.0),
                };
                assert!(!prepared.occluded(&rays, Mask8::ALL).any(), "{side}, step {step}: {here} {toward:?}");
            }
        }
    }
    assert!(rooms(1).camera_path.keys().is_empty(), "there is nowhere to go");
}

/// A larger square holds the smaller: only walls that were outer ones change.
#[test]
fn larger_squares_hold_the_smaller() {
    let triangles = |side: u32| {
        let scene = rooms(side);
        let inner = of(&scene, |name| name.starts_with("lamp") || !is_wall(name) || name == "frame");
        let bits = |i: usize| corners(&scene, i).map(|p| (p + 0.0).to_array().map(f64::to_bits));
        inner.into_iter().map(|i| (material(&scene, i).to_owned(), bits(i))).collect::<HashSet<_>>()
    };
    let sizes = [1, 2, 3, 6, 7].map(triangles);
    for pair in sizes.windows(2) {
        assert!(pair[0].len() < pair[1].len() && pair[0].is_subset(&pair[1]));
    }
}

/// A passage through a wall: what is seen through it is seen through the mouths at both of its ends.
struct Passage {
    /// Mouth and room at the lower end, then at the upper.
    ends: [([DVec3; 4], [i32; 2]); 2],
}

/// The passages, from the floor and the lintel of each.
fn passages(scene: &SceneDesc) -> Vec<Passage> {
    let frames = rectangles(scene, |name| name == "frame");
    // Floor, lintel and two sides each.
    let passage = |parts: &[[DVec3; 4]]| {
        let points: Vec<DVec3> = parts.iter().flatten().copied().collect();
        let (low, high) = (points.iter().copied().reduce(DVec3::min), points.iter().copied().reduce(DVec3::max));
        let (low, high) = (low.expect("points"), high.expect("points"));
        let size = high - low;
        let axis = if size.x < size.z { 0 } else { 2 };
        let mouth = |at: f64| {
            [(low, low.y), (high, low.y), (high, high.y), (low, high.y)].map(|(along, y)| {
                let mut p = DVec3::new(along.x, y, along.z);
                p[axis] = at;
                p
            })
        };
        let mut out = DVec3::ZERO;
        out[axis] = 1.0;
        let room = |at: f64, sign: f64| place((low + high) / 2.0 * (DVec3::ONE - out) + out * (at + sign * REACH));
        Passage { ends: [(mouth(low[axis]), room(low[axis], -1.0)), (mouth(high[axis]), room(high[axis], 1.0))] }
    };
    frames.chunks_exact(4).map(passage).collect()
}

/// What of a polygon lies on the positive side of all planes through `eye` (Sutherland and Hodgman 1974).
fn clipped(polygon: &[DVec3], eye: DVec3, normals: &[DVec3]) -> Vec<DVec3> {
    let mut polygon = polygon.to_vec();
    for normal in normals {
        let height = |p: DVec3| (p - eye).dot(*normal);
        let mut kept: Vec<DVec3> = Vec::new();
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (from, to) = (height(a), height(b));
            if from >= 0.0 {
                kept.push(a);
            }
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                kept.push(a + (b - a) * (from / (from - to)));
            }
        }
        kept.dedup_by(|a, b| a.distance(*b) < 1e-9);
        if kept.len() > 1 && kept[0].distance(kept[kept.len() - 1]) < 1e-9 {
            kept.pop();
        }
        if kept.len() < 3 {
            return Vec::new();
        }
        polygon = kept;
    }
    polygon
}

/// The planes through `eye` and the sides of a convex polygon, which lies on their positive side.
fn beam(eye: DVec3, polygon: &[DVec3]) -> Vec<DVec3> {
    let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let side = |i: usize| {
        let normal = (polygon[i] - eye).cross(polygon[(i + 1) % polygon.len()] - eye).normalize();
        if normal.dot(middle - eye) < 0.0 { -normal } else { normal }
    };
    (0..polygon.len()).map(side).collect()
}

/// The empty rooms, as one who looks through doorways knows them.
struct Plan {
    passages: Vec<Passage>,
    lamps: HashMap<[i32; 2], ([DVec3; 4], [f64; 3])>,
}

impl Plan {
    fn new(scene: &SceneDesc) -> Plan {
        let emission = |name: &str| scene.materials.iter().find(|m| m.name == name).map_or([0.0; 3], |m| m.emission);
        let lamps = scene.materials.iter().filter(|material| material.name.starts_with("lamp")).flat_map(|material| {
            let of_it = rectangles(scene, |name| name == material.name);
            of_it.into_iter().map(|lamp| (place((lamp[0] + lamp[2]) / 2.0), (lamp, emission(&material.name))))
        });
        Plan { passages: passages(scene), lamps: lamps.collect() }
    }

    /// Irradiance at a point of the floor from the lamps of `room` and of all rooms behind it, as far as they are seen within
    /// `normals`: Lambert's formula of each lamp, cut by the doorways in front of it (Teller and Sequin 1991 follow portals so).
    fn irradiance(&self, eye: DVec3, room: [i32; 2], normals: &[DVec3]) -> [f64; 3] {
        let (lamp, emission) = self.lamps[&room];
        let seen = clipped(&lamp, eye, normals);
        let own = if seen.is_empty() { 0.0 } else { polygon_irradiance(eye, DVec3::Y, &seen) };
        let mut sum = emission.map(|c| c * own);
        for passage in &self.passages {
            for (near, far) in [(0, 1), (1, 0)] {
                let ((mouth, from), (exit, to)) = (passage.ends[near], passage.ends[far]);
                let away = (exit[0] - mouth[0]).dot(mouth[0] - eye) > 0.0;
                if from != room || !away || clipped(&mouth, eye, normals).is_empty() {
                    continue;
                }
                let normals = [normals, &beam(eye, &mouth), &beam(eye, &exit)].concat();
                if !clipped(&exit, eye, &normals).is_empty() {
                    let beyond = self.irradiance(eye, to, &normals);
                    (0..3).for_each(|c| sum[c] += beyond[c]);
                }
            }
        }
        sum
    }
}

/// The direct light of one place on the floor of every room, emptied of things, is the closed form: of its own lamp, and of what
/// is seen of other lamps through doorways. Five standard errors, by three strategies and selections: a false alarm once in
/// 5,000 files.
#[test]
fn direct_light_is_lamberts_through_every_doorway() {
    for side in [1, 6] {
        let mut scene = rooms(side);
        let empty: Vec<_> = scene.materials.iter().map(|m| is_wall(&m.name) || m.name.starts_with("lamp")).collect();
        scene.meshes[0].triangles.retain(|t| empty[t.material as usize]);
        let Scattering::Diffuse { albedo } = scene.materials[1].scattering else { panic!("the floor is diffuse") };
        let plan = Plan::new(&scene);
        assert_eq!(plan.passages.len() as u32, 2 * side * (side - 1));
        let (mut through, mut alone) = (0, 0);
        let mut places: Vec<_> = plan.lamps.keys().copied().collect();
        places.sort_unstable();
        for (n, room) in places.into_iter().enumerate() {
            let [x, z, ..] = random_words(n as u32, 0, 0, 5).map(|word| 4.4 * (f64::from(unit(word)) - 0.5));
            let eye = DVec3::new(PITCH * f64::from(room[0]) + x, 0.0, PITCH * f64::from(room[1]) + z);
            let truth = plan.irradiance(eye, room, &[]);
            let (lamp, emission) = plan.lamps[&room];
            let own = emission[0] * polygon_irradiance(eye, DVec3::Y, &lamp);
            if truth[0] > 1.01 * own {
                through += 1
            } else {
                alone += 1
            }
            scene.camera = CameraDesc {
                position: (eye + DVec3::new(-0.04 * x, 1.0, -0.05 * z)).to_array(),
                look_at: eye.to_array(),
                up: [1.0, 0.0, 0.0],
                vertical_fov: 1e-3,
                ..CameraDesc::default()
            };
            let prepared = Scene::from(scene.clone()).prepare().unwrap_or_else(|error| panic!("{error}"));
            for (strategy, lights) in [
                (Strategy::Nee, Lights::Tree),
                (Strategy::MisPower, Lights::Tree),
                (Strategy::MisBalance, Lights::Power),
            ] {
                let settings = Settings { strategy, lights, max_depth: Some(1), ..small(8, 8, 256) };
                let film = render(&prepared, &settings).film;
                for c in 0..3 {
                    let got = estimate(&film, 0..8, 0..8, c);
                    let truth = albedo[c] / std::f64::consts::PI * truth[c];
                    let bound = 5.0 * got.error + 1e-5 * truth;
                    let what = format!("room {room:?}, {strategy}, {lights}: {} +- {}, {truth}", got.mean, got.error);
                    assert!((got.mean - truth).abs() <= bound, "{what}");
                    assert!(bound < 0.3 * truth, "{what}: too noisy to prove anything");
                }
            }
        }
        assert!(
            if side == 1 { alone == 1 } else { through > 5 && alone > 5 },
            "{through} places of {}",
            through + alone
        );
        println!("{side} x {side} rooms: {through} places lit through doorways too, {alone} by their own lamp alone");
    }
}
