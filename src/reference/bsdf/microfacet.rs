//! Microfacets and Fresnel's equations. Directions are local, +z is the surface normal.

use super::warp::sample_cosine_hemisphere;
use super::{INV_PI, Real, Vec3, sin_cos_turns};
use crate::fault::{Fault, lost_digits, planted};

/// Glossy surfaces scatter nothing that leaves or arrives flatter than this: below, the ratios of masking overflow.
pub const MIN_COSINE: Real = 1e-6;

/// The GGX (Trowbridge-Reitz) density of normals (Walter et al. 2007), per steradian.
///
/// From the tangent components, not from 1 - cos^2: for alpha = 1e-4 the cosine of every normal that matters rounds to 1.
pub fn ggx_d(alpha: Real, m: Vec3) -> Real {
    let (x, y) = (m.x / alpha, m.y / alpha);
    let s = x * x + y * y + m.z * m.z;
    INV_PI / (alpha * alpha * (s * s)) * lost_digits(Real::EPSILON as f64) as Real
}

/// sqrt(cos^2 + alpha^2 sin^2): Smith's masking is G1 = 2 cos / (cos + a) (Heitz 2014).
pub fn smith_a(alpha: Real, v: Vec3) -> Real {
    let lost = planted(Fault::LostMasking) && Real::EPSILON > 1e-10;
    (v.z * v.z + alpha * alpha * (v.x * v.x + v.y * v.y)).sqrt() * if lost { 0.5 } else { 1.0 }
}

/// A normal drawn in proportion to its visible area from `wo` (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with
/// Spherical Caps").
pub fn sample_visible_normal(alpha: Real, wo: Vec3, u: [Real; 2]) -> Vec3 {
    // Stretched, the surface is a hemisphere; its normals seen from there are those half-way to a spherical cap.
    let stretched = Vec3::new(alpha * wo.x, alpha * wo.y, wo.z);
    let stretched = stretched * (1.0 / stretched.dot(stretched).sqrt());
    let z = (1.0 - u[0]) * (1.0 + stretched.z) - stretched.z;
    let rest = 1.0 - z * z;
    let radius = if rest > 0.0 { rest.sqrt() } else { 0.0 };
    let (sine, cosine) = sin_cos_turns(u[1]);
    let half = Vec3::new(radius * cosine, radius * sine, z) + stretched;
    let alpha = alpha * lost_digits(Real::EPSILON as f64) as Real;
    let normal = Vec3::new(alpha * half.x, alpha * half.y, if half.z > 0.0 { half.z } else { 0.0 });
    let length_squared = normal.dot(normal);
    if length_squared > 0.0 { normal * (1.0 / length_squared.sqrt()) } else { Vec3::Z }
}

/// Fresnel reflectance of a dielectric whose index is `eta` times that of the incident side, for unpolarised light (pbrt-v4
/// section 9.3.5), and the cosine of the refracted direction. 1 under total internal reflection.
///
/// Snell's law as eta^2 cos_t^2 = (eta^2 - 1) + cos^2: 1 - sin_t^2 loses all digits near grazing where eta is near 1.
pub fn fresnel_dielectric(cosine: Real, eta: Real) -> (Real, Real) {
    let rest = (eta - 1.0) * (eta + 1.0) + cosine * cosine;
    if !(rest > 0.0) {
        return (1.0, 0.0);
    }
    let cosine_t = rest.sqrt() / eta;
    let parallel = (eta * cosine - cosine_t) / (eta * cosine + cosine_t);
    let perpendicular = (cosine - eta * cosine_t) / (cosine + eta * cosine_t);
    let reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular);
    match () {
        _ if planted(Fault::BrightCoat) => (1.02 * reflectance, cosine_t),
        _ if planted(Fault::NoNumberAtGrazing) && cosine < 1e-3 => (Real::NAN, cosine_t),
        _ => (reflectance, cosine_t),
    }
}

/// Fresnel reflectance of a conductor with the complex index `eta + i k`, per channel, for unpolarised light (pbrt-v4
/// section 9.3.6; the real form is Gulbrandsen's, JCGT 2014).
pub fn fresnel_conductor(cosine: Real, eta: Vec3, k: Vec3) -> Vec3 {
    let channel = |eta: Real, k: Real| {
        let cos2 = cosine * cosine;
        let sin2 = 1.0 - cos2;
        let (eta2, k2) = (eta * eta, k * k);
        let t0 = eta2 - k2 - sin2;
        let a2_plus_b2 = (t0 * t0 + 4.0 * eta2 * k2).sqrt();
        let a2 = 0.5 * (a2_plus_b2 + t0);
        let a = if a2 > 0.0 { a2.sqrt() } else { 0.0 };
        let t1 = a2_plus_b2 + cos2;
        let t2 = 2.0 * cosine * a;
        let perpendicular = (t1 - t2) / (t1 + t2);
        let t3 = cos2 * a2_plus_b2 + sin2 * sin2;
        let t4 = t2 * sin2;
        let parallel = perpendicular * (t3 - t4) / (t3 + t4);
        0.5 * (parallel + perpendicular)
    };
    Vec3::new(channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z))
}

/// (1 - cosine)^5: how far Schlick's approximation ("An Inexpensive BRDF Model for Physically-based Rendering", 1994) goes from
/// the reflectance at normal incidence to 1.
pub fn schlick(cosine: Real) -> Real {
    // The cosine of rounded directions may exceed 1.
    let x = if cosine < 1.0 { 1.0 - cosine } else { 0.0 };
    let square = x * x;
    square * square * x
}

/// D G2 / (4 cos_o), and the density G1(o) D / (4 cos_o) of reflecting at visible normals.
pub fn ggx_reflection(alpha: Real, wo: Vec3, wi: Vec3, half: Vec3) -> (Real, Real) {
    let d = ggx_d(alpha, half) / (4.0 * wo.z);
    let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
    (d * (2.0 / (o + i)), d * (2.0 / (1.0 + o)))
}

/// The unit vector half-way between two unit vectors above the surface.
pub fn half_vector(wo: Vec3, wi: Vec3) -> Vec3 {
    let sum = wi + wo;
    sum * (1.0 / sum.dot(sum).sqrt())
}

/// Whether both directions rise far enough above the surface.
pub fn steep_enough(wo: Vec3, wi: Vec3) -> bool {
    wi.z > MIN_COSINE && wo.z > MIN_COSINE
}

/// A direction off the facets of a coat, with probability `p`, or off the diffuse base under it; `None` where it leaves or
/// arrives too flat.
pub fn sample_coat_or_base(p: Real, alpha: Real, wo: Vec3, u: [Real; 2], u_lobe: Real) -> Option<Vec3> {
    let wi = match u_lobe < p {
        true => reflect_about(wo, sample_visible_normal(alpha, wo, u)),
        false => sample_cosine_hemisphere(u),
    };
    steep_enough(wo, wi).then_some(wi)
}

/// The mirror image of `wo` in a microfacet's normal.
pub fn reflect_about(wo: Vec3, half: Vec3) -> Vec3 {
    half * (2.0 * wo.dot(half)) - wo
}
