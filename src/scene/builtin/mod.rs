//! Scenes made in code: `builtin:NAME`. Only exactly rounded operations, so every machine makes the same bits.

use crate::error::{Error, Result};
use crate::nearest::close;
use crate::scene::desc::{
    CameraDesc, EnvironmentDesc, InstanceDesc, LightDesc, MaterialDesc, MeshDesc, RenderDesc, Scattering, SceneDesc,
    TriangleDesc,
};
use crate::scene::validate;
use glam::DVec3;
use std::ops::RangeInclusive;

mod lamp_hall;
mod rooms;

/// What may stand behind `builtin:`.
pub const NAMES: &[&str] = &["heavy", "lamp_hall", "rooms"];

/// A scene made in code; its size may follow its name: `heavy:20000`.
struct Builtin {
    name: &'static str,
    /// What the size counts.
    counts: &'static str,
    /// The size where none is given.
    size: u32,
    /// The smallest and the largest size.
    sizes: RangeInclusive<u32>,
    make: fn(String, u32) -> SceneDesc,
}

/// Below the smallest sizes the fixed parts do not fit (or light up nothing); above the largest, memory is the limit.
const SCENES: [Builtin; 3] = [
    Builtin { name: NAMES[0], counts: "triangle count", size: 1_200_000, sizes: 2_000..=50_000_000, make: heavy },
    Builtin {
        name: NAMES[1],
        counts: "number of lamps",
        size: 2_000,
        sizes: 100..=1_000_000,
        make: lamp_hall::lamp_hall,
    },
    Builtin { name: NAMES[2], counts: "number of rooms along a side", size: 6, sizes: 1..=100, make: rooms::rooms },
];

/// Builds `builtin:NAME` or `builtin:NAME:SIZE`.
pub fn build(name: &str) -> Result<SceneDesc> {
    let scene = format!("builtin:{name}");
    let (name, size) = name.split_once(':').map_or((name, None), |(name, size)| (name, Some(size)));
    let fault = |message: String| Err(Error::Scene { scene: scene.clone(), message });
    let Some(builtin) = SCENES.iter().find(|builtin| builtin.name == name) else {
        let near = close(name, NAMES.iter().copied());
        let hint = near.map_or(String::new(), |near| format!("; did you mean `builtin:{near}`?"));
        let known = NAMES.iter().map(|name| format!("builtin:{name}")).collect::<Vec<_>>().join(", ");
        return fault(format!("no such scene{hint}; known: {known}"));
    };
    let size = match size.map(str::parse::<u32>) {
        None => builtin.size,
        Some(Ok(size)) if builtin.sizes.contains(&size) => size,
        Some(_) => {
            let (first, last) = (builtin.sizes.start(), builtin.sizes.end());
            return fault(format!("the number behind the name is the {}, {first} to {last}", builtin.counts));
        }
    };
    let scene = (builtin.make)(scene, size);
    validate::check(&scene)?;
    Ok(scene)
}

/// Half the side of the hall, its height, and half the side of the hole in its ceiling.
const HALL: (f64, f64, f64) = (12.0, 9.0, 2.5);
/// Lamps along one side of their square grid.
const LAMPS: u32 = 5;
/// Displaced spheres.
const BLOBS: u32 = 60;
const EYE: DVec3 = DVec3::new(-9.5, 4.6, 9.5);

