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

/// Reads `PF` (RGB) and `Pf` (grey) of either byte order. The scale's magnitude is ignored, as common readers do; so are
/// comments, CRs before the header's line ends and white space behind the data.
///
/// Photoshop writes the two sizes on lines of their own, and rows from the top.
pub(super) fn read(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes;
    let channels = match word(&mut rest).map(|(word, _)| word) {
        Some("PF") => 3,
        Some("Pf") => 1,
        _ => return Err("not a PFM file: it must start with PF or Pf".into()),
    };
    let mut size = || word(&mut rest).and_then(|(word, end)| Some((word.parse::<u32>().ok().filter(|&n| n > 0)?, end)));
    let (Some((width, between)), Some((height, _))) = (size(), size()) else {
        return Err("PFM header: the second line must be width and height".into());
    };
    let top_down = matches!(between, b'\n' | b'\r');
    let scale = word(&mut rest).and_then(|(word, end)| Some((word.parse::<f32>().ok().filter(|x| *x != 0.0)?, end)));
    let Some((scale, end)) = scale else {
        return Err("PFM header: the third line must be a scale other than 0".into());
    };
    // In 128 bits, which two numbers of 32 and twelve do not leave.
    let expected = u128::from(width) * u128::from(height) * channels * 4;
    // The LF of a CRLF, unless the data begins there: it may well begin with such a byte.
    if end == b'\r' && rest.len() as u128 > expected && rest.first() == Some(&b'\n') {
        rest = &rest[1..];
    }
    let got = rest.len();
    if (got as u128) < expected {
        return Err(format!("PFM data: {got} bytes where {expected} are expected: the file is cut short"));
    }
    let (data, behind) = rest.split_at(expected as usize);
    if !behind.iter().all(u8::is_ascii_whitespace) {
        return Err(format!("PFM data: {got} bytes where {expected} are expected"));
    }
    claim(width.into(), height.into(), 4 * 3 + 12)?;
    let order = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let values: Vec<f32> = data.as_chunks().0.iter().map(|&bytes| order(bytes)).collect();
    let channels = channels as usize;
    let pixel = |pixel: &[f32]| [pixel[0], pixel[pixel.len() / 2], pixel[pixel.len() - 1]];
    let row_values = width as usize * channels;
    let pixels = match top_down {
        true => values.chunks(channels).map(pixel).collect(),
        false => values.rchunks(row_values).flat_map(|row| row.chunks(channels)).map(pixel).collect(),
    };
    let photoshop = "the sizes stand on lines of their own, as Photoshop writes them: rows are taken from the top";
    let warnings = if top_down { vec![photoshop.to_owned()] } else { Vec::new() };
    Ok(Image { width, height, pixels, warnings, ..Image::default() })
}

/// The next word of the header and the white-space byte that ends it; that alone is consumed, since data may follow.
fn word<'a>(rest: &mut &'a [u8]) -> Option<(&'a str, u8)> {
    let mut start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
    while rest[start] == b'#' {
        let end = rest[start..].iter().position(|&byte| byte == b'\n')?;
        start += end + rest[start + end..].iter().position(|byte| !byte.is_ascii_whitespace())?;
    }
    let length = rest[start..].iter().position(u8::is_ascii_whitespace)?;
    let word = std::str::from_utf8(&rest[start..start + length]).ok()?;
    let end = rest[start + length];
    *rest = &rest[start + length + 1..];
    Some((word, end))
}
