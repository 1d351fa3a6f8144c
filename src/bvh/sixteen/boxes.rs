//! Conservative box tests of sixteen rays; [`crate::simd::native::walks::boxes`] has their form and why it is so.
//!
//! What a far side is widened by, as a factor, is in the ray's constants here: that rounds them once more, so the absolute
//! widening is twice that of eight rays, and the factor, too.

use crate::bvh::node::Node;
use crate::bvh::rounding::{ROUNDING, SMALLEST, WIDENING};
use crate::bvh::sixteen::rays::Rays;
use crate::bvh::sixteen::registers::load_sides;
use std::arch::x86_64::*;

const FAR_WIDENING: f32 = 1.0 + 1.0 / (1 << 20) as f32;

/// Sixteen rays, ready for boxes.
pub(super) struct Boxes {
    pub(super) inverse: [__m512; 3],
    near_offset: [__m512; 3],
    far_inverse: [__m512; 3],
    far_offset: [__m512; 3],
    tmin: __m512,
    /// Where all rays have the same signs: the places, in a node as 64 numbers, of near and far sides.
    pub(super) octant: Option<[[usize; 3]; 2]>,
}

impl Boxes {
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn new(rays: &Rays, extent: f32) -> Self {
        let zero = _mm512_setzero_ps();
        let [mut inverse, mut near_offset, mut far_inverse, mut far_offset] = [[zero; 3]; 4];
        let (mut octant, mut near, mut far) = (true, [0; 3], [0; 3]);
        for k in 0..3 {
            let (origin, direction) = (rays.origin[k], rays.direction[k]);
            let size = _mm512_max_ps(_mm512_abs_ps(direction), _mm512_set1_ps(SMALLEST));
            let safe = _mm512_or_ps(size, _mm512_and_ps(direction, _mm512_set1_ps(-0.0)));
            inverse[k] = _mm512_div_ps(_mm512_set1_ps(1.0), safe);
            let reach = _mm512_add_ps(_mm512_abs_ps(origin), _mm512_set1_ps(extent));
            let widening =
                _mm512_mul_ps(_mm512_set1_ps(2.0 * ROUNDING), _mm512_mul_ps(reach, _mm512_abs_ps(inverse[k])));
            let scaled = _mm512_mul_ps(origin, inverse[k]);
            near_offset[k] = _mm512_add_ps(scaled, widening);
            far_inverse[k] = _mm512_mul_ps(inverse[k], _mm512_set1_ps(FAR_WIDENING));
            far_offset[k] = _mm512_mul_ps(_mm512_sub_ps(scaled, widening), _mm512_set1_ps(FAR_WIDENING));
            let negative = negative(inverse[k]);
            octant &= negative == 0 || negative == 0xffff;
            let side = (negative & 1) as usize;
            (near[k], far[k]) = (16 * k + 8 * side, 16 * k + 8 * (1 - side));
        }
        let octant = octant.then_some([near, far]);
        Self { inverse, near_offset, far_inverse, far_offset, tmin: _mm512_max_ps(rays.tmin, zero), octant }
    }

    /// Entry distances into box `child`, which is not an empty slot, and which of the rays `live` hit it before `best_wide`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn test(&self, node: &Node, child: usize, live: u16, best_wide: __m512) -> (__m512, u16) {
        let zero = _mm512_setzero_ps();
        let [mut near, mut far] = [[zero; 3]; 2];
        match &self.octant {
            Some(places) => {
                let node: &[f32; 64] = bytemuck::cast_ref(node);
                for k in 0..3 {
                    near[k] = _mm512_set1_ps(node[(places[0][k] + child) & 63]);
                    far[k] = _mm512_set1_ps(node[(places[1][k] + child) & 63]);
                }
            }
            None => {
                for k in 0..3 {
                    let (low, high) = (node.bounds[k][0][child & 7], node.bounds[k][1][child & 7]);
                    let (low, high) = (_mm512_set1_ps(low), _mm512_set1_ps(high));
                    let negative = negative(self.inverse[k]);
                    near[k] = _mm512_mask_mov_ps(low, negative, high);
                    far[k] = _mm512_mask_mov_ps(high, negative, low);
                }
            }
        }
        self.test_sides(near, far, live, best_wide)
    }

    /// [`Boxes::test`] of the near and the far sides that each ray has.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn test_sides(
        &self,
        near: [__m512; 3],
        far: [__m512; 3],
        live: u16,
        best_wide: __m512,
    ) -> (__m512, u16) {
        let near = |k: usize| _mm512_fmsub_ps(near[k], self.inverse[k], self.near_offset[k]);
        let far = |k: usize| _mm512_fmsub_ps(far[k], self.far_inverse[k], self.far_offset[k]);
        // Where an operand is NaN the second one comes back. So a side that is NaN bounds nothing, perhaps with its neighbour;
        // `tmin` and `best_wide` always do.
        let entry = _mm512_max_ps(_mm512_max_ps(near(0), near(1)), _mm512_max_ps(near(2), self.tmin));
        let exit = _mm512_min_ps(_mm512_min_ps(far(0), far(1)), _mm512_min_ps(far(2), best_wide));
        (entry, _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(live, entry, exit))
    }
}

