//! What a render is asked to do: strategy, light selection, sampler, depth, roulette, engine.

use crate::named_choice::named_choice;
use crate::strategy::Strategy;
use std::time::Duration;

named_choice! {
    /// How a light sample chooses its light.
    Lights, "light selection", {
        /// Every light triangle with the same probability.
        Uniform = "uniform",
        /// In proportion to emitted power.
        Power = "power",
        /// By what each light can send to the point, found in a tree ([`crate::tables::lights::tree`]).
        Tree = "tree",
        /// By the tree, its clusters weighed by what their samples turned out to be worth in a training render
        /// ([`crate::learn`]); where that would not pay, by the tree alone. The default.
        Learned = "learned",
        /// By the tree, its clusters weighed by how often a training render has found their places visible, which also ends
        /// shadow rays by roulette (Guo, Eisemann and Eisemann 2020: [`crate::learn::visibility`]); for comparison.
        NeePlusPlus = "nee-plus-plus",
    }
}

impl Lights {
    /// Whether lights are chosen by a tree, where there is something to choose.
    pub fn by_tree(self) -> bool {
        self == Lights::Tree || self.learns()
    }

    /// Whether a training render comes first.
    pub fn learns(self) -> bool {
        matches!(self, Lights::Learned | Lights::NeePlusPlus)
    }
}

named_choice! {
    /// Where sample numbers come from.
    Sampler, "sampler", {
        /// Counter-based pseudo-random numbers ([`crate::sampler`]).
        Independent = "independent",
        /// Owen-scrambled Sobol points ([`crate::sampler::sobol`]); the default.
        Sobol = "sobol",
    }
}

named_choice! {
    /// Which code computes the picture. Both give the same bits.
    Engine, "engine", {
        /// Eight rays at a time.
        Packet = "packet",
        /// One ray at a time: the plain reference.
        Scalar = "scalar",
    }
}

named_choice! {
    /// Whether directions at diffuse surfaces are guided by what a training render has found ([`crate::learn::guide`]).
    Guide, "guide", {
        /// They are drawn by the BSDF alone.
        Off = "off",
        /// Half of them are guided, at every place where the training render says that it helps.
        On = "on",
        /// The same, if the strategy is one of multiple importance sampling and the training render says that it pays for the
        /// whole picture. The default.
        Auto = "auto",
    }
}

named_choice! {
    /// What Russian roulette goes by.
    Roulette, "roulette", {
        /// What is learned, where directions are guided, since roulette would else end the paths that guiding has found; else
        /// the throughput. The default.
        Auto = "auto",
        /// The largest component of the throughput.
        Throughput = "throughput",
        /// The product of the largest components of the albedos.
        Albedo = "albedo",
        /// The same, but paths are kept that are expected to bring much to their pixel, as far as a training render can tell
        /// ([`crate::learn::guide`]).
        Learned = "learned",
    }
}

named_choice! {
    /// Which variants of its stages the packet engine runs. All give the same bits: the others are there to measure what is
    /// gained by leaving out what a scene does not need.
    PlanChoice, "plan", {
        /// The least that the scene needs. The default.
        Scene = "scene",
        /// The most that any scene needs: all of the parts below are put back.
        General = "general",
        /// Smooth normals and textures alone: every triangle has a record of its corners.
        Surfaces = "surfaces",
        /// Cut-outs alone: every hit is tested, and shadow rays look for the closest.
        CutOuts = "cut-outs",
        /// The environment alone: rays that leave are shaded, by a map's variant, and light samples draw its numbers.
        Environment = "environment",
        /// The lens and the pixel filter alone.
        Lens = "lens",
        /// The light tree and the lights' textures alone, for a single lamp too.
        Lights = "lights",
        /// Queues of all material kinds and columns of all queues alone, by a look-up of every hit's class.
        Queues = "queues",
    }
}

impl PlanChoice {
    /// Whether `part`, one of [`PlanChoice::parts`], is there whether the scene needs it or not.
    pub fn puts_back(self, part: PlanChoice) -> bool {
        PlanChoice::parts().contains(&part) && (self == PlanChoice::General || self == part)
    }

