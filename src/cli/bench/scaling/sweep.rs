//! One sweep: renders that differ in one size, timed in turn.

use crate::cli::bench::measure::median;
use crate::cli::stats::mrays_per_s;
use crate::render::{Render, Stats, render};
use crate::settings::Settings;
use crate::tables::PreparedScene;
use serde::Serialize;

/// What is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Swept {
    /// Triangles of a scene made in code.
    Triangles,
    /// Lamps of a scene made in code.
    Lights,
    /// Most scattering events of a path.
    Bounces,
    /// Pixels of the film.
    Pixels,
    /// Worker threads.
    Threads,
}

impl Swept {
    /// All, in the order in which they are measured.
    pub const ALL: [Swept; 5] = [Swept::Triangles, Swept::Lights, Swept::Bounces, Swept::Pixels, Swept::Threads];

    /// The word used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Swept::Triangles => "triangles",
            Swept::Lights => "lights",
            Swept::Bounces => "bounces",
            Swept::Pixels => "pixels",
            Swept::Threads => "threads",
        }
    }

    /// Whether every size is a scene of its own, which has to be prepared.
    pub fn is_of_scenes(self) -> bool {
        matches!(self, Swept::Triangles | Swept::Lights)
    }
}

/// One line of the result: medians over the rounds.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What was varied.
    pub what: Swept,
    /// How much of it there was.
    pub size: u64,
    /// The scene rendered.
    pub scene: String,
    /// Columns and rows of the film.
    pub film: [u32; 2],
    /// Samples a pixel.
    pub spp: u32,
    /// Worker threads.
    pub threads: usize,
    /// Paths of one render.
    pub paths: u64,
    /// Millions of paths a second of CPU time.
    pub mpaths_per_s: f64,
    /// Millions of rays a second of CPU time.
    pub mrays_per_s: f64,
    /// Nanoseconds of CPU time a path.
    pub ns_per_path: f64,
    /// CPU seconds of one render, all threads.
    pub cpu_s: f64,
    /// Wall seconds of one render.
    pub wall_s: f64,
    /// The exponent of the growth of `ns_per_path` with `size` since the row before; `null` in the first.
    pub growth: Option<f64>,
    /// Where every size is a scene: wall seconds of making its trees and tables, once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prepare_s: Option<f64>,
    /// The exponent of its growth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prepare_growth: Option<f64>,
    /// Of threads: wall seconds of one thread over these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_up: Option<f64>,
    /// Of threads: CPU seconds over those of one thread.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu_ratio: Option<f64>,
    /// [`Stats::tiles`] of one render.
    pub tiles: u64,
    /// [`Stats::shared_operations`] of one render.
    pub shared_operations: u64,
    /// The one by the other.
    pub operations_per_tile: f64,
    /// Rounds.
    pub runs: usize,
}

/// The exponent of growth: of time as size^e, where `before` and `after` are (size, time); `None` if it has none.
pub fn exponent(before: (f64, f64), after: (f64, f64)) -> Option<f64> {
    let exponent = (after.1 / before.1).ln() / (after.0 / before.0).ln();
    exponent.is_finite().then_some(exponent)
}

/// The exponent of the time of a path from the first of `rows` to the last.
pub fn overall(rows: &[Row]) -> Option<f64> {
    let [first, .., last] = rows else { return None };
    exponent((first.size as f64, first.ns_per_path), (last.size as f64, last.ns_per_path))
}

/// A render to be timed.
pub struct Case<'a> {
    /// How much there is of what is swept.
    size: u64,
    scene: &'a PreparedScene,
    settings: Settings,
    prepare_s: f64,
}

/// Most samples a pixel of a timed render.
const MOST_SPP: u32 = 1 << 16;
/// A render of less than this share of the wanted time says too little about longer ones.
const LEAST_SHARE: f64 = 1.0 / 8.0;

