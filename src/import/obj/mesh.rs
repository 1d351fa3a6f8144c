//! One OBJ file and the MTL files it names, through tobj, into triangles in file order.
//!
//! Vertices are read in f64, placed in f64 and rounded to f32 once, in world space: coordinates of a country's grid have more
//! digits than f32, and a translation can bring back only what reading has kept.

use crate::error::{Error, Result};
use crate::import::obj::mtl;
use crate::import::obj::mtl::MtlMaterial;
use crate::import::obj::text::{CleanObj, clean_obj, find_bad_number};
use crate::import::obj::triangulate::{Cut, newell_normal, triangulate};
use crate::scene::transform::Similarity;
use glam::DVec3;
use std::collections::HashMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// What a face without `usemtl` is made of, by name.
pub const NO_MATERIAL: &str = "default";

/// An OBJ file, read and placed.
#[derive(Debug, Default)]
pub struct ObjMesh {
    /// Vertices in world space; infinite where the transform leaves the range of f32.
    pub positions: Vec<[f32; 3]>,
    /// Triangles in file order, n - 2 per polygon.
    pub triangles: Vec<ObjTriangle>,
    /// The materials the triangles name, in order of first use.
    pub materials: Vec<ObjMaterial>,
}

/// A triangle of an [`ObjMesh`].
#[derive(Clone, Copy, Debug)]
pub struct ObjTriangle {
    /// Places in [`ObjMesh::positions`].
    pub vertices: [u32; 3],
    /// Place in [`ObjMesh::materials`].
    pub material: u32,
    /// The polygon's normals oppose its winding.
    pub flipped: bool,
    /// Normals of the corners as the file has them; zero: none.
    pub normals: [[f32; 3]; 3],
    /// Texture coordinates of the corners; 0 where the file has none.
    pub uvs: [[f32; 2]; 3],
}

/// A material an OBJ names, and whether an MTL defines it.
#[derive(Clone, Debug)]
pub struct ObjMaterial {
    /// What it is: grey where no MTL says.
    pub material: MtlMaterial,
    /// An MTL defines it, or it has no name to define.
    pub defined: bool,
}

