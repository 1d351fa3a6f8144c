//! PNG: 8-bit sRGB, for looking at.

use crate::color::{linear_from_srgb, srgb8};
use crate::files::atomic::Sink;
use crate::film::Film;
use crate::image::{Image, decode, encoding};
use ::image::codecs::png::PngEncoder;
use ::image::{ExtendedColorType, ImageEncoder, ImageFormat};
use std::io;

/// Writes 8-bit sRGB after `exposure` stops.
pub(super) fn write(film: &Film, exposure: f64, out: &mut dyn Sink) -> io::Result<()> {
    let bytes: Vec<u8> = film.means().flatten().map(|value| srgb8(value, exposure)).collect();
    write_bytes(&bytes, film.width, film.height, out)
}

/// Writes 8-bit sRGB, three bytes a pixel.
pub(super) fn write_bytes(bytes: &[u8], width: u32, height: u32, out: &mut dyn Sink) -> io::Result<()> {
    PngEncoder::new(out).write_image(bytes, width, height, ExtendedColorType::Rgb8).map_err(encoding)
}

/// Reads any PNG as linear values; alpha is dropped.
pub(super) fn read(bytes: &[u8]) -> Result<Image, String> {
    let decoded = decode(bytes, ImageFormat::Png)?;
    let (width, height) = (decoded.width(), decoded.height());
    let linear = |value: u16| linear_from_srgb(value as f64 / 65535.0) as f32;
    let pixels = decoded.into_rgb16().pixels().map(|pixel| pixel.0.map(linear)).collect();
    Ok(Image { width, height, pixels, ..Image::default() })
}
