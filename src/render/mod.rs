//! `render()`: threads over tiles, whole passes over samples, and what it all cost.
//!
//! The film is cut into tiles; every tile owns its pixels and adds its samples in order, so threads and passes leave no
//! trace in the picture. A pass brings every pixel to the same number of samples.

mod chance;
mod layers;
mod passes;
pub mod pilot;
pub mod sequence;
mod shared;
mod tiles;
pub mod watch;
mod workers;

use std::sync::atomic::{AtomicBool, Ordering};

use crate::clock::Stopwatch;
use crate::error::{Error, Result};
use crate::fault::{Fault, planted};
use crate::film::layers::Layers;
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
use shared::{Between, SharedSum};
use tiles::{Layout, Order, cut_into_tiles, tile_size};
pub use watch::{Progress, Watch};
use workers::{Job, Worker, with_team};
pub use workers::{PATHS_AT_ONCE, fill_slots};

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
///
/// # Panics
/// As [`render_from`].
pub fn render(scene: &PreparedScene, settings: &Settings) -> Render {
    render_with(scene, settings, &|_| true)
}

/// Renders and tells `progress` now and then how far it is; once that returns false, the render stops at once and the picture
/// holds the samples taken so far, of which some parts may then have more than others ([`Film::uneven`]).
///
/// # Panics
/// As [`render_from`].
pub fn render_with(scene: &PreparedScene, settings: &Settings, progress: &(dyn Fn(Progress) -> bool + Sync)) -> Render {
    render_from(scene, settings, None, progress)
}

/// Goes on from `start`, a picture that an earlier call with the same scene and settings (but for `spp`, `time`,
/// `target_error`, `engine` and `threads`) had come to. The picture then is, bit for bit, the one that would have come
/// without the break. Statistics are those of this call.
///
/// # Panics
/// Where [`try_render_from`] returns an error, with its message.
pub fn render_from(
    scene: &PreparedScene,
    settings: &Settings,
    start: Option<Film>,
    progress: &(dyn Fn(Progress) -> bool + Sync),
) -> Render {
    expect(try_render_from(scene, settings, start, &progress))
}

/// What `done` holds.
fn expect(done: Result<Render>) -> Render {
    done.unwrap_or_else(|error| panic!("{error}"))
}

/// [`render`], for those who do not want to end with a film that is too large.
///
/// # Errors
/// As [`try_render_from`].
pub fn try_render(scene: &PreparedScene, settings: &Settings) -> Result<Render> {
    try_render_from(scene, settings, None, &|_| true)
}

/// [`render_from`]; `watch` hears how far the render is, may stop it, and is shown the picture as often as it wants.
///
/// # Errors
/// [`Error::Memory`] if there is not enough for the film; [`Error::Usage`] if `start` is no picture of this film and sampler.
pub fn try_render_from(
    scene: &PreparedScene,
    settings: &Settings,
    start: Option<Film>,
    watch: &dyn Watch,
) -> Result<Render> {
    let preparing = Stopwatch::start();
    let setup = Setup::new(scene, settings);
    train_and_render(setup, settings, start, watch, preparing.wall_seconds())
}

/// Learns what `settings` want to be learned and renders; `setup_s`: seconds that making the setup has taken.
fn train_and_render(
    mut setup: Setup,
    settings: &Settings,
    start: Option<Film>,
    watch: &dyn Watch,
    setup_s: f64,
) -> Result<Render> {
    // Training is rendering: its seconds count.
    let clock = Stopwatch::start();
    let stop = AtomicBool::new(false);
    pilot::train(&mut setup, settings, &|| asked_to_stop(watch, &stop, start.as_ref(), settings, &clock));
    render_trained(&setup, settings, start, (watch, &stop), (setup_s, clock))
}

