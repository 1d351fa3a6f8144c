//! The numbers of a block by name, for eight paths.
//!
//! `NEEDED` says which words are read ([`sample_words_x8`]): the fields that need other words hold anything.

use super::here;
use super::{sample_words_of_two, sample_words_x8, unit_x8};
use crate::sampler::draws::{BsdfDraws, CameraDraws, LightDraws};
use crate::sampler::{CAMERA_BLOCK, bsdf_block, light_block};
use crate::settings::Sampler;
use here::lanes::{Each, F32x8, Mask8, U32x8};

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

impl PathNumbers8 {
    /// Those of camera rays.
    #[inline(always)]
    pub fn camera<const NEEDED: u8>(&self) -> CameraDraws<F32x8> {
        let [a, b, c, d] = self.words::<NEEDED>(CAMERA_BLOCK).each(
            #[inline(always)]
            |word| unit_x8(word),
        );
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
        self.words::<NEEDED>(bsdf_block(event)).into()
    }
    /// Those of light and BSDF samples at scattering event `event`, `LIGHT` and `BSDF` of their words: drawn together, since two
    /// blocks take hardly longer than one.
    #[inline(always)]
    pub fn light_and_bsdf<const LIGHT: u8, const BSDF: u8>(
        &self,
        event: u32,
    ) -> (LightDraws<U32x8, F32x8>, BsdfDraws<F32x8>) {
        let blocks = [light_block(event), bsdf_block(event)];
        let [light, bsdf] =
            sample_words_of_two::<LIGHT, BSDF>(self.sampler, self.pixel, self.sample, blocks, self.seed);
        (light.into(), bsdf.into())
    }
    #[inline(always)]
    fn words<const NEEDED: u8>(&self, block: u32) -> [U32x8; 4] {
        sample_words_x8::<NEEDED>(self.sampler, self.pixel, self.sample, block, self.seed)
    }
}

/// The words of eight light blocks by name.
impl From<[U32x8; 4]> for LightDraws<U32x8, F32x8> {
    #[inline(always)]
    fn from(words: [U32x8; 4]) -> Self {
        LightDraws { select: words[0], point: [unit_x8(words[1]), unit_x8(words[2])], last: words[3] }
    }
}

/// The words of eight BSDF blocks by name.
impl From<[U32x8; 4]> for BsdfDraws<F32x8> {
    #[inline(always)]
    fn from(words: [U32x8; 4]) -> Self {
        let [a, b, lobe, roulette] = words.each(
            #[inline(always)]
            |word| unit_x8(word),
        );
        BsdfDraws { direction: [a, b], lobe, roulette }
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
