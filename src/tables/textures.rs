//! Textures: the table both engines look texels up in.
//!
//! Texels stay the 8-bit sRGB numbers of their files, four bytes each, beside one table of the 256 linear values: a third
//! of the memory of linear floats, and the decoding is exact by construction.

use crate::color::linear_from_srgb;
use crate::scene::desc::{TextureDesc, TextureUse};

/// The texture of what has none.
pub const NO_TEXTURE: u32 = u32::MAX;

/// All textures of a scene, one column a field; the index is the texture's number.
#[derive(Clone, Debug)]
pub struct TextureTable {
    /// Columns of each texture.
    pub width: Vec<u32>,
    /// Rows of each texture.
    pub height: Vec<u32>,
    /// Where each texture's texels begin.
    pub first: Vec<u32>,
    /// Red in the low byte, then green, then blue; row by row from the bottom (v = 0), so that v needs no turning.
    pub texels: Vec<u32>,
    /// The linear value of every sRGB number.
    pub linear: Vec<f32>,
}

impl TextureTable {
    /// The table of the textures `descs`.
    pub fn new(descs: &[TextureDesc]) -> TextureTable {
        let mut table = TextureTable {
            width: descs.iter().map(|d| d.width).collect(),
            height: descs.iter().map(|d| d.height).collect(),
            first: Vec::new(),
            texels: Vec::new(),
            linear: (0..256).map(|i| linear_from_srgb(i as f64 / 255.0) as f32).collect(),
        };
        for desc in descs {
            table.first.push(table.texels.len() as u32);
            let pack = |&[r, g, b]: &[u8; 3]| u32::from_le_bytes([r, g, b, 0]);
            let rows = desc.texels.chunks(desc.width as usize).rev();
            table.texels.extend(rows.flat_map(|row| row.iter().map(pack)));
        }
        table
    }

    /// The mean linear value of a texture over its area and channels.
    pub fn mean(&self, texture: u32) -> f64 {
        let texture = texture as usize;
        let count = self.width[texture] as usize * self.height[texture] as usize;
        let texels = &self.texels[self.first[texture] as usize..][..count];
        let value = |texel: &u32| -> f64 {
            let [r, g, b, _] = texel.to_le_bytes();
            [r, g, b].iter().map(|&c| f64::from(self.linear[c as usize])).sum()
        };
        texels.iter().map(value).sum::<f64>() / (3 * count) as f64
    }

    /// Its size in bytes, 0 without textures.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.texels[..])
    }
}

/// Texture coordinates under a texture's scale and offset.
pub fn placed(uvs: [[f32; 2]; 3], texture: Option<TextureUse>) -> [[f32; 2]; 3] {
    let Some(TextureUse { scale, offset, .. }) = texture else { return uvs };
    uvs.map(|uv| std::array::from_fn(|i| (f64::from(uv[i]) * scale[i] + offset[i]) as f32))
}
