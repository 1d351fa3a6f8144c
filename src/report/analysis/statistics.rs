//! Statistics of repeated measurements: means with standard errors, Student's t.
//!
//! Every figure is a function of its data, so a report made twice from the same runs reads the same.

/// A range that holds the true value in 95 of 100 cases.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// `center` and `half` to both sides.
    pub fn around(center: f64, half: f64) -> Interval {
        Interval { low: center - half, high: center + half }
    }
    /// `center` divided and multiplied by e^`half`.
    pub fn around_log(center: f64, half: f64) -> Interval {
        Interval { low: center * (-half).exp(), high: center * half.exp() }
    }
    /// Both ends through `map`, which keeps or turns their order.
    pub fn map(self, map: impl Fn(f64) -> f64) -> Interval {
        let (a, b) = (map(self.low), map(self.high));
        Interval { low: a.min(b), high: a.max(b) }
    }
    /// The interval of a product of two values above 0 that are known independently; that of a ratio, with the other turned
    /// around ([`Interval::map`]). Intervals are taken as symmetric in the logarithm.
    pub fn times(self, other: Interval) -> Interval {
        let half = |of: Interval| (of.high / of.low).ln() / 2.0;
        let center = (self.low * self.high * other.low * other.high).sqrt();
        Interval::around_log(center, half(self).hypot(half(other)))
    }
    /// Whether `value` lies in it.
    pub fn contains(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// The mean of `values`; 0 of none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The variance of `values` around their mean, with n - 1; 0 below two.
fn variance(values: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    let count = values.len();
    if count < 2 {
        return 0.0;
    }
    let center = values.clone().sum::<f64>() / count as f64;
    values.map(|value| (value - center).powi(2)).sum::<f64>() / (count - 1) as f64
}

/// The standard deviation of `values` around their mean, with n - 1; 0 below two.
pub fn deviation(values: &[f64]) -> f64 {
    variance(values.iter().copied()).sqrt()
}

/// The standard normal quantile of two sides: `confidence` of all draws lie within this many standard deviations.
fn normal_quantile(confidence: f64) -> f64 {
    bisect(0.0, 40.0, |z| libm::erf(z / std::f64::consts::SQRT_2) < confidence)
}

/// Cells of the quadrature in [`student_quantile`].
const CELLS: usize = 1024;

/// Student's t of two sides: `confidence` of all draws with `freedom` degrees of freedom (at least 1) lie within it.
///
/// With t = sqrt(n) tan(angle) the density of the angle is proportional to cos^(n - 1) over [0, pi / 2]: its integral by
/// Simpson's rule, and the point where it reaches `confidence`.
pub fn student_quantile(confidence: f64, freedom: f64) -> f64 {
    let n = freedom.max(1.0);
    if n > 1e4 {
        return normal_quantile(confidence);
    }
    let width = std::f64::consts::FRAC_PI_2 / CELLS as f64;
    let density = |angle: f64| angle.cos().max(0.0).powf(n - 1.0);
    let area = |left: f64, width: f64| {
        (density(left) + 4.0 * density(left + width / 2.0) + density(left + width)) * width / 6.0
    };
    let cells: Vec<f64> = (0..CELLS).map(|i| area(i as f64 * width, width)).collect();
    let mut missing = confidence * cells.iter().sum::<f64>();
    for (i, whole) in cells.iter().enumerate() {
        if missing <= *whole {
            let left = i as f64 * width;
            let part = bisect(0.0, width, |part| area(left, part) < missing);
            return n.sqrt() * (left + part).tan();
        }
        missing -= whole;
    }
    f64::INFINITY
}

/// Where `below` turns false between `low` and `high`.
fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if below(middle) { low = middle } else { high = middle }
    }
    low
}

/// The share of 1 that each of `count` figures must hold so that all hold at once in 95 of 100 cases (Sidak).
pub fn simultaneous_95(count: usize) -> f64 {
    0.95f64.powf(1.0 / count.max(1) as f64)
}

/// The standard error of a logarithm, and its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogError {
    /// The standard error.
    pub deviation: f64,
    /// Degrees of freedom of the standard error.
    pub freedom: f64,
}

/// A mean of independent runs and how certain it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Degrees of freedom of the standard error.
    pub freedom: f64,
}

impl Estimate {
    /// The mean over runs of a sum over strata; `None` below two runs.
    ///
    /// `runs[r][t]` is what stratum `t` (a tile of the image) adds in run `r`. Tiles are independent of each other, so the
    /// variance of the sum is the sum of the tiles' variances, each estimated from the runs: a handful of runs then has as
    /// many degrees of freedom as tiles carry the noise, not one less than there are runs (Welch 1947, Satterthwaite 1946).
    pub fn of_strata(runs: &[&[f64]]) -> Option<Estimate> {
        let (count, strata) = (runs.len(), runs.first()?.len());
        if count < 2 {
            return None;
        }
        let values = |stratum: usize| runs.iter().map(move |run| run[stratum]);
        let mean = (0..strata).flat_map(values).sum::<f64>() / count as f64;
        let variances = (0..strata).map(|stratum| variance(values(stratum)) / count as f64);
        Some(Estimate::of_variances(mean, variances, count))
    }

