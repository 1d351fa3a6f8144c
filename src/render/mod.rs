//! `render()`: threads over tiles, whole passes over samples, and what it all cost.
//!
//! The film is cut into tiles; every tile owns its pixels and adds its samples in order, so threads and passes leave no
//! trace in the picture. A pass brings every pixel to the same number of samples.

mod passes;
mod tiles;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use crate::clock::Stopwatch;
use crate::film::{ErrorSums, Film, NonFinite, Place, Sums};
use crate::packet::counters::{Counters, Stage};
use crate::packet::plan::Plan;
use crate::packet::queues::{Slots, TileState};
use crate::packet::tile::trace_paths;
use crate::reference::single;
use crate::sampler::pixel_address;
use crate::settings::{Crop, Engine, Settings};
use crate::setup::Setup;
use crate::setup::recipe::Recipe;
pub use crate::stats::{RayCounts, StageStats, Stats};
use crate::tables::PreparedScene;
use crate::trace::TraceVertex;
use passes::{LEAST_SPP_FOR_ERROR, PASS_SPP, pass_length};
use tiles::{Tile, copy_into, cut_into_tiles, fill_from};

/// Paths a packet tile follows at once: their queues (about 250 bytes a path) stay in a core's L2 cache. The last bounces of
/// a tile fill their lanes badly, so more paths are better as long as they fit: against 4096, 2048 cost 3 % on `glass`
/// and 7 % on `builtin:heavy:200000`, 1024 4 to 7 % more; 8192 gained 2 % on `glass` and nothing elsewhere.
pub const PATHS_AT_ONCE: usize = 4096;

/// A picture that is still black after so many samples a pixel has no relative error and is given up as it is.
const BLACK_SPP: u32 = 1024;

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

/// How far a render has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Samples finished, over all pixels.
    pub samples: u64,
    /// Those of them that an earlier call has taken.
    pub resumed: u64,
    /// Samples wanted.
    pub total: u64,
    /// Wall seconds since the start of this call.
    pub seconds: f64,
    /// The picture's estimated relative error ([`Film::relative_error`]) after the last whole pass; `None` before there are
    /// two samples (four with the `sobol` sampler) in every pixel, and for a black picture.
    pub relative_error: Option<f64>,
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
    start: Option<&Film>,
    progress: &(dyn Fn(Progress) -> bool + Sync),
) -> Render {
    let preparing = Stopwatch::start();
    let setup = Setup::new(scene, settings);
    let plan = Plan::new(&setup);
    let setup_s = preparing.wall_seconds();
    let spp = settings.spp.max(1);
    let mut tiles = cut_into_tiles(&setup, spp.min(PASS_SPP));
    let mut done = 0;
    if let Some(film) = start {
        let own = |tile: &mut Mutex<Tile>| {
            fill_from(tile.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner()), film, setup.frame.crop);
        };
        tiles.iter_mut().for_each(own);
        done = film.spp;
    }
    let threads = thread_count(settings.threads).min(tiles.len());
    let watch = Stopwatch::start();
    let pixels = setup.frame.crop.width as u64 * setup.frame.crop.height as u64;
    let job = Job {
        setup: &setup,
        plan: &plan,
        engine: settings.engine,
        tiles,
        next_tile: AtomicUsize::new(0),
        samples: AtomicU64::new(done as u64 * pixels),
        resumed: done as u64 * pixels,
        relative_error: AtomicU64::new(f64::NAN.to_bits()),
        stop: AtomicBool::new(false),
        watch,
        total: spp as u64 * pixels,
        progress,
    };
    let mut workers: Vec<Worker> = (0..threads).map(|_| Worker::new(&job)).collect();
    let first = done;
    let mut error = None;
    let reached = |done: u32, error: Option<f64>, seconds: f64| {
        let target = settings.target_error.is_some_and(|target| match error {
            Some(error) => done >= LEAST_SPP_FOR_ERROR && error <= target,
            None => done >= BLACK_SPP,
        });
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
        let pass = pass_length(settings, done, (done - first, seconds), pixels, error);
        job.run_pass(&mut workers, done..done + pass);
        done += pass;
        error = job.note_error();
    };
    let (render_s, cpu_s) = (watch.wall_seconds(), watch.cpu_seconds());
    finish(&job, &workers, settings, done, Stats { threads, setup_s, render_s, cpu_s, finished, ..Stats::default() })
}

