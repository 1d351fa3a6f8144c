//! Every walk against brute force, bit for bit.
//!
//! The oracle below is plain scalar code over all triangles, written from the description in `src/bvh/triangle.rs`; it
//! shares nothing with the crate but the tables of rays and hits.

use octray::bvh::ray::NO_HIT;
use octray::bvh::{BuildOptions, Bvh, HitQueue, RayKind, RayPacket, RayQueue, Scratch, WalkCounters};
use octray::lanes::{F32x8, Mask8, Vec3x8};
use std::f32::consts::PI;
use std::time::{Duration, Instant};

// ---- oracle ----

#[derive(Clone, Copy)]
struct Ray {
    o: [f32; 3],
    d: [f32; 3],
    tmin: f32,
    tmax: f32,
}

/// (t, id, u, v)
type Hit = (f32, u32, f32, f32);

fn hit_triangle(ray: &Ray, v: [[f32; 3]; 3]) -> Option<(f32, f32, f32)> {
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
    let t = ((e[0] * az + e[1] * bz) + e[2] * cz) / det;
    (det != 0.0 && t > ray.tmin && t <= ray.tmax).then_some((t, e[1] / det, e[2] / det))
}

struct Scene {
    name: String,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Scene {
    fn new(name: &str, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { name: name.into(), positions, triangles }
    }
    fn bvh(&self) -> Bvh {
        let bvh = Bvh::build(&self.positions, &self.triangles, |_| true);
        bvh.validate().unwrap_or_else(|e| panic!("{}: {e}", self.name));
        bvh
    }
    fn corners(&self, id: usize) -> [[f32; 3]; 3] {
        self.triangles[id].map(|v| self.positions[v as usize])
    }
    fn brute_force(&self, ray: &Ray) -> Hit {
        let hits = (0..self.triangles.len()).filter_map(|id| {
            let (t, u, v) = hit_triangle(ray, self.corners(id))?;
            Some((t, id as u32, u, v))
        });
        hits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).unwrap_or((ray.tmax, NO_HIT, 0.0, 0.0))
    }
    fn transformed(&self, name: &str, f: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        Self::new(name, self.positions.iter().map(|&p| f(p)).collect(), self.triangles.clone())
    }
}

// ---- generators ----

struct Random(u64);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = (self.0 >> 32) as u32 ^ (self.0 >> 50) as u32;
        x.wrapping_mul(0x9e37_79b1) ^ (x >> 15)
    }
    fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }
    fn below(&mut self, n: usize) -> usize {
        self.bits() as usize % n
    }
    fn point(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.unit() * 2.0 - 1.0)
    }
}

