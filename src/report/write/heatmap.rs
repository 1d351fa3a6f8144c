//! Pictures of an error: one colour a pixel, on a logarithmic scale, with a legend drawn beside.
//!
//! Colours are viridis (Smith and van der Walt 2015): even in perceived lightness, so that it reads the same in print
//! without colour and to the colour-blind. Dark is a small error, bright a large one.

use crate::error::Result;
use crate::image::atomic;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::io;
use std::path::Path;

/// Decades of the scale: from 10^`low` to 10^`high`; what lies outside takes the colour of the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Exponent of the darkest value.
    pub low: i32,
    /// Exponent of the brightest value.
    pub high: i32,
}

impl Scale {
    /// Three decades, the upper end above all but one value in a hundred.
    pub fn fitting(values: &[f64]) -> Scale {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let top = sorted.get(sorted.len().saturating_sub(1 + sorted.len() / 100)).copied().unwrap_or(0.0);
        let high = if top > 0.0 { (top.log10().ceil() as i32).clamp(-12, 6) } else { 0 };
        Scale { low: high - 3, high }
    }

    /// Where `value` stands between the ends, in [0, 1].
    fn position(self, value: f64) -> f64 {
        let decades = (self.high - self.low).max(1) as f64;
        if value > 0.0 { ((value.log10() - self.low as f64) / decades).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The colour of `value`, 8-bit sRGB.
    pub fn color(self, value: f64) -> [u8; 3] {
        let color = colorous::VIRIDIS.eval_continuous(self.position(value));
        [color.r, color.g, color.b]
    }
}

/// An 8-bit sRGB picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Three bytes a pixel, row by row from the top.
    pub bytes: Vec<u8>,
}

/// Space around the legend, width of its bar, in units of the legend.
const GAP: u32 = 4;
const BAR: u32 = 8;
/// Room for a label: six characters of five columns, one between two.
const LABEL: u32 = 6 * 6;
/// A picture of fewer rows is enlarged by a whole number, so that pixels can be seen and the legend fits.
const LEAST_ROWS: u32 = 160;

impl Canvas {
    /// The colours of `values`, `width` a row, without a legend.
    pub fn plain(values: &[f64], width: u32, scale: Scale) -> Canvas {
        let height = values.len() as u32 / width.max(1);
        Canvas { width, height, bytes: values.iter().flat_map(|&value| scale.color(value)).collect() }
    }

    /// The colours of `values` with the scale beside them, labelled in per cent.
    pub fn with_legend(values: &[f64], width: u32, scale: Scale) -> Canvas {
        let plain = Canvas::plain(values, width, scale);
        let zoom = LEAST_ROWS.div_ceil(plain.height.max(1)).max(1);
        let (picture_width, height) = (plain.width * zoom, plain.height * zoom);
        let unit = (height / LEAST_ROWS).max(1);
        let mut canvas = Canvas::filled(picture_width + (3 * GAP + BAR + LABEL) * unit, height, [255; 3]);
        for y in 0..height {
            for x in 0..picture_width {
                let from = 3 * ((y / zoom) as usize * plain.width as usize + (x / zoom) as usize);
                canvas.set(x, y, [plain.bytes[from], plain.bytes[from + 1], plain.bytes[from + 2]]);
            }
        }
        canvas.draw_legend(picture_width + GAP * unit, unit, scale);
        canvas
    }

    /// The bar and its labels, from column `left` on, over the whole height but for half a label above and below.
    fn draw_legend(&mut self, left: u32, unit: u32, scale: Scale) {
        let (top, rows) = (GLYPH_ROWS * unit, self.height - 2 * GLYPH_ROWS * unit);
        let decades = (scale.high - scale.low).max(1) as f64;
        for y in 0..rows {
            let exponent = scale.high as f64 - decades * y as f64 / (rows - 1) as f64;
            let color = scale.color(10f64.powf(exponent));
            (0..BAR * unit).for_each(|x| self.set(left + x, top + y, color));
        }
        for exponent in scale.low..=scale.high {
            let share = (scale.high - exponent) as f64 / decades;
            let y = top + (share * (rows - 1) as f64).round() as u32;
            (0..GAP * unit / 2).for_each(|x| self.set(left + BAR * unit + x, y, [0; 3]));
            let label = per_cent(exponent);
            self.write(&label, left + (BAR + GAP) * unit, y - GLYPH_ROWS * unit / 2, unit);
        }
    }

    fn filled(width: u32, height: u32, color: [u8; 3]) -> Canvas {
        Canvas { width, height, bytes: color.repeat(width as usize * height as usize) }
    }