/// A walled hall with rough ground, boulders and grass, lit by small lamps and the sky through a hole in its ceiling:
/// long indirect paths, needle triangles, boulders that overlap, and many small lights.
fn heavy(name: String, triangles: u32) -> SceneDesc {
    let dark = [0.0; 3];
    let materials = vec![
        diffuse("ground", [0.45, 0.38, 0.3], dark),
        diffuse("wall", [0.7, 0.68, 0.64], dark),
        diffuse("lamp", dark, [60.0, 45.0, 28.0]),
        diffuse("grass", [0.2, 0.45, 0.12], dark),
        diffuse("sandstone", [0.65, 0.42, 0.28], dark),
        diffuse("slate", [0.3, 0.33, 0.38], dark),
        diffuse("chalk", [0.8, 0.79, 0.75], dark),
    ];
    let mut mesh = Mesh::default();
    // A quarter of the triangles is ground, three fifths are boulders, grass fills up to the exact number.
    add_ground(&mut mesh, (triangles / 8).isqrt());
    add_hall(&mut mesh);
    for boulder in 0..BLOBS {
        add_boulder(&mut mesh, boulder, (triangles / 20 * 12 / (12 * BLOBS)).isqrt().max(1));
    }
    let left = (triangles as usize).saturating_sub(mesh.triangles.len());
    for blade in 0..left {
        add_blade(&mut mesh, blade as u64);
    }
    SceneDesc {
        name,
        camera: CameraDesc {
            position: EYE.to_array(),
            look_at: [1.0, 0.8, -1.0],
            up: [0.0, 1.0, 0.0],
            vertical_fov: 58.0,
            ..CameraDesc::default()
        },
        film: (512, 512),
        render: RenderDesc { spp: Some(16), ..RenderDesc::default() },
        meshes: vec![mesh.into_desc()],
        instances: vec![InstanceDesc::default()],
        materials,
        lights: vec![LightDesc::Environment(EnvironmentDesc::Constant { radiance: [3.0, 3.8, 5.0] })],
        ..SceneDesc::default()
    }
}

fn diffuse(name: &str, albedo: [f64; 3], emission: [f64; 3]) -> MaterialDesc {
    MaterialDesc { name: name.into(), scattering: Scattering::Diffuse { albedo }, emission, ..MaterialDesc::default() }
}

#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<TriangleDesc>,
}

impl Mesh {
    fn into_desc(self) -> MeshDesc {
        MeshDesc { positions: self.positions, triangles: self.triangles, corners: Vec::new() }
    }

    fn vertex(&mut self, p: DVec3) -> u32 {
        self.positions.push(p.as_vec3().to_array());
        self.positions.len() as u32 - 1
    }

    fn triangle(&mut self, vertices: [u32; 3], material: u32) {
        self.triangles.push(TriangleDesc { vertices, material, flipped: false });
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4], material: u32) {
        self.triangle([a, b, c], material);
        self.triangle([a, c, d], material);
    }

    fn free_quad(&mut self, corners: [DVec3; 4], material: u32) {
        let corners = corners.map(|p| self.vertex(p));
        self.quad(corners, material);
    }
}

fn add_ground(mesh: &mut Mesh, cells: u32) {
    let base = mesh.positions.len() as u32;
    let side = cells + 1;
    let along = |i: u32| HALL.0 * (2.0 * f64::from(i) - f64::from(cells)) / f64::from(cells);
    for (x, z) in (0..side).flat_map(|i| (0..side).map(move |k| (i, k))) {
        mesh.vertex(on_ground(along(x), along(z)));
    }
    for (i, k) in (0..cells).flat_map(|i| (0..cells).map(move |k| (i, k))) {
        let at = |i: u32, k: u32| base + i * side + k;
        mesh.quad([at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)], 0);
    }
}

fn on_ground(x: f64, z: f64) -> DVec3 {
    DVec3::new(x, 2.6 * fractal(DVec3::new(0.25 * x, 0.0, 0.25 * z), 9, 1), z)
}

/// Four walls from below the ground, a ceiling around its hole, and the lamps, all facing inwards.
fn add_hall(mesh: &mut Mesh) {
    let (s, top, hole) = HALL;
    let ring = |half: f64, y: f64| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| DVec3::new(x * half, y, z * half))
    };
    let (low, high, gap) = (ring(s, -1.0), ring(s, top), ring(hole, top));
    for i in 0..4 {
        let next = (i + 1) % 4;
        mesh.free_quad([low[i], low[next], high[next], high[i]], 1);
        mesh.free_quad([high[i], high[next], gap[next], gap[i]], 1);
    }
    for i in 0..LAMPS * LAMPS {
        let place = |n: u32| 4.4 * (f64::from(n) - 0.5 * f64::from(LAMPS - 1));
        let centre = DVec3::new(place(i % LAMPS), top - 1.0 - 2.0 * uniform(u64::from(i), 7), place(i / LAMPS));
        mesh.free_quad(ring(0.15, 0.0).map(|p| p + centre), 2);
    }
}

