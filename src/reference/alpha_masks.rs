//! The alpha test: whether a triangle is there at all at a point of it.

use super::Real;
use super::intersect::Hit;
use super::texture::{interpolate, mix, neighbours};
use crate::tables::alpha_masks::{AlphaMaskTable, THRESHOLD};

/// Whether `triangle` is there at the point with weights (1-u-v, u, v): its mask, bilinear and repeated as textures are,
/// is at least one half.
pub fn is_opaque(table: &AlphaMaskTable, triangle: u32, u: Real, v: Real) -> bool {
    if !table.cuts(triangle) {
        return true;
    }
    let record = &table.records[table.record_of[triangle as usize] as usize];
    let uv = interpolate(&record.uvs, [1.0 - u - v, u, v]);
    let mask = record.mask as usize;
    let (width, height) = (table.width[mask], table.height[mask]);
    let (left, right, along) = neighbours(uv[0], width as Real);
    let (below, above, up) = neighbours(uv[1], height as Real);
    let texel = |column: u32, row: u32| table.texels[(table.first[mask] + row * width + column) as usize] as Real;
    let low = mix(texel(left, below), texel(right, below), along);
    let high = mix(texel(left, above), texel(right, above), along);
    mix(low, high, up) >= THRESHOLD as Real
}

/// [`is_opaque`] of the point that a ray has hit.
pub fn is_hit(table: &AlphaMaskTable, hit: &Hit) -> bool {
    is_opaque(table, hit.triangle, hit.u, hit.v)
}
