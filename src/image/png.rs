//! PNG: 8-bit sRGB, for looking at.

use crate::color::{linear_from_srgb, srgb8};
use crate::files::atomic::Sink;
use crate::film::Film;
use crate::image::{Image, claim, encoding};
use ::image::codecs::png::PngEncoder;
use ::image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat};
use std::io::{self, Cursor};

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

/// Bytes that a pixel takes at most while it is decoded: as the file has it, as what is made of that, and as three f32.
const DECODING: u64 = 8 + 6 + 12;

/// Decodes by the `image` crate, if there is memory for it.
pub(super) fn decode(bytes: &[u8], format: ImageFormat) -> Result<DynamicImage, String> {
    let mut reader = ::image::ImageReader::with_format(Cursor::new(bytes), format);
    // What was claimed is the limit; the crate's own would refuse large maps of machines that have room for them.
    reader.no_limits();
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    let each = DECODING + u64::from(decoder.color_type().bytes_per_pixel());
    // Deflate makes 1,032 bytes of one at most, and three runs of Radiance files 2^24 pixels of four bytes each; a header that
    // promises more than the file can hold is wrong.
    let most = if format == ImageFormat::Png { (bytes.len() as u64).saturating_mul(1032) } else { u64::MAX };
    if format == ImageFormat::Png && decoder.total_bytes() / 16 > most {
        return Err(format!("the header promises {width} x {height} pixels, more than {} bytes can hold", bytes.len()));
    }
    claim(u64::from(width), u64::from(height), each)?;
    DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())
}
