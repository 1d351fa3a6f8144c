//! The engine for CPUs with AVX2, in a build for any x86-64.
//!
//! **Law:** only where [`crate::simd::SimdLevel::used`] is AVX2 or more is anything here called.
// Compiling the same files more than once, with other lanes, is the point of this folder.
#![allow(clippy::duplicate_mod)]
// A closure may be marked `#[inline(always)]` where it is an argument, a function that stands for it may not.
#![allow(clippy::redundant_closure)]
// Some things only the native copy is asked for.
#![allow(dead_code)]

use crate::simd::avx2 as here;

#[path = "../lanes/avx2/mod.rs"]
pub mod lanes;

/// Calls `f`, compiled for AVX2 together with all that is inlined into it.
#[inline(always)]
#[allow(unsafe_code)]
pub(crate) fn run<R>(f: impl FnOnce() -> R) -> R {
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn compiled_for_avx2<R>(f: impl FnOnce() -> R) -> R {
        f()
    }
    // SAFETY: whoever calls into this module has asked the CPU for these features ([`crate::simd::SimdLevel::available`]).
    // (Builds for any x86-64, which `cargo install` makes, are three times as fast by it.)
    unsafe { compiled_for_avx2(f) }
}

#[path = "../packet/kernels/mod.rs"]
pub mod kernels;
#[path = "../sampler/lanes/mod.rs"]
pub mod numbers;
#[path = "../bvh/walks/mod.rs"]
pub mod walks;
