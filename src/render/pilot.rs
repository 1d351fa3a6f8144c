//! The training render ([`crate::learn`]): the same engines over a grid of its own, their radiance thrown away.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::clock::Stopwatch;
use crate::learn::forecast::{MOST, forecast};
use crate::learn::outcome::Learning;
use crate::learn::pilot::{PASSES, SCRAMBLE, grid, paths};
use crate::learn::records::LightRecords;
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::queues::TileState;
use crate::packet::tile::trace_paths;
use crate::reference::single;
use crate::render::thread_count;
use crate::render::tiles::tile_size;
use crate::render::workers::{PATHS_AT_ONCE, fill_slots};
use crate::settings::{Crop, Engine, Lights, Settings};
use crate::setup::Setup;
use crate::tables::PreparedScene;
use crate::tables::lights::learned::LearnedLights;
use crate::tables::lights::table::Selection;

/// The render that `settings` ask for, with what is to be learned for it.
pub fn resolve<'a>(scene: &'a PreparedScene, settings: &Settings) -> Setup<'a> {
    let mut setup = Setup::new(scene, settings);
    train(&mut setup, settings);
    setup
}

/// Learns what `settings` want to be learned, if anything. Of the settings, only those count that [`crate::learn`] names.
pub fn train(setup: &mut Setup, settings: &Settings) {
    if settings.lights == Lights::Learned {
        let learning = learn_lights(setup, settings);
        setup.learning = Some(learning);
    }
}

fn learn_lights(setup: &mut Setup, settings: &Settings) -> Learning {
    let Some(grid) = grid(settings.train, setup.frame.film) else { return Learning::none("training is switched off") };
    if !setup.samples_lights() || setup.max_depth == 0 || !setup.scene.features.scatters() {
        return Learning::none("no light is sampled");
    }
    let Selection::Tree(tree) = setup.lights.selection else {
        return Learning::none("there is nothing to choose from");
    };
    let watch = Stopwatch::start();
    let empty = LearnedLights::new(setup.scene, tree);
    let records = LightRecords::new(&empty);
    setup.lights.learned = Some(empty);
    let records = pilot(setup, settings, grid, records);
    let learned = setup.lights.learned.as_ref();
    let forecast = learned.and_then(|learned| forecast(learned, &records));
    let used = forecast.is_some_and(|forecast| forecast <= MOST);
    let learning = Learning {
        used,
        why: match forecast {
            None => "the training render has met too little light to tell".into(),
            Some(forecast) if used => format!("foreseen second moment {forecast:.2} of that without, at most {MOST}"),
            Some(forecast) => format!("foreseen second moment {forecast:.2} of that without, more than {MOST}"),
        },
        forecast,
        grid: Some(grid),
        paths: paths(grid),
        bytes: learned.map_or(0, |learned| learned.tables().iter().map(|(_, bytes)| bytes).sum()),
        seconds: watch.wall_seconds(),
        cpu_seconds: watch.cpu_seconds(),
    };
    if !used {
        setup.lights.learned = None;
    }
    learning
}

/// Renders the pilot over `grid`; what was learned is then what the records say, which are returned. `records`: none yet.
fn pilot(setup: &mut Setup, settings: &Settings, grid: (u32, u32), mut records: LightRecords) -> LightRecords {
    let (camera, seed) = (setup.camera, setup.seed);
    setup.camera = camera.on_grid(setup.frame.film, grid);
    setup.seed = seed ^ SCRAMBLE;
    let empty = records.clone();
    let plan = Plan::new(setup);
    let tiles = PASSES.map(|to| cut(grid, tile_size(to.div_ceil(2))));
    let most = tiles.iter().map(Vec::len).max().unwrap_or(1);
    let worker = || Worker {
        state: (settings.engine == Engine::Packet).then(|| plan.tile_state(PATHS_AT_ONCE)),
        records: empty.clone(),
    };
    let mut workers: Vec<Worker> = (0..thread_count(settings.threads).min(most)).map(|_| worker()).collect();
    let mut done = 0;
    for (to, tiles) in PASSES.into_iter().zip(tiles) {
        let next = AtomicUsize::new(0);
        let work = |setup: &Setup, worker: &mut Worker| {
            while let Some(&tile) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
                worker.run(setup, &plan, tile, done..to);
            }
        };
        match &mut workers[..] {
            [only] => work(setup, only),
            _ => std::thread::scope(|scope| {
                for worker in &mut workers {
                    let (setup, work) = (&*setup, &work);
                    scope.spawn(move || work(setup, worker));
                }
            }),
        }
        workers.iter_mut().for_each(|worker| records.take(&mut worker.records));
        if let Some(learned) = &mut setup.lights.learned {
            learned.learn(&records);
        }
        done = to;
    }
    (setup.camera, setup.seed) = (camera, seed);
    records
}

/// Rectangles that cover a grid.
fn cut((columns, rows): (u32, u32), (width, height): (u32, u32)) -> Vec<Crop> {
    let xs = |y: u32| {
        (0..columns).step_by(width as usize).map(move |x| Crop {
            x,
            y,
            width: width.min(columns - x),
            height: height.min(rows - y),
        })
    };
    (0..rows).step_by(height as usize).flat_map(xs).collect()
}

/// What one thread owns.
struct Worker {
    state: Option<TileState>,
    records: LightRecords,
}

impl Worker {
    /// Takes samples `range` of the pixels of `tile`.
    fn run(&mut self, setup: &Setup, plan: &Plan, tile: Crop, range: std::ops::Range<u32>) {
        let Some(state) = &mut self.state else {
            let mut recorder = single::recorder::Recorder { records: &mut self.records };
            for (y, x) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (y, x))) {
                for sample in range.clone() {
                    single::path::trace_path(setup, (tile.x + x, tile.y + y), sample, &mut recorder);
                }
            }
            return;
        };
        state.records = Some(std::mem::take(&mut self.records));
        let at_once = (PATHS_AT_ONCE as u32 / (tile.width * tile.height)).max(1);
        let mut pixel_of_slot = Vec::new();
        for first in range.clone().step_by(at_once as usize) {
            let count = at_once.min(range.end - first);
            fill_slots(&mut state.slots, &mut pixel_of_slot, tile, first, count);
            trace_paths(setup, plan, state, &mut Counters::default());
        }
        self.records = state.records.take().unwrap_or_default();
    }
}
