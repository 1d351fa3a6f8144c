//! One OBJ file and the MTL files it names into triangles in file order; numbers of vertices and materials through tobj.
//!
//! Vertices are read in f64, placed in f64 and rounded to f32 once, in world space: coordinates of a country's grid have more
//! digits than f32, and a translation can bring back only what reading has kept.

use crate::error::{Error, Result};
use crate::files::read;
use crate::import::obj::choice;
use crate::import::obj::corners::Corner;
use crate::import::obj::encoding::decode;
use crate::import::obj::libraries::{Libraries, ObjMaterial};
use crate::import::obj::text::{ObjText, find_bad_number, line_of_normal, read_text};
use crate::import::obj::triangulate::{Cut, newell_normal, triangulate};
use crate::scene::desc::{CornerDesc, TriangleDesc};
use crate::scene::transform::Similarity;
use glam::{DVec3, Vec3};
use std::mem::take;
use std::path::{Path, PathBuf};

/// An OBJ file, read and cut into triangles: it can stand in many places.
#[derive(Debug, Default)]
pub struct ObjFile {
    path: PathBuf,
    text: String,
    shape: Shape,
    /// The materials the triangles name, in order of first use.
    pub materials: Vec<ObjMaterial>,
}

/// Triangles as a file has them, and what of the file they use.
#[derive(Debug, Default)]
struct Shape {
    /// In order of first use, anew in each run of one material.
    positions: Vec<[f64; 3]>,
    /// In order of first use; zero where the file's are not finite.
    normals: Vec<[f32; 3]>,
    /// In file order, n - 2 per polygon.
    triangles: Vec<TriangleDesc>,
    /// Empty if no corner has anything.
    corners: Vec<FileCorners>,
}

/// What the corners of a triangle name.
#[derive(Clone, Copy, Debug)]
struct FileCorners {
    /// Places in [`Shape::normals`], from 1; 0: none.
    normals: [u32; 3],
    uvs: [[f32; 2]; 3],
}

/// An OBJ file, placed.
#[derive(Debug, Default)]
pub struct ObjMesh {
    /// Vertices in world space, in order of first use, anew in each run of one material; infinite where the transform leaves
    /// the range of f32.
    pub positions: Vec<[f32; 3]>,
    /// Triangles in file order, n - 2 per polygon; their materials are places in [`ObjFile::materials`].
    pub triangles: Vec<TriangleDesc>,
    /// What the triangles' corners carry, in world space; empty if none has anything.
    pub corners: Vec<CornerDesc>,
}

impl ObjFile {
    /// Reads the OBJ file `path` and the MTL files beside it. What a reader should know is appended to `warnings`.
    pub fn read(path: &Path, libraries: &mut Libraries, warnings: &mut Vec<String>) -> Result<ObjFile> {
        let text = decode(path, read::bytes(path)?)?;
        let mut obj = read_text(path, &text)?;
        let not_numbers = |e| match find_bad_number(&text, |x| x.is_finite()) {
            Some((line, message)) => Error::parse(path, Some(line), message),
            None => Error::parse(path, None, format!("not an OBJ file: {e}")),
        };
        let positions = take(&mut obj.positions).read().map_err(not_numbers)?;
        let normals = take(&mut obj.normals).read().map_err(not_numbers)?;
        let normals: Vec<[f32; 3]> = normals.into_iter().map(|n| n.map(|x| x as f32)).collect();
        let file = path.display();
        if obj.small_faces > 0 {
            let (count, line) = (obj.small_faces, obj.first_small_face);
            warnings.push(format!("{file}:{line}: {count} face(s) with fewer than three corners were left out"));
        }
        if obj.coloured {
            warnings.push(format!("{file}: colours of vertices are not read: materials are as its MTL says"));
        }
        let has_no_direction = |n: &&[f32; 3]| n.iter().any(|x| !x.is_finite()) || **n == [0.0; 3];
        if let Some(first) = normals.iter().position(|n| has_no_direction(&n)) {
            let (count, line) = (normals.iter().filter(has_no_direction).count(), line_of_normal(&text, first));
            warnings.push(format!(
                "{file}:{line}: {count} vertex normal(s) are zero or not finite: geometric normals instead"
            ));
        }
        let named = libraries.named_by(path, &obj, warnings)?;
        let materials = choice::materials(path, &obj, &named, warnings);
        let mut faces = Faces::new(&obj, &positions, &normals);
        faces.add_all();
        let Faces { mut shape, crossing, .. } = faces;
        if crossing > 0 {
            warnings.push(format!("{file}: {crossing} polygon(s) cross themselves; they are covered only roughly"));
        }
        let materials = keep_used(&mut shape.triangles, &materials);
        Ok(ObjFile { path: path.to_owned(), shape, materials, text })
    }

