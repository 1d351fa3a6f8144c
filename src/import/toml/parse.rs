//! A TOML scene file's text into what it says. Reads no other file; every fault names its line.

use crate::error::{Error, Result};
use crate::import::obj::mtl::MtlMaterial;
use crate::import::toml::lights::{EnvironmentEntry, LightEntry, parse_environment, parse_lights};
use crate::import::toml::reader::{Document, Lines, Table};
use crate::scene::camera::{CameraKey, CameraPath};
use crate::scene::desc::{CameraDesc, PixelFilter, RenderDesc, Scattering};
use crate::scene::transform;
use crate::scene::transform::Similarity;
use crate::scene::validate;
use crate::settings::{MAX_FILM_SIDE, Train};
use std::path::Path;
use std::str::FromStr;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The film of a scene that does not say.
pub const DEFAULT_FILM: (u32, u32) = (512, 512);

/// What a TOML scene file says.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The cameras, each with its name, if it has one, and how it moves; the first is the scene's own.
    pub cameras: Vec<(Option<String>, CameraDesc, CameraPath)>,
    /// Film size in pixels.
    pub film: (u32, u32),
    /// The pixel filter.
    pub filter: PixelFilter,
    /// Defaults for rendering.
    pub render: RenderDesc,
    /// The meshes, in file order.
    pub meshes: Vec<MeshEntry>,
    /// The material entries, in file order.
    pub materials: Vec<MaterialEntry>,
    /// The environment, if it shines.
    pub environment: Option<EnvironmentEntry>,
    /// The other lights, in file order.
    pub lights: Vec<LightEntry>,
}

/// One `[[mesh]]`.
#[derive(Clone, Debug)]
pub struct MeshEntry {
    /// Its OBJ file, as written.
    pub obj: String,
    /// The line it begins at.
    pub line: usize,
    /// Where it stands.
    pub transform: Similarity,
}

/// The kinds of material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Lambertian.
    Diffuse,
    /// Perfect mirror.
    Mirror,
    /// Rough metal.
    Conductor,
    /// Smooth glass.
    Dielectric,
    /// Diffuse base under a rough coat.
    Plastic,
    /// Metal and plastic, mixed.
    Principled,
}

impl Kind {
    /// Every kind with its name in a scene file and the keys it has besides `emission` and `two_sided`.
    pub const ALL: [(Kind, &'static str, &'static [&'static str]); 6] = [
        (Kind::Diffuse, "diffuse", &["albedo"]),
        (Kind::Mirror, "mirror", &["reflectance"]),
        (Kind::Conductor, "conductor", &["alpha", "reflectance", "eta", "k"]),
        (Kind::Dielectric, "dielectric", &["ior", "transmittance"]),
        (Kind::Plastic, "plastic", &["albedo", "ior", "alpha"]),
        (Kind::Principled, "principled", &["base_color", "metallic", "roughness", "ior"]),
    ];

    fn row(self) -> &'static (Kind, &'static str, &'static [&'static str]) {
        Self::ALL.iter().find(|row| row.0 == self).unwrap_or(&Self::ALL[0])
    }

    /// Its name in a scene file.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Whether it has this key.
    pub fn has(self, key: &str) -> bool {
        self.row().2.contains(&key)
    }
}

/// One `[material.NAME]`: the keys it names.
#[derive(Clone, Debug, Default)]
pub struct MaterialEntry {
    /// The material's name.
    pub name: String,
    /// The line it begins at.
    pub line: usize,
    /// Kind, if named.
    pub kind: Option<Kind>,
    /// Albedo, if named.
    pub albedo: Option<[f64; 3]>,
    /// Reflectance, if named.
    pub reflectance: Option<[f64; 3]>,
    /// GGX width, if named.
    pub alpha: Option<f64>,
    /// Complex index of refraction, if named.
    pub complex_ior: Option<([f64; 3], [f64; 3])>,
    /// Index of refraction, if named.
    pub ior: Option<f64>,
    /// Base colour, if named.
    pub base_color: Option<[f64; 3]>,
    /// How much of it is metal, if named.
    pub metallic: Option<f64>,
    /// Square root of the GGX width, if named.
    pub roughness: Option<f64>,
    /// Transmittance, if named.
    pub transmittance: Option<[f64; 3]>,
    /// Emission, if named.
    pub emission: Option<[f64; 3]>,
    /// Both sides emit.
    pub two_sided: bool,
    /// The file of a picture, as written, and its line.
    pub texture: Option<(String, usize)>,
    /// The file of a mask, as written, and its line.
    pub cutout: Option<(String, usize)>,
}

