//! Many renders of one scene, measured: what is varied, in which order, what is written down of each.
//!
//! Runs are interleaved (for repeat, for budget, for case, for configuration), so that a slow moment of the machine hits
//! all alike. No two runs of one configuration share a random number: every (repeat, budget) has a seed of its own. Which run
//! comes next is a function of the runs made so far, so an interrupted experiment goes on as if it had not been.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::files::sealed::{self, Found};
use crate::fingerprint::Fingerprint;
use crate::image::Image;
use crate::render::render_with;
use crate::report::measure::run_error::{Measured, Pool, Region, mean_bias, measure};
use crate::report::measure::spectrum::{Spectrum, error_image, error_spectrum};
use crate::report::measure::truth::{Reference, white_noise};
use crate::scene::SceneDesc;
use crate::settings::{Engine, Guide, Lights, Roulette, Sampler, Settings, Shard};
use crate::stats::{StageStats, Stats};
use crate::strategy::Strategy;
use crate::tables::PreparedScene;

/// One way to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// How direct light is estimated.
    pub strategy: Strategy,
    /// How lights are chosen.
    pub lights: Lights,
    /// Whether directions are guided; where they are not, roulette goes by the throughput.
    pub guide: Guide,
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

/// What is measured by itself: a scene, whole or with the light of one material only.
pub struct Case {
    /// What to call the scene: short, and no two of an experiment alike.
    pub scene_name: String,
    /// The material whose light is left; [`ALL_LIGHTS`] for the scene as it is.
    pub light: String,
    /// What the scene says.
    pub desc: SceneDesc,
    /// Its tables.
    pub scene: PreparedScene,
    /// Most scattering events of a path; `None`: unbounded.
    pub max_depth: Option<u32>,
    /// First depth at which Russian roulette may end a path; `None`: off.
    pub rr_depth: Option<u32>,
}

/// The light of a case that is the whole scene.
pub const ALL_LIGHTS: &str = "all";

impl Case {
    /// The scene as it is, with all its lights.
    pub fn is_whole(&self) -> bool {
        self.light == ALL_LIGHTS
    }
}

/// Everything that is to be run.
pub struct Experiment {
    /// The cases, at least one.
    pub cases: Vec<Case>,
    /// The ways to render, at least one.
    pub configurations: Vec<Configuration>,
    /// Names of other renderers, whose runs are in `others_runs`. They count as configurations behind ours.
    pub others: Vec<String>,
    /// What other renderers made, measured.
    pub others_runs: Vec<Run>,
    /// The images of `others_runs`.
    pub others_images: Vec<Image>,
    /// The budgets, ascending, at least one.
    pub budgets: Vec<Budget>,
    /// Independent runs of each.
    pub repeats: u32,
    /// The relative error (root of relMSE) that exact strategies are run to, whatever it takes.
    pub reach: Option<f64>,
    /// What all runs share: film, threads; `seed` is the first of the runs' seeds.
    pub settings: Settings,
    /// Parts of the film whose error is measured by itself.
    pub regions: Vec<Region>,
    /// Stops of exposure at which images are shown, and compared as they are seen (PSNR, FLIP).
    pub exposure: f64,
    /// Of the runs that the budgets ask for, every N-th from the K-th on; `None`: all. See [`super::parts`].
    pub shard: Option<Shard>,
}

/// One render and its error.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    /// Index of the case.
    pub case: usize,
    /// Index of the configuration.
    pub configuration: usize,
    /// Index of the budget; from the number of budgets on, of a run that reaches for an error. Of another renderer its samples a
    /// pixel, or where they are not known a number of its own.
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
    /// Share of SIMD lanes that held a live ray in the tree's packets; `null` where none were used.
    pub walk_lanes_used: Option<f64>,
    /// Samples that were not finite, and paths cut at the depth guard.
    pub faults: u64,
    /// The power spectrum of its error.
    pub spectrum: Spectrum,
}

/// What has been measured so far.
pub struct Measurements {
    /// Finished runs, in the order in which they ran.
    pub runs: Vec<Run>,
    /// By case and configuration: the runs' images, added up.
    pub pools: Vec<Vec<Pool>>,
}

