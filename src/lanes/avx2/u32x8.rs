//! Eight `u32`.

use super::types::{F32x8, Mask8, U32x8, avx2, binary_operator};
use crate::lanes::LANES;
use std::arch::x86_64::*;
use std::mem::transmute;
use std::ops::{Shl, Shr};

binary_operator!(U32x8, Add, add, _mm256_add_epi32);
binary_operator!(U32x8, Sub, sub, _mm256_sub_epi32);
binary_operator!(U32x8, Mul, mul, _mm256_mullo_epi32);
binary_operator!(U32x8, BitAnd, bitand, _mm256_and_si256);
binary_operator!(U32x8, BitOr, bitor, _mm256_or_si256);
binary_operator!(U32x8, BitXor, bitxor, _mm256_xor_si256);

impl U32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self::from_array([0; LANES]);

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: u32) -> Self {
        Self(avx2!(_mm256_set1_epi32(value as i32)))
    }
    /// Lane `i` is `values[i]`.
    #[inline(always)]
    pub const fn from_array(values: [u32; LANES]) -> Self {
        // SAFETY: both are 32 bytes, and any are a value.
        Self(unsafe { transmute::<[u32; LANES], __m256i>(values) })
    }
    /// `[i]` is lane `i`.
    #[inline(always)]
    pub fn to_array(self) -> [u32; LANES] {
        // SAFETY: both are 32 bytes, and any are a value.
        unsafe { transmute::<__m256i, [u32; LANES]>(self.0) }
    }
    /// `self == other`.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_castsi256_ps(_mm256_cmpeq_epi32(self.0, other.0))))
    }
    /// `self < other` as signed numbers; the same as unsigned where both are below 2^31.
    #[inline(always)]
    pub fn lt_signed(self, other: Self) -> Mask8 {
        Mask8(avx2!(_mm256_castsi256_ps(_mm256_cmpgt_epi32(other.0, self.0))))
    }
    /// The values as `f32`, exact below 2^24; must be below 2^31.
    #[inline(always)]
    pub fn to_f32(self) -> F32x8 {
        F32x8(avx2!(_mm256_cvtepi32_ps(self.0)))
    }
    /// The upper half of the 64-bit product.
    #[inline(always)]
    pub fn multiply_high(self, other: Self) -> Self {
        let even = avx2!(_mm256_srli_epi64::<32>(_mm256_mul_epu32(self.0, other.0)));
        let odd = avx2!(_mm256_mul_epu32(_mm256_srli_epi64::<32>(self.0), _mm256_srli_epi64::<32>(other.0)));
        Self(avx2!(_mm256_blend_epi32::<0b1010_1010>(even, odd)))
    }
    /// Truncates; every lane must hold a finite value of 0 or more, below 2^31.
    #[inline(always)]
    pub fn from_f32(values: F32x8) -> Self {
        Self(avx2!(_mm256_cvttps_epi32(values.0)))
    }
    /// The smaller, as signed numbers.
    #[inline(always)]
    pub fn min_signed(self, other: Self) -> Self {
        Self(avx2!(_mm256_min_epi32(self.0, other.0)))
    }
    /// The larger, as signed numbers.
    #[inline(always)]
    pub fn max_signed(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_epi32(self.0, other.0)))
    }
    /// Lane by lane, `self >> counts`; every count must be below 32.
    #[inline(always)]
    pub fn shift_right_each(self, counts: Self) -> Self {
        Self(avx2!(_mm256_srlv_epi32(self.0, counts.0)))
    }
    /// Every byte `b` becomes `table[b]`; all must be below 16.
    #[inline(always)]
    pub fn look_up_bytes(self, table: [u8; 16]) -> Self {
        // SAFETY: both are 16 bytes, and any are a value.
        let table = unsafe { transmute::<[u8; 16], __m128i>(table) };
        Self(avx2!(_mm256_shuffle_epi8(_mm256_broadcastsi128_si256(table), self.0)))
    }
    /// Bit 0 becomes bit 31, bit 1 bit 30 and so on.
    #[inline(always)]
    pub fn reverse_bits(self) -> Self {
        /// Half bytes, mirrored.
        const MIRRORED: [u8; 16] = [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15];
        /// The bytes of four words, each word's from its last.
        const BYTES: [u32; LANES] =
            [0x0001_0203, 0x0405_0607, 0x0809_0a0b, 0x0c0d_0e0f, 0x0001_0203, 0x0405_0607, 0x0809_0a0b, 0x0c0d_0e0f];
        let half = Self::splat(0x0f0f_0f0f);
        let low = (self & half).look_up_bytes(MIRRORED.map(|bits| bits << 4));
        let mirrored = low | (self >> 4 & half).look_up_bytes(MIRRORED);
        Self(avx2!(_mm256_shuffle_epi8(mirrored.0, Self::from_array(BYTES).0)))
    }
    /// Crosses lanes: lane `i` becomes lane `indices[i]`; every index must be below 8.
    #[inline(always)]
    pub fn permute(self, indices: U32x8) -> Self {
        Self(avx2!(_mm256_permutevar8x32_epi32(self.0, indices.0)))
    }
}

impl Shl<u32> for U32x8 {
    type Output = Self;
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Self(avx2!(_mm256_sll_epi32(self.0, _mm_cvtsi32_si128(bits as i32))))
    }
}
impl Shr<u32> for U32x8 {
    type Output = Self;
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        Self(avx2!(_mm256_srl_epi32(self.0, _mm_cvtsi32_si128(bits as i32))))
    }
}

/// How many of 16 values are at most `most`.
#[inline(always)]
pub fn count_at_most(values: &[u16; 16], most: u16) -> u32 {
    // SAFETY: both are 32 bytes, and any are a value.
    let values = unsafe { transmute::<[u16; 16], __m256i>(*values) };
    // v <= m exactly where the smaller of the two is v.
    let at_most = avx2!(_mm256_cmpeq_epi16(_mm256_min_epu16(values, _mm256_set1_epi16(most as i16)), values));
    avx2!(_mm256_movemask_epi8(at_most)).count_ones() / 2
}
