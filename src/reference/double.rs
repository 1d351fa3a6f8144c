//! The reference with `Real = f64`.
// Compiling the same files twice, with another number type, is the point of this folder.
#![allow(clippy::duplicate_mod)]
// `!(x > 0.0)` is meant: NaN must fail such a test, as it does in lanes. Casts to `Real` are idle in one of the copies.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::unnecessary_cast)]

/// The number type of this copy of the reference.
pub type Real = f64;
/// Its vectors: glam's plain ones, which do not change with the build.
pub type Vec3 = glam::DVec3;

/// A table's vector as this copy's.
#[inline(always)]
pub fn vec3(v: [f32; 3]) -> Vec3 {
    Vec3::new(v[0] as Real, v[1] as Real, v[2] as Real)
}

/// 1/pi.
pub const INV_PI: Real = std::f64::consts::FRAC_1_PI;
/// 1/(2 pi).
pub const INV_2PI: Real = 0.5 * std::f64::consts::FRAC_1_PI;

/// (sine, cosine) of `turns` whole turns.
pub fn sin_cos_turns(turns: Real) -> (Real, Real) {
    (turns * std::f64::consts::TAU).sin_cos()
}

#[path = "bsdf.rs"]
pub mod bsdf;
#[path = "intersect.rs"]
pub mod intersect;
#[path = "light.rs"]
pub mod light;
#[path = "microfacet.rs"]
pub mod microfacet;
#[path = "mis.rs"]
pub mod mis;
#[path = "path.rs"]
pub mod path;
#[path = "surface.rs"]
pub mod surface;
#[path = "texture.rs"]
pub mod texture;
#[path = "warp.rs"]
pub mod warp;
