//! Findings in plain sentences.

use crate::report::analysis::findings::{BIAS_Z, Finding, Law, Verdict, sample_ratio};
use crate::report::measure::experiment::Experiment;
use crate::report::write::numbers::{
    count, known, known_exponent, known_percent, known_seconds, percent, score, significant, target,
};
use crate::strategy::Strategy;

/// " (95 %: 1.2 to 3.4)", or nothing.
fn within(range: Option<String>) -> String {
    range.map(|range| format!(" (95 %: {range})")).unwrap_or_default()
}

/// "3.4 times".
fn times(factor: f64) -> String {
    format!("{} times", significant(factor, 2))
}

/// The findings of one case, with what sentences about them need.
pub struct Words<'a> {
    /// What was run.
    pub experiment: &'a Experiment,
    /// Of one case, in the order of the configurations.
    pub findings: Vec<&'a Finding>,
}

/// What is said in one word where a picture is not simply right.
pub fn tag(finding: &Finding) -> Option<&'static str> {
    match finding.verdict {
        Verdict::Unbiased => None,
        Verdict::Biased => Some("biased"),
        Verdict::Undersampled => Some("too few samples"),
    }
}

/// The relative error that `finding` had at its largest budget.
pub fn last_error(finding: &Finding) -> f64 {
    finding.points.last().map_or(0.0, |point| point.relmse.max(0.0).sqrt())
}

