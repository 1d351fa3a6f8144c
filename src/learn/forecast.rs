//! Whether what was learned will pay.

use crate::learn::records::{LightRecords, NodeRecord};
use crate::tables::lights::learned::LearnedLights;
use crate::tables::lights::tree::WIDTH;

/// Above this forecast the factors are not used: what they win is then no more than what looking them up and training cost.
/// (Where they pay 1.5 times and more forecasts are 0.3 to 0.5, where they lose 0.88 to 0.96.)
pub const MOST: f64 = 0.85;
/// Nodes with fewer light samples say too little about themselves.
const LEAST_VISITS: u64 = 16;

/// The second moment of light samples with the factors over that without, as far as choosing at the root and at its child nodes
/// goes. `None` if too little was recorded.
///
/// Without factors a column is chosen with probability p and its samples have the mean square worth q, so that the second moment
/// is the sum of p q over the squared importance; in proportion to p sqrt(q) it is the square of the sum of p sqrt(q), which is
/// the least.
pub fn forecast(learned: &LearnedLights, records: &LightRecords) -> Option<f64> {
    let (mut with, mut without) = ([0.0; 2], [0.0; 2]);
    for node in records.sorted() {
        let level = usize::from(node.pair % learned.slot_count > 0);
        let visits: u64 = node.count.iter().sum();
        if visits >= LEAST_VISITS {
            let (first, second) = moments(&node);
            with[level] += visits as f64 * first * first;
            without[level] += visits as f64 * second;
        }
    }
    let ratio = |level: usize| if without[level] > 0.0 { with[level] / without[level] } else { 1.0 };
    (without[0] > 0.0).then(|| ratio(0) * ratio(1))
}

/// The sums of p sqrt(q) and of p q over a node's columns.
fn moments(node: &NodeRecord) -> (f64, f64) {
    let all = node.plain.iter().sum::<u64>() as f64;
    let (mut first, mut second) = (0.0, 0.0);
    for column in (0..WIDTH).filter(|&column| node.count[column] > 0) {
        let p = node.plain[column] as f64 / all;
        let q = node.square[column] as f64 / node.count[column] as f64;
        first += p * q.sqrt();
        second += p * q;
    }
    (first, second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::records::PLAIN_UNIT;

    #[test]
    fn moments_are_those_of_choosing_without_factors() {
        let node = |plain, count, square| NodeRecord { pair: 0, count, plain, square };
        // Two columns, alike likely without factors; one is worth nothing.
        let half = node([512, 512, 0, 0, 0, 0, 0, 0], [2, 2, 0, 0, 0, 0, 0, 0], [8, 0, 0, 0, 0, 0, 0, 0]);
        let (first, second) = moments(&half);
        assert_eq!((first, second), (1.0, 2.0));
        // The same chosen three times as often with factors of 255 and 85: the plain probabilities stay.
        let count = [3, 1, 0, 0, 0, 0, 0, 0];
        let plain = |byte: u32| u64::from(PLAIN_UNIT / byte);
        let weighed = node([3 * plain(255), plain(85), 0, 0, 0, 0, 0, 0], count, [12, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(moments(&weighed), (first, second));
        // All columns worth the same: nothing to win.
        let same = node([9; WIDTH], [5; WIDTH], [20; WIDTH]);
        let (first, second) = moments(&same);
        assert!((first * first / second - 1.0).abs() < 1e-12);
    }
}
