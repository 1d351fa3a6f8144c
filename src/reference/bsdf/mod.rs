//! How surfaces scatter, about the normal `n` of the side the ray came from. `wo` and `wi` are local directions (the normal
//! is +z) back along the ray and to where light comes from.

pub mod microfacet;

use super::warp::{
    cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, sample_uniform_hemisphere, to_local, to_world,
    uniform_hemisphere_pdf_dir,
};
use super::{INV_PI, Real, Vec3, sin_cos_turns, vec3};
use crate::tables::materials::{MaterialKind, MaterialRecord};
use microfacet::{fresnel_conductor, fresnel_dielectric, ggx_d, sample_visible_normal, smith_a};

/// A direction drawn to go on in.
pub struct BsdfSample {
    /// Unit direction in world space; below the surface after a refraction.
    pub direction: Vec3,
    /// BSDF times cosine over density: what the throughput is multiplied with.
    pub factor: Vec3,
    /// Density per steradian; meaningless for a delta lobe.
    pub pdf_dir: Real,
    /// Cosine between direction and normal; meaningless for a delta lobe.
    pub cosine: Real,
    /// The direction was the only one possible, or one of two.
    pub delta: bool,
}

/// Glossy surfaces scatter nothing that leaves or arrives flatter than this: below, the ratios of masking overflow.
pub const MIN_COSINE: Real = 1e-6;

/// Whether light sampling can work on this kind.
pub fn is_delta(kind: MaterialKind) -> bool {
    matches!(kind, MaterialKind::Mirror | MaterialKind::Dielectric)
}

/// BSDF times cosine towards the unit world direction `direction` for the unit `incoming` (towards the surface), and the
/// density with which [`sample`] draws it. Not for delta kinds.
pub fn evaluate(material: &MaterialRecord, n: Vec3, incoming: Vec3, direction: Vec3) -> (Vec3, Real) {
    match material.kind() {
        MaterialKind::Diffuse => {
            // Lambert: albedo/pi times cosine; cosine/pi is also the density.
            let pdf_dir = cosine_hemisphere_pdf_dir(n.dot(direction));
            (vec3(material.color) * pdf_dir, pdf_dir)
        }
        MaterialKind::Conductor => evaluate_conductor(material, to_local(-incoming, n), to_local(direction, n)),
        MaterialKind::Plastic => evaluate_plastic(material, to_local(-incoming, n), to_local(direction, n)),
        MaterialKind::Black | MaterialKind::Mirror | MaterialKind::Dielectric => (Vec3::ZERO, 0.0),
    }
}

/// Draws a direction; `None` if the one drawn carries nothing. `u` places it, `u_lobe` chooses between lobes. `front`: the
/// ray hit the front (for glass: it comes from outside).
pub fn sample(
    material: &MaterialRecord,
    n: Vec3,
    incoming: Vec3,
    front: bool,
    u: [Real; 2],
    u_lobe: Real,
) -> Option<BsdfSample> {
    match material.kind() {
        MaterialKind::Black => None,
        MaterialKind::Diffuse => {
            let local = sample_cosine_hemisphere(u);
            let pdf_dir = cosine_hemisphere_pdf_dir(local.z);
            let (direction, factor) = (to_world(local, n), vec3(material.color));
            Some(BsdfSample { direction, factor, pdf_dir, cosine: local.z, delta: false })
        }
        MaterialKind::Mirror => Some(delta_sample(reflect(incoming, n), vec3(material.color))),
        MaterialKind::Conductor => sample_conductor(material, n, to_local(-incoming, n), u),
        MaterialKind::Dielectric => Some(sample_dielectric(material, n, incoming, front, u_lobe)),
        MaterialKind::Plastic => sample_plastic(material, n, to_local(-incoming, n), u, u_lobe),
    }
}

/// Draws a direction uniformly over the hemisphere (the lecture's starting point). Not for delta kinds.
pub fn sample_uniformly(material: &MaterialRecord, n: Vec3, incoming: Vec3, u: [Real; 2]) -> BsdfSample {
    let local = sample_uniform_hemisphere(u);
    let pdf_dir = uniform_hemisphere_pdf_dir();
    let f_cosine = match material.kind() {
        MaterialKind::Conductor => evaluate_conductor(material, to_local(-incoming, n), local).0,
        MaterialKind::Plastic => evaluate_plastic(material, to_local(-incoming, n), local).0,
        _ => vec3(material.color) * cosine_hemisphere_pdf_dir(local.z),
    };
    let factor = f_cosine * (1.0 / pdf_dir);
    BsdfSample { direction: to_world(local, n), factor, pdf_dir, cosine: local.z, delta: false }
}

fn delta_sample(direction: Vec3, factor: Vec3) -> BsdfSample {
    BsdfSample { direction, factor, pdf_dir: 1.0, cosine: 0.0, delta: true }
}

/// The mirror image of a direction towards the surface.
fn reflect(incoming: Vec3, n: Vec3) -> Vec3 {
    incoming - n * (2.0 * incoming.dot(n))
}

