//! `octray bench --scaling`: how the time of a path grows with what there is to render, and what more threads bring.
//!
//! Whole renders of the packet engine in five sweeps, one size varied in each and everything else held. What is compared is
//! CPU time a path, which does not move when other programs share the cores; rounds are interleaved within a sweep. Whether
//! threads wait for each other is not guessed from times: the render counts what its workers do on what they share.

mod plot;
mod sweep;
mod table;

use crate::api::Scene;
use crate::cli::args::EstimatorArgs;
use crate::cli::output::{JsonArgs, check_plot_path, write_text};
use crate::cli::progress::load;
use crate::cli::{prepare, report, warn};
use crate::error::{Error, Result};
use crate::report::write::plot::Layout;
use crate::settings::Settings;
use crate::setup::frame::Frame;
use crate::tables::PreparedScene;
use std::path::{Path, PathBuf};
use sweep::{Case, Row, Swept, measure};

/// Flags of `octray bench` for this run.
#[derive(clap::Args)]
pub struct ScalingArgs {
    /// Measure instead how whole renders scale with triangles, lights, bounces, pixels and threads; a --size below 256 shortens
    /// all of it
    #[arg(long)]
    scaling: bool,
    /// With --scaling: plot the growth of the time of a path
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

impl ScalingArgs {
    /// Whether this run is asked for; refuses flags that do not go together, and a plot that cannot be written.
    pub fn wanted(&self, estimator: &EstimatorArgs) -> Result<bool> {
        let refused = |message: &str| Err(Error::Usage(message.to_owned()));
        match (&self.plot, self.scaling) {
            (Some(_), false) => refused("--plot draws what --scaling measures: add --scaling or leave --plot out"),
            (_, true) if estimator.max_depth().is_some() => {
                refused("--scaling varies --max-depth itself: leave one of the two out")
            }
            (Some(path), true) => check_plot_path("--plot", path).map(|()| true),
            (None, scaling) => Ok(scaling),
        }
    }
}

/// Sizes of whole sweeps, as far as the scenes go.
const TRIANGLES: [u32; 4] = [2_000, 10_000, 100_000, 1_000_000];
const LAMPS: [u32; 6] = [100, 400, 1_600, 6_400, 25_600, 102_400];
const BOUNCES: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Columns and rows of the film of whole sweeps, and the most that the sweep of pixels has.
const SIDE: u32 = 256;
const MOST_SIDE: u32 = 1024;
/// CPU seconds of one render, about.
const SECONDS: f64 = 0.3;
/// Renders by several threads are longer by their number, up to this.
const MOST_LONGER: usize = 8;

/// The part of `sizes` that a shortened run has: at least two.
fn shortened(sizes: &[u32], share: f64) -> &[u32] {
    let most = sizes.last().map_or(0.0, |&last| f64::from(last) * share);
    let count = sizes.iter().filter(|&&size| f64::from(size) <= most).count();
    &sizes[..count.max(2).min(sizes.len())]
}

/// Columns and rows of the films of the sweep of pixels, around `side`.
fn sides(side: u32) -> Vec<u32> {
    let most = MOST_SIDE.max(side).min(side.saturating_mul(4));
    std::iter::successors(Some((side / 8).max(1)), |side| side.checked_mul(2))
        .take_while(|&side| side <= most)
        .collect()
}

/// Numbers of threads: powers of two up to four times the cores, and the cores.
fn thread_counts(cores: usize) -> Vec<usize> {
    let mut counts: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|&n| n <= 4 * cores).collect();
    counts.push(cores);
    counts.sort_unstable();
    counts.dedup();
    counts
}

