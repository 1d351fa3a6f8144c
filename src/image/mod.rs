//! Image files: EXR, Radiance HDR, PFM (linear radiance) and PNG (sRGB).
//!
//! **Law:** a file's bytes depend on the film alone: no dates, no host names, no hash order. A file appears whole or not at
//! all ([`crate::files::atomic`]). In memory, row 0 is the top of the picture; PFM alone stores rows bottom-up.

mod exr;
mod hdr;
mod pfm;
mod png;
mod primaries;

use crate::color::srgb8;
use crate::error::{Error, Result};
use crate::files::atomic::Sink;
use crate::files::{atomic, memory, read};
use crate::film::{Encoding, Film};
use ::image::{DynamicImage, ImageDecoder, ImageFormat};
use std::io::{self, Cursor};
use std::path::Path;

/// A file format, chosen by the file's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: radiance, variance, layers, alpha, settings; known to builds with the feature `exr` alone.
    Exr,
    /// 8-bit sRGB, and alpha.
    Png,
    /// Radiance RGBE: 8 bits a channel and a shared exponent.
    Hdr,
    /// Portable float map: f32 radiance, nothing else.
    Pfm,
}

/// What a build without the feature `exr` says to such files.
const NO_EXR: &str = "this build knows no OpenEXR; use .pfm, or build octray with the feature `exr`";

impl Format {
    /// The format that `path`'s extension names (upper or lower case).
    pub fn of(path: &Path) -> Result<Format> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match extension.as_str() {
            "exr" if cfg!(feature = "exr") => Ok(Format::Exr),
            "exr" => Err(Error::Usage(format!("{}: {NO_EXR}", path.display()))),
            "png" => Ok(Format::Png),
            "hdr" => Ok(Format::Hdr),
            "pfm" => Ok(Format::Pfm),
            "" => Err(Error::Usage(format!("{}: no extension; use .exr, .png, .hdr or .pfm", path.display()))),
            other => Err(Error::Usage(format!(
                "{}: unknown image extension `.{other}`; use .exr, .png, .hdr or .pfm",
                path.display()
            ))),
        }
    }
}

/// Whether an image can be written to `path`, asked before a render instead of after it: the extension is known, the
/// directory exists and takes new files, and what stands there may be replaced.
pub fn check_output_path(path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    Format::of(path)?;
    atomic::check(path)
}

impl Film {
    /// Writes the picture to `path` in the format its extension names: `.exr`, `.png`, `.hdr` or `.pfm`.
    ///
    /// The file appears whole or not at all; on an error an older file of that name is untouched.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        self.save_exposed(path.as_ref(), self.exposure)
    }

    /// [`Film::save`], with `exposure` stops in place of the film's own.
    pub fn save_exposed(&self, path: &Path, exposure: f64) -> Result<()> {
        let format = Format::of(path)?;
        atomic::write(path, |out| match format {
            Format::Exr => self.write_exr(out),
            Format::Png => png::write(self, exposure, out),
            Format::Hdr => hdr::write(self, out),
            Format::Pfm => pfm::write(self, out),
        })
    }

    /// Writes it as OpenEXR: means, and beside them what [`Film::layers`] wants and has.
    fn write_exr(&self, out: &mut dyn Sink) -> io::Result<()> {
        let has_variance = self.layers.has_variance() && self.sums().tell_errors();
        let layers = self.layers.channels();
        let variance = if has_variance { &exr::VARIANCE[..] } else { &[] };
        let names = exr::COLOR.iter().chain(variance).copied().chain(layers.iter().map(|layer| layer.name));
        let header = exr::Header {
            size: (self.width, self.height),
            metadata: &self.metadata,
            windows: self.windows(),
            channels: names.collect(),
            encoding: self.encoding,
        };
        let pixels = |x: u32, y: u32, values: &mut [f32]| {
            let (color, beside) = values.split_at_mut(3);
            color.copy_from_slice(&self.mean(x, y));
            let (variance, beside) = beside.split_at_mut(variance.len());
            if has_variance {
                variance.copy_from_slice(&self.variance(x, y));
            }
            let at = y as usize * self.width as usize + x as usize;
            beside.iter_mut().zip(&layers).for_each(|(value, layer)| *value = (layer.of)(&self.layers.pixels[at]));
        };
        exr::write(&header, &pixels, out)
    }

    /// The picture so far, as its EXR file would hold it: means, their variance, the settings.
    pub fn to_image(&self) -> Image {
        let places = || (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        Image {
            width: self.width,
            height: self.height,
            pixels: places().map(|(x, y)| self.mean(x, y)).collect(),
            // Where the error is not known, no figure says that it is 0.
            variance: self.sums().tell_errors().then(|| places().map(|(x, y)| self.variance(x, y)).collect()),
            metadata: self.metadata.clone(),
            windows: self.windows(),
            ..Image::default()
        }
    }

    /// Where these pixels lie, if they are not the whole film.
    fn windows(&self) -> Option<Windows> {
        self.place.map(|place| Windows {
            display: Bounds { x: 0, y: 0, width: place.film.0, height: place.film.1 },
            // A film has at most 65,535 columns and rows.
            data_origin: (place.x as i32, place.y as i32),
        })
    }

    /// The means of all pixels, row 0 at the top.
    fn means(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        (0..self.height).flat_map(move |y| (0..self.width).map(move |x| self.mean(x, y)))
    }
}

