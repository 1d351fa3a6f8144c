//! The `sobol` sampler: every block of numbers is a Sobol set of four dimensions of its own, shuffled and Owen-scrambled by
//! hashes, for one path and for eight (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020).
//!
//! **Groups.** Sample `k` is point `k / 4` of group `k % 4`. The four groups of a pixel are scrambled independently, so the
//! spread of their means tells the error of the picture, which the spread of samples does not: those of one group know of
//! each other.
//!
//! **Padding.** A block's shuffle and scrambles are drawn by PCG4D from (pixel, group, block, seed).
//! Blocks and pixels are therefore independent of each other; the points of one block and group are a net together.
//!
//! **Order.** The first two dimensions are the best pair (a (0, 2)-sequence: every 2^m points hit every elementary interval
//! once). They go to the 2-D decisions: words 0, 1 of camera and BSDF blocks, words 1, 2 of light blocks. The third makes
//! the decision beside it: which light, whether to go on.

use crate::lanes::U32x8;
use crate::sampler::{CAMERA_BLOCK, mix, mix_x8};

/// Independently scrambled groups that the samples of a pixel go to in turn.
pub const GROUPS: u32 = 4;

/// Rounds of PCG4D for the seeds of shuffles and scrambles, which are made of all their bits: two rounds leave structure
/// between neighbours in the low ones that tests/operations/sobol.rs sees.
const ROUNDS: u32 = 3;

/// Columns of the generator matrices: sample numbers have 32 bits, two of which name the group.
const COLUMNS: usize = 30;

/// Direction numbers: `DIRECTIONS[d][j]` is what bit `j` of a point's index adds (xor) to its coordinate `d`, most
/// significant digit in bit 31.
static DIRECTIONS: [[u32; COLUMNS]; 4] = [
    van_der_corput(),
    directions(&[1], &[]),
    directions(&[1, 3], &[true]),
    // Of the initial numbers that Sobol's construction allows here and above, 1, 3 and 1, 1, 3 have the least sum of t over
    // all projections and the first 2^m points, m up to 8 (61; the usual 1, 3 and 1, 3, 1 have 64), and no pair of 2^m
    // points of dimensions 2, 3 (a lens) below m = 4 with t above 0.
    directions(&[1, 1, 3], &[false, true]),
];

/// [`DIRECTIONS`], most significant digit in bit 0.
static MIRRORED: [[u32; COLUMNS]; 4] = mirrored();

/// Coordinates 0 to 3, digits mirrored, of what the lowest and the next four bits of an index add: eight digits at most.
const LOW: [[[u8; 16]; 2]; 4] = low();

/// Dimension 0: the index, mirrored at the binary point.
const fn van_der_corput() -> [u32; COLUMNS] {
    let mut numbers = [0; COLUMNS];
    let mut j = 0;
    while j < COLUMNS {
        numbers[j] = 1 << (31 - j);
        j += 1;
    }
    numbers
}

/// Sobol's recurrence (Bratley and Fox 1988, section 2; Joe and Kuo 2008, equation 3) for a primitive polynomial of degree
/// `initial.len()` whose coefficients between the first and the last are `inner`, from odd `initial` numbers.
const fn directions(initial: &[u32], inner: &[bool]) -> [u32; COLUMNS] {
    let degree = initial.len();
    let mut m = [0u32; COLUMNS];
    let mut numbers = [0; COLUMNS];
    let mut j = 0;
    while j < COLUMNS {
        if j < degree {
            m[j] = initial[j];
        } else {
            m[j] = m[j - degree] ^ m[j - degree] << degree;
            let mut i = 1;
            while i < degree {
                if inner[i - 1] {
                    m[j] ^= m[j - i] << i;
                }
                i += 1;
            }
        }
        numbers[j] = m[j] << (31 - j);
        j += 1;
    }
    numbers
}