    /// The parts that can be put back one by one.
    pub fn parts() -> &'static [PlanChoice] {
        &PlanChoice::ALL[2..]
    }
}

named_choice! {
    /// What an image file can hold beside radiance ([`crate::film::layers`]).
    Layer, "layer", {
        /// `Albedo.{R,G,B}`: the colours of surfaces.
        Albedo = "albedo",
        /// `N.{X,Y,Z}` and `Ns.{X,Y,Z}`: geometric and shading normals.
        Normal = "normal",
        /// `Z`: the distance along the camera's axis.
        Depth = "depth",
        /// `variance.{R,G,B}`: the variance of each pixel's mean.
        Variance = "variance",
    }
}

impl Layer {
    /// Whether any of `layers` is one that first hits tell.
    pub fn are_of_hits(layers: &[Layer]) -> bool {
        layers.iter().any(|&layer| layer != Layer::Variance)
    }
}

/// How long the training render is, before a render that learns ([`Lights::learns`], [`Guide`], [`Roulette::Learned`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Train {
    /// As the size of the film suggests.
    Auto,
    /// Nothing is learned.
    Off,
    /// About so many paths; where directions are learned and used, four times as many, eight times for large films. In a
    /// sequence, the pilots of all frames that a frame learns from have so many.
    Paths(u32),
}

impl std::fmt::Display for Train {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Train::Auto => f.pad("auto"),
            Train::Off => f.pad("off"),
            Train::Paths(paths) => std::fmt::Display::fmt(paths, f),
        }
    }
}

impl std::str::FromStr for Train {
    type Err = String;

    fn from_str(text: &str) -> Result<Train, String> {
        match text {
            "auto" => Ok(Train::Auto),
            "off" => Ok(Train::Off),
            _ => match text.parse() {
                Ok(paths) if paths > 0 => Ok(Train::Paths(paths)),
                _ => Err(format!("give a number of paths from 1 to {}, `auto` or `off`", u32::MAX)),
            },
        }
    }
}

/// A rectangle of pixels, from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

/// One of several parts of a film that are rendered by themselves, as on machines of their own, and merged: each has every
/// `count`-th tile of a fixed order, and all samples of their pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which it is, from 1.
    pub number: u32,
    /// How many there are.
    pub count: u32,
}

/// Most parts of a film.
pub const MOST_SHARDS: u32 = 1 << 20;

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let numbers = text.split_once('/').and_then(|(number, count)| {
            let [number, count] = [number, count].map(|text| text.trim().parse::<u32>().ok());
            Some(Shard { number: number?, count: count? })
        });
        let valid =
            |shard: &Shard| (1..=MOST_SHARDS).contains(&shard.count) && (1..=shard.count).contains(&shard.number);
        numbers.filter(valid).ok_or_else(|| {
            format!("give K/N, part K of N, as 2/8: whole numbers, K from 1 to N, N at most {MOST_SHARDS}")
        })
    }
}

/// The guard of an unbounded path: no path is followed past this many events; each that gets here is counted.
pub const DEPTH_GUARD: u32 = 1 << 20;

