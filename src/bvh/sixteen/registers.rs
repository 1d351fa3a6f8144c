//! Between memory and registers of sixteen: the one file here that reads and writes by address. All of it is in slices and
//! arrays whose lengths are known or checked.
#![allow(unsafe_code, reason = "loads and stores of 16 lanes take addresses")]

use crate::bvh::ray::HitQueue;
use crate::bvh::sixteen::memory::Row;
use std::arch::x86_64::*;

/// The lanes of whole blocks of eight that hold the first `count` rows, `count` from 1 to 16.
#[inline(always)]
fn blocks(count: usize) -> (u16, usize) {
    if count > 8 { (0xffff, 16) } else { (0xff, 8) }
}

/// `values[first ..]`: eight of them for a `count` of up to 8, else sixteen.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn load_rows(values: &[f32], first: usize, count: usize) -> __m512 {
    let (lanes, length) = blocks(count);
    let rows = &values[first..first + length];
    // SAFETY: the lanes that are read lie in `rows`.
    unsafe { _mm512_maskz_loadu_ps(lanes, rows.as_ptr()) }
}

/// [`load_rows`] of integers.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn load_integers(values: &[u32], first: usize, count: usize) -> __m512i {
    let (lanes, length) = blocks(count);
    let rows = &values[first..first + length];
    // SAFETY: the lanes that are read lie in `rows`.
    unsafe { _mm512_maskz_loadu_epi32(lanes, rows.as_ptr().cast()) }
}

/// Writes as many hits as [`load_rows`] reads rays.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn store_hits(hits: &mut HitQueue, first: usize, count: usize, [t, u, v]: [__m512; 3], triangle: __m512i) {
    let (lanes, length) = blocks(count);
    let rows = first..first + length;
    let ids = &mut hits.triangle[rows.clone()];
    // SAFETY: the lanes that are written lie in the slices.
    unsafe {
        _mm512_mask_storeu_ps(hits.t[rows.clone()].as_mut_ptr(), lanes, t);
        _mm512_mask_storeu_ps(hits.u[rows.clone()].as_mut_ptr(), lanes, u);
        _mm512_mask_storeu_ps(hits.v[rows].as_mut_ptr(), lanes, v);
        _mm512_mask_storeu_epi32(ids.as_mut_ptr().cast(), lanes, triangle);
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn load(row: &Row) -> __m512 {
    // SAFETY: a row is sixteen numbers at a multiple of 64.
    unsafe { _mm512_load_ps(row.0.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn store(row: &mut Row, values: __m512) {
    // SAFETY: a row is sixteen numbers at a multiple of 64.
    unsafe { _mm512_store_ps(row.0.as_mut_ptr(), values) }
}

/// The numbers of a register.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn to_row(values: __m512) -> Row {
    let mut row = Row::ZERO;
    store(&mut row, values);
    row
}

/// The bits of a register of integers.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn to_integers(values: __m512i) -> [u32; 16] {
    to_row(_mm512_castsi512_ps(values)).0.map(f32::to_bits)
}

/// Both sides of eight boxes along an axis.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn load_sides(sides: &[[f32; 8]; 2]) -> __m512 {
    // SAFETY: these are sixteen numbers.
    unsafe { _mm512_loadu_ps(sides.as_ptr().cast()) }
}

/// Eight numbers, and what follows them in the register unspecified.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn load_eight(values: &[f32; 8]) -> __m512 {
    // SAFETY: these are eight numbers.
    _mm512_castps256_ps512(unsafe { _mm256_loadu_ps(values.as_ptr()) })
}

/// Eight numbers, then eight others.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn load_two(low: &[f32; 8], high: &[f32; 8]) -> __m512 {
    // SAFETY: these are eight numbers.
    _mm512_insertf32x8::<1>(load_eight(low), unsafe { _mm256_loadu_ps(high.as_ptr()) })
}

/// Eight integers twice.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn load_twice(values: &[u32; 8]) -> __m512i {
    // SAFETY: these are eight integers.
    _mm512_broadcast_i32x8(unsafe { _mm256_loadu_si256(values.as_ptr().cast()) })
}

/// `table[index]` in `lanes`, 0 in others. An index beyond the table reads its last number.
#[inline]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn gather(table: &[f32], lanes: u16, index: __m512i) -> __m512 {
    let Some(last) = table.len().checked_sub(1) else { return _mm512_setzero_ps() };
    // Indices are signed to the instruction; a table of so many numbers does not exist.
    let index = _mm512_min_epu32(index, _mm512_set1_epi32(last.min(i32::MAX as usize) as i32));
    // SAFETY: every index lies in the table.
    unsafe { _mm512_mask_i32gather_ps::<4>(_mm512_setzero_ps(), lanes, index, table.as_ptr()) }
}
