//! Triangles as the builder sees them: boxes and centres, in lanes.

use crate::bvh::huge::Table;
use crate::bvh::threads;
use crate::lanes::{F32x8, LANES, U32x8};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;

/// Triangles that a thread turns into boxes at a time.
const CHUNK: usize = 1 << 14;

/// A box and the triangle in it: lanes 0-2 min, 4-6 negated max, so that the union of two is one lane minimum. Lane 3 of a
/// triangle's box is its id. No lane is -0: then unions have the same bits in whatever order they are made.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct PrimBox([f32; LANES]);

impl PrimBox {
    #[inline(always)]
    pub(super) fn new([a, b, c]: [[f32; 3]; 3], id: u32) -> Self {
        let min = crate::math::min;
        let mut lanes = [f32::INFINITY; LANES];
        for axis in 0..3 {
            lanes[axis] = min(min(a[axis], b[axis]), c[axis]) + 0.0;
            lanes[4 + axis] = min(min(-a[axis], -b[axis]), -c[axis]) + 0.0;
        }
        lanes[3] = f32::from_bits(id);
        Self(lanes)
    }
    #[inline(always)]
    pub(super) fn id(&self) -> u32 {
        self.0[3].to_bits()
    }
    #[inline(always)]
    pub(super) fn lanes(&self) -> F32x8 {
        F32x8::from_array(self.0)
    }
    /// Twice the centre.
    #[inline(always)]
    pub(super) fn centre(&self, axis: usize) -> f32 {
        self.0[axis] - self.0[axis + 4]
    }
}

/// The box of nothing.
#[inline(always)]
pub(super) fn nothing() -> F32x8 {
    F32x8::splat(f32::INFINITY)
}

/// Lanes 0-3 and 4-7 in each other's place.
#[inline(always)]
pub(super) fn swap_halves(lanes: F32x8) -> F32x8 {
    lanes.permute(U32x8::from_array([4, 5, 6, 7, 0, 1, 2, 3]))
}

/// Twice the centre of a box (infinite if that is beyond f32), and in lanes 4-6 its negation: the bounds of centres are one lane
/// minimum, too.
#[inline(always)]
pub(super) fn centre(lanes: F32x8) -> F32x8 {
    lanes - swap_halves(lanes)
}

/// A box as obvhs has it; 0 - x and not -x, which would make -0 of 0.
#[inline(always)]
pub(super) fn aabb(lanes: F32x8) -> Aabb {
    let b = lanes.to_array();
    Aabb::new(Vec3A::new(b[0], b[1], b[2]), Vec3A::new(0.0 - b[4], 0.0 - b[5], 0.0 - b[6]))
}

/// What is known of some triangles.
#[derive(Clone, Copy)]
pub(super) struct Known {
    /// The box of all.
    pub(super) bounds: F32x8,
    /// The bounds of their centres ([`centre`]).
    pub(super) centres: F32x8,
}

impl Known {
    fn nothing() -> Self {
        Self { bounds: nothing(), centres: nothing() }
    }
    pub(super) fn of(prims: &[PrimBox]) -> Self {
        prims.iter().fold(Self::nothing(), |known, prim| known.with(prim.lanes()))
    }
    #[inline(always)]
    fn with(self, lanes: F32x8) -> Self {
        Self { bounds: self.bounds.min(lanes), centres: self.centres.min(centre(lanes)) }
    }
    pub(super) fn union(self, other: Self) -> Self {
        Self { bounds: self.bounds.min(other.bounds), centres: self.centres.min(other.centres) }
    }
}

/// The boxes of those of `count` triangles that are to be included, by ascending id, and what is known of them; `vertices` gives a
/// triangle's corners.
pub(super) fn gather(
    count: usize,
    threads: usize,
    vertices: impl Fn(u32) -> [[f32; 3]; 3] + Sync,
    include: impl Fn(u32) -> bool + Sync,
) -> (Table<PrimBox>, Known) {
    let chunks = threads::ranges(count, CHUNK);
    let included = |range: std::ops::Range<usize>| range.filter(|&id| include(id as u32)).count();
    let counts = threads::map(threads, chunks.clone(), included);
    let mut prims = Table::zeroed(counts.iter().sum());
    let work = chunks.into_iter().zip(threads::cut(prims.rows_mut(), counts)).collect();
    let fill = |(ids, rows): (std::ops::Range<usize>, &mut [PrimBox])| {
        let ids = ids.map(|id| id as u32).filter(|&id| include(id));
        rows.iter_mut().zip(ids).fold(Known::nothing(), |known, (row, id)| {
            *row = PrimBox::new(vertices(id), id);
            known.with(row.lanes())
        })
    };
    let known = threads::map(threads, work, fill).into_iter().fold(Known::nothing(), Known::union);
    (prims, known)
}

/// Half the surface of boxes, in units of the scene's size; a little of the edge lengths is added, so that boxes without
/// surface (all triangles in a line) still have an order.
#[derive(Clone, Copy)]
pub(super) struct Area {
    scale: f32,
}

impl Area {
    pub(super) fn of_scene(size: Vec3) -> Self {
        Self { scale: 1.0 / size.max_element().clamp(1e-36, 1e36) }
    }
    #[inline(always)]
    pub(super) fn half(&self, size: Vec3) -> f32 {
        let Vec3 { x, y, z } = size * self.scale;
        (x * y + y * z + z * x) + 1e-6 * (x + y + z)
    }
    /// Of eight boxes; NaN of the box of nothing.
    #[inline(always)]
    pub(super) fn eight(&self, boxes: [F32x8; LANES]) -> F32x8 {
        let c = F32x8::transpose(boxes);
        let scale = F32x8::splat(-self.scale);
        let [x, y, z] = [(c[0] + c[4]) * scale, (c[1] + c[5]) * scale, (c[2] + c[6]) * scale];
        (x * y + y * z + z * x) + F32x8::splat(1e-6) * (x + y + z)
    }
}
