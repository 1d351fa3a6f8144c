//! `SceneDesc -> PreparedScene`: every table the engines read, derived once and immutable afterwards.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::bvh::Bvh;
use crate::error::{Error, Result};
use crate::scene::desc::{CameraDesc, MaterialDesc, PixelFilter, RenderDesc, SceneDesc};
use crate::scene::validate::is_degenerate;
use crate::tables::alpha_masks::AlphaMaskTable;
use crate::tables::corners::{CornerRecord, FLAT, corner_table, placed};
use crate::tables::lights::environment::Environment;
use crate::tables::lights::tree::LightTree;
use crate::tables::margins::Margins;
use crate::tables::materials::{MaterialKind, MaterialRecord};
use crate::tables::textures::TextureTable;

/// [`TriangleRecord::light`] of a triangle that does not emit.
pub const NO_LIGHT: u32 = u32::MAX;

/// What shading needs of one triangle: one cache line, read whole.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct TriangleRecord {
    /// Vertices in file order, scene units.
    pub vertices: [[f32; 3]; 3],
    /// Unit normal of the front side.
    pub normal: [f32; 3],
    /// Index into [`PreparedScene::materials`].
    pub material: u32,
    /// Index into [`PreparedScene::emitters`], or [`NO_LIGHT`].
    pub light: u32,
    /// [`Margins::sliver`], scene units.
    pub sliver: f32,
    /// [`Margins::inset`].
    pub inset: f32,
}

/// One emissive triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// The triangle's id.
    pub triangle: u32,
    /// Its area, square scene units.
    pub area: f64,
    /// Emitted radiance on the front side, W sr^-1 m^-2.
    pub radiance: [f32; 3],
    /// The back emits as the front does.
    pub two_sided: bool,
    /// What multiplies the radiance: a texture and its coordinates at the triangle's corners.
    pub texture: Option<(u32, [[f32; 2]; 3])>,
}

/// The bit of [`PreparedScene::classes`] that says: this triangle emits.
pub const CLASS_EMITS: u8 = 0x80;

/// What a scene holds, hence what a plan may need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Features {
    /// Some triangle has a diffuse material.
    pub diffuse: bool,
    /// Some triangle has a mirror material.
    pub mirror: bool,
    /// Some triangle is a rough metal.
    pub conductor: bool,
    /// Some triangle is glass.
    pub dielectric: bool,
    /// Some triangle is coated.
    pub plastic: bool,
    /// Emissive triangles.
    pub emissive_triangles: usize,
    /// Something surrounds the scene.
    pub environment: bool,
    /// Some triangle is part of a smooth surface.
    pub smooth_normals: bool,
    /// Some material has a texture.
    pub textures: bool,
    /// Of some triangle only a part is there.
    pub alpha_masks: bool,
}

/// A scene ready to be rendered: immutable tables, all values finite. Indices are triangle ids in file order.
pub struct PreparedScene {
    /// The path it was loaded from, or `builtin:NAME`.
    pub name: String,
    /// The camera as the scene describes it.
    pub camera: CameraDesc,
    /// The film size the scene asks for (width, height).
    pub film: (u32, u32),
    /// How samples are spread about a pixel's centre.
    pub filter: PixelFilter,
    /// What the scene file's `[render]` sets.
    pub render: RenderDesc,
    /// Per triangle id, what shading reads.
    pub triangles: Vec<TriangleRecord>,
    /// Per triangle id, what its corners carry; empty if no surface is smooth or textured.
    pub corners: Vec<CornerRecord>,
    /// The textures; lights share them.
    pub textures: Arc<TextureTable>,
    /// The cut-out triangles; lights share them.
    pub alpha_masks: Arc<AlphaMaskTable>,
    /// Per triangle id, the material's kind (low bits) and [`CLASS_EMITS`]: the sorting key of a hit.
    pub classes: Vec<u8>,
    /// Materials in use, sorted by kind.
    pub materials: Vec<MaterialRecord>,
    /// Emissive triangles, by ascending id.
    pub emitters: Vec<Emitter>,
    /// The surroundings, if there are any.
    pub environment: Option<Environment>,
    /// The acceleration structure.
    pub bvh: Bvh,
    /// The light tree, built when it is first asked for.
    light_tree: OnceLock<Option<LightTree>>,
    /// What the scene holds.
    pub features: Features,
    /// What preparing has found out that the user should know, one sentence each; [`SceneDesc::warnings`] has what
    /// loading had to say.
    pub warnings: Vec<String>,
    /// Seconds spent in loading files (0 for scenes made in code).
    pub load_s: f64,
    /// Seconds spent in deriving tables and building the BVH.
    pub build_s: f64,
}

