//! `octray info`: what a scene holds and needs, the plan, what was left out.

use crate::api::Scene;
use crate::camera;
use crate::cli::args::{EstimatorArgs, PlanArgs};
use crate::cli::examples;
use crate::cli::numbers::{count, three_digits};
use crate::cli::output::{JsonArgs, table};
use crate::cli::progress::load;
use crate::cli::{prepare, warn};
use crate::error::Result;
use crate::learn::outcome::Learning;
use crate::packet::explain::{self, LeftOut, PlannedStage};
use crate::packet::plan::Plan;
use crate::render::pilot::resolve;
use crate::settings::Settings;
use crate::simd::simd_level;
use crate::tables::PreparedScene;
use crate::tables::features::Features;
use crate::tables::lights::table::selection_name;
use serde::Serialize;
use std::path::PathBuf;

/// Flags of `octray info`.
#[derive(clap::Args)]
#[command(after_help = examples::INFO)]
pub struct InfoArgs {
    /// A scene file (.toml), a bare .obj, a .gltf or .glb, or builtin:NAME
    scene: PathBuf,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    plan: PlanArgs,
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
    /// Emissive triangles, delta lights, and one for an environment.
    lights: usize,
    /// Keys of a camera that moves; 0: it stands still.
    camera_keys: usize,
    /// The times of the first and the last, seconds.
    camera_seconds: [f64; 2],
    tables: Vec<Table>,
    strategy: &'static str,
    /// The strategy's expected image is wrong on purpose.
    biased: bool,
    /// The setting.
    light_selection: &'static str,
    /// What it comes to for these lights; `null`: the strategy draws no light samples, or there is no light.
    light_selection_used: Option<String>,
    /// What learning them came to and cost; `null`: nothing was to be learned.
    learning: Option<Learning>,
    /// The settings.
    guide: &'static str,
    roulette: &'static str,
    sampler: &'static str,
    /// `null`: unbounded.
    max_depth: Option<u32>,
    /// The first depth at which roulette may end a path; `null`: off.
    rr_depth: Option<u32>,
    seed: u32,
    /// Samples a pixel that a render takes unless told otherwise.
    spp: u32,
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
    let scene = load(&args.scene, false)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let mut settings = scene.settings();
    args.estimator.apply(&mut settings);
    settings.plan = args.plan.plan;
    let prepared = prepare(&scene)?;
    let of_view = camera::warnings(&scene.desc.camera, scene.desc.film.1);
    of_view.iter().for_each(|warning| warn(warning));
    let warnings = [&scene.desc.warnings[..], &prepared.warnings[..], &of_view[..]].concat();
    let info = gather(&scene, &prepared, &settings, warnings);
    args.json.deliver(&info, || text(&info))?;
    Ok(0)
}

