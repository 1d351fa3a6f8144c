//! What sampling a BSDF gives.

use super::warp::to_world;
use super::{Real, Vec3};

/// A direction drawn to go on in.
pub struct BsdfSample {
    /// Unit direction in world space; below the surface after a refraction.
    pub direction: Vec3,
    /// The BSDF weight, BSDF times cosine over density: what the throughput is multiplied with.
    pub weight: Vec3,
    /// Density per steradian; meaningless for a delta lobe.
    pub pdf_dir: Real,
    /// Cosine between direction and normal; meaningless for a delta lobe.
    pub cosine: Real,
    /// What the surface sends on of what arrives, the largest component: where roulette goes by it.
    pub albedo: Real,
    /// The direction was the only one possible, or one of two.
    pub delta: bool,
}

/// The sample of a local direction that was drawn from a density.
pub fn drawn(wi: Vec3, n: Vec3, weight: Vec3, pdf_dir: Real) -> BsdfSample {
    let albedo = max_element(weight);
    BsdfSample { direction: to_world(wi, n), weight, pdf_dir, cosine: wi.z, albedo, delta: false }
}

/// The sample of the only direction possible, or of one of two.
pub fn only(direction: Vec3, weight: Vec3) -> BsdfSample {
    BsdfSample { direction, weight, pdf_dir: 1.0, cosine: 0.0, albedo: max_element(weight), delta: true }
}

/// The largest component, by the crate's definition of the maximum.
pub fn max_element(v: Vec3) -> Real {
    let xy = if v.x > v.y { v.x } else { v.y };
    if xy > v.z { xy } else { v.z }
}
