//! Whether emitters see anything: emission is one-sided, so a mesh wound the other way shines into nothing.

use crate::bvh::{Bvh, RayPacket};
use crate::lanes::{F32x8, LANES, Mask8, Vec3x8};
use crate::math::sin_cos_turns;
use crate::sampler::{random_words, unit};
use crate::scene::desc::SceneDesc;
use crate::scene::flatten::Geometry;
use crate::tables::lights::emitters::Emitter;
use crate::tables::triangles::TriangleRecord;
use glam::Vec3;

/// Rays from the fronts of all emitters together, about; each emissive material has at least one packet of them.
const RAYS: usize = 4096;
/// Rays of one material, at most.
const RAYS_OF_ONE: usize = 256;

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
        let start = |ray: usize| Start::new(triangles, ids[ray * ids.len() / rays], ray as u32);
        (0..rays).step_by(LANES).any(|first| sees_anything(bvh, camera, &std::array::from_fn(|i| start(first + i))))
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

/// Where a ray leaves an emitter's front.
struct Start {
    origin: Vec3,
    normal: Vec3,
    direction: Vec3,
}

impl Start {
    /// Ray number `ray`: a point uniform over the triangle, a direction by the cosine about its front normal. The
    /// address of its numbers is one that no camera sample has: these rays decide no picture.
    fn new(triangles: &[TriangleRecord], triangle: u32, ray: u32) -> Start {
        let record = &triangles[triangle as usize];
        let [a, b, c] = record.vertices.map(Vec3::from);
        let normal = Vec3::from(record.normal);
        let [w0, w1, w2, w3] = random_words(triangle, ray, u32::MAX, 0).map(unit);
        let root = w0.sqrt();
        let weights = [1.0 - root, root * (1.0 - w1), root * w1];
        let position = a * weights[0] + b * weights[1] + c * weights[2];
        let size = [a, b, c].map(|v| v.abs().element_sum()).into_iter().fold(0.0, f32::max);
        let offset = (16.0 * size + record.offset) * 0.5 * f32::EPSILON;
        let (sine, cosine) = sin_cos_turns(w3);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let direction = (tangent * cosine + bitangent * sine) * w2.sqrt() + normal * (1.0 - w2).sqrt();
        Start { origin: position + normal * offset, normal, direction }
    }
}
