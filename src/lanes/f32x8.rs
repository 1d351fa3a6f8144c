//! Eight `f32`.

use crate::lanes::types::{F32x8, LANES, Mask8, U32x8, binary_operator};
use std::ops::{Add, Div, Mul, Neg, Sub};
use wide::f32x8;

binary_operator!(F32x8, Add, add);
binary_operator!(F32x8, Sub, sub);
binary_operator!(F32x8, Mul, mul);
binary_operator!(F32x8, Div, div);

impl Neg for F32x8 {
    type Output = Self;
    /// Flips the sign bit (so `-0.0` of `0.0`, and of NaN its sign), as scalar negation does.
    #[inline(always)]
    fn neg(self) -> Self {
        F32x8::from_bits(self.to_bits() ^ U32x8::splat(0x8000_0000))
    }
}

impl F32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self(f32x8::ZERO);
    /// Eight ones.
    pub const ONE: Self = Self(f32x8::ONE);

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self(f32x8::splat(value))
    }
    /// Lane `i` is `values[i]`.
    #[inline(always)]
    pub fn from_array(values: [f32; LANES]) -> Self {
        Self(f32x8::new(values))
    }
    /// `[i]` is lane `i`.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        self.0.to_array()
    }
    /// Lane `i` is `values[first + i]`; panics if fewer than eight are left.
    #[inline(always)]
    pub fn load(values: &[f32], first: usize) -> Self {
        let block: &[f32; LANES] = values[first..first + LANES].try_into().expect("eight values");
        Self::from_array(*block)
    }
    /// `values[first + i]` becomes lane `i`; panics if there is no room for eight.
    #[inline(always)]
    pub fn store(self, values: &mut [f32], first: usize) {
        let block: &mut [f32; LANES] = (&mut values[first..first + LANES]).try_into().expect("eight values");
        *block = self.to_array();
    }
    /// The bit patterns.
    #[inline(always)]
    pub fn to_bits(self) -> U32x8 {
        U32x8(bytemuck::cast(self.0))
    }
    /// Values of the given bit patterns.
    #[inline(always)]
    pub fn from_bits(bits: U32x8) -> Self {
        Self(bytemuck::cast(bits.0))
    }
    /// Absolute value (clears the sign bit).
    #[inline(always)]
    pub fn abs(self) -> Self {
        F32x8::from_bits(self.to_bits() & U32x8::splat(0x7fff_ffff))
    }
    /// Square root, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    /// The largest whole number that is not larger: exact.
    #[inline(always)]
    pub fn floor(self) -> Self {
        Self(self.0.floor())
    }
    /// `if self < other { self } else { other }`, the crate's one definition ([`crate::math::min`]).
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            // `minps` is that definition, signed zeros and NaN included (tests/operations/lanes.rs tries every pair).
            Self(self.0.fast_min(other.0))
        } else {
            self.lt(other).select(self, other)
        }
    }
    /// `if self > other { self } else { other }`, the crate's one definition ([`crate::math::max`]).
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") { Self(self.0.fast_max(other.0)) } else { self.gt(other).select(self, other) }
    }
    /// `self < other`, false where either is NaN.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_lt(other.0))
    }
    /// `self <= other`, false where either is NaN.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_le(other.0))
    }
    /// `self > other`, false where either is NaN.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_gt(other.0))
    }
    /// `self >= other`, false where either is NaN.
    #[inline(always)]
    pub fn ge(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_ge(other.0))
    }
    /// `self == other` (`-0.0 == 0.0`), false where either is NaN.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_eq(other.0))
    }
    /// Magnitudes of `self`, sign bits of `sign`.
    #[inline(always)]
    pub fn copysign(self, sign: Self) -> Self {
        let top = U32x8::splat(0x8000_0000);
        F32x8::from_bits((self.to_bits() & U32x8::splat(0x7fff_ffff)) | (sign.to_bits() & top))
    }
    /// `self * factor + addend`, fused where this build has FMA, else rounded twice: **not the same bits in every build**,
    /// so only for what cannot change a result (conservative box tests, statistics).
    #[inline(always)]
    pub fn loose_mul_add(self, factor: Self, addend: Self) -> Self {
        Self(self.0.mul_add(factor.0, addend.0))
    }
    /// `self * factor - subtrahend`, under the law of [`F32x8::loose_mul_add`].
    #[inline(always)]
    pub fn loose_mul_sub(self, factor: Self, subtrahend: Self) -> Self {
        Self(self.0.mul_sub(factor.0, subtrahend.0))
    }
    /// Crosses lanes: the lanes of `mask` (bit `i`: lane `i`) move to the front in order; what follows them is unspecified.
    #[inline(always)]
    pub fn compress(self, mask: u8) -> Self {
        F32x8::from_bits(self.to_bits().compress(mask))
    }
    /// Crosses lanes: the least value, which must not be NaN in any lane; of -0 and +0 either.
    #[inline(always)]
    pub fn min_of_lanes(self) -> f32 {
        let swap = |v: Self, partners: [u32; LANES]| v.min(v.permute(U32x8::from_array(partners)));
        let halves = swap(self, [4, 5, 6, 7, 0, 1, 2, 3]);
        let quarters = swap(halves, [2, 3, 0, 1, 6, 7, 4, 5]);
        swap(quarters, [1, 0, 3, 2, 5, 4, 7, 6]).to_array()[0]
    }
    /// Crosses lanes: `rows[i]` lane `j` goes to result `j` lane `i`.
    #[inline(always)]
    pub fn transpose(rows: [F32x8; LANES]) -> [F32x8; LANES] {
        f32x8::transpose(rows.map(|row| row.0)).map(F32x8)
    }
    /// Crosses lanes: lane `i` becomes lane `indices[i]`; every index must be below 8.
    #[inline(always)]
    pub fn permute(self, indices: U32x8) -> Self {
        F32x8::from_bits(self.to_bits().permute(indices))
    }
    /// Reads memory at eight places: lane `i` is `table[indices[i]]`. Every index must lie in the table.
    #[inline(always)]
    pub fn gather(table: &[f32], indices: U32x8) -> Self {
        let at = indices.to_array();
        Self::from_array(std::array::from_fn(|lane| table[at[lane] as usize]))
    }
}
