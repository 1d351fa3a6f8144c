//! Findings in plain sentences.

use crate::report::analysis::findings::{BIAS_Z, Finding, Law, Verdict, sample_ratio};
use crate::report::analysis::statistics::Interval;
use crate::report::measure::experiment::Experiment;
use crate::strategy::Strategy;

/// The findings of one case, with what sentences about them need.
pub struct Words<'a> {
    /// What was run.
    pub experiment: &'a Experiment,
    /// Of one case, in the order of the configurations.
    pub findings: Vec<&'a Finding>,
}

/// A value with `digits` significant digits, no exponent for usual sizes.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..7).contains(&magnitude) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    // Rounded once at the wanted digit, so that 9.96 with two digits is 10 and not 10.0.
    let unit = 10f64.powi(magnitude + 1 - digits);
    let rounded = (value / unit).round() * unit;
    let magnitude = rounded.abs().log10().floor() as i32;
    format!("{rounded:.*}", (digits - 1 - magnitude).max(0) as usize)
}

/// An exponent with two digits and a minus sign that is one; never "-0.00".
pub fn exponent(value: f64) -> String {
    format!("{:.2}", (value * 100.0).round() / 100.0 + 0.0).replace('-', "−")
}

/// A share in per cent.
pub fn percent(share: f64) -> String {
    format!("{}\u{a0}%", significant(100.0 * share, if share.abs() < 0.1 { 2 } else { 3 }))
}

/// An error that was asked for, in per cent, without zeros behind the point.
pub fn target(error: f64) -> String {
    format!("{}\u{a0}%", (error * 1e6).round() / 1e4)
}

/// Seconds in the unit a person would use.
pub fn seconds(value: f64) -> String {
    let (unit, name) = match value {
        v if v < 0.001 => (1e-3, "ms"),
        v if v < 180.0 => (1.0, "s"),
        v if v < 10_800.0 => (60.0, "min"),
        v if v < 259_200.0 => (3600.0, "h"),
        _ => (86_400.0, "days"),
    };
    format!("{}\u{a0}{name}", significant(value / unit, 2))
}

/// "(95 %: 1.2 to 3.4)", or nothing.
fn range(interval: Option<Interval>, digits: i32) -> String {
    let text = |i: Interval| format!(" (95 %: {} to {})", significant(i.low, digits), significant(i.high, digits));
    interval.map(text).unwrap_or_default()
}

