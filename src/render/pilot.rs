//! The training render ([`crate::learn`]): the same engines over a grid of its own, their radiance thrown away.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::camera::Camera;
use crate::clock::Stopwatch;
use crate::learn::forecast::{MOST, forecast};
use crate::learn::guide::steps::StepRecords;
use crate::learn::guide::training::Training;
use crate::learn::outcome::{EnvironmentLearning, GuideLearning, Learning};
use crate::learn::pilot::{LEAST_INDIRECT, PASSES, SCRAMBLE, grid, guided_samples};
use crate::learn::records::LightRecords;
use crate::learn::visibility;
use crate::learn::visibility::records::VisibilityRecords;
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::queues::TileState;
use crate::packet::tile::trace_paths;
use crate::reference::single;
use crate::render::thread_count;
use crate::render::tiles::tile_size;
use crate::render::workers::{PATHS_AT_ONCE, fill_slots, together};
use crate::sampler::pixel_address;
use crate::settings::{Crop, Engine, Guide, Lights, Roulette, Settings, Train};
use crate::setup::Setup;
use crate::tables;
use crate::tables::PreparedScene;
use crate::tables::lights::learned::LearnedLights;
use crate::tables::lights::table::{EnvironmentLight, Selection};
use crate::tables::lights::tree::LightTree;
use crate::tables::lights::visibility::Visibility;
use crate::tables::materials::MaterialKind;

/// The render that `settings` ask for, with what is to be learned for it.
pub fn resolve<'a>(scene: &'a PreparedScene, settings: &Settings) -> Setup<'a> {
    let mut setup = Setup::new(scene, settings);
    train(&mut setup, settings, &|| false);
    setup
}

/// Learns what `settings` want to be learned, if anything. Of the settings, only those count that [`crate::learn`] names. Once
/// `stop` says so, and it must stay with that, the rest is left out: what was learned is then worth nothing.
pub fn train(setup: &mut Setup, settings: &Settings, stop: Stop) {
    if !settings.learns() {
        return;
    }
    let watch = Stopwatch::start();
    let mut learning = learn(setup, settings, stop);
    (learning.seconds, learning.cpu_seconds) = (watch.wall_seconds(), watch.cpu_seconds());
    setup.learning = Some(learning);
}

/// Whether somebody wants a render to end; once it says so, always.
pub type Stop<'s> = &'s (dyn Fn() -> bool + Sync);

/// What is to be learned.
pub(super) struct Wanted<'t> {
    /// Which lights matter where: factors for this tree.
    pub tree: Option<&'t LightTree>,
    /// Which cells see each other: for roulette of shadow rays, and the factors come of this.
    pub visibility: bool,
    /// Which patches of the environment map matter where.
    pub patches: bool,
    /// Where light comes from.
    pub guides: bool,
    /// Why what is not to be learned is not.
    pub learning: Learning,
}

