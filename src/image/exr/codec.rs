//! OpenEXR: f32 radiance in `R,G,B`, the variance of each pixel's mean in `variance.R,G,B` (where it is known), settings
//! in the header.
//!
//! Settings go into the standard attribute `comments`, one `key = value` a line, and not into attributes of their own: the
//! `exr` crate keeps those in a hash map and writes them in a different order every time. No compression: noise in f32
//! hardly shrinks, and the bytes then depend on no compressor's version.

use crate::fault::{Fault, planted};
use crate::files::atomic::Sink;
use crate::files::memory::{self, amount};
use crate::image::exr::{Header, Pixels};
use crate::image::{Bounds, Image, Windows, encoding};
use ::exr::image::write::channels::WritableChannels;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::ChannelDescription;
use ::exr::prelude::*;
use std::io::{self, Cursor};

const COLOR: [&str; 3] = ["R", "G", "B"];
const VARIANCE: [&str; 3] = ["variance.R", "variance.G", "variance.B"];

/// Writes radiance, its variance (where it is known) and settings. Pixels are asked for row by row, as they are written: a
/// copy of the values as f32, in pixels and again in planes, would take 48 bytes a pixel beside the film's 120.
pub(in super::super) fn write(
    header: &Header,
    pixels: Pixels,
    with_variance: bool,
    out: &mut dyn Sink,
) -> io::Result<()> {
    let at = move |Vec2(x, y): Vec2<usize>| pixels(x as u32, y as u32);
    let ([r, g, b], [variance_r, variance_g, variance_b]) = (COLOR, VARIANCE);
    if with_variance {
        let channels = SpecificChannels::build().with_channel(r).with_channel(g).with_channel(b);
        let channels = channels.with_channel(variance_r).with_channel(variance_g).with_channel(variance_b);
        let values = move |place| {
            let ([r, g, b], variance) = at(place);
            let ([r, g, b], [vr, vg, vb]) = ([r, g, b].map(kept), variance.map(kept));
            (r, g, b, vr, vg, vb)
        };
        image(header, channels.with_pixel_fn(values)).write().non_parallel().to_buffered(out).map_err(failed)
    } else {
        let channels = SpecificChannels::build().with_channel(r).with_channel(g).with_channel(b);
        let values = move |place| {
            let [r, g, b] = at(place).0.map(kept);
            (r, g, b)
        };
        image(header, channels.with_pixel_fn(values)).write().non_parallel().to_buffered(out).map_err(failed)
    }
}

/// What the system said, if it did: a full disk has a hint of its own.
fn failed(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(error) => error,
        other => encoding(other),
    }
}

/// A file of one layer.
fn image<'c, C: WritableChannels<'c> + 'c>(header: &Header, channels: C) -> ::exr::prelude::Image<Layer<C>> {
    let settings: Vec<String> = header.metadata.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let attributes = LayerAttributes {
        software_name: Some(text(concat!("octray ", env!("CARGO_PKG_VERSION")))),
        comments: Some(text(&settings.join("\n"))),
        layer_position: header.windows.map_or(Vec2(0, 0), |Windows { data_origin: (x, y), .. }| Vec2(x, y)),
        ..LayerAttributes::default()
    };
    let encoding_options = Encoding {
        compression: Compression::Uncompressed,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (header.size.0 as usize, header.size.1 as usize);
    let layer = Layer::new(size, attributes, encoding_options, channels);
    let mut image = ::exr::prelude::Image::from_layer(layer);
    if let Some(Windows { display, .. }) = header.windows {
        let size = (display.width as usize, display.height as usize);
        image.attributes.display_window = IntegerBounds::new((display.x, display.y), size);
    }
    image
}

/// A value as the file has it: as it is.
fn kept(value: f32) -> f32 {
    if planted(Fault::RoundedFile) { value * 1.001 } else { value }
}

/// Header text; the format knows one byte a character, so others are written as `\u{..}`.
fn text(content: &str) -> Text {
    let bytes = content.chars().flat_map(|c| match u8::try_from(c) {
        Ok(byte) => vec![byte],
        Err(_) => c.escape_unicode().map(|c| c as u8).collect(),
    });
    Text::from_bytes_unchecked(bytes.collect())
}

