//! The tables of the page.

use maud::{Markup, html};

use crate::report::analysis::findings::{Finding, Verdict, sample_ratio};
use crate::report::write::words::{Words, exponent, last_error, percent, seconds, significant, tag, target};
use crate::strategy::Strategy;

/// Efficiency, error, slope, bias: a row a configuration.
pub fn comparison(words: &Words) -> Markup {
    html! {
        div class="scroll" {
            table {
                tr {
                    th { "" } th { "efficiency" br; "of the best" } th { "efficiency" } th { "error at the" br; "largest budget" }
                    th { "CPU time" br; "for it" } th { "slope of MSE" br; "(95 %)" } th { "bias" } th { "z" } th { "lanes" br; "used" }
                }
                @for finding in &words.findings {
                    @let share = words.relative_efficiency(finding);
                    tr class=[tag(finding).map(|_| "biased")] {
                        td class="name" { (words.label(finding)) }
                        td class=[(share == Some(1.0)).then_some("best")] { (share.map_or(tag(finding).unwrap_or("–").to_owned(), percent)) }
                        td { (finding.efficiency.map_or("–".to_owned(), |efficiency| significant(efficiency, 3))) }
                        td { (percent(last_error(finding))) }
                        @let last = finding.points.last();
                        td { (last.map_or(String::new(), |point| seconds(point.cpu_seconds))) }
                        td { (slope(finding)) }
                        td { (format!("{:+.2} %", 100.0 * finding.relative_bias)) }
                        td { (format!("{:.1}", finding.bias_z)) }
                        td { (last.and_then(|point| point.lanes_used).map_or("–".to_owned(), percent)) }
                    }
                }
            }
        }
    }
}

fn slope(finding: &Finding) -> String {
    let Some(fit) = finding.mse_by_samples else { return "–".to_owned() };
    match fit.slope_interval {
        Some(interval) => {
            format!("{} ({} to {})", exponent(fit.law.slope), exponent(interval.low), exponent(interval.high))
        }
        None => exponent(fit.law.slope),
    }
}

/// CPU seconds to the target errors.
pub fn prices(words: &Words) -> Markup {
    let targets: Vec<f64> = words.findings[0].prices.iter().map(|price| price.error).collect();
    let least = |i: usize| {
        let usable = words.findings.iter().filter(|finding| tag(finding).is_none());
        usable.filter_map(|finding| finding.prices[i].cpu_seconds).fold(f64::INFINITY, f64::min)
    };
    html! {
        div class="scroll" {
            table {
                tr { th { "" } @for error in &targets { th { (target(*error)) } } }
                @for finding in &words.findings {
                    tr class=[tag(finding).map(|_| "biased")] {
                        td class="name" { (words.label(finding)) }
                        @for (i, price) in finding.prices.iter().enumerate() {
                            @let best = price.cpu_seconds == Some(least(i)) && tag(finding).is_none();
                            @let class = match (best, price.extrapolated) {
                                (true, true) => Some("best guess"),
                                (true, false) => Some("best"),
                                (false, true) => Some("guess"),
                                (false, false) => None,
                            };
                            td class=[class] {
                                @if finding.verdict == Verdict::Undersampled { "–" }
                                @else { (price.cpu_seconds.map_or("never".to_owned(), seconds)) }
                            }
                        }
                    }
                }
            }
        }
        p class="facts" { "In italics: foreseen by the fitted law, outside of what was measured." }
    }
}

/// Samples for the error of `nee`; nothing where it was not run.
pub fn samples(words: &Words) -> Markup {
    let Some(nee) = words.first_of(Strategy::Nee).filter(|nee| tag(nee).is_none()) else { return html! {} };
    let ratios: Vec<_> = words.findings.iter().filter_map(|f| Some((*f, sample_ratio(f, nee)?))).collect();
    html! {
        h3 { "Samples for the error of nee" }
        p { "How many samples each takes for the error that nee reaches with its largest budget, as a multiple of nee's." }
        div class="scroll" {
            table {
                tr { th { "" } th { "samples" } th { "95 %" } th { "CPU time" } }
                @for (finding, (ratio, interval)) in ratios {
                    tr {
                        td class="name" { (words.label(finding)) }
                        td { (significant(ratio, 3)) " ×" }
                        td {
                            @if let Some(interval) = interval {
                                (significant(interval.low, 3)) " to " (significant(interval.high, 3))
                            } @else { "–" }
                        }
                        td { (significant(ratio * finding.cpu_seconds_by_sample / nee.cpu_seconds_by_sample, 3)) " ×" }
                    }
                }
            }
        }
    }
}

/// The error in parts of the film; nothing where none were asked for.
pub fn regions(words: &Words) -> Markup {
    let regions = &words.experiment.regions;
    if regions.is_empty() {
        return html! {};
    }
    let value = |finding: &Finding, i: usize| finding.regions.get(i).map_or(0.0, |(relmse, _)| *relmse);
    let best = |i: usize| {
        let usable = words.findings.iter().filter(|finding| tag(finding).is_none()).map(|finding| value(finding, i));
        usable.filter(|relmse| *relmse > 0.0).fold(f64::INFINITY, f64::min)
    };
    html! {
        h3 { "By region" }
        p { "Relative error in parts of the film at the largest budget; the least of each in bold." }
        div class="scroll" {
            table {
                tr { th { "" } @for region in regions { th { (region.name) } } }
                @for finding in &words.findings {
                    tr class=[tag(finding).map(|_| "biased")] {
                        td class="name" { (words.label(finding)) }
                        @for i in 0..regions.len() {
                            @let relmse = value(finding, i);
                            td class=[(relmse == best(i)).then_some("best")] { (percent(relmse.max(0.0).sqrt())) }
                        }
                    }
                }
            }
        }
    }
}
