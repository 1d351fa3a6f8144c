//! Lambertian surfaces.

use super::here;
use super::interface::{Bsdf, Sampled, Scattered};
use crate::fault::{Fault, planted};
use crate::sampler::DIRECTION_WORDS;
use crate::sampler::draws::{BsdfDraws, LightDraws};
use crate::tables::materials::{MaterialKind, MaterialRecord};
use here::kernels::records::MaterialColumns;
use here::kernels::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere};
use here::lanes::{F32x8, Mask8, U32x8, Vec3x8};
use here::numbers::draws::PathNumbers8;

/// Eight Lambertian surfaces: their albedos.
pub struct Diffuse(Vec3x8);

impl Bsdf for Diffuse {
    const KIND: MaterialKind = MaterialKind::Diffuse;
    const FACES_FORWARD: bool = false;

    #[inline(always)]
    fn draws(numbers: &PathNumbers8, event: u32) -> BsdfDraws<F32x8> {
        numbers.bsdf::<DIRECTION_WORDS>(event)
    }
    #[inline(always)]
    fn draws_with_light<const LIGHT: u8>(
        numbers: &PathNumbers8,
        event: u32,
    ) -> (LightDraws<U32x8, F32x8>, BsdfDraws<F32x8>) {
        numbers.light_and_bsdf::<LIGHT, DIRECTION_WORDS>(event)
    }

    #[inline(always)]
    fn load(materials: &[MaterialRecord], material: U32x8) -> Self {
        Diffuse(MaterialColumns::gather_colors(materials, material))
    }

    #[inline(always)]
    fn color(&mut self) -> &mut Vec3x8 {
        &mut self.0
    }

    /// Albedo/pi times cosine; cosine/pi is also the density of drawing the direction.
    #[inline(always)]
    fn evaluate(&self, _: Vec3x8, wi: Vec3x8) -> Scattered {
        let pdf_dir = cosine_hemisphere_pdf_dir(if planted(Fault::MissingCosine) { F32x8::ONE } else { wi.z });
        Scattered { f_cosine: self.0.scale(pdf_dir), pdf_dir }
    }

    #[inline(always)]
    fn sample(&self, _: Vec3x8, draws: &BsdfDraws<F32x8>) -> Sampled {
        let wi = sample_cosine_hemisphere(draws.direction);
        Sampled { valid: Mask8::ALL, wi, weight: self.0, pdf_dir: cosine_hemisphere_pdf_dir(wi.z) }
    }
}
