//! Questions to the tree: by packet, by queue, by stream; which walk answers them.

use crate::bvh::build::Bvh;
use crate::bvh::ray::{ANY_ID, HitPacket, HitQueue, RayPacket, RayQueue, WalkCounters};
use crate::bvh::sixteen::{Memory, Sixteen};
use crate::bvh::walk_flat;
use crate::bvh::walk_packet;
use crate::bvh::walk_packet::PacketStack;
use crate::bvh::walk_single;
use crate::bvh::walk_single::Stack;
use crate::bvh::walk_stream::{CHUNK, Stream};
use crate::fault::{Fault, planted};
use crate::lanes::{F32x8, LANES, Mask8, U32x8};
use crate::simd::SimdLevel;
use std::cell::RefCell;
use std::ops::Range;

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

/// What walks need for a while. Keep one per thread: it grows to its size once.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    single: Stack,
    packet: PacketStack,
    stream: Stream,
    corners: Box<walk_flat::Corners>,
    sixteens: Memory,
    level: Option<SimdLevel>,
}

impl Scratch {
    /// For walks that use this level, where the CPU has it: others use [`SimdLevel::used`].
    pub fn at(level: SimdLevel) -> Self {
        Self { level: Some(level), ..Self::default() }
    }

    /// If rays are followed by sixteens.
    fn sixteen(&self) -> Option<Sixteen> {
        Sixteen::of(self.level.unwrap_or_else(SimdLevel::used))
    }

    /// The share of live lanes above which packets are faster than streams.
    fn together(&self, any: bool) -> f64 {
        match (self.sixteen(), any) {
            (None, false) => CLOSEST_TOGETHER,
            (None, true) => ANY_TOGETHER,
            (Some(_), false) => CLOSEST_TOGETHER_16,
            (Some(_), true) => ANY_TOGETHER_16,
        }
    }

    fn reserve(&mut self, bvh: &Bvh) {
        self.single.reserve(bvh.stack_bound());
        self.packet.reserve(bvh.stack_bound());
        self.stream.reserve(bvh.stack_bound());
        self.sixteens.reserve(bvh.stack_bound());
    }
}

/// Segments that anything may block, and per ray the triangle it aims at: at the very end of the ray, `tmax`, only triangles
/// of lower ids block it.
#[derive(Clone, Copy)]
pub struct Segments<'a> {
    rays: &'a RayQueue,
    before: Option<&'a [u32]>,
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
    fn before(&self, row: usize) -> u32 {
        self.before.map_or(ANY_ID, |before| before[row])
    }
    fn before8(&self, first: usize) -> U32x8 {
        self.before.map_or(U32x8::splat(ANY_ID), |before| U32x8::load(before, first))
    }
}

