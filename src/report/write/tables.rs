//! The tables of the page. What a phone shows without scrolling comes first: error, time, bias.

use maud::{Markup, html};

use crate::report::analysis::curve::Unknown;
use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::findings::{Finding, Price, ratios};
use crate::report::analysis::point::Point;
use crate::report::analysis::summary::{Summary, share_of_best};
use crate::report::measure::run_error::TRIMMED;
use crate::report::write::numbers::{
    known, known_exponent, known_percent, known_seconds, percent, score, seconds, signed_percent, significant, target,
};
use crate::report::write::words::{Words, tag};
use crate::strategy::Strategy;

/// A table that scrolls sideways where the page is narrow.
fn scrolling(rows: &Markup) -> Markup {
    html! { div class="scroll" { table { (rows) } } }
}

fn dash() -> String {
    "–".to_owned()
}

/// A value with its 95 % interval below it.
fn with_interval((value, interval): (String, Option<String>)) -> Markup {
    html! { (value) @if let Some(interval) = interval { br; small { (interval) } } }
}

/// The relative error of `point` with its interval, or with what stands against one.
fn error(point: &Point) -> (String, Option<String>) {
    let interval = point.relmse_interval.map(|interval| interval.map(f64::sqrt));
    let (value, range) = known_percent(point.relmse.max(0.0).sqrt(), interval);
    (value, if point.outliers { Some("few pixels rule".to_owned()) } else { range })
}

/// Error, time, bias, efficiency, slope: a row a configuration.
pub fn comparison(words: &Words) -> Markup {
    let rows = html! {
        tr {
            th { "" } th { "error at the" br; "largest budget" } th { "CPU time" br; "for it" } th { "bias" } th { "z" }
            th { @if words.experiment.reach.is_some() { "speed to it," } @else { "efficiency," } br; "of the best" } th { "efficiency" } th { "slope of the error" br; "by samples" }
        }
        @for finding in &words.findings {
            @let share = words.share_of_best(finding);
            @let last = finding.last();
            tr class=[tag(finding).map(|_| "biased")] {
                td class="name" { (words.label(finding)) }
                td { (with_interval(error(last))) }
                td { (seconds(last.cpu_seconds)) }
                td { (signed_percent(finding.relative_bias)) }
                td { (score(finding.bias_z)) }
                td class=[(share == Some(1.0)).then_some("best")] {
                    (share.map_or_else(|| without_share(finding), percent))
                }
                td {
                    @if let Some(efficiency) = finding.efficiency {
                        (with_interval(known(efficiency, finding.efficiency_interval)))
                    } @else { (dash()) }
                }
                td { (slope(finding)) }
            }
        }
    };
    scrolling(&rows)
}

/// What stands where a configuration has no share of the best.
fn without_share(finding: &Finding) -> String {
    let exact = finding.last().relmse <= 0.0 && !finding.last().outliers;
    tag(finding).unwrap_or(if exact { "no error" } else { "–" }).to_owned()
}

/// Half the slope of relMSE; of a biased strategy the level where its error ends.
fn slope(finding: &Finding) -> Markup {
    if finding.level.is_some() {
        let interval = finding.floor_interval.map(|interval| interval.map(f64::sqrt));
        let (level, range) = known_percent(finding.floor.sqrt(), interval);
        return with_interval((format!("ends at {level}"), range));
    }
    let Some(slope) = finding.relmse_by_samples.filter(|_| !finding.biased) else { return html! { (dash()) } };
    with_interval(known_exponent(slope.value / 2.0, slope.interval.map(|interval| interval.map(|slope| slope / 2.0))))
}

/// CPU seconds with their interval, or why there are none.
fn price_text(price: &Price) -> (String, Option<String>) {
    match (price.cpu_seconds, price.unknown) {
        (Some(cpu_seconds), _) => {
            let (text, range) = known_seconds(cpu_seconds, price.interval);
            (if price.extrapolated { format!("({text})") } else { text }, range)
        }
        (None, Some(Unknown::Never)) => ("never".to_owned(), None),
        (None, Some(Unknown::DoesNotFall)) => ("does not fall".to_owned(), None),
        (None, _) => (dash(), None),
    }
}

