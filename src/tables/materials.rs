//! The material table: one record a material, one cache line, sorted by kind.

use bytemuck::{Pod, Zeroable};

use crate::fault::{Fault, planted};
use crate::scene::desc::{MaterialDesc, Scattering};
use crate::tables::plastic_energy;
use crate::tables::textures::NO_TEXTURE;

/// How a material scatters; the order in which materials are sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum MaterialKind {
    /// Scatters nothing: a path that arrives ends.
    Black = 0,
    /// Lambertian.
    Diffuse = 1,
    /// Perfect mirror.
    Mirror = 2,
    /// Metal with a GGX distribution of microfacets.
    Conductor = 3,
    /// Smooth glass.
    Dielectric = 4,
    /// Diffuse base under a GGX coat.
    Plastic = 5,
    /// Metal and plastic in any proportion: the metallic-roughness model of glTF 2.0.
    Principled = 6,
}

/// How many kinds there are.
pub const KINDS: usize = 7;

/// What the directions that a kind scatters to are drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobes {
    /// Nothing is scattered.
    None,
    /// A density: light sampling works.
    Density,
    /// Single directions: light sampling cannot work.
    Delta,
}

/// What is said once about a kind; the engines have a file a kind besides.
pub struct KindRow {
    /// Which.
    pub kind: MaterialKind,
    /// The word in scene files, plans and reports.
    pub name: &'static str,
    /// The name of the packet engine's stage.
    pub stage: &'static str,
    /// What directions are drawn from.
    pub lobes: Lobes,
    /// Densities are cosines over pi, so that either tells the other.
    pub pdf_is_cosine: bool,
    /// Whether a texture can multiply its colour.
    pub textured: bool,
    /// What the plan says of the stage.
    pub variant: &'static str,
    /// What the plan says where no triangle has the kind; empty: nothing.
    pub absent: &'static str,
}

/// The kinds, in the order of [`MaterialKind`].
pub const TABLE: [KindRow; KINDS] = {
    use Lobes::*;
    use MaterialKind::*;
    const fn row(kind: MaterialKind, name: &'static str, stage: &'static str, lobes: Lobes) -> KindRow {
        KindRow { kind, name, stage, lobes, pdf_is_cosine: false, textured: false, variant: "", absent: "" }
    }
    [
        row(Black, "black", "shade_black", None),
        KindRow { pdf_is_cosine: true, textured: true, ..row(Diffuse, "diffuse", "shade_diffuse", Density) },
        KindRow {
            variant: "smooth",
            absent: "no triangle is a mirror",
            ..row(Mirror, "mirror", "shade_mirror", Delta)
        },
        KindRow {
            variant: "GGX",
            absent: "no triangle is a rough metal",
            ..row(Conductor, "conductor", "shade_conductor", Density)
        },
        KindRow {
            variant: "smooth",
            absent: "no triangle is glass",
            ..row(Dielectric, "dielectric", "shade_dielectric", Delta)
        },
        KindRow {
            textured: true,
            variant: "GGX coat",
            absent: "no triangle is coated",
            ..row(Plastic, "plastic", "shade_plastic", Density)
        },
        KindRow {
            textured: true,
            variant: "GGX metal and coat",
            absent: "no triangle is principled",
            ..row(Principled, "principled", "shade_principled", Density)
        },
    ]
};

impl MaterialKind {
    /// Every kind, in order.
    pub const ALL: [MaterialKind; KINDS] = {
        let mut all = [MaterialKind::Black; KINDS];
        let mut i = 0;
        while i < KINDS {
            all[i] = TABLE[i].kind;
            assert!(all[i] as usize == i, "rows stand in the order of the kinds");
            i += 1;
        }
        all
    };

    /// The kind's row.
    pub const fn row(self) -> &'static KindRow {
        &TABLE[self as usize]
    }

    /// The word used in plans and reports.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Whether its directions are the only ones possible, so that light sampling cannot work.
    pub fn is_delta(self) -> bool {
        self.row().lobes == Lobes::Delta
    }

    /// Whether it scatters anything.
    pub fn scatters(self) -> bool {
        self.row().lobes != Lobes::None
    }
}

/// One value for each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerKind<T>(pub [T; KINDS]);

impl<T> PerKind<T> {
    /// From a function of the kind.
    pub fn new(of: impl FnMut(MaterialKind) -> T) -> PerKind<T> {
        PerKind(MaterialKind::ALL.map(of))
    }
}

impl<T> std::ops::Index<MaterialKind> for PerKind<T> {
    type Output = T;
    #[inline(always)]
    fn index(&self, kind: MaterialKind) -> &T {
        &self.0[kind as usize]
    }
}

impl<T> std::ops::IndexMut<MaterialKind> for PerKind<T> {
    #[inline(always)]
    fn index_mut(&mut self, kind: MaterialKind) -> &mut T {
        &mut self.0[kind as usize]
    }
}

