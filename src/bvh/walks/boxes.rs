//! Conservative box tests: a box may be entered in vain, never missed.
//!
//! They cannot change a result, so they may use FMA. A slab is `near = b / d - (o / d + e)`, `far = b / d - (o / d - e)`
//! with `e = 2^-22 (|o| + extent) |1 / d|`, which bounds the rounding of all three terms and what the triangle test moves corners
//! by (`extent` is the largest |b| in the scene); the far side and the closest hit so far are then widened by `1 + 2^-21` (Ize 2013, "Robust BVH Ray
//! Traversal"). The absolute term matters for rays that lie in a face of a box, where every relative widening is of 0.

use super::here;
use crate::bvh::rounding::{ROUNDING, SMALLEST, WIDENING};
use here::lanes::{Each, F32x8, Mask8, Vec3x8};

/// A single ray, ready for boxes: every lane the same.
#[derive(Clone, Copy)]
pub(super) struct OneRayBoxes {
    inverse: [F32x8; 3],
    near_offset: [F32x8; 3],
    far_offset: [F32x8; 3],
    /// Which of min and max is the near side.
    side: [usize; 3],
    tmin: F32x8,
}

/// 1 / direction, finite and not 0 for all numbers.
#[inline(always)]
fn safe_inverse(direction: f32) -> f32 {
    // `max` of the crate: NaN becomes SMALLEST too.
    1.0 / crate::math::max(direction.abs(), SMALLEST).copysign(direction)
}

/// 1 / direction, finite and not 0 for all numbers.
#[inline(always)]
pub(super) fn safe_inverse8(direction: F32x8) -> F32x8 {
    F32x8::ONE / direction.abs().max(F32x8::splat(SMALLEST)).copysign(direction)
}

impl OneRayBoxes {
    #[inline(always)]
    pub(super) fn new(origin: [f32; 3], direction: [f32; 3], tmin: f32, extent: f32) -> Self {
        let inverse = direction.map(safe_inverse);
        let scaled: [f32; 3] = std::array::from_fn(|k| origin[k] * inverse[k]);
        let widening: [f32; 3] = std::array::from_fn(|k| ROUNDING * ((origin[k].abs() + extent) * inverse[k].abs()));
        Self {
            inverse: inverse.each(F32x8::splat),
            near_offset: [0, 1, 2].each(
                #[inline(always)]
                |k| F32x8::splat(scaled[k] + widening[k]),
            ),
            far_offset: [0, 1, 2].each(
                #[inline(always)]
                |k| F32x8::splat(scaled[k] - widening[k]),
            ),
            side: inverse.map(|i| (i < 0.0) as usize),
            // Distances of boxes are never negative (nor -0, nor NaN): their bits are in their order.
            tmin: F32x8::splat(crate::math::max(tmin, 0.0)),
        }
    }

    /// Entry distances into eight boxes, and which of them are hit before `best_wide` (widened closest hit).
    #[inline(always)]
    pub(super) fn test(&self, bounds: &[[[f32; 8]; 2]; 3], best_wide: F32x8) -> (F32x8, Mask8) {
        let near = |k: usize| {
            F32x8::from_array(bounds[k][self.side[k] & 1]).loose_mul_sub(self.inverse[k], self.near_offset[k])
        };
        let far = |k: usize| {
            F32x8::from_array(bounds[k][!self.side[k] & 1]).loose_mul_sub(self.inverse[k], self.far_offset[k])
        };
        let entry = near(0).max(near(1)).max(near(2)).max(self.tmin);
        let exit = far(0).min(far(1)).min(far(2)) * F32x8::splat(WIDENING);
        (entry, entry.le(exit.min(best_wide)))
    }
}

/// Eight rays, ready for boxes.
#[derive(Clone, Copy)]
pub(super) struct EightRaysBoxes {
    inverse: [F32x8; 3],
    near_offset: [F32x8; 3],
    far_offset: [F32x8; 3],
    tmin: F32x8,
}

/// What holds for all of eight rays of one octant, by interval arithmetic: a box that it excludes is hit by none of them.
/// One test of the eight boxes of a node then spares most of the tests ray by ray (Boulos et al. 2006, "Geometric and
/// Arithmetic Culling Methods for Entire Ray Packets").
#[derive(Clone, Copy)]
pub(super) struct Interval {
    /// Which of min and max is the near side.
    side: [usize; 3],
    /// Of the origins: what is taken from the near sides, from the far sides.
    near_origin: [F32x8; 3],
    far_origin: [F32x8; 3],
    /// The inverse directions closest to 0 and farthest from it.
    least_inverse: [F32x8; 3],
    most_inverse: [F32x8; 3],
    widening: [F32x8; 3],
    tmin: F32x8,
}

