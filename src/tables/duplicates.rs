//! Triangles that other triangles lie on corner by corner: exporters double faces, and panels are made two-sided by a reversed
//! copy. A ray hits both at one place, and only the first in the file can be what it has hit; so the others are dropped, for
//! all strategies alike, and the user is told.

use crate::bvh::threads;
use crate::fault::{Fault, planted};
use crate::scene::desc::MaterialDesc;
use crate::scene::flatten::Geometry;
use crate::tables::lights::emitters::Emitter;

/// Triangles that a thread hashes at a time.
const CHUNK: usize = 1 << 14;
/// The hash of what is no copy of anything; no hash has this bit.
const NO_HASH: u64 = 1 << 63;

/// What was dropped.
pub struct Duplicates {
    /// Triangles that have a copy before them in the file.
    pub dropped: Vec<u32>,
    /// Emitters whose dropped copy is wound the other way and emits the same: both sides of them emit.
    two_sided: Vec<u32>,
}

impl Duplicates {
    /// Finds copies among the triangles that have an area. Of cut-out triangles none is a copy: each may be there where another
    /// is not.
    pub fn find(materials: &[MaterialDesc], geometry: &Geometry<'_>, degenerate: &[bool]) -> Duplicates {
        let whole = |id: u32| materials[geometry.triangles[id as usize].material as usize].alpha_mask.is_none();
        let count = geometry.triangles.len();
        let threads = threads::count(0, count);
        let hashes = threads::map(threads, threads::ranges(count, CHUNK), |ids| -> Vec<u64> {
            let wanted = |id: u32| !degenerate[id as usize] && whole(id);
            let hash_of = |id: u32| if wanted(id) { hash(sorted_corners(geometry, id)) } else { NO_HASH };
            ids.map(|id| hash_of(id as u32)).collect()
        });
        let mut by_hash = alike(&hashes);
        by_hash.sort_unstable();
        let mut found = Duplicates { dropped: Vec::new(), two_sided: Vec::new() };
        if planted(Fault::KeptCopies) {
            return found;
        }
        for alike in by_hash.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
            // Nearly always all of one place; different triangles of one hash are told apart here.
            let mut firsts: Vec<u32> = Vec::new();
            for &(_, id) in alike {
                match firsts.iter().find(|&&first| sorted_corners(geometry, first) == sorted_corners(geometry, id)) {
                    None => firsts.push(id),
                    Some(&first) => found.drop_copy(materials, geometry, first, id),
                }
            }
        }
        found.dropped.sort_unstable();
        found
    }

    fn drop_copy(&mut self, materials: &[MaterialDesc], geometry: &Geometry<'_>, first: u32, copy: u32) {
        self.dropped.push(copy);
        let material = |id: u32| geometry.triangles[id as usize].material;
        let emits = materials[material(copy) as usize].emission.iter().any(|&c| c > 0.0);
        if emits && material(first) == material(copy) && faces(geometry, first) != faces(geometry, copy) {
            self.two_sided.push(first);
        }
    }

    /// Makes emitters two-sided whose other side a dropped copy was.
    pub fn light_both_sides(&self, emitters: &mut [Emitter]) {
        for id in &self.two_sided {
            if let Ok(place) = emitters.binary_search_by_key(id, |emitter| emitter.triangle) {
                emitters[place].two_sided = true;
            }
        }
    }

    /// What the user should know.
    pub fn warning(&self) -> Option<String> {
        let count = self.dropped.len();
        (count > 0).then(|| {
            let (noun, verb) = if count == 1 { ("triangle", "was") } else { ("triangles", "were") };
            format!(
                "{count} {noun} {verb} dropped, the first of them number {}: each has the corners of one before it in the \
                 file, which every ray hits instead; remove doubled faces, or say `two_sided = true` for lamps that are to \
                 shine on both sides",
                self.dropped[0]
            )
        })
    }
}

