//! One OBJ file and the MTL files it names into triangles in file order; numbers of vertices and materials through tobj.
//!
//! Vertices are read in f64, placed in f64 and rounded to f32 once, in world space: coordinates of a country's grid have more
//! digits than f32, and a translation can bring back only what reading has kept.

use crate::error::{Error, Result};
use crate::files::read;
use crate::import::obj::corners::Corner;
use crate::import::obj::mtl;
use crate::import::obj::mtl::MtlMaterial;
use crate::import::obj::text::{ObjText, find_bad_number, line_of_normal, read_text};
use crate::import::obj::triangulate::{Cut, newell_normal, triangulate};
use crate::scene::desc::{CornerDesc, TriangleDesc};
use crate::scene::transform::Similarity;
use glam::{DVec3, Vec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::mem::take;
use std::path::{Path, PathBuf};

/// What a face without `usemtl` is made of, by name.
pub const NO_MATERIAL: &str = "default";

/// An OBJ file, read and placed.
#[derive(Debug, Default)]
pub struct ObjMesh {
    /// Vertices in world space, in order of first use, anew in each run of one material; infinite where the transform leaves
    /// the range of f32.
    pub positions: Vec<[f32; 3]>,
    /// Triangles in file order, n - 2 per polygon; their materials are places in [`ObjMesh::materials`].
    pub triangles: Vec<TriangleDesc>,
    /// What the triangles' corners carry, in world space; empty if none has anything.
    pub corners: Vec<CornerDesc>,
    /// The materials the triangles name, in order of first use.
    pub materials: Vec<ObjMaterial>,
}

/// A material an OBJ names, and whether an MTL defines it.
#[derive(Clone, Debug)]
pub struct ObjMaterial {
    /// What it is: grey where no MTL says.
    pub material: MtlMaterial,
    /// An MTL defines it, or it has no name to define.
    pub defined: bool,
}

/// Reads the OBJ file `path` and the MTL files beside it, and places it by `transform`. What a reader should know is appended
/// to `warnings`.
pub fn load_obj(path: &Path, transform: &Similarity, warnings: &mut Vec<String>) -> Result<ObjMesh> {
    let bytes = read::bytes(path)?;
    // Text is checked much faster than it is mended: that saves 35 of 400 ms of CPU time for 50 MB.
    let text = std::str::from_utf8(&bytes).map_or_else(|_| String::from_utf8_lossy(&bytes), Cow::Borrowed);
    let text = text.trim_start_matches('\u{feff}');
    let mut obj = read_text(path, text)?;
    let not_numbers = |e| match find_bad_number(text, |x| x.is_finite()) {
        Some((line, message)) => Error::parse(path, Some(line), message),
        None => Error::parse(path, None, format!("not an OBJ file: {e}")),
    };
    let positions = take(&mut obj.positions).read().map_err(not_numbers)?;
    let normals = take(&mut obj.normals).read().map_err(not_numbers)?;
    let normals: Vec<[f32; 3]> = normals.into_iter().map(|n| n.map(|x| x as f32)).collect();
    if obj.small_faces > 0 {
        let (count, line, file) = (obj.small_faces, obj.first_small_face, path.display());
        warnings.push(format!("{file}:{line}: {count} face(s) with fewer than three corners were left out"));
    }
    let has_no_direction = |n: &&[f32; 3]| n.iter().any(|x| !x.is_finite()) || **n == [0.0; 3];
    if let Some(first) = normals.iter().position(|n| has_no_direction(&n)) {
        let (count, line) = (normals.iter().filter(has_no_direction).count(), line_of_normal(text, first));
        let file = path.display();
        warnings
            .push(format!("{file}:{line}: {count} vertex normal(s) are zero or not finite: geometric normals instead"));
    }
    let materials = load_materials(path, &obj, warnings)?;
    let mut faces = Faces::new(&obj, &positions, &normals, transform);
    faces.add_all();
    let Faces { mut mesh, crossing, .. } = faces;
    mesh.materials = materials;
    if crossing > 0 {
        let file = path.display();
        warnings.push(format!("{file}: {crossing} polygon(s) cross themselves; they are covered only roughly"));
    }
    // What only the transform moves out of range is not this file's fault.
    let fits = |x: f64| if *transform == Similarity::default() { (x as f32).is_finite() } else { x.is_finite() };
    if mesh.positions.iter().flatten().any(|x| !x.is_finite())
        && let Some((line, message)) = find_bad_number(text, fits)
    {
        return Err(Error::parse(path, Some(line), message));
    }
    Ok(mesh)
}

/// Faces becoming triangles.
struct Faces<'a> {
    obj: &'a ObjText,
    positions: &'a [[f64; 3]],
    transform: &'a Similarity,
    /// The normals as the file has them.
    normals: &'a [[f32; 3]],
    /// In world space; zero where the file's are not finite.
    world_normals: Vec<[f32; 3]>,
    mesh: ObjMesh,
    /// By vertex of the file, one more than its place in the mesh; of the run at hand if it is above `run_start`.
    places: Vec<u32>,
    run_start: u32,
    /// Polygons that cross themselves.
    crossing: usize,
    /// The face at hand: its corners, their places in the mesh, its triangles.
    polygon: Vec<DVec3>,
    vertices: Vec<u32>,
    cut: Vec<[u32; 3]>,
}

