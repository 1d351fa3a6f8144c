//! The training render ([`crate::learn`]): the same engines over a grid of its own, their radiance thrown away.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::camera::Camera;
use crate::clock::Stopwatch;
use crate::learn::forecast::{MOST, forecast};
use crate::learn::guide::steps::StepRecords;
use crate::learn::guide::training::Training;
use crate::learn::outcome::{GuideLearning, Learning};
use crate::learn::pilot::{LEAST_INDIRECT, PASSES, SCRAMBLE, grid, guided_samples};
use crate::learn::records::LightRecords;
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::queues::TileState;
use crate::packet::tile::trace_paths;
use crate::reference::single;
use crate::render::thread_count;
use crate::render::tiles::tile_size;
use crate::render::workers::{PATHS_AT_ONCE, fill_slots};
use crate::sampler::pixel_address;
use crate::settings::{Crop, Engine, Guide, Lights, Roulette, Settings};
use crate::setup::Setup;
use crate::tables;
use crate::tables::PreparedScene;
use crate::tables::lights::learned::LearnedLights;
use crate::tables::lights::table::Selection;
use crate::tables::lights::tree::LightTree;
use crate::tables::materials::MaterialKind;

/// The render that `settings` ask for, with what is to be learned for it.
pub fn resolve<'a>(scene: &'a PreparedScene, settings: &Settings) -> Setup<'a> {
    let mut setup = Setup::new(scene, settings);
    train(&mut setup, settings);
    setup
}

/// Learns what `settings` want to be learned, if anything. Of the settings, only those count that [`crate::learn`] names.
pub fn train(setup: &mut Setup, settings: &Settings) {
    let guides = settings.guide != Guide::Off || settings.roulette == Roulette::Learned;
    if settings.lights != Lights::Learned && !guides {
        return;
    }
    let watch = Stopwatch::start();
    let mut learning = learn(setup, settings, guides);
    (learning.seconds, learning.cpu_seconds) = (watch.wall_seconds(), watch.cpu_seconds());
    setup.learning = Some(learning);
}

fn learn(setup: &mut Setup, settings: &Settings, guides: bool) -> Learning {
    let nothing = |why: &str| Learning {
        guide: guides.then(|| GuideLearning::none(why)),
        ..Learning::none(if settings.lights == Lights::Learned { why } else { "not asked for" })
    };
    let Some(grid) = grid(settings.train, setup.frame.film) else { return nothing("training is switched off") };
    if setup.max_depth == 0 || !setup.scene.features.scatters() {
        let learning = nothing("nothing scatters light");
        let learns = settings.lights == Lights::Learned;
        return if learns { Learning { why: "no light is sampled".into(), ..learning } } else { learning };
    }
    let mut learning = nothing("");
    let tree = match setup.lights.selection {
        Selection::Tree(tree) if settings.lights == Lights::Learned && setup.samples_lights() => Some(tree),
        _ => None,
    };
    if settings.lights == Lights::Learned && tree.is_none() {
        let none = if setup.samples_lights() { "there is nothing to choose from" } else { "no light is sampled" };
        learning.why = none.into();
    }
    let guide_off = guides.then(|| no_guide(setup, settings)).flatten();
    if let Some(why) = guide_off {
        learning.guide = Some(GuideLearning::none(why));
    }
    let guides = guides && guide_off.is_none();
    if tree.is_none() && !guides {
        return learning;
    }
    let mut pilot = Pilot::new(setup, settings, grid, tree, guides);
    pilot.first_stage();
    pilot.judge_lights(&mut learning);
    if guides {
        pilot.second_stage(settings, &mut learning);
    }
    learning.grid = Some(grid);
    learning.paths = pilot.paths();
    pilot.end();
    let bytes = |tables: Vec<(&str, usize)>| tables.iter().map(|(_, bytes)| bytes).sum::<usize>();
    if let (Some(outcome), Some(guide)) = (&mut learning.guide, &setup.guide) {
        outcome.bytes = bytes(guide.tables());
    }
    learning
}

/// Why no directions are learned, if there is a reason beside what training may tell.
fn no_guide(setup: &Setup, settings: &Settings) -> Option<&'static str> {
    match () {
        _ if setup.strategy.row().uniform_directions => Some("the strategy draws directions uniformly"),
        _ if !setup.scene.features.kinds[MaterialKind::Diffuse] => Some("no surface is diffuse"),
        _ if setup.max_depth < 2 => Some("paths have one event at most"),
        _ if settings.guide == Guide::Auto && !setup.strategy.is_mis() && settings.roulette != Roulette::Learned => {
            Some("the strategy is not one of multiple importance sampling")
        }
        _ => None,
    }
}

