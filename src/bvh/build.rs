//! Building the tree, looking at it, checking it.

use crate::bvh::collapse::{Shape, Wide, collapse};
use crate::bvh::flat::Flat;
use crate::bvh::huge::Table;
use crate::bvh::node::{Child, LeafBlock, NO_TRIANGLE, Node, Tables};
use crate::bvh::precise::{HUGE, PRECISE, classify};
use crate::bvh::{prims, reinsert, sah, threads};
use crate::lanes::LANES;
use obvhs::bvh2::Bvh2;

/// The tree over a scene's triangles.
#[derive(Debug)]
pub struct Bvh {
    nodes: Table<Node>,
    leaves: Table<LeafBlock>,
    triangles: usize,
    depth: usize,
    extent: f32,
    /// Of the smallest scenes only.
    flat: Option<Flat>,
    /// By triangle id; empty if all are common.
    classes: Vec<u8>,
    /// By leaf block, the lanes that are not common; empty if all are.
    precise: Vec<u8>,
    /// Per leaf block, below what determinants rays may see a triangle of it edge-on ([`crate::bvh::rounding`]).
    least_det: Vec<f32>,
}

/// How to build.
#[derive(Clone, Copy, Debug)]
pub struct BuildOptions {
    /// The most triangles in a leaf, 1 to 8. Packets pay for every triangle, one-ray walks for every block.
    pub leaf_size: usize,
    /// Threads that build, 0 for one a core. They change no bit.
    pub threads: usize,
}

/// Scenes of up to this many triangles are walked by packets only, which like small leaves.
const SMALL_SCENE: usize = 1 << 10;

/// The binary tree of larger scenes has leaves of two triangles.
const SOURCE_LEAF: usize = 2;

/// Scenes of up to this many triangles are also kept as a list, if that is fast.
const FLAT_SCENE: usize = 1280;

impl BuildOptions {
    /// What measured best for a scene of `triangles` triangles.
    pub fn for_scene(triangles: usize) -> Self {
        Self { leaf_size: if triangles <= SMALL_SCENE { 4 } else { LANES }, threads: 0 }
    }
}

impl Bvh {
    /// The tree over those triangles whose id (their index in `triangles`) is to be included; triangles without area need
    /// not be. Positions must be finite.
    pub fn build(positions: &[[f32; 3]], triangles: &[[u32; 3]], include: impl Fn(u32) -> bool + Sync) -> Self {
        Self::build_with(positions, triangles, include, BuildOptions::for_scene(triangles.len()))
    }

    /// [`Bvh::build`] where some triangles emit: what lies under a small lamp is tested with more care.
    pub fn build_lit(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        include: impl Fn(u32) -> bool + Sync,
        emits: impl Fn(u32) -> bool,
    ) -> Self {
        Self::build_from(positions, triangles, include, emits, BuildOptions::for_scene(triangles.len()))
    }

    /// [`Bvh::build`] with options of one's own.
    pub fn build_with(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        include: impl Fn(u32) -> bool + Sync,
        options: BuildOptions,
    ) -> Self {
        Self::build_from(positions, triangles, include, |_| false, options)
    }

    fn build_from(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        include: impl Fn(u32) -> bool + Sync,
        emits: impl Fn(u32) -> bool,
        options: BuildOptions,
    ) -> Self {
        let vertices = |id: u32| triangles[id as usize].map(|vertex| positions[vertex as usize]);
        let (leaf_size, threads) =
            (options.leaf_size.clamp(1, LANES), threads::count(options.threads, triangles.len()));
        let source = Self::source_tree_with(positions, triangles, include, BuildOptions { leaf_size, threads });
        let classes = classify(&source, positions, triangles, emits, threads);
        let extent = source.nodes.first().map_or(0.0, |root| root.min.abs().max(root.max.abs()).max_element());
        let precise = |id: u32| classes.get(id as usize).is_some_and(|class| class & PRECISE != 0);
        let any_precise = classes.iter().any(|&class| class & PRECISE != 0);
        let wide = collapse(&source, leaf_size, &Shape { vertices, precise, any_precise, extent }, threads);
        let triangles = source.primitive_indices.len();
        let flat = (triangles <= FLAT_SCENE && !any_precise).then(|| {
            let mut ids = source.primitive_indices.clone();
            ids.sort_unstable_by(|a, b| b.cmp(a));
            Flat::new(&ids.into_iter().map(|id| (id, vertices(id))).collect::<Vec<_>>(), extent)
        });
        let Wide { nodes, leaves, least_det, precise, depth } = wide;
        Self { nodes, leaves, triangles, depth, extent, flat: flat.flatten(), classes, precise, least_det }
    }

