//! What all walks allow for rounding: how far boxes are widened, which triangles count as seen edge-on.

/// What the closest hit is widened by before a box may be culled against it.
pub(crate) const WIDENING: f32 = 1.0 + 1.0 / (1 << 21) as f32;
/// What the rounding of a slab is bounded by, of all its terms ([`crate::simd::native::walks::boxes`]).
pub(crate) const ROUNDING: f32 = 1.0 / (1 << 22) as f32;
/// Direction components are kept this far from 0: their inverses, times any coordinate up to 2^46, stay finite.
pub(crate) const SMALLEST: f32 = 1.0 / (1u128 << 80) as f32;
/// The part of the corners' squared distances below which a projected triangle is seen edge-on.
pub(crate) const EDGE_ON: f32 = 1.0 / 64.0;

/// Where |det| of a hit is not below this times how far the ray reaches (its origin's or the scene's largest |coordinate|), it does not see the triangle edge-on. `size` is the longest
/// side of the triangle's box, `leaf` that of its leaf's, `extent` the scene's largest |coordinate|.
///
/// A ray inside has sheared corners no farther off than twice the triangle's size, so the test of the triangle itself, which looks
/// at the corners, is asked only below the square of that. What may look inside far beside a small triangle, by rounding alone, has
/// a `det` of at most 32 half-ulps of the scene, or of how far off the ray starts, times the size of the leaf.
pub(crate) fn least_det(size: f32, leaf: f32, extent: f32) -> f32 {
    let least = (size * size * (4.1 * EDGE_ON)).max(extent * leaf * (1.0 / (1 << 16) as f32));
    least / extent.max(f32::MIN_POSITIVE)
}

/// The longest side of the box of some corners.
pub(crate) fn size_of(corners: impl IntoIterator<Item = [f32; 3]>) -> f32 {
    let mut bounds = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
    for corner in corners {
        for axis in 0..3 {
            bounds[axis] = [bounds[axis][0].min(corner[axis]), bounds[axis][1].max(corner[axis])];
        }
    }
    bounds.map(|[low, high]| high - low).into_iter().fold(0.0, f32::max)
}

/// How far rounding and a precise test's shared edges may move corners, for rays from `origin` in a scene that reaches to
/// `extent`: 16 half-ulps of their distances.
#[inline(always)]
pub(crate) fn most_moved(origin: [f32; 3], extent: f32) -> f32 {
    let [x, y, z] = origin.map(f32::abs);
    (crate::math::max(crate::math::max(x, y), z) + extent) * (1.0 / (1 << 19) as f32)
}