/// A training render under way. While it is, the setup is its own: camera, seed and roulette.
struct Pilot<'s, 'a> {
    setup: &'s mut Setup<'a>,
    grid: (u32, u32),
    engine: Engine,
    threads: usize,
    /// Of light samples, where they are learned.
    lights: Option<LightRecords>,
    /// Of directions, where they are learned.
    training: Option<Training>,
    /// Second moment of what the paths of the last pass have brought after their bounces, over what their pixels show.
    indirect: f64,
    /// Samples of each pixel of the grid so far.
    done: u32,
    camera: Camera,
    seed: u32,
    roulette: Roulette,
}

impl<'s, 'a> Pilot<'s, 'a> {
    fn new(
        setup: &'s mut Setup<'a>,
        settings: &Settings,
        grid: (u32, u32),
        tree: Option<&LightTree>,
        guides: bool,
    ) -> Pilot<'s, 'a> {
        let (camera, seed, roulette) = (setup.camera, setup.seed, setup.roulette);
        setup.camera = camera.on_grid(setup.frame.film, grid);
        setup.roulette = Roulette::Throughput;
        setup.lights.learned = tree.map(|tree| LearnedLights::new(setup.scene, tree));
        setup.guide = guides.then(|| tables::guide::Guide::new(setup.scene, grid));
        Pilot {
            lights: setup.lights.learned.as_ref().map(LightRecords::new),
            training: guides.then(|| Training::new(grid)),
            setup,
            grid,
            engine: settings.engine,
            threads: settings.threads,
            indirect: 0.0,
            done: 0,
            camera,
            seed,
            roulette,
        }
    }

    /// Paths as they are without anything learned but lights: they tell what learning would be worth.
    fn first_stage(&mut self) {
        self.setup.seed = self.seed ^ SCRAMBLE;
        for to in PASSES {
            self.pass(to, false);
        }
    }

    /// Whether the lights' factors are used.
    fn judge_lights(&mut self, learning: &mut Learning) {
        let (Some(records), Some(learned)) = (self.lights.take(), &self.setup.lights.learned) else { return };
        let forecast = forecast(learned, &records);
        learning.bytes = learned.tables().iter().map(|(_, bytes)| bytes).sum();
        learning.forecast = forecast;
        learning.used = forecast.is_some_and(|forecast| forecast <= MOST);
        learning.why = match forecast {
            None => "the training render has met too little light to tell".into(),
            Some(forecast) if learning.used => {
                format!("foreseen second moment {forecast:.2} of that without, at most {MOST}")
            }
            Some(forecast) => format!("foreseen second moment {forecast:.2} of that without, more than {MOST}"),
        };
        if !learning.used {
            self.setup.lights.learned = None;
        }
    }

    /// Guided paths, if directions are to be guided, or roulette goes by what was learned.
    fn second_stage(&mut self, settings: &Settings, learning: &mut Learning) {
        let indirect = self.indirect;
        let guides = match settings.guide {
            Guide::Off => false,
            Guide::On => true,
            Guide::Auto => self.setup.strategy.is_mis() && indirect >= LEAST_INDIRECT,
        };
        let used = guides || settings.roulette == Roulette::Learned;
        if used {
            if matches!(settings.roulette, Roulette::Auto | Roulette::Learned) {
                self.roulette = Roulette::Learned;
            }
            self.setup.roulette = self.roulette;
            let end = guided_samples(self.setup.frame.film);
            let mut to = self.done;
            while to < end {
                to = (2 * to).min(end);
                // Each pass has numbers of its own: what it draws from was shaped by those before.
                self.setup.seed = self.seed ^ SCRAMBLE.rotate_left(to.ilog2());
                self.pass(to, guides);
            }
        } else {
            self.setup.guide = None;
        }
        let leaves = self.training.as_ref().map_or((0, 0), Training::leaves);
        learning.guide = Some(GuideLearning {
            used,
            guides,
            why: why(settings.guide, self.setup.strategy.is_mis(), indirect),
            indirect: Some(indirect),
            leaves: leaves.0,
            guided: if guides { leaves.1 } else { 0 },
            bytes: 0,
        });
    }