/// A rectangle of pixels that may lie anywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// First column.
    pub x: i32,
    /// First row.
    pub y: i32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Bounds {
    /// The pixels that are in both; `None` if there are none.
    pub fn overlap(&self, other: &Bounds) -> Option<Bounds> {
        // In i64: windows of other people's files may lie at the ends of i32.
        let both = |start: [i32; 2], size: [u32; 2]| {
            let end = |i: usize| start[i] as i64 + size[i] as i64;
            let (first, end) = (start[0].max(start[1]), end(0).min(end(1)));
            u32::try_from(end - first as i64).ok().filter(|size| *size > 0).map(|size| (first, size))
        };
        let (x, width) = both([self.x, other.x], [self.width, other.width])?;
        let (y, height) = both([self.y, other.y], [self.height, other.height])?;
        Some(Bounds { x, y, width, height })
    }
}

/// Where the pixels of an image lie that are not just what is to be shown, in OpenEXR's terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Windows {
    /// The display window: of a render, the whole film.
    pub display: Bounds,
    /// The first column and row of the data window; its size is the image's.
    pub data_origin: (i32, i32),
}

/// A picture read from a file: linear radiance, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` linear Rec.709 values, row by row.
    pub pixels: Vec<[f32; 3]>,
    /// The variance of each pixel's mean, where the file has it (EXR files of ours do).
    pub variance: Option<Vec<[f32; 3]>>,
    /// The settings of the render, where the file has them (EXR files of ours do).
    pub metadata: Vec<(String, String)>,
    /// Where the pixels lie in the display window; `None`: they fill it.
    pub windows: Option<Windows>,
    /// The file says that the six faces of a cube lie here one below the other.
    pub is_cube: bool,
    /// What a reader of the file should know of how it was taken.
    pub warnings: Vec<String>,
}

impl Image {
    /// Reads an `.exr`, `.pfm`, `.hdr` or `.png` file; sRGB values of a PNG become linear.
    pub fn read(path: impl AsRef<Path>) -> Result<Image> {
        let path = path.as_ref();
        let format = Format::of(path)?;
        let bytes = read::bytes(path)?;
        let image = match format {
            Format::Exr => exr::read(&bytes),
            Format::Png => png::read(&bytes),
            Format::Hdr => hdr::read(&bytes),
            Format::Pfm => pfm::read(&bytes),
        };
        image.map_err(|message| Error::parse(path, None, message))
    }

    /// Writes the picture to `path` as EXR: f32 radiance, its variance where known, the settings.
    ///
    /// # Errors
    /// [`Error::Write`]; an older file of that name is then untouched.
    pub fn save_exr(&self, path: impl AsRef<Path>) -> Result<()> {
        let names = exr::COLOR.iter().chain(if self.variance.is_some() { &exr::VARIANCE[..] } else { &[] });
        let header = exr::Header {
            size: (self.width, self.height),
            metadata: &self.metadata,
            windows: self.windows,
            channels: names.copied().collect(),
            encoding: Encoding::default(),
        };
        let pixels = |x: u32, y: u32, values: &mut [f32]| {
            let at = y as usize * self.width as usize + x as usize;
            values[..3].copy_from_slice(&self.pixels[at]);
            if let Some(variance) = &self.variance {
                values[3..].copy_from_slice(&variance[at]);
            }
        };
        atomic::write(path.as_ref(), |out| exr::write(&header, &pixels, out))
    }

    /// The picture as a PNG file shows it after `exposure` stops: 8-bit sRGB, three bytes a pixel.
    pub fn srgb8(&self, exposure: f64) -> Vec<u8> {
        self.pixels.iter().flatten().map(|value| srgb8(*value, exposure)).collect()
    }