impl Interval {
    /// Nothing if the rays are not of one octant.
    #[inline(always)]
    pub(super) fn new(origin: Vec3x8, direction: Vec3x8, tmin: F32x8, extent: f32) -> Option<Self> {
        let (o, d) = ([origin.x, origin.y, origin.z], [direction.x, direction.y, direction.z]);
        let mut interval = Self {
            side: [0; 3],
            near_origin: [F32x8::ZERO; 3],
            far_origin: [F32x8::ZERO; 3],
            least_inverse: [F32x8::ZERO; 3],
            most_inverse: [F32x8::ZERO; 3],
            widening: [F32x8::ZERO; 3],
            tmin: F32x8::splat(tmin.max(F32x8::ZERO).min_of_lanes()),
        };
        for k in 0..3 {
            let inverse = safe_inverse8(d[k]);
            let negative = inverse.lt(F32x8::ZERO).bits();
            if negative != 0 && negative != 0xff {
                return None;
            }
            let (low, high) = (o[k].min_of_lanes(), -(-o[k]).min_of_lanes());
            let (least, most) = (inverse.abs().min_of_lanes(), -(-inverse.abs()).min_of_lanes());
            interval.side[k] = (negative & 1) as usize;
            let (sign, near, far) = if negative == 0 { (1.0, high, low) } else { (-1.0, low, high) };
            interval.near_origin[k] = F32x8::splat(near);
            interval.far_origin[k] = F32x8::splat(far);
            interval.least_inverse[k] = F32x8::splat(sign * least);
            interval.most_inverse[k] = F32x8::splat(sign * most);
            // Twice that of a single ray: here one more difference is rounded.
            let largest = crate::math::max(low.abs(), high.abs()) + extent;
            interval.widening[k] = F32x8::splat(2.0 * ROUNDING * (largest * most));
        }
        Some(interval)
    }

    /// Which of eight boxes any ray can hit before `best_wide`, the farthest of the rays' closest hits, widened.
    #[inline(always)]
    pub(super) fn test(&self, bounds: &[[[f32; 8]; 2]; 3], best_wide: F32x8) -> Mask8 {
        let (mut entry, mut exit) = (self.tmin, F32x8::splat(f32::INFINITY));
        for (k, sides) in bounds.iter().enumerate() {
            let near = F32x8::from_array(sides[self.side[k] & 1]) - self.near_origin[k];
            let far = F32x8::from_array(sides[!self.side[k] & 1]) - self.far_origin[k];
            let near = (near * self.least_inverse[k]).min(near * self.most_inverse[k]) - self.widening[k];
            let far = (far * self.least_inverse[k]).max(far * self.most_inverse[k]) + self.widening[k];
            entry = near.max(entry);
            exit = far.min(exit);
        }
        entry.le((exit * F32x8::splat(WIDENING)).min(best_wide))
    }
}

impl EightRaysBoxes {
    #[inline(always)]
    pub(super) fn new(origin: Vec3x8, direction: Vec3x8, tmin: F32x8, extent: f32) -> Self {
        let o = [origin.x, origin.y, origin.z];
        let d = [direction.x, direction.y, direction.z];
        let inverse = d.each(
            #[inline(always)]
            |d| safe_inverse8(d),
        );
        let extent = F32x8::splat(extent);
        let widening: [F32x8; 3] = [0, 1, 2].each(
            #[inline(always)]
            |k: usize| F32x8::splat(ROUNDING) * ((o[k].abs() + extent) * inverse[k].abs()),
        );
        Self {
            inverse,
            near_offset: [0, 1, 2].each(
                #[inline(always)]
                |k: usize| o[k] * inverse[k] + widening[k],
            ),
            far_offset: [0, 1, 2].each(
                #[inline(always)]
                |k: usize| o[k] * inverse[k] - widening[k],
            ),
            tmin: tmin.max(F32x8::ZERO),
        }
    }

    /// [`EightRaysBoxes::test`] of rays of the one octant of `interval`.
    #[inline(always)]
    pub(super) fn test_octant(
        &self,
        interval: &Interval,
        bounds: &[[[f32; 8]; 2]; 3],
        child: usize,
        best_wide: F32x8,
    ) -> (F32x8, Mask8) {
        let (mut entry, mut exit) = (self.tmin, F32x8::splat(f32::INFINITY));
        for (k, sides) in bounds.iter().enumerate() {
            let near = F32x8::splat(sides[interval.side[k] & 1][child]);
            let far = F32x8::splat(sides[!interval.side[k] & 1][child]);
            entry = near.loose_mul_sub(self.inverse[k], self.near_offset[k]).max(entry);
            exit = far.loose_mul_sub(self.inverse[k], self.far_offset[k]).min(exit);
        }
        (entry, entry.le((exit * F32x8::splat(WIDENING)).min(best_wide)))
    }

    /// Entry distances into box `child`, and which rays hit it before `best_wide`; not for empty slots.
    #[inline(always)]
    pub(super) fn test(&self, bounds: &[[[f32; 8]; 2]; 3], child: usize, best_wide: F32x8) -> (F32x8, Mask8) {
        let (mut entry, mut exit) = (self.tmin, F32x8::splat(f32::INFINITY));
        for (k, [min, max]) in bounds.iter().enumerate() {
            let low = F32x8::splat(min[child]) * self.inverse[k];
            let high = F32x8::splat(max[child]) * self.inverse[k];
            entry = (low.min(high) - self.near_offset[k]).max(entry);
            exit = (low.max(high) - self.far_offset[k]).min(exit);
        }
        (entry, entry.le((exit * F32x8::splat(WIDENING)).min(best_wide)))
    }
}
