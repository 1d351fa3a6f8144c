//! What learning came to, for people and reports.

/// Of a render that was to learn its lights.
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
    /// Paths of the pilot.
    pub paths: u64,
    /// Bytes of the tables, used or not.
    pub bytes: usize,
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
            bytes: 0,
            seconds: 0.0,
            cpu_seconds: 0.0,
        }
    }
}