const MAGIC: &str = "octray unfinished converge, version 3";
/// The seeds of runs start here above `--seed`, those of references half the range away.
const FIRST_RUN: u32 = 1;
/// Seeds of the runs that reach for an error lie this far from the others'.
const REACHING_SEEDS: u32 = 1 << 30;
/// Seeds of the reference's parts lie this far from the runs'.
pub const REFERENCE_SEEDS: u32 = 1 << 31;
/// Independent runs of a budget that reaches for an error.
const REACHING_REPEATS: u32 = 2;
/// The most by which samples grow in one step towards an error: the law of few samples does not lead far.
const REACHING_GROWTH: f64 = 32.0;
/// A bias of so many standard errors ends the way to an error.
const REACHING_BIAS: f64 = 5.0;
/// What the samples foreseen for an error are multiplied by, so that one step mostly does.
const REACHING_MARGIN: f64 = 1.1;

impl Experiment {
    /// How many runs the budgets ask for; those that reach for an error come on top.
    pub fn run_count(&self) -> usize {
        let all = self.all_runs();
        self.shard.map_or(all, |shard| all.saturating_sub(shard.number as usize - 1).div_ceil(shard.count as usize))
    }

    /// The same of all shards together.
    pub fn all_runs(&self) -> usize {
        self.repeats as usize * self.budgets.len() * self.cases.len() * self.configurations.len()
    }

    /// The number, of all runs, of the run that is number `own` of this shard.
    fn number(&self, own: usize) -> usize {
        self.shard.map_or(own, |shard| shard.number as usize - 1 + own * shard.count as usize)
    }

    /// How many configurations findings may have: ours and the other renderers.
    pub fn entries(&self) -> usize {
        self.configurations.len() + self.others.len()
    }

    /// The strategy of a configuration; `None` for another renderer's.
    pub fn strategy(&self, configuration: usize) -> Option<Strategy> {
        self.configurations.get(configuration).map(|of| of.strategy)
    }

    /// What to call a case: the scene, the light, or both, as far as they are varied; empty where neither is.
    pub fn case_title(&self, case: usize) -> String {
        let of = &self.cases[case];
        let scenes = self.cases.iter().any(|other| other.scene_name != of.scene_name);
        let lights = self.cases.iter().any(|other| !other.is_whole());
        let light = if of.is_whole() { "all lights".to_owned() } else { format!("only {}", of.light) };
        match (scenes, lights) {
            (true, true) => format!("{}, {light}", of.scene_name),
            (true, false) => of.scene_name.clone(),
            (false, true) => light,
            (false, false) => String::new(),
        }
    }

