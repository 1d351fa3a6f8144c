//! The acceleration structure and its walks.
//!
//! **Law:** a walk's answer is a function of the ray and the triangles alone: the closest hit, the lowest triangle id on
//! equal `t`. Tree shape, visiting order, packet width and the kind of walk never change a bit of it. Boxes are tested
//! conservatively, triangles watertightly. Nothing here knows of materials or radiance.

pub mod aim;
mod boxes;
mod build;
mod collapse;
pub(crate) mod huge;
pub mod node;
mod plan;
pub mod precise;
mod prefetch;
mod prims;
mod query;
pub mod ray;
mod reinsert;
mod sah;
mod sort;
mod split;
pub(crate) mod threads;
mod triangle;
mod walk_flat;
mod walk_packet;
mod walk_single;
mod walk_stream;

pub use build::{BuildOptions, Bvh};
pub use query::{RayKind, Scratch, Segments, Walk};
pub use ray::{HitPacket, HitQueue, RayPacket, RayQueue, WalkCounters};
