//! Radiance RGBE: three 8-bit mantissas and a shared exponent (Ward, "Real Pixels", Graphics Gems II, 1991).
//!
//! Written here and not through the `image` crate, whose encoder cuts mantissas off: that darkens a picture by 0.2 % on
//! average. Rounding to nearest keeps means right.

use crate::files::atomic::Sink;
use crate::film::Film;
use crate::image::Image;
use std::io;

/// Writes flat scanlines, top to bottom. Every written pixel but black has a mantissa of at least 128, so none can be
/// mistaken for a run-length marker.
pub(super) fn write(film: &Film, out: &mut dyn Sink) -> io::Result<()> {
    write!(out, "#?RADIANCE\nSOFTWARE=octray {}\n", env!("CARGO_PKG_VERSION"))?;
    write!(out, "FORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", film.height, film.width)?;
    film.means().try_for_each(|rgb| out.write_all(&rgbe(rgb)))
}

/// Nearest RGBE value: what the format cannot hold becomes 0 below and its largest value above.
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    // In f64, where neither scaling by powers of two nor the product below can round or overflow.
    let rgb = rgb.map(|value| if value > 0.0 { (value as f64).min(255.0 * power_of_two(119)) } else { 0.0 });
    let largest = rgb.iter().copied().fold(0.0, f64::max);
    // largest = m 2^e with m in [1/2, 1), read from the number's own bits.
    let mut exponent = (largest.to_bits() >> 52) as i32 - 1022;
    if (largest * power_of_two(8 - exponent)).round() > 255.0 {
        exponent += 1;
    }
    if largest == 0.0 || exponent < -127 {
        return [0; 4];
    }
    let [r, g, b] = rgb.map(|value| (value * power_of_two(8 - exponent)).round() as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// 2^n for n in [-1022, 1023], made of its bits.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// Reads flat and run-length coded files.
pub(super) fn read(bytes: &[u8]) -> Result<Image, String> {
    crate::image::decode(bytes, ::image::ImageFormat::Hdr).map(|decoded| {
        let (width, height) = (decoded.width(), decoded.height());
        let pixels = decoded.into_rgb32f().pixels().map(|pixel| pixel.0).collect();
        Image { width, height, pixels, ..Image::default() }
    })
}

#[cfg(test)]
mod tests {
    use super::rgbe;

    #[test]
    fn rgbe_rounds_to_nearest_and_saturates() {
        assert_eq!(rgbe([1.0, 0.5, 0.0]), [128, 64, 0, 129]);
        // 255.6 / 256 rounds up to a mantissa of 256, which is 128 of the next exponent.
        assert_eq!(rgbe([255.6 / 256.0, 0.0, 0.0]), [128, 0, 0, 129]);
        assert_eq!(rgbe([254.6 / 256.0, 0.0, 0.0]), [255, 0, 0, 128]);
        assert_eq!(rgbe([f32::MAX, 0.0, 1.0]), [255, 0, 0, 255]);
        assert_eq!(rgbe([1e-40, -1.0, f32::NAN]), [0; 4]);
    }
}
