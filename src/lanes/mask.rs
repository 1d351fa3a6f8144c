//! Eight booleans, and what they choose.

use crate::lanes::types::{F32x8, LANES, Mask8, U32x8, Vec3x8, binary_operator};
use std::ops::{BitAnd, BitOr, BitXor, Not};
use wide::{f32x8, u32x8};

binary_operator!(Mask8, BitAnd, bitand);
binary_operator!(Mask8, BitOr, bitor);
binary_operator!(Mask8, BitXor, bitxor);

impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        self ^ Mask8::ALL
    }
}

impl Mask8 {
    /// No lane.
    pub const NONE: Self = Self(f32x8::ZERO);
    /// Every lane.
    pub const ALL: Self = Self(f32x8::new([f32::from_bits(u32::MAX); LANES]));

    /// Lane `i` is bit `i`.
    #[inline(always)]
    pub fn from_bits(bits: u8) -> Self {
        let lane_bits = U32x8::from_array([1, 2, 4, 8, 16, 32, 64, 128]);
        (U32x8::splat(bits as u32) & lane_bits).eq(lane_bits)
    }
    /// Lane `i` is `lanes[i]`.
    #[inline(always)]
    pub const fn from_lanes(lanes: [bool; LANES]) -> Self {
        let mut values = [0.0; LANES];
        let mut lane = 0;
        while lane < LANES {
            values[lane] = f32::from_bits(if lanes[lane] { u32::MAX } else { 0 });
            lane += 1;
        }
        Self(f32x8::new(values))
    }
    /// Lane `i` is `i < count`.
    #[inline(always)]
    pub fn first(count: usize) -> Self {
        U32x8::lane_numbers().lt_signed(U32x8::splat(count as u32))
    }
    /// Bit `i` is lane `i`.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        self.0.to_bitmask() as u8
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
    pub fn select(self, yes: F32x8, no: F32x8) -> F32x8 {
        F32x8(self.0.select(yes.0, no.0))
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select_u32(self, yes: U32x8, no: U32x8) -> U32x8 {
        let mask: u32x8 = bytemuck::cast(self.0);
        U32x8(mask.select(yes.0, no.0))
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select_vec3(self, yes: Vec3x8, no: Vec3x8) -> Vec3x8 {
        Vec3x8 { x: self.select(yes.x, no.x), y: self.select(yes.y, no.y), z: self.select(yes.z, no.z) }
    }
}
