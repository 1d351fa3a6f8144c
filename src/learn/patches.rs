//! What light samples of an environment map were worth, patch by patch: records, from records to shares, and whether they pay.
//!
//! A patch is drawn in proportion to its probability under the map's own distribution times the root of the mean square of what
//! its samples are worth under that distribution, blocked samples being worth 0: then the variance of the choice is least. A
//! place draws a few hundred samples of the map in all, so that what it knows of 128 patches is little: where it has no samples
//! of its own it believes those of the places around it, and these those of all places that face the same way.

use std::collections::BTreeMap;

use crate::tables::lights::learned::{FACES, Grid, LEAST_FACTOR, LearnedLights, MIRROR_BINS};
use crate::tables::lights::patches::{LearnedPatches, PATCHES};

/// Cells along each axis that make a place around one.
const AROUND: u32 = 4;
/// Samples that what is believed counts as, beside a place's own.
const BELIEF: f64 = 1.0;

/// What one light sample that went to the map says if nothing blocks it; squares are in [`super::records::SQUARE_UNIT`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchVisit {
    /// Key of the receiver.
    pub key: u32,
    /// The patch.
    pub patch: u32,
    /// The square of its worth under the map's own distribution.
    pub square: u64,
    /// The square of its worth as it was drawn.
    pub with: u64,
    /// What the square of its worth would have been, had patches been drawn as the map's own distribution does: the mean of this
    /// over samples as they were drawn is the mean of `square` over samples of that distribution.
    pub without: u64,
}

/// The records of one key, or of several.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// Samples by patch.
    pub count: [u64; PATCHES],
    /// Sums of [`PatchVisit::square`] of samples that nothing blocked.
    pub square: [u64; PATCHES],
}

impl Default for Sums {
    fn default() -> Sums {
        Sums { count: [0; PATCHES], square: [0; PATCHES] }
    }
}

impl Sums {
    fn add(&mut self, other: &Sums) {
        for patch in 0..PATCHES {
            self.count[patch] += other.count[patch];
            self.square[patch] += other.square[patch];
        }
    }

    /// The mean squares by patch, where `belief` counts as [`BELIEF`] samples.
    fn means(&self, belief: &[f64; PATCHES]) -> [f64; PATCHES] {
        let Sums { count, square } = self;
        let mean = |patch: usize| (square[patch] as f64 + BELIEF * belief[patch]) / (count[patch] as f64 + BELIEF);
        std::array::from_fn(mean)
    }
}

/// The records of one key.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchRecord {
    /// The key.
    pub key: u32,
    /// What was recorded.
    pub sums: Sums,
}

/// All records, of one thread or of all.
#[derive(Clone, Debug, Default)]
pub struct PatchRecords {
    /// Per key, one more than the place of its record; 0: it has none.
    places: Vec<u32>,
    /// In the order in which they were first needed.
    records: Vec<PatchRecord>,
    /// Sums of [`PatchVisit::with`] and [`PatchVisit::without`].
    pub tried: [u64; 2],
}

impl PatchRecords {
    /// No records yet, for so many keys.
    pub fn new(keys: u32) -> PatchRecords {
        PatchRecords { places: vec![0; keys as usize], records: Vec::new(), tried: [0; 2] }
    }

    fn sums(&mut self, key: u32) -> &mut Sums {
        let place = &mut self.places[key as usize];
        if *place == 0 {
            self.records.push(PatchRecord { key, sums: Sums::default() });
            *place = self.records.len() as u32;
        }
        &mut self.records[*place as usize - 1].sums
    }

    /// Notes a light sample; `free`: it contributes, nothing is in between.
    pub fn note(&mut self, visit: &PatchVisit, free: bool) {
        let sums = self.sums(visit.key);
        sums.count[visit.patch as usize] += 1;
        if free {
            sums.square[visit.patch as usize] += visit.square;
            self.try_out([visit.with, visit.without]);
        }
    }

    /// Adds to [`PatchRecords::tried`]; in any order.
    fn try_out(&mut self, squares: [u64; 2]) {
        self.tried.iter_mut().zip(squares).for_each(|(sum, square)| *sum = sum.saturating_add(square));
    }

    /// Adds what was recorded of a key elsewhere.
    pub fn add(&mut self, theirs: &PatchRecord) {
        self.sums(theirs.key).add(&theirs.sums);
    }

    /// Adds all of `other`, and leaves it empty.
    pub fn take(&mut self, other: &mut PatchRecords) {
        for record in other.records.drain(..) {
            other.places[record.key as usize] = 0;
            self.add(&record);
        }
        self.try_out(std::mem::take(&mut other.tried));
    }

    /// The records, by ascending key.
    pub fn sorted(&self) -> Vec<&PatchRecord> {
        let mut records: Vec<&PatchRecord> = self.records.iter().collect();
        records.sort_unstable_by_key(|record| record.key);
        records
    }

    /// [`PatchRecords::sorted`], without those who own them.
    pub fn into_sorted(mut self) -> Vec<PatchRecord> {
        self.records.sort_unstable_by_key(|record| record.key);
        self.records
    }

    /// The second moment of samples as they were drawn over that of samples of the map's own distribution; `None` if too little
    /// was recorded.
    pub fn forecast(&self) -> Option<f64> {
        let [with, without] = self.tried.map(|sum| sum as f64);
        (without > 0.0).then(|| with / without)
    }
}

