//! `octray bench`: throughput by kind of ray, of whole renders, of every stage, of light samples and of the samplers, the
//! engines side by side.
//!
//! The rays are real: those of the packet engine's queues while it renders the scene, or those of files. Every row's answers
//! are checked before anything is timed. Rounds are interleaved and medians kept.

mod lights;
mod measure;
mod rays;
mod sampling;
mod scaling;
mod walks;

use crate::cli::args;
use crate::cli::args::EstimatorArgs;
use crate::cli::examples;
use crate::cli::numbers::count;
use crate::cli::output::{JsonArgs, aligned, columns, wrapped};
use crate::cli::places;
use crate::cli::progress::load;
use crate::cli::stats::mrays_per_s;
use crate::cli::{prepare, report, warn};
use crate::error::Result;
use crate::render::render;
use crate::settings::{Engine, PlanChoice, Settings};
use crate::setup::frame::Frame;
use crate::simd::simd_level;
use crate::tables::PreparedScene;
use measure::{Case, MOST_COLUMNS, Row, interleave, number, rounds, share};
use rays::RaySet;
use std::path::{Path, PathBuf};
use walks::{Answers, Finder, Question, Yardstick};

/// Samples a pixel of whole renders: enough work for a steady figure, little enough for a short round.
const PACKET_SPP: u32 = 4;
const SCALAR_SPP: u32 = 1;

/// Flags of `octray bench`.
#[derive(clap::Args)]
#[command(after_help = examples::BENCH)]
pub struct BenchArgs {
    /// A scene file (.toml), a bare .obj, a .gltf or .glb, or builtin:NAME
    #[arg(default_value = "builtin:heavy")]
    scene: PathBuf,
    /// Rounds; each row is their median
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: u16,
    /// Columns and rows of the film
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = args::side, allow_negative_numbers = true)]
    size: u32,
    /// Rays to ask the scene about, and nothing else: a u64 count, then 8 f32 a ray (ox oy oz tmin dx dy dz tmax),
    /// little-endian; may be given several times
    #[arg(long, value_name = "FILE", conflicts_with_all = ["size", "scaling"])]
    rays: Vec<PathBuf>,
    #[command(flatten)]
    scaling: scaling::ScalingArgs,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    json: JsonArgs,
}

/// Runs the command; the exit status: 1 if two engines answer differently.
pub fn run(args: &BenchArgs) -> Result<u8> {
    args.json.check()?;
    if args.scaling.wanted(&args.estimator)? {
        return scaling::run(&args.scaling, (&args.scene, args.size, args.runs), &args.estimator, &args.json);
    }
    let mut of_files = places::reading(|| args.rays.iter().map(|path| of_file(path)).collect::<Result<Vec<RaySet>>>())?;
    let scene = load(&args.scene, false)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    // What is measured is the work of a path, not whether another would have been better.
    let mut settings = scene.settings().without_learning();
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
    of_files.iter_mut().for_each(|set| set.find_kind(&prepared.bvh));
    let (sets, of_files) = match of_files.is_empty() {
        true => (rays::record(&prepared, &settings), false),
        false => (of_files, true),
    };
    let yardstick = Yardstick::new(&prepared);
    let mut faults = Vec::new();
    let mut cases = ray_cases(&prepared, &sets, &yardstick, of_files, &mut faults);
    if !of_files {
        cases.extend(render_cases(&prepared, &settings, &mut faults));
        cases.extend(lights::cases(&prepared));
        cases.extend(sampling::cases(settings.seed, &mut faults));
    }
    let rows = interleave(args.runs as usize, &mut cases);
    args.json.deliver(&rows, || match of_files {
        true => text_of_files(&prepared, &rows),
        false => text(&prepared, &settings, &rows),
    })?;
    faults.iter().for_each(report);
    Ok(if faults.is_empty() { 0 } else { 1 })
}

/// The rays of a file; a warning of those that are none.
fn of_file(path: &Path) -> Result<RaySet> {
    let (set, broken) = rays::read_rays(path)?;
    if broken > 0 {
        let what = "hold what is not a finite number, or a direction of no length, and hit nothing";
        warn(&format!("{}: {} of {} rays {what}", path.display(), count(broken as u64), count(set.count() as u64)));
    }
    Ok(set)
}

