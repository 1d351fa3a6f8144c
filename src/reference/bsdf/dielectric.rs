//! Smooth glass.

use super::microfacet::fresnel_dielectric;
use super::mirror::reflect;
use super::sample::{BsdfSample, max_element, only};
use super::{Real, Vec3, vec3};
use crate::fault::{Fault, planted};
use crate::tables::materials::MaterialRecord;

/// Smooth glass: reflected with the Fresnel probability, else refracted (pbrt-v4 section 9.3.3 and 9.5). What is refracted
/// is compressed into another solid angle: radiance is divided by the square of the relative index.
pub fn sample(material: &MaterialRecord, n: Vec3, incoming: Vec3, front: bool, u_lobe: Real) -> BsdfSample {
    let ior = material.ior as Real * if planted(Fault::WrongRefraction) { 1.001 } else { 1.0 };
    let eta = if front { ior } else { 1.0 / ior };
    let cosine = -incoming.dot(n);
    let (reflectance, cosine_t) = fresnel_dielectric(cosine, eta);
    if u_lobe < reflectance {
        return only(reflect(incoming, n), Vec3::ONE);
    }
    let scale = 1.0 / eta;
    let direction = incoming * scale + n * (cosine * scale - cosine_t);
    // Of the weight, what entering takes, leaving gives back.
    let albedo = max_element(vec3(material.color));
    BsdfSample { albedo, ..only(direction, vec3(material.color) * (scale * scale)) }
}
