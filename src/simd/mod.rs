//! What is compiled once a SIMD level, and which level is used.
//!
//! The inner loops live in folders of their rooms: `bvh/walks`, `sampler/lanes`, `packet/kernels`. Each is mounted here as part of
//! [`native`], the engine as the build was compiled, and, in a build for any x86-64, once more as part of `avx2`. There is one
//! source; what differs is what `here` means in it: `here::lanes` are the lanes of its level, `here::run` compiles a closure with
//! the level's instructions. Everything in those folders is inlined into such a closure or is one itself.
//!
//! **Law:** levels talk to the rest of the crate in plain data (queues, arrays), never in lanes, and give the same bits.

mod level;

pub mod native;

#[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
pub mod avx2;

pub use level::{COMPILED, SimdLevel, VARIABLE, simd_level};

/// Calls `native::path(arguments..)`, or `avx2`'s, whichever level is used; with a `scratch`, at its level, and
/// `&mut scratch.native` or `&mut scratch.avx2` is the last argument. In a build for AVX2 the two levels are one.
macro_rules! by_level {
    ($($path:ident)::+ ($($argument:expr),*)) => {
        match $crate::simd::SimdLevel::used() {
            #[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
            $crate::simd::SimdLevel::Avx2 | $crate::simd::SimdLevel::Avx512 => {
                $crate::simd::avx2::$($path)::+($($argument),*)
            }
            _ => $crate::simd::native::$($path)::+($($argument),*),
        }
    };
    ($scratch:expr, $($path:ident)::+ ($($argument:expr),*)) => {
        match $scratch.level() {
            #[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
            $crate::simd::SimdLevel::Avx2 | $crate::simd::SimdLevel::Avx512 => {
                $crate::simd::avx2::$($path)::+($($argument,)* &mut $scratch.avx2)
            }
            _ => $crate::simd::native::$($path)::+($($argument,)* &mut $scratch.native),
        }
    };
}
pub(crate) use by_level;
