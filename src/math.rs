//! Scalar mathematics of exactly rounded operations, shared by both engines.
//!
//! Vectors are glam's plain `Vec3` (f32) and `DVec3` (f64): their operations are scalar code and do not change with the
//! build. glam's SIMD types (`Vec3A`, `Mat4`, ..) do, so nothing here or in an estimator uses them.

/// `if a < b { a } else { b }`: the crate's one minimum. Unlike `f32::min` it says what happens to NaN (the second
/// argument comes back) and to signed zeros (again the second), in every build.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `if a > b { a } else { b }`: the crate's one maximum, see [`min`].
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// 1/pi, rounded to f32.
pub const INV_PI: f32 = std::f32::consts::FRAC_1_PI;
/// 1/(2 pi), rounded to f32.
pub const INV_2PI: f32 = 0.5 * std::f32::consts::FRAC_1_PI;

/// Coefficients of sin(r pi/2) / r in r^2, for r in [-1/2, 1/2]: interpolated at Chebyshev nodes, error below 9e-8.
pub const SIN_POLYNOMIAL: [f32; 4] = [1.570_796_4, -0.645_963_5, 0.079_680_22, -0.004_602_149];
/// Coefficients of cos(r pi/2) in r^2, for r in [-1/2, 1/2]: interpolated at Chebyshev nodes, error below 8e-8.
pub const COS_POLYNOMIAL: [f32; 5] = [1.0, -1.233_700_5, 0.253_669_2, -0.020_860_07, 0.000_903_628_07];

/// (sine, cosine) of `turns` whole turns, for `turns` in [0, 1]; absolute error below 1.5e-7.
///
/// Turns instead of radians: the reduction to the nearest quarter is then exact, and sampling needs no factor 2 pi.
#[inline]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let quarters = turns * 4.0;
    let quadrant = (quarters + 0.5) as u32;
    let r = quarters - quadrant as f32;
    let r2 = r * r;
    let [s0, s1, s2, s3] = SIN_POLYNOMIAL;
    let [c0, c1, c2, c3, c4] = COS_POLYNOMIAL;
    let sine = r * (s0 + r2 * (s1 + r2 * (s2 + r2 * s3)));
    let cosine = c0 + r2 * (c1 + r2 * (c2 + r2 * (c3 + r2 * c4)));
    match quadrant & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_turns_is_close_to_f64_everywhere() {
        for i in 0..=1_000_000u32 {
            let turns = i as f32 / 1e6;
            let (s, c) = sin_cos_turns(turns);
            let (s64, c64) = (turns as f64 * std::f64::consts::TAU).sin_cos();
            assert!((s as f64 - s64).abs() < 1.5e-7 && (c as f64 - c64).abs() < 1.5e-7, "{turns}: {s} {c}");
        }
    }

    #[test]
    fn min_and_max_return_the_second_argument_on_ties_and_nan() {
        assert_eq!(min(0.0, -0.0).to_bits(), (-0.0f32).to_bits());
        assert_eq!(min(-0.0, 0.0).to_bits(), 0.0f32.to_bits());
        assert_eq!(max(0.0, -0.0).to_bits(), (-0.0f32).to_bits());
        assert_eq!(min(f32::NAN, 1.0), 1.0);
        assert!(max(1.0, f32::NAN).is_nan());
    }
}
