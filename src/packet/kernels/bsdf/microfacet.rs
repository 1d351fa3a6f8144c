//! Microfacets and Fresnel's equations, eight at a time. Directions are local, +z is the surface normal.

use super::here;
use crate::math::INV_PI;
use crate::sampler::draws::BsdfDraws;
use here::kernels::warp::sample_cosine_hemisphere;
use here::lanes::{F32x8, Mask8, Vec3x8, inlined, sin_cos_turns};

/// Glossy surfaces scatter nothing that leaves or arrives flatter than this: below, the ratios of masking overflow.
pub const MIN_COSINE: f32 = 1e-6;

/// The GGX density of normals (Walter et al. 2007), per steradian; from the tangent components, which keep their precision
/// in the narrowest lobes.
#[inline(always)]
pub fn ggx_d(alpha: F32x8, m: Vec3x8) -> F32x8 {
    let (x, y) = (m.x / alpha, m.y / alpha);
    let s = x * x + y * y + m.z * m.z;
    F32x8::splat(INV_PI) / (alpha * alpha * (s * s))
}

/// sqrt(cos^2 + alpha^2 sin^2): Smith's masking is G1 = 2 cos / (cos + a) (Heitz 2014).
#[inline(always)]
pub fn smith_a(alpha: F32x8, v: Vec3x8) -> F32x8 {
    (v.z * v.z + alpha * alpha * (v.x * v.x + v.y * v.y)).sqrt()
}

/// Normals drawn in proportion to their visible area from `wo` (Dupuy and Benyoub 2023).
#[inline(always)]
pub fn sample_visible_normal(alpha: F32x8, wo: Vec3x8, u: [F32x8; 2]) -> Vec3x8 {
    let (zero, one) = (F32x8::ZERO, F32x8::ONE);
    let stretched = Vec3x8::new(alpha * wo.x, alpha * wo.y, wo.z);
    let stretched = stretched.scale(one / stretched.dot(stretched).sqrt());
    let z = (one - u[0]) * (one + stretched.z) - stretched.z;
    let rest = one - z * z;
    let radius = rest.gt(zero).select(rest.sqrt(), zero);
    let (sine, cosine) = sin_cos_turns(u[1]);
    let half = Vec3x8::new(radius * cosine, radius * sine, z) + stretched;
    let normal = Vec3x8::new(alpha * half.x, alpha * half.y, half.z.gt(zero).select(half.z, zero));
    let length_squared = normal.dot(normal);
    let unit = normal.scale(one / length_squared.sqrt());
    length_squared.gt(zero).select_vec3(unit, Vec3x8::new(zero, zero, one))
}

/// Fresnel reflectance of dielectrics whose indices are `eta` times those of the incident sides (pbrt-v4 section 9.3.5), and
/// the cosines of the refracted directions. 1 under total internal reflection.
#[inline(always)]
pub fn fresnel_dielectric(cosine: F32x8, eta: F32x8) -> (F32x8, F32x8) {
    let (zero, one) = (F32x8::ZERO, F32x8::ONE);
    let rest = (eta - one) * (eta + one) + cosine * cosine;
    let refracts = rest.gt(zero);
    let cosine_t = refracts.select(rest.sqrt() / eta, zero);
    let parallel = (eta * cosine - cosine_t) / (eta * cosine + cosine_t);
    let perpendicular = (cosine - eta * cosine_t) / (cosine + eta * cosine_t);
    let reflectance = F32x8::splat(0.5) * (parallel * parallel + perpendicular * perpendicular);
    (refracts.select(reflectance, one), cosine_t)
}

/// Fresnel reflectance of conductors with complex indices `eta + i k`, per channel (pbrt-v4 section 9.3.6).
#[inline(always)]
pub fn fresnel_conductor(cosine: F32x8, eta: Vec3x8, k: Vec3x8) -> Vec3x8 {
    let (zero, one, half) = (F32x8::ZERO, F32x8::ONE, F32x8::splat(0.5));
    let channel = inlined(
        #[inline(always)]
        |eta: F32x8, k: F32x8| {
            let cos2 = cosine * cosine;
            let sin2 = one - cos2;
            let (eta2, k2) = (eta * eta, k * k);
            let t0 = eta2 - k2 - sin2;
            let a2_plus_b2 = (t0 * t0 + F32x8::splat(4.0) * eta2 * k2).sqrt();
            let a2 = half * (a2_plus_b2 + t0);
            let a = a2.gt(zero).select(a2.sqrt(), zero);
            let t1 = a2_plus_b2 + cos2;
            let t2 = F32x8::splat(2.0) * cosine * a;
            let perpendicular = (t1 - t2) / (t1 + t2);
            let t3 = cos2 * a2_plus_b2 + sin2 * sin2;
            let t4 = t2 * sin2;
            let parallel = perpendicular * (t3 - t4) / (t3 + t4);
            half * (parallel + perpendicular)
        },
    );
    Vec3x8::new(channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z))
}

/// (1 - cosine)^5: how far Schlick's approximation (1994) goes from reflectances at normal incidence to 1.
#[inline(always)]
pub fn schlick(cosine: F32x8) -> F32x8 {
    let (zero, x) = (F32x8::ZERO, F32x8::ONE - cosine);
    // Cosines of rounded directions may exceed 1.
    let x = x.gt(zero).select(x, zero);
    let square = x * x;
    square * square * x
}

/// Lanes in which neither direction is too flat.
#[inline(always)]
pub fn steep_enough(wo: Vec3x8, wi: Vec3x8) -> Mask8 {
    let least = F32x8::splat(MIN_COSINE);
    wi.z.gt(least) & wo.z.gt(least)
}

/// Unit vectors half-way between unit vectors above the surface.
#[inline(always)]
pub fn half_vector(wo: Vec3x8, wi: Vec3x8) -> Vec3x8 {
    let sum = wi + wo;
    sum.scale(F32x8::ONE / sum.dot(sum).sqrt())
}

/// Directions off the facets of coats, with probabilities `p`, or off the diffuse bases under them.
#[inline(always)]
pub fn sample_coat_or_base(p: F32x8, alpha: F32x8, wo: Vec3x8, draws: &BsdfDraws<F32x8>) -> Vec3x8 {
    let glossy = reflect_about(wo, sample_visible_normal(alpha, wo, draws.direction));
    draws.lobe.lt(p).select_vec3(glossy, sample_cosine_hemisphere(draws.direction))
}

/// Unit vectors `wo`, mirrored in `half`.
#[inline(always)]
pub fn reflect_about(wo: Vec3x8, half: Vec3x8) -> Vec3x8 {
    half.scale(F32x8::splat(2.0) * wo.dot(half)) - wo
}

/// D G2 / (4 cos_o), and the densities G1(o) D / (4 cos_o) of reflecting at visible normals.
#[inline(always)]
pub fn ggx_reflection(alpha: F32x8, wo: Vec3x8, wi: Vec3x8, half: Vec3x8) -> (F32x8, F32x8) {
    let two = F32x8::splat(2.0);
    let d = ggx_d(alpha, half) / (F32x8::splat(4.0) * wo.z);
    let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
    (d * (two / (o + i)), d * (two / (F32x8::ONE + o)))
}
