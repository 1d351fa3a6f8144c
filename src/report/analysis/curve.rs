//! An error that falls with cost, measured at a few costs: how steeply, and what lies between and beyond them.
//!
//! All of it happens in logarithms, where the law of random sampling is a straight line, and all of it is a sum over the
//! measured logarithms with known factors: so what is read off is as uncertain as that sum (Welch 1947, Satterthwaite 1946).
//! No point weighs more for looking more certain: the standard errors come from few runs themselves, and a weight that
//! depends on them pulls the line to where the runs happened to agree.

use serde::Serialize;

use crate::report::analysis::statistics::{Interval, LogError, student_quantile};

/// What was measured at one cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Samples or seconds, above 0.
    pub cost: f64,
    /// The squared error, above 0.
    pub value: f64,
    /// How certain the logarithm of `value` is; `None` of one run.
    pub error: Option<LogError>,
}

/// The exponent of a power of the cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slope {
    /// The exponent: the slope of the line of least squares through the logarithms.
    pub value: f64,
    /// Its interval. Where the points lie on no line it is that of the mean slope over what was measured.
    pub interval: Option<Interval>,
}

/// The cost of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// The cost.
    pub value: f64,
    /// Its 95 % interval.
    pub interval: Option<Interval>,
    /// Outside of what was measured.
    pub extrapolated: bool,
}

/// Why a cost cannot be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    /// No cost brings it: the strategy is biased.
    Never,
    /// The error does not fall measurably where the cost would be read off.
    DoesNotFall,
    /// The ends of the interval are more than a factor of [`MOST_SPREAD`] apart, or nothing was measured to tell it by.
    TooUncertain,
}

/// An interval whose ends are further apart than this factor tells nothing.
pub const MOST_SPREAD: f64 = 100.0;

/// Costs this close together are one.
const SAME_COST: f64 = 1.05;
/// The slope beyond what was measured is that of so many points next to it: curves bend.
const NEAREST: usize = 3;
/// The 99 % point of chi-square with one degree of freedom: a larger square is no chance.
const CHANCE: f64 = 6.635;

/// Measured points, by cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve(Vec<Knot>);

/// A sum of the measured logarithms.
struct Sum {
    value: f64,
    /// Its variance, and what its degrees of freedom are made of; `None` where a point in it knows no error.
    variance: Option<(f64, f64)>,
}

impl Curve {
    /// The curve through `knots`, in any order; those without a cost or a value above 0 are left out, and those of the same
    /// cost taken together. `None` if none is left.
    pub fn new(knots: impl IntoIterator<Item = Knot>) -> Option<Curve> {
        let mut knots: Vec<Knot> = knots.into_iter().filter(|knot| knot.cost > 0.0 && knot.value > 0.0).collect();
        knots.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let groups = knots.chunk_by(|a, b| b.cost < SAME_COST * a.cost);
        let curve = Curve(groups.map(together).collect());
        (!curve.0.is_empty()).then_some(curve)
    }

    /// The slope of the line of least squares, and its interval of `confidence`; `None` of one cost.
    pub fn slope(&self, confidence: f64) -> Option<Slope> {
        let weights = slope_weights(&self.0)?;
        let sum = self.sum(&weights);
        let interval = sum.variance.map(|(variance, lost)| {
            Interval::around(sum.value, student_quantile(confidence, variance * variance / lost) * variance.sqrt())
        });
        Some(Slope { value: sum.value, interval: interval.filter(|interval| interval.low.is_finite()) })
    }

    /// The slope beyond the last measured point, by which a line goes on from there; -1, that of independent samples, of one
    /// point.
    pub fn last_slope(&self) -> f64 {
        self.slope_at(self.0.len() - 1).0
    }

