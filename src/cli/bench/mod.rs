//! `octray bench`: throughput by kind of ray, of whole renders, of every stage, of light samples and of the samplers, the
//! engines side by side.
//!
//! The rays are real: those of the packet engine's queues while it renders the scene. Every row's answers are checked
//! before anything is timed. Rounds are interleaved and medians kept.

mod lights;
mod measure;
mod rays;
mod sampling;
mod walks;

use crate::api::Scene;
use crate::cli::args;
use crate::cli::args::EstimatorArgs;
use crate::cli::output::{JsonArgs, table};
use crate::cli::stats::mrays_per_s;
use crate::cli::{prepare, report, warn};
use crate::error::Result;
use crate::lanes::simd_level;
use crate::render::render;
use crate::settings::{Engine, Settings};
use crate::setup::frame::Frame;
use crate::tables::PreparedScene;
use measure::{Case, Row, interleave, share};
use rays::RaySet;
use std::path::PathBuf;
use walks::{Answers, Finder, Question, Yardstick};

/// Samples a pixel of whole renders: enough work for a steady figure, little enough for a short round.
const PACKET_SPP: u32 = 4;
const SCALAR_SPP: u32 = 1;

/// Flags of `octray bench`.
#[derive(clap::Args)]
pub struct BenchArgs {
    /// A scene file (.toml), a bare .obj, or builtin:NAME
    #[arg(default_value = "builtin:heavy")]
    scene: PathBuf,
    /// Rounds; each row is their median
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: u16,
    /// Columns and rows of the film
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = args::side, allow_negative_numbers = true)]
    size: u32,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    json: JsonArgs,
}

/// Runs the command; the exit status: 1 if two engines answer differently.
pub fn run(args: &BenchArgs) -> Result<u8> {
    args.json.check()?;
    let scene = Scene::load(&args.scene)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let mut settings = scene.settings();
    args.estimator.apply(&mut settings);
    let settings = Settings {
        spp: SCALAR_SPP,
        threads: 1,
        width: Some(args.size),
        height: Some(args.size),
        crop: None,
        time: None,
        ..settings
    };
    Frame::new(&settings, scene.desc.film)?;
    let prepared = prepare(&scene)?;
    let sets = rays::record(&prepared, &settings);
    let yardstick = Yardstick::new(&prepared);
    let mut faults = Vec::new();
    let mut cases = ray_cases(&prepared, &sets, &yardstick, &mut faults);
    cases.extend(render_cases(&prepared, &settings, &mut faults));
    cases.extend(lights::cases(&prepared));
    cases.extend(sampling::cases(settings.seed, &mut faults));
    let rows = interleave(args.runs as usize, &mut cases);
    args.json.deliver(&rows, || text(&prepared, &settings, &rows))?;
    faults.iter().for_each(report);
    Ok(if faults.is_empty() { 0 } else { 1 })
}

/// Every kind of ray, both questions, every way to find the answer.
fn ray_cases<'a>(
    prepared: &'a PreparedScene,
    sets: &'a [RaySet],
    yardstick: &'a Yardstick,
    faults: &mut Vec<String>,
) -> Vec<Case<'a>> {
    let bvh = &prepared.bvh;
    let mut cases = Vec::new();
    for (set, question) in sets.iter().flat_map(|set| Question::ALL.map(|question| (set, question))) {
        let what = format!("{} {}", set.name, question.name());
        let [mut engine, ..] = Finder::all(bvh, yardstick);
        let mut wanted = Answers::new(set, question);
        engine.run(set, question, &mut wanted);
        for mut finder in Finder::all(bvh, yardstick) {
            let mut answers = Answers::new(set, question);
            finder.run(set, question, &mut answers);
            let differ = answers.differences(&wanted, set, finder.is_exact());
            if finder.is_exact() && differ > 0 {
                faults.push(format!("{what}: `{}` answers {differ} rays otherwise than the engine", finder.name()));
            }
            let row = Row {
                what: what.clone(),
                engine: finder.name(),
                walk: finder.walk(set),
                clock: "cpu",
                items: set.count() as u64,
                hits: Some(answers.hits(set)),
                differ: Some(differ),
                ..Row::default()
            };
            cases.push(Box::new(move || {
                let (seconds, counters) = finder.run(set, question, &mut answers);
                let mrays_per_s = Some(row.items as f64 / seconds.max(1e-9) * 1e-6);
                let lanes_used = share(counters.lanes_used, counters.lanes_possible);
                vec![Row { mrays_per_s, lanes_used, ..row.clone() }]
            }) as Case);
        }
    }
    cases
}

/// Whole renders by both engines; the packet engine's stages with them.
fn render_cases<'a>(prepared: &'a PreparedScene, settings: &Settings, faults: &mut Vec<String>) -> Vec<Case<'a>> {
    let by = |engine, spp| Settings { engine, spp, ..settings.clone() };
    let [packet, scalar] =
        [Engine::Packet, Engine::Scalar].map(|engine| render(prepared, &by(engine, SCALAR_SPP)).film.pixels);
    if packet != scalar {
        faults.push("render: the engines give different pictures; octray trace shows one path in both".into());
    }
    let engines = [(Engine::Packet, PACKET_SPP), (Engine::Scalar, SCALAR_SPP)];
    let case = |(engine, spp)| {
        let settings = by(engine, spp);
        Box::new(move || render_rows(prepared, &settings)) as Case<'a>
    };
    engines.map(case).into_iter().collect()
}

