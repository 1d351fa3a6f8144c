//! Diffuse bases under GGX coats.

use super::microfacet::{fresnel_dielectric, ggx_reflection, half_vector, sample_coat_or_base, steep_enough};
use super::sample::{BsdfSample, drawn};
use super::warp::cosine_hemisphere_pdf_dir;
use super::{Real, Vec3, vec3};
use crate::tables::materials::MaterialRecord;

/// A diffuse base under a GGX coat. What the coat lets through twice, (1 - F(o)) (1 - F(i)), the base reflects; the
/// constant in `base` makes the two add up to at most 1 (see [`crate::tables::materials`]).
pub fn evaluate(material: &MaterialRecord, wo: Vec3, wi: Vec3) -> (Vec3, Real) {
    if !steep_enough(wo, wi) {
        return (Vec3::ZERO, 0.0);
    }
    let (alpha, ior) = (material.alpha as Real, material.ior as Real);
    let half = half_vector(wo, wi);
    let (f, pdf_coat) = ggx_reflection(alpha, wo, wi, half);
    let (coat, _) = fresnel_dielectric(wo.dot(half), ior);
    let (fresnel_o, _) = fresnel_dielectric(wo.z, ior);
    let (fresnel_i, _) = fresnel_dielectric(wi.z, ior);
    let pdf_base = cosine_hemisphere_pdf_dir(wi.z);
    let through = (1.0 - fresnel_o) * (1.0 - fresnel_i);
    let p = coat_probability(material, fresnel_o);
    (vec3(material.color) * (through * pdf_base) + Vec3::splat(coat * f), p * pdf_coat + (1.0 - p) * pdf_base)
}

/// Draws from the coat or from the base.
pub fn sample(material: &MaterialRecord, n: Vec3, wo: Vec3, u: [Real; 2], u_lobe: Real) -> Option<BsdfSample> {
    let (fresnel_o, _) = fresnel_dielectric(wo.z, material.ior as Real);
    let p = coat_probability(material, fresnel_o);
    let wi = sample_coat_or_base(p, material.alpha as Real, wo, u, u_lobe)?;
    let (f_cosine, pdf_dir) = evaluate(material, wo, wi);
    let weight = f_cosine * (1.0 / pdf_dir);
    Some(drawn(wi, n, weight, pdf_dir))
}

/// Probability of the coat: in proportion to what it and the base are expected to reflect.
fn coat_probability(material: &MaterialRecord, fresnel: Real) -> Real {
    let base = (1.0 - fresnel) * material.base_weight as Real;
    fresnel / (fresnel + base)
}
