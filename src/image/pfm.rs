//! Portable float maps: a text header, then f32 values row by row from the bottom.

use crate::files::atomic::Sink;
use crate::film::Film;
use crate::image::{Image, claim};
use std::io;

/// Writes little-endian RGB (a negative scale says so).
pub(super) fn write(film: &Film, out: &mut dyn Sink) -> io::Result<()> {
    write!(out, "PF\n{} {}\n-1.0\n", film.width, film.height)?;
    for y in (0..film.height).rev() {
        for x in 0..film.width {
            out.write_all(bytemuck::cast_slice(&film.mean(x, y).map(|value| value.to_bits().to_le())))?;
        }
    }
    Ok(())
}

/// Reads `PF` (RGB) and `Pf` (grey) of either byte order. The scale's magnitude is ignored, as common readers do.
pub(super) fn read(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes;
    let channels = match word(&mut rest) {
        Some("PF") => 3,
        Some("Pf") => 1,
        _ => return Err("not a PFM file: it must start with PF or Pf".into()),
    };
    let mut size = || word(&mut rest)?.parse::<u32>().ok().filter(|&size| size > 0);
    let (Some(width), Some(height)) = (size(), size()) else {
        return Err("PFM header: the second line must be width and height".into());
    };
    let scale = word(&mut rest).and_then(|word| word.parse::<f32>().ok()).filter(|scale| *scale != 0.0);
    let Some(scale) = scale else {
        return Err("PFM header: the third line must be a scale other than 0".into());
    };
    // In 128 bits, which two numbers of 32 and twelve do not leave.
    let expected = u128::from(width) * u128::from(height) * channels * 4;
    if rest.len() as u128 != expected {
        return Err(format!("PFM data: {} bytes where {expected} are expected", rest.len()));
    }
    claim(width.into(), height.into(), 4 * 3 + 12)?;
    let order = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let values: Vec<f32> = rest.as_chunks().0.iter().map(|&bytes| order(bytes)).collect();
    let row_values = width as usize * channels as usize;
    let pixels = values.rchunks(row_values).flat_map(|row| row.chunks(channels as usize));
    let pixels = pixels.map(|pixel| [pixel[0], pixel[pixel.len() / 2], pixel[pixel.len() - 1]]).collect();
    Ok(Image { width, height, pixels, ..Image::default() })
}

/// The next word of the header; exactly one white-space byte after it is consumed, since data may follow.
fn word<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
    let length = rest[start..].iter().position(u8::is_ascii_whitespace)?;
    let word = std::str::from_utf8(&rest[start..start + length]).ok()?;
    *rest = &rest[start + length + 1..];
    Some(word)
}
