//! `octray info`: what a scene holds and needs, the plan, what was left out.

use crate::api::Scene;
use crate::camera;
use crate::cli::args::EstimatorArgs;
use crate::cli::output::{JsonArgs, table};
use crate::cli::{prepare, warn};
use crate::error::Result;
use crate::lanes::simd_level;
use crate::packet::explain::{self, LeftOut, PlannedStage};
use crate::packet::plan::Plan;
use crate::settings::Settings;
use crate::setup::Setup;
use crate::tables::PreparedScene;
use crate::tables::features::Features;
use serde::Serialize;
use std::path::PathBuf;

/// Flags of `octray info`.
#[derive(clap::Args)]
pub struct InfoArgs {
    /// A scene file (.toml), a bare .obj, or builtin:NAME
    scene: PathBuf,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    json: JsonArgs,
}

/// One table of the prepared scene.
#[derive(Serialize)]
struct Table {
    name: &'static str,
    bytes: usize,
}

/// Everything the command prints.
#[derive(Serialize)]
struct Info {
    scene: String,
    features: Features,
    /// Columns and rows.
    film: (u32, u32),
    triangles: usize,
    /// Triangles too thin, or too large beside what lies on them, for f32: rays meet them in f64.
    precise_triangles: usize,
    /// Emissive triangles, and one for an environment.
    lights: usize,
    tables: Vec<Table>,
    strategy: &'static str,
    sampler: &'static str,
    plan: Vec<PlannedStage>,
    left_out: Vec<LeftOut>,
    simd: &'static str,
    load_s: f64,
    build_s: f64,
    warnings: Vec<String>,
}

/// Runs the command; the exit status.
pub fn run(args: &InfoArgs) -> Result<u8> {
    args.json.check()?;
    let scene = Scene::load(&args.scene)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let mut settings = scene.settings();
    args.estimator.apply(&mut settings);
    let prepared = prepare(&scene)?;
    let of_view = camera::warnings(&scene.desc.camera, scene.desc.film.1);
    of_view.iter().for_each(|warning| warn(warning));
    let warnings = [&scene.desc.warnings[..], &prepared.warnings[..], &of_view[..]].concat();
    let info = gather(&prepared, &settings, warnings);
    args.json.deliver(&info, || text(&info))?;
    Ok(0)
}

fn gather(prepared: &PreparedScene, settings: &Settings, warnings: Vec<String>) -> Info {
    let setup = Setup::new(prepared, settings);
    let plan = Plan::new(&setup);
    // The lights' tables depend on strategy and selection; making them may make tables of the scene's.
    let tables = prepared.tables().into_iter().chain(setup.lights.tables());
    Info {
        scene: prepared.name.clone(),
        features: prepared.features,
        triangles: prepared.triangles.len(),
        precise_triangles: prepared.bvh.precise_triangles().0,
        lights: prepared.emitters.len() + prepared.environment.is_some() as usize,
        film: setup.frame.film,
        tables: tables.map(|(name, bytes)| Table { name, bytes }).collect(),
        strategy: settings.strategy.name(),
        sampler: settings.sampler.name(),
        plan: explain::stages(&setup, &plan),
        left_out: explain::left_out(&setup),
        simd: simd_level(),
        load_s: prepared.load_s,
        build_s: prepared.build_s,
        warnings,
    }
}

fn text(info: &Info) -> String {
    let row = |left: &str, right: String| vec![format!("  {left}"), right];
    let mut text = format!("{}\n", info.scene);
    text += &table(&[
        row("film", format!("{} x {} pixels", info.film.0, info.film.1)),
        row("triangles", info.triangles.to_string()),
        row("  tested in f64", info.precise_triangles.to_string()),
        row("lights", info.lights.to_string()),
        row("loaded in", format!("{:.3} s", info.load_s)),
        row("built in", format!("{:.3} s", info.build_s)),
        row("SIMD", info.simd.to_string()),
    ]);
    let total: usize = info.tables.iter().map(|table| table.bytes).sum();
    text += &format!("\ntables, {} in all\n", bytes(total));
    text += &table(&info.tables.iter().map(|table| row(table.name, bytes(table.bytes))).collect::<Vec<_>>());
    text += &format!("\nplan of {}, {} samples\n", info.strategy, info.sampler);
    text += &table(&info.plan.iter().map(|stage| row(stage.stage, stage.variant.clone())).collect::<Vec<_>>());
    text += "\nleft out\n";
    text += &table(&info.left_out.iter().map(|left| row(left.what, left.why.clone())).collect::<Vec<_>>());
    text
}

/// Bytes in the largest unit that keeps at least one digit before the point.
fn bytes(count: usize) -> String {
    match count {
        0..1024 => format!("{count} B"),
        1024..1_048_576 => format!("{:.1} KiB", count as f64 / 1024.0),
        _ => format!("{:.1} MiB", count as f64 / 1_048_576.0),
    }
}
