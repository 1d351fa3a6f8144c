//! How surfaces scatter, about the normal `n` of the side the ray came from: a file a material kind. `wo` and `wi` are local
//! directions (the normal is +z) back along the ray and to where light comes from.
//!
//! A new kind is a file here and a line in [`orient`], [`evaluate`] and [`sample()`].

use super::surface::SurfacePoint;
use super::{INV_PI, Real, Vec3, sin_cos_turns, vec3, warp};

pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod microfacet;
pub mod mirror;
pub mod plastic;
pub mod principled;
pub mod sample;

use crate::tables::materials::{MaterialKind, MaterialRecord};
use sample::{BsdfSample, drawn};
use warp::{sample_uniform_hemisphere, to_local, uniform_hemisphere_pdf_dir};

/// Makes a point on a smooth surface and the ray that hit it in direction `incoming` fit each other; the direction to go by.
pub fn orient(kind: MaterialKind, point: &mut SurfacePoint, incoming: Vec3) -> Vec3 {
    match kind {
        MaterialKind::Black | MaterialKind::Diffuse => incoming,
        MaterialKind::Dielectric => point.graze(incoming),
        MaterialKind::Mirror | MaterialKind::Conductor | MaterialKind::Plastic | MaterialKind::Principled => {
            point.face_forward(-incoming);
            incoming
        }
    }
}

/// BSDF times cosine towards the unit world direction `direction` for the unit `incoming` (towards the surface), and the
/// density with which [`sample()`] draws it. Not for delta kinds.
pub fn evaluate(material: &MaterialRecord, n: Vec3, incoming: Vec3, direction: Vec3) -> (Vec3, Real) {
    let wo = || to_local(-incoming, n);
    match material.kind() {
        MaterialKind::Diffuse => diffuse::evaluate(material, n.dot(direction)),
        MaterialKind::Conductor => conductor::evaluate(material, wo(), to_local(direction, n)),
        MaterialKind::Plastic => plastic::evaluate(material, wo(), to_local(direction, n)),
        MaterialKind::Principled => principled::evaluate(material, wo(), to_local(direction, n)),
        MaterialKind::Black | MaterialKind::Mirror | MaterialKind::Dielectric => (Vec3::ZERO, 0.0),
    }
}

/// Draws a direction; `None` if the one drawn carries nothing. `u` places it, `u_lobe` chooses between lobes. `front`: the
/// ray hit the front (for glass: it comes from outside).
pub fn sample(
    material: &MaterialRecord,
    n: Vec3,
    incoming: Vec3,
    front: bool,
    u: [Real; 2],
    u_lobe: Real,
) -> Option<BsdfSample> {
    match material.kind() {
        MaterialKind::Black => None,
        MaterialKind::Diffuse => Some(diffuse::sample(material, n, u)),
        MaterialKind::Mirror => Some(mirror::sample(material, n, incoming)),
        MaterialKind::Conductor => conductor::sample(material, n, to_local(-incoming, n), u),
        MaterialKind::Dielectric => Some(dielectric::sample(material, n, incoming, front, u_lobe)),
        MaterialKind::Plastic => plastic::sample(material, n, to_local(-incoming, n), u, u_lobe),
        MaterialKind::Principled => principled::sample(material, n, to_local(-incoming, n), u, u_lobe),
    }
}

/// Draws a direction uniformly over the hemisphere (the lecture's starting point). Not for delta kinds.
pub fn sample_uniformly(material: &MaterialRecord, n: Vec3, incoming: Vec3, u: [Real; 2]) -> BsdfSample {
    let wi = sample_uniform_hemisphere(u);
    let pdf_dir = uniform_hemisphere_pdf_dir();
    let f_cosine = match material.kind() {
        MaterialKind::Conductor => conductor::evaluate(material, to_local(-incoming, n), wi).0,
        MaterialKind::Plastic => plastic::evaluate(material, to_local(-incoming, n), wi).0,
        MaterialKind::Principled => principled::evaluate(material, to_local(-incoming, n), wi).0,
        _ => diffuse::evaluate(material, wi.z).0,
    };
    drawn(wi, n, f_cosine * (1.0 / pdf_dir), pdf_dir)
}
