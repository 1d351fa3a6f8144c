//! Numbers for eight addresses at a time: the lanes of [`crate::sampler`], same bits. Compiled once a SIMD level
//! ([`crate::simd`]).

use super::here;
use crate::settings::Sampler;
use here::lanes::{Each, F32x8, U32x8};

pub mod draws;
pub mod sobol;

use sobol::{sobol_words_of_two, sobol_words_x8};

/// [`crate::sampler::sample_words`] for eight addresses that share block and seed; same bits. `NEEDED` is one of the
/// constants of [`crate::sampler`] (a bit for every dimension of [`sobol`]); other words than those hold anything.
#[inline(always)]
pub fn sample_words_x8<const NEEDED: u8>(
    sampler: Sampler,
    pixel: U32x8,
    sample: U32x8,
    block: u32,
    seed: u32,
) -> [U32x8; 4] {
    match sampler {
        Sampler::Independent => random_words_x8(pixel, sample, block, seed),
        Sampler::Sobol => sobol_words_x8::<NEEDED>(pixel, sample, block, seed),
    }
}

/// [`sample_words_x8`] of two blocks, `A` and `B` of their words needed.
#[inline(always)]
pub fn sample_words_of_two<const A: u8, const B: u8>(
    sampler: Sampler,
    pixel: U32x8,
    sample: U32x8,
    blocks: [u32; 2],
    seed: u32,
) -> [[U32x8; 4]; 2] {
    match sampler {
        Sampler::Independent => blocks.each(
            #[inline(always)]
            |block| random_words_x8(pixel, sample, block, seed),
        ),
        Sampler::Sobol => sobol_words_of_two::<A, B>(pixel, sample, blocks, seed),
    }
}

/// [`crate::sampler::random_words`] for eight addresses that share block and seed; same bits.
#[inline(always)]
pub fn random_words_x8(pixel: U32x8, sample: U32x8, block: u32, seed: u32) -> [U32x8; 4] {
    mix_x8::<2>(pixel, sample, block, seed)
}

/// PCG4D for eight addresses.
#[inline(always)]
fn mix_x8<const ROUNDS: u32>(pixel: U32x8, sample: U32x8, block: u32, seed: u32) -> [U32x8; 4] {
    let step = |v: U32x8| v * U32x8::splat(1_664_525) + U32x8::splat(1_013_904_223);
    let (mut x, mut y) = (step(pixel), step(sample));
    let (mut z, mut w) = (step(U32x8::splat(block)), step(U32x8::splat(seed)));
    for round in 0..ROUNDS {
        x = x + y * w;
        y = y + z * x;
        z = z + x * y;
        w = w + y * z;
        if round + 1 < ROUNDS {
            [x, y, z, w] = [x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16), w ^ (w >> 16)];
        }
    }
    [x, y, z, w]
}

/// [`crate::sampler::unit()`] for eight words; same bits.
#[inline(always)]
pub fn unit_x8(word: U32x8) -> F32x8 {
    (word >> 8).to_f32() * F32x8::splat(1.0 / 16_777_216.0)
}
