//! The scalar reference: path tracing as a textbook writes it, one path at a time, early returns.
//!
//! **Law:** this folder never names `lanes`, `packet` or `wide`. It shares with the packet engine the prepared scene, the
//! sample numbers, `math` and the film, and nothing else; every formula is written here a second time, from its source.
//! The same files are compiled twice, with `Real = f32` ([`single`]: the packet engine must equal its bits) and with
//! `Real = f64` ([`double`]: the yardstick for rounding error).

pub mod double;
pub mod single;

/// One step of a path, as `octray trace` prints it. Vectors are scene units and linear Rec.709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceVertex {
    /// Scattering events before this step.
    pub depth: u32,
    /// What happened: `camera`, `emission`, `environment`, `light sample`, `diffuse`, `mirror`, `roulette`, ..
    pub event: &'static str,
    /// The triangle concerned, [`crate::bvh::ray::NO_HIT`] if none.
    pub triangle: u32,
    /// Ray parameter of the hit, where there is one.
    pub t: f64,
    /// Where it happened.
    pub position: [f64; 3],
    /// Throughput after this step.
    pub beta: [f64; 3],
    /// Radiance gathered so far.
    pub radiance: [f64; 3],
    /// Density of the direction or light sample concerned (per steradian), where there is one.
    pub pdf: f64,
    /// MIS weight, where there is one.
    pub weight: f64,
}

impl TraceVertex {
    /// Whether every number is finite (an infinite density or ray parameter is allowed: it means a delta lobe or a miss).
    pub fn is_finite(&self) -> bool {
        self.beta.iter().chain(&self.radiance).all(|c| c.is_finite()) && !self.pdf.is_nan() && !self.weight.is_nan()
    }
}
