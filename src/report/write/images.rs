//! Images of a page: encoded small, enlarged on a click without a script, and the part that is worth a closer look.
//!
//! Bytes are 8-bit sRGB, three a pixel, row by row from the top.

use crate::settings::Crop;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use maud::{Markup, html};
use std::collections::BTreeMap;
use std::io;

/// Most bytes of an image of 256 by 256 pixels in a page.
pub const MOST_BYTES: usize = 35_000;
/// Qualities of JPEG that are tried, best first; below the last its blocks would be taken for what a strategy does.
const QUALITIES: [u8; 9] = [92, 85, 80, 75, 70, 65, 60, 55, 50];

/// How [`zoomable`] images look. A hidden checkbox in the label around an image keeps whether it is large: a click, or the
/// space bar while it has the focus, turns it over. No ancestor may have a `transform`, `filter` or `contain`, which would hold
/// the large image inside of it.
pub const STYLE: &str = ".zoom{display:block;position:relative;cursor:zoom-in}\
.zoom input{position:absolute;top:0;left:0;width:1px;height:1px;margin:0;opacity:0;appearance:none}\
.zoom img{display:block;width:100%;height:auto;max-height:36rem;object-fit:contain}.zoom .pixels{image-rendering:pixelated}\
.zoom input:focus-visible+img{outline:3px solid var(--s1);outline-offset:2px}\
.zoom input:checked+img{position:fixed;inset:0;z-index:9;width:100%;height:100%;max-height:none;box-sizing:border-box;padding:1vmin;object-fit:contain;\
image-rendering:pixelated;background:#0b0c0e;cursor:zoom-out}\
@media print{.zoom input:checked+img{position:static;background:none;height:auto;padding:0}}";

/// `rgb` as a JPEG file of `quality` from 1 to 100.
///
/// # Panics
/// If `rgb` has another size than the image.
pub fn jpeg(rgb: &[u8], width: u32, height: u32, quality: u8) -> Vec<u8> {
    assert_eq!(rgb.len(), 3 * width as usize * height as usize, "three bytes a pixel");
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    // Writing into memory fails only for sizes that a file cannot state: no image, then.
    if encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8).is_err() {
        bytes.clear();
    }
    bytes
}

/// `rgb` in as few bytes as a page needs, and the kind of file ([`data_uri`]): without loss as PNG where that takes `most`
/// bytes or fewer (images of few samples are black with dots, which JPEG makes larger and worse), else the best JPEG that
/// does; where even the worst takes more, the smaller of that and PNG.
///
/// # Panics
/// If `rgb` has another size than the image.
pub fn picture(rgb: &[u8], width: u32, height: u32, most: usize) -> (&'static str, Vec<u8>) {
    let lossless = png(rgb, width, height);
    if lossless.len() <= most {
        return ("png", lossless);
    }
    let mut smallest = ("png", lossless);
    for quality in QUALITIES {
        let bytes = jpeg(rgb, width, height, quality);
        if bytes.len() < smallest.1.len() {
            smallest = ("jpeg", bytes);
        }
        if smallest.1.len() <= most {
            break;
        }
    }
    smallest
}

/// `rgb` as a PNG file, without loss: with a palette if it has no more than 256 colours.
///
/// # Panics
/// If `rgb` has another size than the image.
pub fn png(rgb: &[u8], width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing into memory fails only for sizes that a file cannot state: no image, then.
    if write_png(&mut bytes, rgb, width, height).is_err() {
        bytes.clear();
    }
    bytes
}

