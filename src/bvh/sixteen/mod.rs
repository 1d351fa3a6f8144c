//! Sixteen rays at a time with AVX-512: two packets of eight side by side, through the tree and through the list of leaves.
//!
//! **Law:** these walks give the bits of all others. Their twins are `walk_packet` and `walk_flat`, which other CPUs use; what
//! decides a hit is done here operation by operation as there. Tests of boxes are conservative, so they may differ.
//!
//! Sixteen lanes alone gain nothing: the walks of eight, compiled for AVX-512, were as fast as before. What gains is that
//! - a mask is a word: lanes are counted and asked for in a cycle, and an any-hit stack keeps two bytes an entry;
//! - whether anyone still wants the top of the stack is one masked comparison;
//! - near and far sides of eight boxes lie in one register, so that one chain of operations tests an interval;
//! - rays of one octant read the sides of a box directly, in trees too small for intervals as well;
//! - a leaf that few rays enter is tested two rays at a time, each against the eight triangles at once.
#![cfg_attr(not(target_arch = "x86_64"), allow(unused_variables, dead_code))]

#[cfg(target_arch = "x86_64")]
mod best;
#[cfg(target_arch = "x86_64")]
mod boxes;
#[cfg(target_arch = "x86_64")]
mod list;
mod memory;
#[cfg(target_arch = "x86_64")]
mod rays;
#[cfg(target_arch = "x86_64")]
mod registers;
#[cfg(target_arch = "x86_64")]
mod search;
#[cfg(target_arch = "x86_64")]
mod tree;
#[cfg(target_arch = "x86_64")]
mod triangle;

use crate::bvh::flat::Flat;
use crate::bvh::node::Tables;
use crate::bvh::ray::{HitQueue, RayQueue, WalkCounters};
use crate::simd::SimdLevel;
use std::ops::Range;

pub(super) use memory::Memory;

/// Rays that are followed together.
const LANES: usize = 16;

/// The proof that this CPU has what these walks are compiled for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sixteen(());

#[allow(unsafe_code, reason = "calls what needs AVX-512, where the CPU has it")]
impl Sixteen {
    /// If `level` is AVX-512 and this CPU has that.
    pub(super) fn of(level: SimdLevel) -> Option<Sixteen> {
        (level == SimdLevel::Avx512 && level.is_on_this_cpu()).then_some(Sixteen(()))
    }

    /// Closest hits of the rays `rows`, through the tree.
    pub(super) fn closest(
        self,
        tables: Tables,
        (rays, rows): (&RayQueue, Range<usize>),
        hits: &mut HitQueue,
        memory: &mut Memory,
        counters: &mut WalkCounters,
    ) {
        // SAFETY: there is a `Sixteen` only where the CPU has all that this function is compiled for.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            tree::closest(tables, (rays, rows), hits, memory, counters);
        }
    }

    /// Which of the rays `rows` hit anything before `tmax`, or at `tmax` itself a triangle of an id below that in their row of
    /// `before`, through the tree; a bit a ray, at `blocked[row / 8]`.
    pub(super) fn any(
        self,
        tables: Tables,
        (rays, before, rows): (&RayQueue, Option<&[u32]>, Range<usize>),
        blocked: &mut [u8],
        memory: &mut Memory,
        counters: &mut WalkCounters,
    ) {
        // SAFETY: as for `closest`.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            tree::any(tables, (rays, before, rows), blocked, memory, counters);
        }
    }

    /// Closest hits of the rays `rows`, through the list of a scene that reaches to `extent`.
    pub(super) fn closest_in_list(
        self,
        (list, extent): (&Flat, f32),
        (rays, rows): (&RayQueue, Range<usize>),
        hits: &mut HitQueue,
        memory: &mut Memory,
        counters: &mut WalkCounters,
    ) {
        // SAFETY: as for `closest`.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            list::closest((list, extent), (rays, rows), hits, memory, counters);
        }
    }

    /// Which of the rays `rows` hit anything up to `tmax`, through the list; as [`Sixteen::any`] writes it.
    pub(super) fn any_in_list(
        self,
        (list, extent): (&Flat, f32),
        (rays, rows): (&RayQueue, Range<usize>),
        blocked: &mut [u8],
        memory: &mut Memory,
        counters: &mut WalkCounters,
    ) {
        // SAFETY: as for `closest`.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            list::any((list, extent), (rays, rows), blocked, memory, counters);
        }
    }
}
