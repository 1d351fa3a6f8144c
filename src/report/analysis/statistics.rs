//! Statistics of repeated measurements: bootstrap intervals, power laws.
//!
//! Every figure is a function of its data and a seed, so a report made twice from the same runs reads the same.

use crate::sampler::random_words;

/// The two-sided point of the normal distribution within which `count` independent figures lie all at once in 95 of 100
/// cases (Sidak): the larger the family, the further.
pub fn simultaneous_95(count: usize) -> f64 {
    let each = 0.95f64.powf(1.0 / count.max(1) as f64);
    // erf(z / sqrt 2) = each, by halving.
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        let inside = libm::erf(middle / std::f64::consts::SQRT_2);
        if inside < each { low = middle } else { high = middle }
    }
    low
}

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
    /// Whether `value` lies in it.
    pub fn contains(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// The mean of `values`; 0 of none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The standard deviation of `values` around their mean, with n - 1; 0 below two.
pub fn deviation(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    let center = mean(values);
    let squares: f64 = values.iter().map(|value| (value - center).powi(2)).sum();
    (squares / (values.len() - 1) as f64).sqrt()
}

/// The value below which the share `q` of the sorted `values` lies, linear between neighbours.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let position = q * (sorted.len().max(1) - 1) as f64;
    let (below, share) = (position.floor() as usize, position.fract());
    let at = |i: usize| sorted.get(i).copied().unwrap_or(f64::NAN);
    if share == 0.0 { at(below) } else { at(below) * (1.0 - share) + at(below + 1) * share }
}

/// The middle 95 % of `values`.
pub fn percentile_interval(values: &[f64]) -> Interval {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    Interval { low: quantile(&sorted, 0.025), high: quantile(&sorted, 0.975) }
}

/// Bootstrap replicates of the mean over runs of a sum over strata; `None` below two runs.
///
/// `runs[r][t]` is what stratum `t` (a tile of the picture) adds in run `r`. Pixels are independent of each other, so runs
/// are drawn anew in every stratum (a stratified bootstrap: Davison and Hinkley, *Bootstrap Methods and their Application*,
/// 1997, section 3.2): a handful of runs then has as many ways to fall as there are tiles. Resampling `n` values spreads
/// sqrt((n - 1) / n) times as far as the mean of `n` does; the replicates are widened by the inverse.
pub fn bootstrap_means(runs: &[&[f64]], replicates: u32, seed: u32) -> Option<Vec<f64>> {
    let count = runs.len();
    let strata = runs.first()?.len();
    if count < 2 {
        return None;
    }
    let center = runs.iter().flat_map(|run| run.iter()).sum::<f64>() / count as f64;
    let widening = (count as f64 / (count as f64 - 1.0)).sqrt();
    // What run `run` has in one stratum; runs agree in their number.
    let part = |run: u64, stratum: usize| runs[run as usize][stratum];
    let draws = |replicate: u32| {
        let of_stratum = |stratum: usize| {
            let word = |i: usize| random_words(stratum as u32, i as u32, replicate, seed);
            let words = (0..count.div_ceil(4)).flat_map(word).take(count);
            words.map(|word| part((word as u64 * count as u64) >> 32, stratum)).sum::<f64>()
        };
        let sum: f64 = (0..strata).map(of_stratum).sum();
        center + widening * (sum / count as f64 - center)
    };
    Some((0..replicates).map(draws).collect())
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

/// Fits a power law to points (x, y, weight of ln y) by least squares; `None` below two different x.
pub fn fit_power_law(points: &[(f64, f64, f64)]) -> Option<PowerLaw> {
    let (mut weight, mut sum_x, mut sum_y) = (0.0, 0.0, 0.0);
    for &(x, y, w) in points {
        weight += w;
        sum_x += w * x.ln();
        sum_y += w * y.ln();
    }
    let (mean_x, mean_y) = (sum_x / weight, sum_y / weight);
    let spread: f64 = points.iter().map(|(x, _, w)| w * (x.ln() - mean_x).powi(2)).sum();
    let together: f64 = points.iter().map(|(x, y, w)| w * (x.ln() - mean_x) * (y.ln() - mean_y)).sum();
    let slope = together / spread;
    (spread > 0.0 && slope.is_finite()).then_some(PowerLaw { constant: mean_y - slope * mean_x, slope })
}

/// A power law, how certain its slope is, and how well it describes the points.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Fit {
    /// The line of least squares, points weighted by the inverse variance of their logarithms.
    pub law: PowerLaw,
    /// 95 % interval of the slope (see [`fit`]).
    pub slope_interval: Option<Interval>,
    /// Chi-square of the residuals by degrees of freedom; near 1 where the points lie on a line but for their noise. Where it
    /// is larger, the interval is widened by its root.
    pub misfit: Option<f64>,
}