impl Words<'_> {
    /// What to call the configuration of `finding`.
    pub fn label(&self, finding: &Finding) -> String {
        self.experiment.label(finding.configuration)
    }

    fn strategy(&self, finding: &Finding) -> Option<Strategy> {
        self.experiment.strategy(finding.configuration)
    }

    fn is_biased_by_design(&self, finding: &Finding) -> bool {
        self.strategy(finding).is_some_and(|strategy| strategy.is_biased())
    }

    /// The unbiased findings, most efficient first.
    pub fn ranking(&self) -> Vec<&Finding> {
        let mut ranked: Vec<&Finding> = self.findings.iter().copied().filter(|f| f.efficiency.is_some()).collect();
        ranked.sort_by(|a, b| b.efficiency.unwrap_or(0.0).total_cmp(&a.efficiency.unwrap_or(0.0)));
        ranked
    }

    /// The efficiency of `finding` over that of the best.
    pub fn relative_efficiency(&self, finding: &Finding) -> Option<f64> {
        let best = self.ranking().first()?.efficiency?;
        Some(finding.efficiency? / best)
    }

    /// Whether the intervals of the efficiencies of `finding` and of the best have a value in common.
    fn may_be_best(&self, finding: &Finding) -> bool {
        let best = self.ranking().first().and_then(|best| best.efficiency_interval);
        best.zip(finding.efficiency_interval).is_some_and(|(best, own)| own.high >= best.low)
    }

    /// The first finding of a strategy: that of the first light selection, sampler and engine.
    pub fn first_of(&self, strategy: Strategy) -> Option<&Finding> {
        self.findings.iter().copied().find(|finding| self.strategy(finding) == Some(strategy))
    }

    /// One configuration in a few sentences.
    pub fn sentence(&self, finding: &Finding) -> String {
        match finding.verdict {
            Verdict::Biased => self.biased_sentence(finding),
            Verdict::Undersampled => format!(
                "Its images are too dark by {} (z = {}), though it is exact: its noise is in a few pixels, and rare bright \
                 samples that no run has met look like this. More samples would tell.",
                percent(finding.relative_bias.abs()),
                score(finding.bias_z)
            ),
            Verdict::Unbiased => self.unbiased_sentence(finding),
        }
    }

    fn unbiased_sentence(&self, finding: &Finding) -> String {
        let mut text = self.price_sentence(finding);
        text += &match self.relative_efficiency(finding) {
            Some(share) if share >= 1.0 => "No other takes less time for the same error. ".to_owned(),
            Some(_) if self.may_be_best(finding) => "The best is not measurably better. ".to_owned(),
            Some(share) if share > 0.5 => format!("The best takes {} of its time for the same error. ", percent(share)),
            Some(share) => format!("It takes {} the time of the best for the same error. ", times(1.0 / share)),
            None => String::new(),
        };
        text += &slope_sentence(finding);
        let z = score(finding.bias_z);
        text += &match (self.is_biased_by_design(finding), finding.bias_z.abs() < 3.0) {
            (true, _) => format!("It is biased by design, but not measurably here (z = {z})."),
            (false, true) => format!("No bias is seen (z = {z})."),
            (false, false) => format!("Its mean is {z} standard errors from the reference: more repeats would tell."),
        };
        text
    }

    /// What the error of `--reach`, or else 5 %, costs.
    fn price_sentence(&self, finding: &Finding) -> String {
        let asked = self.experiment.reach.unwrap_or(0.05);
        let price = finding.prices.iter().find(|price| price.error == asked);
        let Some((price, cpu_seconds)) = price.and_then(|price| Some((price, price.cpu_seconds?))) else {
            return String::new();
        };
        let takes = if price.extrapolated { "would take, extrapolated," } else { "takes" };
        let (time, range) = known_seconds(cpu_seconds, price.interval);
        format!("An error of {} {takes} {time} of CPU time{}. ", target(price.error), within(range))
    }

    fn biased_sentence(&self, finding: &Finding) -> String {
        let direction = if finding.bias > 0.0 { "bright" } else { "dark" };
        let bias = percent(finding.relative_bias.abs());
        let mut text = format!("Its images are {bias} too {direction} (z = {}). ", score(finding.bias_z));
        if let Some(Law::Floor { floor, .. }) = finding.law.filter(|_| finding.floor > 0.0) {
            let (level, last) = (floor.sqrt(), last_error(finding));
            let there = if (last / level - 1.0).abs() < 0.05 { ", and has got there" } else { "" };
            let interval = finding.floor_interval.map(|interval| interval.map(f64::sqrt));
            let (level, range) = known_percent(level, interval);
            text += &format!(
                "Its error levels off at {level}{}{there}: no number of samples lowers it further. ",
                within(range)
            );
        }
        text += match (self.strategy(finding).is_some(), self.is_biased_by_design(finding)) {
            (true, true) => "That is what this step of the lecture is there to show.",
            (true, false) => {
                "It should have no bias: the reference shows something else, or there is a fault in the program."
            }
            (false, _) => {
                "Its scene, camera or materials are not quite those of the reference, or one of both is wrong."
            }
        };
        text
    }

    /// The answers that matter most, one sentence each.
    pub fn in_short(&self) -> Vec<String> {
        let mut said = Vec::new();
        let ranking = self.ranking();
        if ranking.len() > 1 {
            let item = |finding: &&Finding| {
                let share = self.relative_efficiency(finding).unwrap_or(0.0);
                format!("{} ({})", self.label(finding), percent(share))
            };
            let order: Vec<String> = ranking.iter().map(item).collect();
            said.push(format!("By efficiency, as shares of the best: {}.", order.join(", ")));
        }
        said.extend(self.against_others());
        said.extend(self.bsdf_against_nee());
        said.extend(self.averaging());
        let biased: Vec<String> = self.findings.iter().filter(|f| f.biased).map(|f| self.biased_item(f)).collect();
        let rule = format!("more than {BIAS_Z} standard errors off");
        said.push(match biased.len() {
            0 => format!("No configuration is biased ({rule})."),
            _ => format!("Biased ({rule}): {}.", biased.join("; ")),
        });
        let few = self.findings.iter().filter(|f| f.verdict == Verdict::Undersampled);
        let few: Vec<String> = few.map(|finding| self.label(finding)).collect();
        if !few.is_empty() {
            said.push(format!("Too few samples to judge by (rare bright ones are missing): {}.", few.join(", ")));
        }
        said
    }

    fn biased_item(&self, finding: &Finding) -> String {
        let direction = if finding.bias > 0.0 { "bright" } else { "dark" };
        let bias = percent(finding.relative_bias.abs());
        format!("{}, {bias} too {direction}, z = {}", self.label(finding), score(finding.bias_z))
    }

    /// The best of ours and the best of the others.
    fn against_others(&self) -> Option<String> {
        let ranking = self.ranking();
        let best = |own: bool| ranking.iter().find(|finding| self.strategy(finding).is_some() == own).copied();
        let (own, other) = (best(true)?, best(false)?);
        let ratio = own.efficiency? / other.efficiency?;
        let (first, second, ratio) = if ratio >= 1.0 { (own, other, ratio) } else { (other, own, ratio.recip()) };
        Some(format!("{} is {} as efficient as {}.", self.label(first), times(ratio), self.label(second)))
    }

    fn bsdf_against_nee(&self) -> Option<String> {
        let (bsdf, nee) = (self.first_of(Strategy::Bsdf)?, self.first_of(Strategy::Nee)?);
        let ratio = sample_ratio(bsdf, nee)?;
        let in_time = ratio.value * bsdf.cpu_seconds_by_sample / nee.cpu_seconds_by_sample;
        let spp = nee.points.last()?.spp;
        let error = percent(last_error(nee));
        let takes = if ratio.extrapolated { "would take, extrapolated," } else { "takes" };
        let (value, range) = known(ratio.value, ratio.interval);
        Some(format!(
            "For the error that nee has with {} a pixel ({error}), bsdf {takes} {value} times as many samples{} and {} the CPU time. (The \
             lecture speaks of 10 or 20 times as many for the scene it shows.)",
            count(spp.round() as u64, "sample"),
            within(range),
            times(in_time),
        ))
    }

    fn averaging(&self) -> Option<String> {
        let of = |strategy: Strategy| self.first_of(strategy)?.efficiency;
        let [bsdf, average, nee] = [of(Strategy::Bsdf)?, of(Strategy::NeeAverage)?, of(Strategy::Nee)?];
        let compare = |ratio: f64| match ratio {
            r if r >= 1.0 => format!("{} as efficient as", times(r)),
            r => format!("less efficient, by a factor of {}, than", significant(1.0 / r, 2)),
        };
        Some(format!(
            "Averaging both techniques (nee-average) is {} BSDF sampling alone, and 0/1 weights (nee) are {} averaging.",
            compare(average / bsdf),
            compare(nee / average)
        ))
    }
}

/// How the error falls with the samples: half the power of relMSE.
fn slope_sentence(finding: &Finding) -> String {
    let Some(fit) = finding.relmse_by_samples else { return String::new() };
    let Some(interval) = fit.slope_interval else { return String::new() };
    let verdict = match (interval.contains(-1.0), fit.law.slope < -1.0) {
        (true, _) => "as that of independent samples does",
        (false, true) => "faster than that of independent samples",
        (false, false) => "more slowly than that of independent samples",
    };
    let (slope, range) = known_exponent(fit.law.slope / 2.0, Some(interval.map(|slope| slope / 2.0)));
    let factor = 4f64.powf(-fit.law.slope / 2.0);
    format!(
        "Its error falls with the power {slope} of the samples{}, {verdict}: four times the samples divide it by {}. ",
        within(range),
        significant(factor, 3)
    )
}
