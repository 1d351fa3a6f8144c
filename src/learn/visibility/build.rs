//! From counted shadow rays to tables.

use crate::learn::outcome::Learning;
use crate::learn::visibility::records::{Sightings, VisibilityRecords};
use crate::learn::visibility::{LEAST_SURVIVAL, LEAST_TRACED};
use crate::tables::PreparedScene;
use crate::tables::lights::learned::{ALIKE, FACES, LEAST_FACTOR, LearnedLights, MIRROR_BINS, NO_SLOT};
use crate::tables::lights::table::{LightTable, Selection, power};
use crate::tables::lights::tree::{LEAF, LightTree, WIDTH};
use crate::tables::lights::visibility::{NO_EMITTER, STEPS, Visibility};

/// Sets the factors of the light tree's columns, if there is one, to what `records` say.
pub fn weigh(scene: &PreparedScene, lights: &mut LightTable, records: &VisibilityRecords) {
    let (Selection::Tree(tree), Some(learned), Some(visibility)) =
        (&lights.selection, &mut lights.learned, &lights.visibility)
    else {
        return;
    };
    let columns = Columns::new(scene, tree, learned, visibility);
    let cells = visibility.grid.cells();
    learned.rows.fill(0);
    learned.words.truncate(learned.slot_count as usize);
    let known = records.both_ways(visibility);
    for of_cell in known.chunk_by(|a, b| a.0 / visibility.number_count == b.0 / visibility.number_count) {
        let cell = of_cell[0].0 / visibility.number_count;
        let mut seen = vec![1.0; visibility.number_count as usize];
        of_cell.iter().for_each(|(pair, sightings)| {
            seen[(pair % visibility.number_count) as usize] = sightings.visibility();
        });
        let row = learned.words.len() as u32 / learned.slot_count;
        learned.words.extend(columns.words(&seen));
        for (first, count) in [(cell * FACES, FACES), (cells * FACES + cell * MIRROR_BINS, MIRROR_BINS)] {
            learned.rows[first as usize..(first + count) as usize].fill(row);
        }
    }
}

/// Ends training: shadow rays are played roulette with from now on. Where none was traced, the tables go.
pub fn judge(lights: &mut LightTable, records: &VisibilityRecords, learning: &mut Learning) {
    let Some(visibility) = &mut lights.visibility else { return };
    let Sightings { traced, free } = records.total();
    learning.used = traced > 0;
    if !learning.used {
        learning.why = "the training render has traced no shadow ray to an emitter".into();
        (lights.learned, lights.visibility) = (None, None);
        return;
    }
    survive(visibility, records);
    let tables = lights.learned.iter().flat_map(LearnedLights::tables).chain(visibility.tables());
    learning.bytes = tables.map(|(_, bytes)| bytes).sum();
    let blocked = 100.0 * (traced - free) as f64 / traced as f64;
    let alone = if lights.learned.is_none() { " (roulette alone)" } else { "" };
    learning.why = format!(
        "asked for{alone}; {traced} shadow rays between {} pairs of cells, {blocked:.0} % of them blocked",
        records.count()
    );
}

/// Sets the probabilities with which shadow rays are traced to what `records` say.
fn survive(visibility: &mut Visibility, records: &VisibilityRecords) {
    for (pair, sightings) in records.both_ways(visibility) {
        if sightings.traced >= LEAST_TRACED {
            let steps = f64::from(STEPS) * sightings.visibility().max(LEAST_SURVIVAL);
            visibility.survival[pair as usize] = (steps.round() - 1.0) as u8;
        }
    }
}

/// Where the emitters below the columns of nodes with slots are.
struct Columns {
    /// Number of the column (that of the slot times [`WIDTH`], plus its own), number of a cell of lights, power there; ascending.
    powers: Vec<(u32, u32, f64)>,
    slot_count: u32,
}