impl Features {
    /// Whether any surface scatters light.
    pub fn scatters(&self) -> bool {
        self.diffuse || self.mirror || self.conductor || self.dielectric || self.plastic
    }
}

impl PreparedScene {
    /// Derives every table.
    ///
    /// # Errors
    /// [`Error::Scene`] if there is nothing to render (no triangle of positive area and no environment), or if the scene
    /// is too large or too small for f32 ([`crate::tables::scale_limits`]).
    pub fn new(desc: &SceneDesc) -> Result<PreparedScene> {
        let start = Instant::now();
        let mut warnings = crate::tables::scale_limits::check(desc)?;
        let degenerate = degenerate_triangles(desc);
        if degenerate.iter().all(|&d| d) && desc.environment.is_none() {
            let message = "no triangle of positive area and no environment: there is nothing to see; check the OBJ";
            return Err(Error::Scene { scene: desc.name.clone(), message: message.into() });
        }
        let (materials, material_index) = material_table(&desc.materials);
        let emitters = emitter_table(desc, &degenerate);
        let triangles = triangle_table(desc, &degenerate, &material_index, &emitters);
        let corners = corner_table(desc, &triangles);
        let classes: Vec<u8> = triangles
            .iter()
            .map(|t| materials[t.material as usize].kind() as u8 | if t.light == NO_LIGHT { 0 } else { CLASS_EMITS })
            .collect();
        let vertices: Vec<[u32; 3]> = desc.triangles.iter().map(|t| t.vertices).collect();
        let bvh = Bvh::build(&desc.positions, &vertices, |id| !degenerate[id as usize]);
        let alpha_masks = AlphaMaskTable::new(desc);
        let uses = |kind: MaterialKind| classes.iter().zip(&degenerate).any(|(c, d)| !d && c & 0x7f == kind as u8);
        let features = Features {
            diffuse: uses(MaterialKind::Diffuse),
            mirror: uses(MaterialKind::Mirror),
            conductor: uses(MaterialKind::Conductor),
            dielectric: uses(MaterialKind::Dielectric),
            plastic: uses(MaterialKind::Plastic),
            emissive_triangles: emitters.len(),
            environment: desc.environment.is_some(),
            smooth_normals: corners.iter().any(|corner| corner.smoothness != FLAT),
            textures: desc.materials.iter().any(|m| m.texture.is_some() || m.emission_texture.is_some()),
            alpha_masks: !alpha_masks.is_empty(),
        };
        let mut scene = PreparedScene {
            name: desc.name.clone(),
            camera: desc.camera,
            film: desc.film,
            filter: desc.filter,
            render: desc.render,
            triangles,
            corners,
            textures: Arc::new(TextureTable::new(&desc.textures)),
            alpha_masks: Arc::new(alpha_masks),
            classes,
            materials,
            emitters,
            environment: desc.environment.as_ref().map(Environment::new),
            bvh,
            light_tree: OnceLock::new(),
            features,
            warnings: Vec::new(),
            load_s: 0.0,
            build_s: 0.0,
        };
        warnings.extend(crate::tables::emitter_facing::warnings(desc, &scene));
        scene.warnings = warnings;
        scene.build_s = start.elapsed().as_secs_f64();
        Ok(scene)
    }

    /// The light tree, if there is anything to choose from; `powers` are those of the emitters.
    pub(super) fn light_tree(&self, powers: impl FnOnce() -> Vec<f64>) -> Option<&LightTree> {
        let build = || {
            let environment = self.environment.as_ref().map_or(0.0, Environment::mean_radiance);
            LightTree::new(&self.emitters, &self.triangles, &powers(), environment)
        };
        self.light_tree.get_or_init(build).as_ref()
    }

