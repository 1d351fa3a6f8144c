//! Random numbers with an address: (pixel, sample, block, seed) gives four numbers, for one path and for eight.
//!
//! The `independent` sampler is the counter-based generator PCG4D of Jarzynski and Olano, "Hash Functions for GPU
//! Rendering" (JCGT 9(3), 2020): four words in, four well-mixed words out, nothing remembered. A number is a function of
//! its address alone, so both engines, every tile order and every thread count draw the same.
//!
//! **Addresses.** `pixel` is `y << 16 | x` in the whole film (a crop draws what the whole picture would). Block 0 belongs
//! to the camera; event `d` (the d-th scattering event, from 0) owns the light block `1 + 2d` and the BSDF block `2 + 2d`.
//!
//! What draws for eight paths is compiled once a SIMD level, as part of [`crate::simd`] (folder `lanes`).
//!
//! The `sobol` sampler ([`sobol`]) has the same addresses and spreads the numbers of one address over samples better.

pub mod draws;
pub mod sobol;

use crate::settings::Sampler;
use sobol::sobol_words;

/// The block of the camera: numbers 0, 1 place the ray in the pixel, 2, 3 on the lens.
pub const CAMERA_BLOCK: u32 = 0;

/// The light block of scattering event `event`: 0 selects the light (all 32 bits), 1, 2 the point on it; the top bit of 3 is
/// the coin of the one-sample strategy, its other bits choose a texel of an environment map together with word 0.
#[inline(always)]
pub fn light_block(event: u32) -> u32 {
    1 + 2 * event
}

/// The BSDF block of scattering event `event`: 0, 1 the direction, 2 the lobe, 3 Russian roulette.
#[inline(always)]
pub fn bsdf_block(event: u32) -> u32 {
    2 + 2 * event
}

/// The pixel word of an address; coordinates below 65,536.
#[inline(always)]
pub fn pixel_address(x: u32, y: u32) -> u32 {
    y << 16 | x
}

/// Four words for one address by `sampler`: uniform over all 32 bits, each.
#[inline]
pub fn sample_words(sampler: Sampler, pixel: u32, sample: u32, block: u32, seed: u32) -> [u32; 4] {
    match sampler {
        Sampler::Independent => random_words(pixel, sample, block, seed),
        Sampler::Sobol => sobol_words(pixel, sample, block, seed),
    }
}

/// Which words of a block are read, for the versions on lanes: all of them.
pub const ALL_WORDS: u8 = 0b1111;
/// Words 0, 1 of a camera block: there is no lens.
pub const PIXEL_WORDS: u8 = 0b0011;
/// Words 0, 1, 2 of a light block: the light and the point on it.
pub const LIGHT_WORDS: u8 = 0b0111;
/// Words 0, 1, 3 of a BSDF block: the direction and roulette.
pub const DIRECTION_WORDS: u8 = 0b0111;
/// Words 2, 3 of a BSDF block: the lobe and roulette.
pub const LOBE_WORDS: u8 = 0b1100;
/// Word 3 of a BSDF block: roulette.
pub const ROULETTE_WORD: u8 = 0b0100;

/// Four random words for one address (PCG4D).
#[inline]
pub fn random_words(pixel: u32, sample: u32, block: u32, seed: u32) -> [u32; 4] {
    mix::<2>(pixel, sample, block, seed)
}

/// PCG4D. After the two rounds of the paper the upper bits of the words are well mixed, after three all of them are.
#[inline(always)]
pub(crate) fn mix<const ROUNDS: u32>(pixel: u32, sample: u32, block: u32, seed: u32) -> [u32; 4] {
    let step = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let [mut x, mut y, mut z, mut w] = [step(pixel), step(sample), step(block), step(seed)];
    for round in 0..ROUNDS {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        if round + 1 < ROUNDS {
            [x, y, z, w] = [x, y, z, w].map(|v| v ^ v >> 16);
        }
    }
    [x, y, z, w]
}

/// The upper 24 bits of a word as a number in [0, 1).
#[inline(always)]
pub fn unit(word: u32) -> f32 {
    (word >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// An index below `count` from all 32 bits of a word (`word * count / 2^32`): every index within 2^-32 of `1 / count`.
#[inline(always)]
pub fn index_below(word: u32, count: u32) -> u32 {
    ((word as u64 * count as u64) >> 32) as u32
}
