//! The oracle, scenes and rays of the traversal tests.
//!
//! The oracle is plain scalar code over all triangles, written from the description in `src/bvh/walks/triangle.rs`; it shares
//! nothing with the crate's walks.

use octray::internal::bvh::Bvh;
use octray::internal::bvh::precise::{PRECISE, SHARED_EDGES};
use octray::internal::bvh::ray::NO_HIT;
use std::f32::consts::PI;

#[derive(Clone, Copy)]
pub struct Ray {
    pub o: [f32; 3],
    pub d: [f32; 3],
    pub tmin: f32,
    pub tmax: f32,
}

/// (t, id, u, v)
pub type Hit = (f32, u32, f32, f32);

pub fn hit_triangle(ray: &Ray, v: [[f32; 3]; 3], class: u8) -> Option<(f32, f32, f32)> {
    let counts = |t: f32| t > ray.tmin && t <= ray.tmax;
    if class & PRECISE != 0 {
        return hit_in_f64(ray, v, class).filter(|hit| counts(hit.0));
    }
    let m = ray.d.map(f32::abs);
    let kz = (0..3).find(|&k| (0..3).all(|other| m[k] >= m[other]))?;
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let (sx, sy, sz) = (ray.d[kx] / ray.d[kz], ray.d[ky] / ray.d[kz], 1.0 / ray.d[kz]);
    let corner = |p: [f32; 3]| {
        let p = [p[0] - ray.o[0], p[1] - ray.o[1], p[2] - ray.o[2]];
        (p[kx] - sx * p[kz], p[ky] - sy * p[kz], sz * p[kz])
    };
    let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (corner(v[0]), corner(v[1]), corner(v[2]));
    let e = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
    if e.iter().any(|&e| e < 0.0) && e.iter().any(|&e| e > 0.0) || e.iter().any(|e| e.is_nan()) {
        return None;
    }
    let det = (e[0] + e[1]) + e[2];
    let size = [ax, ay, bx, by, cx, cy].into_iter().fold(0.0, |m: f32, x| m.max(x.abs()));
    let mut t = ((e[0] * az + e[1] * bz) + e[2] * cz) / det;
    if det.abs() < (size * size) * (1.0 / 64.0) {
        if t <= ray.tmin {
            return None;
        }
        hit_in_f64(ray, v, SHARED_EDGES)?;
        let (first, last) = part_in_box(ray, v)?;
        if last < f64::from(ray.tmin) {
            return None;
        }
        let first = first as f32;
        t = if t < first { first } else { t };
    }
    (det != 0.0 && counts(t)).then_some((t, e[1] / det, e[2] / det))
}

/// As `src/bvh/precise.rs` describes it.
fn hit_in_f64(ray: &Ray, v: [[f32; 3]; 3], class: u8) -> Option<(f32, f32, f32)> {
    let m = ray.d.map(f32::abs);
    let kz = (0..3).find(|&k| (0..3).all(|other| m[k] >= m[other]))?;
    let axes = [(kz + 1) % 3, (kz + 2) % 3, kz];
    let d = axes.map(|k| ray.d[k] as f64);
    let raw = v.map(|p| axes.map(|k| p[k] as f64 - ray.o[k] as f64));
    let p = raw.map(|[x, y, z]| [x - d[0] / d[2] * z, y - d[1] / d[2] * z, z]);
    let cross = |a: [f64; 3], b: [f64; 3]| a[0] * b[1] - a[1] * b[0];
    let mut e = [cross(p[2], p[1]), cross(p[0], p[2]), cross(p[1], p[0])];
    if e[0] + e[1] + e[2] < 0.0 {
        e = e.map(|e| -e);
    }
    let size = p.map(|p| p[0].abs() + p[1].abs());
    let moved = raw.map(|r| [0, 1].map(|k| (r[k].abs() + (d[k] / d[2] * r[2]).abs()) / 2f64.powi(22)));
    for (i, &edge) in e.iter().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let room = (moved[j][0] * p[k][1].abs() + moved[j][1] * p[k][0].abs())
            + (moved[k][0] * p[j][1].abs() + moved[k][1] * p[j][0].abs());
        if edge < -room && class >> i & 1 == 1 || edge < 0.0 && class >> i & 1 == 0 {
            return None;
        }
    }
    let (first, last) = part_in_box(ray, v)?;
    let e = e.map(|e| if e > 0.0 { e } else { 0.0 });
    let det = e[0] + e[1] + e[2];
    let largest = size.into_iter().fold(0.0, f64::max);
    let [a, b, c] = v.map(|p| p.map(f64::from));
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let (f, g) = (minus(b, a), minus(c, a));
    let n = [f[1] * g[2] - f[2] * g[1], f[2] * g[0] - f[0] * g[2], f[0] * g[1] - f[1] * g[0]];
    let from = [a, b, c].map(|p| minus(p, ray.o.map(f64::from)));
    let nearest = from.into_iter().min_by(|p, q| dot(*p, *p).total_cmp(&dot(*q, *q)))?;
    let t = dot(n, nearest) / dot(n, ray.d.map(f64::from));
    let t = if t < first {
        first
    } else if t > last {
        last
    } else {
        t
    } as f32;
    (det > largest * largest / 2f64.powi(36) && t.is_finite()).then_some((t, (e[1] / det) as f32, (e[2] / det) as f32))
}

