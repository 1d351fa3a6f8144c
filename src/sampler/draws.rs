//! The numbers of a block by name, for one path and for eight.
//!
//! `NEEDED` of the lane versions says which words are read ([`sample_words_x8`]): the fields that need other words hold
//! anything.

use super::{CAMERA_BLOCK, bsdf_block, light_block, sample_words, sample_words_x8, unit, unit_x8};
use crate::lanes::{F32x8, Mask8, U32x8};
use crate::settings::Sampler;

/// Where the numbers of one path come from.
#[derive(Clone, Copy)]
pub struct PathNumbers {
    /// The sampler.
    pub sampler: Sampler,
    /// The seed.
    pub seed: u32,
    /// The pixel's address ([`super::pixel_address`]).
    pub pixel: u32,
    /// The sample's number.
    pub sample: u32,
}

/// Where the numbers of eight paths come from.
#[derive(Clone, Copy)]
pub struct PathNumbers8 {
    /// The sampler.
    pub sampler: Sampler,
    /// The seed.
    pub seed: u32,
    /// The pixels' addresses.
    pub pixel: U32x8,
    /// The samples' numbers.
    pub sample: U32x8,
}

/// A camera ray's numbers.
pub struct CameraDraws<T> {
    /// Where the ray goes through its pixel.
    pub film: [T; 2],
    /// Where it leaves the lens.
    pub lens: [T; 2],
}

/// A light sample's numbers; `W` is a word, `T` a number in [0, 1).
pub struct LightDraws<W, T> {
    /// Selects the light, with all 32 bits.
    pub select: W,
    /// The point on the light.
    pub point: [T; 2],
    /// The top bit is the coin of the one-sample strategy, the others are the fork, or roulette's.
    last: W,
}

/// A BSDF sample's numbers.
pub struct BsdfDraws<T> {
    /// Places the direction.
    pub direction: [T; 2],
    /// Chooses between lobes.
    pub lobe: T,
    /// Plays Russian roulette.
    pub roulette: T,
}

impl PathNumbers {
    /// Those of the camera ray.
    pub fn camera(&self) -> CameraDraws<f32> {
        let [a, b, c, d] = self.words(CAMERA_BLOCK).map(unit);
        CameraDraws { film: [a, b], lens: [c, d] }
    }
    /// Those of the light sample at scattering event `event`.
    pub fn light(&self, event: u32) -> LightDraws<u32, f32> {
        self.words(light_block(event)).into()
    }
    /// Those of the BSDF sample at scattering event `event`.
    pub fn bsdf(&self, event: u32) -> BsdfDraws<f32> {
        let [a, b, lobe, roulette] = self.words(bsdf_block(event)).map(unit);
        BsdfDraws { direction: [a, b], lobe, roulette }
    }
    fn words(&self, block: u32) -> [u32; 4] {
        sample_words(self.sampler, self.pixel, self.sample, block, self.seed)
    }
}

impl PathNumbers8 {
    /// Those of camera rays.
    #[inline(always)]
    pub fn camera<const NEEDED: u8>(&self) -> CameraDraws<F32x8> {
        let [a, b, c, d] = self.words::<NEEDED>(CAMERA_BLOCK).map(unit_x8);
        CameraDraws { film: [a, b], lens: [c, d] }
    }
    /// Those of light samples at scattering event `event`.
    #[inline(always)]
    pub fn light<const NEEDED: u8>(&self, event: u32) -> LightDraws<U32x8, F32x8> {
        self.words::<NEEDED>(light_block(event)).into()
    }
    /// Those of BSDF samples at scattering event `event`.
    #[inline(always)]
    pub fn bsdf<const NEEDED: u8>(&self, event: u32) -> BsdfDraws<F32x8> {
        let [a, b, lobe, roulette] = self.words::<NEEDED>(bsdf_block(event)).map(unit_x8);
        BsdfDraws { direction: [a, b], lobe, roulette }
    }
    #[inline(always)]
    fn words<const NEEDED: u8>(&self, block: u32) -> [U32x8; 4] {
        sample_words_x8::<NEEDED>(self.sampler, self.pixel, self.sample, block, self.seed)
    }
}

/// The words of a light block by name.
impl From<[u32; 4]> for LightDraws<u32, f32> {
    fn from(words: [u32; 4]) -> Self {
        LightDraws { select: words[0], point: [unit(words[1]), unit(words[2])], last: words[3] }
    }
}

/// The words of eight light blocks by name.
impl From<[U32x8; 4]> for LightDraws<U32x8, F32x8> {
    #[inline(always)]
    fn from(words: [U32x8; 4]) -> Self {
        LightDraws { select: words[0], point: [unit_x8(words[1]), unit_x8(words[2])], last: words[3] }
    }
}

impl LightDraws<u32, f32> {
    /// Whether the one-sample strategy's coin chooses the light sample.
    pub fn coin(&self) -> bool {
        unit(self.last) < 0.5
    }
    /// Chooses the texel of an environment map together with what choosing a light leaves of `select`.
    pub fn fork(&self) -> u32 {
        self.last << 1
    }
    /// Plays roulette of the shadow ray, if the sample went to an emitter: then nothing else reads these bits.
    pub fn roulette(&self) -> f32 {
        unit(self.last << 1)
    }
}

impl LightDraws<U32x8, F32x8> {
    /// Lanes in which the one-sample strategy's coin chooses the light sample.
    #[inline(always)]
    pub fn coin(&self) -> Mask8 {
        unit_x8(self.last).lt(F32x8::splat(0.5))
    }
    /// Chooses the texel of an environment map together with what choosing a light leaves of `select`.
    #[inline(always)]
    pub fn fork(&self) -> U32x8 {
        self.last << 1
    }
    /// Plays roulette of shadow rays, in lanes whose sample went to an emitter: there nothing else reads these bits.
    #[inline(always)]
    pub fn roulette(&self) -> F32x8 {
        unit_x8(self.last << 1)
    }
}
