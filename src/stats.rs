//! What a render cost and met: numbers for reports, which nothing reads to decide anything.

use crate::film::NonFinite;
use crate::learn::outcome::Learning;

/// Rays of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct RayCounts {
    /// Camera rays.
    pub camera: u64,
    /// Rays after a scattering event.
    pub bounce: u64,
    /// Shadow rays.
    pub shadow: u64,
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.camera + self.bounce + self.shadow
    }
}

/// One stage's work: lanes used and possible, and seconds summed over threads.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct StageStats {
    /// The stage's name in the plan.
    pub stage: &'static str,
    /// Lanes that held work.
    pub lanes_used: u64,
    /// Lanes that could have.
    pub lanes_possible: u64,
    /// Wall seconds spent in it, summed over threads.
    pub seconds: f64,
    /// Of a stage that traces rays: rays that took part in the steps of packets through the tree (one-ray walks have none).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walk_lanes_used: Option<u64>,
    /// Rays that could have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walk_lanes_possible: Option<u64>,
}

/// What a render cost and met.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// Worker threads used.
    pub threads: usize,
    /// Wall seconds of what this render's settings needed built before it began (light tree, sampling tables).
    pub setup_s: f64,
    /// Wall seconds of rendering alone.
    pub render_s: f64,
    /// CPU seconds of rendering alone, user and system, all threads.
    pub cpu_s: f64,
    /// Wall seconds of gathering layers, which are not among those of rendering; `None`: there were none to gather.
    pub layers_s: Option<f64>,
    /// What learning came to and cost; its seconds are among those of rendering, its rays among none. `None`: nothing was to be
    /// learned.
    pub learning: Option<Learning>,
    /// Camera paths followed.
    pub paths: u64,
    /// Rays traced.
    pub rays: RayCounts,
    /// Per stage, in the order of the plan; empty for the scalar engine.
    pub stages: Vec<StageStats>,
    /// How many samples were not finite.
    pub nonfinite: u64,
    /// The first few of them.
    pub nonfinite_samples: Vec<NonFinite>,
    /// What light that no sample has met may add to the picture's relative error, as a target error counts it
    /// ([`crate::film::RelativeError::unseen`]); `None` without a target error and for a black picture.
    pub unseen_error: Option<f64>,
    /// Paths that reached the depth guard.
    pub guarded: u64,
    /// Tiles rendered, each once for every pass over it.
    pub tiles: u64,
    /// How often worker threads have locked something they share or changed a shared atomic in place, counted where they do:
    /// three times a tile (it is taken, it is locked, its samples are added up) and once a worker and pass, when no tile is
    /// left. A lock counts once, with its release. What threads are started and joined by is not among them, nor is training.
    pub shared_operations: u64,
    /// What the user should know of the settings, one sentence each; scenes have warnings of their own
    /// ([`crate::PreparedScene::warnings`]).
    pub warnings: Vec<String>,
    /// Every sample that was asked for has been taken (false after a stop).
    pub finished: bool,
}
