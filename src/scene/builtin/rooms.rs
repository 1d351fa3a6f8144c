//! `builtin:rooms`: a square of rooms with a doorway between any two neighbours. Each has one lamp in the middle of its
//! ceiling, one to a hundred times as strong as another's, and the camera stands in the weakest: most lamps that seem to
//! matter there are behind walls, and some of the light comes through the doorways.
//!
//! Rooms are counted from the camera's, so a larger square has the same rooms about it and more around them. A single room
//! has no doorway, and its direct light a closed form: Lambert's formula of its one lamp.

use crate::scene::builtin::{Mesh, add_ball, diffuse, fractal, uniform};
use crate::scene::camera::{CameraKey, CameraPath};
use crate::scene::desc::{CameraDesc, InstanceDesc, MaterialDesc, RenderDesc, Scattering, SceneDesc};
use glam::DVec3;

/// From one room's middle to the next's.
const PITCH: f64 = 5.0;
/// From a room's middle to its walls, which are as thick as `PITCH` leaves them.
const REACH: f64 = 2.35;
/// Heights of the rooms and of the doorways.
const HIGH: f64 = 3.0;
const DOOR: f64 = 2.1;
/// Half the width of a doorway, and how far its middle may lie from that of the wall.
const HALF_DOOR: f64 = 0.5;
const SHIFT: f64 = 0.9;
/// Height of the camera.
const EYE: f64 = 1.6;
/// Half the side of a lamp, and how far it hangs below the ceiling.
const LAMP: f64 = 0.4;
const GAP: f64 = 0.02;
/// From a room's middle to those of the things in its corners, along either axis.
const CORNER: f64 = 1.8;

/// What the lamps' strengths are taken from; seven, so that the steps of [`strength`] reach each of them.
const STRENGTHS: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// Radiance of a lamp of strength 1, W sr^-1 m^-2.
const RADIANCE: [f64; 3] = [6.0, 5.2, 4.0];

/// The materials in front of the lamps'.
const CEILING: u32 = 0;
const FLOOR: u32 = 1;
const FRAME: u32 = 2;
const FIRST_WALL: u32 = 3;
const WALLS: [(&str, [f64; 3]); 4] = [
    ("wall_chalk", [0.78, 0.76, 0.71]),
    ("wall_sage", [0.52, 0.63, 0.48]),
    ("wall_rose", [0.74, 0.5, 0.44]),
    ("wall_blue", [0.45, 0.55, 0.7]),
];
const OAK: u32 = 7;
const STONE: u32 = 8;
/// What the balls on the plinths are made of, in turns.
const FIRST_BALL: u32 = 9;
const BALLS: u32 = 3;
const FIRST_LAMP: u32 = FIRST_BALL + BALLS;

/// A room's place, counted from the camera's.
type Place = [i32; 2];

/// The outward directions of a room's walls, counter-clockwise seen from above.
const SIDES: [Place; 4] = [[1, 0], [0, -1], [-1, 0], [0, 1]];

/// The rooms, `side` x `side` of them.
pub(super) fn rooms(name: String, side: u32) -> SceneDesc {
    let first = -(side as i32 / 2);
    let last = first + side as i32 - 1;
    let exists = |[i, k]: Place| (first..=last).contains(&i) && (first..=last).contains(&k);
    let mut mesh = Mesh::default();
    for place in (first..=last).flat_map(|k| (first..=last).map(move |i| [i, k])) {
        add_room(&mut mesh, place, &exists);
        add_things(&mut mesh, place);
        add_lamp(&mut mesh, place);
    }
    let camera = CameraDesc {
        position: [-2.2, EYE, 1.45],
        look_at: [1.2, 1.15, -1.55],
        up: [0.0, 1.0, 0.0],
        vertical_fov: 62.0,
        ..CameraDesc::default()
    };
    SceneDesc {
        name,
        camera,
        camera_path: if side > 1 { walk(camera) } else { CameraPath::default() },
        film: (640, 480),
        render: RenderDesc { spp: Some(64), ..RenderDesc::default() },
        meshes: vec![mesh.into_desc()],
        instances: vec![InstanceDesc::default()],
        materials: materials(),
        ..SceneDesc::default()
    }
}