/// The lanes whose sign is set.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn negative(values: __m512) -> u16 {
    _mm512_movepi32_mask(_mm512_castps_si512(values))
}

/// [`crate::simd::native::walks::boxes::Interval`] of sixteen rays: near sides in the lower halves, far sides in the upper
/// ones, there with all signs turned, so that both take the same operations.
pub(super) struct Interval {
    /// Brings near sides to the lower half.
    order: [__m512i; 3],
    origin: [__m512; 3],
    least_inverse: [__m512; 3],
    most_inverse: [__m512; 3],
    widening: [__m512; 3],
    /// The least `tmin`; nothing.
    start: __m512,
}

impl Interval {
    /// Of rays of one octant, which gives `places`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn new(rays: &Rays, boxes: &Boxes, places: [[usize; 3]; 2], extent: f32) -> Self {
        let zero = _mm512_setzero_ps();
        let halves = |low: f32, high: f32| _mm512_mask_mov_ps(_mm512_set1_ps(low), 0xff00, _mm512_set1_ps(high));
        let mut interval = Interval {
            order: [_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15); 3],
            origin: [zero; 3],
            least_inverse: [zero; 3],
            most_inverse: [zero; 3],
            widening: [zero; 3],
            start: halves(_mm512_reduce_min_ps(boxes.tmin), f32::NEG_INFINITY),
        };
        for (k, place) in places[0].into_iter().enumerate() {
            let (low, high) = (_mm512_reduce_min_ps(rays.origin[k]), _mm512_reduce_max_ps(rays.origin[k]));
            let size = _mm512_abs_ps(boxes.inverse[k]);
            let (least, most) = (_mm512_reduce_min_ps(size), _mm512_reduce_max_ps(size));
            let positive = place & 8 == 0;
            let (sign, near, far) = if positive { (1.0, high, low) } else { (-1.0, low, high) };
            if !positive {
                interval.order[k] = _mm512_xor_si512(interval.order[k], _mm512_set1_epi32(8));
            }
            interval.origin[k] = halves(near, far);
            interval.least_inverse[k] = halves(sign * least, -sign * least);
            interval.most_inverse[k] = halves(sign * most, -sign * most);
            // Twice that of a single ray, as in the twin, since one more difference is rounded.
            let largest = crate::math::max(low.abs(), high.abs()) + extent;
            interval.widening[k] = _mm512_set1_ps(2.0 * ROUNDING * (largest * most));
        }
        interval
    }

    /// Which of the eight boxes of a node any ray can hit before `best_wide`, the farthest of the rays' closest hits, widened.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn test(&self, node: &Node, best_wide: f32) -> u8 {
        let mut distances = self.start;
        for k in 0..3 {
            let sides = _mm512_permutexvar_ps(self.order[k], load_sides(&node.bounds[k]));
            let off = _mm512_sub_ps(sides, self.origin[k]);
            let (one, other) = (_mm512_mul_ps(off, self.least_inverse[k]), _mm512_mul_ps(off, self.most_inverse[k]));
            let least = _mm512_sub_ps(_mm512_min_ps(one, other), self.widening[k]);
            // The first one may be NaN, and then bounds nothing.
            distances = _mm512_max_ps(least, distances);
        }
        let entry = _mm512_castps512_ps256(distances);
        let exit = _mm256_mul_ps(_mm512_extractf32x8_ps::<1>(distances), _mm256_set1_ps(-WIDENING));
        _mm256_cmp_ps_mask::<_CMP_LE_OQ>(entry, _mm256_min_ps(exit, _mm256_set1_ps(best_wide)))
    }
}
