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

use crate::sampler::{CAMERA_BLOCK, mix};

/// Independently scrambled groups that the samples of a pixel go to in turn.
pub const GROUPS: u32 = 4;

/// Rounds of PCG4D for the seeds of shuffles and scrambles, which are made of all their bits: two rounds leave structure
/// between neighbours in the low ones that tests/operations/sobol.rs sees.
pub(crate) const ROUNDS: u32 = 3;

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
pub(crate) static MIRRORED: [[u32; COLUMNS]; 4] = mirrored();

/// Coordinates 0 to 3, digits mirrored, of what the lowest and the next four bits of an index add: eight digits at most.
pub(crate) const LOW: [[[u8; 16]; 2]; 4] = low();

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
pub(crate) fn in_order<T>(block: u32, [a, b, c, d]: [T; 4]) -> [T; 4] {
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
pub(crate) const LEVELS: u32 = 5;

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
pub(crate) const fn first_flip(level: u32) -> u32 {
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