    /// What to call a configuration: its strategy, and what else is varied.
    pub fn label(&self, configuration: usize) -> String {
        let Some(&of) = self.configurations.get(configuration) else {
            return self.others.get(configuration - self.configurations.len()).cloned().unwrap_or_default();
        };
        let first = self.configurations[0];
        let mut parts = vec![of.strategy.name()];
        let varied = |differs: fn(&Configuration, &Configuration) -> bool| {
            self.configurations.iter().any(|other| differs(other, &first))
        };
        if varied(|a, b| a.lights != b.lights) {
            parts.push(of.lights.name());
        }
        if varied(|a, b| a.guide != b.guide) {
            parts.push(if of.guide == Guide::Off { "unguided" } else { "guided" });
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

    /// [`Experiment::key`], and which of the runs are made.
    fn own_key(&self, references: &[Reference]) -> String {
        let part = self.shard.map_or("all".to_owned(), |shard| shard.to_string());
        format!("{} {part}", self.key(references))
    }

    /// What decides the runs, as text, except for how many repeats there are: those only go on.
    pub(super) fn key(&self, references: &[Reference]) -> String {
        let scenes: Vec<u64> = self.cases.iter().map(|case| crate::scene::fingerprint::scene(&case.desc)).collect();
        let mut truth = Fingerprint::default();
        references.iter().for_each(|reference| truth.bytes(bytemuck::cast_slice(&reference.image.pixels)));
        let version = env!("CARGO_PKG_VERSION");
        let depths: Vec<_> = self.cases.iter().map(|case| (case.max_depth, case.rr_depth)).collect();
        let varied = (&self.configurations, &self.budgets, &self.settings, &self.regions, depths);
        format!("{version} {scenes:?} {:016x} {varied:?}", truth.value())
    }

    /// Keeps what has been measured in `path`, so that the same experiment can go on.
    ///
    /// # Errors
    /// [`crate::Error::Write`].
    pub fn keep(&self, references: &[Reference], done: &Measurements, path: &Path) -> Result<()> {
        sealed::write(path, MAGIC, &(self.own_key(references), &done.runs), |out| {
            done.pools.iter().flatten().flat_map(Pool::numbers).try_for_each(|number| out.numbers(&[number]))
        })
    }

    /// What an interrupted call of the same experiment has kept in `path`; `None` if that is of another one, or damaged.
    pub fn kept(&self, references: &[Reference], path: &Path) -> Option<Measurements> {
        let Ok(Found::Whole((key, runs), numbers)) = sealed::open::<(String, Vec<Run>)>(path, MAGIC) else {
            return None;
        };
        let each = Pool::count_of_numbers(self.pixels());
        let (cases, configurations) = (self.cases.len(), self.configurations.len());
        let count = each as u64 * cases as u64 * configurations as u64;
        if key != self.own_key(references) || numbers.left() != count || !self.has_made(&runs) {
            return None;
        }
        let numbers: Vec<f64> = numbers.collect();
        if numbers.len() as u64 != count || !numbers.iter().all(|number| number.is_finite()) {
            return None;
        }
        let pools: Vec<Pool> = numbers.chunks(each).map(Pool::from_numbers).collect();
        Some(Measurements { runs, pools: pools.chunks(configurations).map(<[Pool]>::to_vec).collect() })
    }

    /// The film's size.
    pub fn film(&self) -> (u32, u32) {
        (self.settings.width.unwrap_or(0), self.settings.height.unwrap_or(0))
    }

    pub(super) fn pixels(&self) -> usize {
        self.film().0 as usize * self.film().1 as usize
    }

    /// The settings of one configuration with one budget.
    pub fn settings_of(&self, case: &Case, configuration: Configuration, budget: Budget, seed: u32) -> Settings {
        let Configuration { strategy, lights, guide, sampler, engine } = configuration;
        let Case { max_depth, rr_depth, .. } = *case;
        let (spp, time) = match budget {
            Budget::Spp(spp) => (spp, None),
            Budget::Time(time) => (u32::MAX, Some(time)),
        };
        let roulette = if guide == Guide::Off { Roulette::Throughput } else { Roulette::Auto };
        let how = Settings { strategy, lights, guide, roulette, sampler, engine, ..self.settings.clone() };
        Settings { spp, time, seed, max_depth, rr_depth, ..how }
    }

    /// Runs what `done` lacks, in order; false if `stop` ended it early. `told` hears of every finished run.
    pub fn run(
        &self,
        references: &[Reference],
        done: &mut Measurements,
        stop: &AtomicBool,
        told: &mut dyn FnMut(&Measurements),
    ) -> bool {
        while let Some(place) = self.next(&done.runs, references) {
            let case = &self.cases[place.case];
            let settings = self.settings_of(case, self.configurations[place.configuration], place.budget, place.seed);
            let go_on = |_| !stop.load(Ordering::Relaxed);
            let render = render_with(&case.scene, &settings, &go_on);
            if stop.load(Ordering::Relaxed) {
                return false;
            }
            let image = render.film.to_image();
            done.pools[place.case][place.configuration].add(&image, place.repeat, render.film.spp);
            done.runs.push(place.run(&image, render.film.spp, &render.stats, &references[place.case], &self.regions));
            told(done);
        }
        true
    }

    /// How many of `runs` are those that the budgets ask for.
    pub fn asked_of(&self, runs: &[Run]) -> usize {
        runs.iter().filter(|run| run.budget < self.budgets.len()).count()
    }

    /// The run that comes after `runs`; `None` if all are made.
    fn next(&self, runs: &[Run], references: &[Reference]) -> Option<Place> {
        let number = self.asked_of(runs);
        if number >= self.run_count() {
            return self.next_to_reach(runs, references);
        }
        Some(self.place(self.number(number)))
    }

    /// The run of that number of those that the budgets ask for.
    fn place(&self, number: usize) -> Place {
        let (configurations, cases) = (self.configurations.len(), self.cases.len());
        let (configuration, round) = (number % configurations, number / configurations);
        let (case, round) = (round % cases, round / cases);
        let (budget_index, repeat) = (round % self.budgets.len(), (round / self.budgets.len()) as u32);
        let seed = self.settings.seed.wrapping_add(FIRST_RUN + round as u32);
        Place { case, configuration, budget_index, budget: self.budgets[budget_index], repeat, seed }
    }

    /// Whether `runs`, which a file holds, can be runs of this experiment: a file with a right checksum may still be made by
    /// somebody else.
    pub(super) fn has_made(&self, runs: &[Run]) -> bool {
        let sound = |run: &Run| {
            let costs = run.seconds >= 0.0 && run.cpu_seconds >= 0.0;
            let known = run.case < self.cases.len() && run.configuration < self.configurations.len();
            known && costs && run.spp > 0 && run.error.regions.len() == self.regions.len()
        };
        let asked = runs.iter().filter(|run| run.budget < self.budgets.len());
        let in_order = asked.enumerate().all(|(number, run)| {
            let place = self.place(self.number(number));
            number < self.run_count()
                && (place.case, place.configuration, place.budget_index) == (run.case, run.configuration, run.budget)
                && (place.repeat, place.seed) == (run.repeat, run.seed)
        });
        in_order && runs.iter().all(sound)
    }

    /// The next run of a configuration that reaches for [`Experiment::reach`], in their order.
    fn next_to_reach(&self, runs: &[Run], references: &[Reference]) -> Option<Place> {
        let target = self.reach?;
        let exact = |configuration: &usize| !self.configurations[*configuration].strategy.is_biased();
        let all = (0..self.cases.len()).flat_map(|case| (0..self.configurations.len()).map(move |own| (case, own)));
        all.filter(|(_, configuration)| exact(configuration)).find_map(|(case, configuration)| {
            let of = |run: &&Run| (run.case, run.configuration) == (case, configuration);
            let own: Vec<&Run> = runs.iter().filter(of).collect();
            let step = next_step(&own, self.budgets.len(), target, &references[case])?;
            let number = (step.budget + 1 - self.budgets.len()) as u32;
            let seed = self.settings.seed.wrapping_add(REACHING_SEEDS + number * REACHING_REPEATS + step.repeat);
            let budget = Budget::Spp(step.spp);
            Some(Place { case, configuration, budget_index: step.budget, budget, repeat: step.repeat, seed })
        })
    }
}

/// A run that reaches for an error.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    budget: usize,
    spp: u32,
    repeat: u32,
}

/// What comes after the runs of one configuration: its last budget again, until that has its repeats, or a larger one. `None`
/// where the error `target` is reached, and where it is out of reach: the runs are biased, or more samples lower the error by
/// less than a third of what independent ones would (in the logarithm), or no render has so many.
fn next_step(own: &[&Run], budgets: usize, target: f64, reference: &Reference) -> Option<Step> {
    let last = own.iter().map(|run| run.budget).max()?;
    let group = |budget: usize| own.iter().filter(move |run| run.budget == budget);
    let spp = |budget: usize| group(budget).map(|run| run.spp).max().unwrap_or(1);
    let relmse = |budget: usize| group(budget).map(|run| run.error.relmse).sum::<f64>() / group(budget).count() as f64;
    let repeat = group(last).count() as u32;
    if last >= budgets && repeat < REACHING_REPEATS {
        return Some(Step { budget: last, spp: spp(last), repeat });
    }
    let growth = REACHING_MARGIN * relmse(last) / (target * target);
    // Also false where the error is not a number.
    let above = growth > REACHING_MARGIN;
    let pixels = reference.image.pixels.len() as f64;
    let (bias, error) = mean_bias(own.iter().map(|run| &run.error), white_noise(&reference.image) / pixels);
    let biased = bias.abs() > REACHING_BIAS * error;
    let stuck = last >= budgets && {
        let (before, after) = (last - 1, last);
        let expected = f64::from(spp(after)) / f64::from(spp(before));
        (relmse(before) / relmse(after)).ln() < expected.ln() / 3.0
    };
    if !above || biased || stuck {
        return None;
    }
    Some(Step { budget: last + 1, spp: more_samples(spp(last), growth)?, repeat: 0 })
}

/// `spp` grown by `growth`, at least doubled, to four times a whole number; `None` beyond what a render can have.
fn more_samples(spp: u32, growth: f64) -> Option<u32> {
    let wanted = spp as f64 * growth.clamp(2.0, REACHING_GROWTH);
    let whole = (wanted / 4.0).ceil() * 4.0;
    (whole < f64::from(u32::MAX)).then_some(whole as u32)
}

/// Rings of a run's spectrum.
const RINGS: usize = 12;

/// The power spectrum of the error of `image`.
pub fn spectrum_of(image: &Image, reference: &Image) -> Spectrum {
    let (width, height) = (image.width as usize, image.height as usize);
    error_spectrum(&error_image(image, reference), width, height, RINGS)
}

/// Which run of an experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    case: usize,
    configuration: usize,
    budget_index: usize,
    budget: Budget,
    repeat: u32,
    seed: u32,
}

