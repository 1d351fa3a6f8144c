//! Looking up what was learned of the lights.

use super::{Real, Vec3};
use crate::tables::lights::learned::{FACES, Grid, LearnedLights, MIRROR_BINS};
use crate::tables::lights::table::LightTable;
use crate::tables::lights::tree::WIDTH;

/// Where a hit looks up what was learned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Its cell, and the face of the surface or of the mirrored direction.
    pub key: u32,
    /// The key's row; 0: nothing is known.
    pub row: u32,
}

/// The place of a hit at `origin`, where the surface has the unit normal `normal`; `incoming`: of a glossy surface, the
/// direction of the ray that hit.
pub fn place(lights: &LightTable, origin: Vec3, normal: Vec3, incoming: Option<Vec3>) -> Place {
    let Some(learned) = &lights.learned else { return Place::default() };
    let key = key(&learned.grid, origin, normal, incoming);
    Place { key, row: learned.rows[key as usize] }
}

/// The cell that a point is in, or the nearest one.
pub fn cell(grid: &Grid, point: Vec3) -> u32 {
    let axis = |x: Real, i: usize| {
        let along = (x - grid.low[i] as Real) * grid.scale as Real;
        let along = if along > 0.0 { along } else { 0.0 };
        let last = (grid.size[i] - 1) as Real;
        (if along < last { along } else { last }) as u32
    };
    let [columns, rows, _] = grid.size;
    (axis(point.z, 2) * rows + axis(point.y, 1)) * columns + axis(point.x, 0)
}

/// The key of a hit.
pub fn key(grid: &Grid, origin: Vec3, normal: Vec3, incoming: Option<Vec3>) -> u32 {
    let cell = cell(grid, origin);
    match incoming {
        None => cell * FACES + face(normal).0,
        Some(incoming) => {
            let mirrored = incoming - normal * (2.0 * incoming.dot(normal));
            let (face, [b, c]) = face(mirrored);
            let bin = face * 4 + (b < 0.0) as u32 + 2 * (c < 0.0) as u32;
            grid.cells() * FACES + cell * MIRROR_BINS + bin
        }
    }
}

/// Two times the dominant axis, plus 1 if it points down; and the other two components.
fn face(v: Vec3) -> (u32, [Real; 2]) {
    let size = v.abs();
    let (axis, largest, others) = if size.x >= size.y && size.x >= size.z {
        (0, v.x, [v.y, v.z])
    } else if size.y >= size.z {
        (2, v.y, [v.x, v.z])
    } else {
        (4, v.z, [v.x, v.y])
    };
    (axis + (largest < 0.0) as u32, others)
}

/// What the importances of a node's columns are multiplied by, for a row.
pub fn factors(learned: Option<&LearnedLights>, row: u32, node: u32) -> [Real; WIDTH] {
    let word = learned.map_or(crate::tables::lights::learned::ALIKE, |learned| learned.word(row, node));
    std::array::from_fn(|column| (word >> (8 * column) & 0xff) as Real)
}
