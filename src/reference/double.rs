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

/// The angle of the vector (`x`, `y`) from the x axis towards the y axis, in turns, in [0, 1).
pub fn atan2_turns(y: Real, x: Real) -> Real {
    let turns = y.atan2(x) / std::f64::consts::TAU;
    let turns = if turns < 0.0 { turns + 1.0 } else { turns };
    if turns < 1.0 { turns } else { 0.0 }
}

/// The angle, in half turns, of a direction with this `versine` (one minus the cosine) to the axis.
pub fn polar_half_turns(versine: Real) -> Real {
    2.0 * (0.5 * versine).sqrt().asin() / std::f64::consts::PI
}

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
