//! Glossy BSDFs for eight hits at a time. Directions are local, +z is the normal of the side the ray came from; `wo` points
//! back along the ray, `wi` to where light comes from.

pub mod microfacet;

use crate::lanes::{F32x8, Mask8, U32x8, Vec3x8};
use crate::packet::bsdf::microfacet::{fresnel_conductor, fresnel_dielectric, ggx_d, sample_visible_normal, smith_a};
use crate::packet::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere};

/// Glossy surfaces scatter nothing that leaves or arrives flatter than this: below, the ratios of masking overflow.
pub const MIN_COSINE: f32 = 1e-6;

/// Eight material records, as columns ([`crate::tables::materials::MaterialRecord`] field by field).
pub struct MaterialColumns {
    /// Albedo or reflectance.
    pub color: Vec3x8,
    /// GGX widths.
    pub alpha: F32x8,
    /// Real parts of conductors' indices of refraction.
    pub eta: Vec3x8,
    /// Indices of refraction of coats and glass.
    pub ior: F32x8,
    /// Imaginary parts of conductors' indices of refraction.
    pub k: Vec3x8,
    /// What bases are expected to reflect.
    pub base_weight: F32x8,
    /// Conductors with a complex index.
    pub complex_ior: Mask8,
}

impl MaterialColumns {
    /// From gathered records.
    #[inline(always)]
    pub fn new(c: &[F32x8; 16]) -> MaterialColumns {
        MaterialColumns {
            color: Vec3x8::new(c[0], c[1], c[2]),
            alpha: c[3],
            eta: Vec3x8::new(c[4], c[5], c[6]),
            ior: c[7],
            k: Vec3x8::new(c[8], c[9], c[10]),
            base_weight: c[11],
            complex_ior: c[12].to_bits().eq(U32x8::splat(1)),
        }
    }
}

/// BSDF times cosine, and the density of drawing `wi`; both 0 where either direction is too flat.
pub struct Scattered {
    /// BSDF times cosine.
    pub f_cosine: Vec3x8,
    /// Densities per steradian.
    pub pdf_dir: F32x8,
}

/// Eight directions drawn.
pub struct Sampled {
    /// Lanes whose direction carries something.
    pub valid: Mask8,
    /// Local unit directions.
    pub wi: Vec3x8,
    /// BSDF times cosine over density.
    pub factor: Vec3x8,
    /// Densities per steradian.
    pub pdf_dir: F32x8,
}

/// A glossy kind: how it is evaluated and sampled.
pub trait Glossy {
    /// BSDF times cosine towards `wi`, and its density.
    fn evaluate(material: &MaterialColumns, wo: Vec3x8, wi: Vec3x8) -> Scattered;
    /// Draws directions: `u` places them, `u_lobe` chooses between lobes.
    fn sample(material: &MaterialColumns, wo: Vec3x8, u: [F32x8; 2], u_lobe: F32x8) -> Sampled;
}

/// Metal with GGX microfacets.
pub struct Conductor;

/// A diffuse base under a GGX coat.
pub struct Plastic;

#[inline(always)]
fn steep_enough(wo: Vec3x8, wi: Vec3x8) -> Mask8 {
    let least = F32x8::splat(MIN_COSINE);
    wi.z.gt(least) & wo.z.gt(least)
}

/// Unit vectors half-way between unit vectors above the surface.
#[inline(always)]
fn half_vector(wo: Vec3x8, wi: Vec3x8) -> Vec3x8 {
    let sum = wi + wo;
    sum.scale(F32x8::ONE / sum.dot(sum).sqrt())
}

#[inline(always)]
fn reflect_about(wo: Vec3x8, half: Vec3x8) -> Vec3x8 {
    half.scale(F32x8::splat(2.0) * wo.dot(half)) - wo
}

/// D G2 / (4 cos_o), and the densities G1(o) D / (4 cos_o) of reflecting at visible normals.
#[inline(always)]
fn ggx_reflection(alpha: F32x8, wo: Vec3x8, wi: Vec3x8, half: Vec3x8) -> (F32x8, F32x8) {
    let two = F32x8::splat(2.0);
    let d = ggx_d(alpha, half) / (F32x8::splat(4.0) * wo.z);
    let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
    (d * (two / (o + i)), d * (two / (F32x8::ONE + o)))
}

#[inline(always)]
fn conductor_reflectance(material: &MaterialColumns, cosine: F32x8) -> Vec3x8 {
    if !material.complex_ior.any() {
        return material.color;
    }
    material.complex_ior.select_vec3(fresnel_conductor(cosine, material.eta, material.k), material.color)
}

impl Glossy for Conductor {
    #[inline(always)]
    fn evaluate(material: &MaterialColumns, wo: Vec3x8, wi: Vec3x8) -> Scattered {
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
    fn sample(material: &MaterialColumns, wo: Vec3x8, u: [F32x8; 2], _: F32x8) -> Sampled {
        let alpha = material.alpha;
        let half = sample_visible_normal(alpha, wo, u);
        let wi = reflect_about(wo, half);
        let (o, i) = (smith_a(alpha, wo) / wo.z, smith_a(alpha, wi) / wi.z);
        let factor = conductor_reflectance(material, wo.dot(half)).scale((F32x8::ONE + o) / (o + i));
        let (_, pdf_dir) = ggx_reflection(alpha, wo, wi, half);
        Sampled { valid: steep_enough(wo, wi), wi, factor, pdf_dir }
    }
}

#[inline(always)]
fn coat_probability(material: &MaterialColumns, fresnel: F32x8) -> F32x8 {
    let base = (F32x8::ONE - fresnel) * material.base_weight;
    fresnel / (fresnel + base)
}

impl Glossy for Plastic {
    #[inline(always)]
    fn evaluate(material: &MaterialColumns, wo: Vec3x8, wi: Vec3x8) -> Scattered {
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
    fn sample(material: &MaterialColumns, wo: Vec3x8, u: [F32x8; 2], u_lobe: F32x8) -> Sampled {
        let (fresnel_o, _) = fresnel_dielectric(wo.z, material.ior);
        let coat = u_lobe.lt(coat_probability(material, fresnel_o));
        let glossy = reflect_about(wo, sample_visible_normal(material.alpha, wo, u));
        let wi = coat.select_vec3(glossy, sample_cosine_hemisphere(u));
        let Scattered { f_cosine, pdf_dir } = Self::evaluate(material, wo, wi);
        let factor = f_cosine.scale(F32x8::ONE / pdf_dir);
        Sampled { valid: steep_enough(wo, wi), wi, factor, pdf_dir }
    }
}