/// What to render and how. `Default` is the contract's default; [`crate::Scene::settings`] adds what a scene file says.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Samples a pixel, at least 1.
    pub spp: u32,
    /// Stop after the first whole pass past this wall time, even if `spp` is not reached.
    pub time: Option<Duration>,
    /// Stop after the first whole pass at which the picture's estimated relative error is at or below this, even if `spp` is
    /// not reached: what its samples' spread tells ([`crate::Film::relative_error`]) and, where paths meet light by chance,
    /// what they may have missed of it ([`crate::Stats::unseen_error`]), as the root of the sum of the squares. Not before 16
    /// samples a pixel and 16,384 in all.
    pub target_error: Option<f64>,
    /// How direct light is estimated.
    pub strategy: Strategy,
    /// How light samples choose lights.
    pub lights: Lights,
    /// Whether directions are guided.
    pub guide: Guide,
    /// What roulette goes by.
    pub roulette: Roulette,
    /// How long the training render is, where something is learned.
    pub train: Train,
    /// Where sample numbers come from.
    pub sampler: Sampler,
    /// Scattering events a path may have; `None`: unbounded (to the guard of 2^20).
    pub max_depth: Option<u32>,
    /// First depth at which roulette may end a path; `None`: never.
    pub rr_depth: Option<u32>,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Which code computes the picture.
    pub engine: Engine,
    /// Which variants of its stages the packet engine runs.
    pub plan: PlanChoice,
    /// Worker threads; 0: one for every core.
    pub threads: usize,
    /// Film width; `None`: the scene's.
    pub width: Option<u32>,
    /// Film height; `None`: the scene's.
    pub height: Option<u32>,
    /// The part of the film to render; `None`: all of it.
    pub crop: Option<Crop>,
    /// The tiles of that to render; `None`: all of them. The film of such a render is a strip of them: see
    /// [`crate::internal::film::part`].
    pub shard: Option<Shard>,
    /// What image files hold beside radiance. No bit of the radiance depends on it.
    pub layers: Vec<Layer>,
    /// Albedo and normals are those of the first surface that neither mirrors nor is glass, as seen in mirrors and through glass.
    pub layers_through_specular: bool,
    /// Camera rays that leave the scene see nothing: black, and the film has an alpha channel. The environment still lights the
    /// scene, and shows in mirrors and through glass.
    pub hide_environment: bool,
}

/// Where roulette goes by albedos, their product counts at least this: random numbers have 24 bits.
pub const LEAST_ALBEDO: f32 = 1.0 / 16_777_216.0;

/// Roulette may end a path from this depth on, unless told otherwise. By efficiency over ten scenes (64 samples, light tree,
/// `sobol`) 3 and 4 are 5 % better than 2 in the mean; later starts gain where paths soon leave the scene (1.4 times on
/// `lecture_lights` and `sky`) and lose in closed ones (0.8 times on `builtin:heavy`), 4 more so than 3.
pub const DEFAULT_RR_DEPTH: u32 = 3;

impl Settings {
    /// The defaults with nothing learned: lights by the light tree, directions by the BSDF, roulette by the throughput.
    pub fn plain() -> Settings {
        Settings::default().without_learning()
    }

    /// Whether the film is to have what first hits tell ([`crate::film::layers`]).
    pub fn gathers_layers(&self) -> bool {
        self.hide_environment || Layer::are_of_hits(&self.layers)
    }

    /// Whether anything is to be learned, unless training is switched off.
    pub fn learns(&self) -> bool {
        self.lights.learns() || self.guide != Guide::Off || self.roulette == Roulette::Learned
    }

    /// The same without anything learned: what would be is as in [`Settings::plain`].
    pub fn without_learning(self) -> Settings {
        let lights = if self.lights.learns() { Lights::Tree } else { self.lights };
        let roulette = match self.roulette {
            Roulette::Auto | Roulette::Learned => Roulette::Throughput,
            roulette => roulette,
        };
        Settings { lights, guide: Guide::Off, roulette, ..self }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            spp: 64,
            time: None,
            target_error: None,
            strategy: Strategy::MisPower,
            lights: Lights::Learned,
            guide: Guide::Auto,
            roulette: Roulette::Auto,
            train: Train::Auto,
            sampler: Sampler::Sobol,
            max_depth: None,
            rr_depth: Some(DEFAULT_RR_DEPTH),
            seed: 0,
            engine: Engine::Packet,
            plan: PlanChoice::Scene,
            threads: 0,
            width: None,
            height: None,
            crop: None,
            shard: None,
            layers: vec![Layer::Variance],
            layers_through_specular: false,
            hide_environment: false,
        }
    }
}

/// Most columns or rows a film may have.
pub const MAX_FILM_SIDE: u32 = 65_535;
/// Most pixels one render may hold: its film then takes 12 GiB, or 36 GiB with the groups of the `sobol` sampler.
pub const MAX_FILM_PIXELS: u64 = 1 << 28;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_counted_from_one() {
        assert_eq!("2/8".parse(), Ok(Shard { number: 2, count: 8 }));
        assert_eq!(Shard { number: 2, count: 8 }.to_string(), "2/8");
        for text in ["", "2", "0/8", "9/8", "1/0", "-1/8", "1/8/2", "a/b", "1/99999999", "1.5/2"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
