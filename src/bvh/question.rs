//! What is asked of the tree: which kinds of rays there are, which ways to walk, what shadow rays aim at.

use crate::bvh::ray::{ANY_ID, RayQueue};

/// Where rays come from: how coherent neighbours in a queue are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the camera, neighbours in the picture next to each other.
    Camera,
    /// From hits of camera rays towards lights. (Those of later hits are as scattered as [`RayKind::Bounce`].)
    Shadow,
    /// After a bounce, towards anywhere; or from there towards lights.
    Bounce,
}

/// A way to walk the tree. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walk {
    /// One ray after the other.
    Single,
    /// Eight rays together, sixteen with AVX-512.
    Packet,
    /// Many single rays in flight.
    Stream,
    /// As many together through a list of all leaves; trees too big for a list are walked by packets.
    Flat,
}

/// Segments that anything may block, and per ray the triangle it aims at: at the very end of the ray, `tmax`, only triangles
/// of lower ids block it.
#[derive(Clone, Copy)]
pub struct Segments<'a> {
    pub(crate) rays: &'a RayQueue,
    pub(crate) before: Option<&'a [u32]>,
}

impl<'a> From<&'a RayQueue> for Segments<'a> {
    /// Whatever is hit up to `tmax`, that included, blocks.
    fn from(rays: &'a RayQueue) -> Self {
        Segments { rays, before: None }
    }
}

impl<'a> Segments<'a> {
    /// Row by row, the triangles that `rays` aim at; padded as the rays are.
    pub fn aimed(rays: &'a RayQueue, before: &'a [u32]) -> Self {
        Segments { rays, before: Some(before) }
    }
    /// What the ray of one row aims at.
    #[inline(always)]
    pub(crate) fn before(&self, row: usize) -> u32 {
        self.before.map_or(ANY_ID, |before| before[row])
    }
}