/// Whether somebody wants the render to end, asked while it trains; `stop` keeps the answer.
fn asked_to_stop(
    watch: &dyn Watch,
    stop: &AtomicBool,
    start: Option<&Film>,
    settings: &Settings,
    clock: &Stopwatch,
) -> bool {
    let pixels = start.map_or(0, |film| film.pixels.len() as u64);
    let resumed = start.map_or(0, |film| u64::from(film.spp)) * pixels;
    let progress = Progress {
        samples: resumed,
        resumed,
        total: u64::from(settings.spp.max(1)) * pixels.max(1),
        seconds: clock.wall_seconds(),
        training: true,
        layers: false,
        relative_error: None,
        unseen_error: 0.0,
    };
    if !stop.load(Ordering::Relaxed) && !watch.progress(progress) {
        stop.store(true, Ordering::Relaxed);
    }
    stop.load(Ordering::Relaxed)
}

/// Why a leg of a render has ended: between two of them no thread has the film.
enum LegEnd {
    /// All is done.
    Finished,
    /// Somebody wants the render to end.
    Stopped,
    /// Somebody wants to see the picture.
    Paused,
}

/// Renders what is all learned for; `clock` has run since training began.
fn render_trained(
    setup: &Setup,
    settings: &Settings,
    start: Option<Film>,
    (watch, stop): (&dyn Watch, &AtomicBool),
    (setup_s, clock): (f64, Stopwatch),
) -> Result<Render> {
    let trained_s = clock.wall_seconds();
    let plan = Plan::new(setup);
    let spp = settings.spp.max(1);
    // Counts are told for tiles of their own size.
    let of_counts = start.as_ref().and_then(|film| film.uneven.as_ref()).map(|uneven| uneven.tile);
    let tile = of_counts.unwrap_or_else(|| tile_size(spp.min(PASS_SPP)));
    if !(1..=PATHS_AT_ONCE as u64).contains(&(u64::from(tile.0) * u64::from(tile.1))) {
        return Err(not_of_this());
    }
    let layout = Layout::new(setup, tile);
    let mut film = match start {
        Some(Film { spp, .. }) if planted(Fault::LostPass) => Film { spp, ..layout.film(setup)? },
        Some(film) if layout.fits(&film, setup) => film,
        Some(_) => return Err(not_of_this()),
        None => layout.film(setup)?,
    };
    let mut layer_pixels = if settings.gathers_layers() { layers::room(&film)? } else { Vec::new() };
    let mut threads = thread_count(settings.threads).min(layout.areas.len()).max(1);
    let wanted = threads;
    let mut workers: Vec<Worker> = (0..threads).map(|_| Worker::new(&plan, settings.engine)).collect();
    let pixels = layout.pixels();
    let resumed = layout.samples(&film);
    // Looked for only where something asks for it: a map of the surroundings may be large.
    let brightest = settings.target_error.map_or(0.0, |_| brightest_by_chance(setup));
    let first = film.spp;
    let mut nonfinite = Vec::new();
    let (finished, error) = loop {
        let mut done = film.spp;
        // A pass that was left in the middle is done first.
        let mut unfinished = film.uneven.as_ref().map(|_| film.most_spp());
        let any = film.most_spp() > 0;
        let samples = layout.samples(&film);
        if any {
            layout.reorder(&mut film, Order::Tiles);
        }
        let tiles = cut_into_tiles(setup, &mut film, &layout);
        let pause_at = watch.pause_after().map_or(f64::INFINITY, |pause| clock.wall_seconds() + pause.as_secs_f64());
        let job = Between::new(Job {
            setup,
            plan: &plan,
            engine: settings.engine,
            tiles,
            next_tile: SharedSum::new(0),
            samples: SharedSum::new(samples),
            resumed,
            brightest,
            relative_error: None,
            unseen_error: 0.0,
            stop,
            pause_at,
            clock,
            total: spp as u64 * pixels,
            watch,
        });
        let ((end, error, done), team) = with_team(&mut workers, &job, |team| {
            // A picture to go on from may be good enough as it is.
            let mut error = if any { team.error() } else { None };
            let reached = |done: u32, error: Option<RelativeError>, seconds: f64| {
                let by_chance = brightest > 0.0;
                let target =
                    settings.target_error.is_some_and(|target| reaches(target, done, pixels, error, by_chance));
                done >= spp || target || settings.time.is_some_and(|time| seconds >= time.as_secs_f64())
            };
            loop {
                let seconds = clock.wall_seconds();
                // At least one pass is made, so that there is a picture.
                if unfinished.is_none() && done > 0 && reached(done, error, seconds) {
                    return (LegEnd::Finished, error, done);
                }
                if stop.load(Ordering::Relaxed) {
                    return (LegEnd::Stopped, error, done);
                }
                let taken = (done - first, seconds - trained_s);
                let end = unfinished.take().unwrap_or_else(|| done + pass_length(settings, done, taken, pixels, error));
                let (whole, now) = team.run_pass(end);
                error = now;
                if whole {
                    done = end;
                } else if stop.load(Ordering::Relaxed) {
                    return (LegEnd::Stopped, error, done);
                }
                if clock.wall_seconds() >= pause_at {
                    return (LegEnd::Paused, error, done);
                }
            }
        });
        threads = threads.min(team);
        let mut counts = Vec::new();
        for tile in job.into_inner().tiles {
            let mut tile = tile.into_inner();
            nonfinite.append(&mut tile.nonfinite);
            counts.push(tile.done);
        }
        layout.reorder(&mut film, Order::Rows);
        layout.count(&mut film, counts, done);
        match end {
            LegEnd::Finished => break (true, error),
            LegEnd::Stopped => break (false, error),
            LegEnd::Paused => watch.pause(&film, clock.wall_seconds()),
        }
    };
    if planted(Fault::TraceOfThreads) && threads > 1 {
        film.pixels[0].sum[0] += 1.0;
    }
    let (render_s, cpu_s) = (clock.wall_seconds(), clock.cpu_seconds());
    film.layers = Layers { wanted: settings.layers.clone(), alpha: settings.hide_environment, pixels: Vec::new() };
    let (finished, layers_s) = if finished && settings.gathers_layers() {
        let samples = layout.samples(&film);
        let tell = || {
            watch.progress(Progress {
                samples,
                resumed,
                total: samples,
                seconds: clock.wall_seconds(),
                training: false,
                layers: true,
                relative_error: error.map(|error| error.seen),
                unseen_error: error.map_or(0.0, |error| error.unseen),
            })
        };
        let pass = layers::Pass { setup, plan: &plan, layout: &layout, spp: film.spp, stop, tell: &tell };
        let finished = pass.run(&mut workers, &mut layer_pixels, film.width);
        film.layers.pixels = if finished { layer_pixels } else { Vec::new() };
        (finished, Some(clock.wall_seconds() - render_s))
    } else {
        (finished, None)
    };
    let unseen_error = error.filter(|_| settings.target_error.is_some()).map(|error| error.unseen);
    let stats = Stats { threads, setup_s, render_s, cpu_s, layers_s, finished, unseen_error, ..Stats::default() };
    let mut render = finish(setup, settings, &workers, film, nonfinite, stats);
    if threads < wanted {
        let warning = format!("only {threads} of {wanted} threads could be started: the system allows no more");
        render.stats.warnings.push(warning);
    }
    Ok(render)
}

fn not_of_this() -> Error {
    Error::Usage("the picture to go on from is none of this film and sampler".into())
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
    film.place = (!whole && setup.shard.is_none()).then_some(Place { x, y, film: setup.frame.film });
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
    film.metadata = recipe.and("spp", film.spp_in_words()).0;
    if settings.gathers_layers() {
        let surfaces = if settings.layers_through_specular { "behind mirrors and glass" } else { "first hit" };
        film.metadata.push(("layers".to_owned(), surfaces.to_owned()));
    }
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