/// A walk of eight seconds: from where the camera stands through two doorways, into the room beyond the corner.
fn walk(camera: CameraDesc) -> CameraPath {
    let [(first, ahead), (second, aside)] = [([0, 0], SIDES[1]), ([0, -1], SIDES[2])];
    let at = |place: Place, side: Place, out: f64| {
        let [left, right] = doorway(place, side);
        point(place, side, out, 0.5 * (left + right), EYE).to_array()
    };
    let (ahead, aside) = (|out: f64| at(first, ahead, out), |out: f64| at(second, aside, out));
    let steps = [
        (2.0, ahead(1.2), ahead(5.0)),
        (3.0, ahead(0.5 * PITCH), ahead(7.0)),
        (4.0, ahead(PITCH - 1.2), aside(0.5 * PITCH)),
        (5.5, aside(1.2), aside(5.0)),
        (6.5, aside(0.5 * PITCH), aside(7.0)),
        (8.0, aside(PITCH - 1.2), aside(9.0)),
    ];
    let key = |time: f64, camera: CameraDesc| CameraKey { time, camera };
    let steps = steps.map(|(time, position, look_at)| key(time, CameraDesc { position, look_at, ..camera }));
    CameraPath::new(std::iter::once(key(0.0, camera)).chain(steps).collect()).unwrap_or_default()
}

fn materials() -> Vec<MaterialDesc> {
    let dark = [0.0; 3];
    let glazed = Scattering::Plastic { albedo: [0.12, 0.28, 0.34], ior: 1.5, alpha: 0.1 };
    let metal = Scattering::Conductor { alpha: 0.2, reflectance: [0.9, 0.68, 0.42], complex_ior: None };
    let mut materials = vec![
        diffuse("ceiling", [0.82, 0.81, 0.78], dark),
        diffuse("floor", [0.5, 0.38, 0.27], dark),
        diffuse("frame", [0.75, 0.73, 0.68], dark),
    ];
    materials.extend(WALLS.map(|(name, albedo)| diffuse(name, albedo, dark)));
    materials.extend([
        diffuse("oak", [0.42, 0.29, 0.18], dark),
        diffuse("stone", [0.6, 0.58, 0.55], dark),
        diffuse("clay", [0.66, 0.36, 0.26], dark),
        MaterialDesc { name: "glazed".into(), scattering: glazed, ..MaterialDesc::default() },
        MaterialDesc { name: "bronze".into(), scattering: metal, ..MaterialDesc::default() },
    ]);
    materials.extend(STRENGTHS.map(|s| diffuse(&format!("lamp_{s}"), dark, RADIANCE.map(|c| c * s))));
    materials
}

/// Which of [`STRENGTHS`] a room's lamp has: three steps along x and five along z, round and round. The camera's room has
/// the least, and neighbours are never alike.
fn strength([i, k]: Place) -> usize {
    (3 * i + 5 * k).rem_euclid(STRENGTHS.len() as i32) as usize
}

/// A number in [0, 1) that belongs to a room and `stream`.
fn random([i, k]: Place, stream: u64) -> f64 {
    uniform((i + 512) as u64 * 1024 + (k + 512) as u64, 80 + stream)
}

fn neighbour([i, k]: Place, [di, dk]: Place) -> Place {
    [i + di, k + dk]
}

/// The point of a room `out` from its middle towards a wall, `right` of it for who looks at the wall, and `up`. All three
/// stay apart from the room's middle until the last sum, so whatever touches a point has the same bits of it.
fn point([i, k]: Place, [di, dk]: Place, out: f64, right: f64, up: f64) -> DVec3 {
    let (di, dk) = (f64::from(di), f64::from(dk));
    let (x, z) = (di * out - dk * right, dk * out + di * right);
    DVec3::new(PITCH * f64::from(i) + x, up, PITCH * f64::from(k) + z)
}

/// The ends of the doorway in a room's wall, to the right of the wall's middle; the same gap seen from either side.
fn doorway(place: Place, side: Place) -> [f64; 2] {
    // A doorway belongs to the room from which it lies towards +x or +z.
    let (owner, sign) = if side[0] + side[1] > 0 { (place, 1.0) } else { (neighbour(place, side), -1.0) };
    let middle = SHIFT * ((3.0 * random(owner, side[0].unsigned_abs().into())).floor() - 1.0);
    [sign * middle - HALF_DOOR, sign * middle + HALF_DOOR]
}