    /// Brings each pixel of the grid to `to` samples, and freezes what is then known. `guides`: directions are guided from then
    /// on.
    fn pass(&mut self, to: u32, guides: bool) {
        let plan = Plan::new(self.setup);
        let range = self.done..to;
        let tiles = cut(self.grid, tile_size(to - self.done));
        let worker = || Worker {
            state: (self.engine == Engine::Packet).then(|| plan.tile_state(PATHS_AT_ONCE)),
            lights: self.lights.as_ref().and(self.setup.lights.learned.as_ref()).map(LightRecords::new),
            steps: self.training.as_ref().map(|training| StepRecords::new(training.empty())),
        };
        let threads = thread_count(self.threads).min(tiles.len());
        let mut workers: Vec<Worker> = (0..threads).map(|_| worker()).collect();
        let next = AtomicUsize::new(0);
        let setup = &*self.setup;
        let work = |worker: &mut Worker| {
            while let Some(&tile) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
                worker.run(setup, &plan, tile, range.clone());
            }
        };
        match &mut workers[..] {
            [only] => work(only),
            _ => std::thread::scope(|scope| {
                for worker in &mut workers {
                    let work = &work;
                    scope.spawn(move || work(worker));
                }
            }),
        }
        for worker in &mut workers {
            if let (Some(all), Some(records)) = (&mut self.lights, &mut worker.lights) {
                all.take(records);
            }
            if let (Some(training), Some(steps)) = (&mut self.training, &mut worker.steps) {
                training.take(&mut steps.records);
            }
        }
        if let (Some(records), Some(learned)) = (&self.lights, &mut self.setup.lights.learned) {
            learned.learn(records);
        }
        if let (Some(training), Some(guide)) = (&mut self.training, &mut self.setup.guide) {
            self.indirect = training.indirect(to);
            training.freeze(guide, to, guides);
        }
        self.done = to;
    }

    /// Paths so far.
    fn paths(&self) -> u64 {
        u64::from(self.grid.0) * u64::from(self.grid.1) * u64::from(self.done)
    }

    /// Gives the setup back as a render wants it.
    fn end(self) {
        (self.setup.camera, self.setup.seed, self.setup.roulette) = (self.camera, self.seed, self.roulette);
        if let Some(guide) = &mut self.setup.guide {
            guide.pixels.spread(self.grid, self.setup.frame.film);
        }
    }
}

/// Why directions are guided, or not.
fn why(asked: Guide, mis: bool, indirect: f64) -> String {
    let share = format!(
        "what paths bring after their bounces has a second moment of {indirect:.2} over what pixels show; {LEAST_INDIRECT} pays"
    );
    match asked {
        Guide::Off => "only roulette goes by what was learned".into(),
        Guide::On => format!("asked for; {share}"),
        Guide::Auto if !mis => {
            "the strategy is not one of multiple importance sampling; only roulette is learned".into()
        }
        Guide::Auto => share,
    }
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
    lights: Option<LightRecords>,
    steps: Option<StepRecords>,
}

impl Worker {
    /// Takes samples `range` of the pixels of `tile`.
    fn run(&mut self, setup: &Setup, plan: &Plan, tile: Crop, range: std::ops::Range<u32>) {
        let Some(state) = &mut self.state else {
            let (lights, steps) = (self.lights.as_mut(), self.steps.as_mut());
            let mut recorder = single::recorder::Recorder { setup, lights, steps, step: None };
            for (y, x) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (y, x))) {
                let (x, y) = (tile.x + x, tile.y + y);
                for sample in range.clone() {
                    let path = single::path::trace_path(setup, (x, y), sample, &mut recorder);
                    recorder.end_path(pixel_address(x, y), path.radiance);
                }
            }
            return;
        };
        (state.records, state.steps) = (self.lights.take(), self.steps.take());
        let at_once = (PATHS_AT_ONCE as u32 / (tile.width * tile.height)).max(1);
        let mut pixel_of_slot = Vec::new();
        for first in range.clone().step_by(at_once as usize) {
            let count = at_once.min(range.end - first);
            fill_slots(&mut state.slots, &mut pixel_of_slot, tile, first, count);
            trace_paths(setup, plan, state, &mut Counters::default());
        }
        (self.lights, self.steps) = (state.records.take(), state.steps.take());
    }
}