impl MaterialEntry {
    /// How `material` scatters as a `kind` with this entry's keys put over it.
    pub fn over(&self, kind: Kind, material: &MtlMaterial) -> Scattering {
        let albedo = self.albedo.unwrap_or(material.diffuse);
        let reflectance = self.reflectance.unwrap_or(material.specular);
        let alpha = self.alpha.unwrap_or(material.alpha);
        match kind {
            Kind::Diffuse => Scattering::Diffuse { albedo },
            Kind::Mirror => Scattering::Mirror { reflectance },
            Kind::Conductor => Scattering::Conductor { alpha, reflectance, complex_ior: self.complex_ior },
            Kind::Dielectric => Scattering::Dielectric {
                ior: self.ior.unwrap_or(material.ior),
                transmittance: self.transmittance.unwrap_or([1.0; 3]),
            },
            Kind::Plastic => {
                Scattering::Plastic { albedo, ior: self.ior.unwrap_or_else(|| material.coat_ior()), alpha }
            }
            Kind::Principled => Scattering::Principled {
                base_color: self.base_color.unwrap_or(material.diffuse),
                metallic: self.metallic.unwrap_or(material.metallic),
                roughness: self.roughness.unwrap_or(material.alpha.sqrt()),
                ior: self.ior.unwrap_or_else(|| material.coat_ior()),
            },
        }
    }
}

/// Reads the text of the scene file `path`.
pub fn parse_scene(path: &Path, text: &str) -> Result<SceneFile> {
    let lines = Lines::of(text);
    let document = Document { path, lines: &lines };
    let root = DeTable::parse(text).map_err(|e| document.syntax_error(&e))?;
    let root = Table { document, name: "the scene".into(), span: 0..0, entries: root.get_ref() };
    root.check_keys(&["camera", "film", "render", "mesh", "material", "environment", "light"], &[])?;
    let section = |key: &str| match root.entries.get(key) {
        Some(value) => document.table(format!("[{key}]"), value).map(Some),
        None => Ok(None),
    };
    let film = section("film")?.map(|t| parse_film(&t)).transpose()?;
    let (film, filter) = film.unwrap_or((DEFAULT_FILM, PixelFilter::Box));
    Ok(SceneFile {
        cameras: parse_cameras(&root)?,
        film,
        filter,
        render: section("render")?.map(|t| parse_render(&t)).transpose()?.unwrap_or_default(),
        meshes: parse_meshes(&root)?,
        materials: section("material")?.map(|t| parse_materials(&t)).transpose()?.unwrap_or_default(),
        environment: section("environment")?.map(|t| parse_environment(&t)).transpose()?.flatten(),
        lights: parse_lights(&root)?,
    })
}

/// `[camera]`, or any number of `[[camera]]`, which then need names.
fn parse_cameras(root: &Table<'_>) -> Result<Vec<(Option<String>, CameraDesc, CameraPath)>> {
    let Some(value) = root.entries.get("camera") else { return Ok(Vec::new()) };
    let tables = match value.get_ref().as_array() {
        Some(_) => {
            root.tables("camera", "a camera is written [camera], or with double brackets if there are several")?
        }
        None => vec![root.document.table("[camera]".to_owned(), value)?],
    };
    let mut cameras: Vec<(Option<String>, CameraDesc, CameraPath)> = Vec::with_capacity(tables.len());
    for table in &tables {
        let name = table.string("name")?.map(str::to_owned);
        if name.is_none() && tables.len() > 1 {
            return Err(table.error("`name` is missing: of several cameras each needs one, for --camera NAME"));
        }
        if let Some(name) = name.as_ref().filter(|name| cameras.iter().any(|(other, ..)| other.as_ref() == Some(name)))
        {
            return Err(table.error_at("name", format!("two cameras are called `{name}`")));
        }
        let (camera, path) = parse_camera(table, &["name"])?;
        cameras.push((name, camera, path));
    }
    Ok(cameras)
}

