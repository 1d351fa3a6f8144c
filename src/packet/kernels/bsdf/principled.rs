//! The metallic-roughness model of glTF 2.0: metals and plastics, mixed.

use super::here;
use super::interface::{Bsdf, Sampled, Scattered};
use super::microfacet::{fresnel_dielectric, ggx_reflection, half_vector, sample_coat_or_base, schlick, steep_enough};
use crate::sampler::draws::BsdfDraws;
use crate::tables::materials::{MaterialKind, MaterialRecord};
use here::kernels::records::MaterialColumns;
use here::kernels::warp::cosine_hemisphere_pdf_dir;
use here::lanes::{F32x8, U32x8, Vec3x8};

/// Eight principled surfaces.
pub struct Principled(MaterialColumns);

impl Bsdf for Principled {
    const KIND: MaterialKind = MaterialKind::Principled;
    const FACES_FORWARD: bool = true;

    #[inline(always)]
    fn load(materials: &[MaterialRecord], material: U32x8) -> Self {
        Principled(MaterialColumns::gather(materials, material))
    }

    #[inline(always)]
    fn color(&mut self) -> &mut Vec3x8 {
        &mut self.0.color
    }

    #[inline(always)]
    fn evaluate(&self, wo: Vec3x8, wi: Vec3x8) -> Scattered {
        let MaterialColumns { color, alpha, ior, base_weight, metallic, .. } = self.0;
        let (one, ones) = (F32x8::ONE, Vec3x8::splat([1.0; 3]));
        let half = half_vector(wo, wi);
        let (f, pdf_gloss) = ggx_reflection(alpha, wo, wi, half);
        let cosine = wo.dot(half);
        let metal = color + (ones - color).scale(schlick(cosine));
        let (coat, _) = fresnel_dielectric(cosine, ior);
        let coat = coat * (one - metallic);
        let gloss = metal.scale(metallic) + Vec3x8::new(coat, coat, coat);
        let (fresnel_o, _) = fresnel_dielectric(wo.z, ior);
        let (fresnel_i, _) = fresnel_dielectric(wi.z, ior);
        let through = (one - fresnel_o) * (one - fresnel_i);
        let pdf_base = cosine_hemisphere_pdf_dir(wi.z);
        let base = color.scale(base_weight * through * pdf_base);
        let p = gloss_probability(&self.0, wo.z, fresnel_o);
        let (valid, zero) = (steep_enough(wo, wi), F32x8::ZERO);
        Scattered {
            f_cosine: valid.select_vec3(base + gloss.scale(f), Vec3x8::new(zero, zero, zero)),
            pdf_dir: valid.select(p * pdf_gloss + (one - p) * pdf_base, zero),
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3x8, draws: &BsdfDraws<F32x8>) -> Sampled {
        let material = &self.0;
        let (fresnel_o, _) = fresnel_dielectric(wo.z, material.ior);
        let p = gloss_probability(material, wo.z, fresnel_o);
        let wi = sample_coat_or_base(p, material.alpha, wo, draws);
        let Scattered { f_cosine, pdf_dir } = self.evaluate(wo, wi);
        let weight = f_cosine.scale(F32x8::ONE / pdf_dir);
        Sampled { valid: steep_enough(wo, wi), wi, weight, pdf_dir }
    }
}

/// Probabilities of the facets: in proportion to what they and the bases are expected to reflect of the brightest channels.
#[inline(always)]
fn gloss_probability(material: &MaterialColumns, cosine: F32x8, fresnel: F32x8) -> F32x8 {
    let (one, metallic) = (F32x8::ONE, material.metallic);
    let color = material.color.max_element();
    let least = F32x8::splat(1e-4);
    let color = color.gt(least).select(color, least);
    let metal = color + (one - color) * schlick(cosine);
    let gloss = metallic * metal + (one - metallic) * fresnel;
    let base = (one - metallic) * (one - fresnel) * color;
    gloss / (gloss + base)
}
