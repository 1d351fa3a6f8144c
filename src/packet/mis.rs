//! Weights of multiple importance sampling (Veach 1997, section 9.2), eight at a time, as ratios that cannot overflow.

use crate::lanes::F32x8;

/// The balance heuristic: weights of samples drawn with densities `p_a`, where the other technique would have had `p_b`.
#[inline(always)]
pub fn balance(p_a: F32x8, p_b: F32x8) -> F32x8 {
    F32x8::ONE / (F32x8::ONE + p_b / p_a)
}

/// The power heuristic with beta = 2.
#[inline(always)]
pub fn power(p_a: F32x8, p_b: F32x8) -> F32x8 {
    let ratio = p_b / p_a;
    F32x8::ONE / (F32x8::ONE + ratio * ratio)
}
