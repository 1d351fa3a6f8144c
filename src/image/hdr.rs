//! Radiance RGBE: three 8-bit mantissas and a shared exponent (Ward, "Real Pixels", Graphics Gems II, 1991).
//!
//! Written here and not through the `image` crate, whose encoder cuts mantissas off: that darkens a picture by 0.2 % on
//! average. Rounding to nearest keeps means right.

use crate::files::atomic::Sink;
use crate::film::Film;
use crate::image::primaries::{Chromaticities, convert, from_xyz, to_rec709};
use crate::image::{Image, claim};
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

/// What the header says.
struct Header {
    /// By what the pixels have been multiplied.
    exposure: [f64; 3],
    /// Where it is none of what every file has.
    primaries: Option<Chromaticities>,
    /// They are CIE XYZ.
    xyz: bool,
    /// Pixels of a scanline, and how many of those there are.
    size: (u32, u32),
    /// How scanlines lie in the picture.
    lie: Lie,
}

/// How scanlines lie in the picture.
#[derive(Clone, Copy, Default)]
struct Lie {
    /// They are columns.
    columns: bool,
    /// Their pixels run from right to left, or from the bottom up.
    backwards: bool,
    /// The first is the last row from the top, or column from the left.
    last_first: bool,
}

/// Reads a file of any of the eight orientations, its scanlines flat or of either run-length code.
///
/// (Not through the `image` crate, which takes no other first line than `#?RADIANCE`, no CRLF, leaves EXPOSURE alone, and takes a
/// flat pixel for a code where the numbers are alike.)
pub(super) fn read(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes;
    let header = header(&mut rest)?;
    let (length, lines) = header.size;
    let (width, height) = if header.lie.columns { (lines, length) } else { (length, lines) };
    // A scanline has no fewer than four bytes.
    if u64::from(lines) > rest.len() as u64 / 4 {
        return Err(format!("the data is cut short: {} bytes cannot hold {width} x {height} pixels", rest.len()));
    }
    claim(width.into(), height.into(), 12)?;
    let mut pixels = vec![[0.0; 3]; width as usize * height as usize];
    let mut warnings = Vec::new();
    decode(rest, &header, &mut pixels)?;
    if header.xyz {
        convert(&from_xyz(), &mut pixels);
    } else if let Some(of) = header.primaries {
        match to_rec709(of) {
            Ok(Some(matrix)) => convert(&matrix, &mut pixels),
            Ok(None) => {}
            Err(why) => warnings.push(format!("PRIMARIES has no effect: {why}")),
        }
    }
    if header.exposure != [1.0; 3] {
        let divide = |value: f32, by: f64| (f64::from(value) / by) as f32;
        pixels.iter_mut().for_each(|pixel| *pixel = std::array::from_fn(|c| divide(pixel[c], header.exposure[c])));
    }
    Ok(Image { width, height, pixels, warnings, ..Image::default() })
}

/// The next line of a header, which ends in LF or CRLF.
fn line<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let end = rest.iter().position(|&byte| byte == b'\n')?;
    let line = &rest[..end];
    *rest = &rest[end + 1..];
    Some(line.strip_suffix(b"\r").unwrap_or(line))
}

/// Takes the header off `rest`.
fn header(rest: &mut &[u8]) -> Result<Header, String> {
    let cut = || "the header is cut short".to_owned();
    if !rest.starts_with(b"#?") {
        return Err("not a Radiance file: it must start with #?RADIANCE or #?RGBE".into());
    }
    let (mut exposure, mut primaries, mut xyz) = ([1.0; 3], None, false);
    loop {
        let line = line(rest).ok_or_else(cut)?;
        if line.is_empty() {
            break;
        }
        let text = String::from_utf8_lossy(line);
        let Some((key, value)) = text.split_once('=').filter(|_| !text.starts_with('#')) else { continue };
        let numbers = || value.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>();
        let (key, value) = (key.trim(), value.trim());
        match key {
            "FORMAT" if value == "32-bit_rle_rgbe" => {}
            "FORMAT" if value == "32-bit_rle_xyze" => xyz = true,
            "FORMAT" => return Err(format!("FORMAT={value}: 32-bit_rle_rgbe and 32-bit_rle_xyze can be read")),
            // Each of several multiplies: programs add their own.
            "EXPOSURE" | "COLORCORR" => {
                let by = match numbers()[..] {
                    [all] if key == "EXPOSURE" => [all; 3],
                    [r, g, b] if key == "COLORCORR" => [r, g, b],
                    _ => [f64::NAN; 3],
                };
                exposure = std::array::from_fn(|c| exposure[c] * by[c]);
                if !exposure.iter().all(|by| (1e-30..1e30).contains(by)) {
                    return Err(format!("{key}={value}: it must be above 0"));
                }
            }
            // Photoshop writes eight zeros.
            "PRIMARIES" => match numbers()[..] {
                [rx, ry, gx, gy, bx, by, wx, wy] if rx != 0.0 || ry != 0.0 => {
                    primaries = Some([[rx, ry], [gx, gy], [bx, by], [wx, wy]]);
                }
                _ => {}
            },
            _ => {}
        }
    }
    let text = String::from_utf8_lossy(line(rest).ok_or_else(cut)?).into_owned();
    let (size, lie) = resolution(&text)
        .ok_or_else(|| format!("`{text}`: the size must be written as `-Y HEIGHT +X WIDTH` or another orientation"))?;
    Ok(Header { exposure, primaries, xyz, size, lie })
}

