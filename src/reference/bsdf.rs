//! How surfaces scatter, about the normal `n` of the side the ray came from.

use super::warp::{
    cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, sample_uniform_hemisphere, to_world,
    uniform_hemisphere_pdf_dir,
};
use super::{INV_PI, Real, Vec3};

/// A direction drawn to go on in.
pub struct BsdfSample {
    /// Unit direction away from the surface.
    pub direction: Vec3,
    /// BSDF times cosine over density: what the throughput is multiplied with.
    pub factor: Vec3,
    /// Density per steradian; meaningless for a delta lobe.
    pub pdf_dir: Real,
    /// Cosine between the direction and the normal; meaningless for a delta lobe.
    pub cosine: Real,
    /// The direction was the only one possible.
    pub delta: bool,
}

/// Lambertian reflection: BSDF albedo/pi, cosine-distributed directions, so that the factor is the albedo.
pub fn sample_diffuse(albedo: Vec3, n: Vec3, u: [Real; 2]) -> BsdfSample {
    let local = sample_cosine_hemisphere(u);
    let pdf_dir = cosine_hemisphere_pdf_dir(local.z);
    BsdfSample { direction: to_world(local, n), factor: albedo, pdf_dir, cosine: local.z, delta: false }
}

/// Lambertian reflection with uniform directions (the lecture's starting point): the factor is 2 albedo cos.
pub fn sample_diffuse_uniformly(albedo: Vec3, n: Vec3, u: [Real; 2]) -> BsdfSample {
    let local = sample_uniform_hemisphere(u);
    let factor = albedo * (2.0 * local.z);
    let pdf_dir = uniform_hemisphere_pdf_dir();
    BsdfSample { direction: to_world(local, n), factor, pdf_dir, cosine: local.z, delta: false }
}

/// Lambertian BSDF times cosine over albedo: cos/pi, which is also the density of [`sample_diffuse`].
pub fn diffuse_cosine(cosine: Real) -> Real {
    cosine * INV_PI
}

/// Mirror reflection of the unit direction `incoming` (towards the surface).
pub fn sample_mirror(reflectance: Vec3, n: Vec3, incoming: Vec3) -> BsdfSample {
    let direction = incoming - n * (2.0 * incoming.dot(n));
    BsdfSample { direction, factor: reflectance, pdf_dir: Real::INFINITY, cosine: 0.0, delta: true }
}