    /// A sum over strata whose values have these variances, each estimated from `count` values.
    pub fn of_variances(mean: f64, variances: impl Iterator<Item = f64>, count: usize) -> Estimate {
        let (sum, squares) = variances.fold((0.0, 0.0), |(sum, squares), v| (sum + v, squares + v * v));
        let freedom = if squares > 0.0 { sum * sum / squares * (count - 1) as f64 } else { f64::INFINITY };
        Estimate { mean, standard_error: sum.sqrt(), freedom }
    }

    /// The same with an uncertainty of variance `variance` added, which is known and does not shrink with more runs.
    pub fn and(self, variance: f64) -> Estimate {
        let own = self.standard_error.powi(2);
        let all = own + variance.max(0.0);
        let freedom = if own > 0.0 { self.freedom * (all / own).powi(2) } else { f64::INFINITY };
        Estimate { standard_error: all.sqrt(), freedom, ..self }
    }

    /// The standard error of the mean's logarithm.
    pub fn of_logarithm(self) -> LogError {
        LogError { deviation: self.standard_error / self.mean.abs(), freedom: self.freedom }
    }

    /// The 95 % interval of a mean that cannot be negative: symmetric in the logarithm, so that it never reaches 0; `None`
    /// where the mean is not above 0.
    pub fn interval_of_logarithm(self) -> Option<Interval> {
        let half = student_quantile(0.95, self.freedom) * self.of_logarithm().deviation;
        (self.mean > 0.0 && half.is_finite()).then(|| Interval::around_log(self.mean, half))
    }

    /// The 95 % interval.
    pub fn interval(self) -> Interval {
        Interval::around(self.mean, student_quantile(0.95, self.freedom) * self.standard_error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_deviations_of_a_few_numbers() {
        assert_eq!((mean(&[1.0, 2.0, 4.0, 8.0]), deviation(&[1.0, 3.0]), deviation(&[5.0])), (3.75, 2f64.sqrt(), 0.0));
        let interval = Interval::around_log(10.0, 2f64.ln());
        assert!((interval.low - 5.0).abs() < 1e-12 && (interval.high - 20.0).abs() < 1e-12);
        assert_eq!(Interval { low: 4.0, high: 16.0 }.map(f64::sqrt), Interval { low: 2.0, high: 4.0 });
        let product = Interval::around_log(2.0, 0.3).times(Interval::around_log(5.0, 0.4));
        assert!((product.low / (10.0 * (-0.5f64).exp()) - 1.0).abs() < 1e-12, "{product:?}");
        assert_eq!(Interval { low: 2.0, high: 4.0 }.map(f64::recip), Interval { low: 0.25, high: 0.5 });
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Two-sided 95 % points of any table of Student's t, and 99 % ones.
        let table = [(1.0, 12.7062), (2.0, 4.30265), (5.0, 2.57058), (10.0, 2.22814), (30.0, 2.04227), (1e3, 1.96234)];
        for (freedom, expected) in table {
            let found = student_quantile(0.95, freedom);
            assert!((found / expected - 1.0).abs() < 2e-5, "{freedom}: {found}");
        }
        assert!((student_quantile(0.99, 5.0) / 4.03214 - 1.0).abs() < 2e-5);
        for freedom in [9.9e3, 1e5, f64::INFINITY] {
            assert!((student_quantile(0.95, freedom) - 1.95996).abs() < 4e-4, "{freedom}");
        }
        // Python: statistics.NormalDist().inv_cdf((1 + 0.95**(1/count)) / 2)
        for (count, expected) in [(1, 1.959963984540054), (9, 2.765529584339756)] {
            assert!((student_quantile(simultaneous_95(count), f64::INFINITY) - expected).abs() < 1e-9, "{count}");
        }
    }

    #[test]
    fn standard_errors_come_from_all_strata() {
        // Two strata of variance 2 and 8 (values 1 and 3, 0 and 4), two runs: (2 + 8) / 2.
        let found = Estimate::of_strata(&[&[1.0, 0.0], &[3.0, 4.0]]).unwrap();
        assert_eq!((found.mean, found.standard_error), (4.0, 5f64.sqrt()));
        assert!((found.freedom - 100.0 / 68.0).abs() < 1e-12);
        assert_eq!(Estimate::of_strata(&[&[1.0, 2.0]]), None);
        // Runs that agree leave no doubt, unless something else does.
        let sure = Estimate::of_strata(&[&[1.0, 2.0], &[1.0, 2.0]]).unwrap();
        assert_eq!(sure.interval(), Interval { low: 3.0, high: 3.0 });
        assert_eq!(sure.and(0.25).standard_error, 0.5);
        assert_eq!(Estimate { mean: 0.0, ..sure }.interval_of_logarithm(), None);
    }
}
