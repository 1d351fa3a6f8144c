//! Mirrors: the one possible direction.

use super::sample::{BsdfSample, only};
use super::{Vec3, vec3};
use crate::tables::materials::MaterialRecord;

/// The reflected direction.
pub fn sample(material: &MaterialRecord, n: Vec3, incoming: Vec3) -> BsdfSample {
    only(reflect(incoming, n), vec3(material.color))
}

/// The mirror image of a direction towards the surface.
pub fn reflect(incoming: Vec3, n: Vec3) -> Vec3 {
    incoming - n * (2.0 * incoming.dot(n))
}