/// Where a ray enters and leaves the widened box of a triangle.
fn part_in_box(ray: &Ray, v: [[f32; 3]; 3]) -> Option<(f64, f64)> {
    let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
    let [p0, p1, p2] = v.map(|p| p.map(f64::from));
    for k in 0..3 {
        let (low, high) = (p0[k].min(p1[k]).min(p2[k]), p0[k].max(p1[k]).max(p2[k]));
        let (o, wide) = (ray.o[k] as f64, ((ray.o[k] as f64).abs() + low.abs().max(high.abs())) / 2f64.powi(23));
        let ends = [(low - wide - o) / ray.d[k] as f64, (high + wide - o) / ray.d[k] as f64];
        first = first.max(ends[0].min(ends[1]));
        last = last.min(ends[0].max(ends[1]));
    }
    (first <= last).then_some((first, last))
}

pub struct Scene {
    pub name: String,
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Scene {
    pub fn new(name: &str, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { name: name.into(), positions, triangles }
    }
    pub fn bvh(&self) -> Bvh {
        let bvh = Bvh::build(&self.positions, &self.triangles, |_| true);
        bvh.validate().unwrap_or_else(|e| panic!("{}: {e}", self.name));
        bvh
    }
    pub fn corners(&self, id: usize) -> [[f32; 3]; 3] {
        self.triangles[id].map(|v| self.positions[v as usize])
    }
    pub fn brute_force(&self, bvh: &Bvh, ray: &Ray) -> Hit {
        let hits = (0..self.triangles.len()).filter_map(|id| {
            let (t, u, v) = hit_triangle(ray, self.corners(id), bvh.class(id as u32))?;
            Some((t, id as u32, u, v))
        });
        hits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).unwrap_or((ray.tmax, NO_HIT, 0.0, 0.0))
    }
    pub fn transformed(&self, name: &str, f: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        Self::new(name, self.positions.iter().map(|&p| f(p)).collect(), self.triangles.clone())
    }
}

pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = (self.0 >> 32) as u32 ^ (self.0 >> 50) as u32;
        x.wrapping_mul(0x9e37_79b1) ^ (x >> 15)
    }
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }
    pub fn below(&mut self, n: usize) -> usize {
        self.bits() as usize % n
    }
    pub fn point(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.unit() * 2.0 - 1.0)
    }
}

pub fn soup(count: usize, size: f32, seed: u64) -> Scene {
    let mut random = Random(seed);
    let mut positions = vec![];
    for _ in 0..count {
        let centre = random.point();
        for _ in 0..3 {
            let offset = random.point();
            positions.push([0, 1, 2].map(|k| centre[k] + size * offset[k]));
        }
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Scene::new(&format!("soup of {count}"), positions, triangles)
}

/// A closed box of quads, each face n by n, in [-1, 1]^3: many vertices and edges lie in box planes.
pub fn cube(n: u32) -> Scene {
    let (mut positions, mut triangles) = (vec![], vec![]);
    for face in 0..6usize {
        let base = positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let (a, b) = (i as f32 / n as f32 * 2.0 - 1.0, j as f32 / n as f32 * 2.0 - 1.0);
                let mut p = [0.0; 3];
                p[face / 2] = if face % 2 == 0 { -1.0 } else { 1.0 };
                p[(face / 2 + 1) % 3] = a;
                p[(face / 2 + 2) % 3] = b;
                positions.push(p);
            }
        }
        for i in 0..n {
            for j in 0..n {
                let at = base + i * (n + 1) + j;
                triangles.extend([[at, at + n + 1, at + 1], [at + 1, at + n + 1, at + n + 2]]);
            }
        }
    }
    Scene::new(&format!("cube of {}", triangles.len()), positions, triangles)
}

