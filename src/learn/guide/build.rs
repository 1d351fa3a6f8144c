//! From histograms to what directions are drawn from.

use crate::tables::guide::{BINS, Lobes, SIDE};

/// Levels of the quad tree above the bins.
const LEVELS: usize = SIDE.trailing_zeros() as usize;
/// A node of the quad tree is divided only if it holds more than this part of the leaf.
const DIVIDED: f64 = 0.01;

/// The lobes of a histogram, row by row; uniform if it is empty. What a node holds that is not divided is spread over it.
pub fn lobes(bins: &[u64; BINS]) -> Lobes {
    // In f64 by additions, multiplications and divisions in a fixed order: the same everywhere.
    let mut levels: Vec<Vec<f64>> = vec![bins.iter().map(|&bin| bin as f64).collect()];
    for level in (0..LEVELS).rev() {
        let side = 1 << level;
        let finer = levels.last().map_or(&[][..], Vec::as_slice);
        let sum = |i: usize| children(side, i).iter().fold(0.0, |sum, &child| sum + finer[child]);
        levels.push((0..side * side).map(sum).collect());
    }
    levels.reverse();
    let total = levels[0][0];
    if total <= 0.0 {
        return Lobes::uniform();
    }
    let mut parts = vec![1.0];
    for level in 0..LEVELS {
        let side = 1 << level;
        let mut finer = vec![0.0; 4 * side * side];
        for (i, &part) in parts.iter().enumerate() {
            let held = levels[level][i];
            for child in children(side, i) {
                let share = if held > DIVIDED * total { levels[level + 1][child] / held } else { 0.25 };
                finer[child] = part * share;
            }
        }
        parts = finer;
    }
    let rows: Vec<f64> = parts.chunks(SIDE).map(|row| row.iter().sum()).collect();
    let columns = |row: usize| starts(&parts[row * SIDE..(row + 1) * SIDE]);
    Lobes { rows: starts(&rows), columns: std::array::from_fn(columns) }
}

/// The four children of node `i` of a level of `side` x `side` nodes, in the level below.
fn children(side: usize, i: usize) -> [usize; 4] {
    let first = 4 * side * (i / side) + 2 * (i % side);
    [first, first + 1, first + 2 * side, first + 2 * side + 1]
}

/// Where shares in proportion to `weights` begin, in 65,536ths; alike if all are 0.
fn starts(weights: &[f64]) -> [u16; SIDE] {
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return Lobes::uniform().rows;
    }
    let (mut starts, mut sum) = ([0; SIDE], 0.0);
    for (start, weight) in starts.iter_mut().zip(weights) {
        *start = (sum / total * 65_536.0).min(65_535.0) as u16;
        sum += weight;
    }
    starts[SIDE - 1] = starts[SIDE - 1].max(1);
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The probability of a bin.
    fn probability(lobes: &Lobes, bin: usize) -> f64 {
        let share = |starts: &[u16; SIDE], at: usize| f64::from(starts[(at + 1) % SIDE].wrapping_sub(starts[at]));
        share(&lobes.rows, bin / SIDE) * share(&lobes.columns[bin / SIDE], bin % SIDE) / 65_536f64.powi(2)
    }

    #[test]
    fn shares_follow_the_histogram_and_always_add_up_to_one() {
        let spread = |weight: fn(usize) -> u64| std::array::from_fn(weight);
        let histograms: [[u64; BINS]; 6] = [
            [0; BINS],
            [7; BINS],
            spread(|bin| (bin as u64 * 7_919) % 1_000),
            spread(|bin| if bin == 0 { u64::MAX / 2 } else { 0 }),
            spread(|bin| u64::from(bin == BINS - 1)),
            spread(|bin| if bin == 100 { 1_000_000 } else { 1 }),
        ];
        for bins in histograms {
            let lobes = lobes(&bins);
            let total: f64 = (0..BINS).map(|bin| probability(&lobes, bin)).sum();
            assert_eq!(total, 1.0);
            let held: f64 = bins.iter().map(|&bin| bin as f64).sum();
            for (bin, &weight) in bins.iter().enumerate().filter(|(_, weight)| **weight as f64 > 0.04 * held) {
                let wanted = weight as f64 / held;
                assert!(
                    (probability(&lobes, bin) - wanted).abs() < 3e-4,
                    "{bin}: {} {wanted}",
                    probability(&lobes, bin)
                );
            }
            for starts in lobes.columns.iter().chain([&lobes.rows]) {
                assert!(starts.is_sorted() && starts[0] == 0 && starts[SIDE - 1] > 0);
            }
        }
    }

    #[test]
    fn what_holds_little_is_spread_over_its_node() {
        let mut bins = [0; BINS];
        bins[0] = 1_000;
        bins[BINS - 1] = 5;
        let lobes = lobes(&bins);
        // The last node of four bins holds half a percent and so does each above it: its quarter of the square is even.
        let last = probability(&lobes, BINS - 1);
        assert!((last - probability(&lobes, BINS - 18)).abs() < 2e-4 && last > 0.0);
        assert!(probability(&lobes, 0) > 0.99);
    }
}
