//! The triangle table: what shading needs of every triangle, one cache line each, and the classes by which hits are sorted.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::ops::Range;

use crate::bvh::Bvh;
use crate::bvh::precise::PRECISE;
use crate::bvh::{huge, threads};
use crate::scene::flatten::Geometry;
use crate::scene::validate::is_degenerate;
use crate::tables::margins::Margins;
use crate::tables::materials::MaterialRecord;

/// [`TriangleRecord::light`] of a triangle that does not emit.
pub const NO_LIGHT: u32 = u32::MAX;

/// Triangles that a thread works on at a time.
const CHUNK: usize = 1 << 14;

/// What shading needs of one triangle: one cache line, read whole.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct TriangleRecord {
    /// Vertices in file order, scene units.
    pub vertices: [[f32; 3]; 3],
    /// Unit normal of the front side.
    pub normal: [f32; 3],
    /// Index into [`crate::tables::PreparedScene::materials`].
    pub material: u32,
    /// Index into [`crate::tables::PreparedScene::emitters`], or [`NO_LIGHT`].
    pub light: u32,
    /// [`Margins::offset`], scene units or [`crate::tables::margins::PRECISE_OFFSET`].
    pub offset: f32,
    /// [`Margins::inset`].
    pub inset: f32,
}

/// The bit of [`crate::tables::PreparedScene::classes`] that says: this triangle emits.
pub const CLASS_EMITS: u8 = 0x80;

/// Per triangle, whether it has no area.
pub(super) fn degenerate_triangles(geometry: &Geometry<'_>) -> Vec<bool> {
    let count = geometry.triangles.len();
    let judge = |ids: Range<usize>| ids.map(|id| is_degenerate(geometry.vertices(id))).collect::<Vec<bool>>();
    threads::map(threads::count(0, count), threads::ranges(count, CHUNK), judge).concat()
}

/// Twice the area vector of a triangle, from its rounded vertices, in f64.
pub(super) fn double_area_vector([a, b, c]: [[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| glam::Vec3::from(v).as_dvec3());
    (b - a).cross(c - a)
}

/// The records of a scene; `material_index` are the places of its materials in the material table, `emissive` the ids of
/// its emitters, ascending.
pub(super) fn triangle_table(
    geometry: &Geometry<'_>,
    degenerate: &[bool],
    material_index: &[u32],
    emissive: impl IntoIterator<Item = u32>,
    bvh: &Bvh,
) -> Vec<TriangleRecord> {
    let count = geometry.triangles.len();
    let emissive: Vec<u32> = emissive.into_iter().collect();
    let mut records: Vec<TriangleRecord> = huge::zeroed_list(count);
    let fill = |(ids, rows): (Range<usize>, &mut [TriangleRecord])| {
        let before = emissive.partition_point(|&emitter| (emitter as usize) < ids.start);
        let mut emissive = emissive[before..].iter().zip(before..).peekable();
        for (id, row) in ids.zip(rows) {
            let triangle = geometry.triangles[id];
            let vertices = geometry.vertices(id);
            let normal = if degenerate[id] {
                DVec3::Z // never hit; any finite value will do
            } else {
                double_area_vector(vertices).normalize() * if triangle.flipped { -1.0 } else { 1.0 }
            };
            let precise = bvh.class(id as u32) & PRECISE != 0;
            let margins = if degenerate[id] { Margins::default() } else { Margins::of(vertices, precise) };
            let light =
                emissive.next_if(|&(&emitter, _)| emitter == id as u32).map_or(NO_LIGHT, |(_, light)| light as u32);
            *row = TriangleRecord {
                vertices,
                normal: normal.as_vec3().to_array(),
                material: material_index[triangle.material as usize],
                light,
                offset: margins.offset,
                inset: margins.inset,
            };
        }
    };
    let ranges = threads::ranges(count, CHUNK);
    let work = ranges.iter().cloned().zip(threads::cut(&mut records, ranges.iter().map(Range::len))).collect();
    threads::map(threads::count(0, count), work, fill);
    records
}

/// Per triangle id, the sorting key of a hit: the kind of its material (low bits) and [`CLASS_EMITS`].
pub(super) fn class_table(triangles: &[TriangleRecord], materials: &[MaterialRecord]) -> Vec<u8> {
    let emission = |light: u32| if light == NO_LIGHT { 0 } else { CLASS_EMITS };
    triangles.iter().map(|t| materials[t.material as usize].kind() as u8 | emission(t.light)).collect()
}
