//! Whether emitters see anything: emission is one-sided, so a mesh wound the other way shines into nothing.
//!
//! Rays leave the emitters, and surfaces look for them: a small surface before a huge lamp is missed by the first, a small lamp
//! before huge surfaces by the second.

use crate::bvh::{Bvh, RayPacket};
use crate::lanes::{F32x8, LANES, Mask8, Vec3x8};
use crate::math::sin_cos_turns;
use crate::sampler::{random_words, unit};
use crate::scene::desc::SceneDesc;
use crate::scene::flatten::Geometry;
use crate::tables::lights::emitters::Emitter;
use crate::tables::triangles::TriangleRecord;
use glam::{DVec3, Vec3};

/// Rays from the fronts of all emitters together, about; each emissive material has at least one packet of them.
const RAYS: usize = 4096;
/// Rays of one material, at most.
const RAYS_OF_ONE: usize = 256;
/// The part of a segment from a point to an emitter that is left out at either end: there it would meet the surfaces it joins.
const ENDS: f32 = 1e-3;
/// The cosine about an emitter's normal above which a point lies before it, not in its plane.
const LEAST_COSINE: f32 = 1e-3;

/// One warning for each emissive material whose fronts see neither a triangle nor the camera, as far as a few hundred
/// rays can tell. Of more than 512 emissive materials the first 512 are looked at.
pub fn warnings(
    desc: &SceneDesc,
    geometry: &Geometry<'_>,
    emitters: &[Emitter],
    triangles: &[TriangleRecord],
    bvh: &Bvh,
) -> Vec<String> {
    let mut by_material: Vec<Vec<u32>> = vec![Vec::new(); desc.materials.len()];
    for emitter in emitters.iter().filter(|emitter| !emitter.two_sided) {
        by_material[geometry.triangles[emitter.triangle as usize].material as usize].push(emitter.triangle);
    }
    let emissive = by_material.iter().filter(|triangles| !triangles.is_empty()).count();
    let rays = (RAYS / emissive.max(1)).clamp(LANES, RAYS_OF_ONE) / LANES * LANES;
    let looked_at = by_material.iter().enumerate().filter(|(_, triangles)| !triangles.is_empty()).take(RAYS / LANES);
    let camera = Vec3::from(desc.camera.eye().map(|x| x as f32));
    let sees_anything = |ids: &[u32]| {
        // Spread over all triangles of the material, whatever their number.
        let emitter = |ray: usize| ids[ray * ids.len() / rays];
        let start = |ray: usize| Start::new(triangles, emitter(ray), ray as u32);
        let seen_from = |ray: usize| {
            let [w0, w1, ..] = random_words(emitter(ray), ray as u32, u32::MAX, 1).map(unit);
            Start::between(&triangles[emitter(ray) as usize], point(&triangles[ray * triangles.len() / rays], w0, w1))
        };
        let seen_by_camera = |i: usize| Start::between(&triangles[emitter(i * rays / LANES) as usize], camera);
        let packets = || (0..rays).step_by(LANES);
        packets().any(|first| sees_anything(bvh, camera, &std::array::from_fn(|i| start(first + i))))
            || sees_a_point(bvh, &std::array::from_fn(seen_by_camera))
            || packets().any(|first| sees_a_point(bvh, &std::array::from_fn(|i| seen_from(first + i))))
    };
    let blind = looked_at.filter(|(_, ids)| !sees_anything(ids));
    let warning = |(material, _): (usize, _)| {
        let name = &desc.materials[material].name;
        format!(
            "the emitter `{name}` sees nothing: emission is one-sided and its fronts face neither a surface nor the \
             camera; flip the winding of its faces, or say `two_sided = true` under [material.{name}]"
        )
    };
    blind.map(warning).collect()
}

/// Whether any of eight rays from `starts` hits a triangle, or any of the points sees the camera.
fn sees_anything(bvh: &Bvh, camera: Vec3, starts: &[Start; LANES]) -> bool {
    if hits(bvh, starts, |start| start.direction, f32::INFINITY) != 0 {
        return true;
    }
    let in_front = |start: &Start| start.normal.dot(camera - start.origin) > 0.0;
    let blocked = hits(bvh, starts, |start| camera - start.origin, 1.0);
    (0..LANES).any(|lane| in_front(&starts[lane]) && blocked >> lane & 1 == 0)
}

/// Whether any of eight segments comes from a point before an emitter and nothing is in between.
fn sees_a_point(bvh: &Bvh, segments: &[Start; LANES]) -> bool {
    // Against the normal of the emitter; what lies in its plane is not before it.
    let in_front = |s: &Start| -s.normal.dot(s.direction) > s.least_height.max(LEAST_COSINE * s.direction.length());
    let blocked = hits(bvh, segments, |segment| segment.direction, 1.0 - 2.0 * ENDS);
    (0..LANES).any(|lane| in_front(&segments[lane]) && blocked >> lane & 1 == 0)
}