/// Reads the text of a camera path: what stands in `[camera]` of a scene file, its keys as `[[key]]`.
pub fn parse_camera_path(path: &Path, text: &str) -> Result<(CameraDesc, CameraPath)> {
    let lines = Lines::of(text);
    let document = Document { path, lines: &lines };
    let root = DeTable::parse(text).map_err(|e| document.syntax_error(&e))?;
    let root = Table { document, name: "the camera path".into(), span: 0..0, entries: root.get_ref() };
    let (camera, path) = parse_camera(&root, &[])?;
    match path.keys().is_empty() {
        true => Err(root.error("no keys: write [[key]] with `time`, `position` and `look_at`, one for each moment")),
        false => Ok((camera, path)),
    }
}

/// What a camera is made of, one key each.
const CAMERA_KEYS: [&str; 6] = ["position", "look_at", "up", "vertical_fov", "aperture_radius", "focus_distance"];

/// A camera and how it moves. Keys say what differs from the table they stand in; a table with keys may leave to them where
/// the camera is, and then is the first of them by itself. `more`: keys that may stand in the table besides.
fn parse_camera(table: &Table<'_>, more: &[&str]) -> Result<(CameraDesc, CameraPath)> {
    table.check_keys(&[&CAMERA_KEYS[..], &["key"], more].concat(), &[])?;
    let mut keys = Vec::new();
    for entry in table.tables("key", "a key is written with double brackets, one for each moment")? {
        entry.check_keys(&[&CAMERA_KEYS[..], &["time"]].concat(), &[])?;
        let time = entry.need("time", entry.number("time")?)?;
        keys.push(CameraKey { time, camera: camera_of(&entry, Some(table))? });
    }
    let twice = |time: f64| table.error_at("key", format!("two keys have the time {time}; each needs one of its own"));
    let path = CameraPath::new(keys).map_err(twice)?;
    let placed = ["position", "look_at"].iter().all(|key| table.entries.contains_key(*key));
    let camera = match path.keys().first() {
        Some(first) if !placed => first.camera,
        _ => camera_of(table, None)?,
    };
    Ok((camera, path))
}

/// The camera that `table` says; where it is silent `outer` does.
fn camera_of(table: &Table<'_>, outer: Option<&Table<'_>>) -> Result<CameraDesc> {
    let default = CameraDesc::default();
    let vector = |key: &str| table.vector(key).transpose().or_else(|| outer?.vector(key).transpose()).transpose();
    let number = |key: &str| table.number(key).transpose().or_else(|| outer?.number(key).transpose()).transpose();
    let position = table.need("position", vector("position")?)?;
    let look_at = table.need("look_at", vector("look_at")?)?;
    let camera = CameraDesc {
        position,
        look_at,
        up: vector("up")?.unwrap_or(default.up),
        vertical_fov: number("vertical_fov")?.unwrap_or(default.vertical_fov),
        aperture_radius: number("aperture_radius")?.unwrap_or(default.aperture_radius),
        // A lens that does not say is in focus where the camera looks at; `camera_fault` judges it.
        focus_distance: number("focus_distance")?.unwrap_or_else(|| match transform::distance(position, look_at) {
            0.0 => default.focus_distance,
            distance => distance,
        }),
        to_world: None,
    };
    match validate::camera_fault(&camera) {
        // The line of the key to change: the fault's text begins with its name.
        Some(fault) => Err(table.error_at(fault.split([' ', ',']).next().unwrap_or_default(), fault)),
        None => Ok(camera),
    }
}

