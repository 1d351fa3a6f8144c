//! Eight lanes of `f32` and `u32`: the only file of the crate that names `wide`.
//!
//! Only operations that every x86-64 level rounds alike are offered (`+ - * / sqrt floor`, comparisons, integer and bit
//! operations), so code built on these types computes the same bits in an SSE2, an AVX2 and an AVX-512 build, and the
//! same bits as plain `f32` code that performs the same operations in the same order.
//!
//! **Invariant:** lane `i` of a result depends on lane `i` of the operands alone, except in the functions that say
//! otherwise in their first line (`compress`, `transpose`, `gather`, reductions).

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};
use wide::{f32x8, i32x8, u8x32, u32x8};

/// Lanes in a packet.
pub const LANES: usize = 8;

/// Eight `f32`.
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct F32x8(f32x8);

/// Eight `u32`; arithmetic wraps.
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct U32x8(u32x8);

/// Eight booleans, kept as vectors: every lane is all ones (true) or all zeros (false).
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct Mask8(f32x8);

/// Eight vectors, one array a component.
#[derive(Clone, Copy, Default)]
pub struct Vec3x8 {
    /// First components.
    pub x: F32x8,
    /// Second components.
    pub y: F32x8,
    /// Third components.
    pub z: F32x8,
}

macro_rules! binary_operator {
    ($type:ident, $trait:ident, $function:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    };
}
binary_operator!(F32x8, Add, add);
binary_operator!(F32x8, Sub, sub);
binary_operator!(F32x8, Mul, mul);
binary_operator!(F32x8, Div, div);
binary_operator!(U32x8, Add, add);
binary_operator!(U32x8, Sub, sub);
binary_operator!(U32x8, Mul, mul);
binary_operator!(U32x8, BitAnd, bitand);
binary_operator!(U32x8, BitOr, bitor);
binary_operator!(U32x8, BitXor, bitxor);
binary_operator!(Mask8, BitAnd, bitand);
binary_operator!(Mask8, BitOr, bitor);
binary_operator!(Mask8, BitXor, bitxor);

impl Neg for F32x8 {
    type Output = Self;
    /// Flips the sign bit (so `-0.0` of `0.0`, and of NaN its sign), as scalar negation does.
    #[inline(always)]
    fn neg(self) -> Self {
        F32x8::from_bits(self.to_bits() ^ U32x8::splat(0x8000_0000))
    }
}