/// Serialised as a map from the names of the kinds that scatter.
impl<T: serde::Serialize> serde::Serialize for PerKind<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer
            .collect_map(TABLE.iter().zip(&self.0).filter(|(row, _)| row.kind.scatters()).map(|(row, v)| (row.name, v)))
    }
}

/// Below this width a GGX lobe is treated as the mirror it is: f32 directions do not resolve it.
pub const MIN_ALPHA: f64 = 1e-4;

/// One material, as shading reads it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct MaterialRecord {
    /// Albedo (diffuse; plastic: times the energy constant), reflectance (mirror, conductor), transmittance (dielectric), base
    /// colour (principled).
    pub color: [f32; 3],
    /// GGX width.
    pub alpha: f32,
    /// Real part of a conductor's index of refraction.
    pub eta: [f32; 3],
    /// Index of refraction of a dielectric or a coat.
    pub ior: f32,
    /// Imaginary part of a conductor's index of refraction.
    pub k: [f32; 3],
    /// What a plastic's base is expected to reflect of what reaches it: its largest albedo component. The factor from a
    /// principled material's base colour to the albedo of its base: what is not metal, times the energy constant.
    pub base_weight: f32,
    /// 1 if a conductor has `eta` and `k`, 0 if its reflectance is `color`.
    pub complex_ior: u32,
    /// The [`MaterialKind`].
    kind: u32,
    /// What multiplies `color`: index of a texture, or [`NO_TEXTURE`].
    pub texture: u32,
    /// How much of a principled material is metal, from 0 to 1.
    pub metallic: f32,
}

impl MaterialRecord {
    /// The record of a description (already validated).
    pub fn new(desc: &MaterialDesc) -> MaterialRecord {
        let kept = if planted(Fault::LossySurfaces) { 0.99 } else { 1.0 };
        let f32s = |v: [f64; 3]| v.map(|c| (c * kept) as f32);
        let mut record = MaterialRecord { ior: 1.5, alpha: 1.0, texture: NO_TEXTURE, ..MaterialRecord::zeroed() };
        let kind = match desc.scattering {
            Scattering::Diffuse { albedo } => {
                record.color = f32s(albedo.map(|c| if planted(Fault::BrightAlbedo) { 1.001 * c } else { c }));
                MaterialKind::Diffuse
            }
            Scattering::Mirror { reflectance } => {
                record.color = f32s(reflectance);
                MaterialKind::Mirror
            }
            Scattering::Conductor { alpha, reflectance, complex_ior } => {
                record.color = f32s(reflectance);
                record.alpha = alpha.max(MIN_ALPHA) as f32;
                if let Some((eta, k)) = complex_ior {
                    (record.eta, record.k, record.complex_ior, record.color) = (f32s(eta), f32s(k), 1, [1.0; 3]);
                }
                // A mirror with a Fresnel term has no kind of its own: it stays the narrowest lobe.
                if alpha < MIN_ALPHA && complex_ior.is_none() { MaterialKind::Mirror } else { MaterialKind::Conductor }
            }
            Scattering::Dielectric { ior, transmittance } => {
                record.color = f32s(transmittance);
                record.ior = ior as f32;
                MaterialKind::Dielectric
            }
            Scattering::Plastic { albedo, ior, alpha } => {
                let scale = record.set_coat(ior, alpha);
                record.color = albedo.map(|c| (c * scale) as f32);
                // Above 0, so that a probability in proportion to it always exists.
                record.base_weight = albedo.into_iter().fold(1e-4, f64::max) as f32;
                MaterialKind::Plastic
            }
            Scattering::Principled { base_color, metallic, roughness, ior } => {
                let scale = record.set_coat(ior, roughness * roughness);
                record.color = f32s(base_color);
                record.metallic = metallic as f32;
                record.base_weight = ((1.0 - f64::from(record.metallic)) * scale) as f32;
                MaterialKind::Principled
            }
        };
        if let (true, Some(used)) = (kind.row().textured, desc.texture) {
            record.texture = used.texture;
        }
        let black = matches!(kind, MaterialKind::Diffuse | MaterialKind::Mirror) && record.color == [0.0; 3];
        record.kind = if black { MaterialKind::Black } else { kind } as u32;
        record
    }

    /// Takes the index and the width of a coat; the factor on the albedo of the base under it.
    fn set_coat(&mut self, ior: f64, alpha: f64) -> f64 {
        self.ior = ior as f32;
        self.alpha = alpha.max(MIN_ALPHA) as f32;
        // Of the numbers that shading reads: next to 1 an index loses digits in f32.
        let scale = plastic_energy::base_scale(f64::from(self.ior), f64::from(self.alpha));
        scale * if planted(Fault::BrightBase) { 1.02 } else { 1.0 }
    }

    /// How it scatters.
    pub fn kind(&self) -> MaterialKind {
        MaterialKind::ALL[self.kind as usize]
    }

    /// Whether a conductor's reflectance comes from a complex index of refraction.
    pub fn has_complex_ior(&self) -> bool {
        self.complex_ior != 0
    }
}
