//! The walks of one level behind plain data: what `bvh::query` calls.

use super::here;
use crate::bvh::Bvh;
use crate::bvh::question::{Segments, Walk};
use crate::bvh::ray::{ANY_ID, HitQueue, HitRows, RayQueue, RayRows, WalkCounters};
use here::lanes::{LANES, Mask8, U32x8};
use here::walks::packets::{HitPacket, RayPacket};
use here::walks::walk_flat;
use here::walks::walk_packet;
use here::walks::walk_packet::PacketStack;
use here::walks::walk_single;
use here::walks::walk_single::Stack;
use here::walks::walk_stream::{CHUNK, Stream};
use std::ops::Range;

/// What the walks of this level need for a while.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    single: Stack,
    packet: PacketStack,
    stream: Stream,
    corners: Box<walk_flat::Corners>,
}

impl Scratch {
    fn reserve(&mut self, bvh: &Bvh) {
        self.single.reserve(bvh.stack_bound());
        self.packet.reserve(bvh.stack_bound());
        self.stream.reserve(bvh.stack_bound());
    }
}

/// Closest hits of the eight `rays` whose bits are set in `active`.
pub(crate) fn intersect_packet(bvh: &Bvh, rays: RayRows, active: u8, scratch: &mut Scratch) -> HitRows {
    scratch.reserve(bvh);
    let stack = &mut scratch.packet;
    let run = || -> HitRows {
        let (rays, active) = (RayPacket::from_rows(rays), Mask8::from_bits(active));
        walk_packet::closest(bvh.walk_tables(), &rays, active, stack, &mut WalkCounters::default()).to_rows()
    };
    here::run(run)
}

/// Which of the eight `rays` whose bits are set in `active` hit anything.
pub(crate) fn occluded_packet(bvh: &Bvh, rays: RayRows, active: u8, scratch: &mut Scratch) -> u8 {
    scratch.reserve(bvh);
    let stack = &mut scratch.packet;
    let run = || -> u8 {
        let (rays, active) = (RayPacket::from_rows(rays), Mask8::from_bits(active));
        let before = U32x8::splat(ANY_ID);
        walk_packet::any(bvh.walk_tables(), &rays, before, active, stack, &mut WalkCounters::default()).bits()
    };
    here::run(run)
}

/// Closest hits of the rays `range` of a queue by `walk`.
pub(crate) fn intersect_by(
    bvh: &Bvh,
    walk: Walk,
    rays: &RayQueue,
    range: Range<usize>,
    hits: &mut HitQueue,
    counters: &mut WalkCounters,
    scratch: &mut Scratch,
) {
    scratch.reserve(bvh);
    here::run(
        #[inline(always)]
        || match walk {
            Walk::Single => {
                let tables = bvh.walk_tables();
                for row in range {
                    let hit = walk_single::closest(tables, &rays.ray(row), &mut scratch.single);
                    hits.set(row, hit);
                }
            }
            Walk::Packet => by_packets(bvh, rays, range, hits, counters, &mut scratch.packet),
            Walk::Flat => {
                let Some(flat) = bvh.flat() else {
                    return by_packets(bvh, rays, range, hits, counters, &mut scratch.packet);
                };
                let corners = &mut *scratch.corners;
                for first in range.clone().step_by(LANES) {
                    let active = Mask8::first((range.end - first).min(LANES));
                    let packet = RayPacket::load(rays, first);
                    walk_flat::closest(flat, bvh.extent(), &packet, active, corners, counters).store(hits, first);
                }
            }
            Walk::Stream => {
                for chunk in range.clone().step_by(CHUNK) {
                    let count = (range.end - chunk).min(CHUNK);
                    stream_chunk::<false>(bvh, rays.into(), chunk, count, &mut scratch.stream);
                    for first in (0..count).step_by(LANES) {
                        scratch.stream.hits(first).store(hits, chunk + first);
                    }
                }
            }
        },
    );
}

#[inline(always)]
fn by_packets(
    bvh: &Bvh,
    rays: &RayQueue,
    range: Range<usize>,
    hits: &mut HitQueue,
    counters: &mut WalkCounters,
    stack: &mut PacketStack,
) {
    for first in range.clone().step_by(LANES) {
        let active = Mask8::first((range.end - first).min(LANES));
        let packet = RayPacket::load(rays, first);
        let hit: HitPacket = walk_packet::closest(bvh.walk_tables(), &packet, active, stack, counters);
        hit.store(hits, first);
    }
}