/// Reads the first layer that has the channels R, G and B, and the variance and settings beside them if they are there.
pub(in super::super) fn read(bytes: &[u8]) -> std::result::Result<Image, String> {
    plausible(bytes)?;
    let file = read_all(bytes).map_err(|error| error.to_string())?;
    let wanted = |layer: &&Layer<AnyChannels<FlatSamples>>| planes(layer, COLOR).is_some();
    let Some(layer) = file.layer_data.iter().find(wanted) else {
        return Err("no layer with the channels R, G and B".into());
    };
    let (width, height) = size(layer.size)?;
    let shown = file.attributes.display_window;
    let (display_width, display_height) = size(shown.size)?;
    let Vec2(x, y) = layer.attributes.layer_position;
    let windows = Windows {
        display: Bounds { x: shown.position.0, y: shown.position.1, width: display_width, height: display_height },
        data_origin: (x, y),
    };
    let fills = windows.display == Bounds { x, y, width, height };
    let comments = layer.attributes.comments.as_ref().map(Text::to_string).unwrap_or_default();
    let setting = |line: &str| line.split_once(" = ").map(|(key, value)| (key.to_owned(), value.to_owned()));
    Ok(Image {
        width,
        height,
        pixels: planes(layer, COLOR).unwrap_or_default(),
        variance: planes(layer, VARIANCE),
        metadata: comments.lines().filter_map(setting).collect(),
        windows: (!fills).then_some(windows),
    })
}

/// Bytes that one byte of a file becomes at most: deflate makes 1,032 of it, PIZ's Huffman codes some 450, all others less.
const MOST_EXPANSION: u64 = 1100;
/// Bytes that a file has for every block of pixels, at least: its place in the table of offsets, its own place and length.
const LEAST_BLOCK: u64 = 16;
/// Bytes that a pixel takes beside its samples while an image is made of them: six planes and two lists of three f32.
const DECODING: u64 = 6 * 4 + 2 * 12;

/// Refuses what the file's own length belies, before the crate that decodes it takes the header at its word; and what there is no
/// memory for.
fn plausible(bytes: &[u8]) -> std::result::Result<(), String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
    let length = bytes.len() as u64;
    let (mut samples, mut blocks, mut pixels) = (0u64, 0u64, 0u64);
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        let area = (width as u64).saturating_mul(height as u64);
        let each = |channel: &ChannelDescription| {
            let Vec2(x, y) = channel.sampling;
            let count = area / (x.max(1) as u64 * y.max(1) as u64);
            count.saturating_mul(channel.sample_type.bytes_per_sample() as u64)
        };
        let of_layer = header.channels.list.iter().map(each).fold(0, u64::saturating_add);
        samples = samples.saturating_add(of_layer);
        blocks = blocks.saturating_add(header.chunk_count as u64);
        pixels = pixels.max(area);
    }
    if samples > length.saturating_mul(MOST_EXPANSION) || blocks > length / LEAST_BLOCK {
        return Err(format!("the header promises {} of pixels, more than {length} bytes can hold", amount(samples)));
    }
    let bytes = samples.saturating_add(pixels.saturating_mul(DECODING));
    memory::claim(bytes, "the image").map_err(|error| error.to_string())
}

/// Columns and rows.
fn size(Vec2(width, height): Vec2<usize>) -> std::result::Result<(u32, u32), String> {
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(width), Ok(height)) => Ok((width, height)),
        _ => Err(format!("{width} x {height} pixels are more than this program reads")),
    }
}

fn read_all(bytes: &[u8]) -> ::exr::error::Result<AnyImage> {
    let reader = ::exr::prelude::read().no_deep_data().largest_resolution_level();
    reader.all_channels().all_layers().all_attributes().non_parallel().from_buffered(Cursor::new(bytes))
}

type AnyImage = ::exr::prelude::Image<Layers<AnyChannels<FlatSamples>>>;

/// Three channels as one list of pixels; `None` unless all three are there, at full resolution.
fn planes(layer: &Layer<AnyChannels<FlatSamples>>, names: [&str; 3]) -> Option<Vec<[f32; 3]>> {
    let find = |name: &str| {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.eq(name))?;
        Some(channel.sample_data.values_as_f32().collect::<Vec<f32>>())
    };
    let [Some(r), Some(g), Some(b)] = names.map(find) else { return None };
    let count = layer.size.area();
    let complete = [&r, &g, &b].iter().all(|plane| plane.len() == count);
    complete.then(|| r.into_iter().zip(g).zip(b).map(|((r, g), b)| [r, g, b]).collect())
}
