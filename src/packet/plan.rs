//! The plan: which stages, variants and queues a scene and a strategy need, and what they leave out.
//!
//! **Invariant:** a stage that is not needed is not in the list, is never called, and its queue holds no memory.

use crate::bvh::{RayKind, Walk};
use crate::packet::counters::Stage;
use crate::packet::queues::{QueueNeeds, TileState};
use crate::packet::stages::generate_camera_rays;
use crate::packet::stages::generate_camera_rays::CameraStage;
use crate::packet::stages::shade_glossy::{shade_conductor, shade_dielectric, shade_plastic};
use crate::packet::stages::shade_miss;
use crate::packet::stages::shade_miss::MissStage;
use crate::packet::stages::shade_surface::{shade_diffuse, shade_mirror};
use crate::packet::tile;
use crate::packet::tile::IntersectStage;
use crate::scene::desc::PixelFilter;
use crate::settings::Strategy;
use crate::setup::Setup;
use crate::tables::lights::table::{EnvironmentLight, Selection, selection_name};

/// A stage of the plan.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct PlannedStage {
    /// Its name.
    pub stage: &'static str,
    /// The variant of it that runs.
    pub variant: String,
}

/// Something this render does without.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct LeftOut {
    /// What.
    pub what: &'static str,
    /// Why it is not needed.
    pub why: String,
}

/// A surface stage, monomorphised for one strategy.
pub type SurfaceStage = fn(&Setup, &Plan, &mut TileState, u32);

/// What a render runs, in order, and what it leaves out.
pub struct Plan {
    /// Stages in the order in which a path meets them.
    pub stages: Vec<PlannedStage>,
    /// What is neither allocated nor branched on nor run.
    pub left_out: Vec<LeftOut>,
    /// Queues that exist.
    pub needs: QueueNeeds,
    /// The camera stage of this lens and filter.
    pub generate_camera_rays: CameraStage,
    /// The closest hits, in a scene with or without cut-outs.
    pub intersect_closest: IntersectStage,
    /// The shadow rays, likewise.
    pub intersect_shadow: IntersectStage,
    /// The miss stage of this environment.
    pub shade_miss: MissStage,
    /// The surface stages that run, in order, in this strategy's variants.
    pub surfaces: Vec<(Stage, SurfaceStage)>,
    /// Every triangle has this class, so hits need not be looked up ([`crate::tables::PreparedScene::classes`]).
    pub only_class: Option<u8>,
    /// Shadow rays end at a light point (1), leave the scene (infinity), or say so one by one (`None`).
    pub shadow_tmax: Option<f32>,
    /// Whether emission can count after a last event whose direction was drawn from a density.
    pub last_drawn_counts: bool,
    /// Whether emission can count after a last delta event.
    pub last_delta_counts: bool,
}

