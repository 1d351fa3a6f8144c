//! Metals with GGX microfacets.

use super::microfacet::{
    fresnel_conductor, ggx_reflection, half_vector, reflect_about, sample_visible_normal, smith_a, steep_enough,
};
use super::sample::{BsdfSample, drawn};
use super::{Real, Vec3, vec3};
use crate::fault::{Fault, planted};
use crate::tables::materials::MaterialRecord;

/// GGX reflection (Walter et al. 2007; height-correlated Smith, Heitz 2014): F D G2 / (4 cos_o cos_i) times cos_i.
pub fn evaluate(material: &MaterialRecord, wo: Vec3, wi: Vec3) -> (Vec3, Real) {
    if !steep_enough(wo, wi) {
        return (Vec3::ZERO, 0.0);
    }
    let half = half_vector(wo, wi);
    let (f, pdf_dir) = ggx_reflection(material.alpha as Real, wo, wi, half);
    (conductor_reflectance(material, wo.dot(half)) * f, pdf_dir)
}

/// Draws a visible normal and reflects at it.
pub fn sample(material: &MaterialRecord, n: Vec3, wo: Vec3, u: [Real; 2]) -> Option<BsdfSample> {
    let alpha = material.alpha as Real;
    let half = sample_visible_normal(alpha, wo, u);
    let wi = reflect_about(wo, half);
    if !steep_enough(wo, wi) {
        return None;
    }
    // The distribution cancels: what is left is F G2 / G1, finite however sharp the lobe.
    let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
    let weight = conductor_reflectance(material, wo.dot(half)) * ((1.0 + o) / (o + i));
    let (_, pdf_dir) = ggx_reflection(alpha, wo, wi, half);
    Some(drawn(wi, n, weight, if planted(Fault::StaleDensity) { 1.01 * pdf_dir } else { pdf_dir }))
}

/// The Fresnel reflectance of a conductor: constant, or from its complex index of refraction.
fn conductor_reflectance(material: &MaterialRecord, cosine: Real) -> Vec3 {
    if material.has_complex_ior() {
        fresnel_conductor(cosine, vec3(material.eta), vec3(material.k))
    } else {
        vec3(material.color)
    }
}
