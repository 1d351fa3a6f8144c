//! The acceleration structure and its walks.
//!
//! **Law:** a walk's answer is a function of the ray and the triangles alone: the closest hit, the lowest triangle id on
//! equal `t`. Tree shape, visiting order, packet width and the kind of walk never change a bit of it. Boxes are tested
//! conservatively, triangles watertightly. Nothing here knows of materials or radiance.

pub mod ray;

pub use ray::{HitPacket, HitQueue, RayPacket, RayQueue};