/// The place around that a key belongs to, and the way it faces.
fn around(grid: &Grid, key: u32) -> (u32, u32) {
    let diffuse = grid.cells() * FACES;
    let (cell, way) = match key.checked_sub(diffuse) {
        None => (key / FACES, key % FACES),
        Some(key) => (key / MIRROR_BINS, FACES + key % MIRROR_BINS),
    };
    let [columns, rows, _] = grid.size;
    let [x, y, z] = [cell % columns, cell / columns % rows, cell / columns / rows].map(|along| along / AROUND);
    ((z * 64 + y) * 64 + x, way)
}

/// Per key with a record, what its patches are to be drawn in proportion to.
pub fn weights(learned: &LearnedLights, records: &PatchRecords) -> BTreeMap<u32, [f64; PATCHES]> {
    let Some(LearnedPatches { patches, .. }) = &learned.patches else { return BTreeMap::new() };
    let (mut places, mut ways) = (BTreeMap::<(u32, u32), Sums>::new(), BTreeMap::<u32, Sums>::new());
    let records = records.sorted();
    for PatchRecord { key, sums } in &records {
        let (place, way) = around(&learned.grid, *key);
        places.entry((place, way)).or_default().add(sums);
        ways.entry(way).or_default().add(sums);
    }
    let of_way: BTreeMap<u32, [f64; PATCHES]> = ways
        .iter()
        .map(|(&way, sums)| {
            let mean = sums.square.iter().sum::<u64>() as f64 / sums.count.iter().sum::<u64>() as f64;
            (way, sums.means(&[mean; PATCHES]))
        })
        .collect();
    let of_place: BTreeMap<(u32, u32), [f64; PATCHES]> =
        places.iter().map(|(&place, sums)| (place, sums.means(&of_way[&place.1]))).collect();
    let weights = |record: &PatchRecord| {
        let means = record.sums.means(&of_place[&around(&learned.grid, record.key)]);
        let most = means.iter().fold(0.0f64, |most, &mean| most.max(mean)).sqrt();
        let factor = |patch: usize| if most > 0.0 { (means[patch].sqrt() / most).max(LEAST_FACTOR) } else { 1.0 };
        std::array::from_fn(|patch| patches.probability[patch] * factor(patch))
    };
    records.into_iter().map(|record| (record.key, weights(record))).collect()
}

/// [`PatchRecords::forecast`] for the tables of `learned`, which have no part in `records`: of samples of the map's own
/// distribution.
pub fn forecast_of_others(learned: &LearnedLights, records: &PatchRecords) -> Option<f64> {
    let patches = learned.patches.as_ref()?;
    let (mut with, mut without) = (0.0, 0.0);
    for record in records.sorted() {
        let row = learned.rows[record.key as usize];
        let square = &record.sums.square;
        for patch in (0..PATCHES).filter(|&patch| square[patch] > 0) {
            with += square[patch] as f64 / f64::from(patches.ratio(row, patch));
            without += square[patch] as f64;
        }
    }
    (without > 0.0).then(|| with / without)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visits() -> Vec<(PatchVisit, bool)> {
        let visit = |i: u32| {
            let (key, patch, square) = (i * 7 % 90, i * 31 % PATCHES as u32, u64::from(1000 * i));
            (PatchVisit { key, patch, square, with: square / 2, without: 2 * square }, !i.is_multiple_of(3))
        };
        (0..500).map(visit).collect()
    }

    #[test]
    fn order_and_threads_leave_no_trace() {
        let new = || PatchRecords::new(100);
        let mut one = new();
        visits().iter().for_each(|(visit, free)| one.note(visit, *free));
        let (mut total, mut workers) = (new(), [new(), new(), new()]);
        // In two rounds, so that the workers' records are used again after they were taken.
        for round in 0..2 {
            for (i, (visit, free)) in visits().iter().enumerate().rev().filter(|(i, _)| i % 2 == round) {
                workers[i % 3].note(visit, *free);
            }
            workers.iter_mut().rev().for_each(|worker| total.take(worker));
        }
        assert_eq!(one.sorted(), total.sorted());
        assert_eq!(one.tried, total.tried);
        let counted: u64 = one.sorted().iter().flat_map(|record| record.sums.count).sum();
        assert_eq!(counted, 500, "blocked samples count");
        assert_eq!(one.forecast(), Some(0.25));
        assert!(workers.iter().all(|worker| worker.sorted().is_empty() && worker.tried == [0; 2]));
        assert_eq!(new().forecast(), None);
    }

    #[test]
    fn what_a_place_has_not_seen_it_believes() {
        let Sums { mut count, mut square } = Sums::default();
        (count[3], square[3]) = (1_000_000, 0);
        (count[4], square[4]) = (1_000_000, 900_000_000);
        let means = Sums { count, square }.means(&[7.0; PATCHES]);
        assert!(means[3] < 1e-4 && (means[4] - 900.0).abs() < 0.01 && means[5] == 7.0, "{means:?}");
        // Cells of one block of 4 x 4 x 4 are a place; ways to face are kept apart.
        let grid = Grid { low: [0.0; 3], scale: 1.0, size: [16, 5, 8] };
        let diffuse = |x: u32, y: u32, z: u32, face: u32| around(&grid, ((z * 5 + y) * 16 + x) * FACES + face);
        assert_eq!(diffuse(0, 0, 0, 2), diffuse(3, 3, 3, 2));
        let others = [diffuse(4, 0, 0, 2), diffuse(0, 4, 0, 2), diffuse(0, 0, 4, 2), diffuse(0, 0, 0, 3)];
        assert!(others.iter().all(|other| *other != diffuse(0, 0, 0, 2)));
        let glossy = grid.cells() * FACES;
        assert!(around(&grid, glossy).1 == FACES && around(&grid, glossy + 2).1 == FACES + 2);
    }
}
