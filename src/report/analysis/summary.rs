//! Who is best, in a case and over several: the geometric mean and the worst.

use serde::Serialize;

use crate::report::analysis::findings::Finding;
use crate::report::analysis::statistics::Interval;
use crate::report::measure::experiment::Experiment;

/// How a configuration does over all whole scenes (over all cases where none is whole).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Index of the configuration.
    pub configuration: usize,
    /// Geometric mean over the scenes of its worth ([`Finding::worth`]) by that of the best there; `null` where one has none.
    pub geometric_mean: Option<f64>,
    /// The case in which its worth by that of the best is least, and that share.
    pub worst: Option<(usize, f64)>,
}

/// The findings of one case, in the order of the configurations.
pub fn of_case(findings: &[Finding], case: usize) -> impl Iterator<Item = &Finding> {
    findings.iter().filter(move |finding| finding.case == case)
}

/// The findings of a case that have a worth, best first.
pub fn ranking<'a>(findings: impl Iterator<Item = &'a Finding>) -> Vec<&'a Finding> {
    let mut ranked: Vec<&Finding> = findings.filter(|finding| finding.worth.is_some()).collect();
    ranked.sort_by(|a, b| b.worth.unwrap_or(0.0).total_cmp(&a.worth.unwrap_or(0.0)));
    ranked
}

/// The worth of `finding` by that of `other`, and the interval of that ratio.
pub fn share(finding: &Finding, other: &Finding) -> Option<(f64, Option<Interval>)> {
    let interval = finding.worth_interval.zip(other.worth_interval);
    Some((finding.worth? / other.worth?, interval.map(|(own, other)| own.times(other.map(f64::recip)))))
}

/// The worth of `configuration` in `case` by that of the best there.
pub fn share_of_best(findings: &[Finding], case: usize, configuration: usize) -> Option<f64> {
    let best = *ranking(of_case(findings, case)).first()?;
    let own = of_case(findings, case).find(|finding| finding.configuration == configuration)?;
    Some(share(own, best)?.0)
}

/// One summary a configuration and another renderer, in their order.
pub fn summarize(experiment: &Experiment, findings: &[Finding]) -> Vec<Summary> {
    let whole: Vec<usize> = (0..experiment.cases.len()).filter(|case| experiment.cases[*case].is_whole()).collect();
    let cases = if whole.is_empty() { (0..experiment.cases.len()).collect() } else { whole };
    let of = |configuration: usize| {
        let share = |case: usize| share_of_best(findings, case, configuration);
        let shares: Option<Vec<f64>> = cases.iter().map(|case| share(*case)).collect();
        let logarithms = shares.as_ref().map(|shares| shares.iter().map(|share| share.ln()).sum::<f64>());
        let known = cases.iter().filter_map(|case| Some((*case, share(*case)?)));
        Summary {
            configuration,
            geometric_mean: logarithms.map(|sum| (sum / cases.len() as f64).exp()),
            worst: known.min_by(|a, b| a.1.total_cmp(&b.1)),
        }
    };
    (0..experiment.entries()).map(of).collect()
}
