//! The plan in prose: what each stage of it does, and what the render does without.

use crate::bvh::{RayKind, Walk};
use crate::packet::counters::Stage;
use crate::packet::plan::Plan;
use crate::scene::desc::PixelFilter;
use crate::settings::{PlanChoice, Sampler};
use crate::setup::Setup;
use crate::tables::lights::table::{EnvironmentLight, selection_name};
use crate::tables::materials::{Lobes, MaterialKind, TABLE};

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

/// The stages that run, in order: those of the plan between the first, which starts paths, and the last, which ends them.
pub fn stages(setup: &Setup, plan: &Plan) -> Vec<PlannedStage> {
    let round = plan.round.iter().map(|(stage, _)| *stage);
    let all = [Stage::GenerateCameraRays].into_iter().chain(round).chain([Stage::AddToFilm]);
    all.map(|stage| PlannedStage { stage: stage.name(), variant: variant(setup, plan, stage) }).collect()
}

fn variant(setup: &Setup, plan: &Plan, stage: Stage) -> String {
    let needs = &plan.decisions.needs;
    let masks = if needs.alpha_masks { ", past cut-outs" } else { "" };
    let weight = if needs.pdf { "weighed by density" } else { "weighed by strategy" };
    match stage {
        Stage::GenerateCameraRays => {
            let lens = if setup.camera.lens.is_some() { "thin lens" } else { "pinhole" };
            format!("{lens}, {} filter", if setup.camera.filter == PixelFilter::Box { "box" } else { "tent" })
        }
        Stage::IntersectClosest => walks(setup) + masks,
        Stage::SortHits => "one queue a material kind".into(),
        Stage::ShadeMiss => match setup.lights.environment {
            Some(EnvironmentLight::Map(..)) => format!("environment map, {weight}"),
            _ => format!("constant environment, {weight}"),
        },
        Stage::ShadeEmitter => weight.into(),
        Stage::Shade(kind) => surface(setup, plan, kind),
        Stage::IntersectShadow => match plan.decisions.shadow_tmax {
            Some(_) => format!("to the environment{masks}"),
            None if setup.lights.environment.is_none() => format!("to light points{masks}"),
            None => format!("to light points and the environment{masks}"),
        },
        Stage::AddToFilm => match setup.sampler {
            Sampler::Independent => "sums and squares, f64".into(),
            Sampler::Sobol => "sums, and sums by group, f64".into(),
        },
    }
}

fn surface(setup: &Setup, plan: &Plan, kind: MaterialKind) -> String {
    let (row, features) = (kind.row(), &setup.scene.features);
    let mut words: Vec<String> = Vec::new();
    if row.lobes == Lobes::Density {
        words.push(setup.strategy.to_string());
    }
    if row.textured && features.textures {
        words.push("textures".into());
    }
    words.extend((!row.variant.is_empty()).then(|| row.variant.into()));
    if row.lobes == Lobes::Density && plan.decisions.needs.shadow {
        words.push(format!("light sample ({})", selection_name(&setup.lights)));
    }
    if plan.decisions.learned && kind == MaterialKind::Diffuse {
        words.push("what was learned of directions".into());
    }
    words.extend(features.smooth_normals.then(|| "smooth normals".into()));
    if setup.rr_depth != u32::MAX && setup.rr_depth <= setup.max_depth {
        words.push("roulette".into());
    }
    words.join(", ")
}

/// How rays walk the tree, by kind.
fn walks(setup: &Setup) -> String {
    let bvh = &setup.scene.bvh;
    let word = |kind: RayKind| match bvh.first_choice(kind) {
        Walk::Single => "one by one",
        Walk::Packet if bvh.first_choice(RayKind::Bounce) == Walk::Flat => "packets (through a list where they part)",
        Walk::Packet => "packets (streams where they part)",
        Walk::Stream => "streams",
        Walk::Flat => "packets through a list",
    };
    format!("camera rays: {}; after a bounce: {}", word(RayKind::Camera), word(RayKind::Bounce))
}

/// What the render does without.
pub fn left_out(setup: &Setup) -> Vec<LeftOut> {
    let scene = setup.scene;
    let mut list = Vec::new();
    let mut unless = |part: PlanChoice, needed: bool, what: &'static str, why: String| {
        if !needed && !setup.plan.puts_back(part) {
            list.push(LeftOut { what, why });
        }
    };
    let strategy = format!("{} draws no light samples", setup.strategy);
    let nothing = "no surface scatters".to_string();
    use PlanChoice::{CutOuts, Environment, Lens, Queues, Surfaces};
    unless(Environment, scene.environment.is_some(), "environment", "the scene names none".into());
    unless(Surfaces, scene.features.textures, "textures", "no material has one".into());
    for row in TABLE.iter().filter(|row| !row.absent.is_empty()) {
        unless(Queues, scene.features.kinds[row.kind], row.name, row.absent.into());
    }
    unless(Lens, setup.camera.lens.is_some(), "lens", "the camera is a pinhole".into());
    let why = "surfaces are shaded with their geometric normals".into();
    unless(Surfaces, scene.features.smooth_normals, "smooth normals", why);
    unless(CutOuts, scene.features.alpha_masks, "cut-outs", "no material is cut out".into());
    let why = "the box filter needs no weights".into();
    unless(Lens, setup.camera.filter != PixelFilter::Box, "pixel filter", why);
    let selects = setup.samples_lights() && setup.lights.count() > 1;
    let single = if setup.lights.count() == 1 { "there is one light" } else { "there is nothing to choose from" };
    let why = if setup.strategy.samples_lights() { single.to_string() } else { strategy.clone() };
    unless(PlanChoice::Lights, selects, "light selection", why);
    let why = if setup.strategy.samples_lights() { "the scene has no light".to_string() } else { strategy };
    // What follows is no work that a more general plan would do.
    unless(PlanChoice::Scene, setup.samples_lights(), "light sampling", why);
    let roulette = setup.rr_depth <= setup.max_depth;
    let why = if setup.rr_depth == u32::MAX { "it is switched off" } else { "paths end before it would start" };
    unless(PlanChoice::Scene, roulette, "roulette", why.into());
    unless(PlanChoice::Scene, scene.features.scatters(), "surface shading", nothing);
    list
}
