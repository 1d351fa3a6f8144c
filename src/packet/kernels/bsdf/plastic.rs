//! Diffuse bases under GGX coats.

use super::here;
use super::interface::{Bsdf, Sampled, Scattered};
use super::microfacet::{fresnel_dielectric, ggx_reflection, half_vector, sample_coat_or_base, steep_enough};
use crate::sampler::draws::BsdfDraws;
use crate::tables::materials::{MaterialKind, MaterialRecord};
use here::kernels::records::MaterialColumns;
use here::kernels::warp::cosine_hemisphere_pdf_dir;
use here::lanes::{F32x8, U32x8, Vec3x8};

/// Eight coated surfaces.
pub struct Plastic(MaterialColumns);

impl Bsdf for Plastic {
    const KIND: MaterialKind = MaterialKind::Plastic;
    const FACES_FORWARD: bool = true;

    #[inline(always)]
    fn load(materials: &[MaterialRecord], material: U32x8) -> Self {
        Plastic(MaterialColumns::gather(materials, material))
    }

    #[inline(always)]
    fn color(&mut self) -> &mut Vec3x8 {
        &mut self.0.color
    }

    #[inline(always)]
    fn evaluate(&self, wo: Vec3x8, wi: Vec3x8) -> Scattered {
        let material = &self.0;
        let one = F32x8::ONE;
        let half = half_vector(wo, wi);
        let (f, pdf_coat) = ggx_reflection(material.alpha, wo, wi, half);
        let (coat, _) = fresnel_dielectric(wo.dot(half), material.ior);
        let (fresnel_o, _) = fresnel_dielectric(wo.z, material.ior);
        let (fresnel_i, _) = fresnel_dielectric(wi.z, material.ior);
        let pdf_base = cosine_hemisphere_pdf_dir(wi.z);
        let through = (one - fresnel_o) * (one - fresnel_i);
        let p = coat_probability(material, fresnel_o);
        let gloss = coat * f;
        let f_cosine = material.color.scale(through * pdf_base) + Vec3x8::new(gloss, gloss, gloss);
        let (valid, zero) = (steep_enough(wo, wi), F32x8::ZERO);
        Scattered {
            f_cosine: valid.select_vec3(f_cosine, Vec3x8::new(zero, zero, zero)),
            pdf_dir: valid.select(p * pdf_coat + (one - p) * pdf_base, zero),
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3x8, draws: &BsdfDraws<F32x8>) -> Sampled {
        let material = &self.0;
        let (fresnel_o, _) = fresnel_dielectric(wo.z, material.ior);
        let p = coat_probability(material, fresnel_o);
        let wi = sample_coat_or_base(p, material.alpha, wo, draws);
        let Scattered { f_cosine, pdf_dir } = self.evaluate(wo, wi);
        let weight = f_cosine.scale(F32x8::ONE / pdf_dir);
        Sampled { valid: steep_enough(wo, wi), wi, weight, pdf_dir }
    }
}

#[inline(always)]
fn coat_probability(material: &MaterialColumns, fresnel: F32x8) -> F32x8 {
    let base = (F32x8::ONE - fresnel) * material.base_weight;
    fresnel / (fresnel + base)
}
