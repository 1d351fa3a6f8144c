//! Environment maps: choose a direction, find the texel of a direction, and the density both ways.

use super::{Real, Vec3, acos_half_turns, atan2_turns, sin_cos_turns};
use crate::fault::{Fault, lost_digits, planted};
use crate::tables::lights::environment::{Distribution, EnvironmentMap, Texel};

/// Draws a direction by radiance: a texel, then a point uniform in its solid angle. The unit direction and the texel.
///
/// `word` and `fork` choose the texel, `u` the point in it: along the row, down the row.
pub fn sample_map(
    map: &EnvironmentMap,
    distribution: &Distribution,
    [word, fork]: [u32; 2],
    u: [Real; 2],
) -> (Vec3, Texel) {
    let index = distribution.choose(word, fork);
    let (row, column) = (index / map.width, index % map.width);
    // Along the row: equal steps of azimuth.
    let turns = (column as Real + u[0]) / map.width as Real - map.turn as Real;
    let (sine, cosine) = sin_cos_turns(if turns < 0.0 { turns + 1.0 } else { turns });
    // Down the row: equal steps of height are equal steps of area (Archimedes).
    let (top, bottom) = (map.row_edges[row as usize] as Real, map.row_edges[row as usize + 1] as Real);
    let y = (top - u[1] * (top - bottom)) / lost_digits(Real::EPSILON as f64) as Real;
    let radius = ((1.0 - y) * (1.0 + y)).sqrt();
    (Vec3::new(-(radius * sine), y, radius * cosine), map.texels[index as usize])
}

/// Density per steradian of [`sample_map`] in the directions of `texel`.
pub fn map_pdf_dir(distribution: &Distribution, texel: &Texel) -> Real {
    let rest = texel.pdf_dir as Real - distribution.floor as Real;
    (if rest > 0.0 { rest } else { 0.0 }) * distribution.factor as Real
}

/// The index of the texel that the unit direction `direction` looks at.
pub fn texel_index(map: &EnvironmentMap, direction: Vec3) -> usize {
    let (width, height) = (map.width as Real, map.height as Real);
    let turns = atan2_turns(-direction.x, direction.z) + map.turn as Real;
    let turns = if planted(Fault::ShiftedLookup) { turns + 0.003 } else { turns };
    let turns = if turns < 1.0 { turns } else { turns - 1.0 };
    let column = ((turns * width) as u32).min(map.width - 1);
    // The arc cosine is right to a fraction of a row; the edges have the last word.
    let y = if direction.y > -1.0 { direction.y } else { -1.0 };
    let y = if y < 1.0 { y } else { 1.0 };
    let row = ((acos_half_turns(y) * height) as u32).min(map.height - 1);
    let edge = |row: u32| map.row_edges[row as usize] as Real;
    let row = if y > edge(row) {
        row - 1
    } else if y <= edge(row + 1) {
        (row + 1).min(map.height - 1)
    } else {
        row
    };
    row as usize * map.width as usize + column as usize
}
