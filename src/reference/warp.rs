//! From uniform numbers to directions and points; each `sample_x` with its density below it.

use super::{INV_2PI, INV_PI, Real, Vec3, sin_cos_turns};
use crate::fault::{Fault, lost_digits, planted};

/// A direction about +z with density cos/pi: a disk lifted to the hemisphere (Malley's method; pbrt-v4 appendix A.5.3).
pub fn sample_cosine_hemisphere(u: [Real; 2]) -> Vec3 {
    let radius = u[0].sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    let z = (1.0 - u[0]).sqrt() * if planted(Fault::LongDirection) { 1.001 } else { 1.0 };
    let z = z * lost_digits(Real::EPSILON as f64) as Real;
    Vec3::new(radius * cosine, radius * sine, z)
}

/// Density per steradian of [`sample_cosine_hemisphere`].
pub fn cosine_hemisphere_pdf_dir(cosine: Real) -> Real {
    let single = size_of::<Real>() == size_of::<f32>();
    let off = if single && planted(Fault::ScalarDensity) { 1.01 } else { lost_digits(Real::EPSILON as f64) as Real };
    cosine * INV_PI * off
}

/// A direction about +z, uniform over the hemisphere (pbrt-v4 appendix A.5.2).
pub fn sample_uniform_hemisphere(u: [Real; 2]) -> Vec3 {
    let z = u[0];
    let radius = (1.0 - z * z).sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    Vec3::new(radius * cosine, radius * sine, z)
}

/// Density per steradian of [`sample_uniform_hemisphere`].
pub fn uniform_hemisphere_pdf_dir() -> Real {
    INV_2PI
}

/// A point uniform over the unit disk (pbrt-v4 appendix A.5.1, polar).
pub fn sample_uniform_disk(u: [Real; 2]) -> [Real; 2] {
    let radius = u[0].sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    [radius * cosine, radius * sine]
}

/// Barycentric weights of a point uniform over a triangle's area (Turk 1990; Osada et al. 2002).
pub fn sample_uniform_triangle(u: [Real; 2]) -> [Real; 3] {
    let root = u[0].sqrt();
    [1.0 - root, root * (1.0 - u[1]), root * u[1]]
}

/// An orthonormal frame whose third axis is `n` (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017):
/// the first and second axis.
pub fn frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = Real::copysign(1.0, n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a * if planted(Fault::SkewedFrame) { 1.001 } else { 1.0 };
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -(sign * n.x)), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// The world direction `direction` in the frame about `n`.
pub fn to_local(direction: Vec3, n: Vec3) -> Vec3 {
    let (tangent, bitangent) = frame(n);
    Vec3::new(tangent.dot(direction), bitangent.dot(direction), n.dot(direction))
}

/// `local`, given in the frame about `n`, as a world direction.
pub fn to_world(local: Vec3, n: Vec3) -> Vec3 {
    let (tangent, bitangent) = frame(n);
    tangent * local.x + bitangent * local.y + n * local.z
}
