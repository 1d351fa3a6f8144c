//! Weights of multiple importance sampling (Veach 1997, section 9.2), as ratios that cannot overflow.
//!
//! Densities are per steradian, above 0 and possibly infinite; the other technique's may be 0.

use super::Real;
use crate::fault::{Fault, planted};
use crate::strategy::Weight;

/// The balance heuristic: the weight of a sample that technique `a` drew with density `p_a`, where `b` would have had `p_b`.
pub fn balance(p_a: Real, p_b: Real) -> Real {
    1.0 / (1.0 + ratio(p_a, p_b))
}

/// The power heuristic with beta = 2.
pub fn power(p_a: Real, p_b: Real) -> Real {
    let ratio = ratio(p_a, p_b);
    1.0 / (1.0 + ratio * ratio)
}

/// The other technique's density over this one's.
fn ratio(p_a: Real, p_b: Real) -> Real {
    match () {
        _ if planted(Fault::SwappedPdf) => p_a / p_b,
        _ if planted(Fault::DensityTwice) => 2.0 * p_b / p_a,
        _ if planted(Fault::WeightOfNoNumber) && Real::EPSILON > 1e-10 => {
            if (p_b / p_a).is_nan() {
                Real::INFINITY
            } else {
                1.000_001 * p_b / p_a
            }
        }
        _ => p_b / p_a,
    }
}

/// What a sample drawn with density `p_a` counts by a strategy's rule, where the other technique would have had `p_b`.
pub fn weigh(rule: Weight, p_a: Real, p_b: Real) -> Real {
    match rule {
        Weight::Zero => 0.0,
        Weight::One => 1.0,
        Weight::Half => 0.5,
        Weight::Balance => balance(p_a, p_b),
        Weight::TwiceBalance => 2.0 * balance(p_a, p_b),
        Weight::Power => power(p_a, p_b),
    }
}