/// CPU seconds to the target errors.
pub fn prices(words: &Words) -> Markup {
    let targets: Vec<f64> = words.findings[0].prices.iter().map(|price| price.error).collect();
    let least = |i: usize| {
        let usable = words.findings.iter().filter(|finding| tag(finding).is_none());
        usable.filter_map(|finding| finding.prices[i].cpu_seconds).fold(f64::INFINITY, f64::min)
    };
    let rows = html! {
        tr { th { "" } @for error in &targets { th { (target(*error)) } } }
        @for finding in &words.findings {
            tr class=[tag(finding).map(|_| "biased")] {
                td class="name" { (words.label(finding)) }
                @for (i, price) in finding.prices.iter().enumerate() {
                    @let class = match price.extrapolated {
                        true => Some("guess"),
                        false if price.cpu_seconds == Some(least(i)) => Some("best"),
                        false => None,
                    };
                    td class=[class] { (with_interval(price_text(price))) }
                }
            }
        }
    };
    html! {
        (scrolling(&rows))
        p class="facts" {
            "In parentheses: extrapolated from the nearest budget along the slope of the nearest three; of a single budget, if the squared \
             error falls as 1/n. Intervals (95 %) are those of the errors, slope included; the time of a sample counts as known. –: \
             too uncertain to be told."
        }
    }
}

/// Samples for the error of `nee`; nothing where it was not run.
pub fn samples(words: &Words) -> Markup {
    let Some(nee) = words.first_of(Strategy::Nee).filter(|nee| tag(nee).is_none()) else { return html! {} };
    let others = words.findings.iter().filter(|finding| finding.configuration != nee.configuration);
    let found: Vec<_> = others.filter_map(|finding| Some((*finding, ratios(finding, nee)?))).collect();
    if found.is_empty() {
        return html! {};
    }
    let rows = html! {
        tr { th { "" } th { "samples" } th { "95 %" } th { "CPU time" } }
        @for (finding, (samples, time)) in found {
            @let times = |text: String| if time.extrapolated { format!("({text} ×)") } else { format!("{text} ×") };
            @let (value, range) = samples.map_or_else(|| (dash(), None), |samples| {
                let (value, range) = known(samples.value, samples.interval);
                (times(value), range)
            });
            tr {
                td class="name" { (words.label(finding)) }
                td class=[time.extrapolated.then_some("guess")] { (value) }
                td { (range.unwrap_or_else(dash)) }
                td class=[time.extrapolated.then_some("guess")] { (times(significant(time.value, 3))) }
            }
        }
    };
    html! {
        h3 { "Samples for the error of nee" }
        p { "How many samples each takes for the error that nee reaches with its largest budget, as a multiple of nee's." }
        (scrolling(&rows))
    }
}

/// How runs differ, what outliers do, where the error lies in frequency, and how full the lanes are; at the largest budget.
pub fn distribution(words: &Words) -> Markup {
    let share = |share: Option<f64>| share.map_or_else(dash, percent);
    let (width, height) = words.experiment.film();
    let trimmed = width as usize * height as usize >= TRIMMED;
    let rows = html! {
        tr {
            th { "" } th { "spread of MSE" br; "between runs" } th { "error" } th { "error without" br; "the worst 0.1 %" }
            th { "low frequencies" br; "(white noise: 1)" } th { "lanes used" br; "by stages" } th { "lanes used" br; "by walks" }
        }
        @for finding in &words.findings {
            @let last = finding.last();
            tr class=[tag(finding).map(|_| "biased")] {
                td class="name" { (words.label(finding)) }
                td {
                    @if last.runs > 1 && last.mse > 0.0 { (percent(last.mse_deviation / last.mse)) } @else { (dash()) }
                }
                td { (percent(last.relmse.max(0.0).sqrt())) }
                td { @if trimmed { (percent(last.relmse_trimmed.max(0.0).sqrt())) } @else { (dash()) } }
                td { (last.low_frequencies.map_or_else(dash, |share| significant(share, 2))) }
                td { (share(last.lanes_used)) }
                td { (share(last.walk_lanes_used)) }
            }
        }
    };
    html! {
        h3 { "What the error is made of" }
        p {
            "At the largest budget. The spread is the standard deviation of the runs' MSE by its mean: what to expect of a single \
             render. Without the worst 0.1 % of the pixels of each run the error shows what outliers do to it. Low \
             frequencies: the share of the squared error below 1/16 cycle a pixel, compared with that of white noise; above 1 \
             the error hides in blotches. Lanes: the share of SIMD lanes that held work in the shading stages, and that held a \
             live ray in the packets that walk the tree."
        }
        (scrolling(&rows))
    }
}