const fn mirrored() -> [[u32; COLUMNS]; 4] {
    let mut mirrored = DIRECTIONS;
    let mut i = 0;
    while i < 4 * COLUMNS {
        mirrored[i / COLUMNS][i % COLUMNS] = DIRECTIONS[i / COLUMNS][i % COLUMNS].reverse_bits();
        i += 1;
    }
    mirrored
}

const fn low() -> [[[u8; 16]; 2]; 4] {
    let mut tables = [[[0; 16]; 2]; 4];
    let mut i = 0;
    while i < 4 * 2 * 16 * 4 {
        let (dimension, half, bits, bit) = (i / 128, i / 64 % 2, i / 4 % 16, i % 4);
        if bits >> bit & 1 == 1 {
            tables[dimension][half][bits] ^= DIRECTIONS[dimension][4 * half + bit].reverse_bits() as u8;
        }
        i += 1;
    }
    tables
}

/// Four numbers of one address: those of [`crate::sampler::random_words`], better spread.
pub fn sobol_words(pixel: u32, sample: u32, block: u32, seed: u32) -> [u32; 4] {
    let seeds = mix::<ROUNDS>(pixel, sample % GROUPS, block, seed);
    let index = shuffle(sample / GROUPS, seeds[0] ^ seeds[1] ^ seeds[2] ^ seeds[3]);
    in_order(block, std::array::from_fn(|dimension| owen_scramble(sobol(index, dimension), seeds[dimension])))
}

/// The words of a block by the dimensions that make them: the best pair where two numbers make one decision, the last
/// dimension where fewest decisions are made (lobes; an environment map's second choice).
#[inline(always)]
fn in_order<T>(block: u32, [a, b, c, d]: [T; 4]) -> [T; 4] {
    match block {
        CAMERA_BLOCK => [a, b, c, d],
        _ if block % 2 == 1 => [c, a, b, d],
        _ => [a, b, d, c],
    }
}

/// Coordinate `dimension` of point `index` of the Sobol sequence, as 32 binary digits.
fn sobol(index: u32, dimension: usize) -> u32 {
    let columns = DIRECTIONS[dimension].into_iter().enumerate();
    columns.filter(|(j, _)| index >> j & 1 == 1).fold(0, |sum, (_, column)| sum ^ column)
}

