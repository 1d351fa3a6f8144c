//! The types, and how operators of theirs are instructions.

use std::arch::x86_64::{__m256, __m256i};

/// Eight `f32`.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct F32x8(pub(super) __m256);

/// Eight `u32`; arithmetic wraps.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct U32x8(pub(super) __m256i);

/// Eight booleans: every lane is all ones (true) or all zeros (false).
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Mask8(pub(super) __m256);

macro_rules! zero_by_default {
    ($($type:ident = $zero:ident),*) => {
        $(impl Default for $type {
            #[inline(always)]
            fn default() -> Self {
                Self::$zero
            }
        })*
    };
}
zero_by_default!(F32x8 = ZERO, U32x8 = ZERO, Mask8 = NONE);

/// A call of intrinsics.
macro_rules! avx2 {
    ($call:expr) => {
        // SAFETY: the CPU has AVX2 and FMA: the law of this folder.
        unsafe { $call }
    };
}
pub(super) use avx2;

macro_rules! binary_operator {
    ($type:ident, $trait:ident, $function:ident, $instruction:ident) => {
        impl std::ops::$trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(avx2!(std::arch::x86_64::$instruction(self.0, other.0)))
            }
        }
    };
}
pub(super) use binary_operator;
