//! How surfaces scatter, eight hits at a time: a type a material kind.
//!
//! Directions are local, +z is the normal of the side the ray came from; `wo` points back along the ray, `wi` to where light
//! comes from. A new kind is a file here and a line in [`of_kind`].

use super::here;

pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod interface;
pub mod microfacet;
pub mod mirror;
pub mod plastic;
pub mod principled;

use crate::tables::materials::MaterialKind;
pub use interface::{Bsdf, Sampled, Scattered, Specular};

/// What is done with the type of a kind.
pub trait ForKind {
    /// What comes of it.
    type Output;
    /// For a kind with a density.
    fn bsdf<B: Bsdf>(self) -> Self::Output;
    /// For a kind with single directions.
    fn specular<S: Specular>(self) -> Self::Output;
}

/// Hands the type of `kind` to `action`; `None` for the kind that scatters nothing.
pub fn of_kind<A: ForKind>(kind: MaterialKind, action: A) -> Option<A::Output> {
    match kind {
        MaterialKind::Black => None,
        MaterialKind::Diffuse => Some(action.bsdf::<diffuse::Diffuse>()),
        MaterialKind::Mirror => Some(action.specular::<mirror::Mirror>()),
        MaterialKind::Conductor => Some(action.bsdf::<conductor::Conductor>()),
        MaterialKind::Dielectric => Some(action.specular::<dielectric::Dielectric>()),
        MaterialKind::Plastic => Some(action.bsdf::<plastic::Plastic>()),
        MaterialKind::Principled => Some(action.bsdf::<principled::Principled>()),
    }
}
