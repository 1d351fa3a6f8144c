//! Statistics of repeated measurements: means with standard errors, Student's t, power laws.
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

    /// The standard error as a share of the mean, which is that of the mean's logarithm.
    pub fn relative_error(self) -> f64 {
        self.standard_error / self.mean.abs()
    }

    /// The 95 % interval of a mean that cannot be negative: symmetric in the logarithm, so that it never reaches 0; `None`
    /// where the mean is not above 0.
    pub fn interval_of_logarithm(self) -> Option<Interval> {
        let half = student_quantile(0.95, self.freedom) * self.relative_error();
        (self.mean > 0.0 && half.is_finite()).then(|| Interval::around_log(self.mean, half))
    }

    /// The 95 % interval.
    pub fn interval(self) -> Interval {
        Interval::around(self.mean, student_quantile(0.95, self.freedom) * self.standard_error)
    }
}

/// A line through (ln x, ln y): y = exp(`constant`) x^`slope`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PowerLaw {
    /// Logarithm of the value at x = 1.
    pub constant: f64,
    /// The exponent.
    pub slope: f64,
}

impl PowerLaw {
    /// The value at `x`.
    pub fn at(self, x: f64) -> f64 {
        (self.constant + self.slope * x.ln()).exp()
    }
    /// Where it takes the value `y`.
    pub fn inverse(self, y: f64) -> f64 {
        ((y.ln() - self.constant) / self.slope).exp()
    }
}

/// How certain a fitted line is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FitError {
    /// Weighted mean of ln x, where the line is most certain.
    center: f64,
    /// Standard error of ln y there.
    at_center: f64,
    /// Standard error of the slope.
    slope: f64,
    /// Degrees of freedom of both.
    freedom: f64,
}

/// A power law, how certain its slope is, and how well it describes the points.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Fit {
    /// The line of least squares, points weighted by the inverse variance of their logarithms.
    pub law: PowerLaw,
    /// 95 % interval of the slope of this line of least squares, which exists whether or not the points lie on a line.
    pub slope_interval: Option<Interval>,
    /// Chi-square of the residuals by degrees of freedom; near 1 where the points lie on a line but for their noise. Where it
    /// is larger than chance allows (1 %), what is read off the line elsewhere is less certain by its root.
    pub misfit: Option<f64>,
    #[serde(skip)]
    error: Option<FitError>,
}

impl Fit {
    /// Where the line takes the value `y`, and the 95 % interval of that place: that of the whole line, slope included, and
    /// of `y` itself, whose relative standard error is `relative_error`.
    pub fn inverse(&self, y: f64, relative_error: f64) -> (f64, Option<Interval>) {
        let x = self.law.inverse(y);
        let interval = self.error.map(|error| {
            let along = error.slope * (x.ln() - error.center);
            let of_line = error.at_center.hypot(along).hypot(relative_error);
            Interval::around_log(x, student_quantile(0.95, error.freedom) * of_line / self.law.slope.abs())
        });
        (x, interval.filter(|interval| interval.high.is_finite() && interval.low > 0.0))
    }
}

/// One x of a fit: the value there and how certain it is.
#[derive(Clone, Copy, Debug)]
pub struct FitPoint {
    /// Samples or seconds.
    pub x: f64,
    /// Measured value, above 0.
    pub y: f64,
    /// Standard error of ln y and its degrees of freedom; `None` where there was one run only.
    pub error: Option<(f64, f64)>,
}

/// Least deviation of ln y that is believed: no point rules the fit alone.
const LEAST_DEVIATION: f64 = 1e-4;

/// Fits a power law to measured points by least squares, weighted where all of them know their error; `None` below two
/// different x. The slope's interval holds `confidence` (0.95, or more where several are to hold at once).
///
/// The points' errors give those of the line, and so of its slope as the mean slope over what was measured. Where the points
/// lie further off than these errors explain (chi-square beyond its 99 % point), the law is an approximation, and what is read
/// off it ([`Fit::inverse`]) is as uncertain as the scatter (Birge's ratio) with as many degrees of freedom as residuals.
pub fn fit(points: &[FitPoint], confidence: f64) -> Option<Fit> {
    let known = points.iter().all(|point| point.error.is_some());
    let weight = |point: &FitPoint| match point.error {
        Some((deviation, _)) if known => deviation.max(LEAST_DEVIATION).powi(-2),
        _ => 1.0,
    };
    let sum = |term: &dyn Fn(&FitPoint) -> f64| points.iter().map(|point| weight(point) * term(point)).sum::<f64>();
    let all = sum(&|_| 1.0);
    let (center, height) = (sum(&|p| p.x.ln()) / all, sum(&|p| p.y.ln()) / all);
    let spread = sum(&|p| (p.x.ln() - center).powi(2));
    let slope = sum(&|p| (p.x.ln() - center) * (p.y.ln() - height)) / spread;
    if spread.is_nan() || spread <= 0.0 || !slope.is_finite() {
        return None;
    }
    let law = PowerLaw { constant: height - slope * center, slope };
    if !known {
        return Some(Fit { law, slope_interval: None, misfit: None, error: None });
    }
    let residuals = points.len() as f64 - 2.0;
    let misfit = (residuals > 0.0).then(|| sum(&|p| (p.y / law.at(p.x)).ln().powi(2)) / residuals);
    // Welch and Satterthwaite: the slope is a sum of the points' logarithms with these shares of its variance.
    let share = |p: &FitPoint| weight(p) * (p.x.ln() - center).powi(2) / spread;
    let lost: f64 = points.iter().filter_map(|p| Some(share(p).powi(2) / p.error?.1)).sum();
    let half = student_quantile(confidence, lost.recip()) / spread.sqrt();
    let (widening, freedom) = match misfit {
        Some(misfit) if misfit > chi_square_99(residuals) / residuals => (misfit.sqrt(), residuals),
        _ => (1.0, lost.recip()),
    };
    let error = FitError { center, at_center: widening / all.sqrt(), slope: widening / spread.sqrt(), freedom };
    Some(Fit { law, slope_interval: Some(Interval::around(slope, half)), misfit, error: Some(error) })
}