/// "twice", "3.4 times".
fn times(factor: f64) -> String {
    format!("{} times", significant(factor, 2))
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

    fn strategy(&self, finding: &Finding) -> Strategy {
        self.experiment.configurations[finding.configuration].strategy
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

    /// The first finding of a strategy: that of the first light selection, sampler and engine.
    pub fn first_of(&self, strategy: Strategy) -> Option<&Finding> {
        self.findings.iter().copied().find(|finding| self.strategy(finding) == strategy)
    }

    /// One configuration in a few sentences.
    pub fn sentence(&self, finding: &Finding) -> String {
        match finding.verdict {
            Verdict::Biased => return self.biased_sentence(finding),
            Verdict::Undersampled => {
                return format!(
                    "is too dark by {} (z = {:.0}), though it is exact: its noise is in a few pixels, and rare bright samples \
                     that no run has met look like this. It would take more samples to say anything of it.",
                    percent(finding.relative_bias.abs()),
                    finding.bias_z
                );
            }
            Verdict::Unbiased => {}
        }
        let mut text = String::new();
        if let Some(price) = finding.prices.get(1)
            && let Some(cpu_seconds) = price.cpu_seconds
        {
            let foreseen = if price.extrapolated { "would take" } else { "takes" };
            text += &format!("{foreseen} {} of CPU time for an error of {}", seconds(cpu_seconds), target(price.error));
        }
        match self.relative_efficiency(finding) {
            Some(share) if share >= 1.0 => text += ", the least of all. ",
            Some(share) => text += &format!(", {} what the best takes for the same error. ", times(1.0 / share)),
            None => text += ". ",
        }
        text += &slope_sentence(finding);
        text += &match (self.strategy(finding).is_biased(), finding.bias_z.abs() < 3.0) {
            (true, _) => format!("It is biased by design, but not measurably here (z = {:.1}).", finding.bias_z),
            (false, true) => format!("No bias is seen (z = {:.1}).", finding.bias_z),
            (false, false) => {
                format!("Its mean is {:.1} standard errors off: more repeats would tell.", finding.bias_z)
            }
        };
        text
    }

    fn biased_sentence(&self, finding: &Finding) -> String {
        let direction = if finding.bias > 0.0 { "bright" } else { "dark" };
        let bias = percent(finding.relative_bias.abs());
        let mut text = format!("is biased: its picture is {bias} too {direction} (z = {:.0}). ", finding.bias_z);
        text += &match finding.law {
            Some(Law::Floor { floor, .. }) if floor > 0.0 => {
                let (level, last) = (floor.sqrt(), last_error(finding));
                let there = match (last / level - 1.0).abs() < 0.05 {
                    true => ", and has got there",
                    false => "",
                };
                format!("Its error levels off at {}{there}: no number of samples lowers it further. ", percent(level))
            }
            _ => String::new(),
        };
        text += match self.strategy(finding).is_biased() {
            true => "That is what this step of the lecture is there to show.",
            false => "It should have none: the reference shows something else, or there is a fault in the program.",
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
        format!("{}, {bias} too {direction}, z = {:.0}", self.label(finding), finding.bias_z)
    }

    fn bsdf_against_nee(&self) -> Option<String> {
        let (bsdf, nee) = (self.first_of(Strategy::Bsdf)?, self.first_of(Strategy::Nee)?);
        let (ratio, interval) = sample_ratio(bsdf, nee)?;
        let in_time = ratio * bsdf.cpu_seconds_by_sample / nee.cpu_seconds_by_sample;
        let spp = nee.points.last()?.spp;
        let error = percent(last_error(nee));
        Some(format!(
            "For the error that nee has with {spp:.0} samples a pixel ({error}), bsdf takes {} as many samples{} and {} the CPU \
             time. (The lecture speaks of 10 or 20 times as many for the scene it shows.)",
            times(ratio),
            range(interval, 2),
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

/// How the error falls.
fn slope_sentence(finding: &Finding) -> String {
    let Some(fit) = finding.mse_by_samples else { return String::new() };
    let text = |interval: Interval| {
        let verdict = match (interval.contains(-1.0), fit.law.slope < -1.0) {
            (true, _) => "as independent samples do",
            (false, true) => "faster than independent samples do",
            (false, false) => "more slowly than independent samples do",
        };
        format!(
            "Its MSE falls as n^{} (95 %: {} to {}), {verdict}. ",
            exponent(fit.law.slope),
            exponent(interval.low),
            exponent(interval.high)
        )
    };
    fit.slope_interval.map(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_people_write_them() {
        assert_eq!(
            [1.234, 9.96, 123.4, 0.01234, -5.67].map(|v| significant(v, 2)),
            ["1.2", "10", "120", "0.012", "-5.7"]
        );
        assert_eq!([-0.001, -1.0, 0.5].map(exponent), ["0.00", "−1.00", "0.50"]);
        assert_eq!([0.0, 1e9, 3.0e-7].map(|v| significant(v, 2)), ["0", "1.0e9", "3.0e-7"]);
        assert_eq!([0.0213, 0.3335, 1.5].map(percent), ["2.1\u{a0}%", "33.4\u{a0}%", "150\u{a0}%"]);
        assert_eq!(
            [0.00021, 0.5, 61.0, 300.0, 20000.0, 1e6].map(|v| seconds(v).replace('\u{a0}', " ")),
            ["0.21 ms", "0.50 s", "61 s", "5.0 min", "5.6 h", "12 days"]
        );
        assert_eq!([0.1, 0.05, 0.005].map(target), ["10\u{a0}%", "5\u{a0}%", "0.5\u{a0}%"]);
    }
}
