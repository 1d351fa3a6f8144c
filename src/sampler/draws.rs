//! The numbers of a block by name.

use super::{CAMERA_BLOCK, bsdf_block, light_block, sample_words, unit};
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
    pub(crate) last: W,
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

/// The words of a light block by name.
impl From<[u32; 4]> for LightDraws<u32, f32> {
    fn from(words: [u32; 4]) -> Self {
        LightDraws { select: words[0], point: [unit(words[1]), unit(words[2])], last: words[3] }
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
