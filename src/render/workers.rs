//! Threads over tiles: what they share, what each owns, and the samples of one tile by either engine.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::clock::Stopwatch;
use crate::film::{ErrorSums, RelativeError};
use crate::packet::counters::{Counters, Stage};
use crate::packet::plan::Plan;
use crate::packet::queues::{Slots, TileState};
use crate::packet::tile::trace_paths;
use crate::reference::single;
use crate::render::shared::{Locked, Operations, SharedSum};
use crate::render::tiles::Tile;
use crate::sampler::pixel_address;
use crate::settings::{Crop, Engine};
use crate::setup::Setup;

/// Paths a packet tile follows at once: their queues (about 250 bytes a path) stay in a core's L2 cache. The last bounces of
/// a tile fill their lanes badly, so more paths are better as long as they fit: against 4096, 2048 cost 3 % on `glass`
/// and 7 % on `builtin:heavy:200000`, 1024 4 to 7 % more; 8192 gained 2 % on `glass` and nothing elsewhere.
pub const PATHS_AT_ONCE: usize = 4096;

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
    /// The picture's estimated relative error ([`crate::Film::relative_error`]) after the last whole pass; `None` before there are
    /// two samples (four with the `sobol` sampler) in every pixel, and for a black picture.
    pub relative_error: Option<f64>,
    /// What light that no sample has met may add to it ([`RelativeError::unseen`]); 0 without a target error, and where
    /// light samples see to all lights.
    pub unseen_error: f64,
}

/// What the threads of one render share.
pub(super) struct Job<'a> {
    pub(super) setup: &'a Setup<'a>,
    pub(super) plan: &'a Plan,
    pub(super) engine: Engine,
    pub(super) tiles: Vec<Locked<Tile<'a>>>,
    pub(super) next_tile: SharedSum,
    pub(super) samples: SharedSum,
    /// Samples of earlier calls.
    pub(super) resumed: u64,
    /// The brightest light that a path may meet by chance, W sr^-1 m^-2; 0 without a target error.
    pub(super) brightest: f64,
    /// [`Progress::relative_error`] after the last pass.
    pub(super) relative_error: Option<f64>,
    /// [`Progress::unseen_error`] after the last pass.
    pub(super) unseen_error: f64,
    pub(super) stop: AtomicBool,
    pub(super) watch: Stopwatch,
    pub(super) total: u64,
    pub(super) progress: &'a (dyn Fn(Progress) -> bool + Sync),
}

/// What one thread owns.
pub(super) struct Worker {
    pub(super) state: Option<TileState>,
    pub(super) counters: Counters,
    /// Pixel index in the tile of every slot.
    pub(super) pixel_of_slot: Vec<u32>,
    /// Tiles rendered, each once for every pass over it.
    pub(super) tiles: u64,
    /// On what the threads share.
    pub(super) operations: Operations,
}

impl Worker {
    pub(super) fn new(job: &Job) -> Worker {
        let state = (job.engine == Engine::Packet).then(|| job.plan.tile_state(PATHS_AT_ONCE));
        Worker {
            state,
            counters: Counters::default(),
            pixel_of_slot: Vec::new(),
            tiles: 0,
            operations: Operations::default(),
        }
    }
}

impl Job<'_> {
    /// Takes samples `range` of every pixel.
    pub(super) fn run_pass(&mut self, workers: &mut [Worker], range: std::ops::Range<u32>) {
        self.next_tile = SharedSum::new(0);
        let job = &*self;
        match workers {
            [only] => job.work(only, range),
            _ => std::thread::scope(|scope| {
                for worker in workers {
                    let range = range.clone();
                    scope.spawn(move || job.work(worker, range));
                }
            }),
        }
    }

    fn work(&self, worker: &mut Worker, range: std::ops::Range<u32>) {
        while let Some(tile) = self.tiles.get(self.next_tile.add(1, &mut worker.operations) as usize) {
            let mut tile = tile.lock(&mut worker.operations);
            match self.engine {
                Engine::Packet => self.packet_tile(worker, &mut tile, range.clone()),
                Engine::Scalar => self.scalar_tile(worker, &mut tile, range.clone()),
            }
            // By the thread that has the tile in its cache, so that between passes there is next to nothing to do.
            tile.note_error(range.end);
            let taken = tile.len() as u64 * range.len() as u64;
            let samples = self.samples.add(taken, &mut worker.operations) + taken;
            worker.tiles += 1;
            self.report(samples);
        }
    }

    /// Tells how far the render is.
    fn report(&self, samples: u64) {
        let &Job { resumed, total, relative_error, unseen_error, .. } = self;
        let seconds = self.watch.wall_seconds();
        if !(self.progress)(Progress { samples, resumed, total, seconds, relative_error, unseen_error }) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    /// After a pass: how large the error is now. Tiles are added in order, so equal renders tell equal errors.
    pub(super) fn note_error(&mut self) -> Option<RelativeError> {
        let mut sums = ErrorSums::default();
        self.tiles.iter_mut().for_each(|tile| sums.add(&tile.get_mut().error));
        let error = sums.relative_error(self.brightest);
        self.relative_error = error.map(|error| error.seen).filter(|seen| !seen.is_nan());
        self.unseen_error = error.map_or(0.0, |error| error.unseen);
        let samples = self.samples.value();
        self.report(samples);
        error
    }

    fn packet_tile(&self, worker: &mut Worker, tile: &mut Tile, range: std::ops::Range<u32>) {
        let Some(state) = worker.state.as_mut() else { return };
        let samples_at_once = (PATHS_AT_ONCE / tile.len()).max(1) as u32;
        let mut first = range.start;
        while first < range.end {
            let count = samples_at_once.min(range.end - first);
            fill_slots(&mut state.slots, &mut worker.pixel_of_slot, tile.area, first, count);
            trace_paths(self.setup, self.plan, state, &mut worker.counters);
            let clock = std::time::Instant::now();
            for slot in 0..state.slots.len {
                let radiance = state.slots.radiance[slot].value();
                tile.add(worker.pixel_of_slot[slot] as usize, state.slots.sample[slot], radiance);
            }
            worker.counters.note(Stage::AddToFilm, state.slots.len, clock);
            first += count;
        }
    }

    fn scalar_tile(&self, worker: &mut Worker, tile: &mut Tile, range: std::ops::Range<u32>) {
        let counters = &mut worker.counters;
        for index in 0..tile.len() {
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
    slots.radiance[..len].fill(Default::default());
}