    /// The cost at which the curve takes `value`, which is uncertain by `error` itself.
    ///
    /// Between measured points it is read off a cubic through them whose tangents are those of parabolas through three;
    /// beyond them it goes on from the nearest point along the slope of the nearest three. Where that slope is not, by chance, the
    /// slope of all, the difference counts as an error of the slope: what has bent may go on bending.
    ///
    /// # Errors
    /// [`Unknown::DoesNotFall`] and [`Unknown::TooUncertain`].
    pub fn cost_of(&self, value: f64, error: Option<LogError>) -> Result<Cost, Unknown> {
        let target = value.ln();
        let above = |knot: &Knot| knot.value.ln() >= target;
        let crossing = (1..self.0.len()).rev().find(|i| above(&self.0[i - 1]) != above(&self.0[*i]));
        let (at, extrapolated) = match crossing {
            Some(right) => (self.inside(right - 1, target)?, false),
            None if above(&self.0[0]) => (self.beyond(self.0.len() - 1, target)?, true),
            None => (self.beyond(0, target)?, true),
        };
        let Place { log_cost, weights, slope, bend } = at;
        let own = error.map_or(Some((0.0, 0.0)), |LogError { deviation, freedom }| {
            let variance = deviation * deviation;
            Some((variance, variance * variance / freedom))
        });
        let interval = self.sum(&weights).variance.zip(own).map(|((of_curve, lost), (of_value, lost_too))| {
            let sampled = of_curve + of_value;
            let freedom =
                if sampled > 0.0 { (sampled + bend) * (sampled + bend) / (lost + lost_too) } else { f64::INFINITY };
            let half = student_quantile(0.95, freedom) * (sampled + bend).sqrt() / slope.abs();
            Interval::around_log(log_cost.exp(), half)
        });
        match interval {
            Some(Interval { low, high }) if low.is_nan() || high > MOST_SPREAD * low => Err(Unknown::TooUncertain),
            _ => Ok(Cost { value: log_cost.exp(), interval, extrapolated }),
        }
    }

    /// Where the curve takes `target` between the points `left` and the next, which lie on both sides of it.
    fn inside(&self, left: usize, target: f64) -> Result<Place, Unknown> {
        let (mut start, mut end) = (self.0[left].cost.ln(), self.0[left + 1].cost.ln());
        let starts_above = self.sum(&self.between(left, start).0).value >= target;
        for _ in 0..60 {
            let middle = (start + end) / 2.0;
            match (self.sum(&self.between(left, middle).0).value >= target) == starts_above {
                true => start = middle,
                false => end = middle,
            }
        }
        let (weights, tangent) = self.between(left, start);
        let slope = self.sum(&tangent).value;
        match slope < 0.0 {
            true => Ok(Place { log_cost: start, weights, slope, bend: 0.0 }),
            false => Err(Unknown::DoesNotFall),
        }
    }

    /// Where the line that goes on from the first or last point takes `target`.
    fn beyond(&self, end: usize, target: f64) -> Result<Place, Unknown> {
        let (slope, of_slope) = self.slope_at(end);
        let mut bend = 0.0;
        if let (Some(own), Some(all)) = (&of_slope, slope_weights(&self.0)) {
            let difference: Vec<f64> = all.iter().zip(own).map(|(all, own)| all - own).collect();
            let sum = self.sum(&difference);
            if sum.variance.is_none_or(|(variance, _)| sum.value * sum.value > CHANCE * variance) {
                bend = sum.value * sum.value;
            }
            let own = self.sum(own);
            let certain = own.variance.is_none_or(|(variance, lost)| {
                own.value + student_quantile(0.95, variance * variance / lost) * variance.sqrt() < 0.0
            });
            if !certain {
                return Err(Unknown::DoesNotFall);
            }
        }
        if slope >= 0.0 {
            return Err(Unknown::DoesNotFall);
        }
        let knot = self.0[end];
        let distance = (target - knot.value.ln()) / slope;
        let mut weights: Vec<f64> = of_slope.unwrap_or_else(|| vec![0.0; self.0.len()]);
        weights.iter_mut().for_each(|weight| *weight *= distance);
        weights[end] += 1.0;
        Ok(Place { log_cost: knot.cost.ln() + distance, weights, slope, bend: bend * distance * distance })
    }