    /// The mesh placed by `transform`; `last`: it will not be placed again, which spares a copy.
    pub fn place(&mut self, transform: &Similarity, last: bool) -> Result<ObjMesh> {
        let Shape { positions, normals, triangles, corners } = &mut self.shape;
        let positions: Vec<[f32; 3]> = positions.iter().map(|&p| transform.place(p)).collect();
        // What only the transform moves out of range is not this file's fault.
        let fits = |x: f64| if *transform == Similarity::default() { (x as f32).is_finite() } else { x.is_finite() };
        if positions.iter().flatten().any(|x| !x.is_finite())
            && let Some((line, message)) = find_bad_number(&self.text, fits)
        {
            return Err(Error::parse(&self.path, Some(line), message));
        }
        let normals: Vec<[f32; 3]> = normals.iter().map(|&n| transform.apply_to_normal(n)).collect();
        let normal = |place: u32| normals.get((place as usize).wrapping_sub(1)).copied().unwrap_or_default();
        let placed = |c: &FileCorners| CornerDesc { normals: c.normals.map(normal), uvs: c.uvs };
        let corners = corners.iter().map(placed).collect();
        let mut triangles = if last { take(triangles) } else { triangles.clone() };
        if transform.mirrors() {
            triangles.iter_mut().for_each(|triangle| triangle.flipped = !triangle.flipped);
        }
        Ok(ObjMesh { positions, triangles, corners })
    }
}

/// The materials that triangles have, renumbered in order of first use.
fn keep_used(triangles: &mut [TriangleDesc], materials: &[ObjMaterial]) -> Vec<ObjMaterial> {
    let mut place = vec![None; materials.len()];
    let mut used = Vec::new();
    for triangle in triangles {
        let old = triangle.material as usize;
        triangle.material = *place[old].get_or_insert_with(|| {
            used.push(materials[old].clone());
            used.len() as u32 - 1
        });
    }
    used
}

/// Faces becoming triangles.
struct Faces<'a> {
    obj: &'a ObjText,
    positions: &'a [[f64; 3]],
    /// The normals as the file has them.
    normals: &'a [[f32; 3]],
    shape: Shape,
    /// By vertex of the file, one more than its place in the shape; of the run at hand if it is above `run_start`.
    places: Vec<u32>,
    run_start: u32,
    /// By normal of the file, one more than its place in the shape, or 0.
    normal_places: Vec<u32>,
    /// Polygons that cross themselves.
    crossing: usize,
    /// The face at hand: its corners, their places in the shape, its triangles.
    polygon: Vec<DVec3>,
    vertices: Vec<u32>,
    cut: Vec<[u32; 3]>,
}

impl<'a> Faces<'a> {
    fn new(obj: &'a ObjText, positions: &'a [[f64; 3]], normals: &'a [[f32; 3]]) -> Self {
        let triangles = obj.corners.len() - 2 * obj.sizes.len();
        let carrying = if obj.coordinates.is_empty() && normals.is_empty() { 0 } else { triangles };
        let shape = Shape {
            triangles: Vec::with_capacity(triangles),
            corners: Vec::with_capacity(carrying),
            ..Shape::default()
        };
        Faces {
            obj,
            positions,
            normals,
            shape,
            places: vec![0; positions.len()],
            run_start: 0,
            normal_places: vec![0; normals.len()],
            crossing: 0,
            polygon: Vec::new(),
            vertices: Vec::new(),
            cut: Vec::new(),
        }
    }

    /// Adds all faces, run by run.
    fn add_all(&mut self) {
        let obj = self.obj;
        let (mut corners, mut sizes) = (&obj.corners[..], &obj.sizes[..]);
        let mut carries = false;
        for run in &obj.runs {
            self.run_start = self.shape.positions.len() as u32;
            // Faces before the first `usemtl` have the nameless material, which stands last.
            let material = run.material.unwrap_or(obj.materials.len() as u32);
            let (of_run, later) = sizes.split_at(run.faces);
            for &size in of_run {
                let (face, others) = corners.split_at(size as usize);
                carries |= face.iter().any(|corner| self.carries(corner));
                self.add_face(face, material);
                corners = others;
            }
            sizes = later;
        }
        if !carries {
            (self.shape.corners, self.shape.normals) = (Vec::new(), Vec::new());
        }
    }