impl<'t> Wanted<'t> {
    /// What `settings`, which learn something, and the scene suggest.
    pub fn new(setup: &Setup<'t>, settings: &Settings) -> Wanted<'t> {
        let lights = settings.lights.learns();
        let guides = settings.guide != Guide::Off || settings.roulette == Roulette::Learned;
        let none = |lights_why: &str, guide_why: &str| Learning {
            guide: guides.then(|| GuideLearning::none(guide_why)),
            ..Learning::none(if lights { lights_why } else { "not asked for" })
        };
        let nothing =
            |learning: Learning| Wanted { tree: None, visibility: false, patches: false, guides: false, learning };
        if settings.train == Train::Off {
            return nothing(none("training is switched off", "training is switched off"));
        }
        if setup.max_depth == 0 || !setup.scene.features.scatters() {
            return nothing(none("no light is sampled", "nothing scatters light"));
        }
        let tree = match setup.lights.selection {
            Selection::Tree(tree) if lights && tree.choice && setup.samples_lights() => Some(tree),
            _ => None,
        };
        let maps = matches!(setup.lights.environment, Some(EnvironmentLight::Map(..)));
        let patches = maps && settings.lights == Lights::Learned && setup.samples_lights();
        let by_visibility = settings.lights == Lights::NeePlusPlus;
        let visibility = by_visibility && setup.samples_lights() && setup.lights.count() > 0;
        let no_tree = match (&tree, setup.samples_lights()) {
            (Some(_), _) => "",
            (None, true) if visibility => "",
            (None, true) if by_visibility => "there is no light but the environment",
            (None, true) => "there is nothing to choose from",
            (None, false) => "no light is sampled",
        };
        let no_guide = guides.then(|| no_guide(setup, settings)).flatten();
        let learning = none(no_tree, no_guide.unwrap_or_default());
        Wanted { tree, visibility, patches, guides: guides && no_guide.is_none(), learning }
    }

    /// Whether nothing is.
    pub fn is_nothing(&self) -> bool {
        self.tree.is_none() && !self.visibility && !self.patches && !self.guides
    }
}

fn learn(setup: &mut Setup, settings: &Settings, stop: Stop) -> Learning {
    let wanted = Wanted::new(setup, settings);
    let grid = match grid(settings.train, setup.frame.film) {
        Some(grid) if !wanted.is_nothing() => grid,
        _ => return wanted.learning,
    };
    let mut pilot = Pilot::new(setup, settings, grid, &wanted, stop);
    let Wanted { visibility, guides, mut learning, .. } = wanted;
    if visibility {
        pilot.see();
    }
    pilot.first_stage();
    if let Some(records) = pilot.sightings.take() {
        visibility::build::judge(&mut pilot.setup.lights, &records, &mut learning);
    }
    if let Some(records) = pilot.lights.take() {
        let of_patches = records.patches.forecast();
        judge_lights(pilot.setup, (&records, of_patches), &mut learning);
    }
    if guides {
        pilot.second_stage(settings, &mut learning);
    }
    learning.grid = Some(grid);
    learning.paths = pilot.paths();
    pilot.end();
    learning
}

/// Bytes of tables.
pub(super) fn bytes(tables: &[(&str, usize)]) -> usize {
    tables.iter().map(|(_, bytes)| bytes).sum()
}

/// Whether the lights' factors are used, and what was learned of patches of the environment map, for which the second moment
/// `of_patches` is foreseen; what is not used is forgotten.
pub(super) fn judge_lights(
    setup: &mut Setup,
    (records, of_patches): (&LightRecords, Option<f64>),
    learning: &mut Learning,
) {
    let Some(learned) = &mut setup.lights.learned else { return };
    learning.bytes = bytes(&learned.tables());
    if learned.slot_count > 0 {
        learning.forecast = forecast(learned, records);
        (learning.used, learning.why) = judged(learning.forecast);
        if !learning.used {
            learned.forget_tree();
        }
    }
    if learned.patches.is_some() {
        let (used, why) = judged(of_patches);
        if !used {
            learned.patches = None;
        }
        learning.environment = Some(EnvironmentLearning { used, why, forecast: of_patches });
    }
    if learned.slot_count == 0 && learned.patches.is_none() {
        setup.lights.learned = None;
    }
}

/// Whether that pays of which this second moment is foreseen, and why.
fn judged(forecast: Option<f64>) -> (bool, String) {
    match forecast {
        None => (false, "the training render has met too little light to tell".into()),
        Some(forecast) if forecast <= MOST => {
            (true, format!("foreseen second moment {forecast:.2} of that without, at most {MOST}"))
        }
        Some(forecast) => (false, format!("foreseen second moment {forecast:.2} of that without, more than {MOST}")),
    }
}

/// Gives the lights tables that know nothing yet, for what is `wanted`.
pub(super) fn new_tables(setup: &mut Setup, wanted: &Wanted) {
    let patches = if wanted.patches { setup.scene.patches(setup.strategy.is_mis()) } else { None };
    let some = wanted.tree.is_some() || patches.is_some();
    setup.lights.learned = some.then(|| LearnedLights::new(setup.scene, wanted.tree, patches));
}

/// Whether directions are guided, given the second moment of what paths bring after their bounces.
pub(super) fn guides(setup: &Setup, settings: &Settings, indirect: f64) -> bool {
    match settings.guide {
        Guide::Off => false,
        Guide::On => true,
        Guide::Auto => setup.strategy.is_mis() && indirect >= LEAST_INDIRECT,
    }
}

/// What roulette goes by where what was learned of directions is used.
pub(super) fn roulette(setup: &Setup, settings: &Settings) -> Roulette {
    match settings.roulette {
        Roulette::Auto | Roulette::Learned => Roulette::Learned,
        _ => setup.roulette,
    }
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
pub(super) struct Pilot<'s, 'a> {
    pub setup: &'s mut Setup<'a>,
    grid: (u32, u32),
    engine: Engine,
    threads: usize,
    stop: Stop<'s>,
    /// Of light samples, where they are learned.
    pub lights: Option<LightRecords>,
    /// Of shadow rays, where it is learned which cells see each other.
    sightings: Option<VisibilityRecords>,
    /// Of directions, where they are learned.
    pub training: Option<Training>,
    /// Second moment of what the paths of the last pass have brought after their bounces, over what their pixels show.
    indirect: f64,
    /// Samples of each pixel of the grid so far.
    done: u32,
    camera: Camera,
    seed: u32,
    roulette: Roulette,
}

impl<'s, 'a> Pilot<'s, 'a> {
    pub fn new(
        setup: &'s mut Setup<'a>,
        settings: &Settings,
        grid: (u32, u32),
        wanted: &Wanted,
        stop: Stop<'s>,
    ) -> Pilot<'s, 'a> {
        let guides = wanted.guides;
        let (camera, seed, roulette) = (setup.camera, setup.seed, setup.roulette);
        setup.camera = camera.on_grid(setup.frame.film, grid);
        setup.seed ^= SCRAMBLE;
        setup.roulette = Roulette::Throughput;
        new_tables(setup, wanted);
        setup.guide = guides.then(|| tables::guide::Guide::new(setup.scene, grid));
        Pilot {
            lights: setup.lights.learned.as_ref().map(LightRecords::new),
            sightings: None,
            training: guides.then(|| Training::new(grid)),
            setup,
            grid,
            engine: settings.engine,
            threads: settings.threads,
            stop,
            indirect: 0.0,
            done: 0,
            camera,
            seed,
            roulette,
        }
    }

    /// Learns which cells see each other, and nothing else of the lights.
    fn see(&mut self) {
        self.lights = None;
        self.sightings = Some(VisibilityRecords::default());
        self.setup.lights.visibility = Some(Visibility::new(self.setup.scene));
    }

    /// Paths as they are without anything learned but lights: they tell what learning would be worth.
    fn first_stage(&mut self) {
        for to in PASSES {
            // What the last pass finds tells how good the tables are: it has no part in those that it draws by.
            if let Some(records) = &mut self.lights {
                records.patches.tried = [0; 2];
            }
            self.pass(to, false);
        }
    }

    /// Guided paths, if directions are to be guided, or roulette goes by what was learned.
    fn second_stage(&mut self, settings: &Settings, learning: &mut Learning) {
        let indirect = self.indirect;
        let guides = guides(self.setup, settings, indirect);
        let used = guides || settings.roulette == Roulette::Learned;
        if used {
            self.roulette = roulette(self.setup, settings);
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
            bytes: self.setup.guide.as_ref().map_or(0, |guide| bytes(&guide.tables())),
        });
    }

    /// Brings each pixel of the grid to `to` samples, and freezes what is then known. `guides`: directions are guided from then
    /// on.
    fn pass(&mut self, to: u32, guides: bool) {
        self.run(to);
        if let (Some(records), Some(learned)) = (&self.lights, &mut self.setup.lights.learned) {
            learned.learn(records);
        }
        if let Some(records) = &self.sightings {
            visibility::build::weigh(self.setup.scene, &mut self.setup.lights, records);
        }
        if let (Some(training), Some(guide)) = (&mut self.training, &mut self.setup.guide) {
            self.indirect = training.indirect(to);
            training.freeze(guide, to, guides);
        }
        self.done = to;
    }

    /// Records what samples of each pixel find, from those done to `to` of them.
    pub fn run(&mut self, to: u32) {
        let plan = Plan::new(self.setup);
        let range = self.done..to;
        let tiles = cut(self.grid, tile_size(to - self.done));
        let worker = || Worker {
            state: (self.engine == Engine::Packet).then(|| plan.tile_state(PATHS_AT_ONCE)),
            lights: self.lights.as_ref().and(self.setup.lights.learned.as_ref()).map(LightRecords::new),
            sightings: self.sightings.as_ref().map(|_| VisibilityRecords::default()),
            steps: self.training.as_ref().map(|training| StepRecords::new(training.empty())),
        };
        let threads = thread_count(self.threads).min(tiles.len());
        let mut workers: Vec<Worker> = (0..threads).map(|_| worker()).collect();
        let next = AtomicUsize::new(0);
        let setup = &*self.setup;
        let stop = self.stop;
        let work = |worker: &mut Worker| {
            while let Some(&tile) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
                if stop() {
                    return;
                }
                worker.run(setup, &plan, tile, range.clone());
            }
        };
        together(&mut workers, work);
        for worker in &mut workers {
            if let (Some(all), Some(records)) = (&mut self.lights, &mut worker.lights) {
                all.take(records);
            }
            if let (Some(all), Some(records)) = (&mut self.sightings, &mut worker.sightings) {
                all.take(records);
            }
            if let (Some(training), Some(steps)) = (&mut self.training, &mut worker.steps) {
                training.take(&mut steps.records);
            }
        }
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
pub(super) fn why(asked: Guide, mis: bool, indirect: f64) -> String {
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
    sightings: Option<VisibilityRecords>,
    steps: Option<StepRecords>,
}

impl Worker {
    /// Takes samples `range` of the pixels of `tile`.
    fn run(&mut self, setup: &Setup, plan: &Plan, tile: Crop, range: std::ops::Range<u32>) {
        let Some(state) = &mut self.state else {
            let (lights, sightings, steps) = (self.lights.as_mut(), self.sightings.as_mut(), self.steps.as_mut());
            let mut recorder = single::recorder::Recorder { setup, lights, sightings, steps, step: None };
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
        state.sightings = self.sightings.take();
        let at_once = (PATHS_AT_ONCE as u32 / (tile.width * tile.height)).max(1);
        let mut pixel_of_slot = Vec::new();
        for first in range.clone().step_by(at_once as usize) {
            let count = at_once.min(range.end - first);
            fill_slots(&mut state.slots, &mut pixel_of_slot, tile, first, count);
            trace_paths(setup, plan, state, &mut Counters::default());
        }
        (self.lights, self.steps) = (state.records.take(), state.steps.take());
        self.sightings = state.sightings.take();
    }
}
