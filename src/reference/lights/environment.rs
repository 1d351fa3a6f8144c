//! Environment maps: choose a direction, find the texel of a direction, and the density both ways.

use super::{Real, Vec3, atan2_turns, polar_half_turns, sin_cos_turns};
use crate::fault::{Fault, lost_digits, planted};
use crate::tables::lights::environment::{Distribution, EnvironmentMap, Texel};

/// Draws a direction by radiance: a texel, then a point uniform in its solid angle. The unit direction and the texel.
///
/// `words` choose the texel, `u` the point in it: along the row, and from the nearer pole.
pub fn sample_map(map: &EnvironmentMap, distribution: &Distribution, words: [u32; 2], u: [Real; 2]) -> (Vec3, Texel) {
    sample_texel(map, distribution.choose(words), u)
}

/// A point in the texel `index`, uniform in its solid angle: the unit direction, and the texel.
pub fn sample_texel(map: &EnvironmentMap, index: u32, u: [Real; 2]) -> (Vec3, Texel) {
    let (row, column) = (index / map.width, index % map.width);
    // Along the row: equal steps of azimuth.
    let turns = (column as Real + u[0]) / map.width as Real - map.turn as Real;
    let (sine, cosine) = sin_cos_turns(if turns < 0.0 { turns + 1.0 } else { turns });
    // Across the row: equal steps of height are equal steps of area (Archimedes). A middle row has a half in each hemisphere.
    let from_south = map.height - 1 - row;
    let (south, down) = match u[1] + u[1] {
        twice if map.is_middle(row) => {
            if twice >= 1.0 {
                (true, twice - 1.0)
            } else {
                (false, twice)
            }
        }
        _ => (from_south < row, u[1]),
    };
    let row = row.min(from_south) as usize;
    let (near, far) = (map.row_edges[row] as Real, map.row_edges[row + 1] as Real);
    let versine = near + down * (far - near);
    // From the versine, not from y, which next to a pole is 1 for whole rows.
    let radius = (versine * (2.0 - versine)).sqrt();
    let height = 1.0 - versine;
    let y = if south { -height } else { height } / lost_digits(Real::EPSILON as f64) as Real;
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
    let last = map.row_edges.len() as u32 - 2;
    let Vec3 { x, y, z } = direction;
    let versine = (x * x + z * z) / (1.0 + y.abs());
    let versine = if versine < 1.0 { versine } else { 1.0 };
    let row = ((polar_half_turns(versine) * height) as u32).min(last);
    // The angle is right to a fraction of a row; the edges have the last word.
    let edge = |row: u32| map.row_edges[row as usize] as Real;
    let row = if versine < edge(row) {
        row - 1
    } else if versine >= edge(row + 1) {
        (row + 1).min(last)
    } else {
        row
    };
    let row = if y < 0.0 { map.height - 1 - row } else { row };
    row as usize * map.width as usize + column as usize
}