    /// The normal of the file that a corner names; zero if it names none or one that is not finite.
    fn normal(&self, vn: u32) -> [f32; 3] {
        let normal = self.normals.get((vn as usize).wrapping_sub(1)).filter(|n| n.iter().all(|x| x.is_finite()));
        normal.copied().unwrap_or_default()
    }

    /// Whether a corner has a normal or texture coordinates to speak of.
    fn carries(&self, &[_, vt, vn]: &Corner) -> bool {
        self.normal(vn) != [0.0; 3] || self.obj.uv(vt) != [0.0; 2]
    }

    fn add_face(&mut self, corners: &[Corner], material: u32) {
        self.polygon.clear();
        self.polygon.extend(corners.iter().map(|corner| DVec3::from(self.positions[corner[0] as usize - 1])));
        self.vertices.clear();
        for corner in corners {
            let vertex = self.place(corner[0] as usize - 1);
            self.vertices.push(vertex);
        }
        let flipped = self.opposes_winding(corners);
        self.cut.clear();
        if triangulate(&self.polygon, &mut self.cut) == Cut::Crossing {
            self.crossing += 1;
        }
        let vertices = &self.vertices;
        let triangle = |cut: &[u32; 3]| TriangleDesc { vertices: cut.map(|i| vertices[i as usize]), material, flipped };
        self.shape.triangles.extend(self.cut.iter().map(triangle));
        if self.has_corners() {
            for place in 0..self.cut.len() {
                let named = self.cut[place].map(|i| corners[i as usize]);
                let normals = named.map(|[_, _, vn]| self.place_normal(vn));
                let uvs = named.map(|[_, vt, _]| self.obj.uv(vt));
                self.shape.corners.push(FileCorners { normals, uvs });
            }
        }
    }

    fn has_corners(&self) -> bool {
        !self.obj.coordinates.is_empty() || !self.normals.is_empty()
    }

    /// The place of a vertex in the shape, where it is put if the run at hand has not had it.
    fn place(&mut self, vertex: usize) -> u32 {
        if self.places[vertex] <= self.run_start {
            self.shape.positions.push(self.positions[vertex]);
            self.places[vertex] = self.shape.positions.len() as u32;
        }
        self.places[vertex] - 1
    }

    /// One more than the place of a normal in the shape, where it is put if it is new; 0: there is none.
    fn place_normal(&mut self, vn: u32) -> u32 {
        let Some(&known) = self.normal_places.get((vn as usize).wrapping_sub(1)) else { return 0 };
        if known > 0 {
            return known;
        }
        self.shape.normals.push(self.normal(vn));
        let place = self.shape.normals.len() as u32;
        self.normal_places[vn as usize - 1] = place;
        place
    }