/// Which of eight rays from `starts` hit anything up to `tmax`.
fn hits(bvh: &Bvh, starts: &[Start; LANES], direction: impl Fn(&Start) -> Vec3, tmax: f32) -> u8 {
    let column = |of: &dyn Fn(&Start) -> f32| F32x8::from_array(std::array::from_fn(|lane| of(&starts[lane])));
    let columns =
        |of: &dyn Fn(&Start) -> Vec3| Vec3x8::new(column(&|s| of(s).x), column(&|s| of(s).y), column(&|s| of(s).z));
    let rays = RayPacket {
        origin: columns(&|start| start.origin),
        direction: columns(&direction),
        tmin: F32x8::ZERO,
        tmax: F32x8::splat(tmax),
    };
    bvh.occluded(&rays, Mask8::ALL).bits()
}

/// Where a ray leaves an emitter's front, or goes to it; `normal` is the emitter's.
struct Start {
    origin: Vec3,
    normal: Vec3,
    direction: Vec3,
    /// What rounding can make of a height over the emitter's plane, and more.
    least_height: f32,
}

impl Start {
    /// Ray number `ray`: a point uniform over the triangle, a direction by the cosine about its front normal. The
    /// address of its numbers is one that no camera sample has: these rays decide no picture.
    fn new(triangles: &[TriangleRecord], triangle: u32, ray: u32) -> Start {
        let record = &triangles[triangle as usize];
        let normal = Vec3::from(record.normal);
        let [w0, w1, w2, w3] = random_words(triangle, ray, u32::MAX, 0).map(unit);
        let position = point(record, w0, w1);
        // Ample: what a ray from a huge lamp jumps over by it, surfaces and the camera find.
        let size = record.vertices.map(|v| Vec3::from(v).abs().element_sum()).into_iter().fold(0.0, f32::max);
        let offset = (16.0 * size + record.offset.max(0.0)) * 0.5 * f32::EPSILON;
        let (sine, cosine) = sin_cos_turns(w3);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let direction = (tangent * cosine + bitangent * sine) * w2.sqrt() + normal * (1.0 - w2).sqrt();
        Start { origin: position + normal * offset, normal, direction, least_height: least_height(record) }
    }

    /// The segment from a point to the point of an emitter that is nearest to it, but for its ends ([`ENDS`]).
    fn between(emitter: &TriangleRecord, from: Vec3) -> Start {
        let direction = nearest_point(emitter.vertices.map(Vec3::from), from) - from;
        let normal = Vec3::from(emitter.normal);
        Start { origin: from + direction * ENDS, normal, direction, least_height: least_height(emitter) }
    }
}

/// From which height on a point lies above a triangle for certain. How far a huge lamp reaches along its own plane makes its
/// height no less certain: coordinates count by their axis' part of the normal.
fn least_height(record: &TriangleRecord) -> f32 {
    let [a, b, c] = record.vertices.map(|v| Vec3::from(v).abs());
    let size = (a.max(b).max(c) * Vec3::from(record.normal).abs()).element_sum();
    (16.0 * size + record.offset.max(0.0)) * 0.5 * f32::EPSILON
}

/// The point of a triangle for two numbers in [0, 1), uniform over it.
fn point(record: &TriangleRecord, u0: f32, u1: f32) -> Vec3 {
    let [a, b, c] = record.vertices.map(Vec3::from);
    let root = u0.sqrt();
    a * (1.0 - root) + b * (root * (1.0 - u1)) + c * (root * u1)
}

/// The point of a triangle that is nearest to `p`: in it if `p` lies above it, else on its nearest edge.
fn nearest_point(vertices: [Vec3; 3], p: Vec3) -> Vec3 {
    let [a, b, c] = vertices.map(|v| v.as_dvec3());
    let p = p.as_dvec3();
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    let inside = edges.iter().all(|(from, to)| (to - from).cross(p - from).dot(normal) >= 0.0);
    let nearest = if inside {
        p - normal * ((p - a).dot(normal) / normal.length_squared())
    } else {
        let on_edge = |&(from, to): &(DVec3, DVec3)| {
            let edge = to - from;
            from + edge * ((p - from).dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
        };
        let points = edges.iter().map(on_edge);
        points.min_by(|x, y| x.distance_squared(p).total_cmp(&y.distance_squared(p))).unwrap_or(a)
    };
    nearest.as_vec3()
}