/// The 99 % point of chi-square with `freedom` degrees of freedom (Wilson and Hilferty 1931; within 3 % from 1 on).
fn chi_square_99(freedom: f64) -> f64 {
    let part = 2.0 / (9.0 * freedom);
    freedom * (1.0 - part + 2.326_347_9 * part.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{random_words, unit};

    /// Sums of 12 uniform numbers less 6: mean 0, variance 1, nearly normal.
    fn normal(stream: u32, index: u32) -> f64 {
        let words = (0..3).flat_map(|block| random_words(stream, index, block, 99));
        words.map(|word| unit(word) as f64).sum::<f64>() - 6.0
    }

    #[test]
    fn means_and_deviations_of_a_few_numbers() {
        assert_eq!((mean(&[1.0, 2.0, 4.0, 8.0]), deviation(&[1.0, 3.0]), deviation(&[5.0])), (3.75, 2f64.sqrt(), 0.0));
        let interval = Interval::around_log(10.0, 2f64.ln());
        assert!((interval.low - 5.0).abs() < 1e-12 && (interval.high - 20.0).abs() < 1e-12);
        assert_eq!(Interval { low: 4.0, high: 16.0 }.map(f64::sqrt), Interval { low: 2.0, high: 4.0 });
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
        // Tables of chi-square: 6.635, 11.345, 23.209.
        for (freedom, expected) in [(1.0, 6.635), (3.0, 11.345), (10.0, 23.209)] {
            assert!((chi_square_99(freedom) / expected - 1.0).abs() < 0.03, "{freedom}: {}", chi_square_99(freedom));
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

    #[test]
    fn a_power_law_is_found_again() {
        let point = |x: f64| FitPoint { x, y: 3.0 * x.powf(-0.7), error: Some((0.01 * x, 50.0)) };
        let found = fit(&[1.0, 4.0, 16.0].map(point), 0.95).unwrap();
        assert!((found.law.slope + 0.7).abs() < 1e-12 && (found.law.at(1.0) - 3.0).abs() < 1e-12);
        assert!((found.law.inverse(found.law.at(7.0)) - 7.0).abs() < 1e-9);
        let (x, interval) = found.inverse(found.law.at(700.0), 0.0);
        let interval = interval.unwrap();
        assert!((x / 700.0 - 1.0).abs() < 1e-9 && interval.contains(x) && interval.high / interval.low > 1.05);
        let twice = FitPoint { x: 2.0, y: 1.0, error: None };
        assert!(fit(&[twice, twice], 0.95).is_none() && fit(&[], 0.95).is_none());
        let single = [(1.0, 1.0), (2.0, 0.5)].map(|(x, y)| FitPoint { x, y, error: None });
        let found = fit(&single, 0.95).unwrap();
        assert_eq!((found.slope_interval, found.inverse(0.25, 0.0).1), (None, None));
    }

    #[test]
    fn points_off_the_line_widen_what_is_read_off_it() {
        let width = |interval: Interval| (interval.high / interval.low).ln();
        let beyond = |fit: &Fit| width(fit.inverse(fit.law.at(1e3), 0.0).1.unwrap());
        let point =
            |i: i32, factor: f64| FitPoint { x: 4f64.powi(i), y: 4f64.powi(-i) * factor, error: Some((0.01, 1e9)) };
        let bent = fit(&[0, 1, 2, 3].map(|i| point(i, 1.0 + 0.01 * 4f64.powi(i))), 0.95).unwrap();
        let straight = fit(&[0, 1, 2, 3].map(|i| point(i, 1.0)), 0.95).unwrap();
        assert!(bent.misfit.unwrap() > 10.0 && beyond(&bent) > 3.0 * beyond(&straight), "{bent:?}");
        // The slope of the line is known as well as before: 0.01 over the spread of the logarithms.
        for found in [bent, straight] {
            let half = found.slope_interval.map(|i| (i.high - i.low) / 2.0).unwrap();
            assert!((half / 1.96 - 0.01 / (5f64.sqrt() * 4f64.ln())).abs() < 1e-5, "{found:?}");
        }
        // Pure noise is no misfit.
        let noise = fit(&[0, 1, 2, 3].map(|i| point(i, 1.0 + 0.01 * normal(5, i as u32))), 0.95).unwrap();
        assert!((beyond(&noise) / beyond(&straight) - 1.0).abs() < 0.1, "{noise:?}");
    }
}
