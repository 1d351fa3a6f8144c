//! Eight lanes of `f32` and `u32`: the only folder of the crate that names `wide`.
//!
//! Only operations that every x86-64 level rounds alike are offered (`+ - * / sqrt floor`, comparisons, integer and bit
//! operations), so code built on these types computes the same bits in an SSE2, an AVX2 and an AVX-512 build, and the
//! same bits as plain `f32` code that performs the same operations in the same order.
//!
//! **Invariant:** lane `i` of a result depends on lane `i` of the operands alone, except in the functions that say
//! otherwise in their first line (`compress`, `transpose`, `gather`, reductions).

pub(crate) mod compress;
mod derived;
mod each;
mod f32x8;
mod functions;
mod mask;
mod types;
mod u32x8;
mod vec3;

pub use each::{Each, inlined};
pub use functions::{atan2_turns, polar_half_turns, sin_cos_turns};
pub use types::{F32x8, LANES, Mask8, U32x8};
pub use u32x8::count_at_most;
pub use vec3::Vec3x8;
