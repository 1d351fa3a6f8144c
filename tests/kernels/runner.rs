//! The runner: a kernel on lanes and its scalar twin over one table of seeds, for all 256 patterns of live lanes, with the
//! idle ones poisoned.

use octray::internal::lanes::{F32x8, LANES, Vec3x8};
use octray::internal::reference::single::Vec3;
use octray::internal::sampler::{random_words, unit};

/// Numbers at the edges of arithmetic: signed zeros, denormals, both infinities, NaN, and some ordinary ones between.
pub const EDGES: [f32; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::from_bits(1),
    -f32::from_bits(1),
    f32::from_bits(0x007f_ffff),
    f32::MIN_POSITIVE,
    f32::EPSILON,
    1.0 - f32::EPSILON / 2.0,
    0.5,
    -0.5,
    1.5,
    0.1,
    -3.0,
    1e-20,
    -1e20,
    16_777_216.0,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    -f32::NAN,
];

/// What idle lanes hold, in turns.
const POISON: [f32; 5] = [f32::NAN, f32::INFINITY, -1e30, f32::from_bits(0xdead_beef), f32::from_bits(1)];

/// The random numbers of seed `i`, from the crate's own generator, by the number of the argument.
fn word(i: u32, argument: u32) -> u32 {
    random_words(i, argument / 4, 0, 99)[(argument % 4) as usize]
}

/// Anything: half of the seeds are at the edges, in changing company; a quarter are any bits at all.
pub fn anything(i: u32, argument: u32) -> f32 {
    let word = word(i, argument);
    match word >> 30 {
        0 | 1 => EDGES[word as usize % EDGES.len()],
        2 => f32::from_bits(word.wrapping_mul(747_796_405)),
        _ => 4.0 * unit(word << 2) - 2.0,
    }
}

/// A sample number, of [0, 1): every fourth at an edge of that.
pub fn number(i: u32, argument: u32) -> f32 {
    let word = word(i, argument);
    let edges = [0.0, f32::from_bits(1), f32::MIN_POSITIVE, 0.25, 0.5, 0.75, 1.0 - f32::EPSILON / 2.0];
    if word >> 30 == 0 { edges[word as usize % edges.len()] } else { unit(word << 2) }
}

/// A unit vector: every fourth along an axis, zeros of both signs.
pub fn direction(i: u32, argument: u32) -> [f32; 3] {
    let [a, b, c] = [0, 1, 2].map(|k| 2.0 * unit(word(i, argument + k)) - 1.0);
    let axes = [[0.0, 0.0, 1.0], [-0.0, 0.0, -1.0], [1.0, -0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, -0.0]];
    let word = word(i, argument + 3);
    if word >> 30 == 0 { axes[word as usize % axes.len()] } else { Vec3::new(a, b, c).normalize().to_array() }
}

/// What the lanes hold that no live row fills.
#[derive(Clone, Copy, PartialEq)]
pub enum Idle {
    /// NaN, infinity and garbage.
    Poison,
    /// A live row, as in the queues: for kernels that read tables.
    Repeat,
}

/// A kernel beside its twin. Both take `N` numbers and give `M`.
pub struct Kernel<'a, const N: usize, const M: usize> {
    /// For messages.
    pub name: &'a str,
    /// The arguments of seed `i`.
    pub seed: &'a dyn Fn(u32) -> [f32; N],
    /// On lanes.
    pub lanes: &'a dyn Fn([F32x8; N]) -> [F32x8; M],
    /// On plain numbers.
    pub scalar: &'a dyn Fn([f32; N]) -> [f32; M],
    /// What idle lanes hold.
    pub idle: Idle,
}

/// Equal bits, or both NaN (whose payload no operation promises).
fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

/// Checks a kernel: 32 packets of seeds for each of the 255 patterns with a live lane, none of which may feel the others.
pub fn check<const N: usize, const M: usize>(kernel: &Kernel<N, M>) {
    for bits in 1..=255u32 {
        for packet in 0..32 {
            let seeds: [u32; LANES] = std::array::from_fn(|lane| (bits * 32 + packet) * LANES as u32 + lane as u32);
            let live = |lane: usize| bits >> lane & 1 == 1;
            let first = seeds[bits.trailing_zeros() as usize];
            let rows: [[f32; N]; LANES] = std::array::from_fn(|lane| match (live(lane), kernel.idle) {
                (true, _) => (kernel.seed)(seeds[lane]),
                (false, Idle::Repeat) => (kernel.seed)(first),
                (false, Idle::Poison) => std::array::from_fn(|n| POISON[(n + lane + packet as usize) % POISON.len()]),
            });
            let got = (kernel.lanes)(std::array::from_fn(|n| F32x8::from_array(rows.map(|row| row[n]))));
            let got = got.map(F32x8::to_array);
            for lane in (0..LANES).filter(|&lane| live(lane)) {
                let wanted = (kernel.scalar)(rows[lane]);
                for m in 0..M {
                    let (got, wanted) = (got[m][lane], wanted[m]);
                    let (name, row) = (kernel.name, rows[lane]);
                    assert!(
                        same(got, wanted),
                        "{name}, result {m}, lane {lane} of {bits:08b}: {got:e}, not {wanted:e}, of {row:?}"
                    );
                }
            }
        }
    }
}

/// The vector that three of the numbers make.
pub fn lanes3(v: &[F32x8]) -> Vec3x8 {
    Vec3x8::new(v[0], v[1], v[2])
}

/// The numbers of a vector.
pub fn columns(v: Vec3x8) -> [F32x8; 3] {
    [v.x, v.y, v.z]
}

/// The vector that three of the numbers make.
pub fn vec3(v: &[f32]) -> Vec3 {
    Vec3::from_slice(v)
}

/// Two lists of numbers as one.
pub fn both<T: Copy, const A: usize, const B: usize, const AB: usize>(a: [T; A], b: [T; B]) -> [T; AB] {
    std::array::from_fn(|i| if i < A { a[i] } else { b[i - A] })
}

/// The sum of two numbers, judged against `lanes`.
fn check_sum(lanes: &dyn Fn([F32x8; 2]) -> [F32x8; 1]) {
    let seed = |i| [anything(i, 0), anything(i, 1)];
    check(&Kernel { name: "sum", seed: &seed, lanes, scalar: &|[a, b]| [a + b], idle: Idle::Poison });
}

#[test]
fn a_right_kernel_passes() {
    check_sum(&|[a, b]| [a + b]);
}

#[test]
#[should_panic = "sum, result 0"]
fn a_lost_sign_of_zero_is_seen() {
    check_sum(&|[a, b]| [a + b + F32x8::ZERO]);
}

#[test]
#[should_panic = "sum, result 0"]
fn a_lane_that_feels_its_neighbours_is_seen() {
    // What idle lanes hold reaches the live ones.
    check_sum(&|[a, b]| [a + b + F32x8::splat(a.to_array().iter().map(|a| a - a).sum())]);
}