/// The images at equal time in figures.
pub fn equal_time(words: &Words, shown: &[&Shown]) -> Markup {
    let rows = html! {
        tr {
            th { "" } th { "error" } th { "CPU time" } th { "samples" br; "a pixel" } th { "MSE" } th { "PSNR" } th { "FLIP" }
        }
        @for shown in shown {
            tr {
                td class="name" { (words.experiment.label(shown.configuration)) }
                td { (percent(shown.relmse.max(0.0).sqrt())) }
                td { (seconds(shown.cpu_seconds)) }
                td { @if shown.spp > 0 { (shown.spp) } @else { (dash()) } }
                td { (significant(shown.mse, 2)) }
                td { (shown.psnr.map_or_else(dash, |psnr| format!("{}\u{a0}dB", significant(psnr, 3)))) }
                td { (significant(shown.flip, 2)) }
            }
        }
    };
    scrolling(&rows)
}

/// The error in parts of the film at the largest budget.
pub fn regions(words: &Words) -> Markup {
    let regions = &words.experiment.regions;
    let value = |finding: &Finding, i: usize| {
        finding.points.last().and_then(|point| point.regions.get(i)).map_or(0.0, |relmse| relmse.max(0.0))
    };
    let best = |i: usize| {
        let usable = words.findings.iter().filter(|finding| tag(finding).is_none()).map(|finding| value(finding, i));
        usable.filter(|relmse| *relmse > 0.0).fold(f64::INFINITY, f64::min)
    };
    let rows = html! {
        tr { th { "" } @for region in regions { th { (region.name) } } }
        @for finding in &words.findings {
            tr class=[tag(finding).map(|_| "biased")] {
                td class="name" { (words.label(finding)) }
                @for i in 0..regions.len() {
                    @let relmse = value(finding, i);
                    td class=[(relmse == best(i)).then_some("best")] { (percent(relmse.sqrt())) }
                }
            }
        }
    };
    scrolling(&rows)
}

/// Over all cases: efficiencies as shares of the best, the geometric mean and the worst.
pub fn overview(words: &Words, summaries: &[Summary], all: &[Finding]) -> Markup {
    let experiment = words.experiment;
    let cases = 0..experiment.cases.len();
    let text = |case: usize, configuration: usize| {
        let found = all.iter().find(|f| (f.case, f.configuration) == (case, configuration));
        match share_of_best(all, case, configuration) {
            Some(share) => percent(share),
            None => found.map_or_else(dash, without_share),
        }
    };
    let rows = html! {
        tr {
            th { "" } th { "geometric mean" } th { "worst" }
            @for case in cases.clone() { th { (experiment.case_title(case)) } }
        }
        @for summary in summaries {
            tr {
                td class="name" { (experiment.label(summary.configuration)) }
                td { (summary.geometric_mean.map_or_else(dash, percent)) }
                td {
                    @if let Some((case, share)) = summary.worst {
                        (percent(share)) br; small { (experiment.case_title(case)) }
                    } @else { (dash()) }
                }
                @for case in cases.clone() {
                    @let best = share_of_best(all, case, summary.configuration) == Some(1.0);
                    td class=[best.then_some("best")] { (text(case, summary.configuration)) }
                }
            }
        }
    };
    html! {
        p {
            @match experiment.reach {
                Some(error) => { "Speed to an error of " (target(error)) " as a share of the best in each." }
                None => { "Efficiency, 1 / (relMSE × CPU seconds) at the largest budget, as a share of the best in each." }
            }
            @if experiment.cases.iter().any(|case| !case.is_whole()) { " Geometric mean and worst are of whole scenes." }
        }
        (scrolling(&rows))
    }
}