/// Reads the OBJ file `path` and the MTL files beside it, and places its vertices by `transform`; normals stay as the file
/// has them. What a reader should know is appended to `warnings`.
pub fn load_obj(path: &Path, transform: &Similarity, warnings: &mut Vec<String>) -> Result<ObjMesh> {
    let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    let text = String::from_utf8_lossy(&bytes);
    let text = text.trim_start_matches('\u{feff}');
    let clean = clean_obj(path, text)?;
    if clean.small_faces > 0 {
        let (count, line, file) = (clean.small_faces, clean.first_small_face, path.display());
        warnings.push(format!("{file}:{line}: {count} face(s) with fewer than three corners were left out"));
    }
    if clean.bad_normals > 0 {
        let (count, line, file) = (clean.bad_normals, clean.first_bad_normal, path.display());
        warnings
            .push(format!("{file}:{line}: {count} vertex normal(s) are zero or not finite: geometric normals instead"));
    }
    let models = run_tobj(&clean).map_err(|e| match find_bad_number(text, |x| x.is_finite()) {
        Some((line, message)) => Error::parse(path, Some(line), message),
        None => Error::parse(path, None, format!("not an OBJ file: {e}")),
    })?;
    let mut mesh = ObjMesh { materials: load_materials(path, &clean, warnings)?, ..ObjMesh::default() };
    let mut builder = FaceBuilder { mesh: &mut mesh, transform, crossing: 0, corners: Vec::new(), cut: Vec::new() };
    for model in models {
        builder.add_model(&model.mesh);
    }
    if builder.crossing > 0 {
        let count = builder.crossing;
        warnings
            .push(format!("{}: {count} polygon(s) cross themselves; they are covered only roughly", path.display()));
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

/// tobj on the cleaned text: each material its own model, polygons whole.
fn run_tobj(clean: &CleanObj) -> std::result::Result<Vec<tobj::Model>, tobj::LoadError> {
    let options = tobj::LoadOptions { single_index: false, triangulate: false, ..Default::default() };
    let mut reader = clean.vertices.as_bytes().chain(clean.faces.as_bytes());
    let numbered = || (0..clean.materials.len()).map(|slot| (slot.to_string(), slot)).collect::<HashMap<_, _>>();
    let library =
        |_: &Path| Ok((vec![tobj::Material::default(); clean.materials.len()], numbered().into_iter().collect()));
    tobj::load_obj_buf(&mut reader, &options, library).map(|(models, _)| models)
}

struct FaceBuilder<'a> {
    mesh: &'a mut ObjMesh,
    transform: &'a Similarity,
    crossing: usize,
    corners: Vec<DVec3>,
    cut: Vec<[u32; 3]>,
}

impl FaceBuilder<'_> {
    fn add_model(&mut self, model: &tobj::Mesh) {
        let base = self.mesh.positions.len() as u32;
        let placed = model.positions.chunks_exact(3).map(|p| self.transform.place([p[0], p[1], p[2]]));
        self.mesh.positions.extend(placed);
        // Faces before the first `usemtl` have the nameless material, which stands last.
        let material = model.material_id.unwrap_or(self.mesh.materials.len() - 1) as u32;
        let mut start = 0;
        let triangles_only = model.face_arities.is_empty();
        let faces = if triangles_only { model.indices.len() / 3 } else { model.face_arities.len() };
        for face in 0..faces {
            let arity = if triangles_only { 3 } else { model.face_arities[face] as usize };
            let range = start..start + arity;
            start = range.end;
            let vertices = (&model.indices[range.clone()], &model.positions[..]);
            let normals = model.normal_indices.get(range.clone()).unwrap_or(&[]);
            let coordinates = (model.texcoord_indices.get(range).unwrap_or(&[]), &model.texcoords[..]);
            self.add_face(vertices, (normals, &model.normals), coordinates, base, material);
        }
    }

    fn add_face(
        &mut self,
        (vertices, vertex_table): (&[u32], &[f64]),
        (normals, normal_table): (&[u32], &[f64]),
        (coordinates, coordinate_table): (&[u32], &[f64]),
        base: u32,
        material: u32,
    ) {
        self.corners.clear();
        self.corners.extend(vertices.iter().map(|&v| DVec3::from_slice(&vertex_table[3 * v as usize..])));
        // Where normals oppose the winding, normals decide which side is the front.
        let in_f32 = |n: u32| DVec3::from_slice(&normal_table[3 * n as usize..]).as_vec3();
        let normal = |corner: usize| match normals.get(corner).map(|&n| in_f32(n)) {
            Some(n) if n.is_finite() => n.to_array(),
            _ => [0.0; 3],
        };
        let average: DVec3 = normals.iter().map(|&n| in_f32(n).as_dvec3()).sum();
        let flipped = !normals.is_empty() && average.dot(newell_normal(&self.corners)) < 0.0;
        let uv = |corner: usize| match coordinates.get(corner).and_then(|&t| coordinate_table.get(2 * t as usize..)) {
            Some(&[u, v, ..]) => [u as f32, v as f32],
            _ => [0.0; 2],
        };
        self.cut.clear();
        if triangulate(&self.corners, &mut self.cut) == Cut::Crossing {
            self.crossing += 1;
        }
        self.mesh.triangles.extend(self.cut.iter().map(|corner| ObjTriangle {
            vertices: corner.map(|i| base + vertices[i as usize]),
            material,
            flipped,
            normals: corner.map(|i| normal(i as usize)),
            uvs: corner.map(|i| uv(i as usize)),
        }));
    }
}

/// The materials of `clean.materials`, then the nameless one.
fn load_materials(obj: &Path, clean: &CleanObj, warnings: &mut Vec<String>) -> Result<Vec<ObjMaterial>> {
    let mut known: HashMap<String, MtlMaterial> = HashMap::new();
    for library in &clean.libraries {
        for (path, bytes) in find_library(obj, library, warnings) {
            let materials = mtl::parse_mtl(&path, &bytes, warnings)?;
            known.extend(materials.into_iter().map(|material| (material.name.clone(), material)));
        }
    }
    let mut materials: Vec<ObjMaterial> = clean
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
    let read = |name: &str| {
        // Exporters on Windows write backslashes.
        let candidates = [name.to_owned(), name.replace('\\', "/")];
        let paths = candidates.map(|name| obj.with_file_name("").join(name));
        paths.into_iter().find_map(|path| std::fs::read(&path).ok().map(|bytes| (path, bytes)))
    };
    if let Some(file) = read(names) {
        return vec![file];
    }
    let mut files = Vec::new();
    for name in split_names(names) {
        match read(&name) {
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