/// [`Bvh::intersect_behind`].
pub(crate) fn intersect_behind(bvh: &Bvh, rays: &RayQueue, rows: &[u32], hits: &mut HitQueue, scratch: &mut Scratch) {
    scratch.reserve(bvh);
    here::run(
        #[inline(always)]
        || {
            for row in rows.iter().map(|&row| row as usize) {
                let hit = hits.hit(row);
                let ray = rays.ray(row);
                hits.set(row, walk_single::closest_behind(bvh.walk_tables(), &ray, hit, &mut scratch.single));
            }
        },
    );
}

/// [`Bvh::occluded_but`].
pub(crate) fn occluded_but(bvh: &Bvh, rays: &RayQueue, row: usize, passed: &[u32], scratch: &mut Scratch) -> bool {
    scratch.reserve(bvh);
    let stack = &mut scratch.single;
    here::run(
        #[inline(always)]
        || walk_single::any_where(bvh.walk_tables(), &rays.ray(row), ANY_ID, stack, |id| !passed.contains(&id)),
    )
}

/// Which of the rays `range` of a queue hit anything, by `walk`: a bit a ray, from `blocked[range.start / 8]` on, which is there.
pub(crate) fn occluded_by(
    bvh: &Bvh,
    walk: Walk,
    segments: Segments,
    range: Range<usize>,
    blocked: &mut [u8],
    counters: &mut WalkCounters,
    scratch: &mut Scratch,
) {
    scratch.reserve(bvh);
    let rays = segments.rays;
    here::run(
        #[inline(always)]
        || {
            if walk == Walk::Stream {
                for chunk in range.clone().step_by(CHUNK) {
                    let count = (range.end - chunk).min(CHUNK);
                    stream_chunk::<true>(bvh, segments, chunk, count, &mut scratch.stream);
                    for first in (0..count).step_by(LANES) {
                        let lanes = Mask8::first((count - first).min(LANES)).bits();
                        blocked[(chunk + first) / LANES] = scratch.stream.blocked(first) & lanes;
                    }
                }
                return;
            }
            let corners = &mut *scratch.corners;
            // Rays that aim at something are for scenes with precise triangles, which no list has.
            let flat = bvh.flat().filter(|_| walk == Walk::Flat && segments.before.is_none());
            for first in range.clone().step_by(LANES) {
                let lanes = (range.end - first).min(LANES);
                blocked[first / LANES] = match walk {
                    Walk::Single => {
                        let tables = bvh.walk_tables();
                        let mut bits = 0;
                        for lane in 0..lanes {
                            let (ray, before) = (rays.ray(first + lane), segments.before(first + lane));
                            bits |= (walk_single::any(tables, &ray, before, &mut scratch.single) as u8) << lane;
                        }
                        bits
                    }
                    Walk::Packet | Walk::Stream | Walk::Flat => {
                        let (packet, active) = (RayPacket::load(rays, first), Mask8::first(lanes));
                        match flat {
                            Some(flat) => walk_flat::any(flat, bvh.extent(), &packet, active, corners, counters).bits(),
                            None => {
                                let (before, stack) = (before8(&segments, first), &mut scratch.packet);
                                walk_packet::any(bvh.walk_tables(), &packet, before, active, stack, counters).bits()
                            }
                        }
                    }
                };
            }
        },
    );
}

/// What eight rays aim at.
#[inline(always)]
fn before8(segments: &Segments, first: usize) -> U32x8 {
    segments.before.map_or(U32x8::splat(ANY_ID), |before| U32x8::load(before, first))
}

#[inline(always)]
fn stream_chunk<const ANY: bool>(bvh: &Bvh, segments: Segments, chunk: usize, count: usize, stream: &mut Stream) {
    let rays = segments.rays;
    for first in (0..count).step_by(LANES) {
        let before = ANY.then(|| before8(&segments, chunk + first));
        stream.set_packet(first, &RayPacket::load(rays, chunk + first), before, bvh.extent());
    }
    stream.walk::<ANY>(bvh.walk_tables(), count, |row| rays.ray(chunk + row));
}
