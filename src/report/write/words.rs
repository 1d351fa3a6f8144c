//! Findings in plain sentences.

use crate::report::analysis::curve::Unknown;
use crate::report::analysis::findings::{BIAS_Z, Finding, Price, Verdict, ratios};
use crate::report::analysis::statistics::Interval;
use crate::report::analysis::summary::{ranking, share};
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

/// What is said in one word where an image is not simply right.
pub fn tag(finding: &Finding) -> Option<&'static str> {
    match finding.verdict {
        Verdict::Unbiased => None,
        Verdict::Biased => Some("biased"),
        Verdict::Undersampled => Some("too few samples"),
    }
}

/// The relative error that `finding` had at its largest budget.
pub fn last_error(finding: &Finding) -> f64 {
    finding.last().relmse.max(0.0).sqrt()
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

    /// Whether its strategy has a way to find each light of its scene.
    fn sees_all(&self, finding: &Finding) -> bool {
        self.strategy(finding).is_none_or(|strategy| self.experiment.cases[finding.case].scene.is_seen_by(strategy))
    }

    /// The findings that can be ranked, best first.
    pub fn ranking(&self) -> Vec<&Finding> {
        ranking(self.findings.iter().copied())
    }

    /// The worth of `finding` over that of the best.
    pub fn share_of_best(&self, finding: &Finding) -> Option<f64> {
        Some(share(finding, self.ranking().first()?)?.0)
    }

    /// What the ranking goes by.
    pub fn ranked_by(&self) -> String {
        match self.experiment.reach {
            Some(error) => format!("CPU time to an error of {}", target(error)),
            None => "efficiency at the largest budget".to_owned(),
        }
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
                "Its images are too dark by {} (z = {}), though it is exact: rare bright samples that no run has met look like \
                 this. More samples would tell.",
                percent(finding.relative_bias.abs()),
                score(finding.bias_z)
            ),
            Verdict::Unbiased => self.unbiased_sentence(finding),
        }
    }

    fn unbiased_sentence(&self, finding: &Finding) -> String {
        let mut text = String::new();
        if finding.last().outliers {
            text += "A few pixels hold most of its error at the largest budget: the figures that follow from it cannot be relied on. ";
        }
        text += &self.price_sentence(finding);
        text += &self.beside_the_best(finding);
        text += &slope_sentence(finding);
        let z = score(finding.bias_z);
        text += &match (self.is_biased_by_design(finding), finding.bias_z.abs() < 3.0) {
            (true, _) => format!("It is biased by design, but not measurably here (z = {z})."),
            (false, true) => format!("No bias is seen (z = {z})."),
            (false, false) => format!("Its mean is {z} standard errors from the reference: more repeats would tell."),
        };
        text
    }

    /// How much longer it takes than the best for the error that the best has come to.
    fn beside_the_best(&self, finding: &Finding) -> String {
        let ranking = self.ranking();
        let Some(best) = ranking.first().filter(|_| finding.worth.is_some()) else { return String::new() };
        if std::ptr::eq(*best, finding) {
            return match self.experiment.reach {
                _ if ranking.len() == 1 => String::new(),
                Some(_) => "No other takes less time. ".to_owned(),
                None => "No other is more efficient. ".to_owned(),
            };
        }
        if share(finding, best).is_some_and(|(_, interval)| interval.is_some_and(|interval| interval.contains(1.0))) {
            return "The best is not measurably better. ".to_owned();
        }
        let name = self.label(best);
        let error = percent(last_error(best));
        match ratios(finding, best) {
            Some((_, time)) => {
                let (value, range) = known(time.value, time.interval);
                let takes = self.takes(finding, time.extrapolated);
                format!(
                    "For the error that {name} has at its largest budget ({error}) it {takes} {value} times as long{}. ",
                    within(range)
                )
            }
            None => {
                format!("What it takes for the error that {name} has at its largest budget ({error}) cannot be told. ")
            }
        }
    }

    /// "takes", or how it is foreseen.
    fn takes(&self, finding: &Finding, extrapolated: bool) -> &'static str {
        match (extrapolated, finding.points.len()) {
            (false, _) => "takes",
            (true, 1) => "would take, if its squared error falls as 1/n,",
            (true, _) => "would take, extrapolated,",
        }
    }

    /// What the error of `--reach`, or else 5 %, costs.
    fn price_sentence(&self, finding: &Finding) -> String {
        if finding.last().relmse <= 0.0 && !finding.last().outliers {
            return "Its error at the largest budget is 0, or below what the reference can tell. ".to_owned();
        }
        let asked = self.experiment.reach.unwrap_or(0.05);
        match finding.prices.iter().find(|price| price.error == asked) {
            Some(&Price { cpu_seconds: Some(cpu_seconds), interval, extrapolated, .. }) => {
                let takes = self.takes(finding, extrapolated);
                let (time, range) = known_seconds(cpu_seconds, interval);
                format!("An error of {} {takes} {time} of CPU time{}. ", target(asked), within(range))
            }
            Some(Price { unknown: Some(Unknown::TooUncertain), .. }) => {
                format!("What an error of {} takes cannot be told from these runs. ", target(asked))
            }
            _ => String::new(),
        }
    }

    fn biased_sentence(&self, finding: &Finding) -> String {
        let direction = if finding.bias > 0.0 { "bright" } else { "dark" };
        let bias = percent(finding.relative_bias.abs());
        let mut text = match finding.relative_bias.is_finite() {
            true => format!("Its images are {bias} too {direction} (z = {}). ", score(finding.bias_z)),
            false => "Its images show light where the reference is black. ".to_owned(),
        };
        if let Some(level) = finding.level {
            let (level, last) = (level.floor.sqrt(), last_error(finding));
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
            (true, false) if !self.sees_all(finding) => {
                "It finds light by hitting it, and no ray can hit the point, spot and directional lights of this scene."
            }
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
                let share = self.share_of_best(finding).unwrap_or(0.0);
                format!("{} ({})", self.label(finding), percent(share))
            };
            let order: Vec<String> = ranking.iter().map(item).collect();
            let what = match self.experiment.reach {
                Some(error) => format!("By CPU time to an error of {}, speeds", target(error)),
                None => "By efficiency at the largest budget,".to_owned(),
            };
            said.push(format!("{what} as shares of the best: {}.", order.join(", ")));
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
        let compared = self.compared(own, other)?;
        Some(format!("{} {compared} {}, by {}.", self.label(own), self.label(other), self.ranked_by()))
    }

    /// How the worth of one compares with that of another, between their names: "is 3.4 times (95 %: 3.1 to 3.8) as good as".
    fn compared(&self, this: &Finding, other: &Finding) -> Option<String> {
        let good = if self.experiment.reach.is_some() { "fast" } else { "efficient" };
        let (ratio, interval) = share(this, other)?;
        let part = |ratio: f64, interval: Option<Interval>| {
            let (value, range) = known(ratio, interval);
            format!("{value} times{}", within(range))
        };
        Some(match interval {
            Some(interval) if interval.contains(1.0) => format!("is not measurably more or less {good} than"),
            _ if ratio >= 1.0 => format!("is {} as {good} as", part(ratio, interval)),
            _ => {
                let (ratio, interval) = (ratio.recip(), interval.map(|interval| interval.map(f64::recip)));
                format!("is less {good}, by {}, than", part(ratio, interval))
            }
        })
    }

    fn bsdf_against_nee(&self) -> Option<String> {
        let (bsdf, nee) = (self.first_of(Strategy::Bsdf)?, self.first_of(Strategy::Nee)?);
        let (samples, time) = ratios(bsdf, nee)?;
        let samples = samples?;
        let error = percent(last_error(nee));
        let takes = self.takes(bsdf, samples.extrapolated);
        let (value, range) = known(samples.value, samples.interval);
        Some(format!(
            "For the error that nee has with {} a pixel ({error}), bsdf {takes} {value} times as many samples{} and {} the CPU \
             time.",
            count(nee.last().spp.round() as u64, "sample"),
            within(range),
            times(time.value),
        ))
    }

    fn averaging(&self) -> Option<String> {
        let [bsdf, average, nee] =
            [self.first_of(Strategy::Bsdf)?, self.first_of(Strategy::NeeAverage)?, self.first_of(Strategy::Nee)?];
        let (first, second) = (self.compared(average, bsdf)?, self.compared(nee, average)?);
        Some(format!(
            "Averaging both techniques (nee-average) {first} BSDF sampling alone; choosing one by 0/1 weights (nee) {second} \
             averaging."
        ))
    }
}

/// How the error falls with the samples: half the power of relMSE.
fn slope_sentence(finding: &Finding) -> String {
    let Some(slope) = finding.relmse_by_samples else { return String::new() };
    let Some(interval) = slope.interval else { return String::new() };
    let (text, range) = known_exponent(slope.value / 2.0, Some(interval.map(|slope| slope / 2.0)));
    if interval.high >= 0.0 {
        return format!("Its error does not fall measurably with the samples (power {text}{}). ", within(range));
    }
    let verdict = match (interval.contains(-1.0), slope.value < -1.0) {
        (true, _) => "as that of independent samples does",
        (false, true) => "faster than that of independent samples",
        (false, false) => "more slowly than that of independent samples",
    };
    let factor = 4f64.powf(-slope.value / 2.0);
    format!(
        "Its error falls with the power {text} of the samples{}, {verdict}: four times the samples divide it by {}. ",
        within(range),
        significant(factor, 3)
    )
}