impl<'a> Faces<'a> {
    fn new(obj: &'a ObjText, positions: &'a [[f64; 3]], normals: &'a [[f32; 3]], transform: &'a Similarity) -> Self {
        let world = |n: &[f32; 3]| match n.iter().all(|x| x.is_finite()) {
            true => transform.apply_to_normal(*n),
            false => [0.0; 3],
        };
        let triangles = obj.corners.len() - 2 * obj.sizes.len();
        let carrying = if obj.coordinates.is_empty() && normals.is_empty() { 0 } else { triangles };
        let mesh = ObjMesh {
            triangles: Vec::with_capacity(triangles),
            corners: Vec::with_capacity(carrying),
            ..ObjMesh::default()
        };
        Faces {
            obj,
            positions,
            transform,
            normals,
            world_normals: normals.iter().map(world).collect(),
            mesh,
            places: vec![0; positions.len()],
            run_start: 0,
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
            self.run_start = self.mesh.positions.len() as u32;
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
            self.mesh.corners = Vec::new();
        }
    }

    /// Whether a corner has a normal or texture coordinates to speak of.
    fn carries(&self, &[_, vt, vn]: &Corner) -> bool {
        let normal = self.normals.get((vn as usize).wrapping_sub(1)).filter(|n| n.iter().all(|x| x.is_finite()));
        normal.is_some_and(|n| *n != [0.0; 3]) || self.obj.uv(vt) != [0.0; 2]
    }

    fn add_face(&mut self, corners: &[Corner], material: u32) {
        self.polygon.clear();
        self.polygon.extend(corners.iter().map(|corner| DVec3::from(self.positions[corner[0] as usize - 1])));
        self.vertices.clear();
        for corner in corners {
            let vertex = self.place(corner[0] as usize - 1);
            self.vertices.push(vertex);
        }
        let flipped = self.opposes_winding(corners) != self.transform.mirrors();
        self.cut.clear();
        if triangulate(&self.polygon, &mut self.cut) == Cut::Crossing {
            self.crossing += 1;
        }
        let vertices = &self.vertices;
        let triangle = |cut: &[u32; 3]| TriangleDesc { vertices: cut.map(|i| vertices[i as usize]), material, flipped };
        self.mesh.triangles.extend(self.cut.iter().map(triangle));
        if self.has_corners() {
            let obj = self.obj;
            let normal = |vn: u32| self.world_normals.get((vn as usize).wrapping_sub(1)).copied().unwrap_or_default();
            let corner = |cut: &[u32; 3]| CornerDesc {
                normals: cut.map(|i| normal(corners[i as usize][2])),
                uvs: cut.map(|i| obj.uv(corners[i as usize][1])),
            };
            self.mesh.corners.extend(self.cut.iter().map(corner));
        }
    }

    fn has_corners(&self) -> bool {
        !self.obj.coordinates.is_empty() || !self.normals.is_empty()
    }

