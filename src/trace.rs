//! What one path met, written down by either engine: records for `octray trace` and for tests, which no image needs.
//!
//! Both engines give a list of [`PathStep`], one a ray of the path. Equal paths have equal lists, to the last bit;
//! [`first_difference`] says where two part.

/// One step of a path of the scalar reference. Vectors are scene units and linear Rec.709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceVertex {
    /// Scattering events before this step.
    pub depth: u32,
    /// What happened: `ray`, `hit`, `miss`, `emission`, `environment`, `light sample`, `diffuse`, `mirror`, `roulette`, ..
    pub event: &'static str,
    /// The triangle concerned, [`crate::bvh::ray::NO_HIT`] if none.
    pub triangle: u32,
    /// The light that a light sample was sent to.
    pub light: Option<TracedLight>,
    /// Ray parameter of the hit, where there is one.
    pub t: f64,
    /// Where it happened; of a `ray` its origin.
    pub position: [f64; 3],
    /// The direction concerned: of the ray, of the segment to the light (not normalised), of the bounce.
    pub direction: [f64; 3],
    /// Throughput after this step.
    pub beta: [f64; 3],
    /// What this step adds to the radiance, or would if its light sample were not blocked.
    pub gain: [f64; 3],
    /// Radiance gathered so far.
    pub radiance: [f64; 3],
    /// The radiance of the light that was met or sampled.
    pub emitted: [f64; 3],
    /// Of a light sample BSDF times cosine, of a bounce that over the density: the factor on the throughput.
    pub bsdf: [f64; 3],
    /// Density of the direction or light sample concerned (per steradian), where there is one; infinite for a delta lobe.
    pub pdf: f64,
    /// The density with which the other technique would have drawn the direction, where it could have.
    pub pdf_other: f64,
    /// MIS weight, where there is one.
    pub weight: f64,
    /// Of choosing the light, or of surviving roulette.
    pub probability: f64,
    /// Of a light sample, the probability with which roulette has let its shadow ray be traced: `emitted` is over it. 1: it
    /// played none.
    pub survival: f64,
    /// What else there is to say: why a path ends, why a light sample brings nothing, which way emission was found.
    pub note: &'static str,
}

impl TraceVertex {
    /// Whether every number is finite (an infinite density or ray parameter is allowed: it means a delta lobe or a miss).
    pub fn is_finite(&self) -> bool {
        self.beta.iter().chain(&self.radiance).all(|c| c.is_finite()) && !self.pdf.is_nan() && !self.weight.is_nan()
    }
}

/// The event of a [`TraceVertex`] with which a [`PathStep`] begins.
pub const RAY: &str = "ray";
/// The event of a light sample that arrives.
pub const LIGHT_SAMPLE: &str = "light sample";
/// The event of a light sample that something blocks.
pub const LIGHT_SAMPLE_BLOCKED: &str = "light sample, blocked";

/// The event of a light sample that was drawn and can bring nothing: no shadow ray is traced.
pub const LIGHT_SAMPLE_IDLE: &str = "light sample, nothing";
/// The event of a path that roulette ends.
pub const ROULETTE: &str = "roulette";
/// The event of a path that roulette lets go on.
pub const ROULETTE_SURVIVED: &str = "roulette survived";
/// The event of a coin that chooses between light sample and BSDF sample.
pub const COIN: &str = "coin";
/// The event of a path that ends otherwise than by leaving the scene or by roulette.
pub const END: &str = "end";

/// The light of a light sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TracedLight {
    /// What surrounds the scene.
    Environment,
    /// The emissive triangle with this id.
    Triangle(u32),
    /// The delta light with this number, of those of the scene that shine.
    Delta(u32),
}

/// A shadow ray and what it carries.
#[derive(Clone, Copy, Debug)]
pub struct ShadowStep {
    /// The segment, not normalised, scene units.
    pub direction: [f32; 3],
    /// What the path gains if nothing blocks the segment.
    pub contribution: [f32; 3],
    /// Something does.
    pub blocked: bool,
}