/// Every kind of ray, both questions, every way to find the answer; with `sums` of the answers.
fn ray_cases<'a>(
    prepared: &'a PreparedScene,
    sets: &'a [RaySet],
    yardstick: &'a Yardstick,
    sums: bool,
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
            let sums = answers.sums(set).filter(|_| sums);
            let row = Row {
                what: what.clone(),
                engine: finder.name(),
                walk: finder.walk(set),
                clock: "cpu",
                items: set.count() as u64,
                hits: Some(answers.hits(set)),
                sum_id: sums.map(|sums| sums.0),
                sum_t: sums.map(|sums| sums.1),
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

/// Whole renders by both engines, the packet engine's stages with them, and by more general plans.
fn render_cases<'a>(prepared: &'a PreparedScene, settings: &Settings, faults: &mut Vec<String>) -> Vec<Case<'a>> {
    let by = |engine, spp| Settings { engine, spp, ..settings.clone() };
    let [packet, scalar] =
        [Engine::Packet, Engine::Scalar].map(|engine| render(prepared, &by(engine, SCALAR_SPP)).film.pixels);
    if packet != scalar {
        faults.push("render: the engines give different images; octray trace shows one path in both".into());
    }
    let engines = [(Engine::Packet, PACKET_SPP), (Engine::Scalar, SCALAR_SPP)];
    let case = |(engine, spp)| {
        let settings = by(engine, spp);
        Box::new(move || render_rows(prepared, &settings)) as Case<'a>
    };
    let mut cases: Vec<Case> = engines.map(case).into_iter().collect();
    for &plan in &PlanChoice::ALL[1..] {
        let settings = |spp| Settings { plan, ..by(Engine::Packet, spp) };
        if render(prepared, &settings(SCALAR_SPP)).film.pixels != packet {
            faults.push(format!("render: --plan {plan} gives another image"));
        }
        let settings = settings(PACKET_SPP);
        cases.push(Box::new(move || render_rows(prepared, &settings).drain(..1).collect()));
    }
    cases
}

/// What the rows of more general plans begin with.
const PLAN: &str = "render, plan ";

