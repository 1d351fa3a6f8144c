//! The lanes of every SIMD level of this build against plain arithmetic.
// The same tests for other lanes are the point.
#![allow(clippy::duplicate_mod)]

/// In a build for any x86-64, on a CPU that has AVX2; elsewhere there are none besides the native ones.
#[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
mod avx2;
mod native;
