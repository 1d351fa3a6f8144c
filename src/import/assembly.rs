//! From a path to a [`SceneDesc`]: `.toml`, bare `.obj` or `builtin:NAME`.

use crate::error::{Error, Result};
use crate::files::read;
use crate::import::environment::load_map;
use crate::import::framing::{corners, frame};
#[cfg(feature = "gltf")]
use crate::import::gltf;
use crate::import::lamps::add_lights;
use crate::import::obj::libraries::{Libraries, ObjMaterial};
use crate::import::obj::mesh::{ObjFile, ObjMesh};
use crate::import::obj::mtl::{MtlKind, MtlMaterial};
use crate::import::obj::names;
use crate::import::pictures::Numbers;
use crate::import::toml::lights::EnvironmentEntry;
use crate::import::toml::parse;
use crate::import::toml::parse::{Kind, MaterialEntry, MeshEntry, SceneFile};
use crate::nearest::nearest;
use crate::scene::builtin;
use crate::scene::camera::CameraPath;
use crate::scene::desc::{
    CameraDesc, EnvironmentDesc, MapDesc, MaterialDesc, MeshDesc, NamedCamera, SceneDesc, TriangleDesc,
};
use crate::scene::transform::{Similarity, Transform};
use crate::scene::validate;
use crate::scene::validate::is_degenerate;
use crate::scene::warnings::{MOST_LETTERS, condense, shortened};
use std::collections::{HashMap, HashSet};
use std::mem::take;
use std::path::Path;
use std::rc::Rc;

/// How the warnings begin that there is no light.
pub const NO_LIGHT: &str = "nothing emits light";

