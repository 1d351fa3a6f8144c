//! What the stages ask of a material kind.

use super::here;
use crate::sampler::ALL_WORDS;
use crate::sampler::draws::{BsdfDraws, LightDraws};
use crate::tables::materials::{MaterialKind, MaterialRecord};
use here::kernels::surface::SurfacePoints;
use here::lanes::{F32x8, Mask8, U32x8, Vec3x8};
use here::numbers::draws::PathNumbers8;

/// BSDF times cosine, and the density of drawing `wi`; both 0 where nothing is scattered.
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
    /// BSDF weights: BSDF times cosine over density.
    pub weight: Vec3x8,
    /// Densities per steradian.
    pub pdf_dir: F32x8,
}

/// A kind whose directions are drawn from a density.
pub trait Bsdf: Sized {
    /// The kind.
    const KIND: MaterialKind;
    /// The viewers must be above the shading normals.
    const FACES_FORWARD: bool;
    /// The numbers that [`Bsdf::sample`] and roulette read; others hold anything.
    #[inline(always)]
    fn draws(numbers: &PathNumbers8, event: u32) -> BsdfDraws<F32x8> {
        numbers.bsdf::<ALL_WORDS>(event)
    }
    /// These, and `LIGHT` of the numbers of the light sample at the same event.
    #[inline(always)]
    fn draws_with_light<const LIGHT: u8>(
        numbers: &PathNumbers8,
        event: u32,
    ) -> (LightDraws<U32x8, F32x8>, BsdfDraws<F32x8>) {
        numbers.light_and_bsdf::<LIGHT, ALL_WORDS>(event)
    }
    /// The materials that `material` names.
    fn load(materials: &[MaterialRecord], material: U32x8) -> Self;
    /// What textures multiply.
    fn color(&mut self) -> &mut Vec3x8;
    /// BSDF times cosine towards `wi`, and its density.
    fn evaluate(&self, wo: Vec3x8, wi: Vec3x8) -> Scattered;
    /// Draws directions.
    fn sample(&self, wo: Vec3x8, draws: &BsdfDraws<F32x8>) -> Sampled;
}

/// A kind that scatters to single directions.
pub trait Specular: Sized {
    /// The kind.
    const KIND: MaterialKind;
    /// The numbers that [`Specular::sample`] and roulette read; others hold anything.
    fn draws(numbers: &PathNumbers8, event: u32) -> BsdfDraws<F32x8>;
    /// The materials that `material` names.
    fn load(materials: &[MaterialRecord], material: U32x8) -> Self;
    /// Makes points on smooth surfaces and rays in directions `direction` fit each other; the directions to go by.
    fn orient(points: &mut SurfacePoints, direction: Vec3x8) -> Vec3x8;
    /// World directions to go on in, one for each of `incoming`, their weights, and the largest components of the albedos.
    /// `front`: lanes that hit fronts; `lobe` chooses where there are two.
    fn sample(&self, incoming: Vec3x8, normal: Vec3x8, front: Mask8, lobe: F32x8) -> (Vec3x8, Vec3x8, F32x8);
}
