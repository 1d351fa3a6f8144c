//! OpenEXR files of others, read: which of their layers is the picture, what its channels and its numbers mean.

use crate::files::memory::{self, amount};
use crate::image::exr::VARIANCE;
use crate::image::primaries::{convert, to_rec709};
use crate::image::{Bounds, Image, Windows};
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{ChannelDescription, EnvironmentMap};
use ::exr::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::io::Cursor;

/// What renderers and compositors call the layer that is the picture.
const MAIN_LAYERS: [&str; 8] = ["combined", "beauty", "rgba", "rgb", "color", "colour", "main", "default"];
/// Names that a message lists at most.
const MOST_NAMED: usize = 24;

/// Reads the layer that is the picture, and the variance and settings beside it if they are there.
pub(in super::super) fn read(bytes: &[u8]) -> std::result::Result<Image, String> {
    plausible(bytes)?;
    let file = read_all(bytes).map_err(|error| error.to_string())?;
    let mut warnings = Vec::new();
    let found = picture(&file, &mut warnings)?;
    let part = &file.layer_data[found.part];
    let (width, height) = size(part.size)?;
    let shown = file.attributes.display_window;
    let (display_width, display_height) = size(shown.size)?;
    let Vec2(x, y) = part.attributes.layer_position;
    let windows = Windows {
        display: Bounds { x: shown.position.0, y: shown.position.1, width: display_width, height: display_height },
        data_origin: (x, y),
    };
    let fills = windows.display == Bounds { x, y, width, height };
    let mut pixels = planes(part, found.channels);
    let mut variance = three(part, VARIANCE).map(|channels| planes(part, channels));
    if let Some(of) = file.attributes.chromaticities {
        let of = [of.red, of.green, of.blue, of.white].map(|Vec2(x, y)| [f64::from(x), f64::from(y)]);
        match to_rec709(of) {
            Ok(Some(matrix)) => {
                convert(&matrix, &mut pixels);
                // That of a mixture of channels depends on how they go together, which no file says.
                variance = None;
            }
            Ok(None) => {}
            Err(why) => warnings.push(format!("the attribute `chromaticities` has no effect: {why}")),
        }
    }
    let comments = part.attributes.comments.as_ref().map(words).unwrap_or_default();
    let setting = |line: &str| line.split_once(" = ").map(|(key, value)| (key.to_owned(), value.to_owned()));
    Ok(Image {
        width,
        height,
        pixels,
        variance,
        metadata: comments.lines().filter_map(setting).collect(),
        windows: (!fills).then_some(windows),
        is_cube: part.attributes.environment_map == Some(EnvironmentMap::Cube),
        warnings,
    })
}

/// Header text: UTF-8, or else Latin-1, one byte a character.
fn words(text: &Text) -> String {
    match std::str::from_utf8(text.as_slice()) {
        Ok(text) => text.to_owned(),
        Err(_) => text.to_string(),
    }
}

/// Channels that can be the picture.
struct Found {
    part: usize,
    /// The layer's name, `.` between its parts; empty: the file's own.
    layer: String,
    /// Places of red, green and blue in the part's list: one place three times if it is grey.
    channels: [usize; 3],
}

/// The channels that are the picture: the file's own R, G, B; else those of a layer that is called so; else of the first that has
/// them; else a luminance alone.
fn picture(file: &AnyImage, warnings: &mut Vec<String>) -> std::result::Result<Found, String> {
    let mut found = Vec::new();
    for (part, layer) in file.layer_data.iter().enumerate() {
        let name = layer.attributes.layer_name.as_ref().map(words).unwrap_or_default();
        let mut of_part = colours(layer);
        // A part's own channels go before its layers, whatever those are called: what the part is called counts among parts.
        if of_part.iter().any(|(prefix, _)| prefix.is_empty()) {
            of_part.retain(|(prefix, _)| prefix.is_empty());
        }
        for (prefix, channels) in of_part {
            let full =
                [name.as_str(), &prefix].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(".");
            found.push(Found { part, layer: full, channels });
        }
    }
    let rank = |found: &Found| {
        let last = split(&found.layer).1.to_lowercase();
        match last.is_empty() {
            true => 0,
            false => 1 + MAIN_LAYERS.iter().position(|main| **main == last).unwrap_or(MAIN_LAYERS.len()),
        }
    };
    // Known by its name; of several that are called alike, the first is a guess.
    let ranks: Vec<usize> = found.iter().map(rank).collect();
    let is_sure = |found: &Found| {
        let rank = rank(found);
        rank <= MAIN_LAYERS.len() && ranks.iter().filter(|other| **other == rank).count() == 1
    };
    let names: Vec<String> = found.iter().map(|found| found.layer.clone()).collect();
    // The first of the least.
    let best = found.into_iter().min_by_key(rank);
    let Some(best) = best else {
        let all = file.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
        let all: Vec<String> = all.map(|channel| words(&channel.name)).collect();
        return Err(format!("no layer with the channels R, G and B, or Y alone; its channels are {}", listed(&all)));
    };
    if names.len() > 1 && !is_sure(&best) {
        warnings.push(format!("layer `{}` is read; there are {}", best.layer, listed(&names)));
    }
    Ok(best)
}