impl Place {
    fn run(&self, image: &Image, spp: u32, stats: &Stats, reference: &Reference, regions: &[Region]) -> Run {
        let sum = |lanes: fn(&StageStats) -> u64| stats.stages.iter().map(lanes).sum::<u64>();
        let share = |used: u64, possible: u64| (possible > 0).then(|| used as f64 / possible as f64);
        Run {
            case: self.case,
            configuration: self.configuration,
            budget: self.budget_index,
            repeat: self.repeat,
            seed: self.seed,
            spp,
            seconds: stats.render_s,
            cpu_seconds: stats.cpu_s,
            error: measure(image, &reference.image, regions),
            rays: [stats.rays.camera, stats.rays.bounce, stats.rays.shadow],
            lanes_used: share(sum(|stage| stage.lanes_used), sum(|stage| stage.lanes_possible)),
            walk_lanes_used: share(
                sum(|stage| stage.walk_lanes_used.unwrap_or(0)),
                sum(|stage| stage.walk_lanes_possible.unwrap_or(0)),
            ),
            faults: stats.nonfinite + stats.guarded,
            spectrum: spectrum_of(image, &reference.image),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::measure::truth::Source;

    fn reference() -> Reference {
        let image = Image { width: 4, height: 4, pixels: vec![[1.0; 3]; 16], ..Image::default() };
        Reference { image, source: Source::ClosedForm }
    }

    fn run(budget: usize, repeat: u32, spp: u32, relmse: f64, bias: f64) -> Run {
        let truth = reference().image;
        let error = Measured { relmse, bias, bias_se: 0.01, ..measure(&truth, &truth, &[]) };
        Run {
            case: 0,
            configuration: 0,
            budget,
            repeat,
            seed: 0,
            spp,
            seconds: 1.0,
            cpu_seconds: 1.0,
            error,
            rays: [0; 3],
            lanes_used: None,
            walk_lanes_used: None,
            faults: 0,
            spectrum: spectrum_of(&truth, &truth),
        }
    }

    #[test]
    fn an_error_is_reached_for_as_long_as_that_makes_sense() {
        let next = |runs: &[Run], target: f64| next_step(&runs.iter().collect::<Vec<_>>(), 1, target, &reference());
        // 16 samples: 10 %. To 5 % it is four times as many and a margin of 10 %.
        let first = [run(0, 0, 16, 0.01, 0.0), run(0, 1, 16, 0.01, 0.0)];
        assert_eq!(next(&first, 0.1), None);
        assert_eq!(next(&first, 0.05), Some(Step { budget: 1, spp: 72, repeat: 0 }));
        let with = |more: &[Run]| [&first[..], more].concat();
        assert_eq!(next(&with(&[run(1, 0, 72, 0.004, 0.0)]), 0.05), Some(Step { budget: 1, spp: 72, repeat: 1 }));
        let twice = |relmse: f64, bias: f64| with(&[run(1, 0, 72, relmse, bias), run(1, 1, 72, relmse, bias)]);
        assert_eq!(next(&twice(0.0025, 0.0), 0.05), None);
        assert_eq!(next(&twice(0.003, 0.0), 0.05), Some(Step { budget: 2, spp: 144, repeat: 0 }));
        // Its error does not fall, or it comes to another image.
        assert_eq!((next(&twice(0.0095, 0.0), 0.05), next(&twice(0.003, 0.06), 0.05)), (None, None));
        assert_eq!(next(&twice(f64::NAN, 0.0), 0.05), None);
    }
}
