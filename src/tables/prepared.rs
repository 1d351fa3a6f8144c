//! `SceneDesc -> PreparedScene`: every table the engines read, derived once and immutable afterwards.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use crate::bvh::{Bvh, huge};
use crate::error::Result;
use crate::fault::{Fault, planted};
use crate::scene::desc::{CameraDesc, MaterialDesc, PixelFilter, RenderDesc, SceneDesc};
use crate::scene::validate;
use crate::scene::warnings::condense;
use crate::strategy::Strategy;
use crate::tables::alpha_masks::AlphaMaskTable;
use crate::tables::corners::{CornerRecord, corner_table};
use crate::tables::duplicates::Duplicates;
use crate::tables::emitter_facing;
use crate::tables::features::Features;
use crate::tables::lights::deltas::DeltaLights;
use crate::tables::lights::emitters::{Emitter, emitter_table};
use crate::tables::lights::environment::Environment;
use crate::tables::lights::patches::{LearnedPatches, Patches};
use crate::tables::lights::tree::LightTree;
use crate::tables::lights::unit::radiance_unit;
use crate::tables::materials::MaterialRecord;
use crate::tables::scale_limits;
use crate::tables::textures::TextureTable;
use crate::tables::triangles::{TriangleRecord, class_table, degenerate_triangles, triangle_table};

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
    /// Per triangle id, the material's kind (low bits) and [`crate::tables::triangles::CLASS_EMITS`]: the sorting key
    /// of a hit.
    pub classes: Vec<u8>,
    /// Materials in use, sorted by kind.
    pub materials: Vec<MaterialRecord>,
    /// What radiances count in here and in the engines, W sr^-1 m^-2: a power of two, and 1 in scenes that are not extreme
    /// ([`crate::tables::lights::unit`]). Films count in W sr^-1 m^-2.
    pub radiance_unit: f64,
    /// Emissive triangles, by ascending id.
    pub emitters: Vec<Emitter>,
    /// Lights that no ray can hit.
    pub delta_lights: DeltaLights,
    /// The surroundings, if there are any.
    pub environment: Option<Environment>,
    /// The acceleration structure.
    pub bvh: Bvh,
    /// The light tree, if there is something to choose from, and one whether there is or not; built when first asked for.
    light_trees: [OnceLock<Option<LightTree>>; 2],
    patches: [OnceLock<Arc<Patches>>; 2],
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

impl PreparedScene {
    /// Derives every table.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] if the description breaks a rule of [`crate::scene::validate`], or if the scene is too
    /// large or too small for f32 ([`crate::tables::scale_limits`]).
    pub fn new(desc: &SceneDesc) -> Result<PreparedScene> {
        let start = Instant::now();
        let geometry = validate::check(desc)?;
        let mut warnings = scale_limits::check(desc, &geometry)?;
        let mut degenerate = degenerate_triangles(&geometry);
        let duplicates = Duplicates::find(&desc.materials, &geometry, &degenerate);
        duplicates.dropped.iter().for_each(|&id| degenerate[id as usize] = true);
        warnings.extend(duplicates.warning());
        let (materials, material_index) = material_table(&desc.materials);
        let radiance_unit = radiance_unit(desc);
        let delta_lights = DeltaLights::new(desc, &geometry, radiance_unit);
        let mut emitters = emitter_table(&desc.materials, radiance_unit, &geometry, &degenerate);
        duplicates.light_both_sides(&mut emitters);
        let mut vertices: Vec<[u32; 3]> = huge::list(geometry.triangles.len());
        vertices.extend(geometry.triangles.iter().map(|t| t.vertices));
        let mut is_emitter = vec![false; vertices.len()];
        emitters.iter().for_each(|emitter| is_emitter[emitter.triangle as usize] = true);
        let emits = |id: u32| is_emitter[id as usize];
        // Asked here, since a fault is planted for one thread.
        let lost = planted(Fault::LostTriangle);
        let real = |id: u32| !(degenerate[id as usize] || lost && id.is_multiple_of(7));
        let bvh = Bvh::build_lit(&geometry.positions, &vertices, real, emits);
        let emissive = emitters.iter().map(|e| e.triangle);
        let triangles = triangle_table(&geometry, &degenerate, &material_index, emissive, &bvh);
        let corners = corner_table(&desc.materials, &geometry, &triangles);
        let classes = class_table(&triangles, &materials);
        let alpha_masks = AlphaMaskTable::new(desc, &geometry);
        let features = Features::new(desc, &degenerate, &classes, &corners, !alpha_masks.is_empty());
        warnings.extend(emitter_facing::warnings(desc, &geometry, &emitters, &triangles, &bvh));
        let environment = desc.environment().map(|environment| Environment::new(environment, radiance_unit));
        warnings.extend(environment.as_ref().and_then(Environment::warning));
        if planted(Fault::SilentLimits) {
            warnings.clear();
        }
        condense(&mut warnings);
        Ok(PreparedScene {
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
            radiance_unit,
            emitters,
            delta_lights,
            environment,
            bvh,
            light_trees: Default::default(),
            patches: Default::default(),
            features,
            warnings,
            load_s: 0.0,
            build_s: start.elapsed().as_secs_f64(),
        })
    }

    /// The light tree, if there is anything to choose from, or if there is any light and it is wanted `always`; `powers` are
    /// those of the emitters, at least.
    pub(super) fn light_tree(&self, powers: impl FnOnce() -> Vec<f64>, always: bool) -> Option<&LightTree> {
        let build = || {
            let environment = self.environment.as_ref().map_or(0.0, Environment::mean_radiance);
            let emitters = (&self.emitters[..], &self.triangles[..]);
            LightTree::new(emitters, &powers(), &self.delta_lights, environment, always)
        };
        self.light_trees[usize::from(always)].get_or_init(build).as_ref()
    }

    /// Whether `strategy` has a way to find each of the lights.
    pub fn is_seen_by(&self, strategy: Strategy) -> bool {
        strategy.samples_lights() || self.delta_lights.records.is_empty()
    }

    /// The patches of the environment map, if there is one, for a distribution ([`crate::tables::lights::environment::EnvironmentMap::distribution`]).
    pub fn patches(&self, compensated: bool) -> Option<LearnedPatches> {
        let Some(Environment::Map(map)) = &self.environment else { return None };
        let make = || Arc::new(Patches::new(map, map.distribution(compensated)));
        let patches = self.patches[usize::from(compensated)].get_or_init(make);
        Some(LearnedPatches::new(patches.clone(), map.mean_radiance))
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
