//! Rays shot at triangles: out of closed meshes, and off the triangles they leave.

use crate::bvh::precise::HUGE;
use crate::bvh::ray::{HitQueue, NO_HIT, RayQueue, WalkCounters};
use crate::bvh::{Scratch, Walk};
use crate::check::numbers::Numbers;
use crate::reference::{double, single};
use crate::tables::PreparedScene;
use glam::{DVec3, Vec3};

/// Rays shot at once.
const BATCH: usize = 256;

/// The corners of a triangle.
pub fn corners(scene: &PreparedScene, triangle: usize) -> [DVec3; 3] {
    scene.triangles[triangle].vertices.map(|vertex| DVec3::from(vertex.map(f64::from)))
}

/// A point on a triangle: a quarter of them anywhere, a quarter next to an edge, half next to a corner.
fn weights(numbers: &mut Numbers) -> [f64; 3] {
    let mut weights: [f64; 3] = std::array::from_fn(|_| numbers.fine());
    let (mode, corner, near) = (numbers.below(4), numbers.below(3) as usize, numbers.magnitude(-8.0, 0.0));
    for (k, weight) in weights.iter_mut().enumerate() {
        if mode >= 2 && k != corner || mode == 1 && k == corner {
            *weight *= near;
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

/// A direction about `normal`, half of the time within 1e-4 of the plane.
fn direction(numbers: &mut Numbers, normal: DVec3) -> DVec3 {
    let cosine = if numbers.below(2) == 0 { numbers.magnitude(-4.0, 0.0) } else { numbers.fine().sqrt().max(1e-4) };
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sine, cosine_of_turn) = (numbers.fine() * std::f64::consts::TAU).sin_cos();
    (tangent * cosine_of_turn + bitangent * sine) * (1.0 - cosine * cosine).max(0.0).sqrt() + normal * cosine
}

/// Rays from around `inside` at points of all triangles, most of them next to edges and corners, by every walk: how many hit
/// nothing.
pub fn misses_from_inside(scene: &PreparedScene, inside: DVec3, count: u64, seed: u32) -> u64 {
    let mut numbers = Numbers::new(seed);
    let (mut rays, mut hits) = (RayQueue::with_len(BATCH), HitQueue::with_len(BATCH));
    let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
    let mut misses = 0;
    for _ in 0..count.div_ceil(BATCH as u64) {
        for row in 0..BATCH {
            let target = numbers.below(scene.triangles.len() as u32) as usize;
            let [a, b, c] = corners(scene, target);
            let [u, v, w] = weights(&mut numbers);
            let aim = a * u + b * v + c * w;
            // Of a convex mesh every point between two of it is inside.
            let origin = inside + (aim - inside) * 0.5 * numbers.fine();
            let towards = (aim - origin).normalize();
            [rays.ox[row], rays.oy[row], rays.oz[row]] = origin.as_vec3().to_array();
            [rays.dx[row], rays.dy[row], rays.dz[row]] = towards.as_vec3().to_array();
        }
        for walk in scene.bvh.walks() {
            scene.bvh.intersect_by(walk, &rays, 0..BATCH, &mut hits, &mut scratch, &mut counters);
            misses += hits.triangle[..BATCH].iter().filter(|&&triangle| triangle == NO_HIT).count() as u64;
        }
    }
    misses
}

/// Rays by every walk: how many hits of the others have bits that differ from those of single rays. Aimed as in
/// [`misses_from_inside`], from anywhere around the scene.
pub fn walks_that_differ(scene: &PreparedScene, count: u64, seed: u32) -> u64 {
    let mut numbers = Numbers::new(seed);
    let mut rays = RayQueue::with_len(BATCH);
    let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
    let mut differ = 0;
    for _ in 0..count.div_ceil(BATCH as u64) {
        for row in 0..BATCH {
            let place = |numbers: &mut Numbers| {
                let triangle = numbers.below(scene.triangles.len() as u32) as usize;
                let ([a, b, c], [u, v, w]) = (corners(scene, triangle), weights(numbers));
                a * u + b * v + c * w
            };
            let (from, aim) = (place(&mut numbers), place(&mut numbers));
            let towards = if from == aim { DVec3::Y } else { aim - from };
            let origin = from - towards * [0.0, 0.3, 2.0][numbers.below(3) as usize];
            [rays.ox[row], rays.oy[row], rays.oz[row]] = origin.as_vec3().to_array();
            [rays.dx[row], rays.dy[row], rays.dz[row]] = towards.normalize().as_vec3().to_array();
        }
        let bits = |hits: &HitQueue, row: usize| {
            (hits.triangle[row], hits.t[row].to_bits(), hits.u[row].to_bits(), hits.v[row].to_bits())
        };
        let mut single = HitQueue::with_len(BATCH);
        scene.bvh.intersect_by(Walk::Single, &rays, 0..BATCH, &mut single, &mut scratch, &mut counters);
        for walk in scene.bvh.walks() {
            let mut hits = HitQueue::with_len(BATCH);
            scene.bvh.intersect_by(walk, &rays, 0..BATCH, &mut hits, &mut scratch, &mut counters);
            differ += (0..BATCH).filter(|&row| bits(&hits, row) != bits(&single, row)).count() as u64;
        }
    }
    differ
}

/// Rays that leave points of all triangles (most of them next to edges and corners, half of the rays grazing), as paths do: how
/// many hit again the triangle they have left, in f32 and in f64; and how many were shot.
pub fn self_hits(scene: &PreparedScene, count: u64, seed: u32) -> ([u64; 2], u64) {
    let mut numbers = Numbers::new(seed);
    let (mut stack32, mut stack64) = (single::intersect::stack(&scene.bvh), double::intersect::stack(&scene.bvh));
    let (mut hits, mut shot) = ([0; 2], 0);
    for _ in 0..count {
        let triangle = numbers.below(scene.triangles.len() as u32);
        let record = &scene.triangles[triangle as usize];
        let ([a, b, c], [p, q, r]) = (corners(scene, triangle as usize), weights(&mut numbers));
        let front = DVec3::from(record.normal.map(f64::from));
        let normal = if numbers.below(2) == 0 { front } else { -front };
        let direction = direction(&mut numbers, normal);
        if (b - a).cross(c - a) == DVec3::ZERO || (q as f32) + (r as f32) > 1.0 {
            continue;
        }
        shot += 1;
        let found = (scene.bvh.class(triangle) & HUGE != 0).then_some(a * p + b * q + c * r);
        let (narrow, weights) = (direction.as_vec3(), [q as f32, r as f32]);
        let found32 = found.map(|found| found.as_vec3());
        let at = single::surface::surface_point_on(record, None, found32, weights, -narrow);
        let ray = single::intersect::Ray { origin: at.origin, direction: narrow, tmin: 0.0, tmax: f32::INFINITY };
        let hit = single::intersect::intersect(&scene.bvh, &ray, &mut stack32);
        hits[0] += u64::from(hit.is_some_and(|hit| hit.triangle == triangle));
        let at = double::surface::surface_point_on(record, None, found, weights.map(f64::from), -direction);
        let ray = double::intersect::Ray { origin: at.origin, direction, tmin: 0.0, tmax: f64::INFINITY };
        let hit = double::intersect::intersect(&scene.bvh, &ray, &mut stack64);
        hits[1] += u64::from(hit.is_some_and(|hit| hit.triangle == triangle));
    }
    (hits, shot)
}

/// Rays that leave points of a closed mesh into what it encloses: how many find no way out of it, that is, have leaked; and how
/// many were shot. `inwards` tells the side of a triangle's front on which the inside lies: 1 or -1.
pub fn leaks_inwards(scene: &PreparedScene, inwards: &dyn Fn(u32) -> f64, count: u64, seed: u32) -> (u64, u64) {
    let mut numbers = Numbers::new(seed);
    let mut stack = single::intersect::stack(&scene.bvh);
    let (mut leaks, mut shot) = (0, 0);
    for _ in 0..count {
        let triangle = numbers.below(scene.triangles.len() as u32);
        let record = &scene.triangles[triangle as usize];
        let [a, b, c] = corners(scene, triangle as usize);
        let mut share: [f64; 3] = std::array::from_fn(|_| numbers.fine());
        let sum: f64 = share.iter().sum();
        share = share.map(|weight| weight / sum);
        let normal = DVec3::from(record.normal.map(f64::from)) * inwards(triangle);
        let direction: Vec3 = direction(&mut numbers, normal).as_vec3();
        if (b - a).cross(c - a) == DVec3::ZERO {
            continue;
        }
        shot += 1;
        let found =
            (scene.bvh.class(triangle) & HUGE != 0).then(|| (a * share[0] + b * share[1] + c * share[2]).as_vec3());
        let weights = [share[1] as f32, share[2] as f32];
        let at = single::surface::surface_point_on(record, None, found, weights, -direction);
        let ray = single::intersect::Ray { origin: at.origin, direction, tmin: 0.0, tmax: f32::INFINITY };
        leaks += u64::from(single::intersect::intersect(&scene.bvh, &ray, &mut stack).is_none());
    }
    (leaks, shot)
}
