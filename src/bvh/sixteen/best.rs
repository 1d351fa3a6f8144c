//! The closest hits of sixteen rays so far; what blocks sixteen rays.

use crate::bvh::ray::{HitQueue, NO_HIT};
use crate::bvh::sixteen::rays::Rays;
use crate::bvh::sixteen::registers::store_hits;
use crate::bvh::sixteen::triangle::{Decided, Edges};
use std::arch::x86_64::*;

/// The closest hits of sixteen rays so far. Dividing `v` and `w` waits until the walk is over.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) t: __m512,
    pub(super) triangle: __m512i,
    pub(super) v: __m512,
    pub(super) w: __m512,
    pub(super) det: __m512,
}

impl Best {
    /// Nothing hit up to `tmax`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn none(tmax: __m512) -> Self {
        let zero = _mm512_setzero_ps();
        Self { t: tmax, triangle: _mm512_set1_epi32(NO_HIT as i32), v: zero, w: zero, det: _mm512_set1_ps(1.0) }
    }

    /// Takes the hits of triangle `id` among `lanes` that are closer, or as close and of a lower id. All lanes of `lanes` are
    /// inside.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn update(&mut self, edges: &Edges, id: u32, lanes: u16, tmin: __m512) {
        let t = edges.t();
        self.take_closer(lanes, t, _mm512_set1_epi32(id as i32), [edges.v, edges.w, edges.det], tmin);
    }

    /// [`Best::update`] for a triangle whose id is lower than those of all before it: on equal `t` it is the one.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn update_descending(&mut self, edges: &Edges, id: u32, lanes: u16, tmin: __m512) {
        let t = edges.t();
        let behind = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(lanes & edges.inside, t, tmin);
        let take = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(behind, t, self.t);
        self.take(take, t, _mm512_set1_epi32(id as i32), [edges.v, edges.w, edges.det]);
    }

    /// [`Best::update`] of what f64 had a say in.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn update_decided(&mut self, hits: &Decided, id: u32, tmin: __m512) {
        self.take_closer(hits.hit, hits.t, _mm512_set1_epi32(id as i32), [hits.v, hits.w, hits.det], tmin);
    }

    /// Takes those of `lanes` that are behind `tmin` and closer, or as close and of a lower id.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn take_closer(&mut self, lanes: u16, t: __m512, id: __m512i, found: [__m512; 3], tmin: __m512) {
        let behind = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(lanes, t, tmin);
        let lower = _mm512_cmplt_epu32_mask(id, self.triangle);
        let closer =
            _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, self.t) | (_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(t, self.t) & lower);
        self.take(behind & closer, t, id, found);
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    fn take(&mut self, take: u16, t: __m512, id: __m512i, [v, w, det]: [__m512; 3]) {
        self.t = _mm512_mask_mov_ps(self.t, take, t);
        self.triangle = _mm512_mask_mov_epi32(self.triangle, take, id);
        self.v = _mm512_mask_mov_ps(self.v, take, v);
        self.w = _mm512_mask_mov_ps(self.w, take, w);
        self.det = _mm512_mask_mov_ps(self.det, take, det);
    }

    /// Writes the finished hits of rays `first .. first + count`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn store(&self, rays: &Rays, hits: &mut HitQueue, first: usize, count: usize) {
        let t = _mm512_mask_mov_ps(rays.given, rays.active, self.t);
        let (u, v) = (_mm512_div_ps(self.v, self.det), _mm512_div_ps(self.w, self.det));
        store_hits(hits, first, count, [t, u, v], self.triangle);
    }
}

/// Where rays end: before `tmax`, and at `tmax` itself if the id of what is hit is below that of `before`.
#[derive(Clone, Copy)]
pub(super) struct Ends {
    pub(super) tmin: __m512,
    pub(super) tmax: __m512,
    pub(super) before: __m512i,
}

impl Ends {
    /// Which of `lanes`, that hit triangles `ids` at `t`, are blocked.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn blocked(&self, lanes: u16, t: __m512, ids: __m512i) -> u16 {
        let behind = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(lanes, t, self.tmin);
        let lower = _mm512_cmplt_epi32_mask(ids, self.before);
        let at_end = _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(lower, t, self.tmax);
        behind & (at_end | _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, self.tmax))
    }
}
