//! What a render is asked to do: strategy, light selection, sampler, depth, roulette, engine.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

macro_rules! named_choice {
    ($(#[$doc:meta])* $name:ident, $what:literal, { $($(#[$vdoc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$vdoc])* $variant,)* }
        impl $name {
            /// Every choice, in the order of the documentation.
            pub const ALL: &'static [$name] = &[$($name::$variant,)*];
            /// The name on the command line and in files.
            pub fn name(self) -> &'static str {
                match self { $($name::$variant => $text,)* }
            }
        }
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }
        impl FromStr for $name {
            type Err = String;
            fn from_str(text: &str) -> Result<Self, String> {
                match text {
                    $($text => Ok($name::$variant),)*
                    _ => Err(format!("unknown {} `{text}`; known: {}", $what, [$($text),*].join(", "))),
                }
            }
        }
    };
}

named_choice! {
    /// How direct light is estimated: the steps of the lecture, in its order.
    Strategy, "strategy", {
        /// Directions uniform over the hemisphere, no light samples. Exact.
        Uniform = "uniform",
        /// Directions by the BSDF, no light samples. Exact.
        Bsdf = "bsdf",
        /// First attempt: light samples and hit emission both count whole. **Biased**: direct light counts twice.
        NeeSum = "nee-sum",
        /// Second attempt: both count half. Exact.
        NeeAverage = "nee-average",
        /// Hit emission never counts. **Biased**: lights are black, mirrored lights and caustics are lost.
        NeeNoEmission = "nee-no-emission",
        /// Hit emission counts only where light sampling cannot work (depth 0, after a delta lobe). Exact.
        Nee = "nee",
        /// Balance heuristic by a fair coin at every vertex. Exact.
        MisOneSample = "mis-one-sample",
        /// Both techniques, balance heuristic (Veach 1997, section 9.2). Exact.
        MisBalance = "mis-balance",
        /// Both techniques, power heuristic with beta = 2. Exact; the default.
        MisPower = "mis-power",
    }
}

named_choice! {
    /// How a light sample chooses its light.
    Lights, "light selection", {
        /// Every light triangle with the same probability.
        Uniform = "uniform",
        /// In proportion to emitted power.
        Power = "power",
    }
}

named_choice! {
    /// Where sample numbers come from.
    Sampler, "sampler", {
        /// Counter-based pseudo-random numbers ([`crate::sampler`]).
        Independent = "independent",
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

impl Strategy {
    /// Whether light sources are sampled.
    pub fn samples_lights(self) -> bool {
        !matches!(self, Strategy::Uniform | Strategy::Bsdf)
    }
    /// Whether the expected picture is wrong on purpose.
    pub fn is_biased(self) -> bool {
        matches!(self, Strategy::NeeSum | Strategy::NeeNoEmission)
    }
    /// Whether weights come from the densities of both techniques.
    pub fn is_mis(self) -> bool {
        matches!(self, Strategy::MisOneSample | Strategy::MisBalance | Strategy::MisPower)
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

/// The guard of an unbounded path: no path is followed past this many events; each that gets here is counted.
pub const DEPTH_GUARD: u32 = 1 << 20;

/// What to render and how. `Default` is the contract's default; [`crate::Scene::settings`] adds what a scene file says.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Samples a pixel, at least 1.
    pub spp: u32,
    /// Stop after the first whole pass past this wall time, even if `spp` is not reached.
    pub time: Option<Duration>,
    /// How direct light is estimated.
    pub strategy: Strategy,
    /// How light samples choose lights.
    pub lights: Lights,
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
    /// Worker threads; 0: one for every core.
    pub threads: usize,
    /// Film width; `None`: the scene's.
    pub width: Option<u32>,
    /// Film height; `None`: the scene's.
    pub height: Option<u32>,
    /// The part of the film to render; `None`: all of it.
    pub crop: Option<Crop>,
}

/// Roulette may end a path from this depth on, unless told otherwise.
pub const DEFAULT_RR_DEPTH: u32 = 2;

impl Default for Settings {
    fn default() -> Self {
        Settings {
            spp: 64,
            time: None,
            strategy: Strategy::MisPower,
            lights: Lights::Uniform,
            sampler: Sampler::Independent,
            max_depth: None,
            rr_depth: Some(DEFAULT_RR_DEPTH),
            seed: 0,
            engine: Engine::Packet,
            threads: 0,
            width: None,
            height: None,
            crop: None,
        }
    }
}