    /// The place of a vertex in the mesh, where it is put if the run at hand has not had it.
    fn place(&mut self, vertex: usize) -> u32 {
        if self.places[vertex] <= self.run_start {
            self.mesh.positions.push(self.transform.place(self.positions[vertex]));
            self.places[vertex] = self.mesh.positions.len() as u32;
        }
        self.places[vertex] - 1
    }

    /// Where normals oppose the winding, normals decide which side is the front.
    fn opposes_winding(&self, corners: &[Corner]) -> bool {
        let normal = |corner: &Corner| self.normals.get((corner[2] as usize).wrapping_sub(1));
        let in_file = |corner: &Corner| normal(corner).map_or(DVec3::ZERO, |n| Vec3::from(*n).as_dvec3());
        let average: DVec3 = corners.iter().map(in_file).sum();
        !self.normals.is_empty() && average.dot(newell_normal(&self.polygon)) < 0.0
    }
}

/// The materials of `text.materials`, then the nameless one.
fn load_materials(obj: &Path, text: &ObjText, warnings: &mut Vec<String>) -> Result<Vec<ObjMaterial>> {
    let mut known: HashMap<String, MtlMaterial> = HashMap::new();
    for library in &text.libraries {
        for (path, bytes) in find_library(obj, library, warnings) {
            let materials = mtl::parse_mtl(&path, &bytes, warnings)?;
            known.extend(materials.into_iter().map(|material| (material.name.clone(), material)));
        }
    }
    let mut materials: Vec<ObjMaterial> = text
        .materials
        .iter()
        .map(|name| match (known.get(name), name.is_empty()) {
            (Some(material), _) => ObjMaterial { material: material.clone(), defined: true },
            (None, nameless) => {
                let name = if nameless { NO_MATERIAL } else { name };
                ObjMaterial { material: MtlMaterial::grey(name), defined: nameless }
            }
        })
        .collect();
    materials.push(ObjMaterial { material: MtlMaterial::grey(NO_MATERIAL), defined: true });
    Ok(materials)
}

/// The files that stand behind one `mtllib`: the whole rest of the line as one name, or else each of its words; a blank
/// behind a backslash belongs to its word.
fn find_library(obj: &Path, names: &str, warnings: &mut Vec<String>) -> Vec<(PathBuf, Vec<u8>)> {
    let find = |name: &str| {
        // Exporters on Windows write backslashes.
        let candidates = [name.to_owned(), name.replace('\\', "/")];
        let paths = candidates.map(|name| obj.with_file_name("").join(name));
        paths.into_iter().find_map(|path| read::bytes(&path).ok().map(|bytes| (path, bytes)))
    };
    if let Some(file) = find(names) {
        return vec![file];
    }
    let mut files = Vec::new();
    for name in split_names(names) {
        match find(&name) {
            Some(file) => files.push(file),
            None => warnings.push(format!("{}: cannot read its material file `{name}`: grey instead", obj.display())),
        }
    }
    files
}

fn split_names(names: &str) -> Vec<String> {
    let mut split = vec![String::new()];
    let mut letters = names.chars().peekable();
    while let Some(letter) = letters.next() {
        let last = split.len() - 1;
        match letter {
            '\\' if letters.peek() == Some(&' ') => split[last].extend(letters.next()),
            _ if letter.is_whitespace() => split.push(String::new()),
            _ => split[last].push(letter),
        }
    }
    split.retain(|name| !name.is_empty());
    split
}

#[cfg(test)]
mod tests {
    use super::*;
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
                let material = [0, 1, 0, 2][face / 100 % 4] + 1;
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
        let mesh = load_obj(&path, &Similarity::default(), &mut warnings).unwrap();
        let unit = |n: [f32; 3]| Similarity::default().apply_to_normal(n);
        expected.corners.iter_mut().for_each(|corner| corner.normals = corner.normals.map(unit));
        assert_eq!(mesh.positions, expected.positions);
        assert_eq!(mesh.triangles, expected.triangles);
        assert_eq!(mesh.corners, expected.corners);
        let names: Vec<&str> = mesh.materials.iter().map(|m| m.material.name.as_str()).collect();
        assert_eq!(names, ["unused", "a", "b", "c", NO_MATERIAL]);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
    }
}
