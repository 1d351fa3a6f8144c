//! Eight `f32`.

use super::types::{F32x8, LANES, Mask8, U32x8, binary_operator};
use std::ops::{Add, Div, Mul, Sub};
use wide::f32x8;

binary_operator!(F32x8, Add, add);
binary_operator!(F32x8, Sub, sub);
binary_operator!(F32x8, Mul, mul);
binary_operator!(F32x8, Div, div);

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
    pub const fn from_array(values: [f32; LANES]) -> Self {
        Self(f32x8::new(values))
    }
    /// `[i]` is lane `i`.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        self.0.to_array()
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
    /// Crosses lanes: `rows[i]` lane `j` goes to result `j` lane `i`.
    #[inline(always)]
    pub fn transpose(rows: [F32x8; LANES]) -> [F32x8; LANES] {
        f32x8::transpose(rows.map(|row| row.0)).map(F32x8)
    }
}
