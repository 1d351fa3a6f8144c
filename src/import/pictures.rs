//! Picture files, PNG, JPEG and TGA: each read once, and only if it is whole.

use crate::error::Error;
use crate::files::read;
use crate::image::decode;
use crate::import::jpeg;
use crate::scene::desc::{MaskDesc, TextureDesc};
use ::image::ImageFormat;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The numbers of the files that were read, and why others could not be: neither is tried twice.
#[derive(Default)]
pub struct Numbers(HashMap<PathBuf, std::result::Result<u32, String>>);

impl Numbers {
    /// The number of `path`; the first time, what `read` makes it.
    pub fn get_or(
        &mut self,
        path: &Path,
        read: impl FnOnce() -> std::result::Result<u32, String>,
    ) -> std::result::Result<u32, String> {
        if let Some(known) = self.0.get(path) {
            return known.clone();
        }
        let number = read();
        self.0.insert(path.to_owned(), number.clone());
        number
    }
}

/// The format that a file's first bytes tell, whatever it is called; TGA files have none that do.
fn format(bytes: &[u8], may_be_tga: bool) -> std::result::Result<ImageFormat, String> {
    match ::image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => Ok(format),
        // A TGA file may begin with almost anything.
        _ if may_be_tga => Ok(ImageFormat::Tga),
        _ => Err("it is no PNG, JPEG or TGA file".into()),
    }
}

/// Decodes a PNG, JPEG or TGA file; the message says why it cannot.
fn read_image(path: &Path) -> std::result::Result<::image::DynamicImage, String> {
    let bytes = read::bytes(path).map_err(|error| match error {
        // Whoever tells of it names the file.
        Error::Read { source, .. } => source.to_string(),
        error => error.to_string(),
    })?;
    decode_picture(&bytes, path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("tga")))
}

/// Decodes the bytes of a PNG, JPEG or, if it may be that, TGA file; the message says why it cannot.
pub fn decode_picture(bytes: &[u8], may_be_tga: bool) -> std::result::Result<::image::DynamicImage, String> {
    let format = format(bytes, may_be_tga)?;
    let picture = decode(bytes, format)?;
    // Asked behind the decoder, which knows what sizes are too large.
    if format == ImageFormat::Jpeg
        && let Some(why) = jpeg::fault(bytes)
    {
        return Err(why.into());
    }
    if picture.width() == 0 || picture.height() == 0 {
        return Err("the picture has no pixels".into());
    }
    Ok(picture)
}

/// Reads a PNG, JPEG or TGA file; the message says why it cannot.
pub fn read_texture(path: &Path) -> std::result::Result<TextureDesc, String> {
    // Alpha is no colour; 16-bit files lose their lower half.
    let picture = read_image(path)?.to_rgb8();
    let (width, height) = picture.dimensions();
    Ok(TextureDesc {
        name: path.display().to_string(),
        width,
        height,
        texels: picture.pixels().map(|pixel| pixel.0).collect(),
    })
}

/// Reads a PNG, JPEG or TGA file as a mask: its alpha channel if it has one, else its luminance (of a grey picture the grey
/// itself). The numbers are taken as they are, not as sRGB. The message says why it cannot.
pub fn read_mask(path: &Path) -> std::result::Result<MaskDesc, String> {
    let picture = read_image(path)?;
    let (width, height) = (picture.width(), picture.height());
    let texels = if picture.color().has_alpha() {
        picture.to_rgba8().pixels().map(|pixel| pixel.0[3]).collect()
    } else {
        picture.to_luma8().into_raw()
    };
    Ok(MaskDesc { name: path.display().to_string(), width, height, texels })
}
