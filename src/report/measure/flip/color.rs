//! Colours as FLIP sees them (section 4.1 of the paper of 2020).
//!
//! Filtering happens in an opponent space that is linear in light, the comparison in CIELAB, whose distances are about
//! those that the eye sees. Chroma is scaled by lightness (Hunt: dark colours look less colourful), and distances are
//! HyAB: lightness and chroma apart, which holds for large differences, too.

use glam::{DMat3, DVec3, Vec3Swizzles as _};
use std::sync::LazyLock;

/// The exponent that compresses large differences, q_c.
const COMPRESSION: f64 = 0.7;
/// Differences up to this share of the largest, p_c, ..
const SMALL_SHARE: f64 = 0.4;
/// .. fill the error up to this, p_t; the rest is left to what is larger.
const SMALL_ERROR: f64 = 0.95;

/// Linear Rec.709 to CIE XYZ divided by that of D65 white, the sum of each row: white becomes (1, 1, 1).
static XYZ_FROM_RGB: LazyLock<DMat3> = LazyLock::new(|| {
    // The exact form of the primaries and the white of Rec.709; columns are red, green and blue.
    let red = DVec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0);
    let green = DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0);
    let blue = DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0);
    let white = red + green + blue;
    DMat3::from_cols(red / white, green / white, blue / white)
});

static RGB_FROM_XYZ: LazyLock<DMat3> = LazyLock::new(|| XYZ_FROM_RGB.inverse());

/// The largest compressed distance within Rec.709: from green to blue.
static LARGEST: LazyLock<f64> = LazyLock::new(|| {
    let [green, blue] = [DVec3::Y, DVec3::Z].map(|rgb| hunt_lab(*XYZ_FROM_RGB * rgb));
    libm::pow(hyab(green, blue), COMPRESSION)
});

/// Displayed linear Rec.709 to (achromatic, red-green, blue-yellow): (y, x - y, y - z) of XYZ relative to white. This
/// is YCxCz without its factors and its offset, which filters of sum 1 leave as they are; achromatic is in [0, 1].
pub fn opponent(rgb: DVec3) -> DVec3 {
    let xyz = *XYZ_FROM_RGB * rgb;
    DVec3::new(xyz.y, xyz.x - xyz.y, xyz.y - xyz.z)
}

/// A filtered opponent colour to CIELAB with Hunt's adjustment; what filtering brought out of gamut is cut to it.
pub fn perceived(opponent: DVec3) -> DVec3 {
    let xyz = DVec3::new(opponent.x + opponent.y, opponent.x, opponent.x - opponent.z);
    let rgb = (*RGB_FROM_XYZ * xyz).clamp(DVec3::ZERO, DVec3::ONE);
    hunt_lab(*XYZ_FROM_RGB * rgb)
}

/// CIELAB of XYZ relative to white, a and b scaled by L / 100.
fn hunt_lab(xyz: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > DELTA * DELTA * DELTA { libm::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let (x, y, z) = (f(xyz.x), f(xyz.y), f(xyz.z));
    let lightness = 116.0 * y - 16.0;
    DVec3::new(lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z))
}

/// The HyAB distance: that of lightness plus that of chroma.
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let difference = a - b;
    difference.x.abs() + difference.yz().length()
}

/// The difference of two colours as [`perceived`], in [0, 1].
pub fn difference(a: DVec3, b: DVec3) -> f64 {
    let (distance, small) = (libm::pow(hyab(a, b), COMPRESSION), SMALL_SHARE * *LARGEST);
    if distance < small {
        distance * SMALL_ERROR / small
    } else {
        SMALL_ERROR + (distance - small) / (*LARGEST - small) * (1.0 - SMALL_ERROR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_is_one_and_none_is_zero() {
        let [green, blue, white] = [DVec3::Y, DVec3::Z, DVec3::ONE].map(|rgb| perceived(opponent(rgb)));
        assert!((difference(green, blue) - 1.0).abs() < 1e-12);
        assert_eq!(difference(blue, blue), 0.0);
        // White is L = 100 without chroma.
        assert!((white - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-10, "{white}");
    }

    #[test]
    fn opponent_colours_come_back_to_gamut() {
        for rgb in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.2, 0.7, 0.1), DVec3::ONE] {
            let direct = hunt_lab(*XYZ_FROM_RGB * rgb);
            assert!((perceived(opponent(rgb)) - direct).length() < 1e-10);
        }
        // Brighter than white is white.
        let white = perceived(opponent(DVec3::ONE));
        assert!((perceived(opponent(DVec3::splat(1.5))) - white).length() < 1e-10);
    }
}
