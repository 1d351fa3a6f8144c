//! Threads over tiles: what they share, what each owns, and the samples of one tile by either engine.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::clock::Stopwatch;
use crate::film::{ErrorSums, RelativeError};
use crate::packet::counters::{Counters, Stage};
use crate::packet::plan::Plan;
use crate::packet::queues::{Slots, TileState};
use crate::packet::tile::trace_paths;
use crate::reference::single;
use crate::render::shared::{Between, Gate, Locked, Operations, SharedSum};
use crate::render::tiles::Tile;
use crate::render::watch::{Progress, Watch};
use crate::sampler::pixel_address;
use crate::settings::{Crop, Engine};
use crate::setup::Setup;

/// Paths a packet tile follows at once: their queues (about 250 bytes a path) stay in a core's L2 cache. The last bounces of
/// a tile fill their lanes badly, so more paths are better as long as they fit: against 4096, 2048 cost 3 % on `glass`
/// and 7 % on `builtin:heavy:200000`, 1024 4 to 7 % more; 8192 gained 2 % on `glass` and nothing elsewhere.
pub const PATHS_AT_ONCE: usize = 4096;

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
    /// Somebody wants the render to end; it stays so.
    pub(super) stop: &'a AtomicBool,
    /// Wall seconds from which on the threads are to leave the tiles alone for a while.
    pub(super) pause_at: f64,
    pub(super) clock: Stopwatch,
    pub(super) total: u64,
    pub(super) watch: &'a dyn Watch,
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
    pub(super) fn new(plan: &Plan, engine: Engine) -> Worker {
        let state = (engine == Engine::Packet).then(|| plan.tile_state(PATHS_AT_ONCE));
        Worker {
            state,
            counters: Counters::default(),
            pixel_of_slot: Vec::new(),
            tiles: 0,
            operations: Operations::default(),
        }
    }
}

/// The threads of a render: the calling one, which leads, and helpers that wait for it between passes.
pub(super) struct Team<'s, 'j> {
    job: &'s Between<Job<'j>>,
    gate: &'s Gate,
    leader: &'s mut Worker,
    helpers: usize,
}

/// What `lead` returns, called with a team of `workers` for `job`; and how many threads the team had. Helpers are started once;
/// where the system refuses to start one, the others do its work.
pub(super) fn with_team<'j, R>(
    workers: &mut [Worker],
    job: &Between<Job<'j>>,
    lead: impl FnOnce(&mut Team<'_, 'j>) -> R,
) -> (R, usize) {
    let Some((leader, others)) = workers.split_first_mut() else { unreachable!("a render has a worker") };
    let gate = Gate::default();
    std::thread::scope(|scope| {
        let mut helpers = 0;
        for worker in others {
            let gate = &gate;
            let help = move || {
                let mut operations = std::mem::take(&mut worker.operations);
                gate.help(&mut operations, |end, operations| {
                    job.read(operations).work(worker, end);
                });
                worker.operations.add(&operations);
            };
            if std::thread::Builder::new().spawn_scoped(scope, help).is_err() {
                break;
            }
            helpers += 1;
        }
        let closes = Closes(&gate);
        let mut team = Team { job, gate: &gate, leader, helpers };
        let result = lead(&mut team);
        if helpers > 0 {
            gate.close(&mut team.leader.operations);
            std::mem::forget(closes);
        }
        (result, helpers + 1)
    })
}

/// Does `work` with every worker, the first on this thread, until all are done.
pub(super) fn together<W: Send>(workers: &mut [W], work: impl Fn(&mut W) + Sync) {
    let Some((first, others)) = workers.split_first_mut() else { return };
    let work = &work;
    std::thread::scope(|scope| {
        for worker in others {
            // Where the system refuses to start a thread, those that there are do its work.
            if std::thread::Builder::new().spawn_scoped(scope, move || work(worker)).is_err() {
                break;
            }
        }
        work(first);
    });
}

/// Sends helpers home when it is dropped, as it is where the leader panics: they would else wait for ever, and it for them.
struct Closes<'g>(&'g Gate);

impl Drop for Closes<'_> {
    fn drop(&mut self) {
        self.0.close(&mut Operations::default());
    }
}

