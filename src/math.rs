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

/// Coefficients of atan(q) / (2 pi q) in q^2, for q in [0, 1]: interpolated at Chebyshev nodes, error below 4e-8 turns.
pub const ATAN_POLYNOMIAL: [f32; 8] = [
    0.159_154_92,
    -0.053_049_23,
    0.031_778_406,
    -0.022_286_93,
    0.015_706_787,
    -0.009_363_046,
    0.003_784_787,
    -0.000_725_713_44,
];
/// Coefficients of acos(y) / (pi sqrt(1 - y)) in y, for y in [0, 1]: interpolated at Chebyshev nodes, error below 4e-6.
pub const ACOS_POLYNOMIAL: [f32; 5] = [0.499_996_54, -0.068_134_43, 0.026_834_741, -0.011_199_181, 0.002_662_518_8];

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

/// The angle of the vector (`x`, `y`) from the x axis towards the y axis, in turns, in [0, 1); 0 for the zero vector.
/// Absolute error below 1e-7 turns. Both arguments finite.
#[inline]
pub fn atan2_turns(y: f32, x: f32) -> f32 {
    let (a, b) = (y.abs(), x.abs());
    let (low, high) = (min(a, b), max(a, b));
    let q = if high > 0.0 { low / high } else { 0.0 };
    let q2 = q * q;
    let [c0, c1, c2, c3, c4, c5, c6, c7] = ATAN_POLYNOMIAL;
    let octant = q * (c0 + q2 * (c1 + q2 * (c2 + q2 * (c3 + q2 * (c4 + q2 * (c5 + q2 * (c6 + q2 * c7)))))));
    let quarter = if a > b { 0.25 - octant } else { octant };
    let half = if x < 0.0 { 0.5 - quarter } else { quarter };
    let turns = if y < 0.0 { 1.0 - half } else { half };
    if turns < 1.0 { turns } else { 0.0 }
}

/// The angle, in half turns, that a direction with the given `versine` (one minus the cosine, in [0, 1]) makes with the
/// axis, in [0, 1/2]. Error below 1e-5 of it: enough to find a row of a table, whose edges then decide
/// ([`crate::tables::lights::environment`]).
#[inline]
pub fn polar_half_turns(versine: f32) -> f32 {
    let y = 1.0 - versine;
    let [c0, c1, c2, c3, c4] = ACOS_POLYNOMIAL;
    versine.sqrt() * (c0 + y * (c1 + y * (c2 + y * (c3 + y * c4))))
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
    fn angles_are_close_to_f64_everywhere() {
        for i in 0..=400_000u32 {
            let (y, x) = (i as f64 * 1e-4).sin_cos();
            let (y, x) = (y as f32 * 3.0, x as f32 * 3.0);
            let wanted = (y as f64).atan2(x as f64) / std::f64::consts::TAU;
            let error = (atan2_turns(y, x) as f64 - wanted).rem_euclid(1.0);
            assert!(error.min(1.0 - error) < 1e-7, "{y} {x}: {error}");
            // From the pole to the equator, evenly in the angle and next to the pole in its logarithm.
            let part = i as f64 / 400_000.0;
            for angle in [part * std::f64::consts::FRAC_PI_2, 1e-15f64.powf(part)] {
                let versine = (2.0 * (0.5 * angle).sin().powi(2)) as f32;
                let exact = 2.0 * (0.5 * versine as f64).sqrt().asin() / std::f64::consts::PI;
                let error = polar_half_turns(versine) as f64 / exact - 1.0;
                assert!(versine == 0.0 || error.abs() < 1e-5, "{versine}: {error}");
            }
        }
        for (y, x, turns) in [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.25), (0.0, -1.0, 0.5), (-1.0, -0.0, 0.75)]
        {
            assert_eq!(atan2_turns(y, x), turns);
        }
        assert_eq!((atan2_turns(-1e-30, 1.0), atan2_turns(-0.0, 1.0)), (0.0, 0.0), "never a whole turn");
        assert_eq!(polar_half_turns(0.0), 0.0);
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