fn parse_film(table: &Table<'_>) -> Result<((u32, u32), PixelFilter)> {
    table.check_keys(&["width", "height", "filter"], &[])?;
    let width = table.whole("width", 1..=MAX_FILM_SIDE)?.unwrap_or(DEFAULT_FILM.0);
    let height = table.whole("height", 1..=MAX_FILM_SIDE)?.unwrap_or(DEFAULT_FILM.1);
    let filter = match table.string("filter")? {
        None | Some("box") => PixelFilter::Box,
        Some("tent") => PixelFilter::Tent,
        Some(other) => {
            let message = format!("unknown filter \"{other}\"; known: \"box\", \"tent\"");
            return Err(table.error_at("filter", message));
        }
    };
    Ok(((width, height), filter))
}

fn parse_render(table: &Table<'_>) -> Result<RenderDesc> {
    let of_estimator = ["strategy", "lights", "guide", "roulette", "train", "sampler", "max_depth", "rr_depth", "seed"];
    table.check_keys(&[&["spp"], &of_estimator[..]].concat(), &[])?;
    let rr_depth = match table.entries.get("rr_depth").map(|value| value.get_ref().as_str()) {
        None => None,
        Some(Some("off")) => Some(None),
        Some(Some(other)) => {
            return Err(table.error_at("rr_depth", format!("`rr_depth` is \"{other}\"; it must be a depth or \"off\"")));
        }
        Some(None) => Some(table.whole("rr_depth", 0..=u32::MAX)?),
    };
    Ok(RenderDesc {
        spp: table.whole("spp", 1..=u32::MAX)?,
        strategy: choice(table, "strategy")?,
        lights: choice(table, "lights")?,
        guide: choice(table, "guide")?,
        roulette: choice(table, "roulette")?,
        train: parse_train(table)?,
        sampler: choice(table, "sampler")?,
        max_depth: table.whole("max_depth", 0..=u32::MAX)?,
        rr_depth,
        seed: table.whole("seed", 0..=u32::MAX)?,
    })
}

/// A number of paths, or a word.
fn parse_train(table: &Table<'_>) -> Result<Option<Train>> {
    match table.entries.get("train").map(|value| value.get_ref().is_str()) {
        Some(true) => choice(table, "train"),
        Some(false) => Ok(table.whole("train", 1..=u32::MAX)?.map(Train::Paths)),
        None => Ok(None),
    }
}

/// One of the named choices of [`crate::settings`].
fn choice<T: FromStr<Err = String>>(table: &Table<'_>, key: &str) -> Result<Option<T>> {
    let Some(word) = table.string(key)? else { return Ok(None) };
    match word.parse() {
        Ok(choice) => Ok(Some(choice)),
        Err(message) => Err(table.error_at(key, message)),
    }
}

fn parse_meshes(root: &Table<'_>) -> Result<Vec<MeshEntry>> {
    let entries = root.tables("mesh", "a mesh is written [[mesh]], with double brackets")?;
    entries.iter().map(parse_mesh).collect()
}

fn parse_mesh(table: &Table<'_>) -> Result<MeshEntry> {
    table.check_keys(&["obj", "scale", "rotate", "translate"], &[])?;
    let obj = table.need("obj", table.string("obj")?)?.to_owned();
    if obj.is_empty() {
        return Err(table.error_at("obj", "`obj` is empty: name an OBJ file"));
    }
    let mut transform = Similarity::default();
    if let Some(scale) = table.number("scale")? {
        if scale == 0.0 {
            return Err(table.error_at("scale", "`scale` is 0: nothing would be left of the mesh"));
        }
        transform.scale = scale;
    }
    if let Some(rotate) = table.table("rotate")? {
        rotate.check_keys(&["axis", "degrees"], &[])?;
        let axis = rotate.need("axis", rotate.vector("axis")?)?;
        let degrees = rotate.need("degrees", rotate.number("degrees")?)?;
        if axis == [0.0; 3] {
            return Err(rotate.error_at("axis", "`axis` is zero: use for instance [0, 1, 0]"));
        }
        transform.rotation = transform::rotation(axis, degrees);
    }
    transform.translate = table.vector("translate")?.unwrap_or_default();
    Ok(MeshEntry { obj, line: table.document.line(table.span.clone()), transform })
}