    /// The binary tree that [`Bvh::build`] collapses.
    pub fn source_tree(positions: &[[f32; 3]], triangles: &[[u32; 3]], include: impl Fn(u32) -> bool + Sync) -> Bvh2 {
        let options = BuildOptions::for_scene(triangles.len());
        let threads = threads::count(options.threads, triangles.len());
        Self::source_tree_with(positions, triangles, include, BuildOptions { threads, ..options })
    }

    fn source_tree_with(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        include: impl Fn(u32) -> bool + Sync,
        BuildOptions { leaf_size, threads }: BuildOptions,
    ) -> Bvh2 {
        assert!(triangles.len() < 1 << 31, "triangle ids are below 2^31");
        let vertices = |id: u32| triangles[id as usize].map(|vertex| positions[vertex as usize]);
        let (mut prims, known) = prims::gather(triangles.len(), threads, vertices, include);
        let source_leaf = if triangles.len() <= SMALL_SCENE { 1 } else { SOURCE_LEAF.min(leaf_size) };
        let mut tree = sah::build(prims.rows_mut(), known, source_leaf, threads);
        if !tree.nodes.is_empty() {
            reinsert::optimise(&mut tree, threads);
            reinsert::lay_out(&mut tree);
        }
        tree
    }

    /// All nodes, the root first; a parent comes before its children.
    #[inline]
    pub fn nodes(&self) -> &[Node] {
        self.nodes.rows()
    }
    /// All leaf blocks; at least one, which may be empty.
    #[inline]
    pub fn leaves(&self) -> &[LeafBlock] {
        self.leaves.rows()
    }
    /// How many triangles the tree holds.
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }
    /// Levels of nodes, the root's included.
    pub fn depth(&self) -> usize {
        self.depth
    }
    /// The most entries a depth-first walk that pushes every hit child can have on its stack.
    pub fn stack_bound(&self) -> usize {
        self.depth * (LANES - 1) + 1
    }
    /// The largest |coordinate| of all triangles, scene units.
    pub fn extent(&self) -> f32 {
        self.extent
    }
    /// The class of a triangle ([`crate::bvh::precise`]); 0 for most.
    #[inline]
    pub fn class(&self, id: u32) -> u8 {
        self.classes.get(id as usize).copied().unwrap_or(0)
    }
    /// The lanes whose triangles have a bit of `class`.
    #[inline(always)]
    pub fn lanes_of_class<const N: usize>(&self, triangles: [u32; N], class: u8) -> u8 {
        let bit = |lane: usize| ((self.class(triangles[lane]) & class != 0) as u8) << lane;
        (0..N).fold(0, |bits, lane| bits | bit(lane))
    }
    /// How many triangles are tested in f64, and how many of them because something far smaller lies on them.
    pub fn precise_triangles(&self) -> (usize, usize) {
        let of = |bit: u8| self.classes.iter().filter(|&class| class & bit != 0).count();
        (of(PRECISE), of(HUGE))
    }
    /// The tables' names and sizes in bytes.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        let mut tables = vec![("bvh nodes", self.nodes.bytes()), ("bvh leaves", self.leaves.bytes())];
        tables.push(("bvh triangle classes", self.classes.len()));
        tables.extend(self.flat.as_ref().map(|flat| ("bvh list", flat.bytes())));
        tables
    }
    #[inline(always)]
    pub(crate) fn flat(&self) -> Option<&Flat> {
        self.flat.as_ref()
    }
    #[inline(always)]
    pub(crate) fn walk_tables(&self) -> Tables<'_> {
        Tables {
            nodes: self.nodes(),
            leaves: self.leaves(),
            classes: &self.classes,
            precise: &self.precise,
            least_det: &self.least_det,
            extent: self.extent,
        }
    }

    /// Checks every promise of the tables: each node and block has one parent, boxes hold what is below them, ids ascend,
    /// slots fill from 0, the depth is right. The first broken one, in words.
    pub fn validate(&self) -> Result<(), String> {
        let (nodes, leaves) = (self.nodes(), self.leaves());
        let mut node_seen = vec![false; nodes.len()];
        let mut leaf_seen = vec![false; leaves.len()];
        let mut ids = vec![];
        let mut depth = 0;
        let mut pending = vec![(0, 1, [[f32::NEG_INFINITY, f32::INFINITY]; 3])];
        while let Some((index, level, outer)) = pending.pop() {
            let node: &Node = nodes.get(index).ok_or(format!("node {index} does not exist"))?;
            if std::mem::replace(&mut node_seen[index], true) {
                return Err(format!("node {index} has two parents"));
            }
            depth = depth.max(level);
            for slot in 0..LANES {
                let bounds: [[f32; 2]; 3] =
                    std::array::from_fn(|axis| std::array::from_fn(|side| node.bounds[axis][side][slot]));
                let inside = |inner: &[[f32; 2]; 3], outer: &[[f32; 2]; 3]| {
                    (0..3).all(|axis| inner[axis][0] >= outer[axis][0] && inner[axis][1] <= outer[axis][1])
                };
                let child = node.child(slot);
                if child != Child::Empty && !inside(&bounds, &outer) {
                    return Err(format!("child {slot} of node {index} reaches out of its parent"));
                }
                match child {
                    Child::Empty => {
                        if bounds != [[f32::INFINITY, f32::NEG_INFINITY]; 3] {
                            return Err(format!("empty slot {slot} of node {index} can be hit"));
                        }
                    }
                    Child::Inner(child) => pending.push((child, level + 1, bounds)),
                    Child::Leaf(block, count) => {
                        let leaf = leaves.get(block).ok_or(format!("leaf {block} does not exist"))?;
                        if std::mem::replace(&mut leaf_seen[block], true) {
                            return Err(format!("leaf {block} has two parents"));
                        }
                        if !leaf.ids[..count].is_sorted_by(|a, b| a < b)
                            || leaf.ids[count - 1] == NO_TRIANGLE
                            || leaf.ids[count..].iter().any(|&id| id != NO_TRIANGLE)
                        {
                            return Err(format!("leaf {block} of {count} triangles holds ids {:?}", leaf.ids));
                        }
                        ids.extend_from_slice(&leaf.ids[..count]);
                        let corners = (0..count).flat_map(|lane| leaf.vertices.map(|v| v.map(|axis| axis[lane])));
                        for corner in corners {
                            if !inside(&corner.map(|x| [x, x]), &bounds) {
                                return Err(format!("a triangle of leaf {block} reaches out of its box"));
                            }
                        }
                    }
                }
            }
        }
        ids.sort_unstable();
        ids.dedup();
        if ids.len() != self.triangles {
            return Err(format!("{} triangles, {} of them in leaves", self.triangles, ids.len()));
        }
        if node_seen.contains(&false) || (self.triangles > 0 && leaf_seen.contains(&false)) {
            return Err("a node or leaf has no parent".into());
        }
        if depth != self.depth {
            return Err(format!("depth {} is said, {depth} found", self.depth));
        }
        Ok(())
    }
}
