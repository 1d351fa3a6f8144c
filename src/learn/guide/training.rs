//! The guide while it is trained: sums of all passes, the tree of leaves, and the tables frozen for the next pass.

use crate::learn::guide::build::lobes;
use crate::learn::guide::pixels::inverse_pixels;
use crate::learn::guide::records::{GuideRecords, Leaf, Outcomes, SQUARE_UNIT, UNIT};
use crate::tables::guide::{CELL_BITS, CODES, FACES, GUIDED, Guide, Lobes, MOST_LEAVES};

/// A leaf splits when it has seen more than this many directions times the root of the paths so far. (4: the same error; 2: 10 to
/// 20 % more.)
const SPLIT: u64 = 8;
/// Leaves of fewer directions say too little: they are not guided.
const LEAST_COUNT: u64 = 64;
/// A leaf is guided where the second moment of what its directions bring is this much larger without. (1.05 costs a tenth of
/// the error in a room lit through a door ajar.)
const LEAST_GAIN: f64 = 1.0;

/// Most directions that a leaf may have seen after so many paths before it splits.
pub(super) fn most_directions(paths: u64) -> u64 {
    SPLIT * paths.isqrt()
}

/// Whether guiding pays in a leaf: the second moment without is more than `least` times that with it.
pub(super) fn pays(leaf: &Leaf, least: f64) -> bool {
    let Leaf { count, plain, mixed, .. } = *leaf;
    count >= LEAST_COUNT && plain > 0 && plain as f64 > least * mixed as f64
}

/// Adds the next leaf's directions and radiance to `guide`.
pub(super) fn freeze_leaf(guide: &mut Guide, leaf: &Leaf) {
    let known = leaf.count >= LEAST_COUNT && leaf.irradiance > 0;
    let lobes = if known { lobes(&leaf.bins) } else { Lobes::uniform() };
    guide.densities.extend(lobes.densities());
    guide.lobes.push(lobes);
    let mean = leaf.irradiance as f64 / UNIT as f64 / leaf.count.max(1) as f64;
    guide.reflected.push(if known { (mean / std::f64::consts::PI) as f32 } else { 0.0 });
}

/// The place of a leaf in the tree over Morton codes.
#[derive(Clone, Copy, Debug)]
struct Node {
    face: usize,
    first: usize,
    depth: u32,
}

/// The state of the training.
#[derive(Debug)]
pub struct Training {
    nodes: Vec<Node>,
    records: GuideRecords,
    /// Paths so far.
    paths: u64,
    grid: (u32, u32),
}

impl Training {
    /// No paths yet, over a grid of pixels.
    pub fn new(grid: (u32, u32)) -> Training {
        let nodes = (0..FACES).map(|face| Node { face, first: 0, depth: 0 }).collect();
        Training { nodes, records: GuideRecords::new(FACES, (grid.0 * grid.1) as usize), paths: 0, grid }
    }

    /// The same, of a pass that is asked what its directions have found one by one.
    pub fn one_by_one(grid: (u32, u32)) -> Training {
        let mut training = Training::new(grid);
        training.records.outcomes = Some(Outcomes::default());
        training
    }

    /// What all passes have told.
    pub fn into_records(self) -> GuideRecords {
        self.records
    }

    /// Records of one thread for the next pass: empty.
    pub fn empty(&self) -> GuideRecords {
        let outcomes = self.records.outcomes.as_ref().map(|_| Outcomes::default());
        GuideRecords { outcomes, ..GuideRecords::new(self.nodes.len(), self.records.image.len()) }
    }

    /// Adds the records of a pass, to be called for every thread.
    pub fn take(&mut self, records: &mut GuideRecords) {
        self.records.take(records);
    }

    /// The second moment, by path, of what the paths of the pass just added have brought after their bounces, over what their
    /// pixels show; to be asked for before [`Training::freeze`], which ends the pass with `spp` samples of each pixel.
    pub fn indirect(&self, spp: u32) -> f64 {
        let paths = u64::from(spp) * self.records.image.len() as u64 - self.paths;
        self.records.indirect as f64 / f64::from(SQUARE_UNIT) / paths.max(1) as f64
    }

    /// Leaves, and how many of them are guided.
    pub fn leaves(&self) -> (usize, usize) {
        (self.nodes.len(), (0..self.nodes.len()).filter(|&leaf| self.pays(leaf)).count())
    }

    /// Ends a pass after which each pixel of the grid has had `spp` samples: splits leaves and freezes what is known into
    /// `guide`. `guides`: directions are to be guided where that pays.
    pub fn freeze(&mut self, guide: &mut Guide, spp: u32, guides: bool) {
        self.paths = u64::from(spp) * self.records.image.len() as u64;
        let mut guided: Vec<bool> = (0..self.nodes.len()).map(|leaf| guides && self.pays(leaf)).collect();
        self.split(&mut guided);
        guide.lobes.clear();
        guide.densities.clear();
        guide.reflected.clear();
        self.records.leaves.iter().for_each(|leaf| freeze_leaf(guide, leaf));
        for (leaf, (node, guided)) in self.nodes.iter().zip(guided).enumerate() {
            let first = node.face * CODES + node.first;
            let places = first..first + (CODES >> node.depth);
            guide.leaves[places].fill(leaf as u16 | if guided { GUIDED } else { 0 });
        }
        guide.pixels.inverse = inverse_pixels(&self.records.image, self.grid, spp);
        // What was judged by older tables counts half as much as what the new ones will be judged by.
        for leaf in &mut self.records.leaves {
            (leaf.plain, leaf.mixed) = (leaf.plain / 2, leaf.mixed / 2);
        }
        self.records.indirect = 0;
    }

    /// Whether guiding pays in a leaf.
    fn pays(&self, leaf: usize) -> bool {
        pays(&self.records.leaves[leaf], LEAST_GAIN)
    }

    /// Halves leaves, along the next bit of the Morton code, until none has seen too many directions. Each half gets half of
    /// what was known.
    fn split(&mut self, guided: &mut Vec<bool>) {
        let most = most_directions(self.paths);
        let mut at = 0;
        while at < self.nodes.len() {
            while self.records.leaves[at].count > most
                && self.nodes[at].depth < 3 * CELL_BITS
                && self.nodes.len() < MOST_LEAVES
            {
                let node = &mut self.nodes[at];
                node.depth += 1;
                let other = Node { first: node.first + (CODES >> node.depth), ..*node };
                self.nodes.push(other);
                let leaf = &mut self.records.leaves[at];
                leaf.halve();
                let leaf = leaf.clone();
                self.records.leaves.push(leaf);
                guided.push(guided[at]);
            }
            at += 1;
        }
    }
}
