//! Questions to the tree: by packet, by queue, by stream; which walk answers them.

use crate::bvh::build::Bvh;
use crate::bvh::question::{RayKind, Segments, Walk};
use crate::bvh::ray::{HitQueue, RayQueue, WalkCounters};
use crate::bvh::sixteen::{Memory, Sixteen};
use crate::fault::{Fault, planted};
use crate::lanes::{LANES, Mask8};
use crate::simd::native::walks::packets::{HitPacket, RayPacket};
use crate::simd::{SimdLevel, by_level, native};
use std::cell::RefCell;
use std::ops::Range;

#[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
use crate::simd::avx2;

/// What walks need for a while. Keep one per thread: it grows to its size once.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    native: native::walks::ask::Scratch,
    #[cfg(all(target_arch = "x86_64", not(target_feature = "avx2")))]
    avx2: avx2::walks::ask::Scratch,
    sixteens: Memory,
    level: Option<SimdLevel>,
}

impl Scratch {
    /// For walks that use this level, where the CPU has it: others use [`SimdLevel::used`].
    pub fn at(level: SimdLevel) -> Self {
        Self { level: Some(level), ..Self::default() }
    }

    /// The level that walks use.
    fn level(&self) -> SimdLevel {
        self.level.unwrap_or_else(SimdLevel::used)
    }

    /// If rays are followed by sixteens; and what that needs for a while, in this tree.
    fn sixteen(&mut self, bvh: &Bvh) -> Option<(Sixteen, &mut Memory)> {
        let sixteen = Sixteen::of(self.level())?;
        self.sixteens.reserve(bvh.stack_bound());
        Some((sixteen, &mut self.sixteens))
    }

    /// The share of live lanes above which packets are faster than streams.
    fn together(&self, any: bool) -> f64 {
        match (Sixteen::of(self.level()), any) {
            (None, false) => CLOSEST_TOGETHER,
            (None, true) => ANY_TOGETHER,
            (Some(_), false) => CLOSEST_TOGETHER_16,
            (Some(_), true) => ANY_TOGETHER_16,
        }
    }
}

/// Up to this many scattered rays are followed one after the other.
const FEW: usize = 4;
/// Rays by which it is found out whether packets stay together.
const PROBE: usize = 64;
/// In how many places of a queue of rays of unknown kind packets are tried.
const LOOKS: usize = 8;
/// The share of live lanes above which packets are faster than streams, to the closest hit and to any: where they were
/// level in rooms with 20,000, 80,000 and 1.2 million triangles, at four densities of rays.
const CLOSEST_TOGETHER: f64 = 0.4;
const ANY_TOGETHER: f64 = 0.58;
/// The same of sixteen rays: with the shares of eight, half of what they gain is lost.
const CLOSEST_TOGETHER_16: f64 = 0.25;
const ANY_TOGETHER_16: f64 = 0.28;

