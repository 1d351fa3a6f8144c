//! The acceleration structure and its walks.
//!
//! **Law:** a walk's answer is a function of the ray and the triangles alone: the closest hit, the lowest triangle id on
//! equal `t`. Tree shape, visiting order, packet width and the kind of walk never change a bit of it. Boxes are tested
//! conservatively, triangles watertightly. Nothing here knows of materials or radiance.
//!
//! The folder `walks` is compiled once a SIMD level, as part of [`crate::simd`].

mod build;
mod collapse;
mod edges;
pub mod flat;
pub(crate) mod huge;
pub mod node;
mod plan;
pub mod precise;
pub mod prefetch;
mod prims;
mod query;
pub mod question;
pub mod ray;
mod reinsert;
pub mod rounding;
mod sah;
mod sixteen;
mod split;
pub(crate) mod threads;

pub use crate::simd::native::walks::packets::{HitPacket, RayPacket};
pub use build::{BuildOptions, Bvh};
pub use query::Scratch;
pub use question::{RayKind, Segments, Walk};
pub use ray::{HitQueue, RayQueue, WalkCounters};
