//! OpenEXR: f32 radiance in `R,G,B`, the variance of each pixel's mean in `variance.R,G,B` (where it is known), settings
//! in the header.
//!
//! Settings go into the standard attribute `comments`, one `key = value` a line, and not into attributes of their own: the
//! `exr` crate keeps those in a hash map and writes them in a different order every time. No compression: noise in f32
//! hardly shrinks, and the bytes then depend on no compressor's version.

use crate::fault::{Fault, planted};
use crate::files::atomic::Sink;
use crate::image::exr::{Header, Pixels};
use crate::image::{Windows, encoding};
use ::exr::image::write::channels::WritableChannels;
use ::exr::prelude::*;
use std::io;

const COLOR: [&str; 3] = ["R", "G", "B"];
pub(super) const VARIANCE: [&str; 3] = ["variance.R", "variance.G", "variance.B"];

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

/// Header text in UTF-8, which the official library's readers take it for.
fn text(content: &str) -> Text {
    Text::from_bytes_unchecked(content.bytes().collect())
}