    /// The tables and their sizes in bytes, for `octray info`; empty tables are not listed.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        let mut tables = vec![
            ("triangle records", size_of_val(&self.triangles[..])),
            ("triangle corners", size_of_val(&self.corners[..])),
            ("textures", self.textures.bytes()),
            ("cut-outs", self.alpha_masks.bytes()),
            ("triangle classes", size_of_val(&self.classes[..])),
            ("materials", size_of_val(&self.materials[..])),
            ("emissive triangles", size_of_val(&self.emitters[..])),
        ];
        tables.extend(self.bvh.tables());
        if let Some(Environment::Map(map)) = &self.environment {
            tables.extend(map.tables());
        }
        tables.retain(|table| table.1 > 0);
        tables
    }
}

fn corners(desc: &SceneDesc, triangle: usize) -> [[f32; 3]; 3] {
    desc.triangles[triangle].vertices.map(|v| desc.positions[v as usize])
}

fn degenerate_triangles(desc: &SceneDesc) -> Vec<bool> {
    (0..desc.triangles.len()).map(|id| is_degenerate(corners(desc, id))).collect()
}

/// Twice the area vector of a triangle, from its rounded vertices, in f64.
fn double_area_vector([a, b, c]: [[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| glam::Vec3::from(v).as_dvec3());
    (b - a).cross(c - a)
}

/// Materials sorted by kind (stable), and for each old index its new one.
fn material_table(descs: &[MaterialDesc]) -> (Vec<MaterialRecord>, Vec<u32>) {
    let records: Vec<MaterialRecord> = descs.iter().map(MaterialRecord::new).collect();
    let mut order: Vec<usize> = (0..records.len()).collect();
    order.sort_by_key(|&i| records[i].kind());
    let mut new_index = vec![0; records.len()];
    for (new, &old) in order.iter().enumerate() {
        new_index[old] = new as u32;
    }
    (order.into_iter().map(|i| records[i]).collect(), new_index)
}

fn emitter_table(desc: &SceneDesc, degenerate: &[bool]) -> Vec<Emitter> {
    let material = |id: usize| &desc.materials[desc.triangles[id].material as usize];
    let emission = |id: usize| material(id).emission;
    (0..desc.triangles.len())
        .filter(|&id| !degenerate[id] && emission(id).iter().any(|&c| c as f32 > 0.0))
        .map(|id| Emitter {
            triangle: id as u32,
            area: 0.5 * double_area_vector(corners(desc, id)).length(),
            radiance: emission(id).map(|c| c as f32),
            two_sided: material(id).two_sided,
            texture: material(id).emission_texture.map(|used| {
                let uvs = desc.corners.get(id).map_or([[0.0; 2]; 3], |corner| corner.uvs);
                (used.texture, placed(uvs, Some(used)))
            }),
        })
        .collect()
}

fn triangle_table(
    desc: &SceneDesc,
    degenerate: &[bool],
    material_index: &[u32],
    emitters: &[Emitter],
) -> Vec<TriangleRecord> {
    let mut next_emitter = 0;
    (0..desc.triangles.len())
        .map(|id| {
            let triangle = desc.triangles[id];
            let vertices = corners(desc, id);
            let normal = if degenerate[id] {
                DVec3::Z // never hit; any finite value will do
            } else {
                double_area_vector(vertices).normalize() * if triangle.flipped { -1.0 } else { 1.0 }
            };
            let margins = if degenerate[id] { Margins::default() } else { Margins::of(vertices) };
            let emits = emitters.get(next_emitter).is_some_and(|e| e.triangle == id as u32);
            let light = if emits { next_emitter as u32 } else { NO_LIGHT };
            next_emitter += emits as usize;
            TriangleRecord {
                vertices,
                normal: normal.as_vec3().to_array(),
                material: material_index[triangle.material as usize],
                light,
                sliver: margins.sliver,
                inset: margins.inset,
            }
        })
        .collect()
}
