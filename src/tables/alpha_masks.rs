//! Cut-outs: masks, and the table that says of which triangles only a part is there.
//!
//! A point of a cut-out triangle is there if its mask is at least one half (an alpha test; what is soft in the mask does
//! not let a part of the light through). Rays pass points that are not there as if the triangle did not exist.

use crate::scene::desc::SceneDesc;
use crate::scene::flatten::Geometry;
use crate::tables::textures::placed;
use bytemuck::{Pod, Zeroable};

/// [`AlphaMaskTable::record_of`] of a triangle that is whole.
pub const WHOLE: u32 = u32::MAX;

/// Masks of at least this are opaque; half-way between the 8-bit numbers that lie around one half.
pub const THRESHOLD: f32 = 127.5;

/// What the alpha test needs of one cut-out triangle.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct AlphaMaskRecord {
    /// Mask coordinates of the corners, with the mask's scale and offset in them.
    pub uvs: [[f32; 2]; 3],
    /// The mask's number.
    pub mask: u32,
    spare: u32,
}

/// All cut-out triangles of a scene; empty if there is none.
#[derive(Clone, Debug, Default)]
pub struct AlphaMaskTable {
    /// Per triangle id, its place in [`AlphaMaskTable::records`], or [`WHOLE`].
    pub record_of: Vec<u32>,
    /// The cut-out triangles.
    pub records: Vec<AlphaMaskRecord>,
    /// Columns of each mask.
    pub width: Vec<u32>,
    /// Rows of each mask.
    pub height: Vec<u32>,
    /// Where each mask's texels begin.
    pub first: Vec<u32>,
    /// Opacities, row by row from the bottom (v = 0).
    pub texels: Vec<u8>,
}

impl AlphaMaskTable {
    /// The table of a scene.
    pub fn new(desc: &SceneDesc, geometry: &Geometry<'_>) -> AlphaMaskTable {
        let mut table = AlphaMaskTable::default();
        if !geometry.triangles.iter().any(|t| desc.materials[t.material as usize].alpha_mask.is_some()) {
            return table;
        }
        for mask in &desc.masks {
            table.width.push(mask.width);
            table.height.push(mask.height);
            table.first.push(table.texels.len() as u32);
            table.texels.extend(mask.texels.chunks(mask.width as usize).rev().flatten());
        }
        for (id, triangle) in geometry.triangles.iter().enumerate() {
            table.record_of.push(match desc.materials[triangle.material as usize].alpha_mask {
                None => WHOLE,
                Some(used) => {
                    let uvs = geometry.corners.get(id).map_or([[0.0; 2]; 3], |corner| corner.uvs);
                    table.records.push(AlphaMaskRecord { uvs: placed(uvs, Some(used)), mask: used.texture, spare: 0 });
                    table.records.len() as u32 - 1
                }
            });
        }
        table
    }

    /// Whether every triangle is whole.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Whether a part of triangle `id` may be missing.
    pub fn cuts(&self, id: u32) -> bool {
        self.record_of.get(id as usize).is_some_and(|&record| record != WHOLE)
    }

    /// Its size in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.record_of[..]) + size_of_val(&self.records[..]) + self.texels.len()
    }
}
