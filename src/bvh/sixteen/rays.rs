//! Sixteen rays.

use crate::bvh::ray::{LONGEST_DIRECTION, RayQueue, SHORTEST_DIRECTION};
use crate::bvh::sixteen::registers::load_rows;
use std::arch::x86_64::*;

/// Sixteen rays, of which those that are not followed are copies of one that is, and hit nothing.
#[derive(Clone, Copy)]
pub(super) struct Rays {
    pub(super) origin: [__m512; 3],
    pub(super) direction: [__m512; 3],
    pub(super) tmin: __m512,
    pub(super) tmax: __m512,
    /// Those that are followed: asked about, made of numbers, their directions in range.
    pub(super) active: u16,
    /// `tmax` as it was given.
    pub(super) given: __m512,
}

impl Rays {
    /// Rays `first .. first + count` of a queue, `count` up to 16: [`crate::bvh::RayPacket::finite`] and
    /// [`crate::bvh::RayPacket::without_garbage`] of two packets.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn of(queue: &RayQueue, first: usize, count: usize) -> Self {
        let column = |values: &[f32]| load_rows(values, first, count);
        let given = column(&queue.tmax);
        let mut rays = Self {
            origin: [column(&queue.ox), column(&queue.oy), column(&queue.oz)],
            direction: [column(&queue.dx), column(&queue.dy), column(&queue.dz)],
            tmin: column(&queue.tmin),
            tmax: given,
            active: 0,
            given,
        };
        rays.active = rays.finite() & ((1u32 << count) - 1) as u16;
        if rays.active != 0xffff && rays.active != 0 {
            rays.fill_idle();
        }
        rays
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn finite(&self) -> u16 {
        let zero = _mm512_setzero_ps();
        let times_0 = |v: __m512| _mm512_mul_ps(v, zero);
        let ([ox, oy, oz], [dx, dy, dz]) = (self.origin, self.direction);
        let nothing = _mm512_add_ps(
            _mm512_add_ps(_mm512_add_ps(times_0(ox), times_0(oy)), _mm512_add_ps(times_0(oz), times_0(dx))),
            _mm512_add_ps(times_0(dy), times_0(dz)),
        );
        let longest = _mm512_max_ps(_mm512_max_ps(_mm512_abs_ps(dx), _mm512_abs_ps(dy)), _mm512_abs_ps(dz));
        _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(nothing, zero)
            & _mm512_cmp_ps_mask::<_CMP_GE_OQ>(longest, _mm512_set1_ps(SHORTEST_DIRECTION))
            & _mm512_cmp_ps_mask::<_CMP_LE_OQ>(longest, _mm512_set1_ps(LONGEST_DIRECTION))
            & _mm512_cmp_ps_mask::<_CMP_ORD_Q>(self.tmin, self.tmax)
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn fill_idle(&mut self) {
        let from = _mm512_set1_epi32(self.active.trailing_zeros() as i32);
        for k in 0..3 {
            self.origin[k] = _mm512_mask_permutexvar_ps(self.origin[k], !self.active, from, self.origin[k]);
            self.direction[k] = _mm512_mask_permutexvar_ps(self.direction[k], !self.active, from, self.direction[k]);
        }
        self.tmin = _mm512_mask_mov_ps(_mm512_set1_ps(f32::INFINITY), self.active, self.tmin);
        self.tmax = _mm512_mask_mov_ps(_mm512_set1_ps(f32::NEG_INFINITY), self.active, self.tmax);
    }

    /// [`crate::simd::native::walks::triangle::reach`] of each.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn reach(&self, extent: f32) -> __m512 {
        let [x, y, z] = self.origin;
        let farthest = _mm512_max_ps(_mm512_max_ps(_mm512_abs_ps(x), _mm512_abs_ps(y)), _mm512_abs_ps(z));
        _mm512_max_ps(farthest, _mm512_set1_ps(extent))
    }
}

/// `value` with the sign flipped where `sign` says.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn negated(value: __m512) -> __m512 {
    _mm512_xor_ps(value, _mm512_set1_ps(-0.0))
}
