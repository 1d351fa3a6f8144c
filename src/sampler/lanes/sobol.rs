//! The `sobol` sampler for eight addresses at a time: the lanes of [`crate::sampler::sobol`], same bits.

use super::{here, mix_x8};
use crate::sampler::sobol::{GROUPS, LEVELS, LOW, MIRRORED, ROUNDS, first_flip, in_order};
use here::lanes::U32x8;

/// [`crate::sampler::sobol::sobol_words`] for eight addresses that share block and seed; same bits. Only the dimensions of
/// the block whose bit in `NEEDED` is set are made; the words of the others hold anything.
// Not inlined: stages stay small, and what runs without it stays as it is.
#[inline(never)]
pub fn sobol_words_x8<const NEEDED: u8>(pixel: U32x8, sample: U32x8, block: u32, seed: u32) -> [U32x8; 4] {
    here::run(
        #[inline(always)]
        || {
            let [words] = words_of_blocks(pixel, sample, [(block, NEEDED)], seed);
            words
        },
    )
}

/// [`sobol_words_x8`] of two blocks at once, `A` and `B` of them needed. A block is a chain of some 120 cycles in which the
/// CPU has little else to do: two chains take hardly longer than one.
#[inline(never)]
pub fn sobol_words_of_two<const A: u8, const B: u8>(
    pixel: U32x8,
    sample: U32x8,
    blocks: [u32; 2],
    seed: u32,
) -> [[U32x8; 4]; 2] {
    here::run(
        #[inline(always)]
        || words_of_blocks(pixel, sample, [(blocks[0], A), (blocks[1], B)], seed),
    )
}

/// The words of some blocks, each with the dimensions of it that are needed, step by step for all of them.
#[inline(always)]
fn words_of_blocks<const N: usize>(pixel: U32x8, sample: U32x8, blocks: [(u32, u8); N], seed: u32) -> [[U32x8; 4]; N] {
    let group = sample & U32x8::splat(GROUPS - 1);
    let (mut seeds, mut keys) = ([[U32x8::ZERO; 4]; N], [U32x8::ZERO; N]);
    for k in 0..N {
        seeds[k] = mix_x8::<ROUNDS>(pixel, group, blocks[k].0, seed);
        keys[k] = seeds[k][0] ^ seeds[k][1] ^ seeds[k][2] ^ seeds[k][3];
    }
    let index = shuffled(sample >> GROUPS.ilog2(), keys);
    let half = U32x8::splat(15);
    let mut points = [[U32x8::ZERO; 4]; N];
    for k in 0..N {
        points[k][0] = index[k];
        let (low, next) = (index[k] & half, index[k] >> 4 & half);
        for dimension in 1..4 {
            if blocks[k].1 >> dimension & 1 == 1 {
                points[k][dimension] = low.look_up_bytes(LOW[dimension][0]) ^ next.look_up_bytes(LOW[dimension][1]);
            }
        }
    }
    // Shuffling leaves the highest bit of an index where it is: all blocks have such bits, or none.
    if !(index[0] >> 8).eq(U32x8::ZERO).all() {
        for k in 0..N {
            add_high_columns(index[k], &mut points[k]);
        }
    }
    for k in 0..N {
        for dimension in 0..4 {
            if blocks[k].1 >> dimension & 1 == 1 {
                points[k][dimension] = owen_scramble_x8(points[k][dimension], seeds[k][dimension]);
            }
        }
    }
    for k in 0..N {
        points[k] = in_order(blocks[k].0, points[k]);
    }
    points
}

/// Adds what the bits of the index above the lowest eight do to coordinates 1 and on.
#[inline(never)]
fn add_high_columns(index: U32x8, points: &mut [U32x8; 4]) {
    here::run(
        #[inline(always)]
        || {
            let (mut rest, mut j) = (index >> 8, 8);
            while !rest.eq(U32x8::ZERO).all() {
                let taken = U32x8::ZERO - (rest & U32x8::splat(1));
                for (point, columns) in points.iter_mut().zip(&MIRRORED).skip(1) {
                    *point = *point ^ taken & U32x8::splat(columns[j]);
                }
                (rest, j) = (rest >> 1, j + 1);
            }
        },
    )
}

/// [`crate::sampler::sobol::owen_scramble`] of mirrored digits.
#[inline(always)]
fn owen_scramble_x8(mirrored: U32x8, seed: U32x8) -> U32x8 {
    let mut x = mirrored;
    x = x ^ (x * U32x8::splat(0x3d20_adea));
    x = x + seed;
    x = x * (seed >> 16 | U32x8::splat(1));
    x = x ^ (x * U32x8::splat(0x0552_6c56));
    x = x ^ (x * U32x8::splat(0x53a2_2864));
    x.reverse_bits()
}

/// [`crate::sampler::sobol::shuffle`] of eight indices, [`LEVELS`] bits at a time, by some keys.
#[inline(always)]
fn shuffled<const N: usize>(index: U32x8, keys: [U32x8; N]) -> [U32x8; N] {
    let mut shuffled = [index; N];
    for k in 0..N {
        shuffled[k] = index ^ flips_x8(index, keys[k], 0);
    }
    if !(index >> LEVELS).eq(U32x8::ZERO).all() {
        for k in 0..N {
            flip_high_bits(&mut shuffled[k], index, keys[k]);
        }
    }
    shuffled
}

/// The flips above the lowest [`LEVELS`] bits.
#[inline(never)]
fn flip_high_bits(shuffled: &mut U32x8, index: U32x8, seed: U32x8) {
    here::run(
        #[inline(always)]
        || {
            let (mut rest, mut word) = (index >> LEVELS, 1);
            while !rest.eq(U32x8::ZERO).all() {
                *shuffled = *shuffled ^ flips_x8(rest, seed, word) << (LEVELS * word);
                (rest, word) = (rest >> LEVELS, word + 1);
            }
        },
    )
}

/// Which of the lowest [`LEVELS`] bits of `rest` are flipped: the index without the bits of earlier words.
#[inline(always)]
fn flips_x8(rest: U32x8, seed: U32x8, word: u32) -> U32x8 {
    /// The flips of bits with nothing but 0 above them, in a word without prefix.
    const UNUSED: u32 = 1 << first_flip(0) | 1 << first_flip(1) | 1 << first_flip(2) | 1 << first_flip(3) | 1;
    let prefix = rest >> LEVELS;
    let used = prefix.eq(U32x8::ZERO).select_u32(U32x8::splat(!UNUSED), U32x8::splat(u32::MAX));
    let (flips, bits) = (hash_x8(seed, word, prefix) & used, rest & U32x8::splat((1 << LEVELS) - 1));
    let mut flipped = U32x8::ZERO;
    for level in 0..LEVELS {
        let bit = LEVELS - 1 - level;
        // The flip lands on the bit that it is for.
        let shift = (bits >> (bit + 1)) + U32x8::splat(first_flip(level) - bit);
        flipped = flipped | flips.shift_right_each(shift) & U32x8::splat(1 << bit);
    }
    flipped
}

/// [`crate::sampler::sobol::hash`] for eight.
#[inline(always)]
fn hash_x8(seed: U32x8, word: u32, prefix: U32x8) -> U32x8 {
    let mut x = seed + prefix * U32x8::splat(0x9e37_79b9) + U32x8::splat(word << 27);
    x = x ^ x >> 16;
    x = x * U32x8::splat(0x7feb_352d);
    x = x ^ x >> 15;
    x = x * U32x8::splat(0x846c_a68b);
    x ^ x >> 16
}