impl SceneDesc {
    /// Loads a TOML scene file, a bare OBJ, a glTF scene (feature `gltf`), or a scene made in code (`builtin:NAME`).
    pub fn load(path: impl AsRef<Path>) -> Result<SceneDesc> {
        let path = path.as_ref();
        if let Some(name) = path.to_str().and_then(|text| text.strip_prefix("builtin:")) {
            return builtin::build(name);
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match extension.as_str() {
            "toml" => load_toml(path),
            "obj" => SceneDesc::from_obj(path),
            "gltf" | "glb" => load_gltf(path),
            _ => {
                let why = "not a scene: octray reads .toml, .obj, .gltf and .glb files and builtin:NAME";
                Err(Error::parse(path, None, why))
            }
        }
    }

    /// Loads an OBJ by itself: a camera that looks along -z with the whole box in view and, if nothing emits, a
    /// constant white environment.
    pub fn from_obj(path: impl AsRef<Path>) -> Result<SceneDesc> {
        let path = path.as_ref();
        let mut scene = Assembly::new(path);
        let mut file = scene.read_obj(path, None)?;
        scene.add_mesh(&mut file, &Similarity::default(), true, None)?;
        drop(file);
        let mut scene = scene.finish(&[])?;
        frame(&mut scene)?;
        light(&mut scene);
        checked(scene)
    }
}

/// Gives a scene that has no light a constant white environment, and says so.
fn light(scene: &mut SceneDesc) {
    if scene.lights.is_empty() && !scene.emits() {
        scene.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
        scene.default_light = true;
        scene.warnings.push(format!("{NO_LIGHT}: lit by a constant white environment"));
    }
}

/// Loads a glTF scene: without a camera or without light it gets those of a bare OBJ.
#[cfg(feature = "gltf")]
fn load_gltf(path: &Path) -> Result<SceneDesc> {
    let mut scene = gltf::load(path, parse::DEFAULT_FILM)?;
    // What cannot be framed cannot be rendered either.
    validate::check(&scene)?;
    if scene.cameras.is_empty() {
        frame(&mut scene)?;
    }
    light(&mut scene);
    checked(scene)
}

/// Refuses a glTF scene.
#[cfg(not(feature = "gltf"))]
fn load_gltf(path: &Path) -> Result<SceneDesc> {
    Err(Error::parse(path, None, "a glTF scene: this octray was built without the feature `gltf`"))
}

/// What loading ends with: a scene that keeps the rules, and few warnings.
fn checked(mut scene: SceneDesc) -> Result<SceneDesc> {
    validate::check(&scene)?;
    condense(&mut scene.warnings);
    Ok(scene)
}

fn load_toml(path: &Path) -> Result<SceneDesc> {
    let bytes = read::bytes(path)?;
    let SceneFile { cameras, film, filter, render, meshes, materials, environment, lights } =
        parse::parse_scene(path, &parse::toml_text(path, bytes)?)?;
    if meshes.is_empty() {
        return Err(Error::parse(path, None, "no triangles: add a [[mesh]] with obj = \"FILE.obj\""));
    }
    let mut scene = Assembly::new(path);
    scene.add_meshes(&meshes)?;
    let mut scene = scene.finish(&materials)?;
    (scene.film, scene.filter, scene.render) = (film, filter, render);
    let environment = match environment {
        None => None,
        Some(EnvironmentEntry::Constant { radiance }) => Some(EnvironmentDesc::Constant { radiance }),
        Some(EnvironmentEntry::Map { file, line, rotate, scale }) => {
            let desc = MapDesc { file, rotate, scale, ..MapDesc::default() };
            load_map(path, line, desc, &mut scene.warnings)?.map(EnvironmentDesc::Map)
        }
    };
    scene.set_environment(environment);
    match cameras.first() {
        Some((_, camera, path)) => (scene.camera, scene.camera_path) = (*camera, path.clone()),
        None => frame(&mut scene)?,
    }
    let named = cameras.into_iter().filter_map(|(name, camera, path)| Some(NamedCamera { name: name?, camera, path }));
    scene.cameras = named.collect();
    add_lights(path, &mut scene, lights)?;
    if scene.lights.is_empty() && !scene.emits() {
        let rest = "the picture will be black; add emission, a [[light]] or an [environment]";
        scene.warnings.push(format!("{NO_LIGHT}: {rest}"));
    }
    checked(scene)
}

/// Loads a camera and its path from a TOML file: what `[camera]` of a scene file holds, its keys as `[[key]]`.
///
/// # Errors
/// [`Error::Read`] and [`Error::Parse`] name the file, the line and what to do.
pub fn load_camera_path(path: &Path) -> Result<(CameraDesc, CameraPath)> {
    let bytes = read::bytes(path)?;
    parse::parse_camera_path(path, &parse::toml_text(path, bytes)?)
}

/// The triangles of all meshes; each mesh has one instance.
fn triangles(scene: &SceneDesc) -> impl Iterator<Item = &TriangleDesc> {
    scene.meshes.iter().flat_map(|mesh| &mesh.triangles)
}

/// A scene being put together from meshes.
pub(super) struct Assembly<'a> {
    pub(super) path: &'a Path,
    pub(super) scene: SceneDesc,
    /// The materials of the meshes so far, mesh after mesh.
    materials: Vec<ObjMaterial>,
    /// The vertices of the meshes so far.
    vertices: usize,
    libraries: Libraries,
    pub(super) texture_numbers: Numbers,
    pub(super) mask_numbers: Numbers,
}

impl<'a> Assembly<'a> {
    fn new(path: &'a Path) -> Self {
        let scene = SceneDesc { name: path.display().to_string(), film: parse::DEFAULT_FILM, ..SceneDesc::default() };
        Assembly {
            path,
            scene,
            materials: Vec::new(),
            vertices: 0,
            libraries: Libraries::default(),
            texture_numbers: Numbers::default(),
            mask_numbers: Numbers::default(),
        }
    }

    /// Adds the meshes of a scene file. A file that several of them name is read once.
    fn add_meshes(&mut self, meshes: &[MeshEntry]) -> Result<()> {
        let mut still_named: HashMap<&str, usize> = HashMap::new();
        meshes.iter().for_each(|mesh| *still_named.entry(&mesh.obj).or_default() += 1);
        let mut files: HashMap<&str, ObjFile> = HashMap::new();
        for mesh in meshes {
            let mut file = match files.remove(mesh.obj.as_str()) {
                Some(file) => file,
                None => self.read_obj(&self.path.with_file_name("").join(&mesh.obj), Some(mesh.line))?,
            };
            let left = still_named.get_mut(mesh.obj.as_str());
            let last = left.is_none_or(|left| {
                *left -= 1;
                *left == 0
            });
            self.add_mesh(&mut file, &mesh.transform, last, Some(mesh.line))?;
            if !last {
                files.insert(&mesh.obj, file);
            }
        }
        Ok(())
    }