impl Columns {
    fn new(scene: &PreparedScene, tree: &LightTree, learned: &LearnedLights, visibility: &Visibility) -> Columns {
        let mut powers: Vec<(u32, u32, f64)> = Vec::new();
        let number = |point| visibility.numbers[visibility.grid.cell(visibility.grid.axes(point)) as usize];
        let emitters = scene.emitters.iter().map(|emitter| {
            let vertices = scene.triangles[emitter.triangle as usize].vertices;
            let centroid = std::array::from_fn(|axis| vertices.iter().map(|vertex| vertex[axis]).sum::<f32>() / 3.0);
            (number(centroid), power(scene, emitter))
        });
        let deltas = scene.delta_lights.records.iter().zip(scene.delta_lights.powers());
        let deltas = deltas.map(|(light, power)| match light.distant {
            0 => (number(light.position), power),
            _ => (NO_EMITTER, power),
        });
        for ((number, power), &path) in emitters.chain(deltas).zip(&tree.paths) {
            let (mut node, mut path) = (0, path);
            while learned.slots[node as usize] != NO_SLOT {
                let column = path as u32 & 7;
                path >>= 3;
                powers.push((learned.slots[node as usize] * WIDTH as u32 + column, number, power));
                let child = tree.nodes[node as usize].child[column as usize];
                if child & LEAF != 0 {
                    break;
                }
                node = child;
            }
        }
        // A stable sort: sums are in the order of the emitters.
        powers.sort_by_key(|&(column, number, _)| (column, number));
        let sum = |same: &[(u32, u32, f64)]| (same[0].0, same[0].1, same.iter().map(|(_, _, power)| power).sum());
        let powers = powers.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).map(sum).collect();
        Columns { powers, slot_count: learned.slot_count }
    }

    /// The words of a row: `seen` is the visibility of each cell of lights by its number.
    fn words(&self, seen: &[f64]) -> Vec<u64> {
        let mut worth = vec![[0.0f64; WIDTH]; self.slot_count as usize];
        for same in self.powers.chunk_by(|a, b| a.0 == b.0) {
            let all: f64 = same.iter().map(|(_, _, power)| power).sum();
            let free: f64 = same.iter().map(|&(_, number, power)| power * seen[number as usize]).sum();
            // Emitters without power are chosen by nothing else either.
            let mean = if all > 0.0 { free / all } else { 1.0 };
            worth[same[0].0 as usize / WIDTH][same[0].0 as usize % WIDTH] = mean;
        }
        worth.into_iter().map(word).collect()
    }
}

/// The factors of a node's columns that are worth so much, in 255ths of the largest.
fn word(worth: [f64; WIDTH]) -> u64 {
    let most = worth.into_iter().fold(0.0, f64::max);
    if most == 0.0 {
        return ALIKE;
    }
    u64::from_le_bytes(worth.map(|worth| (255.0 * (worth / most).max(LEAST_FACTOR)).round() as u8))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::lights::learned::Grid;

    #[test]
    fn factors_are_mean_visibilities_down_to_a_floor() {
        let bytes = |worth| word(worth).to_le_bytes();
        assert_eq!(bytes([1.0, 0.5, 0.25, 0.01, 0.0, 1.0, 0.75, 0.1]), [255, 128, 64, 8, 8, 255, 191, 26]);
        // Only proportions count.
        assert_eq!(bytes([0.1, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), [255, 128, 8, 8, 8, 8, 8, 8]);
        assert_eq!(word([0.0; WIDTH]), ALIKE);
        // Powers 1 and 3 in two cells below one column, another column with one emitter, one slot without any.
        let columns = Columns { powers: vec![(0, 1, 1.0), (0, 2, 3.0), (5, 0, 7.0)], slot_count: 2 };
        let words = columns.words(&[1.0, 1.0, 0.2]).into_iter().map(u64::to_le_bytes).collect::<Vec<_>>();
        assert_eq!(words[0], [102, 8, 8, 8, 8, 255, 8, 8], "0.25 of 1 and 0.75 of 0.2 are 0.4");
        assert_eq!(words[1], ALIKE.to_le_bytes());
    }

    #[test]
    fn shadow_rays_keep_a_least_probability() {
        let grid = Grid { low: [0.0; 3], scale: 1.0, size: [4, 1, 1] };
        let mut visibility = Visibility { grid, numbers: vec![0, 1, 0, 2], number_count: 3, survival: vec![255; 12] };
        let mut records = VisibilityRecords::default();
        let shape = visibility.clone();
        let mut note = |start, end, traced: u64, free: u64| {
            (0..traced).for_each(|i| records.note(shape.pair(start, end), i < free));
        };
        note(0, 1, 1000, 0);
        note(0, 3, LEAST_TRACED - 1, 0);
        note(2, 1, 99, 24);
        note(2, 3, 1000, 1000);
        survive(&mut visibility, &records);
        let steps = |start, end| visibility.steps(visibility.pair(start, end));
        assert_eq!((steps(0, 1), steps(0, 3), steps(2, 1), steps(2, 3)), (16, 256, 64, 256));
        assert_eq!(steps(1, 1), 256, "nothing is known");
    }
}