fn render_rows(prepared: &PreparedScene, settings: &Settings) -> Vec<Row> {
    let stats = render(prepared, settings).stats;
    let sum = |field: fn(&crate::render::StageStats) -> u64| stats.stages.iter().map(field).sum::<u64>();
    let engine = settings.engine.name();
    let whole = Row {
        what: match settings.plan {
            PlanChoice::Scene => "render".into(),
            plan => format!("{PLAN}{plan}"),
        },
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

/// How many rounds were measured, in words.
fn rounds_of(rows: &[Row]) -> String {
    rounds(rows.first().map_or(0, |row| row.runs))
}

/// Of rays of files.
fn text_of_files(prepared: &PreparedScene, rows: &[Row]) -> String {
    let room = columns().min(MOST_COLUMNS);
    let head = format!("{}, one thread, {}, {}", prepared.name, rounds_of(rows), simd_level());
    // The answers of the others are those of the engine to the last bit, or it is reported.
    let by = ["packet", "obvhs"];
    let closest = rows.iter().filter(|row| row.sum_id.is_some() && by.contains(&row.engine));
    let answers = closest.map(|row| {
        let ids = row.sum_id.map_or("-".to_owned(), count);
        let t = row.sum_t.map_or("-".to_owned(), |t| format!("{t:.9e}"));
        vec![row.what.clone(), row.engine.to_owned(), count(row.hits.unwrap_or(0) as u64), ids, t]
    });
    format!(
        "{}\n{}\n\nrays of files, Mrays/s of CPU time\n{}\nwhat they hit\n{}",
        wrapped(&head, room - 2, 2),
        wrapped(LEGEND, room - 2, 2),
        ray_table(rows, room),
        numbers_table(&["rays", "by", "hits", "sum of ids", "sum of t"], answers.collect()),
    )
}

fn text(prepared: &PreparedScene, settings: &Settings, rows: &[Row]) -> String {
    let (width, height) = (settings.width.unwrap_or(0), settings.height.unwrap_or(0));
    let head = format!(
        "{}, {width} x {height} pixels, {}, lights {}, {}, one thread, {}, {}",
        prepared.name,
        settings.strategy,
        settings.lights,
        settings.sampler,
        rounds_of(rows),
        simd_level(),
    );
    let lights = twin_table(rows, |row| !row.what.starts_with(sampling::WHAT));
    let lights = match lights.lines().count() {
        0 | 1 => "  the scene has no emissive triangle\n".to_owned(),
        _ => lights,
    };
    let room = columns().min(MOST_COLUMNS);
    let prose = |text: &str| wrapped(text, room - 2, 2);
    format!(
        "{}\n{}\n\n\
         rays from the engine's queues, Mrays/s of CPU time\n{}\n\
         whole renders, CPU time\n{}\n\
         what is left out, put back part by part (the same image): CPU time, that of the scene's own plan 1\n{}\n\
         stages of the packet engine, wall time\n{}\n\
         {}\n{lights}\n\
         four numbers of one address, CPU time in ns\n{}",
        prose(&head),
        prose(LEGEND),
        ray_table(rows, room),
        render_table(rows),
        plan_table(rows),
        stage_table(rows),
        prose("light samples for points anywhere on the scene, CPU time in ns; useful: lanes whose sample counts"),
        twin_table(rows, |row| row.what.starts_with(sampling::WHAT)),
    )
}

/// What the columns of the tables mean.
const LEGEND: &str = "\
lanes that held work are told apart: `stages` in the loops over queues, `walks` in packets on their way through the tree; \
`walked by` is the first way through it, and that of rays that part; obvhs answers `differ` rays otherwise";

fn per_cent(share: Option<f64>) -> String {
    share.map_or("-".to_owned(), |share| format!("{:.0} %", share * 100.0))
}

/// A heading and rows: the first column to the left, numbers to the right.
fn numbers_table(heading: &[&str], mut rows: Vec<Vec<String>>) -> String {
    rows.insert(0, heading.iter().map(|&word| word.to_owned()).collect());
    rows.iter_mut().for_each(|row| row[0] = format!("  {}", row[0]));
    aligned(&rows, &(1..heading.len()).collect::<Vec<_>>())
}

/// One line a kind of ray and question, the finders side by side, in so many columns.
fn ray_table(rows: &[Row], room: usize) -> String {
    let mut lines = Vec::new();
    let rows: Vec<&Row> = rows.iter().filter(|row| row.hits.is_some()).collect();
    for finders in rows.chunk_by(|a, b| a.what == b.what) {
        let speed = |name: &str| number(finders.iter().find(|row| row.engine == name).and_then(|row| row.mrays_per_s));
        let [packet, .., obvhs] = finders else { continue };
        let hit = packet.hits.and_then(|hits| share(hits as u64, packet.items));
        lines.push(vec![
            packet.what.clone(),
            count(packet.items),
            per_cent(hit),
            speed("packet"),
            packet.walk.clone().unwrap_or_default().replace(", else ", "/"),
            per_cent(packet.lanes_used),
            speed("one ray"),
            speed("scalar"),
            speed("obvhs"),
            count(obvhs.differ.unwrap_or(0) as u64),
        ]);
    }
    let mut heading =
        vec!["rays", "count", "hit", "packet", "walked by", "walks", "one ray", "scalar", "obvhs", "differ"];
    // Where there is no room, what is least asked for goes.
    for column in [1, 1] {
        let table = numbers_table(&heading, lines.clone());
        if table.lines().all(|line| line.chars().count() <= room) {
            return table;
        }
        heading.remove(column);
        lines.iter_mut().for_each(|line| drop(line.remove(column)));
    }
    numbers_table(&heading, lines)
}

fn render_table(rows: &[Row]) -> String {
    let rows = rows.iter().filter(|row| row.mpaths_per_s.is_some() && !row.what.starts_with(PLAN)).map(|row| {
        vec![row.engine.to_owned(), number(row.mpaths_per_s), number(row.mrays_per_s), per_cent(row.lanes_used)]
    });
    numbers_table(&["engine", "Mpaths/s", "Mrays/s", "stages"], rows.collect())
}

/// More general plans, their times over that of the scene's own.
fn plan_table(rows: &[Row]) -> String {
    let own = rows.iter().find(|row| row.what == "render").and_then(|row| row.mpaths_per_s);
    let plans = rows.iter().filter_map(|row| Some((row.what.strip_prefix(PLAN)?, row.mpaths_per_s?)));
    let lines = plans.map(|(plan, mpaths)| vec![plan.to_owned(), number(own.map(|own| own / mpaths))]);
    numbers_table(&["put back", "time"], lines.collect())
}

fn stage_table(rows: &[Row]) -> String {
    let stages = rows.iter().filter(|row| row.ns_per_item.is_some() && row.clock == "wall").map(|row| {
        let [stages, walks] = [row.lanes_used, row.walk_lanes_used].map(per_cent);
        vec![row.what.clone(), number(row.ns_per_item), count(row.items), stages, walks]
    });
    numbers_table(&["stage", "ns/item", "items", "stages", "walks"], stages.collect())
}

/// One line a way to sample, the engines side by side.
fn twin_table(rows: &[Row], keep: impl Fn(&Row) -> bool) -> String {
    let timed = |row: &&Row| row.ns_per_item.is_some() && row.clock == "cpu" && keep(row);
    let rows: Vec<&Row> = rows.iter().filter(timed).collect();
    let mut lines = Vec::new();
    for engines in rows.chunk_by(|a, b| a.what == b.what) {
        let [packet, scalar] = engines else { continue };
        let figures = [number(packet.ns_per_item), number(scalar.ns_per_item), per_cent(packet.lanes_used)];
        lines.push([vec![packet.what.clone()], figures.to_vec()].concat());
    }
    numbers_table(&["what", "packet", "scalar", "useful"], lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_fit_a_hundred_columns() {
        let finder = |engine| Row {
            what: "bounce 1 closest".into(),
            engine,
            walk: Some("one ray, else stream".into()),
            mrays_per_s: Some(123.456),
            lanes_used: Some(1.0),
            items: 16_777_216,
            hits: Some(16_777_216),
            differ: Some(12_345),
            ..Row::default()
        };
        let mut rows = ["packet", "one ray", "scalar", "obvhs"].map(finder).to_vec();
        rows.push(Row {
            what: "generate_camera_rays".into(),
            ns_per_item: Some(12345.6),
            clock: "wall",
            items: 123_456_789,
            walk_lanes_used: Some(0.5),
            ..Row::default()
        });
        let tables = [(ray_table(&rows, 100), 100), (ray_table(&rows, 85), 85), (stage_table(&rows), 80)];
        for (table, columns) in &tables {
            assert!(table.lines().count() == 2 && table.lines().all(|line| line.len() <= *columns), "{table}");
        }
        assert!(tables[0].0.contains(" 123  one ray/stream ") && tables[0].0.contains("16,777,216"), "{}", tables[0].0);
    }
}
