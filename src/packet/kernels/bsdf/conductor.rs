//! Metals with GGX microfacets.

use super::here;
use super::interface::{Bsdf, Sampled, Scattered};
use super::microfacet::{
    fresnel_conductor, ggx_reflection, half_vector, reflect_about, sample_visible_normal, smith_a, steep_enough,
};
use crate::sampler::DIRECTION_WORDS;
use crate::sampler::draws::{BsdfDraws, LightDraws};
use crate::tables::materials::{MaterialKind, MaterialRecord};
use here::kernels::records::MaterialColumns;
use here::lanes::{F32x8, U32x8, Vec3x8};
use here::numbers::draws::PathNumbers8;

/// Eight metals.
pub struct Conductor(MaterialColumns);

impl Bsdf for Conductor {
    const KIND: MaterialKind = MaterialKind::Conductor;
    const FACES_FORWARD: bool = true;

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
        Conductor(MaterialColumns::gather(materials, material))
    }

    #[inline(always)]
    fn color(&mut self) -> &mut Vec3x8 {
        &mut self.0.color
    }

    #[inline(always)]
    fn evaluate(&self, wo: Vec3x8, wi: Vec3x8) -> Scattered {
        let material = &self.0;
        let half = half_vector(wo, wi);
        let (f, pdf_dir) = ggx_reflection(material.alpha, wo, wi, half);
        let f_cosine = conductor_reflectance(material, wo.dot(half)).scale(f);
        let (valid, zero) = (steep_enough(wo, wi), F32x8::ZERO);
        Scattered {
            f_cosine: valid.select_vec3(f_cosine, Vec3x8::new(zero, zero, zero)),
            pdf_dir: valid.select(pdf_dir, zero),
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3x8, draws: &BsdfDraws<F32x8>) -> Sampled {
        let material = &self.0;
        let alpha = material.alpha;
        let half = sample_visible_normal(alpha, wo, draws.direction);
        let wi = reflect_about(wo, half);
        let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
        let weight = conductor_reflectance(material, wo.dot(half)).scale((F32x8::ONE + o) / (o + i));
        let (_, pdf_dir) = ggx_reflection(alpha, wo, wi, half);
        Sampled { valid: steep_enough(wo, wi), wi, weight, pdf_dir }
    }
}

#[inline(always)]
fn conductor_reflectance(material: &MaterialColumns, cosine: F32x8) -> Vec3x8 {
    if !material.complex_ior.any() {
        return material.color;
    }
    material.complex_ior.select_vec3(fresnel_conductor(cosine, material.eta, material.k), material.color)
}
