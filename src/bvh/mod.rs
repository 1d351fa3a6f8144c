//! The acceleration structure and its walks.
//!
//! **Law:** a walk's answer is a function of the ray and the triangles alone: the closest hit, the lowest triangle id on
//! equal `t`. Tree shape, visiting order, packet width and the kind of walk never change a bit of it. Boxes are tested
//! conservatively, triangles watertightly. Nothing here knows of materials or radiance.

pub mod aim;
mod boxes;
mod build;
mod collapse;
mod huge;
pub mod node;
pub mod precise;
mod prefetch;
mod query;
pub mod ray;
mod sah;
mod sixteen;
mod sort;
mod triangle;
mod walk_flat;
mod walk_packet;
mod walk_single;
mod walk_stream;

pub use build::{BuildOptions, Bvh};
pub use query::{RayKind, Scratch, Segments, Walk};
pub use ray::{HitPacket, HitQueue, RayPacket, RayQueue, WalkCounters};