    /// Where normals oppose the winding, normals decide which side is the front.
    fn opposes_winding(&self, corners: &[Corner]) -> bool {
        let normal = |corner: &Corner| self.normals.get((corner[2] as usize).wrapping_sub(1));
        let in_file = |corner: &Corner| normal(corner).map_or(DVec3::ZERO, |n| Vec3::from(*n).as_dvec3());
        let average: DVec3 = corners.iter().map(in_file).sum();
        !self.normals.is_empty() && average.dot(newell_normal(&self.polygon)) < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::fmt::Write;

    /// A thousand faces in every form that indices come in, against arrays that the loop which writes them keeps.
    #[test]
    fn a_thousand_faces_of_every_form_are_what_they_say() {
        let mut text = String::from("mtllib none.mtl\nusemtl unused\n");
        let mut expected = ObjMesh::default();
        let mut of_run = HashMap::new();
        let (mut vertices, mut normals) = (Vec::new(), Vec::new());
        let materials = ["a", "b", "a", "c"];
        for face in 0..1000 {
            let (number, below) = (vertices.len(), face % 10 == 7);
            // Four vertices, texture coordinates and normals of its own; in some faces they stand below it.
            let mut block = String::new();
            for i in 0..4 {
                let (x, y) = ([0.0, 1.0, 1.0, 0.0][i], [0.0, 0.0, 1.0, 1.0][i]);
                let (vertex, normal) = ([x, y, face as f32 * 0.1], [x, y, if face % 3 == 0 { -1.5 } else { 1.5 }]);
                let uv = [face as f32, i as f32 / 3.0];
                let _ = writeln!(
                    block,
                    "v {} {} {}\nvt {} {} 9\nvn {} {} {} # up",
                    vertex[0], vertex[1], vertex[2], uv[0], uv[1], normal[0], normal[1], normal[2]
                );
                vertices.push(vertex);
                normals.push((normal, uv));
            }
            if face % 100 == 0 {
                let material = materials[face / 100 % 4];
                let _ = writeln!(text, "usemtl {material}");
                of_run.clear();
            }
            let (corners, form) = (3 + face % 2, face % 6);
            let mut line = String::from("f");
            for i in 0..corners {
                let (place, back) = (number + i + 1, format!("-{}", 4 - i));
                let place = place.to_string();
                let index = if form == 5 && !below { &back } else { &place };
                let _ = match form {
                    0 => write!(line, " {index}"),
                    1 => write!(line, "\t{index}/{index}"),
                    2 => write!(line, " {index}//{index} "),
                    3 => write!(line, " \\\n {index}/{index}/{index}"),
                    4 => write!(line, " +{index}/0{index}/{index}"),
                    _ => write!(line, " {index}/{index}/{index}"),
                };
            }
            line += if face % 4 == 0 { " # f 1 2 3\r\n" } else { "\n" };
            text += &if below { line + &block } else { block + &line };
            // A triangle leaves its fourth vertex unused: the mesh does not have it.
            let places: Vec<u32> = (0..corners)
                .map(|i| {
                    *of_run.entry(number + i).or_insert_with(|| {
                        expected.positions.push(vertices[number + i]);
                        expected.positions.len() as u32 - 1
                    })
                })
                .collect();
            let (has_uv, has_normal) = (!matches!(form, 0 | 2), !matches!(form, 0 | 1));
            for cut in [[0, 1, 2], [0, 2, 3]].iter().take(corners - 2) {
                let material = [0, 1, 0, 2][face / 100 % 4];
                let flipped = has_normal && face % 3 == 0;
                expected.triangles.push(TriangleDesc { vertices: cut.map(|i: usize| places[i]), material, flipped });
                expected.corners.push(CornerDesc {
                    normals: cut.map(|i| if has_normal { normals[number + i].0 } else { [0.0; 3] }),
                    uvs: cut.map(|i| if has_uv { normals[number + i].1 } else { [0.0; 2] }),
                });
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        std::fs::write(&path, text).unwrap();
        let mut warnings = Vec::new();
        let mut file = ObjFile::read(&path, &mut Libraries::default(), &mut warnings).unwrap();
        let mesh = file.place(&Similarity::default(), false).unwrap();
        let unit = |n: [f32; 3]| Similarity::default().apply_to_normal(n);
        expected.corners.iter_mut().for_each(|corner| corner.normals = corner.normals.map(unit));
        assert_eq!(mesh.positions, expected.positions);
        assert_eq!(mesh.triangles, expected.triangles);
        assert_eq!(mesh.corners, expected.corners);
        let names: Vec<&str> = file.materials.iter().map(|m| m.material.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c"], "only what triangles have");
        assert_eq!(warnings.len(), 1, "{warnings:?}");
    }

    /// A file that is placed again and again is placed each time as if it were read anew.
    #[test]
    fn a_file_can_stand_in_many_places() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        let text = "v 0.1 0 0\nv 1 0.2 0\nv 0 1 0.3\nv 1 1 1\nvt 0.5 1\nvn 0 0 -2\nvn 0.3 0 0.7\nvn nan 0 0\nusemtl a\n\
                    f 1/1/2 2/1/2 3//3\nusemtl b\nf 1//1 2//1 4\n";
        std::fs::write(&path, text).unwrap();
        let read = || ObjFile::read(&path, &mut Libraries::default(), &mut Vec::new()).unwrap();
        let mut file = read();
        let moved = Similarity { scale: 0.7, translate: [3.3, 0.1, 5e6], ..Similarity::default() };
        let mirrored = Similarity { scale: -3.0, ..Similarity::default() };
        for (transform, last) in [(moved, false), (mirrored, false), (Similarity::default(), false), (moved, true)] {
            let (again, anew) = (file.place(&transform, last).unwrap(), read().place(&transform, true).unwrap());
            assert_eq!((&again.positions, &again.corners), (&anew.positions, &anew.corners));
            assert_eq!(again.triangles, anew.triangles);
            assert_eq!(
                again.triangles.iter().map(|t| t.flipped).collect::<Vec<_>>(),
                match transform.mirrors() {
                    true => [true, false],
                    false => [false, true],
                }
            );
            assert_eq!(again.positions[1], transform.place([1.0, 0.2, 0.0]));
            assert_eq!(again.corners[0].normals[0], transform.apply_to_normal([0.3, 0.0, 0.7]));
        }
    }
}
