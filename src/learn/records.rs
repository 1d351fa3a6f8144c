//! What the light samples of a training render were worth, column by column: integers, so that adding them up in any order
//! gives the same bits.

use crate::learn::patches::{PatchRecords, PatchVisit};
use crate::tables::lights::learned::{LEVELS, LearnedLights};
use crate::tables::lights::tree::WIDTH;

/// Most that a sample is worth over what the importance has promised: narrow lobes have heavy tails.
pub const CAP: f32 = 4.0;
/// What the square of a worth is multiplied by before it is cut to an integer.
pub const SQUARE_UNIT: f32 = 1_048_576.0;
/// What [`Visit::plain`] is in, over the factor's byte: 256 for the largest byte.
pub const PLAIN_UNIT: u32 = 65_280;

/// What one light sample says of one node on the way to its light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Visit {
    /// Key and slot of the node: `key * slot_count + slot`.
    pub pair: u32,
    /// The column that leads to the light.
    pub column: u32,
    /// [`PLAIN_UNIT`] over the factor that the column had: in proportion to this, samples would go there without factors.
    pub plain: u32,
    /// The square of the sample's worth if nothing blocks it, at most [`CAP`] squared, in [`SQUARE_UNIT`].
    pub square: u32,
}

/// What one light sample says: of the nodes on the way to its light that have slots; of the environment, of its patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lesson {
    /// The visits, from the root down.
    pub visits: [Visit; LEVELS],
    /// How many there are.
    pub len: usize,
    /// What a sample of an environment map says.
    pub patch: Option<PatchVisit>,
}

impl Lesson {
    /// Adds a visit to the next node.
    pub fn push(&mut self, visit: Visit) {
        self.visits[self.len] = visit;
        self.len += 1;
    }
}

/// The records of one node for one key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeRecord {
    /// As [`Visit::pair`].
    pub pair: u32,
    /// Light samples by column.
    pub count: [u64; WIDTH],
    /// Sums of [`Visit::plain`].
    pub plain: [u64; WIDTH],
    /// Sums of [`Visit::square`] of samples that nothing blocked.
    pub square: [u64; WIDTH],
}

/// All records, of one thread or of all.
#[derive(Clone, Debug, Default)]
pub struct LightRecords {
    /// Per pair, one more than the place of its record; 0: it has none.
    places: Vec<u32>,
    /// In the order in which they were first needed.
    nodes: Vec<NodeRecord>,
    /// Those of an environment map.
    pub patches: PatchRecords,
}

impl LightRecords {
    /// No records yet, for tables of the shape of `learned`.
    pub fn new(learned: &LearnedLights) -> LightRecords {
        LightRecords {
            places: vec![0; learned.rows.len() * learned.slot_count as usize],
            nodes: Vec::new(),
            patches: PatchRecords::new(if learned.patches.is_some() { learned.grid.keys() } else { 0 }),
        }
    }

    fn node(&mut self, pair: u32) -> &mut NodeRecord {
        let place = &mut self.places[pair as usize];
        if *place == 0 {
            let none = [0; WIDTH];
            self.nodes.push(NodeRecord { pair, count: none, plain: none, square: none });
            *place = self.nodes.len() as u32;
        }
        &mut self.nodes[*place as usize - 1]
    }

    /// Notes a light sample; `free`: it contributes, nothing is in between.
    pub fn note(&mut self, lesson: &Lesson, free: bool) {
        for visit in &lesson.visits[..lesson.len] {
            let node = self.node(visit.pair);
            let column = visit.column as usize;
            node.count[column] += 1;
            node.plain[column] += u64::from(visit.plain);
            node.square[column] += if free { u64::from(visit.square) } else { 0 };
        }
        if let Some(visit) = &lesson.patch {
            self.patches.note(visit, free);
        }
    }

    /// Adds all of `other`, and leaves it empty.
    pub fn take(&mut self, other: &mut LightRecords) {
        for theirs in other.nodes.drain(..) {
            other.places[theirs.pair as usize] = 0;
            self.add(&theirs);
        }
        self.patches.take(&mut other.patches);
    }

    /// Adds what was recorded of a node elsewhere.
    pub fn add(&mut self, theirs: &NodeRecord) {
        let mine = self.node(theirs.pair);
        for column in 0..WIDTH {
            mine.count[column] += theirs.count[column];
            mine.plain[column] += theirs.plain[column];
            mine.square[column] += theirs.square[column];
        }
    }

    /// The records, by ascending pair: in an order that does not tell how they came about.
    pub fn sorted(&self) -> Vec<NodeRecord> {
        let mut nodes = self.nodes.clone();
        nodes.sort_unstable_by_key(|node| node.pair);
        nodes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn empty() -> LightRecords {
        LightRecords { places: vec![0; 100], nodes: Vec::new(), patches: PatchRecords::default() }
    }

    /// Lessons of which some share nodes, and whether they are free.
    fn lessons() -> Vec<(Lesson, bool)> {
        let lesson = |i: u32| {
            let mut lesson = Lesson::default();
            for level in 0..i % 3 {
                let pair = 9 * (i % 7) + level * (1 + i % 5);
                lesson.push(Visit { pair, column: i % 8, plain: 256 + i, square: i * 1_000 });
            }
            (lesson, !i.is_multiple_of(4))
        };
        (0..200).map(lesson).collect()
    }

    #[test]
    fn order_and_threads_leave_no_trace() {
        let mut one = empty();
        lessons().iter().for_each(|(lesson, free)| one.note(lesson, *free));
        let mut total = empty();
        let mut workers = [empty(), empty(), empty()];
        // In two rounds, so that the workers' records are used again after they were taken.
        for round in 0..2 {
            for (i, (lesson, free)) in lessons().iter().enumerate().rev().filter(|(i, _)| i % 2 == round) {
                workers[i % 3].note(lesson, *free);
            }
            workers.iter_mut().rev().for_each(|worker| total.take(worker));
        }
        assert_eq!(one.sorted(), total.sorted());
        let counted: u64 = one.sorted().iter().flat_map(|node| node.count).sum();
        assert_eq!(counted, lessons().iter().map(|(lesson, _)| lesson.len as u64).sum::<u64>());
        assert!(workers.iter().all(|worker| worker.sorted().is_empty()));
    }

    #[test]
    fn blocked_samples_count_and_are_worth_nothing() {
        let mut records = empty();
        let mut lesson = Lesson::default();
        lesson.push(Visit { pair: 5, column: 3, plain: 256, square: 70 });
        records.note(&lesson, true);
        records.note(&lesson, false);
        let node = records.sorted()[0];
        assert_eq!((node.pair, node.count[3], node.plain[3], node.square[3]), (5, 2, 512, 70));
    }
}