    /// The slope at the first or last point: that of the nearest three, and what of the logarithms it is made of. Of a
    /// single point -1, and made of nothing.
    fn slope_at(&self, end: usize) -> (f64, Option<Vec<f64>>) {
        let count = self.0.len();
        let first = if end == 0 { 0 } else { count.saturating_sub(NEAREST) };
        let nearest = first..(first + NEAREST).min(count);
        match slope_weights(&self.0[nearest.clone()]) {
            Some(own) => {
                let mut weights = vec![0.0; count];
                weights[nearest].copy_from_slice(&own);
                (self.sum(&weights).value, Some(weights))
            }
            None => (-1.0, None),
        }
    }

    /// The factors of the logarithms in the curve's value at `log_cost`, between the points `left` and the next, and in its
    /// slope there: a cubic with given tangents (Hermite).
    fn between(&self, left: usize, log_cost: f64) -> (Vec<f64>, Vec<f64>) {
        let (x0, x1) = (self.0[left].cost.ln(), self.0[left + 1].cost.ln());
        let (width, t) = (x1 - x0, (log_cost - x0) / (x1 - x0));
        let (t2, t3) = (t * t, t * t * t);
        let [mut value, mut slope] = [vec![0.0; self.0.len()], vec![0.0; self.0.len()]];
        value[left] += 2.0 * t3 - 3.0 * t2 + 1.0;
        value[left + 1] += 3.0 * t2 - 2.0 * t3;
        slope[left] += 6.0 * (t2 - t) / width;
        slope[left + 1] -= 6.0 * (t2 - t) / width;
        let tangents = [(left, t3 - 2.0 * t2 + t, 3.0 * t2 - 4.0 * t + 1.0), (left + 1, t3 - t2, 3.0 * t2 - 2.0 * t)];
        for (knot, of_value, of_slope) in tangents {
            for (i, weight) in self.tangent(knot) {
                value[i] += of_value * width * weight;
                slope[i] += of_slope * weight;
            }
        }
        (value, slope)
    }

    /// The factors of the logarithms in the slope at a point of the parabola through it and its neighbours; of two points that
    /// of the line.
    fn tangent(&self, knot: usize) -> Vec<(usize, f64)> {
        let x = |i: usize| self.0[i].cost.ln();
        let last = self.0.len() - 1;
        if last == 1 {
            let width = x(1) - x(0);
            return vec![(0, -1.0 / width), (1, 1.0 / width)];
        }
        let middle = knot.clamp(1, last - 1);
        let nodes = [middle - 1, middle, middle + 1];
        // The derivative at x of Lagrange's polynomials.
        let weight = |own: usize| {
            let [a, b] = [1, 2].map(|step| nodes[(own + step) % 3]);
            let own = nodes[own];
            (own, (2.0 * x(knot) - x(a) - x(b)) / ((x(own) - x(a)) * (x(own) - x(b))))
        };
        vec![weight(0), weight(1), weight(2)]
    }

    fn sum(&self, weights: &[f64]) -> Sum {
        let of =
            |term: &dyn Fn(&Knot, f64) -> f64| self.0.iter().zip(weights).map(|(knot, w)| term(knot, *w)).sum::<f64>();
        let value = of(&|knot, weight| weight * knot.value.ln());
        let known = self.0.iter().zip(weights).all(|(knot, weight)| *weight == 0.0 || knot.error.is_some());
        let part = |knot: &Knot, weight: f64| {
            knot.error.map_or((0.0, f64::INFINITY), |error| ((weight * error.deviation).powi(2), error.freedom))
        };
        let variance = of(&|knot, weight| part(knot, weight).0);
        let lost = of(&|knot, weight| {
            let (variance, freedom) = part(knot, weight);
            variance * variance / freedom
        });
        Sum { value, variance: known.then_some((variance, lost)) }
    }
}

