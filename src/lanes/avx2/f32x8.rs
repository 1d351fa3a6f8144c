//! Eight `f32`.

use super::types::{F32x8, Mask8, U32x8, avx2, binary_operator};
use crate::lanes::LANES;
use std::arch::x86_64::*;
use std::mem::transmute;

binary_operator!(F32x8, Add, add, _mm256_add_ps);
binary_operator!(F32x8, Sub, sub, _mm256_sub_ps);
binary_operator!(F32x8, Mul, mul, _mm256_mul_ps);
binary_operator!(F32x8, Div, div, _mm256_div_ps);

impl F32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self::from_array([0.0; LANES]);
    /// Eight ones.
    pub const ONE: Self = Self::from_array([1.0; LANES]);

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self(avx2!(_mm256_set1_ps(value)))
    }
    /// Lane `i` is `values[i]`.
    #[inline(always)]
    pub const fn from_array(values: [f32; LANES]) -> Self {
        // SAFETY: both are 32 bytes, and any are a value.
        Self(unsafe { transmute::<[f32; LANES], __m256>(values) })
    }
    /// `[i]` is lane `i`.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        // SAFETY: both are 32 bytes, and any are a value.
        unsafe { transmute::<__m256, [f32; LANES]>(self.0) }
    }
    /// The bit patterns.
    #[inline(always)]
    pub fn to_bits(self) -> U32x8 {
        U32x8(avx2!(_mm256_castps_si256(self.0)))
    }
    /// Values of the given bit patterns.
    #[inline(always)]
    pub fn from_bits(bits: U32x8) -> Self {
        Self(avx2!(_mm256_castsi256_ps(bits.0)))
    }
    /// Square root, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(avx2!(_mm256_sqrt_ps(self.0)))
    }
    /// The largest whole number that is not larger: exact.
    #[inline(always)]
    pub fn floor(self) -> Self {
        Self(avx2!(_mm256_floor_ps(self.0)))
    }
    /// `if self < other { self } else { other }`, signed zeros and NaN included.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(avx2!(_mm256_min_ps(self.0, other.0)))
    }
    /// `if self > other { self } else { other }`, signed zeros and NaN included.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_ps(self.0, other.0)))
    }
    /// `self < other`, false where either is NaN.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)))
    }
    /// `self <= other`, false where either is NaN.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)))
    }
    /// `self > other`, false where either is NaN.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0)))
    }
    /// `self >= other`, false where either is NaN.
    #[inline(always)]
    pub fn ge(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_cmp_ps::<_CMP_GE_OQ>(self.0, other.0)))
    }
    /// `self == other` (`-0.0 == 0.0`), false where either is NaN.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0)))
    }
    /// `self * factor + addend`, fused: **not the same bits at every level**, so only for what cannot change a result
    /// (conservative box tests, statistics).
    #[inline(always)]
    pub fn loose_mul_add(self, factor: Self, addend: Self) -> Self {
        Self(avx2!(_mm256_fmadd_ps(self.0, factor.0, addend.0)))
    }
    /// `self * factor - subtrahend`, under the law of [`F32x8::loose_mul_add`].
    #[inline(always)]
    pub fn loose_mul_sub(self, factor: Self, subtrahend: Self) -> Self {
        Self(avx2!(_mm256_fmsub_ps(self.0, factor.0, subtrahend.0)))
    }
    /// Crosses lanes: `rows[i]` lane `j` goes to result `j` lane `i`.
    #[inline(always)]
    pub fn transpose(rows: [F32x8; LANES]) -> [F32x8; LANES] {
        let [a, b, c, d, e, f, g, h] = rows;
        // Pairs of rows interleaved, then pairs of those, then halves exchanged.
        let low = |a: Self, b: Self| Self(avx2!(_mm256_unpacklo_ps(a.0, b.0)));
        let high = |a: Self, b: Self| Self(avx2!(_mm256_unpackhi_ps(a.0, b.0)));
        let firsts = |a: Self, b: Self| Self(avx2!(_mm256_shuffle_ps::<0b01_00_01_00>(a.0, b.0)));
        let seconds = |a: Self, b: Self| Self(avx2!(_mm256_shuffle_ps::<0b11_10_11_10>(a.0, b.0)));
        let (ab, cd, ef, gh) = (low(a, b), low(c, d), low(e, f), low(g, h));
        let (ab2, cd2, ef2, gh2) = (high(a, b), high(c, d), high(e, f), high(g, h));
        let top = [firsts(ab, cd), seconds(ab, cd), firsts(ab2, cd2), seconds(ab2, cd2)];
        let bottom = [firsts(ef, gh), seconds(ef, gh), firsts(ef2, gh2), seconds(ef2, gh2)];
        let left = |k: usize| Self(avx2!(_mm256_permute2f128_ps::<0x20>(top[k].0, bottom[k].0)));
        let right = |k: usize| Self(avx2!(_mm256_permute2f128_ps::<0x31>(top[k].0, bottom[k].0)));
        [left(0), left(1), left(2), left(3), right(0), right(1), right(2), right(3)]
    }
}
