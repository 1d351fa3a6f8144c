//! Pictures of a file, and how texture coordinates are placed on them.

use super::buffers::bytes_at;
use super::file::File;
use crate::import::pictures::decode_picture;
use ::image::DynamicImage;
use gltf::json::texture::{Info, Texture, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Image, Index};

/// How a material's texture coordinates are made of a mesh's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Which of the mesh's sets.
    pub set: u32,
    /// The rows of the affine map to the coordinates of the texture, v down (KHR_texture_transform).
    pub rows: [[f64; 3]; 2],
    /// Beyond [0, 1] the texture does not repeat as it is.
    pub ends: bool,
}

impl Default for Placement {
    fn default() -> Self {
        Placement { set: 0, rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], ends: false }
    }
}

impl Placement {
    /// What `info` says of texture coordinates.
    pub fn new(file: &File<'_>, info: &Info) -> Placement {
        let mut placement = Placement { set: info.tex_coord, ends: ends(file, info.index), ..Placement::default() };
        let Some(transform) = info.extensions.as_ref().and_then(|all| all.texture_transform.as_ref()) else {
            return placement;
        };
        let [sx, sy] = transform.scale.0.map(f64::from);
        let [ox, oy] = transform.offset.0.map(f64::from);
        // Counter-clockwise as the texture is seen, with v down.
        let (s, c) = libm::sincos(transform.rotation.0.into());
        placement.rows = [[c * sx, s * sy, ox], [-s * sx, c * sy, oy]];
        placement.set = transform.tex_coord.unwrap_or(info.tex_coord);
        placement
    }

    /// Texture coordinates as octray has them: v up.
    pub fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [x, y] = self.rows.map(|row| row[0] * f64::from(u) + row[1] * f64::from(v) + row[2]);
        [x as f32, (1.0 - y) as f32]
    }
}

/// Whether a texture's sampler does anything but repeat it.
fn ends(file: &File<'_>, texture: Index<Texture>) -> bool {
    let sampler = file.root.textures.get(texture.value()).and_then(|texture| texture.sampler);
    let sampler = sampler.and_then(|sampler| file.root.samplers.get(sampler.value()));
    let repeats = |mode| matches!(mode, Checked::Valid(WrappingMode::Repeat));
    sampler.is_some_and(|sampler| !(repeats(sampler.wrap_s) && repeats(sampler.wrap_t)))
}

/// The number of the image that a texture shows; the message says why it shows none.
pub fn image_of(file: &File<'_>, texture: Index<Texture>) -> std::result::Result<usize, String> {
    let texture = file.root.textures.get(texture.value()).ok_or("there is no such texture")?;
    let source = texture.source.value();
    // Where an extension has the image, the crate has the largest number instead.
    match source < file.root.images.len() {
        true => Ok(source),
        false => Err("its image is of a format that only an extension knows: PNG and JPEG are read".into()),
    }
}

/// Decodes an image; the message says why it cannot.
pub fn decode(file: &File<'_>, number: usize) -> std::result::Result<DynamicImage, String> {
    let Image { buffer_view, uri, .. } = &file.root.images[number];
    match (buffer_view, uri) {
        (Some(view), _) => decode_picture(file.buffers.view(&file.root, *view)?.0, false),
        (None, Some(uri)) => decode_picture(&bytes_at(file.path, uri)?, false),
        (None, None) => Err("it names no data".into()),
    }
}
