//! Images of an error: one colour a pixel, on a logarithmic scale, with a legend drawn beside.
//!
//! Colours are viridis (Smith and van der Walt 2015): even in perceived lightness, so that it reads the same in print
//! without colour and to the colour-blind. Dark is a small error, bright a large one. Colours come in steps, at most eight a
//! decade, so that files have a small palette: noise is what images of errors are made of, and every step fewer saves.

use crate::error::Result;
use crate::files::atomic;
use crate::report::write::images;
use crate::report::write::plot::number;
use maud::{Markup, html};
use std::path::Path;

/// Steps of colour in a decade, and in all.
const STEPS_A_DECADE: i32 = 8;
const MOST_STEPS: i32 = 32;

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
        let decades = self.decades() as f64;
        if value > 0.0 { ((value.log10() - self.low as f64) / decades).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn decades(self) -> i32 {
        (self.high - self.low).max(1)
    }

    /// How many colours there are: a whole number a decade.
    fn steps(self) -> i32 {
        self.decades() * (MOST_STEPS / self.decades()).clamp(1, STEPS_A_DECADE)
    }

    /// The colour of a step, counted from the darkest.
    fn step(self, step: i32) -> [u8; 3] {
        let last = (self.steps() - 1).max(1);
        let color = colorous::VIRIDIS.eval_continuous(step.clamp(0, last) as f64 / last as f64);
        [color.r, color.g, color.b]
    }

    /// The colour of `value`, 8-bit sRGB.
    pub fn color(self, value: f64) -> [u8; 3] {
        self.step((self.position(value) * self.steps() as f64).floor() as i32)
    }
}

/// An 8-bit sRGB image.
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
/// An image of fewer rows is enlarged by a whole number, so that pixels can be seen and the legend fits.
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

    /// The image as a PNG file, with a palette.
    pub fn png(&self) -> Vec<u8> {
        images::png(&self.bytes, self.width, self.height)
    }

    /// Writes the image to `path` as PNG, whole or not at all.
    ///
    /// # Errors
    /// [`crate::Error::Write`].
    pub fn save(&self, path: &Path) -> Result<()> {
        atomic::write(path, |out| images::write_png(out, &self.bytes, self.width, self.height))
    }
}

/// How [`scale_legend`] looks. `--paper`, `--ink` and `--soft` are those of [`super::plot::LIGHT`].
pub const STYLE: &str = ".heat{position:relative;max-width:26rem;height:2.3rem;margin:.4rem 1.6rem 1rem 1.2rem;\
font:.82rem system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;color:var(--soft)}\
.heat i{position:absolute;top:0;left:0;right:0;height:.8rem;-webkit-print-color-adjust:exact;print-color-adjust:exact}\
.heat span{position:absolute;top:1.15rem;transform:translateX(-50%);white-space:nowrap}\
.heat span::before{content:'';position:absolute;left:50%;top:-.35rem;height:.3rem;border-left:1px solid var(--ink)}";

/// The colours of `scale` for a page, with a tick and a label in per cent at every decade.
pub fn scale_legend(scale: Scale) -> Markup {
    let share = |part: i32, of: i32| number((1e4 * part as f64 / of as f64).round() / 100.0) + "%";
    let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    let (steps, decades) = (scale.steps(), scale.decades());
    let stop = |i: i32| format!("{} {} {}", hex(scale.step(i)), share(i, steps), share(i + 1, steps));
    let stops: Vec<String> = (0..steps).map(stop).collect();
    let label = |exponent: i32| format!("{}\u{a0}%", number(10f64.powi(exponent + 2)));
    let ends = format!("Relative error by colour, from {} (dark) to {} (bright)", label(scale.low), label(scale.high));
    html! {
        div class="heat" role="img" aria-label=(ends) {
            i style=(format!("background:linear-gradient(90deg,{})", stops.join(","))) {}
            @for decade in 0..=decades {
                span style=(format!("left:{}", share(decade, decades))) { (label(scale.low + decade)) }
            }
        }
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

    #[test]
    fn colors_come_in_few_steps_that_end_at_decades() {
        for (low, high) in [(-3, 0), (-1, 0), (-5, 1), (-12, 6), (-40, 6)] {
            let scale = Scale { low, high };
            let decades = high - low;
            let exponents = (0..=decades * 200).map(|i| low as f64 + i as f64 / 200.0 - 0.0025);
            let colors: std::collections::BTreeSet<_> = exponents.map(|e| scale.color(10f64.powf(e))).collect();
            assert_eq!(colors.len() as i32, scale.steps());
            assert!(scale.steps() <= MOST_STEPS.max(decades) && scale.steps() % decades == 0);
            for exponent in low + 1..high {
                let (below, above) = (10f64.powf(exponent as f64 - 1e-6), 10f64.powf(exponent as f64 + 1e-6));
                assert_ne!(scale.color(below), scale.color(above), "a decade begins with a colour of its own");
            }
        }
    }

    #[test]
    fn noise_makes_a_small_file() {
        // Relative errors of a noisy image: magnitudes of normal deviates, here of sums of twelve uniform ones.
        let uniform = |i: usize| {
            let mut h = (i as u32).wrapping_mul(0x9E37_79B9);
            for _ in 0..3 {
                h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
            }
            (h >> 8) as f64 / 16_777_216.0
        };
        let deviate = |i: usize| (0..12).map(|j| uniform(12 * i + j)).sum::<f64>() - 6.0;
        let values: Vec<f64> = (0..256 * 256).map(|i| 0.2 * deviate(i).abs()).collect();
        let canvas = Canvas::plain(&values, 256, Scale::fitting(&values));
        let bytes = canvas.png();
        assert!(bytes.len() < 38_000, "{}", bytes.len());
        assert_eq!(image::load_from_memory(&bytes).unwrap().into_rgb8().into_raw(), canvas.bytes);
        let labelled = Canvas::with_legend(&values, 256, Scale::fitting(&values)).png();
        assert!(labelled.len() < 42_000 && labelled[25] == 3, "{}", labelled.len());
    }

    #[test]
    fn the_legend_of_a_page_labels_every_decade() {
        let text = scale_legend(Scale { low: -7, high: -1 }).into_string();
        let page = scraper::Html::parse_fragment(&text);
        let spans = scraper::Selector::parse(".heat span").unwrap();
        let labels: Vec<String> =
            page.select(&spans).map(|span| span.text().collect::<String>().replace('\u{a0}', " ")).collect();
        assert_eq!(labels, ["10⁻⁵ %", "0.0001 %", "0.001 %", "0.01 %", "0.1 %", "1 %", "10 %"]);
        assert!(text.contains("left:0%") && text.contains("left:50%") && text.contains("left:100%"));
        let one = Scale { low: 0, high: 0 };
        assert!(scale_legend(one).into_string().contains("100\u{a0}%"));
    }
}
