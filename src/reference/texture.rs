//! Texture lookup: bilinear between texel centres, repeated in both directions.

use super::{Real, Vec3};
use crate::tables::textures::TextureTable;
use std::ops::{Add, Mul};

/// The colour of `texture` at (u, v): u runs along the rows, v up, and the picture fills [0, 1) x [0, 1).
pub fn look_up(table: &TextureTable, texture: u32, uv: [Real; 2]) -> Vec3 {
    let texture = texture as usize;
    let (width, height) = (table.width[texture], table.height[texture]);
    let (left, right, along) = neighbours(uv[0], width as Real);
    let (below, above, up) = neighbours(uv[1], height as Real);
    let texel = |column: u32, row: u32| {
        let [r, g, b, _] = table.texels[(table.first[texture] + row * width + column) as usize].to_le_bytes();
        let linear = |c: u8| table.linear[c as usize] as Real;
        Vec3::new(linear(r), linear(g), linear(b))
    };
    let low = mix(texel(left, below), texel(right, below), along);
    let high = mix(texel(left, above), texel(right, above), along);
    mix(low, high, up)
}

/// The texels whose centres lie on either side of `t`, and how far along from the first to the second.
pub fn neighbours(t: Real, count: Real) -> (u32, u32, Real) {
    let x = (t - t.floor()) * count - 0.5;
    let first = x.floor();
    let second = first + 1.0;
    let wrapped = |i: Real| if i < 0.0 { i + count } else { i };
    (wrapped(first) as u32, if second < count { second } else { second - count } as u32, x - first)
}

/// What lies the fraction `along` of the way from `a` to `b`.
pub fn mix<T: Mul<Real, Output = T> + Add<Output = T>>(a: T, b: T, along: Real) -> T {
    a * (1.0 - along) + b * along
}

/// What three corners carry, at barycentric weights.
pub fn interpolate(uvs: &[[f32; 2]; 3], weights: [Real; 3]) -> [Real; 2] {
    [0, 1].map(|i| uvs[0][i] as Real * weights[0] + uvs[1][i] as Real * weights[1] + uvs[2][i] as Real * weights[2])
}