/// A place on the curve: what its logarithm is made of, the slope there, and the variance that bending adds.
struct Place {
    log_cost: f64,
    weights: Vec<f64>,
    slope: f64,
    bend: f64,
}

/// The factors of the logarithms in the slope of the line of least squares; `None` of one point.
fn slope_weights(knots: &[Knot]) -> Option<Vec<f64>> {
    let logs: Vec<f64> = knots.iter().map(|knot| knot.cost.ln()).collect();
    let center = logs.iter().sum::<f64>() / logs.len() as f64;
    let spread: f64 = logs.iter().map(|log| (log - center).powi(2)).sum();
    (spread > 0.0).then(|| logs.iter().map(|log| (log - center) / spread).collect())
}

/// Points of one cost as one: the means of their logarithms.
fn together(knots: &[Knot]) -> Knot {
    let [first] = knots else {
        let count = knots.len() as f64;
        let mean = |log: fn(&Knot) -> f64| (knots.iter().map(log).sum::<f64>() / count).exp();
        let variances: Option<Vec<(f64, f64)>> =
            knots.iter().map(|knot| knot.error.map(|e| ((e.deviation / count).powi(2), e.freedom))).collect();
        let error = variances.map(|parts| {
            let variance: f64 = parts.iter().map(|(variance, _)| variance).sum();
            let lost: f64 = parts.iter().map(|(variance, freedom)| variance * variance / freedom).sum();
            let freedom = if lost > 0.0 { variance * variance / lost } else { f64::INFINITY };
            LogError { deviation: variance.sqrt(), freedom }
        });
        return Knot { cost: mean(|knot| knot.cost.ln()), value: mean(|knot| knot.value.ln()), error };
    };
    *first
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knot(cost: f64, value: f64, deviation: f64) -> Knot {
        Knot { cost, value, error: Some(LogError { deviation, freedom: 1e9 }) }
    }

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
    }

    #[test]
    fn a_power_law_is_found_again_inside_and_outside() {
        let law = |x: f64| 3.0 * x.powf(-0.7);
        let curve = Curve::new([16.0, 1.0, 4.0, 64.0].map(|x| knot(x, law(x), 0.01))).unwrap();
        let slope = curve.slope(0.95).unwrap();
        near(slope.value, -0.7, 1e-12);
        // 0.01 over the root of the sum of squares of the logarithms around their mean, times 1.96.
        let half = 1.959964 * 0.01 / (5f64.sqrt() * 4f64.ln());
        near(slope.interval.unwrap().high + 0.7, half, 1e-5);
        for (x, extrapolated) in [(0.2, true), (1.5, false), (9.0, false), (63.0, false), (700.0, true)] {
            let cost = curve.cost_of(law(x), None).unwrap();
            near(cost.value, x, 1e-9);
            assert!(cost.extrapolated == extrapolated && cost.interval.unwrap().contains(x), "{cost:?}");
        }
        near(curve.last_slope(), -0.7, 1e-9);
    }

    #[test]
    fn what_is_read_off_is_as_uncertain_as_what_it_is_made_of() {
        let curve = Curve::new([1.0, 4.0, 16.0].map(|x| knot(x, 1.0 / x, 0.01))).unwrap();
        let half = |value: f64, error: f64| {
            let error = Some(LogError { deviation: error, freedom: 1e9 });
            let interval = curve.cost_of(value, error).unwrap().interval.unwrap();
            (interval.high / interval.low).ln() / 2.0 / 1.959964
        };
        // At a point: its own error; with that of the value: the root of the sum of squares.
        near(half(0.25, 0.0), 0.01, 1e-4);
        near(half(0.25, 0.02), 5f64.sqrt() * 0.01, 1e-4);
        // Far beyond: the last point's, and the slope's times the distance: 0.01 (ln 16 / 2 (x) for two of three points.
        let (step, distance) = (4f64.ln(), 1000f64.ln() - 16f64.ln());
        let slope = 0.01 / (2f64.sqrt() * step);
        let with_last = 2.0 * 0.01 * 0.01 * distance / (2.0 * step);
        near(half(1e-3, 0.0), (0.01f64.powi(2) + (slope * distance).powi(2) + with_last).sqrt(), 1e-3);
    }

    #[test]
    fn a_bent_curve_is_followed_inside_and_doubted_outside() {
        // From the slope -1 to the slope -1.5.
        let law = |x: f64| (1.0 + x / 30.0).powf(-0.5) / x;
        let bent = Curve::new([1.0, 4.0, 16.0, 64.0, 256.0].map(|x| knot(x, law(x), 0.003))).unwrap();
        for x in [2.0, 8.0, 30.0, 120.0, 250.0] {
            near(bent.cost_of(law(x), None).unwrap().value, x, 0.01);
        }
        let straight = Curve::new([1.0, 4.0, 16.0, 64.0, 256.0].map(|x| knot(x, 1.0 / x, 0.003))).unwrap();
        let width = |curve: &Curve, value: f64| {
            let interval = curve.cost_of(value, None).unwrap().interval.unwrap();
            (interval.high / interval.low).ln()
        };
        assert!(width(&bent, law(2000.0)) > 5.0 * width(&straight, 1.0 / 2000.0));
        assert!(bent.cost_of(law(2000.0), None).unwrap().interval.unwrap().contains(2000.0));
    }

    #[test]
    fn what_cannot_be_told_is_not() {
        let level = Curve::new([1.0, 4.0, 16.0].map(|x| knot(x, 1.0 + 0.001 * (x - 4.0).abs(), 0.05))).unwrap();
        assert_eq!(level.cost_of(0.5, None), Err(Unknown::DoesNotFall));
        let rising = Curve::new([(1.0, 1.0), (4.0, 0.5), (16.0, 0.8)].map(|(x, y)| knot(x, y, 0.01))).unwrap();
        assert_eq!(rising.cost_of(0.6, None), Err(Unknown::DoesNotFall));
        let noisy = Curve::new([(1.0, 1.0), (4.0, 0.3)].map(|(x, y)| knot(x, y, 0.25))).unwrap();
        assert_eq!(noisy.cost_of(1e-3, None), Err(Unknown::TooUncertain));
        assert_eq!(Curve::new([knot(0.0, 1.0, 0.1), knot(1.0, 0.0, 0.1), knot(1.0, -1.0, 0.1)]), None);
    }

    #[test]
    fn few_points_say_what_they_can() {
        let one = Curve::new([knot(4.0, 0.5, 0.1)]).unwrap();
        assert_eq!((one.slope(0.95), one.last_slope()), (None, -1.0));
        // As of independent samples; as uncertain as the point is.
        let cost = one.cost_of(0.05, None).unwrap();
        near(cost.value, 40.0, 1e-9);
        near(cost.interval.unwrap().high / cost.value, (1.959964f64 * 0.1).exp(), 1e-4);
        assert!(cost.extrapolated);
        // Single runs know no error; equal costs are one point.
        let bare = |cost: f64, value: f64| Knot { cost, value, error: None };
        let two = Curve::new([bare(4.0, 0.5), bare(4.1, 0.5), bare(1.0, 2.0)]).unwrap();
        let cost = two.cost_of(1.0, None).unwrap();
        assert!((1.9..2.1).contains(&cost.value) && cost.interval.is_none() && !cost.extrapolated, "{cost:?}");
        assert_eq!(two.slope(0.95).unwrap().interval, None);
        let merged = together(&[knot(2.0, 1.0, 0.2), knot(2.0, 4.0, 0.2)]);
        near(merged.value, 2.0, 1e-12);
        near(merged.error.unwrap().deviation, 0.2 / 2f64.sqrt(), 1e-12);
    }
}
