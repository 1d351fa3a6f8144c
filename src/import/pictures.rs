//! Picture files, PNG and JPEG: each read once, and only if it is whole.

use crate::import::jpeg;
use crate::scene::desc::{MaskDesc, TextureDesc};
use ::image::{ImageFormat, ImageReader};
use std::collections::HashMap;
use std::io::{Cursor, Read, Seek};
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

/// Decodes a PNG or JPEG file; the message says why it cannot.
fn read_image(path: &Path) -> std::result::Result<::image::DynamicImage, String> {
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format).map_err(|e| e.to_string())?;
    let picture = match reader.format() {
        Some(ImageFormat::Jpeg) => {
            let (mut file, mut bytes) = (reader.into_inner(), Vec::new());
            file.rewind().and_then(|()| file.read_to_end(&mut bytes)).map_err(|e| e.to_string())?;
            let picture = ImageReader::with_format(Cursor::new(&bytes), ImageFormat::Jpeg).decode();
            // Asked behind the decoder, which knows what sizes are too large.
            picture
                .map_err(|e| e.to_string())
                .and_then(|picture| jpeg::fault(&bytes).map_or(Ok(picture), |why| Err(why.into())))?
        }
        _ => reader.decode().map_err(|e| e.to_string())?,
    };
    if picture.width() == 0 || picture.height() == 0 {
        return Err("the picture has no pixels".into());
    }
    Ok(picture)
}

/// Reads a PNG or JPEG file; the message says why it cannot.
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

/// Reads a PNG or JPEG file as a mask: its alpha channel if it has one, else its luminance (of a grey picture the grey
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
