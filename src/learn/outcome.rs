//! What learning came to, for people and reports.

/// Of a render that was to learn something; what stands here by itself is what was learned of lights.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Learning {
    /// Whether lights are chosen by what was learned.
    pub used: bool,
    /// Why, or why not.
    pub why: String,
    /// The second moment of light samples with what was learned over that without ([`crate::learn::forecast`]).
    pub forecast: Option<f64>,
    /// Columns and rows of the pilot's grid; `null`: there was no pilot.
    pub grid: Option<(u32, u32)>,
    /// Paths of the pilot, or of those of all frames whose training adds up.
    pub paths: u64,
    /// Frames whose training adds up; 1: an image's or a frame's own.
    pub frames: u32,
    /// Bytes of the tables, used or not.
    pub bytes: usize,
    /// What was learned of the environment map; `null`: nothing was to be.
    pub environment: Option<EnvironmentLearning>,
    /// What was learned of directions; `null`: nothing was to be.
    pub guide: Option<GuideLearning>,
    /// Wall seconds of the pilot.
    pub seconds: f64,
    /// CPU seconds of the pilot, all threads.
    pub cpu_seconds: f64,
}

impl Learning {
    /// Nothing was tried.
    pub fn none(why: &str) -> Learning {
        Learning {
            used: false,
            why: why.into(),
            forecast: None,
            grid: None,
            paths: 0,
            frames: 1,
            bytes: 0,
            environment: None,
            guide: None,
            seconds: 0.0,
            cpu_seconds: 0.0,
        }
    }
}

/// Of a render that was to learn which patches of the environment map matter where.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct EnvironmentLearning {
    /// Whether light samples go by what was learned.
    pub used: bool,
    /// Why, or why not.
    pub why: String,
    /// The second moment of light samples of the map with what was learned over that without.
    pub forecast: Option<f64>,
}

/// Of a render that was to learn where light comes from.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct GuideLearning {
    /// Whether what was learned is used, for directions or roulette.
    pub used: bool,
    /// Whether directions are guided.
    pub guides: bool,
    /// Why, or why not.
    pub why: String,
    /// Second moment of what paths bring after their bounces at diffuse surfaces, over what their pixels show; `null`: nothing was
    /// recorded.
    pub indirect: Option<f64>,
    /// Leaves of the trees over cells.
    pub leaves: usize,
    /// Those of them where directions are guided.
    pub guided: usize,
    /// Bytes of the tables, if they are used.
    pub bytes: usize,
}

impl GuideLearning {
    /// Nothing was tried.
    pub fn none(why: &str) -> GuideLearning {
        GuideLearning { used: false, guides: false, why: why.into(), indirect: None, leaves: 0, guided: 0, bytes: 0 }
    }
}
