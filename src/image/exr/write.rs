//! OpenEXR: radiance in `R,G,B`, beside it the variance of each pixel's mean and layers as they are wanted, settings in the header.
//!
//! Settings go into the standard attribute `comments`, one `key = value` a line, from which they are read again, and, with their
//! types, into attributes of their own ([`super::attributes`]). Unless asked for there is no compression: noise in f32 hardly
//! shrinks, and the bytes then depend on no compressor's version. (What ZIP makes of the same numbers is the same in every build
//! all the same: the compressor is code of ours to lock, one block after the other.)

use crate::fault::{Fault, planted};
use crate::files::atomic::Sink;
use crate::image::exr::attributes::{Noted, text, typed};
use crate::image::exr::{Header, Pixels, VARIANCE};
use crate::image::{Windows, encoding};
use ::exr::block::BlockIndex;
use ::exr::image::write::channels::{ChannelsWriter, WritableChannels};
use ::exr::math::RoundingMode;
use ::exr::meta::attribute::{ChannelList, LevelMode};
use ::exr::meta::header::Header as Meta;
use ::exr::prelude::*;
use std::io;

/// Writes pixels, which are asked for row by row, as they are written: a copy of the values as f32, in pixels and again in planes,
/// would take 48 bytes a pixel beside the film's 120.
pub(in super::super) fn write(header: &Header, pixels: Pixels, out: &mut dyn Sink) -> io::Result<()> {
    let mut channels: Vec<Plane> = (0..).zip(&header.channels).map(|(place, name)| Plane { name, place }).collect();
    channels.sort_unstable_by_key(|channel| channel.name);
    let planes = Planes { channels, half: header.encoding.half, pixels };
    let mut noted = Noted::new(out);
    image(header, planes).write().non_parallel().to_buffered(&mut noted).map_err(failed)?;
    noted.sort()
}

/// What the system said, if it did: a full disk has a hint of its own.
fn failed(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(error) => error,
        other => encoding(other),
    }
}

/// A file of one layer.
fn image<'a>(header: &Header, channels: Planes<'a>) -> ::exr::prelude::Image<Layer<Planes<'a>>> {
    let settings: Vec<String> = header.metadata.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let attributes = LayerAttributes {
        software_name: Some(text(concat!("octray ", env!("CARGO_PKG_VERSION")))),
        comments: Some(text(&settings.join("\n"))),
        layer_position: header.windows.map_or(Vec2(0, 0), |Windows { data_origin: (x, y), .. }| Vec2(x, y)),
        other: typed(header.metadata),
        ..LayerAttributes::default()
    };
    let encoding_options = Encoding {
        compression: if header.encoding.zip { Compression::ZIP16 } else { Compression::Uncompressed },
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

/// A channel.
#[derive(Clone, Copy)]
struct Plane {
    name: &'static str,
    /// Its place among the values of a pixel.
    place: usize,
}

/// The channels of a file, in its order: sorted by name.
#[derive(Clone)]
struct Planes<'a> {
    channels: Vec<Plane>,
    /// All but depths and variances are f16.
    half: bool,
    pixels: Pixels<'a>,
}

impl Planes<'_> {
    fn sample_type(&self, channel: &Plane) -> SampleType {
        let is_half = self.half && channel.name != "Z" && !VARIANCE.contains(&channel.name);
        if is_half { SampleType::F16 } else { SampleType::F32 }
    }
}

impl<'p> WritableChannels<'p> for Planes<'p> {
    type Writer = Planes<'p>;

    fn infer_channel_list(&self) -> ChannelList {
        let described = |channel: &Plane| ChannelDescription::new(channel.name, self.sample_type(channel), false);
        ChannelList::new(self.channels.iter().map(described).collect())
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&'p self, _: &Meta) -> Planes<'p> {
        self.clone()
    }
}

impl ChannelsWriter for Planes<'_> {
    /// Row by row, in each channel by channel.
    fn extract_uncompressed_block(&self, _: &Meta, block: BlockIndex) -> Vec<u8> {
        let (Vec2(left, top), Vec2(width, height)) = (block.pixel_position, block.pixel_size);
        let types: Vec<SampleType> = self.channels.iter().map(|channel| self.sample_type(channel)).collect();
        let mut starts = Vec::new();
        let mut length = 0;
        for of_channel in &types {
            starts.push(length);
            length += width * of_channel.bytes_per_sample();
        }
        let mut bytes = vec![0; length * height];
        let mut values = vec![0.0; self.channels.len()];
        for (y, row) in bytes.chunks_exact_mut(length.max(1)).enumerate() {
            for x in 0..width {
                (self.pixels)((left + x) as u32, (top + y) as u32, &mut values);
                for ((channel, of_channel), start) in self.channels.iter().zip(&types).zip(&starts) {
                    let value = kept(values[channel.place]);
                    match of_channel {
                        SampleType::F16 => {
                            let most = crate::film::Encoding::MOST_HALF;
                            let value = f16::from_f32(value.clamp(-most, most));
                            row[start + 2 * x..][..2].copy_from_slice(&value.to_ne_bytes());
                        }
                        _ => row[start + 4 * x..][..4].copy_from_slice(&value.to_ne_bytes()),
                    }
                }
            }
        }
        bytes
    }
}

/// A value as the file has it: as it is.
fn kept(value: f32) -> f32 {
    if planted(Fault::RoundedFile) { value * 1.001 } else { value }
}