fn gather(scene: &Scene, prepared: &PreparedScene, settings: &Settings, warnings: Vec<String>) -> Info {
    let setup = resolve(prepared, settings);
    let plan = Plan::new(&setup);
    let keys = scene.desc.camera_path.keys();
    // The lights' tables depend on strategy and selection; making them may make tables of the scene's.
    let learned = setup.guide.iter().flat_map(|guide| guide.tables());
    let tables = prepared.tables().into_iter().chain(setup.lights.tables()).chain(learned);
    Info {
        scene: prepared.name.clone(),
        features: prepared.features,
        triangles: prepared.triangles.len(),
        precise_triangles: prepared.bvh.precise_triangles().0,
        lights: prepared.emitters.len() + prepared.delta_lights.records.len() + prepared.environment.is_some() as usize,
        camera_keys: keys.len(),
        camera_seconds: [keys.first(), keys.last()].map(|key| key.map_or(0.0, |key| key.time)),
        film: setup.frame.film,
        tables: tables.map(|(name, bytes)| Table { name, bytes }).collect(),
        strategy: settings.strategy.name(),
        biased: settings.strategy.is_biased(),
        light_selection: settings.lights.name(),
        light_selection_used: setup.samples_lights().then(|| selection_name(&setup.lights)),
        learning: setup.learning.clone(),
        guide: settings.guide.name(),
        roulette: settings.roulette.name(),
        sampler: settings.sampler.name(),
        max_depth: settings.max_depth,
        rr_depth: settings.rr_depth,
        seed: settings.seed,
        spp: settings.spp,
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
        row("triangles", count(info.triangles as u64)),
        row("  tested in f64", count(info.precise_triangles as u64)),
        row("lights", count(info.lights as u64)),
        row("camera", camera_text(info.camera_keys, info.camera_seconds)),
        row("loaded in", format!("{} s", three_digits(info.load_s))),
        row("built in", format!("{} s", three_digits(info.build_s))),
        row("SIMD", info.simd.to_string()),
    ]);
    let depth = |depth: Option<u32>, none: &str| depth.map_or(none.to_owned(), |depth| depth.to_string());
    let biased = |name: &str| if info.biased { format!("{name} (biased)") } else { name.to_owned() };
    text += "\nsettings of a render\n";
    text += &table(&[
        row("strategy", biased(info.strategy)),
        row(
            "light selection",
            match &info.light_selection_used {
                Some(used) => format!("{} (here: {used})", info.light_selection),
                None => format!("{} (not used: no light is sampled)", info.light_selection),
            },
        ),
        row("guided directions", info.guide.to_string()),
        row("sampler", info.sampler.to_string()),
        row("max depth", depth(info.max_depth, "unbounded")),
        row(
            "roulette",
            info.rr_depth.map_or("off".to_owned(), |depth| format!("{}, from depth {depth} on", info.roulette)),
        ),
        row("seed", info.seed.to_string()),
        row("samples a pixel", info.spp.to_string()),
    ]);
    if let Some(learning) = &info.learning {
        text += "\nlearned\n";
        text += &table(&learned(learning).into_iter().map(|(left, right)| row(left, right)).collect::<Vec<_>>());
    }
    let total: usize = info.tables.iter().map(|table| table.bytes).sum();
    text += &format!("\ntables, {} in all\n", bytes(total));
    text += &table(&info.tables.iter().map(|table| row(table.name, bytes(table.bytes))).collect::<Vec<_>>());
    text += &format!("\nplan of {}, {} samples\n", info.strategy, info.sampler);
    text += &table(&info.plan.iter().map(|stage| row(stage.stage, stage.variant.clone())).collect::<Vec<_>>());
    text += "\nleft out\n";
    text += &table(&info.left_out.iter().map(|left| row(left.what, left.why.clone())).collect::<Vec<_>>());
    text
}

/// How the camera moves.
fn camera_text(keys: usize, [first, last]: [f64; 2]) -> String {
    match keys {
        0 => "stands still".to_owned(),
        _ => {
            format!("moves through {keys} key{} from {first} to {last} s (--frames)", if keys == 1 { "" } else { "s" })
        }
    }
}

/// What was learned of the lights, in words.
fn learned(learning: &Learning) -> Vec<(&'static str, String)> {
    let pilot = match learning.grid {
        Some((columns, rows)) => format!(
            "{} paths over {columns} x {rows} pixels in {} s; {} of tables",
            count(learning.paths),
            three_digits(learning.cpu_seconds),
            bytes(learning.bytes)
        ),
        None => "none".into(),
    };
    let used = |used: bool| if used { "used" } else { "not used" };
    let mut rows =
        vec![("training render", pilot), ("choice of lights", format!("{}: {}", used(learning.used), learning.why))];
    if let Some(environment) = &learning.environment {
        rows.push(("patches of the environment", format!("{}: {}", used(environment.used), environment.why)));
    }
    if let Some(guide) = &learning.guide {
        let leaves = format!("{} of {} leaves guided", count(guide.guided as u64), count(guide.leaves as u64));
        let tables = format!("{leaves}; {} of tables", bytes(guide.bytes));
        rows.push(("directions", format!("{}: {}; {tables}", used(guide.used), guide.why)));
    }
    rows
}

/// Bytes in the largest unit that keeps at least one digit before the point.
fn bytes(count: usize) -> String {
    match count {
        0..1024 => format!("{count} B"),
        1024..1_048_576 => format!("{:.1} KiB", count as f64 / 1024.0),
        _ => format!("{:.1} MiB", count as f64 / 1_048_576.0),
    }
}