impl F32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self(f32x8::ZERO);
    /// Eight ones.
    pub const ONE: Self = Self(f32x8::ONE);

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self(f32x8::splat(value))
    }
    /// Lane `i` is `values[i]`.
    #[inline(always)]
    pub fn from_array(values: [f32; LANES]) -> Self {
        Self(f32x8::new(values))
    }
    /// `[i]` is lane `i`.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        self.0.to_array()
    }
    /// Lane `i` is `values[first + i]`; panics if fewer than eight are left.
    #[inline(always)]
    pub fn load(values: &[f32], first: usize) -> Self {
        let block: &[f32; LANES] = values[first..first + LANES].try_into().expect("eight values");
        Self::from_array(*block)
    }
    /// `values[first + i]` becomes lane `i`; panics if there is no room for eight.
    #[inline(always)]
    pub fn store(self, values: &mut [f32], first: usize) {
        let block: &mut [f32; LANES] = (&mut values[first..first + LANES]).try_into().expect("eight values");
        *block = self.to_array();
    }
    /// The bit patterns.
    #[inline(always)]
    pub fn to_bits(self) -> U32x8 {
        U32x8(bytemuck::cast(self.0))
    }
    /// Values of the given bit patterns.
    #[inline(always)]
    pub fn from_bits(bits: U32x8) -> Self {
        Self(bytemuck::cast(bits.0))
    }
    /// Absolute value (clears the sign bit).
    #[inline(always)]
    pub fn abs(self) -> Self {
        F32x8::from_bits(self.to_bits() & U32x8::splat(0x7fff_ffff))
    }
    /// Square root, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    /// The largest whole number that is not larger: exact.
    #[inline(always)]
    pub fn floor(self) -> Self {
        Self(self.0.floor())
    }
    /// `if self < other { self } else { other }`, the crate's one definition ([`crate::math::min`]).
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            // `minps` is that definition, signed zeros and NaN included (tests/lanes.rs tries every pair).
            Self(self.0.fast_min(other.0))
        } else {
            self.lt(other).select(self, other)
        }
    }
    /// `if self > other { self } else { other }`, the crate's one definition ([`crate::math::max`]).
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") { Self(self.0.fast_max(other.0)) } else { self.gt(other).select(self, other) }
    }
    /// `self < other`, false where either is NaN.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_lt(other.0))
    }
    /// `self <= other`, false where either is NaN.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_le(other.0))
    }
    /// `self > other`, false where either is NaN.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_gt(other.0))
    }
    /// `self >= other`, false where either is NaN.
    #[inline(always)]
    pub fn ge(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_ge(other.0))
    }
    /// `self == other` (`-0.0 == 0.0`), false where either is NaN.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8 {
        Mask8(self.0.simd_eq(other.0))
    }
    /// Magnitudes of `self`, sign bits of `sign`.
    #[inline(always)]
    pub fn copysign(self, sign: Self) -> Self {
        let top = U32x8::splat(0x8000_0000);
        F32x8::from_bits((self.to_bits() & U32x8::splat(0x7fff_ffff)) | (sign.to_bits() & top))
    }
    /// `self * factor + addend`, fused where this build has FMA, else rounded twice: **not the same bits in every build**,
    /// so only for what cannot change a result (conservative box tests, statistics).
    #[inline(always)]
    pub fn loose_mul_add(self, factor: Self, addend: Self) -> Self {
        Self(self.0.mul_add(factor.0, addend.0))
    }
    /// `self * factor - subtrahend`, under the law of [`F32x8::loose_mul_add`].
    #[inline(always)]
    pub fn loose_mul_sub(self, factor: Self, subtrahend: Self) -> Self {
        Self(self.0.mul_sub(factor.0, subtrahend.0))
    }
    /// Crosses lanes: the lanes of `mask` (bit `i`: lane `i`) move to the front in order; what follows them is unspecified.
    #[inline(always)]
    pub fn compress(self, mask: u8) -> Self {
        F32x8::from_bits(self.to_bits().compress(mask))
    }
    /// Crosses lanes: the least value, which must not be NaN in any lane; of -0 and +0 either.
    #[inline(always)]
    pub fn min_of_lanes(self) -> f32 {
        let swap = |v: Self, partners: [u32; LANES]| v.min(v.permute(U32x8::from_array(partners)));
        let halves = swap(self, [4, 5, 6, 7, 0, 1, 2, 3]);
        let quarters = swap(halves, [2, 3, 0, 1, 6, 7, 4, 5]);
        swap(quarters, [1, 0, 3, 2, 5, 4, 7, 6]).to_array()[0]
    }
    /// Crosses lanes: `rows[i]` lane `j` goes to result `j` lane `i`.
    #[inline(always)]
    pub fn transpose(rows: [F32x8; LANES]) -> [F32x8; LANES] {
        f32x8::transpose(rows.map(|row| row.0)).map(F32x8)
    }
    /// Crosses lanes: lane `i` becomes lane `indices[i]`; every index must be below 8.
    #[inline(always)]
    pub fn permute(self, indices: U32x8) -> Self {
        F32x8::from_bits(self.to_bits().permute(indices))
    }
    /// Reads memory at eight places: lane `i` is `table[indices[i]]`. Every index must lie in the table.
    #[inline(always)]
    pub fn gather(table: &[f32], indices: U32x8) -> Self {
        let at = indices.to_array();
        Self::from_array(std::array::from_fn(|lane| table[at[lane] as usize]))
    }
}

