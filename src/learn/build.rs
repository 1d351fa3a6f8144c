//! From records to tables.

use std::collections::BTreeSet;

use crate::learn::patches::weights;
use crate::learn::records::{LightRecords, NodeRecord};
use crate::tables::lights::learned::{ALIKE, LEAST_FACTOR, LearnedLights};
use crate::tables::lights::tree::WIDTH;

impl LearnedLights {
    /// Sets rows and words to what `records` say. A key of which there is no record has row 0.
    pub fn learn(&mut self, records: &LightRecords) {
        let (nodes, weights) = (records.sorted(), weights(self, &records.patches));
        let keys = nodes.iter().map(|node| node.pair / self.slot_count).chain(weights.keys().copied());
        let keys: BTreeSet<u32> = keys.collect();
        self.rows.fill(0);
        keys.iter().zip(1..).for_each(|(&key, row)| self.rows[key as usize] = row);
        self.words.clear();
        self.words.resize((1 + keys.len()) * self.slot_count as usize, ALIKE);
        for node in nodes {
            let (key, slot) = (node.pair / self.slot_count, node.pair % self.slot_count);
            self.words[(self.rows[key as usize] * self.slot_count + slot) as usize] = word(&node);
        }
        if let Some(patches) = &mut self.patches {
            patches.clear();
            // Where no sample has gone to the map, its own probabilities stay.
            let unknown = patches.patches.probability;
            keys.iter().for_each(|key| patches.push(weights.get(key).unwrap_or(&unknown)));
        }
    }
}

/// The factors of a node's columns: root mean squares of what their samples were worth, each with one sample of the node's own
/// mean beside them, in 255ths of the largest. A column that no sample has gone to (it holds no lights, or next to no share
/// leads there) counts as that mean.
fn word(node: &NodeRecord) -> u64 {
    let (squares, count): (u64, u64) = (node.square.iter().sum(), node.count.iter().sum());
    if squares == 0 {
        return ALIKE;
    }
    let mean = squares as f64 / count as f64;
    let worth = |column: usize| ((node.square[column] as f64 + mean) / (node.count[column] as f64 + 1.0)).sqrt();
    let worth: [f64; WIDTH] = std::array::from_fn(worth);
    let most = worth.into_iter().fold(0.0, f64::max);
    u64::from_le_bytes(worth.map(|worth| (255.0 * (worth / most).max(LEAST_FACTOR)).round().clamp(1.0, 255.0) as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(count: [u64; WIDTH], square: [u64; WIDTH]) -> NodeRecord {
        NodeRecord { pair: 0, count, plain: [0; WIDTH], square }
    }

    #[test]
    fn factors_follow_the_root_mean_square_down_to_a_floor() {
        let bytes = |count, square| word(&node(count, square)).to_le_bytes();
        // Many samples of one mean square each: the prior is lost in them.
        let n = 1_000_000_000;
        let found = bytes([n; WIDTH], [16 * n, 4 * n, n, n / 4, n / 1024, n / 4096, 0, 16 * n]);
        assert_eq!(found, [255, 128, 64, 32, 8, 8, 8, 255]);
        for square in [[1; WIDTH], [0, 0, 0, 0, 0, 0, 0, u64::MAX / 64], [u64::MAX / 64; WIDTH]] {
            let found = bytes([3; WIDTH], square);
            assert!(found.iter().all(|&byte| byte >= 8) && found.contains(&255), "{found:?}");
        }
        // Nothing was worth anything: nothing is known.
        assert_eq!(word(&node([7; WIDTH], [0; WIDTH])), ALIKE);
        // One sample says little: its column is at most a factor of the prior's root above the others.
        let found = bytes([1, 0, 0, 0, 0, 0, 0, 0], [1 << 20, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(found, [255; WIDTH]);
    }
}
