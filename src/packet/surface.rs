//! The points that eight rays have hit: position, facing normal, and safe places for the next rays to start.

use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use crate::scene::prepare::TriangleRecord;

/// Offsets are this fraction (16 x 2^-24) of the summed sizes of the coordinates that made the point: the barycentric sum
/// itself and the next ray's triangle test each err by a few half-ulps of it (pbrt-v4 section 6.8).
pub const OFFSET_FRACTION: f32 = 16.0 / 16_777_216.0;

/// Eight records of 16 words, lane by lane, as columns: `[word]` lane `i` is word `word` of record `indices[i]`.
#[inline(always)]
pub fn gather_records<T: bytemuck::Pod>(table: &[T], indices: U32x8) -> [F32x8; 16] {
    const { assert!(size_of::<T>() == 64) };
    let at = indices.to_array();
    let row = |lane: usize| -> &[[f32; LANES]; 2] { bytemuck::cast_ref(&table[at[lane] as usize]) };
    let rows: [&[[f32; LANES]; 2]; LANES] = std::array::from_fn(row);
    let low = F32x8::transpose(rows.map(|row| F32x8::from_array(row[0])));
    let high = F32x8::transpose(rows.map(|row| F32x8::from_array(row[1])));
    std::array::from_fn(|word| if word < LANES { low[word] } else { high[word - LANES] })
}

/// The vertices in the first nine columns of gathered triangle or light records.
#[inline(always)]
pub fn vertices(columns: &[F32x8; 16]) -> [Vec3x8; 3] {
    std::array::from_fn(|v| Vec3x8::new(columns[3 * v], columns[3 * v + 1], columns[3 * v + 2]))
}

/// Eight points on surfaces.
pub struct SurfacePoints {
    /// The hits, from barycentric weights.
    pub position: Vec3x8,
    /// Unit normals on the sides the rays came from.
    pub normal: Vec3x8,
    /// The rays hit fronts.
    pub front: Mask8,
    /// Where rays that leave on the sides of `normal` start.
    pub origin: Vec3x8,
    /// Where rays that leave on the other sides start.
    pub origin_behind: Vec3x8,
    /// Material indices.
    pub material: U32x8,
}

/// The points with weights (1-u-v, u, v) on `triangle`, hit by rays in directions `direction`.
#[inline(always)]
pub fn surface_points(
    triangles: &[TriangleRecord],
    triangle: U32x8,
    u: F32x8,
    v: F32x8,
    direction: Vec3x8,
) -> SurfacePoints {
    let columns = gather_records(triangles, triangle);
    let weights = [F32x8::ONE - u - v, u, v];
    let front_normal = Vec3x8::new(columns[9], columns[10], columns[11]);
    let front: Mask8 = front_normal.dot(direction).lt(F32x8::ZERO);
    let normal = front.select_vec3(front_normal, -front_normal);
    let (position, offset) = point_and_offset(&vertices(&columns), weights);
    let away = normal.scale(offset);
    let (origin, origin_behind) = (position + away, position - away);
    SurfacePoints { position, normal, front, origin, origin_behind, material: columns[12].to_bits() }
}

/// Barycentric sums, and how far along the normals rays must start to be off the surfaces for certain.
#[inline(always)]
pub fn point_and_offset(vertices: &[Vec3x8; 3], weights: [F32x8; 3]) -> (Vec3x8, F32x8) {
    let [a, b, c] = *vertices;
    let position = a.scale(weights[0]) + b.scale(weights[1]) + c.scale(weights[2]);
    let size = a.abs().scale(weights[0]) + b.abs().scale(weights[1]) + c.abs().scale(weights[2]);
    (position, (size.x + size.y + size.z) * F32x8::splat(OFFSET_FRACTION))
}
