//! Environment maps, eight directions at a time: choose directions, find the texels of directions, and the densities.

use super::here;
use crate::tables::lights::environment::{Distribution, EnvironmentMap};
use crate::tables::lights::patches::LearnedPatches;
use here::lanes::{F32x8, LANES, U32x8, Vec3x8, atan2_turns, polar_half_turns, sin_cos_turns};

/// Eight texels.
pub struct Texels {
    /// Radiance, W sr^-1 m^-2.
    pub radiance: Vec3x8,
    /// Densities per steradian, before a distribution's floor and factor.
    pub pdf_dir: F32x8,
}

/// The texels with these indices.
#[inline(always)]
pub fn gather_texels(map: &EnvironmentMap, index: U32x8) -> Texels {
    let at = index.to_array();
    let rows: [&[f32; 4]; LANES] = std::array::from_fn(|lane| bytemuck::cast_ref(&map.texels[at[lane] as usize]));
    let column = |c: usize| F32x8::from_array(std::array::from_fn(|lane| rows[lane][c]));
    Texels { radiance: Vec3x8::new(column(0), column(1), column(2)), pdf_dir: column(3) }
}

/// Draws directions by radiance: texels, then points uniform in their solid angles. Unit directions and the texels.
///
/// `words` choose the texels, `u` the points in them: along the row, and from the nearer pole.
#[inline(always)]
pub fn sample_map(
    map: &EnvironmentMap,
    distribution: &Distribution,
    words: [U32x8; 2],
    u: [F32x8; 2],
) -> (Vec3x8, Texels) {
    // A table lookup a lane: the scalar rule is the lane rule.
    let (word, fork) = (words[0].to_array(), words[1].to_array());
    sample_texels(map, std::array::from_fn(|lane| distribution.choose([word[lane], fork[lane]])), u)
}

/// [`sample_map`], where texels are chosen by what was learned for the rows `row`; and by what factors that has multiplied the
/// densities.
#[inline(never)]
pub fn sample_learned(
    map: &EnvironmentMap,
    learned: &LearnedPatches,
    row: U32x8,
    words: [U32x8; 2],
    u: [F32x8; 2],
) -> (Vec3x8, Texels, F32x8) {
    here::run(
        #[inline(always)]
        || {
            let (word, fork, rows) = (words[0].to_array(), words[1].to_array(), row.to_array());
            let chosen: [_; LANES] = std::array::from_fn(|lane| learned.choose(rows[lane], [word[lane], fork[lane]]));
            let (direction, texels) = sample_texels(map, chosen.map(|(index, _)| index), u);
            (direction, texels, F32x8::from_array(chosen.map(|(_, ratio)| ratio)))
        },
    )
}

/// By what factors what was learned for the rows `row` multiplies the densities of texels.
#[inline(always)]
pub fn ratios(learned: &LearnedPatches, row: U32x8, index: U32x8) -> F32x8 {
    let (row, index) = (row.to_array(), index.to_array());
    F32x8::from_array(std::array::from_fn(|lane| learned.ratio_of_texel(row[lane], index[lane])))
}

/// Points in texels, uniform in their solid angles.
#[inline(always)]
fn sample_texels(map: &EnvironmentMap, index: [u32; LANES], u: [F32x8; 2]) -> (Vec3x8, Texels) {
    let row = U32x8::from_array(index.map(|index| index / map.width));
    let column = U32x8::from_array(index.map(|index| index % map.width));
    let turns = (column.to_f32() + u[0]) / F32x8::splat(map.width as f32) - F32x8::splat(map.turn);
    let turns = turns.lt(F32x8::ZERO).select(turns + F32x8::ONE, turns);
    let (sine, cosine) = sin_cos_turns(turns);
    let (one, last_row) = (U32x8::splat(1), U32x8::splat(map.height - 1));
    let from_south = last_row - row;
    let middle = row.eq(from_south);
    let twice = u[1] + u[1];
    let lower_half = twice.ge(F32x8::ONE);
    let down = middle.select(lower_half.select(twice - F32x8::ONE, twice), u[1]);
    let south = (middle & lower_half) | from_south.lt_signed(row);
    let row = row.min_signed(from_south);
    let near = F32x8::gather(&map.row_edges, row);
    let far = F32x8::gather(&map.row_edges, row + one);
    let versine = near + down * (far - near);
    let radius = (versine * (F32x8::splat(2.0) - versine)).sqrt();
    let height = F32x8::ONE - versine;
    let y = south.select(-height, height);
    (Vec3x8::new(-(radius * sine), y, radius * cosine), gather_texels(map, U32x8::from_array(index)))
}

/// Densities per steradian of [`sample_map`] in the directions of `texels`.
#[inline(always)]
pub fn map_pdf_dir(distribution: &Distribution, texels: &Texels) -> F32x8 {
    let rest = texels.pdf_dir - F32x8::splat(distribution.floor);
    rest.max(F32x8::ZERO) * F32x8::splat(distribution.factor)
}

/// The indices of the texels that unit directions look at.
#[inline(always)]
pub fn texel_indices(map: &EnvironmentMap, direction: Vec3x8) -> U32x8 {
    let last_column = U32x8::splat(map.width - 1);
    let turns = atan2_turns(-direction.x, direction.z) + F32x8::splat(map.turn);
    let turns = turns.lt(F32x8::ONE).select(turns, turns - F32x8::ONE);
    let column = U32x8::from_f32(turns * F32x8::splat(map.width as f32)).min_signed(last_column);
    let (one, last) = (U32x8::splat(1), U32x8::splat(map.row_edges.len() as u32 - 2));
    let Vec3x8 { x, y, z } = direction;
    let versine = ((x * x + z * z) / (F32x8::ONE + y.abs())).min(F32x8::ONE);
    let row = U32x8::from_f32(polar_half_turns(versine) * F32x8::splat(map.height as f32)).min_signed(last);
    // The angle is right to a fraction of a row; the edges have the last word.
    let before = versine.lt(F32x8::gather(&map.row_edges, row));
    let after = versine.ge(F32x8::gather(&map.row_edges, row + one));
    let row = before.select_u32(row - one, after.select_u32((row + one).min_signed(last), row));
    let row = y.lt(F32x8::ZERO).select_u32(U32x8::splat(map.height - 1) - row, row);
    row * U32x8::splat(map.width) + column
}
