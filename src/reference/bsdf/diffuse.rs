//! Lambertian surfaces.

use super::sample::{BsdfSample, drawn};
use super::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere};
use super::{Real, Vec3, vec3};
use crate::tables::materials::MaterialRecord;

/// Albedo/pi times cosine, and cosine/pi: the density of drawing the direction.
pub fn evaluate(material: &MaterialRecord, cosine: Real) -> (Vec3, Real) {
    let pdf_dir = cosine_hemisphere_pdf_dir(cosine);
    (vec3(material.color) * pdf_dir, pdf_dir)
}

/// Draws in proportion to the cosine: the BSDF weight is the albedo.
pub fn sample(material: &MaterialRecord, n: Vec3, u: [Real; 2]) -> BsdfSample {
    let wi = sample_cosine_hemisphere(u);
    drawn(wi, n, vec3(material.color), cosine_hemisphere_pdf_dir(wi.z))
}