/// A closed, bumpy sphere.
pub fn sphere(rings: u32, sectors: u32) -> Scene {
    let (mut positions, mut triangles) = (vec![], vec![]);
    for i in 0..=rings {
        for j in 0..sectors {
            let (theta, phi) = (i as f32 / rings as f32 * PI, j as f32 / sectors as f32 * (2.0 * PI));
            let r = 1.0 + 0.1 * (5.0 * theta).sin() * (7.0 * phi).cos();
            let s = if i == 0 || i == rings { 0.0 } else { theta.sin() };
            positions.push([r * s * phi.cos(), r * theta.cos(), r * s * phi.sin()]);
        }
    }
    // One vertex a pole: copies of it would differ in r.
    for i in 0..rings {
        for j in 0..sectors {
            let (next, at) =
                ((j + 1) % sectors, |i: u32, j: u32| i * sectors + if i == 0 || i == rings { 0 } else { j });
            let (a, b, c, d) = (at(i, j), at(i, next), at(i + 1, j), at(i + 1, next));
            if a != b {
                triangles.push([a, c, b]);
            }
            if c != d {
                triangles.push([b, c, d]);
            }
        }
    }
    Scene::new(&format!("sphere of {}", triangles.len()), positions, triangles)
}

pub fn heightfield(n: u32) -> Scene {
    let mut random = Random(9);
    let mut scene = cube(n);
    let per_face = ((n + 1) * (n + 1)) as usize;
    scene.positions.truncate(per_face);
    scene.triangles.truncate((2 * n * n) as usize);
    for p in &mut scene.positions {
        p[0] = random.unit() * 0.3;
    }
    scene.name = format!("heightfield of {}", scene.triangles.len());
    scene
}

/// A room with two boxes, as small as a Cornell box.
pub fn room() -> Scene {
    let mut scene = cube(1);
    for (centre, half) in [([0.3, -0.7, 0.2], 0.3), ([-0.4, -0.4, -0.3], 0.25), ([0.0, 0.99, 0.0], 0.2)] {
        let inner = cube(1);
        let base = scene.positions.len() as u32;
        scene.positions.extend(inner.positions.iter().map(|p| [0, 1, 2].map(|k| centre[k] + half * p[k])));
        scene.triangles.extend(inner.triangles.iter().map(|t| t.map(|v| v + base)));
    }
    scene.name = "room".into();
    scene
}

/// Needles and long strips of every aspect up to `10^most`, crossed, side by side with triangles of ordinary shape.
pub fn slivers(count: usize, most: i32, seed: u64) -> Scene {
    let mut random = Random(seed);
    let (mut positions, mut triangles) = (vec![], vec![]);
    for i in 0..count {
        let height = 10f32.powi(-(random.below(most as usize + 1) as i32));
        let (a, along, across) = (random.point(), random.point(), random.point());
        let b = [0, 1, 2].map(|k| a[k] + along[k]);
        let c = [0, 1, 2].map(|k| a[k] + 0.5 * along[k] + height * across[k]);
        let d = [0, 1, 2].map(|k| c[k] + along[k]);
        let first = positions.len() as u32;
        positions.extend([a, b, c, d]);
        triangles.push([first, first + 1, first + 2]);
        // Some are strips: pairs that share their long edge.
        if i % 2 == 0 {
            triangles.push([first + 2, first + 1, first + 3]);
        }
    }
    Scene::new(&format!("slivers to 1e{most}"), positions, triangles)
}

