//! Eight booleans, and what they choose.

use super::types::{F32x8, LANES, Mask8, U32x8, binary_operator};
use std::ops::{BitAnd, BitOr, BitXor};
use wide::{f32x8, u32x8};

binary_operator!(Mask8, BitAnd, bitand);
binary_operator!(Mask8, BitOr, bitor);
binary_operator!(Mask8, BitXor, bitxor);

impl Mask8 {
    /// No lane.
    pub const NONE: Self = Self(f32x8::ZERO);
    /// Every lane.
    pub const ALL: Self = Self(f32x8::new([f32::from_bits(u32::MAX); LANES]));

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
    /// Bit `i` is lane `i`.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        self.0.to_bitmask() as u8
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
}