/// One x of a fit: the value there and bootstrap replicates of it.
pub struct FitPoint<'a> {
    /// Samples or seconds.
    pub x: f64,
    /// Measured value, above 0.
    pub y: f64,
    /// Replicates of `y`; `None` where there was one run only.
    pub replicates: Option<&'a [f64]>,
}

/// Least deviation of ln y that is believed: no point rules the fit alone.
const LEAST_DEVIATION: f64 = 1e-4;

/// Fits a power law to measured points, its interval from their replicates: `z` standard errors to both sides.
pub fn fit(points: &[FitPoint], z: f64) -> Option<Fit> {
    let logs = |values: &[f64]| values.iter().filter(|v| **v > 0.0).map(|v| v.ln()).collect::<Vec<_>>();
    let deviations: Option<Vec<f64>> = points.iter().map(|p| Some(deviation(&logs(p.replicates?)))).collect();
    let weight = |i: usize| deviations.as_ref().map_or(1.0, |d| d[i].max(LEAST_DEVIATION).powi(-2));
    let weighted: Vec<(f64, f64, f64)> = points.iter().enumerate().map(|(i, p)| (p.x, p.y, weight(i))).collect();
    let law = fit_power_law(&weighted)?;
    if deviations.is_none() {
        return Some(Fit { law, slope_interval: None, misfit: None });
    }
    let residual = |(x, y, w): &(f64, f64, f64)| w * (y / law.at(*x)).ln().powi(2);
    let freedom = points.len() as f64 - 2.0;
    let misfit = (freedom > 0.0).then(|| weighted.iter().map(residual).sum::<f64>() / freedom);
    let center = weighted.iter().map(|(x, _, w)| w * x.ln()).sum::<f64>();
    let center = center / weighted.iter().map(|(_, _, w)| w).sum::<f64>();
    let spread: f64 = weighted.iter().map(|(x, _, w)| w * (x.ln() - center).powi(2)).sum();
    let standard_error = (misfit.unwrap_or(1.0).max(1.0) / spread).sqrt();
    Some(Fit { law, slope_interval: Some(Interval::around(law.slope, z * standard_error)), misfit })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::unit;

    /// Sums of 12 uniform numbers less 6: mean 0, variance 1, nearly normal.
    fn normal(stream: u32, index: u32) -> f64 {
        let words = (0..3).flat_map(|block| random_words(stream, index, block, 99));
        words.map(|word| unit(word) as f64).sum::<f64>() - 6.0
    }

    #[test]
    fn quantiles_and_deviations_of_a_few_numbers() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        assert_eq!([0.0, 0.5, 1.0].map(|q| quantile(&sorted, q)), [1.0, 3.0, 8.0]);
        assert_eq!((mean(&sorted), deviation(&[1.0, 3.0]), deviation(&[5.0])), (3.75, 2f64.sqrt(), 0.0));
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn bootstrap_intervals_hold_the_truth_as_often_as_they_say() {
        // Mean 16 of 64 strata, five runs: 95 % of 400 intervals, within 3.3 binomial standard deviations (99.9 %).
        let (trials, strata, count) = (400, 64, 5);
        let mut held = 0;
        for trial in 0..trials {
            let run = |r: u32| (0..strata).map(|t| 0.25 + normal(trial * 8 + r, t) * 0.1).collect::<Vec<f64>>();
            let runs: Vec<Vec<f64>> = (0..count).map(run).collect();
            let runs: Vec<&[f64]> = runs.iter().map(Vec::as_slice).collect();
            let replicates = bootstrap_means(&runs, 400, trial).unwrap();
            held += percentile_interval(&replicates).contains(16.0) as u32;
        }
        let expected = 0.95 * trials as f64;
        let tolerance = 3.3 * (expected * 0.05).sqrt();
        assert!((held as f64 - expected).abs() < tolerance, "{held} of {trials}");
        assert_eq!(bootstrap_means(&[&[1.0, 2.0]], 10, 0), None);
        // Runs that agree leave no doubt.
        assert!(bootstrap_means(&[&[1.0, 2.0], &[1.0, 2.0]], 10, 0).unwrap().iter().all(|v| *v == 3.0));
    }

    #[test]
    fn families_need_wider_intervals() {
        // Python: statistics.NormalDist().inv_cdf((1 + 0.95**(1/count)) / 2)
        for (count, expected) in [(1, 1.959963984540054), (9, 2.765529584339756)] {
            assert!((simultaneous_95(count) - expected).abs() < 1e-9, "{count}: {}", simultaneous_95(count));
        }
    }

    #[test]
    fn a_power_law_is_found_again() {
        let points: Vec<_> = [1.0f64, 4.0, 16.0].iter().map(|x| (*x, 3.0 * x.powf(-0.7), x * x)).collect();
        let law = fit_power_law(&points).unwrap();
        assert!((law.slope + 0.7).abs() < 1e-12 && (law.at(1.0) - 3.0).abs() < 1e-12);
        assert!((law.inverse(law.at(7.0)) - 7.0).abs() < 1e-9);
        assert_eq!(fit_power_law(&[(2.0, 1.0, 1.0), (2.0, 3.0, 1.0)]), None);
        assert_eq!(fit_power_law(&[]), None);
    }

    #[test]
    fn slope_intervals_hold_the_truth_as_often_as_they_say() {
        // y = 2 / x with a noise of 1 to 5 %: 300 fits; widening by the misfit can only make them hold more often.
        let (trials, mut held, mut width) = (300, 0, 0.0);
        for trial in 0..trials {
            let noise = |i: usize| 0.01 * (1 + i) as f64;
            let xs = [1.0, 4.0, 16.0, 64.0, 256.0];
            let y = |i: usize| 2.0 / xs[i] * (1.0 + noise(i) * normal(trial, i as u32));
            let replicates = |i: usize| {
                let values = (0..200).map(|k| y(i) * (1.0 + noise(i) * normal(trial * 7 + i as u32 + 5000, k)));
                values.collect::<Vec<_>>()
            };
            let all: Vec<Vec<f64>> = (0..5).map(replicates).collect();
            let points: Vec<FitPoint> =
                (0..5).map(|i| FitPoint { x: xs[i], y: y(i), replicates: Some(&all[i]) }).collect();
            let interval = fit(&points, simultaneous_95(1)).unwrap().slope_interval.unwrap();
            held += interval.contains(-1.0) as u32;
            width += (interval.high - interval.low) / trials as f64;
        }
        assert!(held as f64 >= 0.95 * trials as f64 - 3.3 * (0.95 * 0.05 * trials as f64).sqrt(), "{held} of {trials}");
        assert!(width < 0.04, "{width}");
        let single = [(1.0, 1.0), (2.0, 0.5)].map(|(x, y)| FitPoint { x, y, replicates: None });
        assert_eq!(fit(&single, simultaneous_95(1)).unwrap().slope_interval, None);
    }
}