/// Floor, ceiling, walls with their doorways, and the passages through the walls at +x and +z. Corners of one polygon are
/// corners of those beside it, so that all rooms together are one closed surface.
fn add_room(mesh: &mut Mesh, place: Place, exists: &impl Fn(Place) -> bool) {
    let paint = FIRST_WALL + (random(place, 2) * WALLS.len() as f64) as u32;
    let mut rim = Vec::new();
    for side in SIDES {
        let at = |right: f64, up: f64| point(place, side, REACH, right, up);
        rim.push(at(REACH, 0.0));
        if !exists(neighbour(place, side)) {
            mesh.free_quad([at(-REACH, 0.0), at(REACH, 0.0), at(REACH, HIGH), at(-REACH, HIGH)], paint);
            continue;
        }
        let [left, right] = doorway(place, side);
        rim.extend([at(right, 0.0), at(left, 0.0)]);
        mesh.free_quad([at(-REACH, 0.0), at(left, 0.0), at(left, DOOR), at(-REACH, HIGH)], paint);
        mesh.free_quad([at(right, 0.0), at(REACH, 0.0), at(REACH, HIGH), at(right, DOOR)], paint);
        mesh.free_quad([at(left, DOOR), at(right, DOOR), at(REACH, HIGH), at(-REACH, HIGH)], paint);
        if side[0] + side[1] > 0 {
            // Seen from the other room, right is left.
            let beyond = |right: f64, up: f64| point(neighbour(place, side), side, -REACH, right, up);
            mesh.free_quad([at(left, 0.0), at(right, 0.0), beyond(right, 0.0), beyond(left, 0.0)], FRAME);
            mesh.free_quad([at(right, DOOR), at(left, DOOR), beyond(left, DOOR), beyond(right, DOOR)], FRAME);
            mesh.free_quad([at(left, DOOR), at(left, 0.0), beyond(left, 0.0), beyond(left, DOOR)], FRAME);
            mesh.free_quad([at(right, 0.0), at(right, DOOR), beyond(right, DOOR), beyond(right, 0.0)], FRAME);
        }
    }
    let middle = point(place, SIDES[0], 0.0, 0.0, 0.0);
    for (i, &from) in rim.iter().enumerate() {
        let vertices = [middle, from, rim[(i + 1) % rim.len()]].map(|p| mesh.vertex(p));
        mesh.triangle(vertices, FLOOR);
    }
    // Along the last wall, and from there to the one across.
    mesh.free_quad([0, 3, 2, 1].map(|i| point(place, SIDES[i], REACH, REACH, HIGH)), CEILING);
}

/// A plinth with a ball in one corner of a room, and a sideboard in the corner across.
fn add_things(mesh: &mut Mesh, place: Place) {
    // Not where the camera stands.
    let corner = if place == [0, 0] { 1 } else { (random(place, 3) * 4.0) as usize };
    let turn = SIDES[corner];
    let at = |out: f64, right: f64, up: f64| point(place, turn, out, right, up);
    add_box(mesh, |x, y, z| at(CORNER + 0.28 * x, CORNER + 0.28 * z, 0.9 * y), STONE);
    add_box(mesh, |x, y, z| at(0.25 * x - CORNER - 0.15, 0.4 * z - CORNER, 0.8 * y), OAK);
    let (seed, centre) = (400 + u64::from(strength(place) as u32), at(CORNER, CORNER, 1.22));
    // Every third is a rough stone.
    let material = (random(place, 4) * f64::from(BALLS)) as u32;
    let surface = |p: DVec3| {
        let p = p / p.length();
        let dents = if material == 0 { 0.3 * (fractal(1.6 * p, 3, seed) - 0.5) } else { 0.0 };
        centre + p * (0.3 * (1.0 + dents))
    };
    add_ball(mesh, 6, surface, FIRST_BALL + material);
}

/// A box without a bottom, -1 to 1 along its first and last axis and 0 to 1 along the one up, put in place by `at`, which
/// turns nothing inside out.
fn add_box(mesh: &mut Mesh, at: impl Fn(f64, f64, f64) -> DVec3, material: u32) {
    let ring = |y: f64| [at(-1.0, y, 1.0), at(1.0, y, 1.0), at(1.0, y, -1.0), at(-1.0, y, -1.0)];
    let (low, high) = (ring(0.0), ring(1.0));
    for k in 0..4 {
        mesh.free_quad([low[k], low[(k + 1) % 4], high[(k + 1) % 4], high[k]], material);
    }
    mesh.free_quad(high, material);
}

/// A lamp that shines down, in the middle of a room's ceiling.
fn add_lamp(mesh: &mut Mesh, place: Place) {
    let corners = [0, 3, 2, 1].map(|i| point(place, SIDES[i], LAMP, LAMP, HIGH - GAP));
    mesh.free_quad(corners, FIRST_LAMP + strength(place) as u32);
}