/// The hashes, and their places, that are not the only ones of their marks, which are few: only these need to be sorted.
fn alike(hashes: &[Vec<u64>]) -> Vec<(u64, u32)> {
    let all = || hashes.iter().flatten().zip(0..).filter(|&(&hash, _)| hash != NO_HASH);
    // Marks: bits of the hash, at least 16 for each triangle.
    let bits = (16 * CHUNK * hashes.len()).next_power_of_two();
    let place = |hash: u64| ((hash >> 6) as usize & (bits / 64 - 1), 1u64 << (hash & 63));
    let (mut seen, mut twice) = (vec![0u64; bits / 64], vec![0u64; bits / 64]);
    for (&hash, _) in all() {
        let (word, bit) = place(hash);
        twice[word] |= seen[word] & bit;
        seen[word] |= bit;
    }
    let is_twice = |hash: u64| {
        let (word, bit) = place(hash);
        twice[word] & bit != 0
    };
    all().filter(|&(&hash, _)| is_twice(hash)).map(|(&hash, id)| (hash, id)).collect()
}

/// The corners of a triangle as bits, in an order that does not depend on theirs; both zeros are one number.
fn sorted_corners(geometry: &Geometry<'_>, id: u32) -> [[u32; 3]; 3] {
    let mut corners = geometry.vertices(id as usize).map(|corner| corner.map(|x| (x + 0.0).to_bits()));
    corners.sort_unstable();
    corners
}

fn hash(corners: [[u32; 3]; 3]) -> u64 {
    let mix = |hash: u64, word: u32| (hash ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    let hash = corners.into_iter().flatten().fold(0, mix);
    // The last words have hardly reached the low bits, of which the marks are made.
    (hash ^ hash >> 32) & !NO_HASH
}

/// Which way a triangle faces: whether its winding is an even order of its sorted corners.
fn faces(geometry: &Geometry<'_>, id: u32) -> bool {
    let corners = geometry.vertices(id as usize).map(|corner| corner.map(|x| (x + 0.0).to_bits()));
    let even = (corners[0] < corners[1]) ^ (corners[1] < corners[2]) ^ (corners[0] < corners[2]);
    even != geometry.triangles[id as usize].flipped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::desc::{InstanceDesc, MeshDesc, SceneDesc, TriangleDesc};

    fn scene(triangles: &[([u32; 3], u32)]) -> SceneDesc {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangle = |&(vertices, material): &([u32; 3], u32)| TriangleDesc { vertices, material, flipped: false };
        let triangles = triangles.iter().map(triangle).collect();
        let mut desc = crate::scene::builtin::build("heavy:2000").unwrap();
        desc.meshes = vec![MeshDesc { positions, triangles, corners: Vec::new() }];
        desc.instances = vec![InstanceDesc::default()];
        desc.materials[0].emission = [1.0; 3];
        desc
    }

    #[test]
    fn copies_in_any_order_of_corners_are_dropped_and_reversed_lamps_shine_on_both_sides() {
        let orders = [([0, 1, 2], false), ([1, 2, 0], false), ([2, 1, 0], true), ([1, 0, 2], true), ([0, 2, 1], true)];
        for (order, reversed) in orders {
            let desc = scene(&[([0, 1, 3], 0), ([0, 1, 2], 0), (order, 0), ([1, 2, 3], 0)]);
            let geometry = desc.geometry();
            let found = Duplicates::find(&desc.materials, &geometry, &[false; 4]);
            assert_eq!(found.dropped, [2]);
            assert_eq!(found.two_sided, if reversed { vec![1] } else { vec![] }, "{order:?}");
            assert!(found.warning().unwrap().contains("number 2"));
        }
        let desc = scene(&[([0, 1, 2], 1), ([2, 1, 0], 0), ([0, 1, 2], 0)]);
        let found = Duplicates::find(&desc.materials, &desc.geometry(), &[false; 3]);
        assert_eq!((found.dropped, found.two_sided), (vec![1, 2], vec![]), "a wall comes first and stays a wall");
    }
}
