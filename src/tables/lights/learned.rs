//! What was learned of the lights: by how much each cluster of the light tree is worth more or less than its importance says,
//! for a cell of the scene and the way a surface in it faces. Plain data, frozen while anything is rendered with it;
//! [`crate::learn`] says where the numbers come from.
//!
//! ```text
//! key (cell and face of a hit) --rows--> row --(row, slot of the node)--> word: a byte for each of the node's eight columns
//!                                            \--(row, patch)--> share of a patch of the environment map
//! ```

use crate::tables::lights::patches::LearnedPatches;
use crate::tables::lights::tree::{LEAF, LightTree, WIDTH};
use crate::tables::prepared::PreparedScene;

/// Cells along the longest side of the scene.
pub const CELLS: u32 = 16;
/// Faces of a cell: the dominant axis and its sign.
pub const FACES: u32 = 6;
/// Bins of the reflected direction: its face, and the signs along the other two axes.
pub const MIRROR_BINS: u32 = 4 * FACES;
/// Levels of the light tree whose nodes have words: the root and its child nodes. (A third level gained little and cost 3 to
/// 10 % more time.)
pub const LEVELS: usize = 2;

/// The word of a node of which nothing is known: all columns alike.
pub const ALIKE: u64 = 0x0101_0101_0101_0101;
/// The least factor over the largest of its node: what was not worth anything so far still gets samples. (0.1 cost efficiency,
/// as did a part of samples without factors.)
pub const LEAST_FACTOR: f64 = 1.0 / 32.0;
/// [`LearnedLights::slots`] of a node without words.
pub const NO_SLOT: u32 = u32::MAX;

/// Cubes that cover the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Where the cells begin, scene units.
    pub low: [f32; 3],
    /// Cells a scene unit.
    pub scale: f32,
    /// Cells along each axis, 1 to [`CELLS`].
    pub size: [u32; 3],
}

impl Grid {
    /// The grid over all triangles of a scene.
    pub fn new(scene: &PreparedScene) -> Grid {
        let vertices = || scene.triangles.iter().flat_map(|triangle| triangle.vertices);
        let bound = |axis: usize, start: f32, pick: fn(f32, f32) -> f32| {
            vertices().fold(start, |bound, vertex| pick(bound, vertex[axis]))
        };
        let low: [f32; 3] = std::array::from_fn(|axis| bound(axis, f32::INFINITY, f32::min));
        let high: [f32; 3] = std::array::from_fn(|axis| bound(axis, f32::NEG_INFINITY, f32::max));
        let length: [f32; 3] = std::array::from_fn(|axis| high[axis] - low[axis]);
        let scale = CELLS as f32 / length.into_iter().fold(f32::MIN_POSITIVE, f32::max);
        Grid { low, scale, size: length.map(|length| ((length * scale).ceil() as u32).clamp(1, CELLS)) }
    }

    /// How many cells there are.
    pub fn cells(&self) -> u32 {
        self.size.iter().product()
    }

    /// Along each axis, which cell `point` is in, or the nearest one.
    pub fn axes(&self, point: [f32; 3]) -> [u32; 3] {
        std::array::from_fn(|axis| {
            let along = (point[axis] - self.low[axis]) * self.scale;
            along.max(0.0).min((self.size[axis] - 1) as f32) as u32
        })
    }

    /// The number of the cell at these places along the axes.
    pub fn cell(&self, [x, y, z]: [u32; 3]) -> u32 {
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// How many keys there are. Those of diffuse surfaces come first: `cell * FACES + face of the normal`; those of the
    /// others follow: `cells * FACES + cell * MIRROR_BINS + bin of the reflected direction`.
    pub fn keys(&self) -> u32 {
        self.cells() * (FACES + MIRROR_BINS)
    }
}

/// The tables.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedLights {
    /// Where cells are.
    pub grid: Grid,
    /// Per key, its row; 0: nothing is known.
    pub rows: Vec<u32>,
    /// Per node of the light tree, its slot, or [`NO_SLOT`].
    pub slots: Vec<u32>,
    /// Slots a row; 0: nothing is known of a light tree.
    pub slot_count: u32,
    /// Per row and slot, a byte from 1 to 255 for each of the node's columns, the first lowest: what the column's importance is
    /// multiplied by. Row 0 is [`ALIKE`] all along.
    pub words: Vec<u64>,
    /// Of a cluster of importance 1, what its samples may be worth: the strongest light's power over pi, as a diffuse white
    /// surface would send it on, summed over the channels.
    pub unit: f32,
    /// What was learned of the environment map.
    pub patches: Option<LearnedPatches>,
}

impl LearnedLights {
    /// Tables that know nothing, of a light tree and of a map, as far as there are these.
    pub fn new(scene: &PreparedScene, tree: Option<&LightTree>, patches: Option<LearnedPatches>) -> LearnedLights {
        let grid = Grid::new(scene);
        let mut learned = LearnedLights {
            grid,
            rows: vec![0; grid.keys() as usize],
            slots: Vec::new(),
            slot_count: 0,
            words: Vec::new(),
            unit: 0.0,
            patches,
        };
        if let Some(tree) = tree {
            learned.add_tree(tree);
        }
        learned
    }

    fn add_tree(&mut self, tree: &LightTree) {
        let mut slots = vec![NO_SLOT; tree.nodes.len()];
        slots[0] = 0;
        let root = &tree.nodes[0];
        let children = (0..WIDTH).filter(|&column| root.power[column] > 0.0 && root.child[column] & LEAF == 0);
        let children: Vec<usize> = children.map(|column| root.child[column] as usize).collect();
        children.iter().zip(1..).for_each(|(&child, slot)| slots[child] = slot);
        let slot_count = 1 + children.len() as u32;
        self.slots = slots;
        self.slot_count = slot_count;
        self.words = vec![ALIKE; slot_count as usize];
        self.unit = tree.strongest / std::f32::consts::PI;
    }

    /// Forgets what is known of the light tree.
    pub fn forget_tree(&mut self) {
        (self.slots, self.slot_count, self.words) = (Vec::new(), 0, Vec::new());
    }

    /// The word of a node for a row.
    #[inline]
    pub fn word(&self, row: u32, node: u32) -> u64 {
        match self.slots[node as usize] {
            NO_SLOT => ALIKE,
            slot => self.words[(row * self.slot_count + slot) as usize],
        }
    }

    /// The tables and their sizes in bytes.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        let mut tables = vec![
            ("learned light rows", size_of_val(&self.rows[..])),
            ("learned light slots", size_of_val(&self.slots[..])),
            ("learned light factors", size_of_val(&self.words[..])),
        ];
        tables.extend(self.patches.iter().flat_map(LearnedPatches::tables));
        tables
    }
}