    /// Reads an OBJ file; `line` of the scene file names it.
    fn read_obj(&mut self, obj: &Path, line: Option<usize>) -> Result<ObjFile> {
        let file = ObjFile::read(obj, &mut self.libraries, &mut self.scene.warnings);
        file.map_err(|error| match (line, error) {
            (Some(_), error @ Error::Read { .. }) => Error::parse(self.path, line, format!("[[mesh]]: {error}")),
            (_, error) => error,
        })
    }

    /// Adds the mesh of an OBJ file, for the last time or not; `line` of the scene file places it.
    fn add_mesh(&mut self, file: &mut ObjFile, transform: &Similarity, last: bool, line: Option<usize>) -> Result<()> {
        let ObjMesh { positions, mut triangles, corners } = file.place(transform, last)?;
        self.vertices += positions.len();
        if u32::try_from(self.vertices).is_err() {
            return Err(Error::parse(self.path, line, "more than 2^32 vertices: split the scene"));
        }
        if positions.iter().flatten().any(|x| !x.is_finite()) {
            let message = "the transform moves vertices out of the range of f32: scale or translate less";
            return Err(Error::parse(self.path, line, message));
        }
        let first_material = self.materials.len() as u32;
        triangles.iter_mut().for_each(|triangle| triangle.material += first_material);
        self.scene.add_mesh(MeshDesc { positions, triangles, corners }, Transform::Identity);
        self.materials.extend_from_slice(&file.materials);
        Ok(())
    }

    /// Makes the materials, the TOML's entries put over them.
    fn finish(mut self, entries: &[MaterialEntry]) -> Result<SceneDesc> {
        if triangles(&self.scene).next().is_none() {
            return Err(Error::parse(self.path, None, "no triangles: the OBJ has no faces of three or more corners"));
        }
        let used = take(&mut self.materials);
        let by_name: HashMap<&str, &MaterialEntry> = entries.iter().map(|entry| (entry.name.as_str(), entry)).collect();
        let (mut undefined, mut used_names) = (Vec::new(), Names::default());
        // Meshes of one file share materials: each is made, and told of, once.
        let mut made: HashMap<*const MtlMaterial, usize> = HashMap::new();
        for ObjMaterial { material, defined } in &used {
            let place = self.scene.materials.len();
            let first = *made.entry(Rc::as_ptr(material)).or_insert(place);
            if first < place {
                self.scene.materials.push(self.scene.materials[first].clone());
                continue;
            }
            let written = material.name.as_str();
            // Quotes and comments of a name that no MTL has are none of it where the scene file has the rest.
            let short = if *defined { written } else { names::plain(written) };
            let name = [written, short].into_iter().find(|name| by_name.contains_key(name)).unwrap_or(written);
            let entry = by_name.get(name).copied();
            if used_names.add(name) && !defined && entry.is_none() {
                undefined.push(name);
            }
            let mut resolved = resolve(self.path, material, entry)?;
            self.add_images(&mut resolved, material, entry)?;
            self.scene.materials.push(resolved);
        }
        self.warn_of_unused(entries, &used_names);
        if !undefined.is_empty() {
            let warning = format!("no MTL defines {}: grey (albedo 0.5) instead", list(&undefined));
            self.scene.warnings.push(warning);
        }
        self.warn_of_degenerate();
        Ok(self.scene)
    }