impl U32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self(u32x8::ZERO);

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: u32) -> Self {
        Self(u32x8::splat(value))
    }
    /// Lane `i` is `values[i]`.
    #[inline(always)]
    pub fn from_array(values: [u32; LANES]) -> Self {
        Self(u32x8::new(values))
    }
    /// `0, 1, .. 7`.
    #[inline(always)]
    pub fn lane_numbers() -> Self {
        Self::from_array([0, 1, 2, 3, 4, 5, 6, 7])
    }
    /// `[i]` is lane `i`.
    #[inline(always)]
    pub fn to_array(self) -> [u32; LANES] {
        self.0.to_array()
    }
    /// Lane `i` is `values[first + i]`; panics if fewer than eight are left.
    #[inline(always)]
    pub fn load(values: &[u32], first: usize) -> Self {
        let block: &[u32; LANES] = values[first..first + LANES].try_into().expect("eight values");
        Self::from_array(*block)
    }
    /// `values[first + i]` becomes lane `i`; panics if there is no room for eight.
    #[inline(always)]
    pub fn store(self, values: &mut [u32], first: usize) {
        let block: &mut [u32; LANES] = (&mut values[first..first + LANES]).try_into().expect("eight values");
        *block = self.to_array();
    }
    /// `self == other`.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8 {
        Mask8(bytemuck::cast(self.0.simd_eq(other.0)))
    }
    /// `self < other` as signed numbers; the same as unsigned where both are below 2^31.
    #[inline(always)]
    pub fn lt_signed(self, other: Self) -> Mask8 {
        let (a, b): (i32x8, i32x8) = (bytemuck::cast(self.0), bytemuck::cast(other.0));
        Mask8(bytemuck::cast(a.simd_lt(b)))
    }
    /// `self < other` as unsigned numbers.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask8 {
        let flip = U32x8::splat(0x8000_0000);
        (self ^ flip).lt_signed(other ^ flip)
    }
    /// The values as `f32`, exact below 2^24; must be below 2^31.
    #[inline(always)]
    pub fn to_f32(self) -> F32x8 {
        F32x8(f32x8::from_i32x8(bytemuck::cast(self.0)))
    }
    /// The upper half of the 64-bit product.
    #[inline(always)]
    pub fn multiply_high(self, other: Self) -> Self {
        Self(self.0.mul_keep_high(other.0))
    }
    /// Truncates; every lane must hold a finite value of 0 or more, below 2^31.
    #[inline(always)]
    pub fn from_f32(values: F32x8) -> Self {
        Self(bytemuck::cast(values.0.fast_trunc_int()))
    }
    /// The smaller, as signed numbers.
    #[inline(always)]
    pub fn min_signed(self, other: Self) -> Self {
        let (a, b): (i32x8, i32x8) = (bytemuck::cast(self.0), bytemuck::cast(other.0));
        Self(bytemuck::cast(a.min(b)))
    }
    /// The larger, as signed numbers.
    #[inline(always)]
    pub fn max_signed(self, other: Self) -> Self {
        let (a, b): (i32x8, i32x8) = (bytemuck::cast(self.0), bytemuck::cast(other.0));
        Self(bytemuck::cast(a.max(b)))
    }
    /// Lane by lane, `self >> counts`; every count must be below 32.
    #[inline(always)]
    pub fn shift_right_each(self, counts: Self) -> Self {
        Self(self.0 >> counts.0)
    }
    /// Every byte `b` becomes `table[b]`; all must be below 16.
    #[inline(always)]
    pub fn look_up_bytes(self, table: [u8; 16]) -> Self {
        let table = u8x32::new(std::array::from_fn(|i| table[i % 16]));
        Self(bytemuck::cast(table.swizzle_half_relaxed(bytemuck::cast(self.0))))
    }
    /// Bit 0 becomes bit 31, bit 1 bit 30 and so on.
    #[inline(always)]
    pub fn reverse_bits(self) -> Self {
        if cfg!(target_feature = "avx2") {
            /// Half bytes, mirrored.
            const MIRRORED: [u8; 16] = [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15];
            let half = Self::splat(0x0f0f_0f0f);
            let low = (self & half).look_up_bytes(MIRRORED.map(|bits| bits << 4));
            let mirrored: u8x32 = bytemuck::cast((low | (self >> 4 & half).look_up_bytes(MIRRORED)).0);
            let bytes = u8x32::new(std::array::from_fn(|i| (i % 16) as u8 ^ 3));
            return Self(bytemuck::cast(mirrored.swizzle_half_relaxed(bytes)));
        }
        let swap = |x: Self, bits: u32, mask: u32| {
            let mask = Self::splat(mask);
            (x >> bits & mask) | (x & mask) << bits
        };
        let bytes = swap(swap(swap(self, 1, 0x5555_5555), 2, 0x3333_3333), 4, 0x0f0f_0f0f);
        let halves = swap(bytes, 8, 0x00ff_00ff);
        halves >> 16 | halves << 16
    }
    /// Crosses lanes: lane `i` becomes lane `indices[i]`; every index must be below 8.
    #[inline(always)]
    pub fn permute(self, indices: U32x8) -> Self {
        Self(self.0.shuffle(indices.0))
    }
    /// Crosses lanes: the lanes of `mask` (bit `i`: lane `i`) move to the front in order; what follows them is unspecified.
    #[inline(always)]
    pub fn compress(self, mask: u8) -> Self {
        Self(self.0.shuffle(u32x8::new(COMPRESS[mask as usize])))
    }
    /// Reads memory at eight places: lane `i` is `table[indices[i]]`. Every index must lie in the table.
    #[inline(always)]
    pub fn gather(table: &[u32], indices: U32x8) -> Self {
        let at = indices.to_array();
        Self::from_array(std::array::from_fn(|lane| table[at[lane] as usize]))
    }
}