/// The Fresnel reflectance of a conductor: constant, or from its complex index of refraction.
fn conductor_reflectance(material: &MaterialRecord, cosine: Real) -> Vec3 {
    if material.has_complex_ior() {
        fresnel_conductor(cosine, vec3(material.eta), vec3(material.k))
    } else {
        vec3(material.color)
    }
}

/// GGX reflection (Walter et al. 2007; height-correlated Smith, Heitz 2014): F D G2 / (4 cos_o cos_i) times cos_i.
fn evaluate_conductor(material: &MaterialRecord, wo: Vec3, wi: Vec3) -> (Vec3, Real) {
    if !(wi.z > MIN_COSINE && wo.z > MIN_COSINE) {
        return (Vec3::ZERO, 0.0);
    }
    let half = half_vector(wo, wi);
    let (f, pdf_dir) = ggx_reflection(material.alpha as Real, wo, wi, half);
    (conductor_reflectance(material, wo.dot(half)) * f, pdf_dir)
}

/// D G2 / (4 cos_o), and the density G1(o) D / (4 cos_o) of reflecting at visible normals.
fn ggx_reflection(alpha: Real, wo: Vec3, wi: Vec3, half: Vec3) -> (Real, Real) {
    let d = ggx_d(alpha, half) / (4.0 * wo.z);
    let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
    (d * (2.0 / (o + i)), d * (2.0 / (1.0 + o)))
}

/// The unit vector half-way between two unit vectors above the surface.
fn half_vector(wo: Vec3, wi: Vec3) -> Vec3 {
    let sum = wi + wo;
    sum * (1.0 / sum.dot(sum).sqrt())
}

fn sample_conductor(material: &MaterialRecord, n: Vec3, wo: Vec3, u: [Real; 2]) -> Option<BsdfSample> {
    let alpha = material.alpha as Real;
    let half = sample_visible_normal(alpha, wo, u);
    let wi = half * (2.0 * wo.dot(half)) - wo;
    if !(wi.z > MIN_COSINE && wo.z > MIN_COSINE) {
        return None;
    }
    // The distribution cancels: what is left is F G2 / G1, finite however sharp the lobe.
    let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
    let factor = conductor_reflectance(material, wo.dot(half)) * ((1.0 + o) / (o + i));
    let (_, pdf_dir) = ggx_reflection(alpha, wo, wi, half);
    Some(BsdfSample { direction: to_world(wi, n), factor, pdf_dir, cosine: wi.z, delta: false })
}

/// Smooth glass: reflected with the Fresnel probability, else refracted (pbrt-v4 section 9.3.3 and 9.5). What is refracted
/// is compressed into another solid angle: radiance is divided by the square of the relative index.
fn sample_dielectric(material: &MaterialRecord, n: Vec3, incoming: Vec3, front: bool, u_lobe: Real) -> BsdfSample {
    let ior = material.ior as Real;
    let eta = if front { ior } else { 1.0 / ior };
    let cosine = -incoming.dot(n);
    let (reflectance, cosine_t) = fresnel_dielectric(cosine, eta);
    if u_lobe < reflectance {
        return delta_sample(reflect(incoming, n), Vec3::ONE);
    }
    let scale = 1.0 / eta;
    let direction = incoming * scale + n * (cosine * scale - cosine_t);
    delta_sample(direction, vec3(material.color) * (scale * scale))
}

/// Probability of the coat: in proportion to what it and the base are expected to reflect.
fn coat_probability(material: &MaterialRecord, fresnel: Real) -> Real {
    let base = (1.0 - fresnel) * material.base_weight as Real;
    fresnel / (fresnel + base)
}

/// A diffuse base under a GGX coat. What the coat lets through twice, (1 - F(o)) (1 - F(i)), the base reflects; the
/// constant in `base` makes the two add up to at most 1 (see [`crate::tables::materials`]).
fn evaluate_plastic(material: &MaterialRecord, wo: Vec3, wi: Vec3) -> (Vec3, Real) {
    if !(wi.z > MIN_COSINE && wo.z > MIN_COSINE) {
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

fn sample_plastic(material: &MaterialRecord, n: Vec3, wo: Vec3, u: [Real; 2], u_lobe: Real) -> Option<BsdfSample> {
    let (fresnel_o, _) = fresnel_dielectric(wo.z, material.ior as Real);
    let wi = if u_lobe < coat_probability(material, fresnel_o) {
        let half = sample_visible_normal(material.alpha as Real, wo, u);
        half * (2.0 * wo.dot(half)) - wo
    } else {
        sample_cosine_hemisphere(u)
    };
    if !(wi.z > MIN_COSINE && wo.z > MIN_COSINE) {
        return None;
    }
    let (f_cosine, pdf_dir) = evaluate_plastic(material, wo, wi);
    let factor = f_cosine * (1.0 / pdf_dir);
    Some(BsdfSample { direction: to_world(wi, n), factor, pdf_dir, cosine: wi.z, delta: false })
}
