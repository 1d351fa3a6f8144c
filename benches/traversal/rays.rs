//! Scenes and ray sets for traversal measurements: camera rays, shadow rays of their hits, first and third bounces.

use octray::internal::bvh::ray::NO_HIT;
use octray::internal::bvh::{Bvh, HitQueue, RayQueue};

/// Triangles in a table, as the BVH takes them.
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub light: [[f32; 3]; 3],
    pub eye: [f32; 3],
}

fn quad(mesh: &mut Mesh, corner: [f32; 3], a: [f32; 3], b: [f32; 3]) {
    let base = mesh.positions.len() as u32;
    for (s, t) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        mesh.positions.push([0, 1, 2].map(|k| corner[k] + s * a[k] + t * b[k]));
    }
    mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
}

/// A room of 36 triangles, built like the Cornell box: five walls, a light, two turned boxes of six sides.
pub fn room() -> Mesh {
    let light = [[-0.25, 1.98, -0.25], [0.5, 0.0, 0.0], [0.0, 0.0, 0.5]];
    let mut mesh = Mesh { positions: vec![], triangles: vec![], light, eye: [0.0, 1.0, 3.9] };
    quad(&mut mesh, [-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    quad(&mut mesh, [-1.0, 2.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    quad(&mut mesh, [-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    quad(&mut mesh, [-1.0, 0.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    quad(&mut mesh, [1.0, 0.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    quad(&mut mesh, light[0], light[1], light[2]);
    for (centre, height, turn) in [([0.35f32, 0.35f32], 0.6f32, 0.3f32), ([-0.35, -0.3], 1.2, -0.3)] {
        let (s, c) = (0.6 * turn.sin(), 0.6 * turn.cos());
        let (a, b, up) = ([c, 0.0, s], [-s, 0.0, c], [0.0, height, 0.0]);
        let corner = [centre[0] - 0.5 * (a[0] + b[0]), 0.0, centre[1] - 0.5 * (a[2] + b[2])];
        let plus = |p: [f32; 3], q: [f32; 3]| [0, 1, 2].map(|k| p[k] + q[k]);
        quad(&mut mesh, corner, a, b);
        quad(&mut mesh, plus(corner, up), a, b);
        quad(&mut mesh, corner, a, up);
        quad(&mut mesh, corner, b, up);
        quad(&mut mesh, plus(corner, b), a, up);
        quad(&mut mesh, plus(corner, a), b, up);
    }
    mesh
}

/// The same room, the boxes replaced by `n` bumpy spheres of 20,000 triangles each.
pub fn spheres(n: usize) -> Mesh {
    let mut mesh = room();
    mesh.positions.truncate(6 * 4);
    mesh.triangles.truncate(6 * 2);
    let mut random = Random(1);
    let (rings, sectors) = (100u32, 100u32);
    for _ in 0..n {
        let centre = [random.unit() * 1.7 - 0.85, random.unit() * 1.5 + 0.15, random.unit() * 1.7 - 0.85];
        let radius = 0.06 + 0.16 * random.unit();
        let base = mesh.positions.len() as u32;
        for i in 0..=rings {
            for j in 0..sectors {
                let theta = i as f32 / rings as f32 * std::f32::consts::PI;
                let phi = j as f32 / sectors as f32 * std::f32::consts::TAU;
                let r = radius * (1.0 + 0.1 * (13.0 * theta).sin() * (11.0 * phi).cos() + 0.02 * random.unit());
                mesh.positions.push([
                    centre[0] + r * theta.sin() * phi.cos(),
                    centre[1] + r * theta.cos(),
                    centre[2] + r * theta.sin() * phi.sin(),
                ]);
            }
        }
        for i in 0..rings {
            for j in 0..sectors {
                let at = |i: u32, j: u32| base + i * sectors + j % sectors;
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                mesh.triangles.push([at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]);
            }
        }
    }
    mesh
}

/// Rays of one kind.
pub struct RaySet {
    pub name: &'static str,
    pub rays: RayQueue,
    pub count: usize,
}

pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

type Vector = [f32; 3];

fn add(a: Vector, s: f32, b: Vector) -> Vector {
    [0, 1, 2].map(|k| a[k] + s * b[k])
}
fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

fn set(name: &'static str, list: &[(Vector, Vector, f32)]) -> RaySet {
    let mut rays = RayQueue::with_len(list.len());
    for (i, (o, d, tmax)) in list.iter().enumerate() {
        ([rays.ox[i], rays.oy[i], rays.oz[i]], [rays.dx[i], rays.dy[i], rays.dz[i]]) = (*o, *d);
        rays.tmax[i] = *tmax;
    }
    RaySet { name, rays, count: list.len() }
}

/// Camera, shadow, first and third bounce rays of a picture of `size` by `size` pixels, in blocks of 4 by 2 pixels.
pub fn ray_sets(mesh: &Mesh, bvh: &Bvh, size: usize) -> Vec<RaySet> {
    let mut random = Random(7);
    let mut list = vec![];
    for block in 0..size * size / 8 {
        let (bx, by) = (block % (size / 4) * 4, block / (size / 4) * 2);
        for lane in 0..8 {
            let (x, y) = ((bx + lane % 4) as f32 + random.unit(), (by + lane / 4) as f32 + random.unit());
            let s = 0.68 / size as f32;
            let d = unit([x * s - 0.34, 0.34 - y * s, -1.0]);
            list.push((mesh.eye, d, f32::INFINITY));
        }
    }
    let mut sets = vec![set("camera", &list)];
    for bounce in 1..=3 {
        let rays = set("", &list);
        let mut hits = HitQueue::default();
        bvh.intersect_stream(&rays.rays, list.len(), &mut hits);
        let (mut shadow, mut next) = (vec![], vec![]);
        for (i, (o, d, _)) in list.iter().enumerate() {
            if hits.triangle[i] == NO_HIT {
                continue;
            }
            let v = mesh.triangles[hits.triangle[i] as usize].map(|v| mesh.positions[v as usize]);
            let mut n = unit(cross(add(v[1], -1.0, v[0]), add(v[2], -1.0, v[0])));
            if dot(n, *d) > 0.0 {
                n = n.map(|x| -x);
            }
            let p = add(add(*o, hits.t[i], *d), 1e-5, n);
            let [corner, a, b] = mesh.light;
            let to_light = add(add(add(corner, random.unit(), a), random.unit(), b), -1.0, p);
            if dot(to_light, n) > 0.0 {
                shadow.push((p, to_light, 0.999));
            }
            let (z, phi) = (2.0 * random.unit() - 1.0, std::f32::consts::TAU * random.unit());
            let r = (1.0 - z * z).sqrt();
            next.push((p, unit(add(n, 0.9999, [r * phi.cos(), r * phi.sin(), z])), f32::INFINITY));
        }
        // Bounce n leaves the n-th hit; the shadow rays beside it go from there towards the light.
        if bounce != 2 {
            sets.push(set(if bounce == 1 { "shadow" } else { "shadow 3" }, &shadow));
            sets.push(set(if bounce == 1 { "bounce 1" } else { "bounce 3" }, &next));
        }
        list = next;
    }
    sets
}
