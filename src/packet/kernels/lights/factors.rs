//! Looking up what was learned of the lights, for eight hits at once.

use super::here;
use crate::tables::lights::learned::{FACES, Grid, LearnedLights, MIRROR_BINS};
use crate::tables::lights::tree::WIDTH;
use here::lanes::{Each, F32x8, LANES, U32x8, Vec3x8};

/// The cells that eight points are in, or the nearest ones.
#[inline(always)]
pub fn cells(grid: &Grid, point: Vec3x8) -> U32x8 {
    let axis = |x: F32x8, i: usize| {
        let along = (x - F32x8::splat(grid.low[i])) * F32x8::splat(grid.scale);
        U32x8::from_f32(along.max(F32x8::ZERO).min(F32x8::splat((grid.size[i] - 1) as f32)))
    };
    let [columns, rows, _] = grid.size.each(U32x8::splat);
    (axis(point.z, 2) * rows + axis(point.y, 1)) * columns + axis(point.x, 0)
}

/// Keys of eight hits at `origin`, where the surface has the unit normal `normal`; `incoming`: of glossy surfaces, the
/// directions of the rays that hit.
#[inline(always)]
pub fn keys(grid: &Grid, origin: Vec3x8, normal: Vec3x8, incoming: Option<Vec3x8>) -> U32x8 {
    let cell = cells(grid, origin);
    let Some(incoming) = incoming else {
        let (face, _) = face(normal);
        return cell * U32x8::splat(FACES) + face;
    };
    let mirrored = incoming - normal.scale(F32x8::splat(2.0) * incoming.dot(normal));
    let (face, [b, c]) = face(mirrored);
    let bin = face * U32x8::splat(4) + bit(b, 1) + bit(c, 2);
    U32x8::splat(grid.cells() * FACES) + cell * U32x8::splat(MIRROR_BINS) + bin
}

/// Two times the dominant axis, plus 1 if it points down; and the other two components.
#[inline(always)]
fn face(v: Vec3x8) -> (U32x8, [F32x8; 2]) {
    let size = v.abs();
    let along_x = size.x.ge(size.y) & size.x.ge(size.z);
    let along_y = size.y.ge(size.z).and_not(along_x);
    let largest = along_x.select(v.x, along_y.select(v.y, v.z));
    let axis = along_x.select_u32(U32x8::ZERO, along_y.select_u32(U32x8::splat(2), U32x8::splat(4)));
    let others = [along_x.select(v.y, v.x), along_y.select(v.z, along_x.select(v.z, v.y))];
    (axis + bit(largest, 1), others)
}

/// `value` where `x` is below 0, else 0.
#[inline(always)]
fn bit(x: F32x8, value: u32) -> U32x8 {
    x.lt(F32x8::ZERO).select_u32(U32x8::splat(value), U32x8::ZERO)
}

/// What the importances of the columns of eight nodes are multiplied by: `[column]` lane `i` is that of the node of lane `i`
/// for row `i`.
#[inline(always)]
pub fn factors(learned: &LearnedLights, rows: &[u32; LANES], nodes: &[u32; LANES]) -> [F32x8; WIDTH] {
    let words: [u64; LANES] = std::array::from_fn(|lane| learned.word(rows[lane], nodes[lane]));
    // Shifts of all lanes alike: bytes mapped lane by lane compiled to scalar code.
    let (low, high) = (U32x8::from_array(words.map(|w| w as u32)), U32x8::from_array(words.map(|w| (w >> 32) as u32)));
    let byte = |half: U32x8, count: u32| ((half >> count) & U32x8::splat(0xff)).to_f32();
    [
        byte(low, 0),
        byte(low, 8),
        byte(low, 16),
        byte(low, 24),
        byte(high, 0),
        byte(high, 8),
        byte(high, 16),
        byte(high, 24),
    ]
}
