//! The reference with `Real = f32`.
// Compiling the same files twice, with another number type, is the point of this folder.
#![allow(clippy::duplicate_mod)]
// `!(x > 0.0)` is meant: NaN must fail such a test, as it does in lanes. Casts to `Real` are idle in one of the copies.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::unnecessary_cast)]

/// The number type of this copy of the reference.
pub type Real = f32;
/// Its vectors: glam's plain ones, which do not change with the build.
pub type Vec3 = glam::Vec3;

/// A table's vector as this copy's.
#[inline(always)]
pub fn vec3(v: [f32; 3]) -> Vec3 {
    Vec3::new(v[0] as Real, v[1] as Real, v[2] as Real)
}

pub use crate::math::{INV_2PI, INV_PI, atan2_turns, polar_half_turns, sin_cos_turns};

#[path = "alpha_masks.rs"]
pub mod alpha_masks;
#[path = "bsdf/mod.rs"]
pub mod bsdf;
#[path = "camera.rs"]
pub mod camera;
#[path = "guide.rs"]
pub mod guide;
#[path = "intersect.rs"]
pub mod intersect;
#[path = "layers.rs"]
pub mod layers;
#[path = "lights/mod.rs"]
pub mod lights;
#[path = "mis.rs"]
pub mod mis;
#[path = "observer.rs"]
pub mod observer;
#[path = "path.rs"]
pub mod path;
#[path = "precise.rs"]
pub mod precise;
#[path = "recorder.rs"]
pub mod recorder;
#[path = "surface.rs"]
pub mod surface;
#[path = "texture.rs"]
pub mod texture;
#[path = "warp.rs"]
pub mod warp;
