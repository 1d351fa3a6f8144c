//! Eight booleans, and what they choose.

use super::types::{F32x8, Mask8, U32x8, binary_operator};
use std::ops::{BitAnd, BitOr, BitXor};
use wide::u32x8;

binary_operator!(Mask8, BitAnd, bitand);
binary_operator!(Mask8, BitOr, bitor);
binary_operator!(Mask8, BitXor, bitxor);

impl Mask8 {
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
