//! Many renders of one scene, measured: what is varied, in which order, what is written down of each.
//!
//! Runs are interleaved (for repeat, for budget, for scene, for configuration), so that a slow moment of the machine hits
//! all alike. No two runs of one configuration share a random number: every (repeat, budget) has a seed of its own.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::film::sealed;
use crate::fingerprint::Fingerprint;
use crate::image::Image;
use crate::render::render_with;
use crate::report::measure::run_error::{Measured, Pool, Region, measure};
use crate::report::measure::truth::Reference;
use crate::scene::SceneDesc;
use crate::settings::{Engine, Lights, Sampler, Settings};
use crate::stats::Stats;
use crate::strategy::Strategy;
use crate::tables::PreparedScene;

/// One way to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// How direct light is estimated.
    pub strategy: Strategy,
    /// How lights are chosen.
    pub lights: Lights,
    /// Where sample numbers come from.
    pub sampler: Sampler,
    /// Which code computes it.
    pub engine: Engine,
}

/// How long a run may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Samples a pixel.
    Spp(u32),
    /// Wall time of rendering; ends on a whole pass.
    Time(Duration),
}

/// A scene as it is measured: whole, or with the light of one material only.
pub struct Case {
    /// The material whose light is left; `all` for the scene as it is.
    pub light: String,
    /// What the scene says.
    pub desc: SceneDesc,
    /// Its tables.
    pub scene: PreparedScene,
}

/// Everything that is to be run.
pub struct Experiment {
    /// The scenes, at least one.
    pub cases: Vec<Case>,
    /// The ways to render, at least one.
    pub configurations: Vec<Configuration>,
    /// The budgets, ascending, at least one.
    pub budgets: Vec<Budget>,
    /// Independent runs of each.
    pub repeats: u32,
    /// What all runs share: film, depths, threads; `seed` is the first of the runs' seeds.
    pub settings: Settings,
    /// Parts of the film whose error is measured by itself.
    pub regions: Vec<Region>,
}

/// One render and its error.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    /// Index of the case.
    pub case: usize,
    /// Index of the configuration.
    pub configuration: usize,
    /// Index of the budget.
    pub budget: usize,
    /// Number of the repeat, from 0.
    pub repeat: u32,
    /// Seed of its random numbers.
    pub seed: u32,
    /// Samples a pixel.
    pub spp: u32,
    /// Wall seconds of rendering.
    pub seconds: f64,
    /// CPU seconds of rendering, all threads.
    pub cpu_seconds: f64,
    /// Its error against the reference.
    #[serde(flatten)]
    pub error: Measured,
    /// Rays traced: camera, bounce, shadow.
    pub rays: [u64; 3],
    /// Share of SIMD lanes that held work, over all stages; `null` for the scalar engine.
    pub lanes_used: Option<f64>,
    /// Samples that were not finite, and paths cut at the depth guard.
    pub faults: u64,
}

/// What has been measured so far.
pub struct Measurements {
    /// Finished runs, in the order in which they ran.
    pub runs: Vec<Run>,
    /// By case and configuration: the runs' pictures, added up.
    pub pools: Vec<Vec<Pool>>,
}

const MAGIC: &str = "octray unfinished converge, version 1";
/// The seeds of runs start here above `--seed`, those of references half the range away.
const FIRST_RUN: u32 = 1;
/// Seeds of the reference's parts lie this far from the runs'.
pub const REFERENCE_SEEDS: u32 = 1 << 31;

impl Experiment {
    /// How many runs there are.
    pub fn run_count(&self) -> usize {
        self.repeats as usize * self.budgets.len() * self.cases.len() * self.configurations.len()
    }

    /// What to call a configuration: its strategy, and what else is varied.
    pub fn label(&self, configuration: usize) -> String {
        let of = self.configurations[configuration];
        let first = self.configurations[0];
        let mut parts = vec![of.strategy.name()];
        let varied = |differs: fn(&Configuration, &Configuration) -> bool| {
            self.configurations.iter().any(|other| differs(other, &first))
        };
        if varied(|a, b| a.lights != b.lights) {
            parts.push(of.lights.name());
        }
        if varied(|a, b| a.sampler != b.sampler) {
            parts.push(of.sampler.name());
        }
        if varied(|a, b| a.engine != b.engine) {
            parts.push(of.engine.name());
        }
        parts.join(" ")
    }

    /// Nothing measured yet.
    pub fn start(&self) -> Measurements {
        let pixels = self.pixels();
        let pools = self.cases.iter().map(|_| self.configurations.iter().map(|_| Pool::new(pixels)).collect());
        Measurements { runs: Vec::new(), pools: pools.collect() }
    }

    /// What decides the runs, as text, except for how many repeats there are: those only go on.
    fn key(&self, references: &[Reference]) -> String {
        let scenes: Vec<u64> = self.cases.iter().map(|case| crate::scene::fingerprint::scene(&case.desc)).collect();
        let mut truth = Fingerprint::default();
        references.iter().for_each(|reference| truth.bytes(bytemuck::cast_slice(&reference.image.pixels)));
        let version = env!("CARGO_PKG_VERSION");
        let varied = (&self.configurations, &self.budgets, &self.settings, &self.regions);
        format!("{version} {scenes:?} {:016x} {varied:?}", truth.value())
    }

