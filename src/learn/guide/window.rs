//! The guide of a frame of a sequence: tables from the directions of several frames' pilots, each of which knew nothing.
//!
//! The surfaces stand still, so what an earlier frame's pilot has found at a place is as true as what the frame's own has. The
//! leaves are cut anew for every frame from all that is known; whether guiding pays in a leaf is judged for the directions of
//! even frames by what odd ones tell, and the other way round, so that no direction speaks for itself.

use crate::learn::guide::build::lobes;
use crate::learn::guide::records::{Leaf, Outcome, Outcomes, UNIT, fixed};
use crate::learn::guide::training::{freeze_leaf, most_directions, pays};
use crate::math::INV_PI;
use crate::tables::guide::{BINS, CELL_BITS, CODES, FACES, GUIDED, Guide, Lobes, MOST_LEAVES};

/// A leaf is guided where the second moment of what its directions bring is more than this much of that in the mixture. Below 1,
/// since half of the directions know less than all, by which they will be guided. (1: 8 % more error in `builtin:rooms`; 0.6 is
/// as good.)
const LEAST_GAIN: f64 = 0.85;

/// Places `first .. first + (CODES >> depth)`.
#[derive(Clone, Copy, Debug)]
struct Node {
    first: usize,
    depth: u32,
}

impl Node {
    fn places(self) -> std::ops::Range<usize> {
        self.first..self.first + (CODES >> self.depth)
    }
}

/// Fills `guide` but for its pixels with what pilots of `paths` paths in all have found, even frames first; how many leaves
/// there are, and how many are guided. `guides`: directions are to be guided where that pays.
pub fn fill(guide: &mut Guide, halves: [&[&Outcomes]; 2], paths: u64, guides: bool) -> (usize, usize) {
    let nodes = cut(&halves, paths);
    for (leaf, node) in nodes.iter().enumerate() {
        guide.leaves[node.places()].fill(leaf as u16);
    }
    let mut leaves = halves.map(|half| sums(&guide.leaves[..], half, nodes.len()));
    for half in 0..2 {
        let others: Vec<[f32; BINS]> = leaves[1 - half].iter().map(densities).collect();
        for outcome in halves[half].iter().flat_map(|outcomes| &outcomes.outcomes) {
            let leaf = usize::from(guide.leaves[outcome.place as usize]);
            judge(&mut leaves[half][leaf], outcome, others[leaf][outcome.bin as usize]);
        }
    }
    guide.lobes.clear();
    guide.densities.clear();
    guide.reflected.clear();
    let [even, odd] = &leaves;
    let mut guided = 0;
    for ((even, odd), node) in even.iter().zip(odd).zip(&nodes) {
        let mut leaf = even.clone();
        leaf.add(odd);
        freeze_leaf(guide, &leaf);
        if guides && pays(&leaf, LEAST_GAIN) {
            guided += 1;
            guide.leaves[node.places()].iter_mut().for_each(|entry| *entry |= GUIDED);
        }
    }
    (nodes.len(), guided)
}

/// The leaves: places halved along the next bit of the Morton code until none holds too many directions.
fn cut(halves: &[&[&Outcomes]; 2], paths: u64) -> Vec<Node> {
    // Directions before each place.
    let mut before = vec![0u32; FACES * CODES + 1];
    for &place in halves.iter().flat_map(|half| half.iter()).flat_map(|outcomes| &outcomes.places) {
        before[place as usize + 1] += 1;
    }
    let mut sum = 0;
    for count in &mut before {
        sum += *count;
        *count = sum;
    }
    let count = |node: &Node| {
        let places = node.places();
        u64::from(before[places.end] - before[places.start])
    };
    let most = most_directions(paths);
    let mut nodes: Vec<Node> = (0..FACES).map(|face| Node { first: face * CODES, depth: 0 }).collect();
    let mut at = 0;
    while at < nodes.len() {
        while count(&nodes[at]) > most && nodes[at].depth < 3 * CELL_BITS && nodes.len() < MOST_LEAVES {
            let node = &mut nodes[at];
            node.depth += 1;
            let other = Node { first: node.places().end, ..*node };
            nodes.push(other);
        }
        at += 1;
    }
    nodes
}

