//! Rows of the scene's tables, eight at a time, as typed columns.
//!
//! A table's row is one cache line of 16 words, read whole and transposed. Columns are taken from it by the offsets of the
//! row's own fields, so that a field is declared once, in its table.

use super::here;
use std::mem::offset_of;

use bytemuck::Pod;

use crate::tables::alpha_masks::AlphaMaskRecord;
use crate::tables::corners::CornerRecord;
use crate::tables::lights::deltas::DeltaRecord;
use crate::tables::lights::table::LightRecord;
use crate::tables::materials::MaterialRecord;
use crate::tables::triangles::TriangleRecord;
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8, Vec3x8};

/// Eight rows of `N` words: lane `i` of word `w` is word `w` of row `indices[i]`.
struct Words<const N: usize>([F32x8; N]);

impl Words<16> {
    #[inline(always)]
    fn gather<T: Pod>(table: &[T], indices: U32x8) -> Words<16> {
        const { assert!(size_of::<T>() == 64) };
        let at = indices.to_array();
        let row = |lane: usize| -> &[[f32; LANES]; 2] { bytemuck::cast_ref(&table[at[lane] as usize]) };
        let rows: [&[[f32; LANES]; 2]; LANES] = std::array::from_fn(row);
        let low = F32x8::transpose(rows.each(
            #[inline(always)]
            |row| F32x8::from_array(row[0]),
        ));
        let high = F32x8::transpose(rows.each(
            #[inline(always)]
            |row| F32x8::from_array(row[1]),
        ));
        let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (low, high);
        Words([a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p])
    }
}

impl<const N: usize> Words<N> {
    /// The numbers at a byte offset of the rows.
    #[inline(always)]
    fn number(&self, offset: usize) -> F32x8 {
        self.0[offset / size_of::<f32>()]
    }
    #[inline(always)]
    fn integer(&self, offset: usize) -> U32x8 {
        self.number(offset).to_bits()
    }
    #[inline(always)]
    fn vector(&self, offset: usize) -> Vec3x8 {
        let first = offset / size_of::<f32>();
        Vec3x8::new(self.0[first], self.0[first + 1], self.0[first + 2])
    }
    #[inline(always)]
    fn three_vectors(&self, offset: usize) -> [Vec3x8; 3] {
        [0, 1, 2].each(
            #[inline(always)]
            |i: usize| self.vector(offset + i * size_of::<[f32; 3]>()),
        )
    }
    /// Three (u, v) pairs.
    #[inline(always)]
    fn three_uvs(&self, offset: usize) -> [F32x8; 6] {
        [0, 1, 2, 3, 4, 5].each(
            #[inline(always)]
            |i: usize| self.number(offset + i * size_of::<f32>()),
        )
    }
}

/// Eight [`TriangleRecord`]s.
pub struct TriangleColumns {
    /// Vertices, scene units.
    pub vertices: [Vec3x8; 3],
    /// Unit geometric normals of the front sides.
    pub normal: Vec3x8,
    /// Material indices.
    pub material: U32x8,
    /// Light indices.
    pub light: U32x8,
    /// What the triangle test adds to offsets.
    pub offset: F32x8,
    /// Least barycentric weights, in half-ulps.
    pub inset: F32x8,
}

impl TriangleColumns {
    /// The rows of `triangles` that `indices` name.
    #[inline(always)]
    pub fn gather(triangles: &[TriangleRecord], indices: U32x8) -> TriangleColumns {
        let words = Words::gather(triangles, indices);
        TriangleColumns {
            vertices: words.three_vectors(offset_of!(TriangleRecord, vertices)),
            normal: words.vector(offset_of!(TriangleRecord, normal)),
            material: words.integer(offset_of!(TriangleRecord, material)),
            light: words.integer(offset_of!(TriangleRecord, light)),
            offset: words.number(offset_of!(TriangleRecord, offset)),
            inset: words.number(offset_of!(TriangleRecord, inset)),
        }
    }
}

/// Eight [`CornerRecord`]s.
pub struct CornerColumns {
    /// Unit normals of the smooth surfaces at the corners.
    pub normals: [Vec3x8; 3],
    /// Texture coordinates: u and v of each corner.
    pub uvs: [F32x8; 6],
    /// [`CornerRecord::smoothness`].
    pub smoothness: U32x8,
}

impl CornerColumns {
    /// The rows of `corners` that `indices` name.
    #[inline(always)]
    pub fn gather(corners: &[CornerRecord], indices: U32x8) -> CornerColumns {
        let words = Words::gather(corners, indices);
        CornerColumns {
            normals: words.three_vectors(offset_of!(CornerRecord, normals)),
            uvs: words.three_uvs(offset_of!(CornerRecord, uvs)),
            smoothness: words.integer(offset_of!(CornerRecord, smoothness)),
        }
    }
}

/// Eight [`LightRecord`]s.
pub struct LightColumns {
    /// Vertices, scene units.
    pub vertices: [Vec3x8; 3],
    /// Unit normals of the sides that emit.
    pub normal: Vec3x8,
    /// Emitted radiance.
    pub radiance: Vec3x8,
    /// Densities of points drawn uniformly, per unit area; the sign says that both sides emit.
    signed_pdf_area: F32x8,
}

