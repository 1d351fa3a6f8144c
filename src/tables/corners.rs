//! The corner table: what smooth surfaces need of a triangle besides its record, one cache line each.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::scene::desc::{CornerDesc, MaterialDesc, TextureUse};
use crate::scene::flatten::Geometry;
use crate::tables::textures::placed;
use crate::tables::triangles::TriangleRecord;

/// Not part of a smooth surface: shaded with the geometric normal.
pub const FLAT: u32 = 0;
/// Shaded with interpolated normals, too bent for rays to start off it.
pub const SMOOTH: u32 = 1;
/// Shaded with interpolated normals; rays start on the smooth surface.
pub const LIFTED: u32 = 2;

/// What a triangle's corners carry.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct CornerRecord {
    /// Unit normals of the smooth surface, towards the front.
    pub normals: [[f32; 3]; 3],
    /// Texture coordinates, with the scale and offset of the material's texture in them.
    pub uvs: [[f32; 2]; 3],
    /// [`FLAT`], [`SMOOTH`] or [`LIFTED`].
    pub smoothness: u32,
}

/// Normals closer to the geometric one than this (as the sine of the angle) are the geometric one, written with few digits: a flat
/// surface, which needs no interpolation.
const FLAT_SINE: f32 = 2e-4;

/// From normals that lean further from the geometric one than this (as the cosine of the angle, 45 degrees) no ray is lifted.
/// Such normals lend a box round edges; the smooth surface they describe stands so far off that rays from it could start
/// behind a neighbouring wall.
const LIFT_COSINE: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// The table of a scene; empty if no triangle is smooth or textured.
pub fn corner_table(
    materials: &[MaterialDesc],
    geometry: &Geometry<'_>,
    triangles: &[TriangleRecord],
) -> Vec<CornerRecord> {
    let texture = |id: usize| materials[geometry.triangles[id].material as usize].texture;
    let mut needed = geometry.corners.is_empty() && materials.iter().any(|m| m.texture.is_some());
    if geometry.corners.is_empty() && !needed {
        return Vec::new();
    }
    let make = |id: usize| {
        let corner = geometry.corners.get(id).copied().unwrap_or_default();
        let record = record(&corner, &triangles[id], texture(id));
        needed |= record.smoothness != FLAT || texture(id).is_some();
        record
    };
    let records: Vec<CornerRecord> = (0..triangles.len()).map(make).collect();
    if needed { records } else { Vec::new() }
}

fn record(corner: &CornerDesc, triangle: &TriangleRecord, texture: Option<TextureUse>) -> CornerRecord {
    let front = Vec3::from(triangle.normal);
    let normals = corner.normals.map(|n| if n == [0.0; 3] { front } else { Vec3::from(n) });
    let smoothness = match () {
        _ if normals.iter().all(|n| n.cross(front).length() < FLAT_SINE && n.dot(front) > 0.0) => FLAT,
        _ if normals.iter().all(|n| n.dot(front) > LIFT_COSINE) => LIFTED,
        _ => SMOOTH,
    };
    CornerRecord { normals: normals.map(|n| n.to_array()), uvs: placed(corner.uvs, texture), smoothness }
}
