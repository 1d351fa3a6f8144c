//! `render()`: threads over tiles, whole passes over samples, and what it all cost.
//!
//! The film is cut into tiles; every tile owns its pixels and adds its samples in order, so threads and passes leave no
//! trace in the picture. A pass brings every pixel to the same number of samples.

mod chance;
mod passes;
pub mod pilot;
pub mod sequence;
mod shared;
mod tiles;
mod workers;

use std::sync::atomic::{AtomicBool, Ordering};

use crate::clock::Stopwatch;
use crate::fault::{Fault, planted};
use crate::film::{Film, NonFinite, Place, RelativeError};
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::reference::single;
use crate::settings::{Crop, Settings};
use crate::setup::Setup;
use crate::setup::recipe::Recipe;
pub use crate::stats::{RayCounts, StageStats, Stats};
use crate::tables::PreparedScene;
use crate::trace::TraceVertex;
use chance::brightest_by_chance;
use passes::{PASS_SPP, pass_length, reaches};
use shared::SharedSum;
use tiles::{Order, cut_into_tiles, reorder, tile_size};
use workers::{Job, Worker};
pub use workers::{PATHS_AT_ONCE, Progress, fill_slots};

/// How many non-finite samples are described one by one.
const NONFINITE_SHOWN: usize = 8;

/// A finished render.
#[derive(Debug)]
pub struct Render {
    /// The picture.
    pub film: Film,
    /// What it cost.
    pub stats: Stats,
}

/// Renders `scene` as `settings` say. See [`render_with`].
pub fn render(scene: &PreparedScene, settings: &Settings) -> Render {
    render_with(scene, settings, &|_| true)
}

/// Renders and tells `progress` now and then how far it is; once that returns false, the render stops after the pass it is
/// in and the picture holds the samples taken so far.
pub fn render_with(scene: &PreparedScene, settings: &Settings, progress: &(dyn Fn(Progress) -> bool + Sync)) -> Render {
    render_from(scene, settings, None, progress)
}

/// Goes on from `start`, a picture that an earlier call with the same scene and settings (but for `spp`, `time`,
/// `target_error`, `engine` and `threads`) had come to. The picture then is, bit for bit, the one that would have come
/// without the break. Statistics are those of this call.
pub fn render_from(
    scene: &PreparedScene,
    settings: &Settings,
    start: Option<Film>,
    progress: &(dyn Fn(Progress) -> bool + Sync),
) -> Render {
    let preparing = Stopwatch::start();
    let setup = Setup::new(scene, settings);
    train_and_render(setup, settings, start, progress, preparing.wall_seconds())
}

/// Learns what `settings` want to be learned and renders; `setup_s`: seconds that making the setup has taken.
fn train_and_render(
    mut setup: Setup,
    settings: &Settings,
    start: Option<Film>,
    progress: &(dyn Fn(Progress) -> bool + Sync),
    setup_s: f64,
) -> Render {
    // Training is rendering: its seconds count.
    let watch = Stopwatch::start();
    pilot::train(&mut setup, settings);
    render_trained(&setup, settings, start, progress, (setup_s, watch))
}

