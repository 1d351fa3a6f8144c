//! Eight lanes of `f32` and `u32`: the only folder of the crate that names `wide`.
//!
//! Only operations that every x86-64 level rounds alike are offered (`+ - * / sqrt floor`, comparisons, integer and bit
//! operations), so code built on these types computes the same bits in an SSE2, an AVX2 and an AVX-512 build, and the
//! same bits as plain `f32` code that performs the same operations in the same order.
//!
//! **Invariant:** lane `i` of a result depends on lane `i` of the operands alone, except in the functions that say
//! otherwise in their first line (`compress`, `transpose`, `gather`, reductions).

mod f32x8;
mod functions;
mod mask;
mod types;
mod u32x8;
mod vec3;

pub use functions::{atan2_turns, count_at_most, polar_half_turns, sin_cos_turns};
pub use types::{F32x8, LANES, Mask8, U32x8, Vec3x8};

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