/// The worker threads of a render: `asked`, or one for every core.
fn thread_count(asked: usize) -> usize {
    match asked {
        0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
        n => n,
    }
}

/// What the threads of one render share.
struct Job<'a> {
    setup: &'a Setup<'a>,
    plan: &'a Plan,
    engine: Engine,
    tiles: Vec<Mutex<Tile>>,
    next_tile: AtomicUsize,
    samples: AtomicU64,
    /// Samples of earlier calls.
    resumed: u64,
    /// Bits of the estimate after the last pass, NaN before there is one.
    relative_error: AtomicU64,
    stop: AtomicBool,
    watch: Stopwatch,
    total: u64,
    progress: &'a (dyn Fn(Progress) -> bool + Sync),
}

/// What one thread owns.
struct Worker {
    state: Option<TileState>,
    counters: Counters,
    /// Pixel index in the tile of every slot.
    pixel_of_slot: Vec<u32>,
}

impl Worker {
    fn new(job: &Job) -> Worker {
        let state = (job.engine == Engine::Packet).then(|| job.plan.tile_state(PATHS_AT_ONCE));
        Worker { state, counters: Counters::default(), pixel_of_slot: Vec::new() }
    }
}

impl Job<'_> {
    /// Takes samples `range` of every pixel.
    fn run_pass(&self, workers: &mut [Worker], range: std::ops::Range<u32>) {
        self.next_tile.store(0, Ordering::Relaxed);
        match workers {
            [only] => self.work(only, range),
            _ => std::thread::scope(|scope| {
                for worker in workers {
                    let range = range.clone();
                    scope.spawn(move || self.work(worker, range));
                }
            }),
        }
    }

    fn work(&self, worker: &mut Worker, range: std::ops::Range<u32>) {
        while let Some(tile) = self.tiles.get(self.next_tile.fetch_add(1, Ordering::Relaxed)) {
            // A poisoned lock means another thread has panicked: its tile is not this one's.
            let mut tile = tile.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            match self.engine {
                Engine::Packet => self.packet_tile(worker, &mut tile, range.clone()),
                Engine::Scalar => self.scalar_tile(worker, &mut tile, range.clone()),
            }
            // By the thread that has the tile in its cache, so that between passes there is next to nothing to do.
            tile.error = ErrorSums::of(Sums { pixels: &tile.pixels, groups: &tile.groups, spp: range.end });
            let taken = tile.pixels.len() as u64 * range.len() as u64;
            let samples = self.samples.fetch_add(taken, Ordering::Relaxed) + taken;
            self.report(samples);
        }
    }

    /// Tells how far the render is.
    fn report(&self, samples: u64) {
        let relative_error = Some(f64::from_bits(self.relative_error.load(Ordering::Relaxed))).filter(|e| !e.is_nan());
        let seconds = self.watch.wall_seconds();
        if !(self.progress)(Progress { samples, resumed: self.resumed, total: self.total, seconds, relative_error }) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    /// After a pass: how large the error is now. Tiles are added in order, so equal renders tell equal errors.
    fn note_error(&self) -> Option<f64> {
        let mut sums = ErrorSums::default();
        for tile in &self.tiles {
            sums.add(&tile.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).error);
        }
        let error = sums.estimate().map(|(error, _)| error);
        self.relative_error.store(error.unwrap_or(f64::NAN).to_bits(), Ordering::Relaxed);
        self.report(self.samples.load(Ordering::Relaxed));
        error
    }

    fn packet_tile(&self, worker: &mut Worker, tile: &mut Tile, range: std::ops::Range<u32>) {
        let Some(state) = worker.state.as_mut() else { return };
        let samples_at_once = (PATHS_AT_ONCE / tile.pixels.len()).max(1) as u32;
        let mut first = range.start;
        while first < range.end {
            let count = samples_at_once.min(range.end - first);
            fill_slots(&mut state.slots, &mut worker.pixel_of_slot, tile.area, first, count);
            trace_paths(self.setup, self.plan, state, &mut worker.counters);
            let clock = std::time::Instant::now();
            for slot in 0..state.slots.len {
                let [r, g, b, _] = state.slots.radiance[slot];
                tile.add(worker.pixel_of_slot[slot] as usize, state.slots.sample[slot], [r, g, b]);
            }
            worker.counters.note(Stage::AddToFilm, state.slots.len, clock);
            first += count;
        }
    }

    fn scalar_tile(&self, worker: &mut Worker, tile: &mut Tile, range: std::ops::Range<u32>) {
        let counters = &mut worker.counters;
        for index in 0..tile.pixels.len() {
            let pixel = (tile.area.x + index as u32 % tile.area.width, tile.area.y + index as u32 / tile.area.width);
            for sample in range.clone() {
                let path = single::path::trace_path(self.setup, pixel, sample, &mut single::observer::Unobserved);
                counters.paths += 1;
                counters.rays.camera += 1;
                counters.rays.bounce += path.bounce_rays as u64;
                counters.rays.shadow += path.shadow_rays as u64;
                counters.guarded += path.guarded as u64;
                tile.add(index, sample, path.radiance.to_array());
            }
        }
    }
}