impl Plan {
    /// The plan of one render.
    pub fn new(setup: &Setup) -> Plan {
        let (scene, strategy) = (setup.scene, setup.strategy);
        let emission_counts = strategy != Strategy::NeeNoEmission;
        let (features, events) = (scene.features, setup.max_depth > 0);
        let glossy = features.conductor || features.plastic;
        let pdf = strategy.is_mis() && setup.samples_lights();
        let needs = QueueNeeds {
            pdf,
            cosine: pdf && glossy && matches!(setup.lights.environment, Some(EnvironmentLight::Constant(_))),
            normal: pdf && matches!(setup.lights.selection, Selection::Tree(_)),
            misses: scene.environment.is_some() && emission_counts,
            emitters: !scene.emitters.is_empty() && emission_counts,
            diffuse: features.diffuse && events,
            mirror: features.mirror && events,
            conductor: features.conductor && events,
            dielectric: features.dielectric && events,
            plastic: features.plastic && events,
            shadow: (features.diffuse || glossy) && events && setup.samples_lights(),
            alpha_masks: features.alpha_masks,
        };
        let (intersect_closest, intersect_shadow) = tile::variants(features.alpha_masks);
        let first = scene.classes.first().copied();
        let lit = !setup.lights.is_empty();
        let detailed = !scene.corners.is_empty();
        let mut surfaces = match detailed {
            false => variants::<false>(strategy),
            true => variants::<true>(strategy),
        }
        .to_vec();
        surfaces.retain(|(stage, _)| needs.surface(*stage));
        Plan {
            stages: stages(setup, needs),
            left_out: left_out(setup),
            needs,
            generate_camera_rays: generate_camera_rays::variant(setup),
            intersect_closest,
            intersect_shadow,
            shade_miss: shade_miss::variant(setup),
            surfaces,
            only_class: first.filter(|class| scene.classes.iter().all(|c| c == class)),
            shadow_tmax: match (setup.lights.environment.is_some(), setup.lights.records.is_empty()) {
                (false, _) => Some(1.0),
                (true, true) => Some(f32::INFINITY),
                (true, false) => None,
            },
            last_drawn_counts: lit && !matches!(strategy, Strategy::Nee | Strategy::NeeNoEmission),
            last_delta_counts: lit && emission_counts,
        }
    }

    /// One thread's queues.
    pub fn tile_state(&self, capacity: usize) -> TileState {
        TileState::new(capacity, self.needs, self.shadow_tmax.unwrap_or(1.0))
    }
}

/// The surface stages of a strategy: one monomorphised copy each, without or with what smooth surfaces need. (The sampler
/// is a branch in them, always taken alike: copies for it would double the code to save 1 % of the instructions.)
fn variants<const DETAIL: bool>(strategy: Strategy) -> [(Stage, SurfaceStage); 5] {
    macro_rules! choose {
        ($($variant:ident),*) => {
            match strategy {
                $(Strategy::$variant => [
                    (Stage::ShadeDiffuse, shade_diffuse::<{ Strategy::$variant as u8 }, DETAIL>),
                    (Stage::ShadeMirror, shade_mirror::<{ Strategy::$variant as u8 }, DETAIL>),
                    (Stage::ShadeConductor, shade_conductor::<{ Strategy::$variant as u8 }, DETAIL>),
                    (Stage::ShadeDielectric, shade_dielectric::<{ Strategy::$variant as u8 }, DETAIL>),
                    (Stage::ShadePlastic, shade_plastic::<{ Strategy::$variant as u8 }, DETAIL>),
                ],)*
            }
        };
    }
    choose!(Uniform, Bsdf, NeeSum, NeeAverage, NeeNoEmission, Nee, MisOneSample, MisBalance, MisPower)
}

