//! The engine as this build was compiled.
// Compiling the same files more than once, with other lanes, is the point of this folder.
#![allow(clippy::duplicate_mod)]
// A closure may be marked `#[inline(always)]` where it is an argument, a function that stands for it may not.
#![allow(clippy::redundant_closure)]

use crate::simd::native as here;

pub use crate::internal::lanes;

/// Calls `f`: this level needs nothing that the build does not have.
#[inline(always)]
pub(crate) fn run<R>(f: impl FnOnce() -> R) -> R {
    f()
}

#[path = "../packet/kernels/mod.rs"]
pub mod kernels;
#[path = "../sampler/lanes/mod.rs"]
pub mod numbers;
#[path = "../bvh/walks/mod.rs"]
pub mod walks;