/// One ray of a path, its hit, and what was gathered up to and including that hit.
#[derive(Clone, Copy, Debug)]
pub struct PathStep {
    /// Where the ray starts, scene units.
    pub origin: [f32; 3],
    /// Its unit direction.
    pub direction: [f32; 3],
    /// The throughput it carries.
    pub beta: [f32; 3],
    /// The triangle it hits, [`crate::bvh::ray::NO_HIT`] if none.
    pub triangle: u32,
    /// Ray parameter of the hit, infinite without one.
    pub t: f32,
    /// The shadow ray of a light sample that could contribute.
    pub shadow: Option<ShadowStep>,
    /// Radiance gathered so far.
    pub radiance: [f32; 3],
}

/// One value of a [`PathStep`]; values are equal if their bits are.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    /// A triangle id.
    Triangle(u32),
    /// A number.
    Number(f32),
    /// A vector or colour.
    Vector([f32; 3]),
    /// Yes or no.
    Flag(bool),
    /// There is none.
    None,
}

impl PartialEq for Value {
    fn eq(&self, other: &Value) -> bool {
        match (self, other) {
            (Value::Triangle(a), Value::Triangle(b)) => a == b,
            (Value::Number(a), Value::Number(b)) => a.to_bits() == b.to_bits(),
            (Value::Vector(a), Value::Vector(b)) => a.map(f32::to_bits) == b.map(f32::to_bits),
            (Value::Flag(a), Value::Flag(b)) => a == b,
            (Value::None, Value::None) => true,
            _ => false,
        }
    }
}

impl PathStep {
    /// Every value with its name, in the order in which an engine computes them.
    pub fn values(&self) -> [(&'static str, Value); 9] {
        let shadow = self.shadow;
        let of_shadow = |value: fn(ShadowStep) -> Value| shadow.map_or(Value::None, value);
        [
            ("origin", Value::Vector(self.origin)),
            ("direction", Value::Vector(self.direction)),
            ("throughput", Value::Vector(self.beta)),
            ("triangle", Value::Triangle(self.triangle)),
            ("t", Value::Number(self.t)),
            ("shadow direction", of_shadow(|s| Value::Vector(s.direction))),
            ("shadow contribution", of_shadow(|s| Value::Vector(s.contribution))),
            ("shadow blocked", of_shadow(|s| Value::Flag(s.blocked))),
            ("radiance", Value::Vector(self.radiance)),
        ]
    }
}

/// The first value in which two paths differ: the depth and the value's name (`end` if one path goes on and the other does
/// not).
pub fn first_difference(a: &[PathStep], b: &[PathStep]) -> Option<(usize, &'static str)> {
    for (depth, (a, b)) in a.iter().zip(b).enumerate() {
        let pairs = a.values().into_iter().zip(b.values());
        if let Some(((name, _), _)) = pairs.into_iter().find(|((_, a), (_, b))| a != b) {
            return Some((depth, name));
        }
    }
    (a.len() != b.len()).then_some((a.len().min(b.len()), "end"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_compared_value_by_value_and_bit_by_bit() {
        let shadow = ShadowStep { direction: [1.0; 3], contribution: [0.5; 3], blocked: false };
        let step = PathStep {
            origin: [0.0; 3],
            direction: [0.0, 0.0, 1.0],
            beta: [1.0; 3],
            triangle: 3,
            t: f32::NAN,
            shadow: Some(shadow),
            radiance: [0.0; 3],
        };
        let differs = |other: PathStep| first_difference(&[step, step], &[step, other]);
        assert_eq!(differs(step), None, "NaN has bits, too");
        assert_eq!(differs(PathStep { radiance: [0.0, -0.0, 0.0], ..step }), Some((1, "radiance")));
        assert_eq!(differs(PathStep { triangle: 4, radiance: [1.0; 3], ..step }), Some((1, "triangle")));
        assert_eq!(differs(PathStep { shadow: None, ..step }), Some((1, "shadow direction")));
        let blocked = ShadowStep { blocked: true, ..shadow };
        assert_eq!(differs(PathStep { shadow: Some(blocked), ..step }), Some((1, "shadow blocked")));
        assert_eq!(first_difference(&[step], &[]), Some((0, "end")));
        assert_eq!(first_difference(&[], &[]), None);
    }
}