    /// One warning for all entries that no mesh uses.
    fn warn_of_unused(&mut self, entries: &[MaterialEntry], used: &Names) {
        let mut unused = entries.iter().filter(|entry| !used.set.contains(entry.name.as_str()));
        let describe = |entry: &MaterialEntry| {
            let near = nearest(&entry.name, used.list.iter().copied()).unwrap_or_default();
            [&entry.name, near].map(|name| shortened(name, MOST_OF_A_NAME).into_owned())
        };
        let Some(first) = unused.next() else { return };
        let (file, line, [name, near]) = (self.path.display(), first.line, describe(first));
        let mut warning = format!("{file}:{line}: no mesh uses the material `{name}`; the nearest in use is `{near}`");
        for entry in unused.by_ref().take(MOST_NAMES - 1) {
            let (line, [name, near]) = (entry.line, describe(entry));
            warning += &format!("; nor `{name}` of line {line} (`{near}`)");
        }
        match unused.count() {
            0 => {}
            more => warning += &format!("; nor {more} more"),
        }
        self.scene.warnings.push(warning);
    }

    fn warn_of_degenerate(&mut self) {
        let count = corners(&self.scene).filter(|&corners| is_degenerate(corners)).count();
        if count > 0 {
            self.scene
                .warnings
                .push(format!("{count} triangle(s) have no area; they keep their numbers and are never hit"));
        }
    }
}

/// Names in order of first occurrence, each once.
#[derive(Default)]
struct Names<'a> {
    list: Vec<&'a str>,
    set: HashSet<&'a str>,
}

impl<'a> Names<'a> {
    /// Adds a name; whether it is new.
    fn add(&mut self, name: &'a str) -> bool {
        let new = self.set.insert(name);
        if new {
            self.list.push(name);
        }
        new
    }
}

/// The most names a warning lists, ..
const MOST_NAMES: usize = 8;

/// .. and the most bytes of each.
const MOST_OF_A_NAME: usize = 100;

/// The first few names in quotes.
fn list(names: &[&str]) -> String {
    let quoted = |name: &&str| format!("`{}`", shortened(name, MOST_OF_A_NAME));
    let mut text = names.iter().take(MOST_NAMES).map(quoted).collect::<Vec<_>>().join(", ");
    if names.len() > MOST_NAMES {
        text += &format!(" and {} more", names.len() - MOST_NAMES);
    }
    text
}

/// An MTL material with a TOML entry's keys put over it.
fn resolve(scene: &Path, material: &MtlMaterial, entry: Option<&MaterialEntry>) -> Result<MaterialDesc> {
    let kind = entry.and_then(|e| e.kind).unwrap_or(match material.kind {
        MtlKind::Diffuse => Kind::Diffuse,
        MtlKind::Mirror => Kind::Mirror,
        MtlKind::Dielectric => Kind::Dielectric,
        MtlKind::Conductor => Kind::Conductor,
        MtlKind::Plastic => Kind::Plastic,
    });
    // Every mesh has materials of its own, and their names are for messages.
    let name = shortened(&material.name, MOST_LETTERS).into_owned();
    let fault =
        |line: usize, message: String| Err(Error::parse(scene, Some(line), format!("[material.{name}]: {message}")));
    if let Some(entry) = entry {
        let named = [
            ("albedo", entry.albedo.is_some()),
            ("reflectance", entry.reflectance.is_some()),
            ("alpha", entry.alpha.is_some()),
            ("eta", entry.complex_ior.is_some()),
            ("ior", entry.ior.is_some()),
            ("base_color", entry.base_color.is_some()),
            ("metallic", entry.metallic.is_some()),
            ("roughness", entry.roughness.is_some()),
            ("transmittance", entry.transmittance.is_some()),
        ];
        if let Some((key, _)) = named.iter().find(|(key, named)| *named && !kind.has(key)) {
            return fault(entry.line, format!("its MTL makes it no kind that has `{key}`: add a `kind`"));
        }
    }
    let scattering = entry.unwrap_or(&MaterialEntry::default()).over(kind, material);
    if let (Some(entry), Some(message)) = (entry, validate::scattering_fault(&scattering)) {
        return fault(entry.line, message);
    }
    let emission = entry.and_then(|e| e.emission).unwrap_or(material.emission);
    let two_sided = entry.is_some_and(|e| e.two_sided);
    Ok(MaterialDesc { name, scattering, emission, two_sided, ..MaterialDesc::default() })
}
