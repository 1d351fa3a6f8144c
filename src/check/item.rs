//! A check: its name and what it does.

use crate::api::Scene;
use crate::check::row::Outcome;
use crate::error::Result;
use crate::settings::Settings;
use crate::tables::PreparedScene;

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// A sixteenth, for tests of the checks themselves.
    Quick,
    /// About a minute for the whole suite on two cores.
    Default,
    /// A hundred times as much.
    Thorough,
}

/// How much is tried, and by how many threads.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// How much.
    pub level: Level,
    /// Checks made at once; each renders on one thread.
    pub threads: usize,
}

impl Effort {
    /// How many cases to try where the default is `usual`.
    pub fn cases(&self, usual: u64) -> u64 {
        match self.level {
            Level::Quick => (usual / 16).max(1),
            Level::Default => usual,
            Level::Thorough => usual * 100,
        }
    }

    /// Samples a pixel, or renders with a seed each, where the default is `usual`: never below `least`.
    pub fn samples(&self, usual: u32, least: u32) -> u32 {
        (self.cases(u64::from(usual)).min(1 << 24) as u32).max(least)
    }
}

/// A check of the built-in suite.
pub struct Check {
    /// The group.
    pub group: &'static str,
    /// What it watches over; with the group before it, its name.
    pub what: &'static str,
    /// Makes it.
    pub run: fn(&Effort) -> Result<Outcome>,
}

/// A scene to check.
pub struct SceneSubject<'a> {
    /// What its files say.
    pub scene: &'a Scene,
    /// The scene as it was named: what `octray trace` takes.
    pub path: &'a str,
    /// Its tables.
    pub prepared: &'a PreparedScene,
    /// The settings its file asks for.
    pub settings: Settings,
}

/// A check that applies to a scene.
pub struct SceneCheck {
    /// The group.
    pub group: &'static str,
    /// What it watches over.
    pub what: &'static str,
    /// Makes it.
    pub run: fn(&SceneSubject, &Effort) -> Result<Outcome>,
}
