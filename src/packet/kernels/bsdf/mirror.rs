//! Mirrors: the one possible direction.

use super::here;
use super::interface::Specular;
use crate::sampler::ROULETTE_WORD;
use crate::sampler::draws::BsdfDraws;
use crate::tables::materials::{MaterialKind, MaterialRecord};
use here::kernels::records::MaterialColumns;
use here::kernels::surface::SurfacePoints;
use here::lanes::{F32x8, Mask8, U32x8, Vec3x8};
use here::numbers::draws::PathNumbers8;

/// Eight mirrors: their reflectances.
pub struct Mirror(Vec3x8);

impl Specular for Mirror {
    const KIND: MaterialKind = MaterialKind::Mirror;

    #[inline(always)]
    fn draws(numbers: &PathNumbers8, event: u32) -> BsdfDraws<F32x8> {
        numbers.bsdf::<ROULETTE_WORD>(event)
    }

    #[inline(always)]
    fn load(materials: &[MaterialRecord], material: U32x8) -> Self {
        Mirror(MaterialColumns::gather_colors(materials, material))
    }

    #[inline(always)]
    fn orient(points: &mut SurfacePoints, direction: Vec3x8) -> Vec3x8 {
        points.face_forward(-direction);
        direction
    }

    #[inline(always)]
    fn sample(&self, incoming: Vec3x8, normal: Vec3x8, _: Mask8, _: F32x8) -> (Vec3x8, Vec3x8, F32x8) {
        (reflect(incoming, normal), self.0, self.0.max_element())
    }
}

/// The mirror images of directions towards surfaces.
#[inline(always)]
pub fn reflect(incoming: Vec3x8, normal: Vec3x8) -> Vec3x8 {
    incoming - normal.scale(F32x8::splat(2.0) * incoming.dot(normal))
}
