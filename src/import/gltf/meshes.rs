//! Meshes: their primitives, a mesh of ours each.

use super::file::File;
use super::materials::{Made, Materials};
use crate::error::Result;
use crate::scene::desc::{CornerDesc, MeshDesc, SceneDesc, TriangleDesc};
use glam::DVec3;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// The meshes that have been met so far, by their numbers in the file: the numbers of their primitives in the scene.
#[derive(Default)]
pub struct Meshes(HashMap<usize, Vec<u32>>);

impl Meshes {
    /// The primitives of mesh number `index` that are seen, read when they are first asked for.
    pub fn primitives(
        &mut self,
        file: &File<'_>,
        index: usize,
        materials: &mut Materials,
        scene: &mut SceneDesc,
    ) -> Result<&[u32]> {
        let place = match self.0.entry(index) {
            Entry::Occupied(known) => return Ok(known.into_mut()),
            Entry::Vacant(place) => place,
        };
        let mut numbers = Vec::new();
        for (i, primitive) in file.root.meshes[index].primitives.iter().enumerate() {
            let made = materials.get(file, primitive.material.map(|material| material.value()), scene);
            if made.hidden {
                continue;
            }
            let reader = Reader { file, primitive, made, place: format!("meshes[{index}].primitives[{i}]") };
            if let Some(mesh) = reader.read(&mut scene.warnings)? {
                numbers.push(scene.meshes.len() as u32);
                scene.meshes.push(mesh);
            }
        }
        Ok(place.insert(numbers))
    }
}

/// A primitive being read.
struct Reader<'a> {
    file: &'a File<'a>,
    primitive: &'a Primitive,
    made: Made,
    /// Where the file has it.
    place: String,
}

impl Reader<'_> {
    /// The mesh; `None` if the primitive has no triangles.
    fn read(&self, warnings: &mut Vec<String>) -> Result<Option<MeshDesc>> {
        let name = self.file.path.display();
        let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) = self.primitive.mode
        else {
            warnings.push(format!("{name}: points and lines are left out"));
            return Ok(None);
        };
        let Some(positions) = self.attribute::<3>(Semantic::Positions)? else { return Ok(None) };
        let fault = |why: String| Err(self.file.fault(&self.place, why));
        let vertices = positions.len();
        if u32::try_from(vertices).is_err() {
            return fault("more than 2^32 vertices".into());
        }
        let indices = match self.primitive.indices {
            Some(indices) => self.file.indices(indices)?,
            None => (0..vertices as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return fault(format!("it names vertex {index}; it has {vertices}"));
        }
        if let Some(vertex) = positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return fault(format!("its vertex {vertex} is not finite: {:?}", positions[vertex]));
        }
        let triangles = triangles(mode, &indices);
        if triangles.is_empty() {
            return Ok(None);
        }
        let corners = self.corners(vertices, &triangles, warnings)?;
        if self.primitive.attributes.contains_key(&Checked::Valid(Semantic::Colors(0))) {
            warnings.push(format!("{name}: colours of vertices are not kept"));
        }
        if self.primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
            warnings.push(format!("{name}: morph targets are not applied"));
        }
        let material = self.made.number;
        let triangle = |vertices: [u32; 3]| TriangleDesc { vertices, material, flipped: false };
        let triangles = triangles.into_iter().map(triangle).collect();
        Ok(Some(MeshDesc { positions, triangles, corners }))
    }

    /// What the vertices have of `semantic`, if they have it.
    fn attribute<const N: usize>(&self, semantic: Semantic) -> Result<Option<Vec<[f32; N]>>> {
        let accessor = self.primitive.attributes.get(&Checked::Valid(semantic));
        accessor.map(|&accessor| self.file.vectors(accessor)).transpose()
    }

    /// Normals and texture coordinates, as far as there are any.
    fn corners(&self, vertices: usize, triangles: &[[u32; 3]], warnings: &mut Vec<String>) -> Result<Vec<CornerDesc>> {
        let placement = self.made.placement;
        let normals = self.attribute::<3>(Semantic::Normals)?;
        let uvs = self.attribute::<2>(Semantic::TexCoords(placement.set))?;
        for (what, count) in
            [("normals", normals.as_ref().map(Vec::len)), ("texture coordinates", uvs.as_ref().map(Vec::len))]
        {
            if let Some(count) = count.filter(|&count| count < vertices) {
                return Err(self.file.fault(&self.place, format!("it has {vertices} vertices but {count} {what}")));
            }
        }
        if normals.is_none() && uvs.is_none() {
            return Ok(Vec::new());
        }
        let unit =
            |n: [f32; 3]| DVec3::from(n.map(f64::from)).try_normalize().map_or([0.0; 3], |n| n.as_vec3().to_array());
        let normals = normals.unwrap_or_default().into_iter().map(unit).collect::<Vec<_>>();
        let uvs = uvs.unwrap_or_default().into_iter().map(|uv| placement.apply(uv)).collect::<Vec<_>>();
        let outside = |uv: &[f32; 2]| !uv.iter().all(|t| (-1e-3..=1.001).contains(t));
        if placement.ends && uvs.iter().any(outside) {
            let name = self.file.path.display();
            warnings.push(format!(
                "{name}: textures repeat beyond their edges, also where the file has them end or mirrored"
            ));
        }
        let corner = |triangle: &[u32; 3]| {
            let at = triangle.map(|vertex| vertex as usize);
            CornerDesc {
                normals: at.map(|vertex| normals.get(vertex).copied().unwrap_or_default()),
                uvs: at.map(|vertex| uvs.get(vertex).copied().unwrap_or_default()),
            }
        };
        Ok(triangles.iter().map(corner).collect())
    }
}

/// The triangles that `indices` stand for (glTF 2.0, section 3.7.2.1); an incomplete last one is none.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        // Every second triangle of a strip runs the other way; joints between strips have no area.
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            let is_joint = |t: &[u32; 3]| t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
            indices.windows(3).enumerate().map(turned).filter(|t| !is_joint(t)).collect()
        }
        Mode::TriangleFan => match indices.split_first() {
            Some((&first, rest)) => rest.windows(2).map(|pair| [first, pair[0], pair[1]]).collect(),
            None => Vec::new(),
        },
        _ => indices.as_chunks().0.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_strips_and_fans_keep_their_winding() {
        let indices = [0, 1, 2, 3, 4];
        assert_eq!(triangles(Mode::Triangles, &indices), [[0, 1, 2]]);
        assert_eq!(triangles(Mode::TriangleStrip, &indices), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 2, 3, 3, 4, 5]), [[0, 1, 2], [4, 3, 5]]);
        assert_eq!(triangles(Mode::TriangleFan, &indices), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert!(triangles(Mode::TriangleFan, &[]).is_empty() && triangles(Mode::TriangleStrip, &[1, 2]).is_empty());
    }
}
