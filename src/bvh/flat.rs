//! The list of leaves that the smallest scenes are walked by instead of a tree.

use crate::bvh::rounding::{least_det, size_of};
use crate::lanes::LANES;

/// The most corners in a leaf.
pub(crate) const CORNERS: usize = 32;
/// What a visit of a leaf, a corner and a triangle take, roughly in cycles.
const LEAF_COST: f32 = 12.0;
const CORNER_COST: f32 = 4.0;
const TRIANGLE_COST: f32 = 11.0;
/// Beyond this a stream through the tree is faster: in a room of 96 cubes, 1,164 triangles, the list still is.
const MOST_COST: f32 = 6000.0;

/// A leaf: its box, and where its corners and triangles are in the list.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(crate) struct Leaf {
    /// min x, max x, min y, max y, min z, max z.
    pub(crate) bounds: [f32; LANES],
    pub(crate) corners: std::ops::Range<u32>,
    pub(crate) triangles: std::ops::Range<u32>,
    /// The largest of its triangles' least determinants.
    pub(crate) least_det: f32,
}

/// A triangle: which corners of its leaf it has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    pub(crate) id: u32,
    pub(crate) corners: [u8; 3],
}

/// The triangles of a small scene, in leaves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flat {
    pub(crate) leaves: Vec<Leaf>,
    /// x, y, z in the first three lanes.
    pub(crate) corners: Vec<[f32; LANES]>,
    pub(crate) triangles: Vec<Triangle>,
    /// By id, [`crate::simd::native::walks::triangle::least_det`].
    pub(crate) least_det: Vec<f32>,
}

type Vertices = [[f32; 3]; 3];

/// A leaf in the making.
#[derive(Clone, Debug, Default)]
struct Group {
    corners: Vec<[f32; 3]>,
    triangles: Vec<Triangle>,
}

impl Group {
    /// Adds a triangle unless it has too many new corners.
    fn add(&mut self, id: u32, vertices: Vertices) -> bool {
        let before = self.corners.len();
        let corners = vertices.map(|vertex| {
            let known = self.corners.iter().position(|corner| corner.map(f32::to_bits) == vertex.map(f32::to_bits));
            known.unwrap_or_else(|| {
                self.corners.push(vertex);
                self.corners.len() - 1
            })
        });
        if self.corners.len() > CORNERS {
            self.corners.truncate(before);
            return false;
        }
        self.triangles.push(Triangle { id, corners: corners.map(|corner| corner as u8) });
        true
    }

    fn bounds(&self) -> [[f32; 2]; 3] {
        std::array::from_fn(|axis| {
            let along =
                |fold: fn(f32, f32) -> f32, from| self.corners.iter().map(|corner| corner[axis]).fold(from, fold);
            [along(f32::min, f32::INFINITY), along(f32::max, f32::NEG_INFINITY)]
        })
    }

    /// Ids, and [`Flat::least_det`] of them, in a scene that reaches to `extent`.
    fn least_det(&self, extent: f32) -> impl Iterator<Item = (u32, f32)> {
        let leaf = size_of(self.corners.iter().copied());
        self.triangles.iter().map(move |triangle| {
            let corners = triangle.corners.map(|corner| self.corners[corner as usize]);
            (triangle.id, least_det(size_of(corners), leaf, extent))
        })
    }

    /// What eight unrelated rays spend on it in a scene of half surface `scene`.
    fn cost(&self, scene: f32) -> f32 {
        let miss = 1.0 - (half_area(self.bounds()) / scene).min(1.0);
        let inside = self.corners.len() as f32 * CORNER_COST + self.triangles.len() as f32 * TRIANGLE_COST;
        LEAF_COST + (1.0 - miss.powi(LANES as i32)) * inside
    }
}

fn half_area(bounds: [[f32; 2]; 3]) -> f32 {
    let [x, y, z] = bounds.map(|[min, max]| max - min);
    x * y + y * z + z * x
}

impl Flat {
    /// The list of `triangles`, ids descending, if eight unrelated rays get through it in less than [`MOST_COST`]. Leaves are runs of ids, files being written object by object; where one
    /// ends and the next begins is chosen by dynamic programming.
    pub(crate) fn new(triangles: &[(u32, Vertices)], extent: f32) -> Option<Self> {
        let mut all = Group::default();
        all.corners.extend(triangles.iter().flat_map(|triangle| triangle.1));
        let scene = half_area(all.bounds()).max(f32::MIN_POSITIVE);
        // `best[i]`: the least cost of triangles from i on, and the end of the first leaf.
        let mut best = vec![(0.0, 0); triangles.len() + 1];
        for first in (0..triangles.len()).rev() {
            let mut group = Group::default();
            best[first] = (f32::INFINITY, first + 1);
            for (end, &(id, vertices)) in (first + 1..).zip(&triangles[first..]) {
                if !group.add(id, vertices) {
                    break;
                }
                let cost = group.cost(scene) + best[end].0;
                if cost < best[first].0 {
                    best[first] = (cost, end);
                }
            }
        }
        if best[0].0 > MOST_COST {
            return None;
        }
        let ids = triangles.iter().map(|triangle| triangle.0 as usize + 1).max().unwrap_or(1);
        let mut flat = Self { least_det: vec![0.0; ids], ..Self::default() };
        let mut first = 0;
        while first < triangles.len() {
            let mut group = Group::default();
            for &(id, vertices) in &triangles[first..best[first].1] {
                group.add(id, vertices);
            }
            first = best[first].1;
            let mut most: f32 = 0.0;
            for (id, least_det) in group.least_det(extent) {
                flat.least_det[id as usize] = least_det;
                most = most.max(least_det);
            }
            let [[x0, x1], [y0, y1], [z0, z1]] = group.bounds();
            let (corners, triangles) = (flat.corners.len() as u32, flat.triangles.len() as u32);
            flat.corners.extend(group.corners.iter().map(|&[x, y, z]| [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0]));
            flat.triangles.extend(group.triangles);
            flat.leaves.push(Leaf {
                bounds: [x0, x1, y0, y1, z0, z1, 0.0, 0.0],
                corners: corners..flat.corners.len() as u32,
                triangles: triangles..flat.triangles.len() as u32,
                least_det: most,
            });
        }
        Some(flat)
    }

    /// Bytes of the list.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.least_det[..])
    }

    /// The corners of triangle `id`, scene units.
    pub(crate) fn vertices(&self, id: u32) -> Option<Vertices> {
        self.leaves.iter().find_map(|leaf| {
            let triangle = leaf.triangles(self).iter().find(|triangle| triangle.id == id)?;
            Some(triangle.vertices(self, leaf))
        })
    }
}

impl Leaf {
    #[inline(always)]
    pub(crate) fn triangles<'a>(&self, flat: &'a Flat) -> &'a [Triangle] {
        &flat.triangles[self.triangles.start as usize..self.triangles.end as usize]
    }
}

impl Triangle {
    /// Its corners, scene units.
    pub(crate) fn vertices(&self, flat: &Flat, leaf: &Leaf) -> Vertices {
        self.corners.map(|corner| {
            let [x, y, z, ..] = flat.corners[leaf.corners.start as usize + corner as usize];
            [x, y, z]
        })
    }
}
