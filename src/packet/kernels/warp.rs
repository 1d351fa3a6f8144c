//! From uniform numbers to directions and points, eight at a time; each `sample_x` with its density below it.

use super::here;
use crate::math::INV_PI;
use here::lanes::{F32x8, Vec3x8, sin_cos_turns};

/// Directions about +z with density cos/pi (Malley's method; pbrt-v4 appendix A.5.3).
#[inline(always)]
pub fn sample_cosine_hemisphere(u: [F32x8; 2]) -> Vec3x8 {
    let radius = u[0].sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    Vec3x8::new(radius * cosine, radius * sine, (F32x8::ONE - u[0]).sqrt())
}

/// Densities per steradian of [`sample_cosine_hemisphere`].
#[inline(always)]
pub fn cosine_hemisphere_pdf_dir(cosine: F32x8) -> F32x8 {
    cosine * F32x8::splat(INV_PI)
}

/// Directions about +z, uniform over the hemisphere: density 1/(2 pi) (pbrt-v4 appendix A.5.2).
#[inline(always)]
pub fn sample_uniform_hemisphere(u: [F32x8; 2]) -> Vec3x8 {
    let z = u[0];
    let radius = (F32x8::ONE - z * z).sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    Vec3x8::new(radius * cosine, radius * sine, z)
}

/// Points uniform over the unit disk (pbrt-v4 appendix A.5.1, polar).
#[inline(always)]
pub fn sample_uniform_disk(u: [F32x8; 2]) -> [F32x8; 2] {
    let radius = u[0].sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    [radius * cosine, radius * sine]
}

/// Barycentric weights of points uniform over triangles (Turk 1990).
#[inline(always)]
pub fn sample_uniform_triangle(u: [F32x8; 2]) -> [F32x8; 3] {
    let root = u[0].sqrt();
    [F32x8::ONE - root, root * (F32x8::ONE - u[1]), root * u[1]]
}

/// The first two axes of orthonormal frames whose third axes are `n` (Duff et al., JCGT 2017).
#[inline(always)]
pub fn frame(n: Vec3x8) -> (Vec3x8, Vec3x8) {
    let sign = F32x8::ONE.copysign(n.z);
    let a = F32x8::splat(-1.0) / (sign + n.z);
    let b = n.x * n.y * a;
    let tangent = Vec3x8::new(F32x8::ONE + sign * n.x * n.x * a, sign * b, -(sign * n.x));
    (tangent, Vec3x8::new(b, sign + n.y * n.y * a, -n.y))
}

/// World directions in the frames about `n`.
#[inline(always)]
pub fn to_local(direction: Vec3x8, n: Vec3x8) -> Vec3x8 {
    let (tangent, bitangent) = frame(n);
    Vec3x8::new(tangent.dot(direction), bitangent.dot(direction), n.dot(direction))
}

/// Directions given in the frames about `n`, as world directions.
#[inline(always)]
pub fn to_world(local: Vec3x8, n: Vec3x8) -> Vec3x8 {
    let (tangent, bitangent) = frame(n);
    tangent.scale(local.x) + bitangent.scale(local.y) + n.scale(local.z)
}
