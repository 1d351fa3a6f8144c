//! PNG: 8-bit sRGB, for looking at.

use crate::color::{linear_from_srgb, srgb8};
use crate::files::atomic::Sink;
use crate::film::Film;
use crate::image::{Image, decode, encoding};
use ::image::codecs::png::PngEncoder;
use ::image::{ExtendedColorType, ImageEncoder, ImageFormat};
use std::io;

/// Writes 8-bit sRGB after `exposure` stops, with alpha where the film has it: then colours are those of what is there, without
/// what is not (the format's alpha is not associated).
pub(super) fn write(film: &Film, exposure: f64, out: &mut dyn Sink) -> io::Result<()> {
    if let Some(alphas) = film.layers.alphas() {
        let pixel = |(color, alpha): ([f32; 3], f32)| {
            let [r, g, b] = color.map(|value| srgb8(if alpha > 0.0 { value / alpha } else { 0.0 }, exposure));
            [r, g, b, (alpha * 255.0).round() as u8]
        };
        let bytes: Vec<u8> = film.means().zip(alphas).flat_map(pixel).collect();
        let encoder = PngEncoder::new(out);
        return encoder.write_image(&bytes, film.width, film.height, ExtendedColorType::Rgba8).map_err(encoding);
    }
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
