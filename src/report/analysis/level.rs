//! Where the error of a biased strategy ends.

use serde::Serialize;

use crate::report::analysis::bias::Floor;
use crate::report::analysis::curve::{Curve, Knot};
use crate::report::analysis::point::Point;

/// floor + constant n^slope: relMSE of n samples a pixel of a biased strategy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Level {
    /// The squared relative bias, which no number of samples lowers.
    pub floor: f64,
    /// relMSE of one sample a pixel, without it; 0 where all budgets have come to the floor.
    pub constant: f64,
    /// The exponent of what samples lower.
    pub slope: f64,
}

impl Level {
    /// The level at `floor`, and a power law for what is above it: of the budgets that are clearly above it.
    pub fn of(points: &[Point], floor: Floor) -> Level {
        let of_floor = floor.estimate.map_or(0.0, |estimate| estimate.standard_error);
        let above = |point: &Point| {
            let rest = point.relmse - floor.value;
            let own = point.relmse_estimate.map_or(0.05 * point.relmse, |estimate| estimate.standard_error);
            (rest > 2.0 * own.hypot(of_floor)).then_some(Knot { cost: point.spp, value: rest, error: None })
        };
        let above: Vec<Knot> = points.iter().filter_map(above).collect();
        let slope = Curve::new(above.iter().copied()).and_then(|curve| curve.slope(0.95)).map(|slope| slope.value);
        let slope = slope.filter(|slope| *slope < 0.0).unwrap_or(-1.0);
        // Through the middle of what is above it.
        let logs = above.iter().map(|knot| knot.value.ln() - slope * knot.cost.ln());
        let constant = if above.is_empty() { 0.0 } else { (logs.sum::<f64>() / above.len() as f64).exp() };
        Level { floor: floor.value, constant, slope }
    }

    /// relMSE of `n` samples a pixel.
    pub fn at(self, n: f64) -> f64 {
        self.floor + self.constant * n.powf(self.slope)
    }

    /// Samples a pixel for a relMSE; `None` where no number brings it, 0 where every budget has.
    pub fn samples_for(self, relmse: f64) -> Option<f64> {
        let rest = relmse - self.floor;
        let samples = if self.constant > 0.0 { (rest / self.constant).powf(1.0 / self.slope) } else { 0.0 };
        (rest > 0.0).then_some(samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_the_inverse_of_the_error() {
        let level = Level { floor: 0.001, constant: 2.0, slope: -1.2 };
        assert!((level.samples_for(level.at(37.0)).unwrap() / 37.0 - 1.0).abs() < 1e-9);
        assert_eq!((level.samples_for(0.001), level.samples_for(0.0005)), (None, None));
        let reached = Level { constant: 0.0, ..level };
        assert_eq!((reached.samples_for(0.1), reached.samples_for(0.001)), (Some(0.0), None));
    }
}