impl Team<'_, '_> {
    /// Brings every pixel to `end` samples, or as far as the wish to stop or pause lets it; false if it did not get there.
    /// Returns how large the error is then.
    pub(super) fn run_pass(&mut self, end: u32) -> (bool, Option<RelativeError>) {
        let operations = &mut self.leader.operations;
        if self.helpers > 0 {
            self.gate.begin(self.helpers, end, operations);
            let job = self.job.read(operations);
            job.work(self.leader, end);
            drop(job);
            let whole = self.gate.finished(&mut self.leader.operations);
            assert!(whole, "a thread of the render has panicked");
            return self.job.write(&mut self.leader.operations).end_pass(end);
        }
        // Nobody else sees the job, but it is shared by its type: these locks make no thread wait, and count nowhere.
        let uncounted = &mut Operations::default();
        self.job.read(uncounted).work(self.leader, end);
        self.job.write(uncounted).end_pass(end)
    }

    /// How large the error is before the first pass.
    pub(super) fn error(&mut self) -> Option<RelativeError> {
        self.job.write(&mut self.leader.operations).note_error()
    }
}

impl Job<'_> {
    /// One thread's part of a pass to `end` samples a pixel.
    fn work(&self, worker: &mut Worker, end: u32) {
        let mut begun = false;
        // A pause may be due before the first tile: something is done between two of them all the same.
        while !self.is_to_end() || (!begun && !self.stop.load(Ordering::Relaxed)) {
            begun = true;
            let next = self.next_tile.add(1, &mut worker.operations);
            let Some(tile) = self.tiles.get(next as usize) else { return };
            let mut tile = tile.lock(&mut worker.operations);
            let first = tile.done;
            // A tile that was met in the middle of a pass has what it has.
            if first >= end {
                continue;
            }
            let at_once = (PATHS_AT_ONCE / tile.len()).max(1) as u32;
            while tile.done < end {
                let range = tile.done..end.min(tile.done + at_once);
                match self.engine {
                    Engine::Packet => self.packet_tile(worker, &mut tile, range.clone()),
                    Engine::Scalar => self.scalar_tile(worker, &mut tile, range.clone()),
                }
                tile.done = range.end;
                if tile.done < end && self.tells_to_end(self.samples.value()) {
                    break;
                }
            }
            // By the thread that has the tile in its cache, so that between passes there is next to nothing to do.
            tile.note_error();
            let taken = tile.len() as u64 * u64::from(tile.done - first);
            let samples = self.samples.add(taken, &mut worker.operations) + taken;
            worker.tiles += 1;
            self.tells_to_end(samples);
        }
    }

    /// Whether no more work is to be done for now.
    fn is_to_end(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.clock.wall_seconds() >= self.pause_at
    }

    /// Tells how far the render is, and whether no more work is to be done for now.
    fn tells_to_end(&self, samples: u64) -> bool {
        let &Job { resumed, total, relative_error, unseen_error, .. } = self;
        let seconds = self.clock.wall_seconds();
        if !self.watch.progress(Progress {
            samples,
            resumed,
            total,
            seconds,
            training: false,
            layers: false,
            relative_error,
            unseen_error,
        }) {
            self.stop.store(true, Ordering::Relaxed);
        }
        self.is_to_end()
    }

    /// After a pass to `end` samples a pixel: whether all pixels have them, and how large the error is now.
    fn end_pass(&mut self, end: u32) -> (bool, Option<RelativeError>) {
        self.next_tile = SharedSum::new(0);
        (self.tiles.iter_mut().all(|tile| tile.get_mut().done >= end), self.note_error())
    }

    /// How large the error is now. Tiles are added in order, so equal renders tell equal errors.
    pub(super) fn note_error(&mut self) -> Option<RelativeError> {
        let mut sums = ErrorSums::default();
        self.tiles.iter_mut().for_each(|tile| sums.add(&tile.get_mut().error));
        let error = sums.relative_error(self.brightest);
        self.relative_error = error.map(|error| error.seen).filter(|seen| !seen.is_nan());
        self.unseen_error = error.map_or(0.0, |error| error.unseen);
        self.tells_to_end(self.samples.value());
        error
    }

    /// Takes samples `range` of every pixel of `tile`: of so few that their paths are followed at once.
    fn packet_tile(&self, worker: &mut Worker, tile: &mut Tile, range: std::ops::Range<u32>) {
        let Some(state) = worker.state.as_mut() else { return };
        fill_slots(&mut state.slots, &mut worker.pixel_of_slot, tile.area, range.start, range.len() as u32);
        trace_paths(self.setup, self.plan, state, &mut worker.counters);
        let clock = std::time::Instant::now();
        for slot in 0..state.slots.len {
            let radiance = state.slots.radiance[slot].value();
            tile.add(worker.pixel_of_slot[slot] as usize, state.slots.sample[slot], radiance);
        }
        worker.counters.note(Stage::AddToFilm, state.slots.len, clock);
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
