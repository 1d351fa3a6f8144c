//! What a light sample is.

use super::intersect::Hit;
use super::{Real, Vec3};

/// A light sample as seen from a surface point.
pub struct LightSample {
    /// Unit direction to the light.
    pub direction: Vec3,
    /// Cosine at the surface, above 0.
    pub cosine: Real,
    /// Radiance that arrives if nothing is in between, over `survival`.
    pub radiance: Vec3,
    /// The probability with which roulette has let the shadow ray be traced; 1: none was played.
    pub survival: Real,
    /// Density per steradian, selection included, above 0; of a delta light the selection alone.
    pub pdf_dir: Real,
    /// No hit finds the light.
    pub delta: bool,
    /// The segment that must be free: from the point's ray origin in this direction (not normalised) ..
    pub shadow_direction: Vec3,
    /// .. up to this parameter.
    pub shadow_tmax: Real,
    /// What it is sent to.
    pub target: Target,
}

/// What a shadow ray is sent to.
pub enum Target {
    /// The environment, or a directional light.
    Environment,
    /// A common emitter, or a delta light at a point, a little behind its end.
    Emitter,
    /// A precise triangle that it hits at its end. What closest hits would find first blocks it.
    Triangle(u32),
    /// A triangle that rounding makes it miss. Neither that nor the emitters beside it in the same plane block it.
    Missed([u32; 4]),
}

impl Target {
    /// Whether `hit` blocks a shadow ray that ends at `tmax`.
    pub fn is_blocked_by(&self, hit: &Hit, tmax: Real) -> bool {
        match self {
            Target::Environment | Target::Emitter => hit.t <= tmax,
            Target::Triangle(id) => hit.t < tmax || (hit.t == tmax && hit.triangle < *id),
            Target::Missed(passed) => hit.t <= tmax && !passed.contains(&hit.triangle),
        }
    }
}
