//! Several cases in one figure a configuration: the geometric mean and the worst.

use serde::Serialize;

use crate::report::analysis::findings::Finding;
use crate::report::measure::experiment::Experiment;

/// How a configuration does over all cases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Index of the configuration.
    pub configuration: usize,
    /// Geometric mean over the cases of its efficiency by that of the best there; `null` where a case has none.
    pub geometric_mean: Option<f64>,
    /// The case in which its efficiency by that of the best is least, and that share.
    pub worst: Option<(usize, f64)>,
}

/// The findings of one case, in the order of the configurations.
pub fn of_case(findings: &[Finding], case: usize) -> impl Iterator<Item = &Finding> {
    findings.iter().filter(move |finding| finding.case == case)
}

/// The efficiency of `configuration` in `case` by that of the best there.
pub fn share_of_best(findings: &[Finding], case: usize, configuration: usize) -> Option<f64> {
    let best = of_case(findings, case).filter_map(|finding| finding.efficiency).fold(0.0, f64::max);
    Some(of_case(findings, case).find(|finding| finding.configuration == configuration)?.efficiency? / best)
}

/// One summary a configuration and another renderer, in their order.
pub fn summarize(experiment: &Experiment, findings: &[Finding]) -> Vec<Summary> {
    let of = |configuration: usize| {
        let share = |case: usize| share_of_best(findings, case, configuration);
        let shares: Option<Vec<f64>> = (0..experiment.cases.len()).map(share).collect();
        let logarithms = shares.as_ref().map(|shares| shares.iter().map(|share| share.ln()).sum::<f64>());
        let known = (0..experiment.cases.len()).filter_map(|case| Some((case, share(case)?)));
        Summary {
            configuration,
            geometric_mean: logarithms.map(|sum| (sum / experiment.cases.len() as f64).exp()),
            worst: known.min_by(|a, b| a.1.total_cmp(&b.1)),
        }
    };
    (0..experiment.entries()).map(of).collect()
}