fn render_rows(prepared: &PreparedScene, settings: &Settings) -> Vec<Row> {
    let stats = render(prepared, settings).stats;
    let sum = |field: fn(&crate::render::StageStats) -> u64| stats.stages.iter().map(field).sum::<u64>();
    let engine = settings.engine.name();
    let whole = Row {
        what: "render".into(),
        engine,
        mrays_per_s: Some(mrays_per_s(&stats.rays, stats.cpu_s)),
        mpaths_per_s: Some(stats.paths as f64 / stats.cpu_s.max(1e-9) * 1e-6),
        clock: "cpu",
        items: stats.paths,
        lanes_used: share(sum(|stage| stage.lanes_used), sum(|stage| stage.lanes_possible)),
        ..Row::default()
    };
    let stages = stats.stages.iter().map(|stage| Row {
        what: stage.stage.into(),
        engine,
        ns_per_item: Some(stage.seconds * 1e9 / stage.lanes_used.max(1) as f64),
        // A stage runs for microseconds: reading the thread's CPU clock would cost more than some of them.
        clock: "wall",
        items: stage.lanes_used,
        lanes_used: share(stage.lanes_used, stage.lanes_possible),
        walk_lanes_used: share(stage.walk_lanes_used.unwrap_or(0), stage.walk_lanes_possible.unwrap_or(0)),
        ..Row::default()
    });
    std::iter::once(whole).chain(stages).collect()
}

fn text(prepared: &PreparedScene, settings: &Settings, rows: &[Row]) -> String {
    let runs = rows.first().map_or(0, |row| row.runs);
    let (width, height) = (settings.width.unwrap_or(0), settings.height.unwrap_or(0));
    format!(
        "{}, {}, {width} x {height} pixels, {}, one thread, medians of {runs} round{}\n\n\
         rays from the engine's queues, Mrays/s of CPU time\n{}\n\
         whole renders, CPU time\n{}\n\
         stages of the packet engine, wall time\n{}\n\
         light samples for points anywhere on the scene, CPU time\n{}\n\
         four numbers of one address, CPU time\n{}",
        prepared.name,
        simd_level(),
        settings.strategy,
        if runs == 1 { "" } else { "s" },
        ray_table(rows),
        render_table(rows),
        stage_table(rows),
        twin_table(rows, |row| !row.what.starts_with(sampling::WHAT)),
        twin_table(rows, |row| row.what.starts_with(sampling::WHAT)),
    )
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.2}"))
}

fn percent(share: Option<f64>) -> String {
    share.map_or("-".to_owned(), |share| format!("{:.1} %", share * 100.0))
}

/// One line a kind of ray and question, the finders side by side.
fn ray_table(rows: &[Row]) -> String {
    let heading =
        ["  rays", "count", "hit", "packet", "by", "lanes used", "one ray", "scalar", "obvhs", "obvhs differs on"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    let rows: Vec<&Row> = rows.iter().filter(|row| row.hits.is_some()).collect();
    for finders in rows.chunk_by(|a, b| a.what == b.what) {
        let speed = |name: &str| number(finders.iter().find(|row| row.engine == name).and_then(|row| row.mrays_per_s));
        let [packet, .., obvhs] = finders else { continue };
        let hit = packet.hits.and_then(|hits| share(hits as u64, packet.items));
        lines.push(vec![
            format!("  {}", packet.what),
            packet.items.to_string(),
            percent(hit),
            speed("packet"),
            packet.walk.clone().unwrap_or_default(),
            percent(packet.lanes_used),
            speed("one ray"),
            speed("scalar"),
            speed("obvhs"),
            format!("{} rays", obvhs.differ.unwrap_or(0)),
        ]);
    }
    table(&lines)
}

fn render_table(rows: &[Row]) -> String {
    let mut lines = vec![["  engine", "Mpaths/s", "Mrays/s", "lanes used"].map(str::to_owned).to_vec()];
    for row in rows.iter().filter(|row| row.mpaths_per_s.is_some()) {
        let engine = format!("  {}", row.engine);
        lines.push(vec![engine, number(row.mpaths_per_s), number(row.mrays_per_s), percent(row.lanes_used)]);
    }
    table(&lines)
}

fn stage_table(rows: &[Row]) -> String {
    let mut lines =
        vec![["  stage", "ns/item", "items", "lanes used", "in the tree's packets"].map(str::to_owned).to_vec()];
    for row in rows.iter().filter(|row| row.ns_per_item.is_some() && row.clock == "wall") {
        let what = format!("  {}", row.what);
        let lanes = [row.lanes_used, row.walk_lanes_used].map(percent);
        lines.push([vec![what, number(row.ns_per_item), row.items.to_string()], lanes.to_vec()].concat());
    }
    table(&lines)
}

/// One line a way to sample, the engines side by side.
fn twin_table(rows: &[Row], keep: impl Fn(&Row) -> bool) -> String {
    let mut lines = vec![["  what", "packet ns", "scalar ns", "lanes used"].map(str::to_owned).to_vec()];
    let timed = |row: &&Row| row.ns_per_item.is_some() && row.clock == "cpu" && keep(row);
    let rows: Vec<&Row> = rows.iter().filter(timed).collect();
    for engines in rows.chunk_by(|a, b| a.what == b.what) {
        let [packet, scalar] = engines else { continue };
        let figures = [number(packet.ns_per_item), number(scalar.ns_per_item), percent(packet.lanes_used)];
        lines.push([vec![format!("  {}", packet.what)], figures.to_vec()].concat());
    }
    table(&lines)
}