/// Some names, and how many more there are.
fn listed(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMED).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The layers of a part, by what stands before the last `.` of their channels, that have red, green and blue at full resolution;
/// without any, those of a luminance alone.
fn colours(part: &Part) -> Vec<(String, [usize; 3])> {
    // Tables, as a header may name channels by the ten thousand.
    let mut layers: BTreeMap<String, HashMap<String, usize>> = BTreeMap::new();
    for (place, channel) in part.channel_data.list.iter().enumerate() {
        let (layer, own) = split(&words(&channel.name));
        layers.entry(layer).or_default().entry(own.to_lowercase()).or_insert(place);
    }
    // The variance of ours is no picture.
    layers.remove("variance");
    let colour = |(name, channels): (&String, &HashMap<String, usize>)| {
        let place = |names: [&str; 2]| {
            let mut places = names.iter().filter_map(|name| channels.get(*name).copied());
            places.find(|&at| is_whole(part, at))
        };
        Some((name.clone(), [place(["r", "red"])?, place(["g", "green"])?, place(["b", "blue"])?]))
    };
    let colours: Vec<_> = layers.iter().filter_map(colour).collect();
    let grey = |(name, channels): (&String, &HashMap<String, usize>)| {
        // With chroma beside it, it is not the whole picture; nor is the y of a vector.
        let is_alone = !["ry", "by", "x", "z"].iter().any(|other| channels.contains_key(*other));
        let y = channels.get("y").copied().filter(|&at| is_alone && is_whole(part, at))?;
        Some((name.clone(), [y; 3]))
    };
    if colours.is_empty() { layers.iter().filter_map(grey).collect() } else { colours }
}

/// A channel's layer and its own name.
fn split(name: &str) -> (String, String) {
    let (layer, own) = name.rsplit_once('.').unwrap_or(("", name));
    (layer.to_owned(), own.to_owned())
}

/// Bytes that one byte of a file becomes at most: deflate makes 1,032 of it, PIZ's Huffman codes some 450, all others less.
const MOST_EXPANSION: u64 = 1100;
/// Bytes that a file has for every block of pixels, at least: its place in the table of offsets, its own place and length.
const LEAST_BLOCK: u64 = 16;
/// Bytes that a pixel takes beside its samples while an image is made of them: three f32 of radiance and three of variance.
const DECODING: u64 = 2 * 12;

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
type Part = Layer<AnyChannels<FlatSamples>>;

/// Whether a channel has a sample for each pixel.
fn is_whole(part: &Part, channel: usize) -> bool {
    part.channel_data.list.get(channel).is_some_and(|channel| channel.sample_data.len() == part.size.area())
}

/// Three channels by their names, if all are there.
fn three(part: &Part, names: [&str; 3]) -> Option<[usize; 3]> {
    let find = |name: &str| part.channel_data.list.iter().position(|channel| channel.name.eq(name));
    let [Some(r), Some(g), Some(b)] = names.map(find) else { return None };
    [r, g, b].iter().all(|&channel| is_whole(part, channel)).then_some([r, g, b])
}

/// Three channels as one list of pixels.
fn planes(part: &Part, channels: [usize; 3]) -> Vec<[f32; 3]> {
    let [r, g, b] = channels.map(|channel| part.channel_data.list[channel].sample_data.values_as_f32());
    r.zip(g).zip(b).map(|((r, g), b)| [r, g, b]).collect()
}