/// A closed box of `size` along the axes, its long sides slivers, turned about an axis by `angle`.
pub fn corridor(size: [f32; 3], angle: f32) -> Scene {
    let (s, c) = angle.sin_cos();
    cube(1).transformed(&format!("corridor {size:?} turned by {angle}"), |p| {
        let [x, y, z] = [0, 1, 2].map(|k| p[k] * size[k]);
        [c * x + s * z, y, c * z - s * x]
    })
}

/// Rays of every nasty sort: random, axis-parallel, in planes of boxes, at vertices and edges, with +-0, short and long.
pub fn rays(scene: &Scene, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for p in &scene.positions {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
        }
    }
    if scene.positions.is_empty() {
        (low, high) = ([-1.0; 3], [1.0; 3]);
    }
    let size = (0..3).map(|k| high[k] - low[k]).fold(1e-30, f32::max);
    let mut list = vec![];
    for i in 0..count {
        let p = random.point();
        let mut o = [0, 1, 2].map(|k| (low[k] + high[k]) * 0.5 + size * 0.7 * p[k]);
        let mut d = random.point();
        let (mut tmin, mut tmax) = (0.0, f32::INFINITY);
        let vertices: [[f32; 3]; 3] = match scene.triangles.len() {
            0 => [[0.0; 3]; 3],
            n => scene.corners(random.below(n)),
        };
        let target = |random: &mut Random| match random.below(3) {
            0 => vertices[0],
            1 => [0, 1, 2].map(|k| (vertices[0][k] + vertices[1][k]) * 0.5),
            _ => [0, 1, 2].map(|k| vertices[0][k] + (vertices[2][k] - vertices[0][k]) * (1.0 / 3.0)),
        };
        match i % 9 {
            0 | 1 => {}
            2 => {
                // Shadow-like: the direction reaches the target, tmax just below.
                let target = target(&mut random);
                d = [0, 1, 2].map(|k| target[k] - o[k]);
                tmax = if i % 16 == 2 { 1.0 - 1.0 / 4096.0 } else { 1.0 };
            }
            3 => {
                let target = target(&mut random);
                d = [0, 1, 2].map(|k| target[k] - o[k]);
            }
            4 => {
                // Parallel to an axis, through a vertex or beside one.
                let axis = random.below(3);
                let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
                let zero = if random.below(2) == 0 { 0.0 } else { -0.0 };
                d = [zero; 3];
                d[axis] = sign * 10f32.powi(random.below(7) as i32 - 3);
                for k in 0..3 {
                    if k != axis && random.below(2) == 0 {
                        o[k] = vertices[0][k];
                    }
                }
            }
            5 => {
                // In a plane of a box.
                let axis = random.below(3);
                d[axis] = if random.below(2) == 0 { 0.0 } else { -0.0 };
                o[axis] = vertices[random.below(3)][axis];
            }
            6 => {
                o = vertices[random.below(3)];
                if random.below(2) == 0 {
                    let target = scene.positions.get(random.below(scene.positions.len().max(1)));
                    let target = *target.unwrap_or(&[1.0; 3]);
                    d = [0, 1, 2].map(|k| target[k] - o[k]);
                }
            }
            7 => {
                // In the plane of a triangle, as far as f32 goes, through it or past it.
                let within = |random: &mut Random, reach: f32| {
                    let (u, v) = ((random.unit() * 2.0 - 0.5) * reach, (random.unit() * 2.0 - 0.5) * reach);
                    [0, 1, 2].map(|k| {
                        let [a, b, c] = vertices.map(|vertex| vertex[k]);
                        a + u * (b - a) + v * (c - a)
                    })
                };
                let reach = 10f32.powi(random.below(4) as i32);
                o = within(&mut random, reach);
                let target = within(&mut random, 1.0);
                d = [0, 1, 2].map(|k| target[k] - o[k]);
            }
            _ => {
                tmin = size * random.unit() * 0.5;
                tmax = tmin + size * random.unit();
                let stretch = 10f32.powi(random.below(13) as i32 - 6);
                d = d.map(|x| x * stretch);
                (tmin, tmax) = (tmin / stretch, tmax / stretch);
            }
        }
        if d == [0.0; 3] {
            d = [0.0, 0.0, -1.0];
        }
        list.push(Ray { o, d, tmin, tmax });
    }
    list
}