impl<'a> Case<'a> {
    /// With as many samples a pixel, a power of two, as take about so many seconds of CPU time.
    pub fn of_seconds(size: u64, scene: &'a PreparedScene, settings: Settings, seconds: f64) -> Case<'a> {
        let tried = |spp: u32| render(scene, &Settings { spp, ..settings.clone() }).stats;
        let mut spp = 1;
        let mut stats = tried(spp);
        // The light tree is made for the first render that asks for it.
        let prepare_s = scene.build_s + stats.setup_s;
        while stats.cpu_s < LEAST_SHARE * seconds && spp < MOST_SPP {
            spp *= 4;
            stats = tried(spp);
        }
        let spp = power_of_two(f64::from(spp) * seconds / stats.cpu_s.max(1e-9), MOST_SPP);
        Case { size, scene, settings: Settings { spp, ..settings }, prepare_s }
    }

    /// All with the same samples a pixel, those of the middle one of them: so that nothing differs but what is swept.
    pub fn alike(mut cases: Vec<Case<'a>>) -> Vec<Case<'a>> {
        let mut samples: Vec<u32> = cases.iter().map(|case| case.settings.spp).collect();
        samples.sort_unstable();
        let middle = samples.get(samples.len() / 2).copied().unwrap_or(1);
        cases.iter_mut().for_each(|case| case.settings.spp = middle);
        cases
    }

    /// The same render by so many threads, which are what is swept.
    pub fn with_threads(&self, threads: usize) -> Case<'a> {
        let settings = Settings { threads, ..self.settings.clone() };
        Case { size: threads as u64, settings, ..*self }
    }
}

/// The power of two nearest to `value`, from 1 to `most`.
fn power_of_two(value: f64, most: u32) -> u32 {
    1 << value.max(1.0).log2().round().min(f64::from(most.ilog2())) as u32
}

/// Renders every case `runs` times, in turn, and keeps medians. What went wrong is told in `faults`.
pub fn measure(what: Swept, cases: &[Case], runs: usize, faults: &mut Vec<String>) -> Vec<Row> {
    let mut measured: Vec<Vec<Stats>> = cases.iter().map(|_| Vec::new()).collect();
    let mut of_one_thread = None;
    for _ in 0..runs {
        for (case, measured) in cases.iter().zip(&mut measured) {
            let Render { film, stats } = render(case.scene, &case.settings);
            measured.push(stats);
            if what == Swept::Threads && *of_one_thread.get_or_insert_with(|| film.pixels.clone()) != film.pixels {
                faults.push(format!("{} threads give another image than one", case.size));
            }
        }
    }
    faults.sort_unstable();
    faults.dedup();
    let mut rows: Vec<Row> = cases.iter().zip(&measured).filter_map(|(case, stats)| row(what, case, stats)).collect();
    // Films of few tiles are rendered by fewer threads than were asked for.
    rows.retain(|row| what != Swept::Threads || row.threads as u64 == row.size);
    compare(&mut rows);
    rows
}

/// The row of a case that was rendered at least once.
fn row(what: Swept, case: &Case, measured: &[Stats]) -> Option<Row> {
    let last = measured.last()?;
    let median_of = |figure: fn(&Stats) -> f64| median(measured.iter().map(figure).collect()).map(|s| s.max(1e-9));
    let (cpu_s, wall_s) = (median_of(|stats| stats.cpu_s)?, median_of(|stats| stats.render_s)?);
    Some(Row {
        what,
        size: case.size,
        scene: case.scene.name.clone(),
        film: [case.settings.width.unwrap_or(0), case.settings.height.unwrap_or(0)],
        spp: case.settings.spp,
        threads: last.threads,
        paths: last.paths,
        mpaths_per_s: last.paths as f64 / cpu_s * 1e-6,
        mrays_per_s: mrays_per_s(&last.rays, cpu_s),
        ns_per_path: cpu_s * 1e9 / last.paths.max(1) as f64,
        cpu_s,
        wall_s,
        growth: None,
        prepare_s: what.is_of_scenes().then_some(case.prepare_s),
        prepare_growth: None,
        speed_up: None,
        cpu_ratio: None,
        tiles: last.tiles,
        shared_operations: last.shared_operations,
        operations_per_tile: last.shared_operations as f64 / last.tiles.max(1) as f64,
        runs: measured.len(),
    })
}

/// Compares every row of a sweep with the one before it, and those of threads with the first.
fn compare(rows: &mut [Row]) {
    for i in 1..rows.len() {
        let (before, row) = (rows[i - 1].clone(), &mut rows[i]);
        let sizes = (before.size as f64, row.size as f64);
        row.growth = exponent((sizes.0, before.ns_per_path), (sizes.1, row.ns_per_path));
        row.prepare_growth = before.prepare_s.zip(row.prepare_s).and_then(|s| exponent((sizes.0, s.0), (sizes.1, s.1)));
    }
    if let Some((wall_s, cpu_s)) = rows.first().map(|first| (first.wall_s, first.cpu_s)) {
        for row in rows.iter_mut().filter(|row| row.what == Swept::Threads) {
            row.speed_up = Some(wall_s / row.wall_s);
            row.cpu_ratio = Some(row.cpu_s / cpu_s);
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Rows of a sweep whose sizes and times of a path are these, 1000 paths each.
    pub fn rows(what: Swept, sizes: &[(u64, f64)]) -> Vec<Row> {
        let row = |&(size, ns_per_path): &(u64, f64)| Row {
            what,
            size,
            scene: "builtin:lamp_hall:102400".into(),
            film: [256, 256],
            spp: 16,
            threads: 1,
            paths: 1000,
            mpaths_per_s: 1e3 / ns_per_path,
            mrays_per_s: 5e3 / ns_per_path,
            ns_per_path,
            cpu_s: ns_per_path * 1e-6,
            wall_s: ns_per_path * 1e-6 / size as f64,
            growth: None,
            prepare_s: what.is_of_scenes().then_some(size as f64 * 1e-6),
            prepare_growth: None,
            speed_up: None,
            cpu_ratio: None,
            tiles: 256,
            shared_operations: 769,
            operations_per_tile: 769.0 / 256.0,
            runs: 5,
        };
        let mut rows: Vec<Row> = sizes.iter().map(row).collect();
        compare(&mut rows);
        rows
    }

    #[test]
    fn exponents_are_those_of_powers() {
        let of = |e: f64| exponent((10.0, 3.0 * 10f64.powf(e)), (1000.0, 3.0 * 1000f64.powf(e))).unwrap();
        assert!([0.0, 0.1, 0.5, 1.0, 2.0, -1.0].iter().all(|e| (of(*e) - e).abs() < 1e-12));
        assert_eq!(exponent((4.0, 1.0), (4.0, 2.0)), None, "one size tells no growth");
        assert_eq!(exponent((4.0, 0.0), (8.0, 2.0)), None);
        let rows = rows(Swept::Triangles, &[(100, 1.0), (1000, 10.0), (10_000, 10.0)]);
        let shown = |exponent: Option<f64>| exponent.map(|e| (e * 1e6).round() / 1e6);
        assert_eq!([0, 1, 2].map(|i| shown(rows[i].growth)), [None, Some(1.0), Some(0.0)]);
        assert_eq!([0, 1, 2].map(|i| shown(rows[i].prepare_growth)), [None, Some(1.0), Some(1.0)]);
        assert_eq!((shown(overall(&rows)), overall(&rows[..1])), (Some(0.5), None));
    }

    #[test]
    fn threads_are_compared_with_one() {
        let rows = rows(Swept::Threads, &[(1, 100.0), (2, 100.0), (4, 125.0)]);
        let near = |value: Option<f64>, wanted: f64| (value.unwrap() / wanted - 1.0).abs() < 1e-12;
        assert!(near(rows[1].speed_up, 2.0) && near(rows[1].cpu_ratio, 1.0));
        assert!(near(rows[2].speed_up, 3.2) && near(rows[2].cpu_ratio, 1.25));
    }

    #[test]
    fn samples_are_powers_of_two() {
        let values = [0.0, 0.3, 1.0, 1.4, 1.5, 5.6, 5.7, 1e3, 1e9, f64::INFINITY];
        assert_eq!(values.map(|value| power_of_two(value, 1 << 16)), [1, 1, 1, 1, 2, 4, 8, 1024, 65536, 65536]);
    }
}