/// The leaves' sums over some frames.
fn sums(leaf_of: &[u16], half: &[&Outcomes], leaves: usize) -> Vec<Leaf> {
    let mut sums = vec![Leaf::EMPTY; leaves];
    for outcomes in half {
        for &place in &outcomes.places {
            sums[usize::from(leaf_of[place as usize])].count += 1;
        }
        for outcome in &outcomes.outcomes {
            let leaf = &mut sums[usize::from(leaf_of[outcome.place as usize])];
            // Drawn by the cosine: cosine over density is pi.
            let units = fixed(outcome.found * std::f32::consts::PI, UNIT);
            leaf.irradiance = leaf.irradiance.saturating_add(units);
            let bin = &mut leaf.bins[outcome.bin as usize];
            *bin = bin.saturating_add(units);
        }
    }
    sums
}

/// What a guide made of a leaf would have for densities ([`Guide::densities`]).
fn densities(leaf: &Leaf) -> [f32; BINS] {
    let lobes = if leaf.irradiance > 0 { lobes(&leaf.bins) } else { Lobes::uniform() };
    lobes.densities()
}

/// Adds the squares of what a direction has brought and of what it would have under the mixture. `density`: that of its bin in
/// the guide.
fn judge(leaf: &mut Leaf, outcome: &Outcome, density: f32) {
    let mean = (leaf.irradiance as f64 / UNIT as f64 / leaf.count as f64) as f32 * INV_PI;
    let pdf_guide = density / (outcome.norm * outcome.norm * outcome.norm);
    let pdf_cosine = outcome.cosine * INV_PI;
    leaf.judge(outcome.found / mean, pdf_cosine, pdf_cosine, pdf_guide);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions at places spread over one face and crowded in a corner of another.
    fn crowded() -> Outcomes {
        let spread = (0..4000).map(|i: u32| i * 65 % CODES as u32);
        let corner = (0..40_000).map(|i: u32| 3 * CODES as u32 + i % 8);
        Outcomes { places: spread.chain(corner).collect(), ..Outcomes::default() }
    }

    #[test]
    fn leaves_cover_every_place_once_and_none_sees_too_much() {
        let outcomes = crowded();
        let (some, none) = ([&outcomes], []);
        let nodes = cut(&[&some, &none], 10_000);
        let mut covered = vec![0; FACES * CODES];
        for node in &nodes {
            node.places().for_each(|place| covered[place] += 1);
            let count = outcomes.places.iter().filter(|place| node.places().contains(&(**place as usize))).count();
            // What lies in one cell cannot be told apart.
            assert!(count as u64 <= most_directions(10_000) || node.depth == 3 * CELL_BITS, "{node:?} {count}");
        }
        assert!(covered.iter().all(|times| *times == 1) && nodes.iter().any(|node| node.depth == 3 * CELL_BITS));
        // Whichever half knows it, the leaves are the same.
        let places = |nodes: Vec<Node>| nodes.into_iter().map(Node::places).collect::<Vec<_>>();
        assert_eq!(places(cut(&[&none, &some], 10_000)), places(nodes));
    }

    #[test]
    fn a_direction_is_judged_by_what_others_have_found() {
        // All light comes from one bin; the guide of the other half knows, or has seen another bin.
        let outcome = |bin| Outcome { place: 0, bin, norm: 1.5, cosine: 0.5, found: 1.0 };
        let found = |bin| Outcomes { places: vec![0; 100], outcomes: vec![outcome(bin); 100], gains: Vec::new() };
        for (other, better) in [(7, true), (200, false)] {
            let (mut leaves, theirs) = (sums(&[0], &[&found(7)], 1), sums(&[0], &[&found(other)], 1));
            let density = densities(&theirs[0])[7];
            found(7).outcomes.iter().for_each(|outcome| judge(&mut leaves[0], outcome, density));
            assert_eq!((pays(&leaves[0], LEAST_GAIN), leaves[0].count), (better, 100));
        }
    }
}
