//! Eight `u32`.

use super::types::{F32x8, LANES, Mask8, U32x8, binary_operator};
use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};
use wide::{f32x8, i32x8, u8x32, u32x8};

binary_operator!(U32x8, Add, add);
binary_operator!(U32x8, Sub, sub);
binary_operator!(U32x8, Mul, mul);
binary_operator!(U32x8, BitAnd, bitand);
binary_operator!(U32x8, BitOr, bitor);
binary_operator!(U32x8, BitXor, bitxor);

impl U32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self(u32x8::ZERO);

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: u32) -> Self {
        Self(u32x8::splat(value))
    }
    /// Lane `i` is `values[i]`.
    #[inline(always)]
    pub fn from_array(values: [u32; LANES]) -> Self {
        Self(u32x8::new(values))
    }
    /// `[i]` is lane `i`.
    #[inline(always)]
    pub fn to_array(self) -> [u32; LANES] {
        self.0.to_array()
    }
    /// `self == other`.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8 {
        Mask8(bytemuck::cast(self.0.simd_eq(other.0)))
    }
    /// `self < other` as signed numbers; the same as unsigned where both are below 2^31.
    #[inline(always)]
    pub fn lt_signed(self, other: Self) -> Mask8 {
        let (a, b): (i32x8, i32x8) = (bytemuck::cast(self.0), bytemuck::cast(other.0));
        Mask8(bytemuck::cast(a.simd_lt(b)))
    }
    /// The values as `f32`, exact below 2^24; must be below 2^31.
    #[inline(always)]
    pub fn to_f32(self) -> F32x8 {
        F32x8(f32x8::from_i32x8(bytemuck::cast(self.0)))
    }
    /// The upper half of the 64-bit product.
    #[inline(always)]
    pub fn multiply_high(self, other: Self) -> Self {
        Self(self.0.mul_keep_high(other.0))
    }
    /// Truncates; every lane must hold a finite value of 0 or more, below 2^31.
    #[inline(always)]
    pub fn from_f32(values: F32x8) -> Self {
        Self(bytemuck::cast(values.0.fast_trunc_int()))
    }
    /// The smaller, as signed numbers.
    #[inline(always)]
    pub fn min_signed(self, other: Self) -> Self {
        let (a, b): (i32x8, i32x8) = (bytemuck::cast(self.0), bytemuck::cast(other.0));
        Self(bytemuck::cast(a.min(b)))
    }
    /// The larger, as signed numbers.
    #[inline(always)]
    pub fn max_signed(self, other: Self) -> Self {
        let (a, b): (i32x8, i32x8) = (bytemuck::cast(self.0), bytemuck::cast(other.0));
        Self(bytemuck::cast(a.max(b)))
    }
    /// Lane by lane, `self >> counts`; every count must be below 32.
    #[inline(always)]
    pub fn shift_right_each(self, counts: Self) -> Self {
        Self(self.0 >> counts.0)
    }
    /// Every byte `b` becomes `table[b]`; all must be below 16.
    #[inline(always)]
    pub fn look_up_bytes(self, table: [u8; 16]) -> Self {
        let table = u8x32::new(std::array::from_fn(|i| table[i % 16]));
        Self(bytemuck::cast(table.swizzle_half_relaxed(bytemuck::cast(self.0))))
    }
    /// Bit 0 becomes bit 31, bit 1 bit 30 and so on.
    #[inline(always)]
    pub fn reverse_bits(self) -> Self {
        if cfg!(target_feature = "avx2") {
            /// Half bytes, mirrored.
            const MIRRORED: [u8; 16] = [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15];
            let half = Self::splat(0x0f0f_0f0f);
            let low = (self & half).look_up_bytes(MIRRORED.map(|bits| bits << 4));
            let mirrored: u8x32 = bytemuck::cast((low | (self >> 4 & half).look_up_bytes(MIRRORED)).0);
            let bytes = u8x32::new(std::array::from_fn(|i| (i % 16) as u8 ^ 3));
            return Self(bytemuck::cast(mirrored.swizzle_half_relaxed(bytes)));
        }
        let swap = |x: Self, bits: u32, mask: u32| {
            let mask = Self::splat(mask);
            (x >> bits & mask) | (x & mask) << bits
        };
        let bytes = swap(swap(swap(self, 1, 0x5555_5555), 2, 0x3333_3333), 4, 0x0f0f_0f0f);
        let halves = swap(bytes, 8, 0x00ff_00ff);
        halves >> 16 | halves << 16
    }
    /// Crosses lanes: lane `i` becomes lane `indices[i]`; every index must be below 8.
    #[inline(always)]
    pub fn permute(self, indices: U32x8) -> Self {
        Self(self.0.shuffle(indices.0))
    }
}

impl Shl<u32> for U32x8 {
    type Output = Self;
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Self(self.0 << bits)
    }
}
impl Shr<u32> for U32x8 {
    type Output = Self;
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }
}

/// How many of 16 values are at most `most`.
#[inline(always)]
pub fn count_at_most(values: &[u16; 16], most: u16) -> u32 {
    wide::u16x16::new(*values).simd_le(wide::u16x16::splat(most)).to_bitmask().count_ones()
}