/// Renders what is all learned for; `watch` has run since training began.
fn render_trained(
    setup: &Setup,
    settings: &Settings,
    start: Option<Film>,
    progress: &(dyn Fn(Progress) -> bool + Sync),
    (setup_s, watch): (f64, Stopwatch),
) -> Render {
    let trained_s = watch.wall_seconds();
    let plan = Plan::new(setup);
    let spp = settings.spp.max(1);
    let mut done = start.as_ref().map_or(0, |film| film.spp);
    let (first, resumed) = (done, start.is_some());
    let film = start.filter(|_| !planted(Fault::LostPass));
    let mut film = film.unwrap_or_else(|| Film::of_sampler(setup.frame.crop, settings.sampler));
    let tile = tile_size(spp.min(PASS_SPP));
    if resumed {
        reorder(&mut film, tile, Order::Tiles);
    }
    let tiles = cut_into_tiles(setup, &mut film, tile);
    let threads = thread_count(settings.threads).min(tiles.len());
    let pixels = setup.frame.crop.width as u64 * setup.frame.crop.height as u64;
    let mut job = Job {
        setup,
        plan: &plan,
        engine: settings.engine,
        tiles,
        next_tile: SharedSum::new(0),
        samples: SharedSum::new(done as u64 * pixels),
        resumed: done as u64 * pixels,
        // Looked for only where something asks for it: a map of the surroundings may be large.
        brightest: settings.target_error.map_or(0.0, |_| brightest_by_chance(setup)),
        relative_error: None,
        unseen_error: 0.0,
        stop: AtomicBool::new(false),
        watch,
        total: spp as u64 * pixels,
        progress,
    };
    let mut workers: Vec<Worker> = (0..threads).map(|_| Worker::new(&job)).collect();
    // A picture to go on from may be good enough as it is.
    let mut error = if resumed { job.note_error() } else { None };
    let by_chance = job.brightest > 0.0;
    let reached = |done: u32, error: Option<RelativeError>, seconds: f64| {
        let target = settings.target_error.is_some_and(|target| reaches(target, done, pixels, error, by_chance));
        done >= spp || target || settings.time.is_some_and(|time| seconds >= time.as_secs_f64())
    };
    let finished = loop {
        let seconds = watch.wall_seconds();
        // At least one pass is made, so that there is a picture.
        if done > 0 && reached(done, error, seconds) {
            break true;
        }
        if done > first && job.stop.load(Ordering::Relaxed) {
            break false;
        }
        let pass = pass_length(settings, done, (done - first, seconds - trained_s), pixels, error);
        job.run_pass(&mut workers, done..done + pass);
        done += pass;
        error = job.note_error();
    };
    let (render_s, cpu_s) = (watch.wall_seconds(), watch.cpu_seconds());
    let unseen_error = error.filter(|_| settings.target_error.is_some()).map(|error| error.unseen);
    let stats = Stats { threads, setup_s, render_s, cpu_s, finished, unseen_error, ..Stats::default() };
    let mut nonfinite = Vec::new();
    for tile in job.tiles {
        nonfinite.append(&mut tile.into_inner().nonfinite);
    }
    reorder(&mut film, tile, Order::Rows);
    film.spp = done;
    finish(setup, settings, &workers, film, nonfinite, stats)
}

/// The worker threads of a render: `asked`, or one for every core.
fn thread_count(asked: usize) -> usize {
    match asked {
        0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
        n => n,
    }
}

/// What a render is besides its sums; counters to statistics. `nonfinite`: row, column and number of samples.
fn finish(
    setup: &Setup,
    settings: &Settings,
    workers: &[Worker],
    mut film: Film,
    mut nonfinite: Vec<(u32, u32, u32)>,
    mut stats: Stats,
) -> Render {
    let Crop { x, y, width, height } = setup.frame.crop;
    let whole = (x, y, (width, height)) == (0, 0, setup.frame.film);
    film.place = (!whole).then_some(Place { x, y, film: setup.frame.film });
    film.exposure = 0.0;
    nonfinite.sort_unstable();
    let mut counters = Counters::default();
    workers.iter().for_each(|worker| counters.add(&worker.counters));
    stats.warnings.clone_from(&setup.warnings);
    stats.learning.clone_from(&setup.learning);
    stats.paths = counters.paths;
    stats.rays = counters.rays;
    stats.guarded = counters.guarded;
    stats.tiles = workers.iter().map(|worker| worker.tiles).sum();
    stats.shared_operations = workers.iter().map(|worker| worker.operations.count()).sum();
    stats.stages = counters.report();
    stats.nonfinite = nonfinite.len() as u64;
    let shown = nonfinite.iter().take(NONFINITE_SHOWN);
    stats.nonfinite_samples =
        shown.map(|&(y, x, sample)| NonFinite { x, y, sample, stage: stage_of(setup, (x, y), sample) }).collect();
    let recipe = Recipe::new(&setup.scene.name, settings, &setup.frame);
    film.metadata = recipe.and("spp", film.spp.to_string()).0;
    Render { film, stats }
}

/// The step of a path (told by the reference, which takes the same ones) that first made a value that is not finite.
fn stage_of(setup: &Setup, pixel: (u32, u32), sample: u32) -> &'static str {
    let mut stage = None;
    single::path::trace_path(setup, pixel, sample, &mut |vertex: TraceVertex| {
        if stage.is_none() && !vertex.is_finite() {
            stage = Some(vertex.event);
        }
    });
    stage.unwrap_or("film")
}