    /// Writes the picture to `path` as PNG after `exposure` stops.
    ///
    /// # Errors
    /// [`Error::Write`]; an older file of that name is then untouched.
    pub fn save_png(&self, path: impl AsRef<Path>, exposure: f64) -> Result<()> {
        let bytes = self.srgb8(exposure);
        atomic::write(path.as_ref(), |out| png::write_bytes(&bytes, self.width, self.height, out))
    }

    /// What is to be shown: the display window.
    pub fn display(&self) -> Bounds {
        let whole = Bounds { x: 0, y: 0, width: self.width, height: self.height };
        self.windows.map_or(whole, |windows| windows.display)
    }

    /// Where the pixels lie: the data window.
    pub fn data(&self) -> Bounds {
        let (x, y) = self.windows.map_or((0, 0), |windows| windows.data_origin);
        Bounds { x, y, width: self.width, height: self.height }
    }

    /// The pixels in `area`, which lies in the data window.
    pub fn part(&self, area: Bounds) -> Image {
        let rows = |pixels: &Vec<[f32; 3]>| {
            let mut part = vec![[0.0; 3]; area.width as usize * area.height as usize];
            copy_rows((pixels, self.data()), (&mut part, area));
            part
        };
        Image {
            width: area.width,
            height: area.height,
            pixels: rows(&self.pixels),
            variance: self.variance.as_ref().map(rows),
            metadata: self.metadata.clone(),
            windows: Some(Windows { display: self.display(), data_origin: (area.x, area.y) }),
            ..Image::default()
        }
    }

    /// The picture as it is to be shown: the display window, black where there is no data.
    ///
    /// # Errors
    /// There is no memory for it; the message says so.
    pub fn shown(self) -> std::result::Result<Image, String> {
        let (shown, data) = (self.display(), self.data());
        if self.windows.is_none() {
            return Ok(self);
        }
        claim(shown.width.into(), shown.height.into(), 12)?;
        let mut pixels = vec![[0.0; 3]; shown.width as usize * shown.height as usize];
        copy_rows((&self.pixels, data), (&mut pixels, shown));
        Ok(Image { width: shown.width, height: shown.height, pixels, variance: None, windows: None, ..self })
    }

    /// The value at column `x` of row `y`, row 0 at the top.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        self.pixels[y as usize * self.width as usize + x as usize]
    }
}

/// Copies the pixels that are in both rectangles.
fn copy_rows((from, of_from): (&[[f32; 3]], Bounds), (to, of_to): (&mut [[f32; 3]], Bounds)) {
    let Some(both) = of_from.overlap(&of_to) else { return };
    let place = |of: Bounds, row: u32| {
        let (x, y) = (both.x.abs_diff(of.x) as usize, both.y.abs_diff(of.y) as usize);
        let start = (y + row as usize) * of.width as usize + x;
        start..start + both.width as usize
    };
    (0..both.height).for_each(|row| to[place(of_to, row)].copy_from_slice(&from[place(of_from, row)]));
}

/// Asks for the memory that `count` pixels of `bytes` each take while they are decoded, before any of it is taken.
fn claim(width: u64, height: u64, bytes: u64) -> std::result::Result<(), String> {
    let wanted = width.saturating_mul(height).saturating_mul(bytes);
    memory::claim(wanted, &format!("an image of {width} x {height} pixels")).map_err(|error| error.to_string())
}

/// Bytes that a pixel takes at most while it is decoded: as the file has it, as what is made of that, and as three f32.
const DECODING: u64 = 8 + 6 + 12;

/// Decodes by the `image` crate, if there is memory for it.
pub fn decode(bytes: &[u8], format: ImageFormat) -> std::result::Result<DynamicImage, String> {
    let mut reader = ::image::ImageReader::with_format(Cursor::new(bytes), format);
    // What was claimed is the limit; the crate's own would refuse large maps of machines that have room for them.
    reader.no_limits();
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    let each = DECODING + u64::from(decoder.color_type().bytes_per_pixel());
    // Deflate makes 1,032 bytes of one at most, of which a picture of one bit a pixel and a palette makes 24 times as many.
    let most = (bytes.len() as u64).saturating_mul(1032 * 24);
    if format == ImageFormat::Png && decoder.total_bytes() > most {
        return Err(format!("the header promises {width} x {height} pixels, more than {} bytes can hold", bytes.len()));
    }
    claim(u64::from(width), u64::from(height), each)?;
    DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())
}

/// An encoder's error as an I/O error, which [`atomic::write`] turns into a message.
fn encoding(error: impl std::fmt::Display) -> io::Error {
    io::Error::other(error.to_string())
}