    fn set(&mut self, x: u32, y: u32, color: [u8; 3]) {
        if x < self.width && y < self.height {
            let at = 3 * (y as usize * self.width as usize + x as usize);
            self.bytes[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Writes digits and signs in black, each dot `unit` pixels wide.
    fn write(&mut self, text: &str, left: u32, top: u32, unit: u32) {
        for (i, rows) in text.chars().map(glyph).enumerate() {
            for (row, bits) in rows.into_iter().enumerate() {
                for column in (0..5).filter(|column| bits >> (4 - column) & 1 == 1) {
                    let (x, y) = (left + (i as u32 * 6 + column) * unit, top + row as u32 * unit);
                    (0..unit * unit).for_each(|dot| self.set(x + dot % unit, y + dot / unit, [0; 3]));
                }
            }
        }
    }

    /// The picture as a PNG file.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing into memory fails only for sizes that do not match the bytes, and these do.
        let _ = self.encode(&mut bytes);
        bytes
    }

    /// Writes the picture to `path` as PNG, whole or not at all.
    ///
    /// # Errors
    /// [`crate::Error::Write`].
    pub fn save(&self, path: &Path) -> Result<()> {
        atomic::write(path, |out| self.encode(out))
    }

    fn encode(&self, out: impl io::Write) -> io::Result<()> {
        let encoder = PngEncoder::new(out);
        let written = encoder.write_image(&self.bytes, self.width, self.height, ExtendedColorType::Rgb8);
        written.map_err(|error| io::Error::other(error.to_string()))
    }
}

/// 10^`exponent` in per cent, as short as it can be written.
fn per_cent(exponent: i32) -> String {
    match exponent + 2 {
        places @ 0..=3 => format!("{}%", 10u32.pow(places as u32)),
        places @ -2..0 => format!("{:.*}%", -places as usize, 10f64.powi(places)),
        places => format!("1e{places}%"),
    }
}

const GLYPH_ROWS: u32 = 7;

/// The rows of a character, five dots each, the leftmost in the highest bit; unknown ones are blank.
fn glyph(character: char) -> [u8; GLYPH_ROWS as usize] {
    match character {
        '0' => [14, 17, 19, 21, 25, 17, 14],
        '1' => [4, 12, 4, 4, 4, 4, 14],
        'e' => [0, 0, 14, 17, 31, 16, 14],
        '2' => [14, 17, 1, 2, 4, 8, 31],
        '3' => [31, 2, 4, 2, 1, 17, 14],
        '4' => [2, 6, 10, 18, 31, 2, 2],
        '5' => [31, 16, 30, 1, 1, 17, 14],
        '6' => [6, 8, 16, 30, 17, 17, 14],
        '7' => [31, 1, 2, 4, 8, 8, 8],
        '8' => [14, 17, 17, 14, 17, 17, 14],
        '9' => [14, 17, 17, 15, 1, 2, 12],
        '.' => [0, 0, 0, 0, 0, 12, 12],
        '-' => [0, 0, 0, 31, 0, 0, 0],
        '%' => [24, 25, 2, 4, 8, 19, 3],
        _ => [0; 7],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_fits_the_values_and_its_ends_hold() {
        let mut values = vec![0.03; 99];
        values.push(1e9);
        let scale = Scale::fitting(&values);
        assert_eq!(scale, Scale { low: -4, high: -1 });
        assert_eq!([0.0, 1e-9, 1e-4].map(|v| scale.position(v)), [0.0; 3]);
        assert_eq!([0.1, 1.0, 1e9].map(|v| scale.position(v)), [1.0; 3]);
        assert!((scale.position(0.01) - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!(Scale::fitting(&[0.0; 4]), Scale { low: -3, high: 0 });
    }

    #[test]
    fn colors_grow_brighter_with_the_error() {
        let scale = Scale { low: -3, high: 0 };
        let light = |value: f64| {
            let [r, g, b] = scale.color(value).map(|byte| crate::color::linear_from_srgb(byte as f64 / 255.0));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let lights: Vec<f64> = (0..=30).map(|i| light(10f64.powf(-3.0 + i as f64 / 10.0))).collect();
        assert!(lights.is_sorted(), "{lights:?}");
    }

    #[test]
    fn the_picture_stands_left_of_its_legend() {
        let scale = Scale { low: -2, high: 0 };
        let canvas = Canvas::with_legend(&[1.0, 0.01, 0.01, 1.0], 2, scale);
        assert_eq!((canvas.width, canvas.height), (160 + 12 + 8 + 36, 160));
        let at = |x: u32, y: u32| &canvas.bytes[3 * (y * canvas.width + x) as usize..][..3];
        assert_eq!((at(0, 0), at(80, 0)), (&scale.color(1.0)[..], &scale.color(0.01)[..]));
        assert_eq!((at(164, 7), at(164, 152)), (&scale.color(1.0)[..], &scale.color(0.01)[..]));
        let read = image::load_from_memory(&canvas.png()).unwrap();
        assert_eq!((read.width(), read.height()), (canvas.width, canvas.height));
        assert_eq!([-4, -3, -2, 0, 1, -7, 3].map(per_cent), ["0.01%", "0.1%", "1%", "100%", "1000%", "1e-5%", "1e5%"]);
    }
}
