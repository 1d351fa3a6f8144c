//! Sixteen rays on their way through a tree: what is ready for them, and how they are tested against leaves.

use crate::bvh::node::{Tables, block_of, triangles_in};
use crate::bvh::sixteen::best::{Best, Ends};
use crate::bvh::sixteen::boxes::{Boxes, Interval};
use crate::bvh::sixteen::rays::Rays;
use crate::bvh::sixteen::registers::{load_twice, to_row};
use crate::bvh::sixteen::triangle::{Decided, Triangles, decided, ones};
use std::arch::x86_64::*;
use std::ops::Range;

/// Sixteen rays on their way through a tree. What is ready for them stays where it was made: together it is 3 KiB, and copying
/// that would take as long as a short walk.
pub(super) struct Search<'a> {
    pub(super) rays: &'a Rays,
    pub(super) tables: Tables<'a>,
    pub(super) boxes: &'a Boxes,
    pub(super) interval: Option<&'a Interval>,
    triangles: &'a Triangles,
    /// Of the rays, for [`crate::simd::native::walks::triangle::least_det`].
    reach: __m512,
}

impl Search<'_> {
    /// Makes all ready for `rays` and lets them walk.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn make<T>(tables: Tables, rays: &Rays, walk: impl FnOnce(&Search) -> T) -> T {
        let boxes = Boxes::new(rays, tables.extent);
        let triangles = Triangles::new(rays);
        let interval;
        let interval = match boxes.octant {
            // In the smallest trees it is not worth its making.
            Some(places) if tables.nodes.len() >= 32 => {
                interval = Interval::new(rays, &boxes, places, tables.extent);
                Some(&interval)
            }
            _ => None,
        };
        let reach = rays.reach(tables.extent);
        walk(&Search { rays, tables, boxes: &boxes, interval, triangles: &triangles, reach })
    }

    /// Of node `node`, the children that any ray may enter before `farthest`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn children(&self, node: u32, farthest: f32) -> u32 {
        let node = &self.tables.nodes[node as usize];
        match &self.interval {
            Some(interval) => interval.test(node, farthest).into(),
            None => (1 << node.count()) - 1,
        }
    }

    /// What a triangle's `|det|` is compared with for the rays to see those of leaf `leaf` edge-on.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn least_det(&self, leaf: usize) -> __m512 {
        _mm512_mul_ps(self.reach, _mm512_set1_ps(self.tables.least_det[leaf]))
    }

    /// Tells of triangles `which` of the leaf of `word`, and of the rays of `lanes` that hit them when f64 has had its say.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn for_each_decided(&self, word: u32, which: Range<usize>, lanes: u16, mut tell: impl FnMut(u32, Decided)) {
        let block = &self.tables.leaves[block_of(word)];
        for triangle in which {
            let id = block.ids[triangle];
            let class = self.tables.classes.get(id as usize).copied().unwrap_or(0);
            for kz in 0..3 {
                let own = lanes & self.triangles.lanes_by_axis[kz];
                if own != 0 {
                    let edges = match kz {
                        0 => self.triangles.edges::<0>(block, triangle),
                        1 => self.triangles.edges::<1>(block, triangle),
                        _ => self.triangles.edges::<2>(block, triangle),
                    };
                    let of = (block.corners(triangle), class);
                    tell(id, decided(self.rays, self.tables.extent, of, &edges, own));
                }
            }
        }
    }

    /// `best` after triangles `which` of a leaf, of which some are precise or may be seen edge-on by the rays of `lanes`. By value,
    /// so that the hits of a walk that never comes here stay in registers.
    #[cold]
    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn closest_carefully(&self, word: u32, which: Range<usize>, lanes: u16, mut best: Best) -> Best {
        self.for_each_decided(word, which, lanes, |id, hits| best.update_decided(&hits, id, self.rays.tmin));
        best
    }

    /// Which rays of `lanes` are blocked by such triangles.
    #[cold]
    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn blocked_carefully(&self, word: u32, which: Range<usize>, lanes: u16, ends: &Ends) -> u16 {
        let mut blocked = 0;
        self.for_each_decided(word, which, lanes, |id, hits| {
            blocked |= ends.blocked(hits.hit, hits.t, _mm512_set1_epi32(id as i32));
        });
        blocked
    }

    /// `best` after the triangles of the leaf of `word`, triangle by triangle.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn closest_by_triangles(&self, word: u32, live: u16, best: &mut Best) {
        let [x, y, z] = self.triangles.lanes_by_axis;
        self.closest_along::<0>(word, live & x, best);
        self.closest_along::<1>(word, live & y, best);
        self.closest_along::<2>(word, live & z, best);
    }

    /// [`Search::closest_by_triangles`] for the rays `own`, whose dominant axis is `KZ`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn closest_along<const KZ: usize>(&self, word: u32, own: u16, best: &mut Best) {
        if own == 0 {
            return;
        }
        let leaf = block_of(word);
        let block = &self.tables.leaves[leaf];
        for triangle in 0..triangles_in(word) {
            let edges = self.triangles.edges::<KZ>(block, triangle);
            let inside = edges.inside & own;
            if inside != 0 {
                if edges.may_be_edge_on(inside, self.least_det(leaf)) != 0 {
                    *best = self.closest_carefully(word, triangle..triangle + 1, own, *best);
                } else {
                    best.update(&edges, block.ids[triangle], inside, self.rays.tmin);
                }
            }
        }
    }

    /// `best` after the triangles of the leaf of `word`, two rays at a time.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn closest_by_rays(&self, word: u32, mut live: u16, best: &mut Best) {
        let leaf = block_of(word);
        let block = &self.tables.leaves[leaf];
        while live != 0 {
            let two = Two::take(&mut live);
            let edges = self.triangles.edges_of_two(block, two.lanes, two.from);
            if edges.inside == 0 {
                continue;
            }
            if edges.may_be_edge_on(edges.inside, two.own(self.least_det(leaf))) != 0 {
                *best = self.closest_carefully(word, 0..triangles_in(word), two.mask(), *best);
                continue;
            }
            let t = edges.t();
            let behind = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(edges.inside, t, two.own(self.rays.tmin));
            let hits = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(behind, t, two.own(best.t));
            for half in 0..2 {
                let hits = hits & (0xff << (8 * half));
                if hits != 0 {
                    // Ids ascend: of equal `t` the first one counts.
                    let ts = to_row(t).0;
                    let nearest = ones(hits).reduce(|a, b| if ts[b] < ts[a] { b } else { a }).unwrap_or(0);
                    let at = _mm512_set1_epi32(nearest as i32);
                    let all = |values| _mm512_permutexvar_ps(at, values);
                    let id = _mm512_set1_epi32(block.ids[nearest & 7] as i32);
                    let found = [all(edges.v), all(edges.w), all(edges.det)];
                    best.take_closer(1 << two.lanes[half], all(t), id, found, self.rays.tmin);
                }
            }
        }
    }

    /// Which of the rays `live` are blocked by the leaf of `word`, triangle by triangle.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn blocked_by_triangles(&self, word: u32, live: u16, ends: &Ends) -> u16 {
        let [x, y, z] = self.triangles.lanes_by_axis;
        self.blocked_along::<0>(word, live & x, ends)
            | self.blocked_along::<1>(word, live & y, ends)
            | self.blocked_along::<2>(word, live & z, ends)
    }

    /// [`Search::blocked_by_triangles`] for the rays `own`, whose dominant axis is `KZ`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn blocked_along<const KZ: usize>(&self, word: u32, own: u16, ends: &Ends) -> u16 {
        if own == 0 {
            return 0;
        }
        let leaf = block_of(word);
        let block = &self.tables.leaves[leaf];
        let mut open = own;
        for triangle in 0..triangles_in(word) {
            let edges = self.triangles.edges::<KZ>(block, triangle);
            let inside = edges.inside & open;
            if inside != 0 {
                open &= !if edges.may_be_edge_on(inside, self.least_det(leaf)) != 0 {
                    self.blocked_carefully(word, triangle..triangle + 1, open, ends)
                } else {
                    ends.blocked(inside, edges.t(), _mm512_set1_epi32(block.ids[triangle] as i32))
                };
                if open == 0 {
                    break;
                }
            }
        }
        own & !open
    }

    /// Which of the rays `live` are blocked by the leaf of `word`, two rays at a time.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn blocked_by_rays(&self, word: u32, mut live: u16, ends: &Ends) -> u16 {
        let leaf = block_of(word);
        let block = &self.tables.leaves[leaf];
        let mut all_blocked = 0;
        while live != 0 {
            let two = Two::take(&mut live);
            let edges = self.triangles.edges_of_two(block, two.lanes, two.from);
            if edges.inside == 0 {
                continue;
            }
            if edges.may_be_edge_on(edges.inside, two.own(self.least_det(leaf))) != 0 {
                all_blocked |= self.blocked_carefully(word, 0..triangles_in(word), two.mask(), ends);
                continue;
            }
            let before = _mm512_permutexvar_epi32(two.from, ends.before);
            let ends = Ends { tmin: two.own(ends.tmin), tmax: two.own(ends.tmax), before };
            let blocked = ends.blocked(edges.inside, edges.t(), load_twice(&block.ids));
            all_blocked |= u16::from(blocked & 0xff != 0) << two.lanes[0];
            all_blocked |= u16::from(blocked >> 8 != 0) << two.lanes[1];
        }
        all_blocked
    }
}

/// Two rays, which take the lower and the upper eight lanes.
struct Two {
    lanes: [usize; 2],
    /// Lane by lane, which of the sixteen rays is meant.
    from: __m512i,
}

impl Two {
    /// Takes two rays off `live`; the same one twice if it is the last.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn take(live: &mut u16) -> Self {
        let low = live.trailing_zeros() as usize & 15;
        *live &= live.wrapping_sub(1);
        let high = if *live == 0 { low } else { live.trailing_zeros() as usize & 15 };
        *live &= live.wrapping_sub(1);
        let from = _mm512_mask_mov_epi32(_mm512_set1_epi32(low as i32), 0xff00, _mm512_set1_epi32(high as i32));
        Self { lanes: [low, high], from }
    }

    /// What the two have of `values`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn own(&self, values: __m512) -> __m512 {
        _mm512_permutexvar_ps(self.from, values)
    }

    fn mask(&self) -> u16 {
        1 << self.lanes[0] | 1 << self.lanes[1]
    }
}
