//! Sine, cosine and angles on lanes: the polynomials of [`crate::math`], same bits.

use super::types::{F32x8, U32x8};

/// (sine, cosine) of `turns` whole turns; the lanes of [`crate::math::sin_cos_turns`], same bits.
#[inline(always)]
pub fn sin_cos_turns(turns: F32x8) -> (F32x8, F32x8) {
    use crate::math::{COS_POLYNOMIAL as C, SIN_POLYNOMIAL as S};
    let quarters = turns * F32x8::splat(4.0);
    let quadrant = U32x8::from_f32(quarters + F32x8::splat(0.5));
    let r = quarters - quadrant.to_f32();
    let r2 = r * r;
    let c = |k: f32| F32x8::splat(k);
    let sine = r * (c(S[0]) + r2 * (c(S[1]) + r2 * (c(S[2]) + r2 * c(S[3]))));
    let cosine = c(C[0]) + r2 * (c(C[1]) + r2 * (c(C[2]) + r2 * (c(C[3]) + r2 * c(C[4]))));
    let odd = (quadrant & U32x8::splat(1)).eq(U32x8::splat(1));
    let (s, c) = (odd.select(cosine, sine), odd.select(sine, cosine));
    // Quadrants 2 and 3 have negative sines, quadrants 1 and 2 negative cosines.
    let sine_sign = (quadrant & U32x8::splat(2)) << 30;
    let cosine_sign = ((quadrant + U32x8::splat(1)) & U32x8::splat(2)) << 30;
    (F32x8::from_bits(s.to_bits() ^ sine_sign), F32x8::from_bits(c.to_bits() ^ cosine_sign))
}

/// Angles of vectors in turns; the lanes of [`crate::math::atan2_turns`], same bits.
#[inline(always)]
pub fn atan2_turns(y: F32x8, x: F32x8) -> F32x8 {
    let (a, b) = (y.abs(), x.abs());
    let (low, high) = (a.min(b), a.max(b));
    let q = high.gt(F32x8::ZERO).select(low / high, F32x8::ZERO);
    let octant = q * polynomial(&crate::math::ATAN_POLYNOMIAL, q * q);
    let quarter = a.gt(b).select(F32x8::splat(0.25) - octant, octant);
    let half = x.lt(F32x8::ZERO).select(F32x8::splat(0.5) - quarter, quarter);
    let turns = y.lt(F32x8::ZERO).select(F32x8::ONE - half, half);
    turns.lt(F32x8::ONE).select(turns, F32x8::ZERO)
}

/// Angles in half turns from versines; the lanes of [`crate::math::polar_half_turns`], same bits.
#[inline(always)]
pub fn polar_half_turns(versine: F32x8) -> F32x8 {
    versine.sqrt() * polynomial(&crate::math::ACOS_POLYNOMIAL, F32x8::ONE - versine)
}

/// `c[0] + x (c[1] + x (c[2] + ..))`.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f32; N], x: F32x8) -> F32x8 {
    let last = F32x8::splat(c[N - 1]);
    let mut sum = last;
    for i in (0..N - 1).rev() {
        sum = F32x8::splat(c[i]) + x * sum;
    }
    sum
}