/// Writes what [`png()`] gives.
///
/// # Errors
/// Those of `out`.
///
/// # Panics
/// If `rgb` has another size than the image.
pub fn write_png(out: impl io::Write, rgb: &[u8], width: u32, height: u32) -> io::Result<()> {
    assert_eq!(rgb.len(), 3 * width as usize * height as usize, "three bytes a pixel");
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_compression(png::Compression::High);
    match palette(rgb) {
        Some(palette) => {
            let depth = match palette.len() {
                0..=2 => (png::BitDepth::One, 1),
                3..=4 => (png::BitDepth::Two, 2),
                5..=16 => (png::BitDepth::Four, 4),
                _ => (png::BitDepth::Eight, 8),
            };
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_depth(depth.0);
            // Indices have no neighbourhood that a filter could foresee.
            encoder.set_filter(png::Filter::NoFilter);
            encoder.set_palette(palette.keys().flatten().copied().collect::<Vec<u8>>());
            let mut writer = encoder.write_header().map_err(failure)?;
            writer.write_image_data(&indices(rgb, width, &palette, depth.1)).map_err(failure)?;
            writer.finish().map_err(failure)
        }
        None => {
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_filter(png::Filter::Adaptive);
            let mut writer = encoder.write_header().map_err(failure)?;
            writer.write_image_data(rgb).map_err(failure)?;
            writer.finish().map_err(failure)
        }
    }
}

fn failure(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

/// The colours of an image and their indices, if there are few. Neighbours in the palette are alike: it is in order.
fn palette(rgb: &[u8]) -> Option<BTreeMap<[u8; 3], u8>> {
    let mut colors = BTreeMap::new();
    for color in rgb.chunks_exact(3) {
        colors.insert([color[0], color[1], color[2]], 0);
        if colors.len() > 256 {
            return None;
        }
    }
    colors.values_mut().enumerate().for_each(|(i, index)| *index = i as u8);
    Some(colors)
}

/// The index of every pixel, `bits` each, the leftmost in the highest bits; rows begin at whole bytes.
fn indices(rgb: &[u8], width: u32, palette: &BTreeMap<[u8; 3], u8>, bits: usize) -> Vec<u8> {
    let per_byte = 8 / bits;
    let byte = |pixels: &[u8]| {
        let index = |(i, color): (usize, &[u8])| palette[&[color[0], color[1], color[2]]] << (8 - bits * (i + 1));
        pixels.chunks_exact(3).enumerate().map(index).fold(0, |all, index| all | index)
    };
    rgb.chunks_exact(3 * width.max(1) as usize).flat_map(|row| row.chunks(3 * per_byte).map(byte)).collect()
}

/// `bytes` as an address that holds them; `kind` is `png` or `jpeg`.
pub fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:image/{kind};base64,{}", STANDARD.encode(bytes))
}

/// An image that a click enlarges to the whole window, and another puts back. `src` is its address ([`data_uri`]), `what` says
/// what it shows; `pixels`: small images keep hard pixels in their place, too.
pub fn zoomable(src: &str, width: u32, height: u32, what: &str, pixels: bool) -> Markup {
    html! {
        // The ratio keeps the place while the image is elsewhere.
        label class="zoom" style=(format!("aspect-ratio:{width}/{height}")) {
            input type="checkbox" aria-label=(format!("Enlarge: {what}"));
            img class=[pixels.then_some("pixels")] src=(src) width=(width) height=(height) alt=(what);
        }
    }
}

/// The part `window` of an image of `width` columns as a PNG file, each of its pixels `zoom` wide and high.
///
/// # Panics
/// If the window leaves the image.
pub fn crop(rgb: &[u8], width: u32, window: Crop, zoom: u32) -> Vec<u8> {
    let zoom = zoom.max(1);
    let rows = window.y..window.y + window.height;
    let bytes: Vec<u8> = rows
        .flat_map(|y| {
            let from = 3 * (y as usize * width as usize + window.x as usize);
            let row = &rgb[from..from + 3 * window.width as usize];
            let row: Vec<u8> = row.chunks_exact(3).flat_map(|color| color.repeat(zoom as usize)).collect();
            row.repeat(zoom as usize)
        })
        .collect();
    png(&bytes, zoom * window.width, zoom * window.height)
}

/// Side of the window that is looked for, of the shorter side of the film.
const SHARE: u32 = 4;
/// Least side of it, in pixels.
const LEAST_SIDE: u32 = 16;
/// The largest errors of an image count as that of which so many in a thousand are larger: a single bright sample is no place.
const OUTLIERS: usize = 5;

