//! What shadow rays to emitters must know of the triangles they aim at.

use std::collections::HashMap;

use crate::bvh::precise::{PRECISE, aspect, longest_edge};
use crate::bvh::ray::ANY_ID;
use crate::tables::prepared::PreparedScene;
use crate::tables::triangles::TriangleRecord;
use glam::Vec3;

/// In a shadow ray's target: rounding made the ray miss it.
pub const MISSED: u32 = 1 << 31;
/// In a shadow ray's target: it is a delta light. The other bits are its number.
pub const DELTA: u32 = 1 << 30;

/// The part of the way to a common emitter that must be free: 1 - 2^-17. Boxes about the emitter are then not entered.
/// (Whatever lies so close before an emitter makes it a precise one; see [`crate::bvh::precise`].)
pub const FREE_PART: f32 = 1.0 - 1.0 / 131_072.0;

/// From higher over their planes than 1/8 of their coordinates, and of their aspects times longest edges, the test of common
/// triangles finds emitters where points on them are, to less than 2^-17 of the way: it errs by a few half-ulps (2^-24) of these
/// along the normal.
const FAR: f32 = 1.0 / 8.0;

/// No triangle.
const NONE: u32 = u32::MAX;

/// Emitters whose normals are closer than this (as the sine of the angle) are coplanar.
const COPLANAR_SINE: f32 = 1e-4;

/// Per emitter, what its shadow rays must know.
pub struct Targets {
    /// Whether any emitter is precise: shadow rays then must know their targets.
    pub aimed: bool,
    /// The squared height over an emitter's plane beyond which shadow rays end at the points they were sent to; below, where the
    /// triangle test finds the emitters.
    pub far: f32,
    /// Triangle ids.
    pub triangle: Vec<u32>,
    /// Classes of the triangles ([`crate::bvh::precise`]); empty if all are common.
    class: Vec<u8>,
    /// The emitters (triangle ids) that lie in the same plane beyond each edge: a ray that rounding makes miss its target hits
    /// one of them instead, and is not blocked by it.
    beside: Vec<[u32; 3]>,
}

impl Targets {
    /// Those of the emitters of `scene`.
    pub fn new(scene: &PreparedScene) -> Targets {
        let triangle: Vec<u32> = scene.emitters.iter().map(|emitter| emitter.triangle).collect();
        let class: Vec<u8> = triangle.iter().map(|&id| scene.bvh.class(id)).collect();
        let beside = beside(&scene.triangles, &triangle);
        let aimed = class.iter().any(|class| class & PRECISE != 0);
        let reach = |id: u32| {
            let vertices = scene.triangles[id as usize].vertices;
            let coordinates = vertices.as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
            FAR * coordinates.max(aspect_length(vertices) as f32)
        };
        let far = triangle.iter().map(|&id| reach(id)).fold(0.0, f32::max);
        Targets {
            aimed,
            far: if aimed { f32::INFINITY } else { far * far },
            class: if class.iter().any(|&class| class != 0) { class } else { Vec::new() },
            triangle,
            beside,
        }
    }

    /// The class of an emitter's triangle.
    #[inline(always)]
    pub fn class(&self, emitter: u32) -> u8 {
        if self.class.is_empty() { 0 } else { self.class[emitter as usize] }
    }

    /// The classes of eight emitters' triangles, unless all triangles that emit are common.
    #[inline(always)]
    pub fn classes<const N: usize>(&self, emitters: [u32; N]) -> Option<[u8; N]> {
        (!self.class.is_empty()).then(|| emitters.map(|emitter| self.class[emitter as usize]))
    }

    /// At the very end of a shadow ray to an emitter, only triangles of ids below this one block it.
    #[inline(always)]
    pub fn before(&self, emitter: u32) -> u32 {
        if self.class(emitter) & PRECISE != 0 { self.triangle[emitter as usize] } else { ANY_ID }
    }

    /// The triangles that do not block a shadow ray that missed the emitter it was sent to.
    pub fn passed(&self, emitter: u32) -> [u32; 4] {
        let [a, b, c] = self.beside[emitter as usize];
        [self.triangle[emitter as usize], a, b, c]
    }

    /// Bytes of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.triangle[..]) + self.class.len() + size_of_val(&self.beside[..])
    }
}

/// The aspect of a triangle times its longest edge, scene units.
fn aspect_length(vertices: [[f32; 3]; 3]) -> f64 {
    aspect(vertices) * f64::from(longest_edge(vertices))
}

fn beside(triangles: &[TriangleRecord], emitters: &[u32]) -> Vec<[u32; 3]> {
    let edge = |id: u32, opposite: usize| {
        let v = triangles[id as usize].vertices.map(|v| v.map(|x| (x + 0.0).to_bits()));
        let (a, b) = (v[(opposite + 1) % 3], v[(opposite + 2) % 3]);
        if a < b { [a, b] } else { [b, a] }
    };
    let mut owners: HashMap<[[u32; 3]; 2], Vec<u32>> = HashMap::new();
    for &id in emitters {
        (0..3).for_each(|opposite| owners.entry(edge(id, opposite)).or_default().push(id));
    }
    let normal = |id: u32| Vec3::from(triangles[id as usize].normal);
    let coplanar = |a: u32, b: u32| a != b && normal(a).cross(normal(b)).length() < COPLANAR_SINE;
    let neighbour = |id: u32, opposite: usize| {
        let others = owners.get(&edge(id, opposite)).into_iter().flatten();
        others.copied().find(|&other| coplanar(id, other)).unwrap_or(NONE)
    };
    emitters.iter().map(|&id| std::array::from_fn(|opposite| neighbour(id, opposite))).collect()
}
