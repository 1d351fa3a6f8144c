//! The metallic-roughness model of glTF 2.0 (appendix B of the specification; what differs here, and why, is said at
//! [`crate::scene::desc::Scattering::Principled`]).

use super::microfacet::{fresnel_dielectric, ggx_reflection, half_vector, sample_coat_or_base, schlick, steep_enough};
use super::sample::{BsdfSample, drawn, max_element};
use super::warp::cosine_hemisphere_pdf_dir;
use super::{Real, Vec3, vec3};
use crate::fault::{Fault, planted};
use crate::tables::materials::MaterialRecord;

/// A metal and a plastic, mixed: facets of one GGX distribution, whose reflectance is the mean of the metal's (Schlick) and
/// the coat's (Fresnel), over the base of what is not metal.
pub fn evaluate(material: &MaterialRecord, wo: Vec3, wi: Vec3) -> (Vec3, Real) {
    if !steep_enough(wo, wi) {
        return (Vec3::ZERO, 0.0);
    }
    let (color, metallic, ior) = (vec3(material.color), material.metallic as Real, material.ior as Real);
    let half = half_vector(wo, wi);
    let (f, pdf_gloss) = ggx_reflection(material.alpha as Real, wo, wi, half);
    let cosine = wo.dot(half);
    let metal = color + (Vec3::ONE - color) * schlick(cosine);
    let (coat, _) = fresnel_dielectric(cosine, ior);
    let gloss = metal * metallic + Vec3::splat(coat * (1.0 - metallic));
    // What the coat lets through on the way in and out reaches the base; the constant in `base_weight` makes coat and base add
    // up to at most 1, as in plastics.
    let (fresnel_o, _) = fresnel_dielectric(wo.z, ior);
    let (fresnel_i, _) = fresnel_dielectric(wi.z, ior);
    let through = (1.0 - fresnel_o) * (1.0 - fresnel_i);
    let pdf_base = cosine_hemisphere_pdf_dir(wi.z);
    let base = color * (material.base_weight as Real * through * pdf_base);
    let p = gloss_probability(material, wo.z, fresnel_o);
    (base + gloss * f, p * pdf_gloss + (1.0 - p) * pdf_base)
}

/// Draws from the facets or from the base.
pub fn sample(material: &MaterialRecord, n: Vec3, wo: Vec3, u: [Real; 2], u_lobe: Real) -> Option<BsdfSample> {
    let (fresnel_o, _) = fresnel_dielectric(wo.z, material.ior as Real);
    let p = gloss_probability(material, wo.z, fresnel_o);
    let wi = sample_coat_or_base(p, material.alpha as Real, wo, u, u_lobe)?;
    let (f_cosine, pdf_dir) = evaluate(material, wo, wi);
    let weight = f_cosine * (1.0 / pdf_dir);
    Some(drawn(wi, n, weight, if planted(Fault::StaleDensity) { 1.01 * pdf_dir } else { pdf_dir }))
}

/// Probability of the facets: in proportion to what they and the base are expected to reflect of the brightest channel.
/// `fresnel`: what the coat reflects at this cosine.
fn gloss_probability(material: &MaterialRecord, cosine: Real, fresnel: Real) -> Real {
    let metallic = material.metallic as Real;
    // Above 0, so that a probability in proportion to it always exists.
    let color = max_element(vec3(material.color));
    let color = if color > 1e-4 { color } else { 1e-4 };
    let metal = color + (1.0 - color) * schlick(cosine);
    let gloss = metallic * metal + (1.0 - metallic) * fresnel;
    let base = (1.0 - metallic) * (1.0 - fresnel) * color;
    gloss / (gloss + base)
}