fn parse_materials(table: &Table<'_>) -> Result<Vec<MaterialEntry>> {
    let mut entries: Vec<(&Spanned<_>, &Spanned<DeValue<'_>>)> = table.entries.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let named = |(key, value): (&Spanned<std::borrow::Cow<'_, str>>, &_)| {
        let table = table.document.table(format!("[material.{}]", key.get_ref()), value)?;
        parse_material(key.get_ref(), &table)
    };
    entries.into_iter().map(named).collect()
}

fn parse_material(name: &str, table: &Table<'_>) -> Result<MaterialEntry> {
    let mut known = vec!["kind", "emission", "two_sided", "texture", "cutout"];
    known.extend(Kind::ALL.iter().flat_map(|row| row.2));
    let kind = match table.string("kind")? {
        None => None,
        Some(word) => match Kind::ALL.iter().find(|row| row.1 == word) {
            Some(row) => Some(row.0),
            None => {
                let names = Kind::ALL.map(|row| format!("\"{}\"", row.1)).join(", ");
                return Err(table.error_at("kind", format!("unknown kind \"{word}\"; known: {names}")));
            }
        },
    };
    table.check_keys(&known, &[])?;
    if let Some(kind) = kind {
        let foreign =
            Kind::ALL.iter().flat_map(|row| row.2).find(|key| table.entries.contains_key(**key) && !kind.has(key));
        if let Some(key) = foreign {
            let has = kind.row().2.join("`, `");
            return Err(table.error_at(key, format!("a {} has no `{key}`; it has `{has}`", kind.name())));
        }
    }
    let complex_ior = match (table.vector("eta")?, table.vector("k")?) {
        (Some(eta), Some(k)) => Some((eta, k)),
        (None, None) => None,
        (Some(_), None) => return Err(table.error_at("eta", "`eta` needs `k` beside it")),
        (None, Some(_)) => return Err(table.error_at("k", "`k` needs `eta` beside it")),
    };
    let picture = |key: &str| -> Result<Option<(String, usize)>> {
        Ok(table.string(key)?.map(|file| (file.to_owned(), table.line_of(key))))
    };
    let entry = MaterialEntry {
        name: name.to_owned(),
        line: table.document.line(table.span.clone()),
        kind,
        albedo: table.fraction("albedo")?,
        reflectance: table.fraction("reflectance")?,
        alpha: table.number("alpha")?,
        complex_ior,
        ior: table.number("ior")?,
        base_color: table.fraction("base_color")?,
        metallic: table.number("metallic")?,
        roughness: table.number("roughness")?,
        transmittance: table.fraction("transmittance")?,
        emission: table.radiance("emission")?,
        two_sided: table.boolean("two_sided")?.unwrap_or(false),
        texture: picture("texture")?,
        cutout: picture("cutout")?,
    };
    // What the entry leaves to the MTL is in range already; what it names is judged at its own line.
    let named = kind.and_then(|kind| validate::scattering_fault(&entry.over(kind, &MtlMaterial::grey(name))));
    if let Some(fault) = named {
        return Err(table.error_at(fault.split(' ').next().unwrap_or_default(), fault.as_str()));
    }
    match (entry.albedo, entry.reflectance, complex_ior) {
        (Some(_), Some(_), _) => Err(table.error_at("reflectance", "`albedo` and `reflectance` exclude each other")),
        (_, Some(_), Some(_)) => Err(table.error_at("reflectance", "`reflectance` and `eta`, `k` exclude each other")),
        _ => Ok(entry),
    }
}

/// The bytes of a TOML file as text.
pub fn toml_text(path: &Path, bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes).map_err(|e| {
        let valid = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|&&b| b == b'\n').count();
        Error::parse(path, Some(line), "not UTF-8 text: save the file as UTF-8")
    })
}