impl Shl<u32> for U32x8 {
    type Output = Self;
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Self(self.0 << bits)
    }
}
impl Shr<u32> for U32x8 {
    type Output = Self;
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }
}

impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        self ^ Mask8::ALL
    }
}

impl Mask8 {
    /// No lane.
    pub const NONE: Self = Self(f32x8::ZERO);
    /// Every lane.
    pub const ALL: Self = Self(f32x8::new([f32::from_bits(u32::MAX); LANES]));

    /// Lane `i` is bit `i`.
    #[inline(always)]
    pub fn from_bits(bits: u8) -> Self {
        let lane_bits = U32x8::from_array([1, 2, 4, 8, 16, 32, 64, 128]);
        (U32x8::splat(bits as u32) & lane_bits).eq(lane_bits)
    }
    /// Lane `i` is `lanes[i]`.
    #[inline(always)]
    pub const fn from_lanes(lanes: [bool; LANES]) -> Self {
        let mut values = [0.0; LANES];
        let mut lane = 0;
        while lane < LANES {
            values[lane] = f32::from_bits(if lanes[lane] { u32::MAX } else { 0 });
            lane += 1;
        }
        Self(f32x8::new(values))
    }
    /// Lane `i` is `i < count`.
    #[inline(always)]
    pub fn first(count: usize) -> Self {
        U32x8::lane_numbers().lt_signed(U32x8::splat(count as u32))
    }
    /// Bit `i` is lane `i`.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        self.0.to_bitmask() as u8
    }
    /// Whether any lane is true.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.bits() != 0
    }
    /// Whether every lane is true.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.bits() == 0xff
    }
    /// How many lanes are true.
    #[inline(always)]
    pub fn count(self) -> u32 {
        self.bits().count_ones()
    }
    /// True here and not in `other`.
    #[inline(always)]
    pub fn and_not(self, other: Self) -> Self {
        self & !other
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select(self, yes: F32x8, no: F32x8) -> F32x8 {
        F32x8(self.0.bitselect(yes.0, no.0))
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select_u32(self, yes: U32x8, no: U32x8) -> U32x8 {
        let mask: u32x8 = bytemuck::cast(self.0);
        U32x8(mask.bitselect(yes.0, no.0))
    }
    /// Lane by lane, `if self { yes } else { no }`.
    #[inline(always)]
    pub fn select_vec3(self, yes: Vec3x8, no: Vec3x8) -> Vec3x8 {
        Vec3x8 { x: self.select(yes.x, no.x), y: self.select(yes.y, no.y), z: self.select(yes.z, no.z) }
    }
}

impl Vec3x8 {
    /// From its components.
    #[inline(always)]
    pub fn new(x: F32x8, y: F32x8, z: F32x8) -> Self {
        Self { x, y, z }
    }
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: [f32; 3]) -> Self {
        Self { x: F32x8::splat(v[0]), y: F32x8::splat(v[1]), z: F32x8::splat(v[2]) }
    }
    /// `x x' + y y' + z z'`, added from left to right as glam's scalar `Vec3` does.
    #[inline(always)]
    pub fn dot(self, other: Self) -> F32x8 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
    /// Cross product, in the operation order of glam's scalar `Vec3`.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }
    /// Every component times `factor`.
    #[inline(always)]
    pub fn scale(self, factor: F32x8) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
    /// Absolute value of every component.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }
    /// The largest component, as `max(max(x, y), z)`.
    #[inline(always)]
    pub fn max_element(self) -> F32x8 {
        self.x.max(self.y).max(self.z)
    }
}