/// The hardest part of a film: the square window, a quarter of the film's shorter side but at least 16 pixels wide, whose mean
/// error is largest, by the geometric mean over all `errors`: one a configuration, each the relative errors of all pixels.
/// The first in reading order where several are equal. The largest errors of an image are cut off at its quantile of
/// 99.5 %; what is not finite counts as 0.
///
/// # Panics
/// If an image of errors has another size than the film, or the film has no pixel.
pub fn hardest_region(errors: &[&[f64]], width: u32, height: u32) -> Crop {
    assert!(width > 0 && height > 0 && errors.iter().all(|errors| errors.len() == width as usize * height as usize));
    let shorter = width.min(height);
    let side = (shorter / SHARE).max(LEAST_SIDE).min(shorter);
    let tables: Vec<SummedAreas> = errors.iter().map(|errors| SummedAreas::new(&cut(errors), width)).collect();
    let mut best = (f64::NEG_INFINITY, Crop { x: 0, y: 0, width: side, height: side });
    for y in 0..=height - side {
        for x in 0..=width - side {
            let window = Crop { x, y, width: side, height: side };
            let score: f64 = tables.iter().map(|table| table.sum(window).max(f64::MIN_POSITIVE).ln()).sum();
            // Sums of the same values in another order differ in their last bits.
            if score > best.0 + 1e-9 {
                best = (score, window);
            }
        }
    }
    best.1
}

/// Errors without outliers.
fn cut(errors: &[f64]) -> Vec<f64> {
    let finite = |error: &f64| if error.is_finite() { error.max(0.0) } else { 0.0 };
    let mut sorted: Vec<f64> = errors.iter().map(finite).collect();
    let rank = sorted.len() - 1 - sorted.len() * OUTLIERS / 1000;
    let (_, most, _) = sorted.select_nth_unstable_by(rank, f64::total_cmp);
    let most = *most;
    errors.iter().map(|error| finite(error).min(most)).collect()
}

/// Sums over all rectangles that begin at the top left (Crow 1984).
struct SummedAreas {
    /// One row and column more than the image: the first are 0.
    sums: Vec<f64>,
    stride: usize,
}

impl SummedAreas {
    fn new(values: &[f64], width: u32) -> SummedAreas {
        let stride = width as usize + 1;
        let mut sums = vec![0.0; stride];
        for row in values.chunks_exact(width as usize) {
            let above = sums.len() - stride;
            let mut sum = 0.0;
            sums.push(0.0);
            for (x, value) in row.iter().enumerate() {
                sum += value;
                sums.push(sums[above + x + 1] + sum);
            }
        }
        SummedAreas { sums, stride }
    }