/// Runs all sweeps; the exit status: 1 if several threads give another image than one.
pub fn run(
    flags: &ScalingArgs,
    (path, size, runs): (&Path, u32, u16),
    estimator: &EstimatorArgs,
    json: &JsonArgs,
) -> Result<u8> {
    let settings = |scene: &Scene| {
        // What is measured is the work of a path, not whether another would have been better.
        let mut settings = scene.settings().without_learning();
        estimator.apply(&mut settings);
        Settings { threads: 1, width: Some(size), height: Some(size), crop: None, time: None, ..settings }
    };
    let scene = load(path, false)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let own = settings(&scene);
    Frame::new(&own, scene.desc.film)?;
    let prepared = prepare(&scene)?;
    drop(scene);
    let share = (f64::from(size) / f64::from(SIDE)).powi(2).min(1.0);
    let mut sweeps = Sweeps { share, runs: usize::from(runs), rows: Vec::new(), faults: Vec::new() };
    sweeps.of_scenes(Swept::Triangles, "heavy", &TRIANGLES, &settings)?;
    sweeps.of_scenes(Swept::Lights, "lamp_hall", &LAMPS, &settings)?;
    let bounces = shortened(&BOUNCES, share).iter();
    let bounces = bounces.map(|&depth| (depth.into(), Settings { max_depth: Some(depth), ..own.clone() }));
    sweeps.of_settings(Swept::Bounces, &prepared, bounces);
    let pixels = sides(size).into_iter().map(|side| {
        let film = Settings { width: Some(side), height: Some(side), ..own.clone() };
        (u64::from(side) * u64::from(side), film)
    });
    sweeps.of_settings(Swept::Pixels, &prepared, pixels);
    sweeps.of_threads(&prepared, &own);
    let Sweeps { rows, faults, .. } = sweeps;
    json.deliver(&rows, || table::text(&prepared.name, &own, &rows))?;
    if let Some(path) = &flags.plot {
        write_text(path, &plot::plot(&prepared.name, &rows).svg(Layout::FILE).into_string())?;
    }
    faults.iter().for_each(report);
    Ok(if faults.is_empty() { 0 } else { 1 })
}

/// What sweeps have in common, and what has come of them.
struct Sweeps {
    /// How long they are, of what whole ones are.
    share: f64,
    runs: usize,
    rows: Vec<Row>,
    faults: Vec<String>,
}

impl Sweeps {
    /// CPU seconds of one render, about.
    fn seconds(&self) -> f64 {
        SECONDS * self.share
    }

    /// Scenes made in code, of these sizes.
    fn of_scenes(
        &mut self,
        what: Swept,
        name: &str,
        sizes: &[u32],
        settings: &impl Fn(&Scene) -> Settings,
    ) -> Result<()> {
        let made = |&size: &u32| -> Result<(u32, PreparedScene, Settings)> {
            let scene = Scene::load(format!("builtin:{name}:{size}"))?;
            Ok((size, scene.prepare()?, settings(&scene)))
        };
        let scenes: Vec<_> = shortened(sizes, self.share).iter().map(made).collect::<Result<_>>()?;
        let cases = scenes
            .iter()
            .map(|(size, scene, settings)| Case::of_seconds(u64::from(*size), scene, settings.clone(), self.seconds()));
        self.measure(what, &Case::alike(cases.collect()));
        Ok(())
    }

    /// One scene with settings of these sizes.
    fn of_settings(&mut self, what: Swept, scene: &PreparedScene, sizes: impl Iterator<Item = (u64, Settings)>) {
        let cases = sizes.map(|(size, settings)| Case::of_seconds(size, scene, settings, self.seconds())).collect();
        // Larger films have more paths a sample: theirs are fewer.
        let cases = if what == Swept::Pixels { cases } else { Case::alike(cases) };
        self.measure(what, &cases);
    }

    /// One and the same render by more and more threads.
    fn of_threads(&mut self, scene: &PreparedScene, settings: &Settings) {
        let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
        let one = Case::of_seconds(1, scene, settings.clone(), self.seconds() * cores.min(MOST_LONGER) as f64);
        let cases = thread_counts(cores).into_iter().map(|threads| one.with_threads(threads));
        self.measure(Swept::Threads, &cases.collect::<Vec<_>>());
    }

    fn measure(&mut self, what: Swept, cases: &[Case]) {
        self.rows.extend(measure(what, cases, self.runs, &mut self.faults));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_are_shortened_and_keep_two_sizes() {
        assert_eq!(shortened(&TRIANGLES, 1.0), TRIANGLES);
        assert_eq!(shortened(&TRIANGLES, 0.25), &TRIANGLES[..3]);
        assert_eq!(shortened(&LAMPS, 1.0 / 256.0), [100, 400]);
        assert_eq!(shortened(&BOUNCES, 1e-9), [1, 2]);
    }

    #[test]
    fn films_grow_around_the_size_that_is_asked_for() {
        assert_eq!(sides(256), [32, 64, 128, 256, 512, 1024]);
        assert_eq!(sides(16), [2, 4, 8, 16, 32, 64]);
        assert_eq!(sides(1), [1, 2, 4]);
        assert_eq!(sides(2048), [256, 512, 1024, 2048]);
        assert_eq!(sides(65535).last(), Some(&65528));
    }

    #[test]
    fn threads_are_powers_of_two_and_the_cores() {
        assert_eq!(thread_counts(1), [1, 2, 4]);
        assert_eq!(thread_counts(2), [1, 2, 4, 8]);
        assert_eq!(thread_counts(6), [1, 2, 4, 6, 8, 16]);
    }
}