fn stages(setup: &Setup, needs: QueueNeeds) -> Vec<PlannedStage> {
    let strategy = setup.strategy.name();
    let lights =
        if needs.shadow { format!(", light sample ({})", selection_name(&setup.lights)) } else { String::new() };
    let textures = if setup.scene.features.textures { ", textures" } else { "" };
    let alpha_masks = if setup.scene.features.alpha_masks { ", past cut-outs" } else { "" };
    let normals = if setup.scene.features.smooth_normals { ", smooth normals" } else { "" };
    let roulette = if setup.rr_depth == u32::MAX || setup.rr_depth > setup.max_depth { "" } else { ", roulette" };
    let ends = match (setup.lights.environment.is_some(), setup.lights.records.is_empty()) {
        (false, _) => "to light points",
        (true, true) => "to the environment",
        (true, false) => "to light points and the environment",
    };
    let weight = if needs.pdf { "weighed by density" } else { "weighed by strategy" };
    let environment = match setup.lights.environment {
        Some(EnvironmentLight::Map(..)) => "environment map",
        _ => "constant environment",
    };
    let lens = if setup.camera.lens.is_some() { "thin lens" } else { "pinhole" };
    let filter = if setup.camera.filter == PixelFilter::Box { "box" } else { "tent" };
    let camera = format!("{lens}, {filter} filter");
    let list = [
        (Stage::GenerateCameraRays, true, camera),
        (Stage::IntersectClosest, true, walks(setup) + alpha_masks),
        (Stage::SortHits, true, "one queue a material kind".to_string()),
        (Stage::ShadeMiss, needs.misses, format!("{environment}, {weight}")),
        (Stage::ShadeEmitter, needs.emitters, weight.to_string()),
        (Stage::ShadeDiffuse, needs.diffuse, format!("{strategy}{textures}{lights}{normals}{roulette}")),
        (Stage::ShadeMirror, needs.mirror, format!("{strategy}{normals}{roulette}")),
        (Stage::ShadeConductor, needs.conductor, format!("{strategy}, GGX{lights}{normals}{roulette}")),
        (Stage::ShadeDielectric, needs.dielectric, format!("{strategy}, smooth{normals}{roulette}")),
        (Stage::ShadePlastic, needs.plastic, format!("{strategy}{textures}, GGX coat{lights}{normals}{roulette}")),
        (Stage::IntersectShadow, needs.shadow, format!("{ends}{alpha_masks}")),
        (Stage::AddToFilm, true, "sums and squares, f64".to_string()),
    ];
    let planned = list.into_iter().filter(|(_, needed, _)| *needed);
    planned.map(|(stage, _, variant)| PlannedStage { stage: stage.name(), variant }).collect()
}

/// How rays walk the tree, by kind.
fn walks(setup: &Setup) -> String {
    let word = |kind: RayKind| match setup.scene.bvh.first_choice(kind) {
        Walk::Single => "one by one",
        Walk::Packet => "packets (streams where they part)",
        Walk::Stream => "streams",
        Walk::Flat => "packets through a list",
    };
    format!("camera rays: {}; after a bounce: {}", word(RayKind::Camera), word(RayKind::Bounce))
}

fn left_out(setup: &Setup) -> Vec<LeftOut> {
    let scene = setup.scene;
    let mut list = Vec::new();
    let mut unless = |needed: bool, what: &'static str, why: String| {
        if !needed {
            list.push(LeftOut { what, why });
        }
    };
    let strategy = format!("{} draws no light samples", setup.strategy);
    let nothing = "no surface scatters".to_string();
    unless(scene.environment.is_some(), "environment", "the scene names none".into());
    unless(scene.features.textures, "textures", "no material has one".into());
    unless(scene.features.mirror, "mirror", "no triangle is a mirror".into());
    unless(scene.features.conductor, "conductor", "no triangle is a rough metal".into());
    unless(scene.features.dielectric, "dielectric", "no triangle is glass".into());
    unless(scene.features.plastic, "plastic", "no triangle is coated".into());
    unless(setup.camera.lens.is_some(), "lens", "the camera is a pinhole".into());
    unless(scene.features.smooth_normals, "smooth normals", "surfaces are shaded with their true normals".into());
    unless(scene.features.alpha_masks, "cut-outs", "no material is cut out".into());
    unless(setup.camera.filter != PixelFilter::Box, "pixel filter", "the box filter needs no weights".into());
    let selects = setup.samples_lights() && setup.lights.records.len() > 1;
    let single = if setup.lights.records.len() == 1 { "there is one light" } else { "there is nothing to choose from" };
    let why = if setup.strategy.samples_lights() { single.to_string() } else { strategy.clone() };
    unless(selects, "light selection", why);
    let why = if setup.strategy.samples_lights() { "the scene has no light".to_string() } else { strategy };
    unless(setup.samples_lights(), "light sampling", why);
    let roulette = setup.rr_depth <= setup.max_depth;
    let why = if setup.rr_depth == u32::MAX { "it is switched off" } else { "paths end before it would start" };
    unless(roulette, "roulette", why.into());
    unless(scene.features.scatters(), "surface shading", nothing);
    list
}
