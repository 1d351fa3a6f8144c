//! `octray bench`: throughput of the engines, side by side.
//!
//! Rounds are interleaved (every case once, then every case again), so that a machine that slows down slows all cases, and
//! the median of the rounds is kept. Time is CPU time: other programs on the cores do not count.

use super::args::EstimatorArgs;
use super::output::{JsonArgs, table};
use super::stats::mrays_per_s;
use super::warn;
use crate::error::Result;
use crate::lanes::simd_level;
use crate::render::render;
use crate::scene::{PreparedScene, Scene};
use crate::settings::{Engine, Settings};
use serde::Serialize;
use std::path::PathBuf;

/// Flags of `octray bench`.
#[derive(clap::Args)]
pub struct BenchArgs {
    /// A scene file (.toml), a bare .obj, or builtin:NAME
    #[arg(default_value = "builtin:heavy")]
    scene: PathBuf,
    /// Rounds; each row is their median
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: u16,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    json: JsonArgs,
}

/// One figure of one round.
struct Figure {
    what: String,
    engine: &'static str,
    speed: Speed,
    /// Lanes that held work by lanes that could have; `None` where there are no lanes.
    lanes_used: Option<f64>,
}

/// How a figure is stated.
#[derive(Clone, Copy)]
enum Speed {
    /// Millions of rays by CPU second.
    MraysPerSecond(f64),
    /// Nanoseconds of one thread for one item.
    NsPerItem(f64),
}

/// The median of a figure over all rounds.
#[derive(Serialize)]
struct Row {
    what: String,
    engine: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    mrays_per_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ns_per_item: Option<f64>,
    lanes_used: Option<f64>,
    runs: usize,
}

/// Something to measure: each call is one round and gives the same figures in the same order.
type Case<'a> = Box<dyn FnMut() -> Vec<Figure> + 'a>;

/// Runs the command; the exit status.
pub fn run(args: &BenchArgs) -> Result<u8> {
    args.json.check()?;
    let scene = Scene::load(&args.scene)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let mut settings = scene.settings();
    args.estimator.apply(&mut settings);
    let prepared = scene.prepare()?;
    let rows = interleave(args.runs as usize, &mut cases(&prepared, &settings));
    args.json.deliver(&rows, || text(&prepared, &rows))?;
    Ok(0)
}

/// Whole renders by both engines; the packet engine's stages with them.
fn cases<'a>(prepared: &'a PreparedScene, settings: &Settings) -> Vec<Case<'a>> {
    let engines = [(Engine::Packet, 4), (Engine::Scalar, 1)];
    let case = |(engine, spp)| {
        let settings = Settings {
            spp,
            engine,
            threads: 1,
            width: Some(256),
            height: Some(256),
            crop: None,
            time: None,
            ..settings.clone()
        };
        Box::new(move || render_figures(prepared, &settings)) as Case<'a>
    };
    engines.map(case).into_iter().collect()
}

fn render_figures(prepared: &PreparedScene, settings: &Settings) -> Vec<Figure> {
    let stats = render(prepared, settings).stats;
    let share = |used: u64, possible: u64| (possible > 0).then(|| used as f64 / possible as f64);
    let sum = |field: fn(&crate::render::StageStats) -> u64| stats.stages.iter().map(field).sum::<u64>();
    let engine = settings.engine.name();
    let whole = Figure {
        what: "render".into(),
        engine,
        speed: Speed::MraysPerSecond(mrays_per_s(&stats.rays, stats.cpu_s)),
        lanes_used: share(sum(|stage| stage.lanes_used), sum(|stage| stage.lanes_possible)),
    };
    let stages = stats.stages.iter().map(|stage| Figure {
        what: stage.stage.into(),
        engine,
        speed: Speed::NsPerItem(stage.seconds * 1e9 / stage.lanes_used.max(1) as f64),
        lanes_used: share(stage.lanes_used, stage.lanes_possible),
    });
    std::iter::once(whole).chain(stages).collect()
}

/// Runs every case `runs` times, in turn, and keeps medians.
fn interleave(runs: usize, cases: &mut [Case]) -> Vec<Row> {
    let mut rounds: Vec<Vec<Figure>> = Vec::new();
    for _ in 0..runs {
        rounds.push(cases.iter_mut().flat_map(|case| case()).collect());
    }
    let Some(first) = rounds.first() else { return Vec::new() };
    let row = |(index, figure): (usize, &Figure)| {
        let speeds = rounds.iter().filter_map(|round| round.get(index)).map(|figure| figure.speed);
        let (rates, times): (Vec<_>, Vec<_>) = speeds.partition(|speed| matches!(speed, Speed::MraysPerSecond(_)));
        Row {
            what: figure.what.clone(),
            engine: figure.engine,
            mrays_per_s: median(rates),
            ns_per_item: median(times),
            lanes_used: figure.lanes_used,
            runs,
        }
    };
    first.iter().enumerate().map(row).collect()
}

fn median(speeds: Vec<Speed>) -> Option<f64> {
    let mut values: Vec<f64> =
        speeds.into_iter().map(|(Speed::MraysPerSecond(value) | Speed::NsPerItem(value))| value).collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n % 2 == 0 => Some(0.5 * (values[middle - 1] + values[middle])),
        _ => Some(values[middle]),
    }
}

fn text(prepared: &PreparedScene, rows: &[Row]) -> String {
    let mut lines = vec![["what", "engine", "Mrays/s", "ns/item", "lanes used", "runs"].map(str::to_owned).to_vec()];
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    for row in rows {
        lines.push(vec![
            row.what.clone(),
            row.engine.to_owned(),
            number(row.mrays_per_s),
            number(row.ns_per_item),
            row.lanes_used.map_or("-".to_owned(), |share| format!("{:.1} %", share * 100.0)),
            row.runs.to_string(),
        ]);
    }
    format!("{}, one thread, CPU time, {}\n{}", prepared.name, simd_level(), table(&lines))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_take_turns_and_medians_are_kept() {
        let log = std::cell::RefCell::new(String::new());
        let case = |name: &'static str, values: [f64; 3]| {
            let (log, mut values) = (&log, values.into_iter());
            Box::new(move || {
                *log.borrow_mut() += name;
                let speed = Speed::NsPerItem(values.next().unwrap_or(0.0));
                vec![Figure { what: name.into(), engine: "packet", speed, lanes_used: Some(1.0) }]
            }) as Case
        };
        let rows = interleave(3, &mut [case("a", [5.0, 1.0, 2.0]), case("b", [0.0, 9.0, 8.0])]);
        assert_eq!(*log.borrow(), "ababab");
        assert_eq!((rows[0].ns_per_item, rows[1].ns_per_item), (Some(2.0), Some(8.0)));
        assert_eq!((rows[0].mrays_per_s, rows[0].runs), (None, 3));
        assert_eq!(median(vec![Speed::NsPerItem(1.0), Speed::NsPerItem(2.0)]), Some(1.5));
    }
}