/// Up to this many scattered rays are followed one after the other.
const FEW: usize = 4;
/// Rays by which it is found out whether packets stay together.
const PROBE: usize = 64;
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
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.reserve(self);
            walk_packet::closest(self.walk_tables(), rays, active, &mut scratch.packet, &mut WalkCounters::default())
        })
    }

    /// Which of eight rays hit anything. Lanes that are not active may hold anything and come back false.
    pub fn occluded(&self, rays: &RayPacket, active: Mask8) -> Mask8 {
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.reserve(self);
            let packet = &mut scratch.packet;
            walk_packet::any(
                self.walk_tables(),
                rays,
                U32x8::splat(ANY_ID),
                active,
                packet,
                &mut WalkCounters::default(),
            )
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

    /// Closest hits of the first `count` rays of a queue; the kind of rays is guessed from how alike neighbours are.
    pub fn intersect_stream(&self, rays: &RayQueue, count: usize, hits: &mut HitQueue) {
        hits.resize(count);
        SCRATCH.with_borrow_mut(|scratch| {
            let kind = guess_kind(rays, count);
            self.intersect_queue(kind, rays, 0..count, hits, scratch, &mut WalkCounters::default());
        });
    }

    /// Which of the first `count` rays of a queue hit anything, as [`Bvh::occluded_queue`] writes it.
    pub fn occluded_stream(&self, rays: &RayQueue, count: usize, blocked: &mut Vec<u8>) {
        SCRATCH.with_borrow_mut(|scratch| {
            let kind = match guess_kind(rays, count) {
                RayKind::Camera => RayKind::Shadow,
                kind => kind,
            };
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
        scratch.reserve(self);
        counters.rays += range.len() as u64;
        if walk == Walk::Single && planted(Fault::BlindWalk) {
            return;
        }
        if let Some(sixteen) = scratch.sixteen() {
            let memory = &mut scratch.sixteens;
            match (walk, self.flat()) {
                (Walk::Packet, _) | (Walk::Flat, None) => {
                    return sixteen.closest(self.walk_tables(), (rays, range), hits, memory, counters);
                }
                (Walk::Flat, Some(list)) => {
                    return sixteen.closest_in_list((list, self.extent()), (rays, range), hits, memory, counters);
                }
                (Walk::Single | Walk::Stream, _) => {}
            }
        }
        match walk {
            Walk::Single => {
                let tables = self.walk_tables();
                for row in range {
                    let hit = walk_single::closest(tables, &rays.ray(row), &mut scratch.single);
                    hits.set(row, hit);
                }
            }
            Walk::Packet => {
                for first in range.clone().step_by(LANES) {
                    let active = Mask8::first((range.end - first).min(LANES));
                    let hit = walk_packet::closest(
                        self.walk_tables(),
                        &rays.packet(first),
                        active,
                        &mut scratch.packet,
                        counters,
                    );
                    hits.set_packet(first, &hit);
                }
            }
            Walk::Flat => {
                let Some(flat) = self.flat() else {
                    return self.intersect_by(Walk::Packet, rays, range, hits, scratch, counters);
                };
                let corners = &mut *scratch.corners;
                for first in range.clone().step_by(LANES) {
                    let active = Mask8::first((range.end - first).min(LANES));
                    let packet = rays.packet(first);
                    let hit = walk_flat::closest(flat, self.extent(), &packet, active, corners, counters);
                    hits.set_packet(first, &hit);
                }
            }
            Walk::Stream => {
                for chunk in range.clone().step_by(CHUNK) {
                    let count = (range.end - chunk).min(CHUNK);
                    self.stream_chunk::<false>(rays.into(), chunk, count, &mut scratch.stream);
                    for first in (0..count).step_by(LANES) {
                        hits.set_packet(chunk + first, &scratch.stream.hits(first));
                    }
                }
            }
        }
    }

    /// The hits of the rays `rows` of a queue, all of which hit something, become the first ones behind: of the hits later
    /// in the order of `t`, and of ids on equal `t`, the first. So a ray meets all its hits, none twice.
    pub fn intersect_behind(&self, rays: &RayQueue, rows: &[u32], hits: &mut HitQueue, scratch: &mut Scratch) {
        scratch.reserve(self);
        for row in rows.iter().map(|&row| row as usize) {
            let hit = hits.hit(row);
            hits.set(row, walk_single::closest_behind(self.walk_tables(), &rays.ray(row), hit, &mut scratch.single));
        }
    }

    /// Whether anything but `passed` blocks the ray of one row before its end.
    pub fn occluded_but(&self, rays: &RayQueue, row: usize, passed: &[u32], scratch: &mut Scratch) -> bool {
        scratch.reserve(self);
        let stack = &mut scratch.single;
        walk_single::any_where(self.walk_tables(), &rays.ray(row), ANY_ID, stack, |id| !passed.contains(&id))
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
        let segments = rays.into();
        let rays = segments.rays;
        assert!(range.start.is_multiple_of(LANES), "a range of rays begins at a multiple of 8");
        scratch.reserve(self);
        counters.rays += range.len() as u64;
        if blocked.len() < range.end.div_ceil(LANES) {
            blocked.resize(range.end.div_ceil(LANES), 0);
        }
        if walk == Walk::Stream {
            for chunk in range.clone().step_by(CHUNK) {
                let count = (range.end - chunk).min(CHUNK);
                self.stream_chunk::<true>(segments, chunk, count, &mut scratch.stream);
                for first in (0..count).step_by(LANES) {
                    let lanes = Mask8::first((count - first).min(LANES)).bits();
                    blocked[(chunk + first) / LANES] = scratch.stream.blocked(first) & lanes;
                }
            }
            return;
        }
        // Rays that aim at something are for scenes with precise triangles, which no list has.
        let flat = self.flat().filter(|_| walk == Walk::Flat && segments.before.is_none());
        if let Some(sixteen) = scratch.sixteen().filter(|_| walk != Walk::Single) {
            let memory = &mut scratch.sixteens;
            return match flat {
                Some(list) => sixteen.any_in_list((list, self.extent()), (rays, range), blocked, memory, counters),
                None => sixteen.any(self.walk_tables(), (rays, segments.before, range), blocked, memory, counters),
            };
        }
        let corners = &mut *scratch.corners;
        for first in range.clone().step_by(LANES) {
            let lanes = (range.end - first).min(LANES);
            blocked[first / LANES] = match walk {
                Walk::Single => {
                    let tables = self.walk_tables();
                    let is_blocked = |lane: usize| {
                        let (ray, before) = (rays.ray(first + lane), segments.before(first + lane));
                        walk_single::any(tables, &ray, before, &mut scratch.single) as u8
                    };
                    (0..lanes).map(is_blocked).enumerate().fold(0, |bits, (lane, bit)| bits | bit << lane)
                }
                Walk::Packet | Walk::Stream | Walk::Flat => {
                    let (packet, active) = (rays.packet(first), Mask8::first(lanes));
                    match flat {
                        Some(flat) => walk_flat::any(flat, self.extent(), &packet, active, corners, counters).bits(),
                        None => {
                            let (before, stack) = (segments.before8(first), &mut scratch.packet);
                            walk_packet::any(self.walk_tables(), &packet, before, active, stack, counters).bits()
                        }
                    }
                }
            };
        }
    }

    fn stream_chunk<const ANY: bool>(&self, segments: Segments, chunk: usize, count: usize, stream: &mut Stream) {
        let rays = segments.rays;
        for first in (0..count).step_by(LANES) {
            let before = ANY.then(|| segments.before8(chunk + first));
            stream.set_packet(first, &rays.packet(chunk + first), before, self.extent());
        }
        stream.walk::<ANY>(self.walk_tables(), count, |row| rays.ray(chunk + row));
    }
}

/// Camera-like if most rays share their octant with the next one and point nearly the same way, else bounced.
fn guess_kind(rays: &RayQueue, count: usize) -> RayKind {
    let (mut alike, mut looked) = (0, 0);
    for first in (0..count).step_by((count / 64).next_multiple_of(LANES).max(LANES)) {
        let d = rays.packet(first).direction;
        let length = d.dot(d).sqrt().to_array();
        let first_d = crate::lanes::Vec3x8::new(
            F32x8::splat(d.x.to_array()[0]),
            F32x8::splat(d.y.to_array()[0]),
            F32x8::splat(d.z.to_array()[0]),
        );
        let cosine = first_d.dot(d).to_array();
        for lane in 1..LANES.min(count - first) {
            looked += 1;
            alike += (cosine[lane] > 0.95 * length[0] * length[lane]) as usize;
        }
    }
    if alike * 4 >= looked * 3 { RayKind::Camera } else { RayKind::Bounce }
}