fn soup(count: usize, size: f32, seed: u64) -> Scene {
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
fn cube(n: u32) -> Scene {
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
fn sphere(rings: u32, sectors: u32) -> Scene {
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

fn heightfield(n: u32) -> Scene {
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
fn room() -> Scene {
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

/// Rays of every nasty sort: random, axis-parallel, in planes of boxes, at vertices and edges, with +-0, short and long.
fn rays(scene: &Scene, count: usize, seed: u64) -> Vec<Ray> {
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
        match i % 8 {
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

fn queue(rays: &[Ray]) -> RayQueue {
    let mut queue = RayQueue::with_len(rays.len());
    for (i, ray) in rays.iter().enumerate() {
        ([queue.ox[i], queue.oy[i], queue.oz[i]], [queue.dx[i], queue.dy[i], queue.dz[i]]) = (ray.o, ray.d);
        (queue.tmin[i], queue.tmax[i]) = (ray.tmin, ray.tmax);
    }
    queue
}

fn row(hits: &HitQueue, i: usize) -> Hit {
    (hits.t[i], hits.triangle[i], hits.u[i], hits.v[i])
}

fn bits(hit: Hit) -> (u32, u32, u32, u32) {
    (hit.0.to_bits(), hit.1, hit.2.to_bits(), hit.3.to_bits())
}

/// Every walk, queue and stream call, closest and any hit, must say what `expected` says.
fn check_walks(name: &str, bvh: &Bvh, rays: &[Ray], expected: &[Hit]) {
    let queue = queue(rays);
    let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
    let mut answers: Vec<(String, HitQueue, Vec<u8>)> = vec![];
    for walk in bvh.walks() {
        let (mut hits, mut blocked) = (HitQueue::with_len(rays.len()), vec![]);
        bvh.intersect_by(walk, &queue, 0..rays.len(), &mut hits, &mut scratch, &mut counters);
        bvh.occluded_by(walk, &queue, 0..rays.len(), &mut blocked, &mut scratch, &mut counters);
        answers.push((format!("{walk:?}"), hits, blocked));
    }
    for kind in [RayKind::Camera, RayKind::Shadow, RayKind::Bounce] {
        let (mut hits, mut blocked) = (HitQueue::with_len(rays.len()), vec![]);
        bvh.intersect_queue(kind, &queue, 0..rays.len(), &mut hits, &mut scratch, &mut counters);
        bvh.occluded_queue(kind, &queue, 0..rays.len(), &mut blocked, &mut scratch, &mut counters);
        answers.push((format!("{kind:?}"), hits, blocked));
    }
    let (mut hits, mut blocked) = (HitQueue::default(), vec![]);
    bvh.intersect_stream(&queue, rays.len(), &mut hits);
    bvh.occluded_stream(&queue, rays.len(), &mut blocked);
    answers.push(("stream call".into(), hits, blocked));
    for (walk, hits, blocked) in &answers {
        let mut wrong = 0;
        for (i, &hit) in expected.iter().enumerate() {
            if bits(row(hits, i)) != bits(hit) || (blocked[i / 8] >> (i % 8) & 1 == 1) != (hit.1 != NO_HIT) {
                wrong += 1;
                if wrong <= 3 {
                    let blocked = blocked[i / 8] >> (i % 8) & 1;
                    let Ray { o, d, tmin, tmax } = rays[i];
                    eprintln!("{name}, {walk}: ray {i} {o:?} {d:?} {tmin} {tmax}");
                    eprintln!("  says {:?}, blocked {blocked}; truth {hit:?}", row(hits, i));
                }
            }
        }
        assert_eq!(wrong, 0, "{name}, {walk}: wrong rays of {}", rays.len());
    }
}

fn check(scene: &Scene, count: usize) {
    let bvh = scene.bvh();
    let rays = rays(scene, count, 77);
    let expected: Vec<Hit> = rays.iter().map(|ray| scene.brute_force(ray)).collect();
    check_walks(&scene.name, &bvh, &rays, &expected);
}

// ---- tests ----

#[test]
fn small_scenes_of_every_size() {
    for count in 0..=20 {
        check(&soup(count, 0.5, count as u64), 400);
    }
    for count in [31, 32, 33, 63, 64, 65, 100, 127, 128, 129, 200, 255, 256, 257] {
        check(&soup(count, 0.3, count as u64), 800);
    }
    check(&room(), 20_000);
}

#[test]
fn soups() {
    check(&soup(2_000, 0.1, 1), 6_000);
    check(&soup(300, 2.0, 2), 6_000);
    check(&soup(5_000, 0.02, 3), 3_000);
}

#[test]
fn grids_and_closed_meshes() {
    check(&cube(1), 20_000);
    check(&cube(4), 20_000);
    check(&cube(12), 8_000);
    check(&heightfield(40), 6_000);
    check(&sphere(30, 40), 8_000);
}

#[test]
fn huge_tiny_and_far_scenes() {
    for scene in [room(), sphere(16, 20), soup(500, 0.1, 4)] {
        for scale in [1e6f32, 1e-6, 3.7e4, 1e-3] {
            check(&scene.transformed(&format!("{} x {scale}", scene.name), |p| p.map(|x| x * scale)), 4_000);
        }
        for far in [1e2f32, 2e3, 1e5] {
            let name = format!("{} at {far}", scene.name);
            check(&scene.transformed(&name, |p| [p[0] + far, p[1] - 0.5 * far, p[2] + 0.1 * far]), 4_000);
        }
    }
}

#[test]
fn degenerate_trees() {
    let mut copies = soup(1, 0.5, 5);
    copies.triangles = vec![copies.triangles[0]; 300];
    copies.name = "300 copies".into();
    check(&copies, 2_000);
    // All in a line, along an axis and not; the second one thinner and thinner.
    for direction in [[1.0f32, 0.0, 0.0], [0.3, 0.5, -0.8]] {
        let mut line = Scene::new("line", vec![], vec![]);
        for i in 0..500u32 {
            let at = |s: f32| direction.map(|x| x * s);
            let s = i as f32 * 0.01;
            // Not all in one plane: see the limit in `src/bvh/triangle.rs`.
            let turn = [(i as f32).sin(), (i as f32).cos(), (2.0 * i as f32).sin()];
            line.positions.extend([at(s), at(s + 0.01), [0, 1, 2].map(|k| at(s)[k] + 0.05 * turn[k])]);
            line.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        check(&line, 2_000);
    }
    // Sizes growing from 2^-8 to 2^8: splits peel off a few triangles at a time.
    let mut spiral = Scene::new("spiral", vec![], vec![]);
    for i in 0..100u32 {
        let s = 2f32.powf(i as f32 * 0.16 - 8.0);
        spiral.positions.extend([[s, 0.0, 0.0], [0.0, s, 0.0], [s, s, s]]);
        spiral.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    check(&spiral, 2_000);
    // No triangle has an area.
    let mut flat = soup(50, 0.5, 6);
    for triangle in &mut flat.triangles {
        triangle[2] = triangle[1];
    }
    flat.name = "no area".into();
    check(&flat, 500);
}

#[test]
fn coincident_triangles_build_fast_and_shallow() {
    let mut scene = soup(1, 0.5, 5);
    scene.triangles = vec![scene.triangles[0]; 100_000];
    let start = Instant::now();
    let bvh = Bvh::build(&scene.positions, &scene.triangles, |_| true);
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    bvh.validate().unwrap();
    assert!(bvh.depth() < 30, "depth {}", bvh.depth());
    let c = scene.corners(0);
    let centre = [0, 1, 2].map(|k| (c[0][k] + c[1][k] + c[2][k]) / 3.0);
    let ray = Ray { o: [centre[0], centre[1], 5.0], d: [0.0, 0.0, -1.0], tmin: 0.0, tmax: f32::INFINITY };
    let (t, u, v) = hit_triangle(&ray, c).unwrap();
    check_walks("1e5 copies", &bvh, &[ray], &[(t, 0, u, v)]);
}

#[test]
fn triangles_left_out_are_never_hit_and_ids_stay() {
    let scene = soup(600, 0.3, 8);
    let include = |id: u32| !id.is_multiple_of(3);
    let bvh = Bvh::build(&scene.positions, &scene.triangles, include);
    bvh.validate().unwrap();
    assert_eq!(bvh.triangle_count(), 400);
    let mut without = soup(600, 0.3, 8);
    for id in (0..600).step_by(3) {
        // A triangle at one point is never hit.
        without.triangles[id] = [0; 3];
    }
    let rays = rays(&scene, 4_000, 3);
    let expected: Vec<Hit> = rays.iter().map(|ray| without.brute_force(ray)).collect();
    check_walks("left out", &bvh, &rays, &expected);
}

#[test]
fn every_leaf_size_gives_the_same_bits() {
    let scene = sphere(12, 16);
    let rays = rays(&scene, 2_000, 4);
    let expected: Vec<Hit> = rays.iter().map(|ray| scene.brute_force(ray)).collect();
    for leaf_size in 1..=8 {
        let bvh = Bvh::build_with(&scene.positions, &scene.triangles, |_| true, BuildOptions { leaf_size });
        bvh.validate().unwrap();
        check_walks(&format!("leaves of {leaf_size}"), &bvh, &rays, &expected);
    }
}

#[test]
fn nothing_leaks_out_of_closed_meshes() {
    for scene in [sphere(60, 80), cube(20)] {
        let bvh = scene.bvh();
        let mut random = Random(11);
        let mut list = vec![];
        for _ in 0..40_000 {
            let p = random.point();
            let o = p.map(|x| x * 0.3);
            let c = scene.corners(random.below(scene.triangles.len()));
            let s = [0.0, 0.5, 1.0 / 3.0, random.unit()][random.below(4)];
            let target = [0, 1, 2].map(|k| c[0][k] + s * (c[1][k] - c[0][k]));
            list.push(Ray { o, d: [0, 1, 2].map(|k| target[k] - o[k]), tmin: 0.0, tmax: f32::INFINITY });
        }
        let queue = queue(&list);
        let mut first: Option<HitQueue> = None;
        for walk in bvh.walks() {
            let (mut hits, mut blocked) = (HitQueue::with_len(list.len()), vec![]);
            let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
            bvh.intersect_by(walk, &queue, 0..list.len(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_by(walk, &queue, 0..list.len(), &mut blocked, &mut scratch, &mut counters);
            for i in 0..list.len() {
                assert_ne!(hits.triangle[i], NO_HIT, "{}: {walk:?} leaks {:?} {:?}", scene.name, list[i].o, list[i].d);
                assert_eq!(blocked[i / 8] >> (i % 8) & 1, 1, "{}: {walk:?} leaks", scene.name);
                if let Some(first) = &first {
                    assert_eq!(bits(row(&hits, i)), bits(row(first, i)), "{}: {walk:?}, ray {i}", scene.name);
                }
            }
            first = Some(hits);
        }
    }
}

fn packet(rays: &[Ray]) -> RayPacket {
    queue(rays).packet(0)
}

#[test]
fn all_masks_with_poisoned_idle_lanes() {
    for scene in [room(), soup(500, 0.2, 12)] {
        let bvh = scene.bvh();
        let list = rays(&scene, 8 * 256, 13);
        for (mask, eight) in list.chunks(8).enumerate() {
            let active = Mask8::from_bits(mask as u8);
            let whole = packet(eight);
            let expected: Vec<Hit> = eight.iter().map(|ray| scene.brute_force(ray)).collect();
            for poison in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, 1e38] {
                let dirty = |v: F32x8| active.select(v, F32x8::splat(poison));
                let dirty3 = |v: Vec3x8| Vec3x8::new(dirty(v.x), dirty(v.y), dirty(v.z));
                let rays = RayPacket {
                    origin: dirty3(whole.origin),
                    direction: dirty3(whole.direction),
                    tmin: dirty(whole.tmin),
                    tmax: dirty(whole.tmax),
                };
                let hits = bvh.intersect(&rays, active);
                let blocked = bvh.occluded(&rays, active).bits();
                let (t, id, u, v) = (hits.t.to_array(), hits.triangle.to_array(), hits.u.to_array(), hits.v.to_array());
                for lane in 0..8 {
                    let got = (t[lane], id[lane], u[lane], v[lane]);
                    if mask >> lane & 1 == 1 {
                        assert_eq!(bits(got), bits(expected[lane]), "{} mask {mask:08b} lane {lane}", scene.name);
                        assert_eq!(blocked >> lane & 1 == 1, got.1 != NO_HIT);
                    } else {
                        assert_eq!((id[lane], u[lane], v[lane]), (NO_HIT, 0.0, 0.0), "mask {mask:08b} lane {lane}");
                        assert_eq!(t[lane].to_bits(), poison.to_bits());
                        assert_eq!(blocked >> lane & 1, 0);
                    }
                }
            }
        }
    }
}

#[test]
fn rays_of_nonsense_end_and_spoil_no_neighbour() {
    let values = [0.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-45];
    let mut random = Random(14);
    for scene in [room(), soup(3_000, 0.1, 15), soup(0, 1.0, 0)] {
        let bvh = scene.bvh();
        let mut list = rays(&scene, 4_000, 18);
        let good: Vec<bool> = list.iter().map(|_| random.below(2) == 0).collect();
        for (ray, _) in list.iter_mut().zip(&good).filter(|(_, good)| !**good) {
            let mut pick = || if random.below(2) == 0 { values[random.below(8)] } else { random.unit() };
            *ray = Ray { o: [pick(), pick(), pick()], d: [pick(), pick(), pick()], tmin: pick(), tmax: pick() };
        }
        let queue = queue(&list);
        let expected: Vec<Hit> = list.iter().map(|ray| scene.brute_force(ray)).collect();
        for walk in bvh.walks() {
            let (mut hits, mut blocked) = (HitQueue::with_len(list.len()), vec![]);
            let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
            bvh.intersect_by(walk, &queue, 0..list.len(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_by(walk, &queue, 0..list.len(), &mut blocked, &mut scratch, &mut counters);
            for (i, ray) in list.iter().enumerate() {
                let numbers = ray.o.iter().chain(&ray.d).all(|x| x.is_finite())
                    && ![ray.tmin, ray.tmax].iter().any(|x| x.is_nan());
                if good[i] {
                    assert_eq!(bits(row(&hits, i)), bits(expected[i]), "{} {walk:?} ray {i}", scene.name);
                } else if !numbers {
                    assert_eq!((hits.triangle[i], hits.t[i].to_bits()), (NO_HIT, ray.tmax.to_bits()), "{walk:?}");
                    assert_eq!(blocked[i / 8] >> (i % 8) & 1, 0, "{walk:?}");
                }
            }
        }
    }
}

#[test]
fn real_meshes() {
    for file in ["cornell/CornellBox-Original.obj", "meshes/suzanne.obj", "meshes/teapot.obj"] {
        let path = std::path::Path::new("../shared/scenes/obj").join(file);
        let Ok(text) = std::fs::read_to_string(&path) else {
            eprintln!("skipped: {} is not there", path.display());
            continue;
        };
        let mut scene = Scene::new(file, vec![], vec![]);
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            if words.first() == Some(&"v") {
                scene.positions.push([1, 2, 3].map(|k| words[k].parse().unwrap()));
            } else if words.first() == Some(&"f") {
                let count = scene.positions.len() as i64;
                let index = |word: &&str| {
                    let i: i64 = word.split('/').next().unwrap().parse().unwrap();
                    if i < 0 { (count + i) as u32 } else { i as u32 - 1 }
                };
                let corners: Vec<u32> = words[1..].iter().map(index).collect();
                scene.triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
            }
        }
        check(&scene, if scene.triangles.len() < 100 { 20_000 } else { 4_000 });
    }
}

#[test]
fn ranges_of_queues_touch_only_their_rows() {
    let scene = soup(800, 0.2, 16);
    let bvh = scene.bvh();
    let list = rays(&scene, 1_000, 17);
    let queue = queue(&list);
    let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
    for walk in bvh.walks() {
        let mut whole = HitQueue::with_len(list.len());
        let mut blocked = vec![];
        bvh.intersect_by(walk, &queue, 0..list.len(), &mut whole, &mut scratch, &mut counters);
        bvh.occluded_by(walk, &queue, 0..list.len(), &mut blocked, &mut scratch, &mut counters);
        for range in [0..0, 0..1, 8..9, 16..31, 64..64 + 257, 504..1_000] {
            let mut hits = HitQueue::with_len(list.len());
            hits.t.fill(-7.0);
            let mut some = vec![0xa5; 126];
            bvh.intersect_by(walk, &queue, range.clone(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_by(walk, &queue, range.clone(), &mut some, &mut scratch, &mut counters);
            for i in 0..list.len() {
                if range.contains(&i) {
                    assert_eq!(bits(row(&hits, i)), bits(row(&whole, i)), "{walk:?}, {range:?}");
                    assert_eq!(some[i / 8] >> (i % 8) & 1, blocked[i / 8] >> (i % 8) & 1, "{walk:?}, {range:?}");
                } else if i < range.start || i >= range.end.next_multiple_of(8) {
                    assert_eq!(hits.t[i], -7.0, "{walk:?}, {range:?} wrote row {i}");
                    assert_eq!(some[i / 8], 0xa5, "{walk:?}, {range:?} wrote byte {}", i / 8);
                }
            }
        }
    }
}