thread_local! {
    /// For the packet calls, which bring no scratch of their own.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Bvh {
    /// Closest hits of eight rays. Lanes that are not active may hold anything and come back without a hit.
    pub fn intersect(&self, rays: &RayPacket, active: Mask8) -> HitPacket {
        let (rows, active) = (rays.to_rows(), active.bits());
        SCRATCH.with_borrow_mut(|scratch| {
            HitPacket::from_rows(by_level!(scratch, walks::ask::intersect_packet(self, rows, active)))
        })
    }

    /// Which of eight rays hit anything. Lanes that are not active may hold anything and come back false.
    pub fn occluded(&self, rays: &RayPacket, active: Mask8) -> Mask8 {
        let (rows, active) = (rays.to_rows(), active.bits());
        SCRATCH.with_borrow_mut(|scratch| {
            Mask8::from_bits(by_level!(scratch, walks::ask::occluded_packet(self, rows, active)))
        })
    }

    /// Closest hits of the rays `range` of a queue, written to the same rows of `hits`. `range` begins at a multiple of 8;
    /// up to seven rows after its end may be written, too.
    pub fn intersect_queue(
        &self,
        kind: RayKind,
        rays: &RayQueue,
        range: Range<usize>,
        hits: &mut HitQueue,
        scratch: &mut Scratch,
        counters: &mut WalkCounters,
    ) {
        let together = scratch.together(kind == RayKind::Shadow);
        let (walk, range) = self.probe(kind, range, together, counters, |walk, range, counters| {
            self.intersect_by(walk, rays, range, hits, scratch, counters);
        });
        self.intersect_by(walk, rays, range, hits, scratch, counters);
    }

    /// Which of the rays `range` of a queue hit anything: one byte per block of eight rays, a bit per lane, at
    /// `blocked[row / 8]`, which grows as needed. `range` begins at a multiple of 8.
    pub fn occluded_queue<'a>(
        &self,
        kind: RayKind,
        rays: impl Into<Segments<'a>>,
        range: Range<usize>,
        blocked: &mut Vec<u8>,
        scratch: &mut Scratch,
        counters: &mut WalkCounters,
    ) {
        let rays = rays.into();
        let (walk, range) = self.probe(kind, range, scratch.together(true), counters, |walk, range, counters| {
            self.occluded_by(walk, rays, range, blocked, scratch, counters);
        });
        self.occluded_by(walk, rays, range, blocked, scratch, counters);
    }

    /// Chooses the walk for rays of `kind`. Whether packets stay together depends on the scene and on how close the rays
    /// are, so the first few of the range are walked (by `walk`) to see; the walk for the others, and which are left.
    fn probe(
        &self,
        kind: RayKind,
        range: Range<usize>,
        together: f64,
        counters: &mut WalkCounters,
        walk: impl FnOnce(Walk, Range<usize>, &mut WalkCounters),
    ) -> (Walk, Range<usize>) {
        let first_choice = match self.first_choice(kind) {
            // A stream of a few rays only costs its setting up: long paths of glass are followed one or two at a time.
            Walk::Stream if range.len() <= FEW => Walk::Single,
            choice => choice,
        };
        if first_choice != Walk::Packet || range.len() < 4 * PROBE {
            return (first_choice, range);
        }
        let mut seen = WalkCounters::default();
        walk(first_choice, range.start..range.start + PROBE, &mut seen);
        counters.rays += seen.rays;
        counters.lanes_used += seen.lanes_used;
        counters.lanes_possible += seen.lanes_possible;
        let apart = (seen.lanes_used as f64) < together * seen.lanes_possible as f64;
        (if apart { self.first_choice(RayKind::Bounce) } else { first_choice }, range.start + PROBE..range.end)
    }

    /// What the first `count` rays of a queue, of which nothing is known, are best taken for: camera rays if most neighbours
    /// point nearly the same way, or if packets of a few of them, here and there, stay together; else rays after a bounce.
    pub fn likely_kind(&self, rays: &RayQueue, count: usize, scratch: &mut Scratch) -> RayKind {
        if are_alike(rays, count) {
            return RayKind::Camera;
        }
        // A list takes scattered rays faster than packets that stay half together take a tree.
        if self.flat().is_some() || count < 4 * PROBE {
            return RayKind::Bounce;
        }
        let mut some = RayQueue::with_len(LOOKS * PROBE);
        for part in 0..LOOKS {
            let first = (count - PROBE) / LANES * part / (LOOKS - 1) * LANES;
            some.copy_rows(part * PROBE, rays, first, PROBE);
        }
        let (mut seen, mut hits) = (WalkCounters::default(), HitQueue::with_len(LOOKS * PROBE));
        self.intersect_by(Walk::Packet, &some, 0..LOOKS * PROBE, &mut hits, scratch, &mut seen);
        let together = seen.lanes_used as f64 >= scratch.together(false) * seen.lanes_possible as f64;
        if together { RayKind::Camera } else { RayKind::Bounce }
    }

    /// Closest hits of the first `count` rays of a queue; what kind of rays they are is found out by trying some.
    pub fn intersect_stream(&self, rays: &RayQueue, count: usize, hits: &mut HitQueue) {
        hits.resize(count);
        SCRATCH.with_borrow_mut(|scratch| {
            let kind = self.likely_kind(rays, count, scratch);
            self.intersect_queue(kind, rays, 0..count, hits, scratch, &mut WalkCounters::default());
        });
    }

    /// Which of the first `count` rays of a queue hit anything, as [`Bvh::occluded_queue`] writes it.
    pub fn occluded_stream(&self, rays: &RayQueue, count: usize, blocked: &mut Vec<u8>) {
        SCRATCH.with_borrow_mut(|scratch| {
            let kind = self.likely_kind(rays, count, scratch);
            self.occluded_queue(kind, rays, 0..count, blocked, scratch, &mut WalkCounters::default());
        });
    }

    /// The walk that is tried first for rays of `kind` in this tree.
    pub fn first_choice(&self, kind: RayKind) -> Walk {
        match kind {
            RayKind::Camera | RayKind::Shadow => Walk::Packet,
            RayKind::Bounce if self.flat().is_some() => Walk::Flat,
            RayKind::Bounce => Walk::Stream,
        }
    }

    /// All walks that this tree can be walked by.
    pub fn walks(&self) -> Vec<Walk> {
        let all = [Walk::Single, Walk::Packet, Walk::Stream, Walk::Flat];
        all.into_iter().filter(|&walk| walk != Walk::Flat || self.flat().is_some()).collect()
    }

    /// [`Bvh::intersect_queue`] by a walk of one's choice.
    pub fn intersect_by(
        &self,
        walk: Walk,
        rays: &RayQueue,
        range: Range<usize>,
        hits: &mut HitQueue,
        scratch: &mut Scratch,
        counters: &mut WalkCounters,
    ) {
        assert!(range.start.is_multiple_of(LANES), "a range of rays begins at a multiple of 8");
        counters.rays += range.len() as u64;
        if walk == Walk::Single && planted(Fault::BlindWalk) {
            return;
        }
        if let (Walk::Packet | Walk::Flat, Some((sixteen, memory))) = (walk, scratch.sixteen(self)) {
            return match self.flat().filter(|_| walk == Walk::Flat) {
                Some(list) => sixteen.closest_in_list((list, self.extent()), (rays, range), hits, memory, counters),
                None => sixteen.closest(self.walk_tables(), (rays, range), hits, memory, counters),
            };
        }
        by_level!(scratch, walks::ask::intersect_by(self, walk, rays, range, hits, counters));
    }

    /// The hits of the rays `rows` of a queue, all of which hit something, become the first ones behind: of the hits later
    /// in the order of `t`, and of ids on equal `t`, the first. So a ray meets all its hits, none twice.
    pub fn intersect_behind(&self, rays: &RayQueue, rows: &[u32], hits: &mut HitQueue, scratch: &mut Scratch) {
        by_level!(scratch, walks::ask::intersect_behind(self, rays, rows, hits));
    }

    /// Whether anything but `passed` blocks the ray of one row before its end.
    pub fn occluded_but(&self, rays: &RayQueue, row: usize, passed: &[u32], scratch: &mut Scratch) -> bool {
        by_level!(scratch, walks::ask::occluded_but(self, rays, row, passed))
    }

    /// [`Bvh::occluded_queue`] by a walk of one's choice.
    pub fn occluded_by<'a>(
        &self,
        walk: Walk,
        rays: impl Into<Segments<'a>>,
        range: Range<usize>,
        blocked: &mut Vec<u8>,
        scratch: &mut Scratch,
        counters: &mut WalkCounters,
    ) {
        assert!(range.start.is_multiple_of(LANES), "a range of rays begins at a multiple of 8");
        counters.rays += range.len() as u64;
        if blocked.len() < range.end.div_ceil(LANES) {
            blocked.resize(range.end.div_ceil(LANES), 0);
        }
        let segments = rays.into();
        if let (Walk::Packet | Walk::Flat, Some((sixteen, memory))) = (walk, scratch.sixteen(self)) {
            // Rays that aim at something are for scenes with precise triangles, which no list has.
            let list = self.flat().filter(|_| walk == Walk::Flat && segments.before.is_none());
            return match list {
                Some(list) => {
                    sixteen.any_in_list((list, self.extent()), (segments.rays, range), blocked, memory, counters)
                }
                None => {
                    let rays = (segments.rays, segments.before, range);
                    sixteen.any(self.walk_tables(), rays, blocked, memory, counters)
                }
            };
        }
        by_level!(scratch, walks::ask::occluded_by(self, walk, segments, range, blocked, counters));
    }
}

/// Whether most of the first `count` rays of a queue point nearly the same way as the first of their eight.
fn are_alike(rays: &RayQueue, count: usize) -> bool {
    let direction = |row: usize| [rays.dx[row], rays.dy[row], rays.dz[row]];
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (mut alike, mut looked) = (0, 0);
    for first in (0..count).step_by((count / 64).next_multiple_of(LANES).max(LANES)) {
        let d = direction(first);
        for other in (first + 1..count.min(first + LANES)).map(direction) {
            looked += 1;
            alike += (dot(d, other) > 0.95 * dot(d, d).sqrt() * dot(other, other).sqrt()) as usize;
        }
    }
    alike * 4 >= looked * 3
}
