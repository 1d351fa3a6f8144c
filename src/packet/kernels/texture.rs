//! Texture lookup for eight lanes: bilinear between texel centres, repeated in both directions.

use super::here;
use crate::tables::textures::{NO_TEXTURE, TextureTable};
use here::lanes::{Each, F32x8, U32x8, Vec3x8, inlined};

/// The colours at `uv`; white where there is no texture.
#[inline(always)]
pub fn look_up(table: &TextureTable, texture: U32x8, uv: [F32x8; 2]) -> Vec3x8 {
    let none = texture.eq(U32x8::splat(NO_TEXTURE));
    let white = Vec3x8::splat([1.0; 3]);
    if none.all() {
        return white;
    }
    // Idle lanes look at the first texel of the first texture, wherever their coordinates lead.
    let texture = none.select_u32(U32x8::ZERO, texture);
    let uv = uv.each(
        #[inline(always)]
        |t| none.select(F32x8::ZERO, t),
    );
    let (width, height) = (U32x8::gather(&table.width, texture), U32x8::gather(&table.height, texture));
    let first = U32x8::gather(&table.first, texture);
    let (left, right, along) = neighbours(uv[0], width.to_f32());
    let (below, above, up) = neighbours(uv[1], height.to_f32());
    let texel = inlined(
        #[inline(always)]
        |column: U32x8, row: U32x8| decode(table, first + row * width + column),
    );
    let low = mix3(texel(left, below), texel(right, below), along);
    let high = mix3(texel(left, above), texel(right, above), along);
    none.select_vec3(white, mix3(low, high, up))
}

/// The linear colours of eight texels.
#[inline(always)]
fn decode(table: &TextureTable, at: U32x8) -> Vec3x8 {
    let texel = U32x8::gather(&table.texels, at);
    let byte = |shift: u32| F32x8::gather(&table.linear, (texel >> shift) & U32x8::splat(0xff));
    Vec3x8::new(byte(0), byte(8), byte(16))
}

/// The texels whose centres lie on either side of `t`, and how far along from the first to the second.
#[inline(always)]
pub(super) fn neighbours(t: F32x8, count: F32x8) -> (U32x8, U32x8, F32x8) {
    let x = (t - t.floor()) * count - F32x8::splat(0.5);
    let first = x.floor();
    let second = first + F32x8::ONE;
    let wrapped = first.lt(F32x8::ZERO).select(first + count, first);
    let next = second.lt(count).select(second, second - count);
    (U32x8::from_f32(wrapped), U32x8::from_f32(next), x - first)
}

#[inline(always)]
fn mix3(a: Vec3x8, b: Vec3x8, along: F32x8) -> Vec3x8 {
    a.scale(F32x8::ONE - along) + b.scale(along)
}

/// What lies the fractions `along` of the way from `a` to `b`.
#[inline(always)]
pub(super) fn mix(a: F32x8, b: F32x8, along: F32x8) -> F32x8 {
    a * (F32x8::ONE - along) + b * along
}

/// What three corners carry, at barycentric weights: `corners` is u, v of each.
#[inline(always)]
pub fn interpolate(corners: [F32x8; 6], weights: [F32x8; 3]) -> [F32x8; 2] {
    [0, 1].each(
        #[inline(always)]
        |i: usize| corners[i] * weights[0] + corners[i + 2] * weights[1] + corners[i + 4] * weights[2],
    )
}