/// The line of the size: first the axis that scanlines follow each other along, then the one they run along.
fn resolution(text: &str) -> Option<((u32, u32), Lie)> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let [first, lines, second, length] = words[..] else { return None };
    let size = |word: &str| word.parse::<u32>().ok().filter(|&size| size > 0);
    let columns = match (first, second) {
        ("-Y" | "+Y", "+X" | "-X") => false,
        ("+X" | "-X", "-Y" | "+Y") => true,
        _ => return None,
    };
    // Y points up, rows are counted down.
    let reversed = |axis: &str| matches!(axis, "+Y" | "-X");
    Some(((size(length)?, size(lines)?), Lie { columns, backwards: reversed(second), last_first: reversed(first) }))
}

/// Decodes all scanlines. A flat pixel may look like the start of a run, so where the data has the very length of flat pixels and
/// is no whole code, it is flat.
fn decode(rest: &[u8], header: &Header, pixels: &mut [[f32; 3]]) -> Result<(), String> {
    let (length, lines) = (header.size.0 as usize, header.size.1 as usize);
    let mut scanline = vec![[0u8; 4]; length];
    let mut coded = || {
        let mut rest = rest;
        for index in 0..lines {
            if !coded_scanline(&mut rest, &mut scanline) {
                return Err(format!("the data is cut short, or no code of it, in scanline {} of {lines}", index + 1));
            }
            place(&scanline, index, header, pixels);
        }
        Ok(rest.is_empty())
    };
    let is_flat = rest.len() as u64 == 4 * length as u64 * lines as u64;
    match coded() {
        Ok(true) => Ok(()),
        Ok(false) | Err(_) if is_flat => {
            let (flat, _) = rest.as_chunks();
            flat.chunks(length).enumerate().for_each(|(index, line)| place(line, index, header, pixels));
            Ok(())
        }
        other => other.map(|_| ()),
    }
}

/// Takes one scanline off `rest`; false if there is no whole one.
fn coded_scanline(rest: &mut &[u8], scanline: &mut [[u8; 4]]) -> bool {
    let length = scanline.len();
    let marker = [2, 2, (length >> 8) as u8, length as u8];
    if (8..1 << 15).contains(&length) && rest.starts_with(&marker) {
        *rest = &rest[4..];
        (0..4).all(|component| coded_component(rest, scanline, component).is_some())
    } else {
        old_scanline(rest, scanline).is_some()
    }
}

/// One of the four components of a scanline: runs of up to 127 of a byte, or up to 128 bytes.
fn coded_component(rest: &mut &[u8], scanline: &mut [[u8; 4]], component: usize) -> Option<()> {
    let mut at = 0;
    while at < scanline.len() {
        let (&count, behind) = rest.split_first()?;
        let (count, is_run) = if count > 128 { (usize::from(count) - 128, true) } else { (count.into(), false) };
        let target = scanline.get_mut(at..at + count).filter(|_| count > 0)?;
        let (source, behind) = behind.split_at_checked(if is_run { 1 } else { count })?;
        for (i, pixel) in target.iter_mut().enumerate() {
            pixel[component] = source[if is_run { 0 } else { i }];
        }
        *rest = behind;
        at += count;
    }
    Some(())
}

/// A scanline of pixels, of which 1, 1, 1, n repeats the one before it n times, 256 n times behind another such, and so on.
fn old_scanline(rest: &mut &[u8], scanline: &mut [[u8; 4]]) -> Option<()> {
    let (mut at, mut shift) = (0, 0);
    while at < scanline.len() {
        let (&pixel, behind) = rest.split_first_chunk()?;
        *rest = behind;
        if pixel[..3] == [1; 3] {
            let last = *scanline.get(at.checked_sub(1)?)?;
            let count = (pixel[3] as usize).checked_shl(shift)?;
            scanline.get_mut(at..at.checked_add(count)?)?.fill(last);
            (at, shift) = (at + count, shift + 8);
            // A longer run than any line has.
            if shift > 32 {
                return None;
            }
        } else {
            scanline[at] = pixel;
            (at, shift) = (at + 1, 0);
        }
    }
    Some(())
}

/// Puts scanline `index` where it lies in the picture.
fn place(scanline: &[[u8; 4]], index: usize, header: &Header, pixels: &mut [[f32; 3]]) {
    let (length, lines) = (header.size.0 as usize, header.size.1 as usize);
    let Lie { columns, backwards, last_first } = header.lie;
    let major = if last_first { lines - 1 - index } else { index };
    for (i, &pixel) in scanline.iter().enumerate() {
        let minor = if backwards { length - 1 - i } else { i };
        let (x, y, width) = if columns { (major, minor, lines) } else { (minor, major, length) };
        pixels[y * width + x] = radiance(pixel);
    }
}

/// What a pixel's four bytes say: exact in f32.
fn radiance([r, g, b, exponent]: [u8; 4]) -> [f32; 3] {
    let scale = if exponent == 0 { 0.0 } else { power_of_two(i32::from(exponent) - 136) };
    [r, g, b].map(|mantissa| (f64::from(mantissa) * scale) as f32)
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
