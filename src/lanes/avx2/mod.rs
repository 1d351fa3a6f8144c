//! Eight lanes of AVX2 in a build for any x86-64: what [`crate::lanes`] offers, by the CPU's own names, since `wide` chooses its
//! instructions when it is compiled. Same operations, same bits (`tests/operations/lanes.rs` runs both).
//!
//! **Law:** everything here is inlined into code compiled for AVX2 ([`crate::simd::avx2`]), or it is slow: elsewhere each
//! operation is a call that passes its lanes through memory. `.ci/run` looks for such calls in the program.
// SAFETY: whoever enters `crate::simd::avx2` has asked the CPU for AVX2 and FMA; intrinsics on values need nothing else, and none
// here touches memory. (3.2 times the speed of SSE2, measured on `cornell`.)
#![allow(unsafe_code)]

use crate::lanes::compress;

#[path = "../derived.rs"]
mod derived;
mod f32x8;
#[path = "../functions.rs"]
mod functions;
mod mask;
mod types;
mod u32x8;
#[path = "../vec3.rs"]
mod vec3;

pub use crate::lanes::{Each, LANES, inlined};
pub use functions::{atan2_turns, polar_half_turns, sin_cos_turns};
pub use types::{F32x8, Mask8, U32x8};
pub use u32x8::count_at_most;
pub use vec3::Vec3x8;