    /// Keeps what has been measured in `path`, so that the same experiment can go on.
    ///
    /// # Errors
    /// [`crate::Error::Write`].
    pub fn keep(&self, references: &[Reference], done: &Measurements, path: &Path) -> Result<()> {
        let numbers = done.pools.iter().flatten().flat_map(Pool::numbers);
        sealed::write(path, MAGIC, &(self.key(references), &done.runs), numbers)
    }

    /// What an interrupted call of the same experiment has kept in `path`; `None` if that is of another one, or damaged.
    pub fn kept(&self, references: &[Reference], path: &Path) -> Option<Measurements> {
        let (header, numbers) = sealed::read::<(String, Vec<Run>)>(path, MAGIC).ok()??;
        let (key, runs) = header;
        let each = Pool::count_of_numbers(self.pixels());
        let (cases, configurations) = (self.cases.len(), self.configurations.len());
        if key != self.key(references) || runs.len() > self.run_count() {
            return None;
        }
        let pools: Vec<Pool> = numbers.chunks(each).map(Pool::from_numbers).collect();
        (numbers.len() == each * cases * configurations)
            .then(|| Measurements { runs, pools: pools.chunks(configurations).map(<[Pool]>::to_vec).collect() })
    }

    /// The film's size.
    pub fn film(&self) -> (u32, u32) {
        (self.settings.width.unwrap_or(0), self.settings.height.unwrap_or(0))
    }

    fn pixels(&self) -> usize {
        self.film().0 as usize * self.film().1 as usize
    }

    /// The settings of one configuration with one budget.
    pub fn settings_of(&self, configuration: Configuration, budget: Budget, seed: u32) -> Settings {
        let Configuration { strategy, lights, sampler, engine } = configuration;
        let (spp, time) = match budget {
            Budget::Spp(spp) => (spp, None),
            Budget::Time(time) => (u32::MAX, Some(time)),
        };
        Settings { strategy, lights, sampler, engine, spp, time, seed, ..self.settings.clone() }
    }

    /// Runs what `done` lacks, in order; false if `stop` ended it early. `told` hears of every finished run.
    pub fn run(
        &self,
        references: &[Reference],
        done: &mut Measurements,
        stop: &AtomicBool,
        told: &dyn Fn(usize),
    ) -> bool {
        let mut number = 0;
        for repeat in 0..self.repeats {
            for (budget_index, &budget) in self.budgets.iter().enumerate() {
                let seed = FIRST_RUN + repeat * self.budgets.len() as u32 + budget_index as u32;
                let seed = self.settings.seed.wrapping_add(seed);
                for (case, reference) in references.iter().enumerate() {
                    for configuration in 0..self.configurations.len() {
                        number += 1;
                        if number <= done.runs.len() {
                            continue;
                        }
                        let place = Place { case, configuration, budget: budget_index, repeat, seed };
                        let Some(run) = self.run_one(place, budget, reference, done, stop) else { return false };
                        done.runs.push(run);
                        told(done.runs.len());
                    }
                }
            }
        }
        true
    }

    /// One run; `None` if `stop` was set meanwhile.
    fn run_one(
        &self,
        place: Place,
        budget: Budget,
        reference: &Reference,
        done: &mut Measurements,
        stop: &AtomicBool,
    ) -> Option<Run> {
        let settings = self.settings_of(self.configurations[place.configuration], budget, place.seed);
        let go_on = |_| !stop.load(Ordering::Relaxed);
        let render = render_with(&self.cases[place.case].scene, &settings, &go_on);
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let image = render.film.to_image();
        done.pools[place.case][place.configuration].add(&image, render.film.spp);
        Some(place.run(&image, render.film.spp, &render.stats, reference, &self.regions))
    }
}

/// Which run of an experiment.
struct Place {
    case: usize,
    configuration: usize,
    budget: usize,
    repeat: u32,
    seed: u32,
}

impl Place {
    fn run(&self, image: &Image, spp: u32, stats: &Stats, reference: &Reference, regions: &[Region]) -> Run {
        let lanes = |lanes: fn(&crate::stats::StageStats) -> u64| stats.stages.iter().map(lanes).sum::<u64>();
        let possible = lanes(|stage| stage.lanes_possible);
        Run {
            case: self.case,
            configuration: self.configuration,
            budget: self.budget,
            repeat: self.repeat,
            seed: self.seed,
            spp,
            seconds: stats.render_s,
            cpu_seconds: stats.cpu_s,
            error: measure(image, &reference.image, regions),
            rays: [stats.rays.camera, stats.rays.bounce, stats.rays.shadow],
            lanes_used: (possible > 0).then(|| lanes(|stage| stage.lanes_used) as f64 / possible as f64),
            faults: stats.nonfinite + stats.guarded,
        }
    }
}