macro_rules! vec3_operator {
    ($trait:ident, $function:ident) => {
        impl $trait for Vec3x8 {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self { x: self.x.$function(other.x), y: self.y.$function(other.y), z: self.z.$function(other.z) }
            }
        }
    };
}
vec3_operator!(Add, add);
vec3_operator!(Sub, sub);
vec3_operator!(Mul, mul);

impl Neg for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

/// `COMPRESS[mask]`: the numbers of the lanes set in `mask`, ascending, then zeros.
static COMPRESS: [[u32; LANES]; 256] = {
    let mut table = [[0u32; LANES]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < LANES {
            if mask >> lane & 1 == 1 {
                table[mask][place] = lane as u32;
                place += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// (sine, cosine) of `turns` whole turns; the lanes of [`crate::math::sin_cos_turns`], same bits.
#[inline(always)]
pub fn sin_cos_turns(turns: F32x8) -> (F32x8, F32x8) {
    use crate::math::{COS_POLYNOMIAL as C, SIN_POLYNOMIAL as S};
    let quarters = turns * F32x8::splat(4.0);
    let quadrant = U32x8::from_f32(quarters + F32x8::splat(0.5));
    let r = quarters - quadrant.to_f32();
    let r2 = r * r;
    let c = |k: f32| F32x8::splat(k);
    let sine = r * (c(S[0]) + r2 * (c(S[1]) + r2 * (c(S[2]) + r2 * c(S[3]))));
    let cosine = c(C[0]) + r2 * (c(C[1]) + r2 * (c(C[2]) + r2 * (c(C[3]) + r2 * c(C[4]))));
    let odd = (quadrant & U32x8::splat(1)).eq(U32x8::splat(1));
    let (s, c) = (odd.select(cosine, sine), odd.select(sine, cosine));
    // Quadrants 2 and 3 have negative sines, quadrants 1 and 2 negative cosines.
    let sine_sign = (quadrant & U32x8::splat(2)) << 30;
    let cosine_sign = ((quadrant + U32x8::splat(1)) & U32x8::splat(2)) << 30;
    (F32x8::from_bits(s.to_bits() ^ sine_sign), F32x8::from_bits(c.to_bits() ^ cosine_sign))
}

/// Angles of vectors in turns; the lanes of [`crate::math::atan2_turns`], same bits.
#[inline(always)]
pub fn atan2_turns(y: F32x8, x: F32x8) -> F32x8 {
    let (a, b) = (y.abs(), x.abs());
    let (low, high) = (a.min(b), a.max(b));
    let q = high.gt(F32x8::ZERO).select(low / high, F32x8::ZERO);
    let octant = q * polynomial(&crate::math::ATAN_POLYNOMIAL, q * q);
    let quarter = a.gt(b).select(F32x8::splat(0.25) - octant, octant);
    let half = x.lt(F32x8::ZERO).select(F32x8::splat(0.5) - quarter, quarter);
    let turns = y.lt(F32x8::ZERO).select(F32x8::ONE - half, half);
    turns.lt(F32x8::ONE).select(turns, F32x8::ZERO)
}

/// Arc cosines in half turns; the lanes of [`crate::math::acos_half_turns`], same bits.
#[inline(always)]
pub fn acos_half_turns(y: F32x8) -> F32x8 {
    let a = y.abs();
    let root = (F32x8::ONE - a).max(F32x8::ZERO).sqrt();
    let half = root * polynomial(&crate::math::ACOS_POLYNOMIAL, a);
    y.lt(F32x8::ZERO).select(F32x8::ONE - half, half)
}

/// `c[0] + x (c[1] + x (c[2] + ..))`.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f32; N], x: F32x8) -> F32x8 {
    let last = F32x8::splat(c[N - 1]);
    c[..N - 1].iter().rev().fold(last, |sum, &c| F32x8::splat(c) + x * sum)
}

/// The SIMD level this build was compiled for.
pub const fn simd_level() -> &'static str {
    if cfg!(all(target_arch = "x86_64", target_feature = "avx512f")) {
        "x86-64-v4 (AVX-512 build, 8 lanes)"
    } else if cfg!(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")) {
        "x86-64-v3 (AVX2, 8 lanes)"
    } else if cfg!(all(target_arch = "x86_64", target_feature = "avx")) {
        "AVX (8 lanes, integers in halves)"
    } else if cfg!(target_arch = "x86_64") {
        "x86-64 (SSE2, 8 lanes in halves)"
    } else {
        "portable (8 lanes, untested CPU)"
    }
}
