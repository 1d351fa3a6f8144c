//! Linear Rec.709 radiance to and from the sRGB numbers of PNG files.
//!
//! Powers go through `libm` in f64, so a PNG has the same bytes on every system.

/// The sRGB transfer function (IEC 61966-2-1): linear light in [0, 1] to a display value in [0, 1].
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_from_linear`]: a display value in [0, 1] to linear light.
pub fn linear_from_srgb(display: f64) -> f64 {
    if display <= 0.040_45 { display / 12.92 } else { libm::pow((display + 0.055) / 1.055, 2.4) }
}

/// Radiance as an 8-bit sRGB value, after `exposure` stops: what exceeds 1 becomes 255, what is below 0 or NaN becomes 0.
pub fn srgb8(radiance: f32, exposure: f64) -> u8 {
    let scaled = radiance as f64 * libm::exp2(exposure);
    if scaled >= 1.0 {
        255
    } else if scaled > 0.0 {
        (srgb_from_linear(scaled) * 255.0 + 0.5) as u8
    } else {
        0
    }
}

/// Luminance (CIE Y) of a linear Rec.709 colour.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    0.212_6 * rgb[0] + 0.715_2 * rgb[1] + 0.072_2 * rgb[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_has_the_standard_values() {
        assert_eq!([0.0, 1.0, 2.0, f32::INFINITY].map(|v| srgb8(v, 0.0)), [0, 255, 255, 255]);
        assert_eq!([-1.0, f32::NAN].map(|v| srgb8(v, 0.0)), [0, 0]);
        // Middle grey 0.18 is 46.135 % on the display; half of full light is 188.
        assert!((srgb_from_linear(0.18) - 0.461_356).abs() < 1e-6);
        assert_eq!((srgb8(0.5, 0.0), srgb8(0.25, 1.0), srgb8(1.0, -1.0)), (188, 188, 188));
        // The straight part: 0.002 * 12.92 * 255 = 6.59.
        assert_eq!(srgb8(0.002, 0.0), 7);
    }

    #[test]
    fn every_8_bit_value_survives_a_round_trip() {
        for value in 0..=255u8 {
            assert_eq!(srgb8(linear_from_srgb(value as f64 / 255.0) as f32, 0.0), value);
        }
    }

    #[test]
    fn white_has_luminance_one() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-12);
    }
}
