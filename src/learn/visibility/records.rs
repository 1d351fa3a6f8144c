//! Shadow rays that a training render has traced to emitters, counted by pairs of cells.

use std::collections::HashMap;

use crate::tables::lights::visibility::{NO_EMITTER, Visibility};

/// Free shadow rays that every pair is taken to have had beside those recorded.
const PRIOR: f64 = 1.0;

/// Shadow rays of one pair of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sightings {
    /// All of them.
    pub traced: u64,
    /// Those that nothing blocked.
    pub free: u64,
}

impl Sightings {
    fn add(&mut self, other: Sightings) {
        self.traced += other.traced;
        self.free += other.free;
    }

    /// The part that is free, above 0; 1 where nothing is known.
    pub fn visibility(self) -> f64 {
        (self.free as f64 + PRIOR) / (self.traced as f64 + PRIOR)
    }
}

/// All shadow rays recorded, of one thread or of all: sums of integers, in which order leaves no trace.
#[derive(Clone, Debug, Default)]
pub struct VisibilityRecords {
    /// By [`Visibility::pair`].
    pairs: HashMap<u32, Sightings>,
}

impl VisibilityRecords {
    /// Notes a shadow ray between a pair of cells ([`Visibility::pair`]); `free`: nothing has blocked it.
    pub fn note(&mut self, pair: u32, free: bool) {
        self.pairs.entry(pair).or_default().add(Sightings { traced: 1, free: u64::from(free) });
    }

    /// Adds all of `other`, and leaves it empty.
    pub fn take(&mut self, other: &mut VisibilityRecords) {
        other.pairs.drain().for_each(|(pair, sightings)| self.pairs.entry(pair).or_default().add(sightings));
    }

    /// Shadow rays of all pairs.
    pub fn total(&self) -> Sightings {
        let mut total = Sightings::default();
        self.pairs.values().for_each(|&sightings| total.add(sightings));
        total
    }

    /// How many pairs have records.
    pub fn count(&self) -> usize {
        self.pairs.len()
    }

    /// The records by ascending pair, each in both ways round.
    pub fn both_ways(&self, visibility: &Visibility) -> Vec<(u32, Sightings)> {
        let Visibility { numbers, number_count, .. } = visibility;
        let cells: Vec<u32> =
            (0..).zip(numbers).filter(|(_, number)| **number != NO_EMITTER).map(|(cell, _)| cell).collect();
        let mut all = Vec::with_capacity(self.pairs.len());
        for (&pair, &sightings) in &self.pairs {
            let (start, number) = (pair / number_count, pair % number_count);
            if number != NO_EMITTER {
                all.push((pair, sightings));
                let (end, back) = (cells[number as usize - 1], numbers[start as usize]);
                if back != NO_EMITTER && end != start {
                    all.push((end * number_count + back, sightings));
                }
            }
        }
        all.sort_unstable_by_key(|(pair, _)| *pair);
        let sum = |same: &[(u32, Sightings)]| {
            let mut sum = Sightings::default();
            same.iter().for_each(|(_, sightings)| sum.add(*sightings));
            (same[0].0, sum)
        };
        all.chunk_by(|a, b| a.0 == b.0).map(sum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::lights::learned::Grid;

    /// Four cells in a row, of which the second and the last hold emitters.
    fn row() -> Visibility {
        let grid = Grid { low: [0.0; 3], scale: 1.0, size: [4, 1, 1] };
        Visibility { grid, numbers: vec![0, 1, 0, 2], number_count: 3, survival: vec![u8::MAX; 12] }
    }

    fn noted(notes: &[(u32, u32, bool)]) -> VisibilityRecords {
        let (visibility, mut records) = (row(), VisibilityRecords::default());
        notes.iter().for_each(|&(start, end, free)| records.note(visibility.pair(start, end), free));
        records
    }

    #[test]
    fn order_and_threads_leave_no_trace() {
        let notes: Vec<(u32, u32, bool)> = (0..500u32).map(|i| (i % 4, i / 3 % 4, i % 5 == 0)).collect();
        let one = noted(&notes);
        let mut total = VisibilityRecords::default();
        let mut workers: [VisibilityRecords; 3] = Default::default();
        // In two rounds, so that the workers' records are used again after they were taken.
        for round in 0..2 {
            for (i, &(start, end, free)) in notes.iter().enumerate().rev().filter(|(i, _)| i % 2 == round) {
                workers[i % 3].note(row().pair(start, end), free);
            }
            workers.iter_mut().rev().for_each(|worker| total.take(worker));
        }
        assert_eq!(one.both_ways(&row()), total.both_ways(&row()));
        assert_eq!(one.total(), Sightings { traced: 500, free: 100 });
        assert_eq!((one.total(), one.count()), (total.total(), total.count()));
        assert!(workers.iter().all(|worker| worker.count() == 0));
    }

    #[test]
    fn a_pair_is_one_both_ways_round() {
        let records = noted(&[(1, 3, true), (3, 1, false), (3, 1, false), (0, 3, true), (1, 1, false), (2, 0, true)]);
        let sightings = |traced, free| Sightings { traced, free };
        let pair = |start, end| row().pair(start, end);
        let mut expected = vec![
            (pair(0, 3), sightings(1, 1)),
            (pair(1, 1), sightings(1, 0)),
            (pair(1, 3), sightings(3, 1)),
            (pair(3, 1), sightings(3, 1)),
        ];
        expected.sort_unstable_by_key(|(pair, _)| *pair);
        // Nothing is said of the last: its light point was beside the cells of lights.
        assert_eq!(records.both_ways(&row()), expected);
    }

    #[test]
    fn unknown_pairs_count_as_visible_and_none_as_invisible() {
        let visibility = |traced, free| Sightings { traced, free }.visibility();
        assert_eq!([visibility(0, 0), visibility(1, 0), visibility(3, 1), visibility(9, 9)], [1.0, 0.5, 0.5, 1.0]);
        assert!(visibility(u64::MAX / 2, 0) > 0.0);
    }
}