/// A sphere pushed in and out by noise.
fn add_boulder(mesh: &mut Mesh, boulder: u32, cells: u32) {
    let random = |k: u64| uniform(u64::from(boulder), 20 + k);
    let radius = 0.25 + 1.1 * random(0) * random(1);
    // Not in front of the lens: a place too near is mirrored to the other side of the hall.
    let mut place = DVec3::new(20.0 * random(2) - 10.0, 0.0, 20.0 * random(3) - 10.0);
    if (place - EYE.with_y(0.0)).length() < 4.0 {
        place = -place;
    }
    let centre = on_ground(place.x, place.z) + DVec3::Y * (0.5 * radius + 4.0 * random(4) * random(5) * random(6));
    let surface = |p: DVec3| {
        let p = p / p.length();
        centre + p * (radius * (0.6 + 0.8 * fractal(2.0 * p, 6, 100 + u64::from(boulder))))
    };
    add_ball(mesh, cells, surface, 4 + boulder % 3);
}

/// A sphere of 6 grids of `cells` x `cells` quads whose points `surface` moves to their places.
fn add_ball(mesh: &mut Mesh, cells: u32, surface: impl Fn(DVec3) -> DVec3, material: u32) {
    // (2i - n) / n is exactly antisymmetric, so the six grids share the bits of their edges.
    let along = |i: u32| (2.0 * f64::from(i) - f64::from(cells)) / f64::from(cells);
    let side = cells + 1;
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let base = mesh.positions.len() as u32;
        for (i, k) in (0..side).flat_map(|i| (0..side).map(move |k| (i, k))) {
            let mut p = DVec3::ZERO;
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, along(i), along(k));
            mesh.vertex(surface(p));
        }
        for (i, k) in (0..cells).flat_map(|i| (0..cells).map(move |k| (i, k))) {
            let at = |i: u32, k: u32| base + i * side + k;
            let (b, d) = (at(i + 1, k), at(i, k + 1));
            let (b, d) = if sign > 0.0 { (b, d) } else { (d, b) };
            mesh.quad([at(i, k), b, at(i + 1, k + 1), d], material);
        }
    }
}

/// A needle of a triangle that leans anywhere.
fn add_blade(mesh: &mut Mesh, blade: u64) {
    let random = |k: u64| uniform(blade, 40 + k);
    let root = on_ground(23.6 * random(0) - 11.8, 23.6 * random(1) - 11.8);
    let across = DVec3::new(random(2) - 0.5, 0.0, random(3) - 0.5) * 0.03;
    let lean = DVec3::new(random(4) - 0.5, 0.0, random(5) - 0.5);
    let tip = root + (DVec3::Y + lean) * (0.08 + 0.5 * random(6) * random(7));
    let vertices = [root - across, root + across, tip].map(|p| mesh.vertex(p));
    mesh.triangle(vertices, 3);
}

/// A number in [0, 1) that belongs to `index` and `stream`: the mixing steps of SplitMix64 (Steele, Lea and Flood
/// 2014).
fn uniform(index: u64, stream: u64) -> f64 {
    let mut z = (index << 8 | stream).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
}

/// Value noise summed over octaves of half the size and half the strength; in [0, 1).
fn fractal(p: DVec3, octaves: u32, seed: u64) -> f64 {
    let (mut sum, mut strength, mut p) = (0.0, 0.5, p);
    for octave in 0..octaves {
        sum += strength * noise(p, seed + 1000 * u64::from(octave));
        strength *= 0.5;
        p *= 2.0;
    }
    sum
}

/// Random values at whole coordinates, joined by smooth steps.
fn noise(p: DVec3, seed: u64) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * (3.0 - 2.0 * f);
    let [x, y, z] = cell.to_array().map(|c| c as i64 as u64);
    let at = |i: u64, j: u64, k: u64| {
        // Distinct odd factors spread the lattice over the index; no other use has stream 255.
        let index = x.wrapping_add(i).wrapping_mul(0x8DA6_B343)
            ^ y.wrapping_add(j).wrapping_mul(0xD816_3841)
            ^ z.wrapping_add(k).wrapping_mul(0xCB1A_B31F);
        uniform(index.wrapping_add(seed << 32), 255)
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let row = |j: u64, k: u64| mix(at(0, j, k), at(1, j, k), w.x);
    mix(mix(row(0, 0), row(1, 0), w.y), mix(row(0, 1), row(1, 1), w.y), w.z)
}
