//! Smooth glass: reflected with the Fresnel probability, else refracted (pbrt-v4 sections 9.3.3 and 9.5).

use super::here;
use super::interface::Specular;
use super::microfacet::fresnel_dielectric;
use super::mirror::reflect;
use crate::sampler::LOBE_WORDS;
use crate::sampler::draws::BsdfDraws;
use crate::tables::materials::{MaterialKind, MaterialRecord};
use here::kernels::records::MaterialColumns;
use here::kernels::surface::SurfacePoints;
use here::lanes::{F32x8, Mask8, U32x8, Vec3x8};
use here::numbers::draws::PathNumbers8;

/// Eight pieces of glass.
pub struct Dielectric(MaterialColumns);

impl Specular for Dielectric {
    const KIND: MaterialKind = MaterialKind::Dielectric;

    #[inline(always)]
    fn draws(numbers: &PathNumbers8, event: u32) -> BsdfDraws<F32x8> {
        numbers.bsdf::<LOBE_WORDS>(event)
    }

    #[inline(always)]
    fn load(materials: &[MaterialRecord], material: U32x8) -> Self {
        Dielectric(MaterialColumns::gather(materials, material))
    }

    #[inline(always)]
    fn orient(points: &mut SurfacePoints, direction: Vec3x8) -> Vec3x8 {
        points.graze(direction)
    }

    #[inline(always)]
    fn sample(&self, incoming: Vec3x8, normal: Vec3x8, front: Mask8, lobe: F32x8) -> (Vec3x8, Vec3x8, F32x8) {
        let one = F32x8::ONE;
        let eta = front.select(self.0.ior, one / self.0.ior);
        let cosine = -incoming.dot(normal);
        let (reflectance, cosine_t) = fresnel_dielectric(cosine, eta);
        let reflects = lobe.lt(reflectance);
        let scale = one / eta;
        let refracted = incoming.scale(scale) + normal.scale(cosine * scale - cosine_t);
        // Radiance is divided by the square of the relative index: it comes from another solid angle.
        let weight = reflects.select_vec3(Vec3x8::splat([1.0; 3]), self.0.color.scale(scale * scale));
        // Not of the weight: what entering takes, leaving gives back.
        let albedo = reflects.select(one, self.0.color.max_element());
        (reflects.select_vec3(reflect(incoming, normal), refracted), weight, albedo)
    }
}
