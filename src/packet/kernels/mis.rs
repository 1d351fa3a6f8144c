//! Weights of multiple importance sampling (Veach 1997, section 9.2), eight at a time, as ratios that cannot overflow.

use super::here;
use crate::fault::{Fault, planted};
use crate::strategy::Weight;
use here::lanes::F32x8;

/// The balance heuristic: weights of samples drawn with densities `p_a`, where the other technique would have had `p_b`.
#[inline(always)]
pub fn balance(p_a: F32x8, p_b: F32x8) -> F32x8 {
    F32x8::ONE / (F32x8::ONE + ratio(p_a, p_b))
}

/// The power heuristic with beta = 2.
#[inline(always)]
pub fn power(p_a: F32x8, p_b: F32x8) -> F32x8 {
    let ratio = ratio(p_a, p_b);
    F32x8::ONE / (F32x8::ONE + ratio * ratio)
}

/// The other technique's density over this one's.
#[inline(always)]
fn ratio(p_a: F32x8, p_b: F32x8) -> F32x8 {
    if planted(Fault::DensityTwice) { F32x8::splat(2.0) * p_b / p_a } else { p_b / p_a }
}

/// What samples drawn with density `p_a` count by a strategy's rule, where the other technique would have had `p_b`.
#[inline(always)]
pub fn weigh(rule: Weight, p_a: F32x8, p_b: F32x8) -> F32x8 {
    match rule {
        Weight::Zero => F32x8::ZERO,
        Weight::One => F32x8::ONE,
        Weight::Half => F32x8::splat(0.5),
        Weight::Balance => balance(p_a, p_b),
        Weight::TwiceBalance => F32x8::splat(2.0) * balance(p_a, p_b),
        Weight::Power => power(p_a, p_b),
    }
}