    fn sum(&self, window: Crop) -> f64 {
        let at = |x: u32, y: u32| self.sums[y as usize * self.stride + x as usize];
        let (right, bottom) = (window.x + window.width, window.y + window.height);
        at(right, bottom) - at(window.x, bottom) - at(right, window.y) + at(window.x, window.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A counter-based hash to [0, 1).
    fn noise(i: usize) -> f64 {
        let mut h = (i as u32).wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
        for _ in 0..3 {
            h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
        }
        (h >> 8) as f64 / 16_777_216.0
    }

    /// A film as a path tracer leaves it at few samples: a smooth image under noise that follows its brightness.
    fn noisy(side: u32) -> Vec<u8> {
        let pixel = |i: usize| {
            let (x, y) = ((i as u32 % side) as f64 / side as f64, (i as u32 / side) as f64 / side as f64);
            let light = 0.15 + 0.6 * (1.0 - y) * (0.5 + 0.5 * (6.0 * x).sin().abs());
            let grain = 1.0 + 0.35 * (noise(3 * i) + noise(3 * i + 1) + noise(3 * i + 2) - 1.5);
            [1.0, 0.8, 0.6].map(|tint| crate::color::srgb8((light * tint * grain) as f32, 0.0))
        };
        (0..(side * side) as usize).flat_map(pixel).collect()
    }

    fn decoded(bytes: &[u8]) -> (Vec<u8>, u32, u32) {
        let image = image::load_from_memory(bytes).unwrap();
        let (width, height) = (image.width(), image.height());
        (image.into_rgb8().into_raw(), width, height)
    }

    #[test]
    fn pngs_keep_every_bit_with_a_palette_of_any_size() {
        for colors in [1usize, 2, 3, 4, 5, 16, 17, 255, 256, 257, 3000] {
            for width in [1u32, 7, 8, 33] {
                let height = 3000u32.div_ceil(width);
                let color = |i: usize| {
                    let value = i * 7919 % colors;
                    [(value % 256) as u8, (value / 256) as u8, 9]
                };
                let rgb: Vec<u8> = (0..(width * height) as usize).flat_map(color).collect();
                let bytes = png(&rgb, width, height);
                assert_eq!(decoded(&bytes), (rgb, width, height), "{colors} colours, {width} columns");
                // Byte 25 of a file is its colour type: 3 with a palette, 2 without.
                assert_eq!(bytes[25], if colors <= 256 { 3 } else { 2 });
            }
        }
    }

    #[test]
    fn noisy_pictures_are_small_and_like_what_they_show() {
        let rgb = noisy(256);
        let (kind, bytes) = picture(&rgb, 256, 256, MOST_BYTES);
        assert_eq!(kind, "jpeg");
        assert!((MOST_BYTES / 2..=MOST_BYTES).contains(&bytes.len()), "{}", bytes.len());
        let (back, width, height) = decoded(&bytes);
        assert_eq!((width, height), (256, 256));
        let squares = rgb.iter().zip(&back).map(|(a, b)| (*a as f64 - *b as f64).powi(2));
        let off = (squares.sum::<f64>() / rgb.len() as f64).sqrt();
        assert!(off < 10.0, "off by {off} of 255");
        // The mean is what the eye compares between images.
        let mean = |bytes: &[u8]| bytes.iter().map(|b| *b as f64).sum::<f64>() / bytes.len() as f64;
        assert!((mean(&rgb) - mean(&back)).abs() < 0.5);
    }

    #[test]
    fn pictures_are_lossless_where_that_is_small_and_as_good_as_their_bytes_allow() {
        // Black with bright dots, as a strategy that seldom meets a light leaves it.
        let dots: Vec<u8> =
            (0..128 * 128).flat_map(|i| if noise(i) < 0.02 { [250, 240, (i % 7) as u8] } else { [0; 3] }).collect();
        let (kind, bytes) = picture(&dots, 128, 128, 8_000);
        assert_eq!((kind, decoded(&bytes).0), ("png", dots));
        // Fewer bytes allowed, fewer taken; the least there is where that is not enough.
        let rgb = noisy(128);
        let sizes = [20_000, 9_000, 6_000, 1].map(|most| picture(&rgb, 128, 128, most).1.len());
        assert!(sizes[0] <= 20_000 && sizes[1] <= 9_000 && sizes[2] <= sizes[1] && sizes[3] <= sizes[2], "{sizes:?}");
        assert_eq!(sizes[3], jpeg(&rgb, 128, 128, QUALITIES[8]).len());
    }

    #[test]
    fn addresses_hold_their_bytes() {
        assert_eq!(data_uri("png", b"abc"), "data:image/png;base64,YWJj");
    }

    #[test]
    fn zoomable_pictures_hold_their_bytes_once_and_take_the_keyboard() {
        let text = zoomable("data:image/png;base64,YWJj", 64, 48, "a <b>", true).into_string();
        assert_eq!(text.matches("YWJj").count(), 1);
        let page = scraper::Html::parse_fragment(&text);
        let select = |css: &str| page.select(&scraper::Selector::parse(css).unwrap()).count();
        assert_eq!(
            select("label.zoom > input[type=checkbox][aria-label='Enlarge: a <b>'] + img.pixels[alt='a <b>']"),
            1
        );
        assert!(!text.contains("script") && text.contains("aspect-ratio:64/48"));
        assert!(STYLE.contains("input:checked+img") && STYLE.contains("focus-visible"));
    }

    #[test]
    fn crops_are_the_pixels_of_their_window_enlarged() {
        let (width, window) = (20u32, Crop { x: 3, y: 5, width: 6, height: 4 });
        let rgb: Vec<u8> = (0..width * 10).flat_map(|i| [i as u8, (i * 3) as u8, 7]).collect();
        for zoom in [1, 2, 5] {
            let (bytes, columns, rows) = decoded(&crop(&rgb, width, window, zoom));
            assert_eq!((columns, rows), (6 * zoom, 4 * zoom));
            for y in 0..rows {
                for x in 0..columns {
                    let i = (window.y + y / zoom) * width + window.x + x / zoom;
                    let at = 3 * (y * columns + x) as usize;
                    assert_eq!(bytes[at..at + 3], [i as u8, (i * 3) as u8, 7]);
                }
            }
        }
    }

    /// The window by looking at every pixel of every window.
    fn by_force(errors: &[&[f64]], width: u32, height: u32) -> (f64, Crop) {
        let side = (width.min(height) / 4).max(16).min(width.min(height));
        let mut best = (f64::NEG_INFINITY, Crop { x: 0, y: 0, width: side, height: side });
        for y in 0..=height - side {
            for x in 0..=width - side {
                let pixels = (y..y + side).flat_map(|y| (x..x + side).map(move |x| (y * width + x) as usize));
                let pixels: Vec<usize> = pixels.collect();
                let mean = |errors: &[f64]| {
                    let mut sorted = errors.to_vec();
                    sorted.sort_by(f64::total_cmp);
                    let most = sorted[sorted.len() - 1 - sorted.len() * 5 / 1000];
                    pixels.iter().map(|i| errors[*i].min(most)).sum::<f64>()
                };
                let score = errors.iter().map(|errors| mean(errors).ln()).sum::<f64>();
                if score > best.0 + 1e-9 {
                    best = (score, Crop { x, y, width: side, height: side });
                }
            }
        }
        best
    }

    #[test]
    fn the_hardest_region_is_that_of_brute_force() {
        for (width, height, seed) in
            [(40u32, 30u32, 1usize), (30, 40, 2), (16, 16, 3), (70, 19, 4), (10, 12, 5), (72, 66, 6)]
        {
            let count = (width * height) as usize;
            let image =
                |n: usize| (0..count).map(|i| noise(seed * 100_000 + n * 10_000 + i).powi(4)).collect::<Vec<f64>>();
            let images = [image(0), image(1), image(2)];
            let images: Vec<&[f64]> = images.iter().map(Vec::as_slice).collect();
            assert_eq!(
                hardest_region(&images, width, height),
                by_force(&images, width, height).1,
                "{width} x {height}"
            );
        }
    }

    #[test]
    fn the_hardest_region_is_where_all_have_errors_and_not_where_one_has_a_spike() {
        let (width, height) = (128u32, 96u32);
        let image = |patch: (u32, u32), strength: f64| -> Vec<f64> {
            let inside = |x: u32, y: u32| (patch.0..patch.0 + 24).contains(&x) && (patch.1..patch.1 + 24).contains(&y);
            let pixel = |i: u32| if inside(i % width, i / width) { strength } else { 0.1 };
            (0..width * height).map(pixel).collect()
        };
        // Both are bad at (70, 40); one more so at (10, 10).
        let mut one = image((70, 40), 0.4);
        let other = image((70, 40), 0.3);
        image((10, 10), 0.5).iter().zip(&mut one).for_each(|(error, one)| *one = one.max(*error));
        one[0] = 1e9;
        one[1] = f64::NAN;
        one[2] = f64::INFINITY;
        let found = hardest_region(&[&one, &other], width, height);
        assert_eq!(found, Crop { x: 70, y: 40, width: 24, height: 24 });
        // Without errors, and without images, it is the first.
        let none = vec![0.0; (width * height) as usize];
        assert_eq!(hardest_region(&[&none], width, height), Crop { x: 0, y: 0, width: 24, height: 24 });
        assert_eq!(hardest_region(&[], 5, 9), Crop { x: 0, y: 0, width: 5, height: 5 });
    }
}