/// Addresses of `count` samples from `first` of every pixel of `area`. Slots go through blocks of 4x4 pixels, each as two
/// halves of 4x2, sample by sample, so that eight or sixteen neighbouring lanes hold neighbouring camera rays.
/// `pixel_of_slot` becomes each slot's pixel, counted row by row in `area`.
pub fn fill_slots(slots: &mut Slots, pixel_of_slot: &mut Vec<u32>, area: Crop, first: u32, count: u32) {
    pixel_of_slot.clear();
    let mut len = 0;
    for block_y in (0..area.height).step_by(4) {
        for block_x in (0..area.width).step_by(4) {
            for sample in first..first + count {
                for y in block_y..(block_y + 4).min(area.height) {
                    for x in block_x..(block_x + 4).min(area.width) {
                        slots.pixel[len] = pixel_address(area.x + x, area.y + y);
                        slots.sample[len] = sample;
                        pixel_of_slot.push(y * area.width + x);
                        len += 1;
                    }
                }
            }
        }
    }
    slots.len = len;
    slots.radiance[..len].fill([0.0; 4]);
}

/// Tiles to film, counters to statistics.
fn finish(job: &Job, workers: &[Worker], settings: &Settings, spp: u32, mut stats: Stats) -> Render {
    let crop = job.setup.frame.crop;
    let mut film = Film::of_sampler(crop, settings.sampler);
    film.spp = spp;
    let Crop { x, y, width, height } = crop;
    let whole = (x, y, (width, height)) == (0, 0, job.setup.frame.film);
    film.place = (!whole).then_some(Place { x, y, film: job.setup.frame.film });
    let mut nonfinite = Vec::new();
    for tile in &job.tiles {
        let tile = tile.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        copy_into(&mut film.pixels, &tile.pixels, tile.area, crop);
        if !tile.groups.is_empty() {
            copy_into(&mut film.groups, &tile.groups, tile.area, crop);
        }
        nonfinite.extend_from_slice(&tile.nonfinite);
    }
    nonfinite.sort_unstable();
    let mut counters = Counters::default();
    workers.iter().for_each(|worker| counters.add(&worker.counters));
    stats.paths = counters.paths;
    stats.rays = counters.rays;
    stats.guarded = counters.guarded;
    stats.stages = counters.report();
    stats.nonfinite = nonfinite.len() as u64;
    let shown = nonfinite.iter().take(NONFINITE_SHOWN);
    stats.nonfinite_samples =
        shown.map(|&(y, x, sample)| NonFinite { x, y, sample, stage: stage_of(job.setup, (x, y), sample) }).collect();
    let recipe = Recipe::new(&job.setup.scene.name, settings, &job.setup.frame);
    film.metadata = recipe.and("spp", spp.to_string()).0;
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
