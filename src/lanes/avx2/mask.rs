//! Eight booleans, and what they choose.

use super::types::{F32x8, Mask8, U32x8, avx2, binary_operator};
use std::arch::x86_64::*;

binary_operator!(Mask8, BitAnd, bitand, _mm256_and_ps);
binary_operator!(Mask8, BitOr, bitor, _mm256_or_ps);
binary_operator!(Mask8, BitXor, bitxor, _mm256_xor_ps);

impl Mask8 {
    /// Bit `i` is lane `i`.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        avx2!(_mm256_movemask_ps(self.0)) as u8
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select(self, yes: F32x8, no: F32x8) -> F32x8 {
        F32x8(avx2!(_mm256_blendv_ps(no.0, yes.0, self.0)))
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select_u32(self, yes: U32x8, no: U32x8) -> U32x8 {
        self.select(F32x8::from_bits(yes), F32x8::from_bits(no)).to_bits()
    }
}
