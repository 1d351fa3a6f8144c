//! What lanes of every level can do by operations that differ between levels.

use super::compress::COMPRESS;
use super::types::{F32x8, Mask8, U32x8};
use super::vec3::Vec3x8;
use crate::lanes::LANES;
use std::ops::{Neg, Not};

impl Neg for F32x8 {
    type Output = Self;
    /// Flips the sign bit (so `-0.0` of `0.0`, and of NaN its sign), as scalar negation does.
    #[inline(always)]
    fn neg(self) -> Self {
        F32x8::from_bits(self.to_bits() ^ U32x8::splat(0x8000_0000))
    }
}

impl F32x8 {
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
    /// Absolute value (clears the sign bit).
    #[inline(always)]
    pub fn abs(self) -> Self {
        F32x8::from_bits(self.to_bits() & U32x8::splat(0x7fff_ffff))
    }
    /// Magnitudes of `self`, sign bits of `sign`.
    #[inline(always)]
    pub fn copysign(self, sign: Self) -> Self {
        let top = U32x8::splat(0x8000_0000);
        F32x8::from_bits((self.to_bits() & U32x8::splat(0x7fff_ffff)) | (sign.to_bits() & top))
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

impl U32x8 {
    /// `0, 1, .. 7`.
    #[inline(always)]
    pub fn lane_numbers() -> Self {
        Self::from_array([0, 1, 2, 3, 4, 5, 6, 7])
    }
    /// Lane `i` is `values[first + i]`; panics if fewer than eight are left.
    #[inline(always)]
    pub fn load(values: &[u32], first: usize) -> Self {
        let block: &[u32; LANES] = values[first..first + LANES].try_into().expect("eight values");
        Self::from_array(*block)
    }
    /// `values[first + i]` becomes lane `i`; panics if there is no room for eight.
    #[inline(always)]
    pub fn store(self, values: &mut [u32], first: usize) {
        let block: &mut [u32; LANES] = (&mut values[first..first + LANES]).try_into().expect("eight values");
        *block = self.to_array();
    }
    /// `self < other` as unsigned numbers.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask8 {
        let flip = U32x8::splat(0x8000_0000);
        (self ^ flip).lt_signed(other ^ flip)
    }
    /// Crosses lanes: the lanes of `mask` (bit `i`: lane `i`) move to the front in order; what follows them is unspecified.
    #[inline(always)]
    pub fn compress(self, mask: u8) -> Self {
        self.permute(Self::from_array(COMPRESS[mask as usize]))
    }
    /// Reads memory at eight places: lane `i` is `table[indices[i]]`. Every index must lie in the table.
    #[inline(always)]
    pub fn gather(table: &[u32], indices: U32x8) -> Self {
        let at = indices.to_array();
        Self::from_array(std::array::from_fn(|lane| table[at[lane] as usize]))
    }
}

impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        self ^ Mask8::ALL
    }
}

impl Mask8 {
    /// No lane.
    pub const NONE: Self = Self(F32x8::ZERO.0);
    /// Every lane.
    pub const ALL: Self = Self::from_lanes([true; LANES]);

    /// Lane `i` is `lanes[i]`.
    #[inline(always)]
    pub const fn from_lanes(lanes: [bool; LANES]) -> Self {
        let mut values = [0.0; LANES];
        let mut lane = 0;
        while lane < LANES {
            values[lane] = f32::from_bits(if lanes[lane] { u32::MAX } else { 0 });
            lane += 1;
        }
        Self(F32x8::from_array(values).0)
    }
    /// Lane `i` is bit `i`.
    #[inline(always)]
    pub fn from_bits(bits: u8) -> Self {
        let lane_bits = U32x8::from_array([1, 2, 4, 8, 16, 32, 64, 128]);
        (U32x8::splat(bits as u32) & lane_bits).eq(lane_bits)
    }
    /// Lane `i` is `i < count`.
    #[inline(always)]
    pub fn first(count: usize) -> Self {
        U32x8::lane_numbers().lt_signed(U32x8::splat(count as u32))
    }
    /// Whether any lane is true.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.bits() != 0
    }
    /// Whether every lane is true.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.bits() == 0xff
    }
    /// How many lanes are true.
    #[inline(always)]
    pub fn count(self) -> u32 {
        self.bits().count_ones()
    }
    /// True here and not in `other`.
    #[inline(always)]
    pub fn and_not(self, other: Self) -> Self {
        self & !other
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select_vec3(self, yes: Vec3x8, no: Vec3x8) -> Vec3x8 {
        Vec3x8 { x: self.select(yes.x, no.x), y: self.select(yes.y, no.y), z: self.select(yes.z, no.z) }
    }
}
