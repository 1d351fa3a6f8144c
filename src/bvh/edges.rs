//! Edges of triangles by where their ends are, whatever vertices they are written with.

use std::collections::HashMap;

/// An edge: the bits of its two corners, the lower first.
pub type Edge = [[u32; 3]; 2];

/// The edge opposite a corner.
pub fn edge_of(vertices: [[f32; 3]; 3], opposite: usize) -> Edge {
    let (a, b) = (place(vertices[(opposite + 1) % 3]), place(vertices[(opposite + 2) % 3]));
    if a < b { [a, b] } else { [b, a] }
}

/// The bits of a corner; both zeros are one place.
pub fn place(corner: [f32; 3]) -> [u32; 3] {
    corner.map(|x| (x + 0.0).to_bits())
}

/// What is known of edges, those of precise triangles. (By place, not through the tree: of slivers that all overlap, each would
/// meet all the others.)
pub struct Edges<T> {
    of_edge: HashMap<Edge, T>,
    /// A bit for the hash of every corner of these edges: hardly any other triangle has two of them.
    corners: Vec<u64>,
}

impl<T> Edges<T> {
    /// For the edges of so many triangles.
    pub fn new(triangles: usize) -> Edges<T> {
        // 16 bits a triangle: one in some six is set.
        Edges { of_edge: HashMap::new(), corners: vec![0; (triangles / 4).next_power_of_two().max(16)] }
    }

    /// Word and bit of a corner.
    fn bit(&self, corner: [u32; 3]) -> (usize, u64) {
        let mix = |hash: u64, bits: u32| (hash ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        let hash = corner.into_iter().fold(0, mix);
        ((hash >> 6) as usize & (self.corners.len() - 1), 1 << (hash & 63))
    }

    /// What is known of an edge; first `new`.
    pub fn entry(&mut self, edge: Edge, new: T) -> &mut T {
        for corner in edge {
            let (word, bit) = self.bit(corner);
            self.corners[word] |= bit;
        }
        self.of_edge.entry(edge).or_insert(new)
    }

    /// What is known of the edges of a triangle, of those of which anything is.
    pub fn known(&mut self, vertices: [[f32; 3]; 3], mut tell: impl FnMut(&mut T)) {
        let may_be = vertices.map(|corner| {
            let (word, bit) = self.bit(place(corner));
            self.corners[word] & bit != 0
        });
        for opposite in 0..3 {
            if may_be[(opposite + 1) % 3]
                && may_be[(opposite + 2) % 3]
                && let Some(known) = self.of_edge.get_mut(&edge_of(vertices, opposite))
            {
                tell(known);
            }
        }
    }
}
