//! Sixteen rays at a time through the tree; the twin is [`crate::simd::native::walks::walk_packet`], which says what was tried.

use crate::bvh::node::{Tables, holds_precise, is_leaf, triangles_in};
use crate::bvh::ray::{ANY_ID, HitQueue, RayQueue, WalkCounters};
use crate::bvh::rounding::WIDENING;
use crate::bvh::sixteen::LANES;
use crate::bvh::sixteen::best::{Best, Ends};
use crate::bvh::sixteen::memory::Memory;
use crate::bvh::sixteen::rays::Rays;
use crate::bvh::sixteen::registers::{load, load_integers, store};
use crate::bvh::sixteen::search::Search;
use std::arch::x86_64::*;
use std::ops::Range;

/// Whether a leaf of `triangles` triangles, which `live` rays enter, is tested by rays: two rays against eight triangles take a
/// little longer than sixteen rays against one. Same bits both ways.
#[inline(always)]
fn few(live: u16, triangles: usize) -> bool {
    live.count_ones() as usize * 2 <= triangles
}

/// The largest of sixteen distances, widened.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
fn farthest_of(t: __m512) -> f32 {
    _mm512_reduce_max_ps(t) * WIDENING
}

/// Closest hits of rays `rows` of a queue.
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn closest(
    tables: Tables,
    (queue, rows): (&RayQueue, Range<usize>),
    hits: &mut HitQueue,
    memory: &mut Memory,
    counters: &mut WalkCounters,
) {
    for first in rows.clone().step_by(LANES) {
        let count = (rows.end - first).min(LANES);
        let rays = Rays::of(queue, first, count);
        let best = if rays.active == 0 {
            Best::none(rays.given)
        } else {
            Search::make(tables, &rays, |search| closest_of(search, memory, counters))
        };
        best.store(&rays, hits, first, count);
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
fn closest_of(search: &Search, memory: &mut Memory, counters: &mut WalkCounters) -> Best {
    let (words, nears) = (&mut memory.words[..], &mut memory.near[..]);
    let active = search.rays.active;
    let mut best = Best::none(search.rays.tmax);
    let widening = _mm512_set1_ps(WIDENING);
    let missed = _mm512_set1_ps(f32::NAN);
    let mut best_wide = _mm512_mul_ps(best.t, widening);
    let mut farthest = farthest_of(best.t);
    let mut top = 0;
    let (mut next, mut live) = (0, active);
    let (mut steps, mut used) = (0, 0);
    'walk: loop {
        steps += 1;
        used += u64::from(live.count_ones());
        if is_leaf(next) {
            let before = best.t;
            if holds_precise(next) {
                best = search.closest_carefully(next, 0..triangles_in(next), live, best);
            } else if few(live, triangles_in(next)) {
                search.closest_by_rays(next, live, &mut best);
            } else {
                search.closest_by_triangles(next, live, &mut best);
            }
            if _mm512_cmp_ps_mask::<_CMP_LT_OQ>(best.t, before) != 0 {
                best_wide = _mm512_mul_ps(best.t, widening);
                if search.interval.is_some() {
                    farthest = farthest_of(best.t);
                }
            }
        } else {
            let node = &search.tables.nodes[next as usize];
            let mut children = search.children(next, farthest);
            // The child that is visited next, and its rays; none yet.
            let (mut word, mut near, mut entered) = (0, missed, 0);
            while children != 0 {
                let child = children.trailing_zeros() as usize & 7;
                children &= children - 1;
                let (entry, hit) = search.boxes.test(node, child, live, best_wide);
                if hit == 0 {
                    continue;
                }
                let entry = _mm512_mask_mov_ps(missed, hit, entry);
                let this = node.children[child];
                if entered == 0 {
                    (word, near, entered) = (this, entry, hit);
                    continue;
                }
                // The child that any ray enters first goes first.
                let (later, later_near);
                if _mm512_cmp_ps_mask::<_CMP_LT_OQ>(entry, near) != 0 {
                    (later, later_near) = (word, near);
                    (word, near, entered) = (this, entry, hit);
                } else {
                    (later, later_near) = (this, entry);
                }
                words[top] = later;
                store(&mut nears[top], later_near);
                top += 1;
            }
            if entered != 0 {
                (next, live) = (word, entered);
                continue;
            }
        }
        loop {
            if top == 0 {
                break 'walk;
            }
            top -= 1;
            live = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(active, load(&nears[top]), best_wide);
            if live != 0 {
                next = words[top];
                break;
            }
        }
    }
    counters.lanes_possible += LANES as u64 * steps;
    counters.lanes_used += used;
    best
}

/// Which of the rays `rows` of a queue hit anything, see [`crate::bvh::sixteen::Sixteen::any`].
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn any(
    tables: Tables,
    (queue, before, rows): (&RayQueue, Option<&[u32]>, Range<usize>),
    blocked: &mut [u8],
    memory: &mut Memory,
    counters: &mut WalkCounters,
) {
    for first in rows.clone().step_by(LANES) {
        let count = (rows.end - first).min(LANES);
        let rays = Rays::of(queue, first, count);
        let bits = if rays.active == 0 {
            0
        } else {
            let before = match before {
                Some(before) => load_integers(before, first, count),
                None => _mm512_set1_epi32(ANY_ID as i32),
            };
            Search::make(tables, &rays, |search| any_of(search, before, memory, counters))
        };
        let bytes = &mut blocked[first / 8..(first + count).div_ceil(8)];
        bytes.copy_from_slice(&bits.to_le_bytes()[..bytes.len()]);
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
fn any_of(search: &Search, before: __m512i, memory: &mut Memory, counters: &mut WalkCounters) -> u16 {
    let (words, masks) = (&mut memory.words[..], &mut memory.masks[..]);
    let Rays { tmin, tmax, active, .. } = *search.rays;
    let ends = Ends { tmin, tmax, before };
    let best_wide = _mm512_mul_ps(tmax, _mm512_set1_ps(WIDENING));
    let farthest = farthest_of(tmax);
    let mut open = active;
    let mut top = 0;
    let (mut next, mut live) = (0, active);
    let (mut steps, mut used) = (0, 0);
    'walk: loop {
        steps += 1;
        used += u64::from(live.count_ones());
        if is_leaf(next) {
            open &= !if holds_precise(next) {
                search.blocked_carefully(next, 0..triangles_in(next), live, &ends)
            } else if few(live, triangles_in(next)) {
                search.blocked_by_rays(next, live, &ends)
            } else {
                search.blocked_by_triangles(next, live, &ends)
            };
            if open == 0 {
                break;
            }
        } else {
            let node = &search.tables.nodes[next as usize];
            let mut children = search.children(next, farthest);
            let (mut word, mut entered) = (0, 0);
            while children != 0 {
                // The first child, the largest, is pushed last and visited first.
                let child = children.ilog2() as usize & 7;
                children &= !(1 << child);
                let (_, hit) = search.boxes.test(node, child, live, best_wide);
                if hit != 0 {
                    // What is not kept is written over, which costs less than asking.
                    words[top] = word;
                    masks[top] = entered;
                    top += usize::from(entered != 0);
                    (word, entered) = (node.children[child], hit);
                }
            }
            if entered != 0 {
                (next, live) = (word, entered);
                continue;
            }
        }
        loop {
            if top == 0 {
                break 'walk;
            }
            top -= 1;
            live = masks[top] & open;
            if live != 0 {
                next = words[top];
                break;
            }
        }
    }
    counters.lanes_possible += LANES as u64 * steps;
    counters.lanes_used += used;
    active & !open
}