/// Owen's nested scrambling (Owen 1995): every digit is flipped or not, as a hash of the digits before it decides.
///
/// On mirrored digits a hash does so for all of them at once if it carries upwards only (Laine and Karras 2011). This one is
/// Vegdahl's ("Building a Better LK Hash", 2021), found by search for unbiased flips.
fn owen_scramble(digits: u32, seed: u32) -> u32 {
    let mut x = digits.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Levels of the tree of flips that one word holds.
const LEVELS: u32 = 5;

/// The order of the points: every bit of the index is flipped or not, as the bits above it decide, so that each aligned run
/// of 2^m points stays together: the first 2^m samples are the first 2^m points, in another order.
///
/// Flips come from a table, one word of 31 of them for every [`LEVELS`] bits: a hash that carries (as in
/// [`owen_scramble`]) would know 128 of the 2,048 orders of 16 points that the scrambles leave different; this has them all,
/// equally likely. Bits with nothing but 0 above them are not flipped: the scrambles make up for it, since an index
/// xor a constant is a point xor a constant, and few bits of the index are then left to multiply.
fn shuffle(index: u32, seed: u32) -> u32 {
    let mut shuffled = index;
    for bit in 0..u32::BITS - index.leading_zeros() {
        let above = index >> (bit + 1);
        if above == 0 {
            continue;
        }
        let (word, level) = (bit / LEVELS, LEVELS - 1 - bit % LEVELS);
        let flips = hash(seed, word, index >> (LEVELS * (word + 1)));
        let path = above & ((1 << level) - 1);
        shuffled ^= (flips >> (first_flip(level) + path) & 1) << bit;
    }
    shuffled
}

/// Where the `2^level` flips of a level begin in a word.
const fn first_flip(level: u32) -> u32 {
    32 - (2 << level)
}

/// The word of flips for [`LEVELS`] bits of an index below `prefix`: Wellons' "lowbias32" (hash-prospector, 2018).
fn hash(seed: u32, word: u32, prefix: u32) -> u32 {
    let mut x = seed.wrapping_add(prefix.wrapping_mul(0x9e37_79b9)).wrapping_add(word << 27);
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// [`sobol_words`] for eight addresses that share block and seed; same bits. Only the dimensions of the block whose bit in
/// `NEEDED` is set are made; the words of the others hold anything.
// Not inlined: stages stay small, and what runs without it stays as it is.
#[inline(never)]
pub fn sobol_words_x8<const NEEDED: u8>(pixel: U32x8, sample: U32x8, block: u32, seed: u32) -> [U32x8; 4] {
    let seeds = mix_x8::<ROUNDS>(pixel, sample & U32x8::splat(GROUPS - 1), block, seed);
    let index = shuffle_x8(sample >> GROUPS.ilog2(), seeds[0] ^ seeds[1] ^ seeds[2] ^ seeds[3]);
    let half = U32x8::splat(15);
    let (low, next) = (index & half, index >> 4 & half);
    let mut points = [index, U32x8::ZERO, U32x8::ZERO, U32x8::ZERO];
    for dimension in 1..4 {
        if NEEDED >> dimension & 1 == 1 {
            points[dimension] = low.look_up_bytes(LOW[dimension][0]) ^ next.look_up_bytes(LOW[dimension][1]);
        }
    }
    if !(index >> 8).eq(U32x8::ZERO).all() {
        add_high_columns(index, &mut points);
    }
    for dimension in 0..4 {
        if NEEDED >> dimension & 1 == 1 {
            points[dimension] = owen_scramble_x8(points[dimension], seeds[dimension]);
        }
    }
    in_order(block, points)
}

/// Adds what the bits of the index above the lowest eight do to coordinates 1 and on.
#[inline(never)]
fn add_high_columns(index: U32x8, points: &mut [U32x8; 4]) {
    let (mut rest, mut j) = (index >> 8, 8);
    while !rest.eq(U32x8::ZERO).all() {
        let taken = U32x8::ZERO - (rest & U32x8::splat(1));
        for (point, columns) in points.iter_mut().zip(&MIRRORED).skip(1) {
            *point = *point ^ taken & U32x8::splat(columns[j]);
        }
        (rest, j) = (rest >> 1, j + 1);
    }
}

/// [`owen_scramble`] of mirrored digits.
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

/// [`shuffle`] of eight indices, [`LEVELS`] bits at a time.
#[inline(always)]
fn shuffle_x8(index: U32x8, seed: U32x8) -> U32x8 {
    let mut shuffled = index ^ flips_x8(index, seed, 0);
    if !(index >> LEVELS).eq(U32x8::ZERO).all() {
        flip_high_bits(&mut shuffled, index, seed);
    }
    shuffled
}

/// The flips above the lowest [`LEVELS`] bits.
#[inline(never)]
fn flip_high_bits(shuffled: &mut U32x8, index: U32x8, seed: U32x8) {
    let (mut rest, mut word) = (index >> LEVELS, 1);
    while !rest.eq(U32x8::ZERO).all() {
        *shuffled = *shuffled ^ flips_x8(rest, seed, word) << (LEVELS * word);
        (rest, word) = (rest >> LEVELS, word + 1);
    }
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

/// [`hash`] for eight.
#[inline(always)]
fn hash_x8(seed: U32x8, word: u32, prefix: U32x8) -> U32x8 {
    let mut x = seed + prefix * U32x8::splat(0x9e37_79b9) + U32x8::splat(word << 27);
    x = x ^ x >> 16;
    x = x * U32x8::splat(0x7feb_352d);
    x = x ^ x >> 15;
    x = x * U32x8::splat(0x846c_a68b);
    x ^ x >> 16
}