impl LightColumns {
    /// The rows of `lights` that `indices` name.
    #[inline(always)]
    pub fn gather(lights: &[LightRecord], indices: U32x8) -> LightColumns {
        let words = Words::gather(lights, indices);
        LightColumns {
            vertices: words.three_vectors(offset_of!(LightRecord, vertices)),
            normal: words.vector(offset_of!(LightRecord, normal)),
            radiance: words.vector(offset_of!(LightRecord, radiance)),
            signed_pdf_area: words.number(offset_of!(LightRecord, signed_pdf_area)),
        }
    }
    /// Densities of points drawn uniformly, per unit area.
    #[inline(always)]
    pub fn pdf_area(&self) -> F32x8 {
        self.signed_pdf_area.abs()
    }
    /// Lights that emit on both sides.
    #[inline(always)]
    pub fn two_sided(&self) -> Mask8 {
        self.signed_pdf_area.lt(F32x8::ZERO)
    }
}

/// Eight [`DeltaRecord`]s.
pub struct DeltaColumns {
    /// Positions, scene units; of directional lights unit directions towards them.
    pub position: Vec3x8,
    /// 1 of directional lights, else 0.
    pub distant: U32x8,
    /// Intensities along the axes, or irradiances.
    pub strength: Vec3x8,
    /// Versines of the cones' edges.
    pub edge: F32x8,
    /// Unit axes of the cones.
    pub axis: Vec3x8,
    /// One over the versines between edges and where lights are whole.
    pub falloff: F32x8,
}

impl DeltaColumns {
    /// The rows of `lights` that `indices` name.
    #[inline(always)]
    pub fn gather(lights: &[DeltaRecord], indices: U32x8) -> DeltaColumns {
        let words = Words::gather(lights, indices);
        DeltaColumns {
            position: words.vector(offset_of!(DeltaRecord, position)),
            distant: words.integer(offset_of!(DeltaRecord, distant)),
            strength: words.vector(offset_of!(DeltaRecord, strength)),
            edge: words.number(offset_of!(DeltaRecord, edge)),
            axis: words.vector(offset_of!(DeltaRecord, axis)),
            falloff: words.number(offset_of!(DeltaRecord, falloff)),
        }
    }
}

/// Eight [`MaterialRecord`]s.
pub struct MaterialColumns {
    /// Albedo, reflectance or transmittance.
    pub color: Vec3x8,
    /// GGX widths.
    pub alpha: F32x8,
    /// Real parts of conductors' indices of refraction.
    pub eta: Vec3x8,
    /// Indices of refraction of coats and glass.
    pub ior: F32x8,
    /// Imaginary parts of conductors' indices of refraction.
    pub k: Vec3x8,
    /// What plastics' bases are expected to reflect; of principled materials the factors from colours to albedos of bases.
    pub base_weight: F32x8,
    /// How much of principled materials is metal.
    pub metallic: F32x8,
    /// Conductors with a complex index.
    pub complex_ior: Mask8,
}

impl MaterialColumns {
    /// The rows of `materials` that `indices` name.
    #[inline(always)]
    pub fn gather(materials: &[MaterialRecord], indices: U32x8) -> MaterialColumns {
        let words = Words::gather(materials, indices);
        MaterialColumns {
            color: words.vector(offset_of!(MaterialRecord, color)),
            alpha: words.number(offset_of!(MaterialRecord, alpha)),
            eta: words.vector(offset_of!(MaterialRecord, eta)),
            ior: words.number(offset_of!(MaterialRecord, ior)),
            k: words.vector(offset_of!(MaterialRecord, k)),
            base_weight: words.number(offset_of!(MaterialRecord, base_weight)),
            metallic: words.number(offset_of!(MaterialRecord, metallic)),
            complex_ior: words.integer(offset_of!(MaterialRecord, complex_ior)).eq(U32x8::splat(1)),
        }
    }

    /// The colours alone, for kinds that need no more.
    #[inline(always)]
    pub fn gather_colors(materials: &[MaterialRecord], indices: U32x8) -> Vec3x8 {
        let at = indices.to_array();
        let rows: [[f32; 3]; LANES] = std::array::from_fn(|lane| materials[at[lane] as usize].color);
        let column = |c: usize| F32x8::from_array(std::array::from_fn(|lane| rows[lane][c]));
        Vec3x8::new(column(0), column(1), column(2))
    }

    /// The textures alone.
    #[inline(always)]
    pub fn gather_textures(materials: &[MaterialRecord], indices: U32x8) -> U32x8 {
        U32x8::from_array(indices.to_array().map(|material| materials[material as usize].texture))
    }
}

/// Eight [`AlphaMaskRecord`]s.
pub struct AlphaMaskColumns {
    /// Mask coordinates: u and v of each corner.
    pub uvs: [F32x8; 6],
    /// Mask indices.
    pub mask: U32x8,
}

impl AlphaMaskColumns {
    /// The rows of `records` that `indices` name.
    #[inline(always)]
    pub fn gather(records: &[AlphaMaskRecord], indices: U32x8) -> AlphaMaskColumns {
        let row = |index: u32| F32x8::from_array(bytemuck::cast::<AlphaMaskRecord, _>(records[index as usize]));
        let words = Words(F32x8::transpose(indices.to_array().each(
            #[inline(always)]
            |index| row(index),
        )));
        AlphaMaskColumns {
            uvs: words.three_uvs(offset_of!(AlphaMaskRecord, uvs)),
            mask: words.integer(offset_of!(AlphaMaskRecord, mask)),
        }
    }
}
