//! Findings as plots.

use crate::report::analysis::findings::{Finding, Point};
use crate::report::write::numbers::exponent;
use crate::report::write::plot::{Mark, Plot, Series};
use crate::report::write::words::{Words, tag};
use crate::strategy::Strategy;

/// Error against CPU seconds and against samples a pixel, each with the name of its file.
pub fn plots(words: &Words, case: &str) -> [(Plot, &'static str); 2] {
    let of = |x: fn(&Point) -> f64| words.findings.iter().map(|f| series(words, f, x)).collect::<Vec<_>>();
    let of_case = if case.is_empty() { String::new() } else { format!(": {case}") };
    let plot = |against: &str, x: fn(&Point) -> f64| Plot {
        title: format!("Relative error against {against}{of_case}"),
        x_label: against.to_owned(),
        y_label: "relative error".to_owned(),
        series: of(x),
    };
    [
        (plot("CPU seconds", |point| point.cpu_seconds), "error-against-seconds"),
        (plot("samples a pixel", |point| point.spp), "error-against-samples"),
    ]
}

/// Points of a fitted line.
const LINE_POINTS: usize = 40;

fn series(words: &Words, finding: &Finding, x: fn(&Point) -> f64) -> Series {
    let usable: Vec<&Point> = finding.points.iter().filter(|point| point.relmse > 0.0 && x(point) > 0.0).collect();
    let interval = |point: &Point| {
        let interval = point.relmse_interval.filter(|interval| interval.low > 0.0)?;
        Some((interval.low.sqrt(), interval.high.sqrt()))
    };
    let mark = |point: &&Point| Mark { x: x(point), y: point.relmse.sqrt(), interval: interval(point) };
    let marks: Vec<Mark> = usable.iter().map(mark).collect();
    let by_samples = usable.first().is_some_and(|point| x(point) == point.spp);
    let fit = if by_samples { finding.relmse_by_samples } else { finding.relmse_by_seconds };
    let (first, last) = (marks.first().map_or(1.0, |mark| mark.x), marks.last().map_or(1.0, |mark| mark.x));
    let steps = (0..=LINE_POINTS).map(|i| first * (last / first).powf(i as f64 / LINE_POINTS as f64));
    let (line, note, floor) = match (finding.biased, fit, finding.law) {
        (true, _, Some(law)) => {
            let scale = if by_samples { 1.0 } else { finding.cpu_seconds_by_sample };
            let line = steps.map(|step| (step, law.at(step / scale).max(0.0).sqrt())).collect();
            (line, String::new(), Some(finding.floor.sqrt()).filter(|floor| *floor > 0.0))
        }
        (false, Some(fit), _) if marks.len() > 1 => {
            let line = steps.map(|step| (step, fit.law.at(step).sqrt())).collect();
            (line, exponent(fit.law.slope / 2.0), None)
        }
        _ => (Vec::new(), String::new(), None),
    };
    let note = tag(finding).map_or(note, str::to_owned);
    Series { label: words.label(finding), note, style: style(words, finding), marks, line, floor }
}

/// Each strategy has a style of its own; where others are varied too, configurations take styles in turn.
fn style(words: &Words, finding: &Finding) -> usize {
    let configurations = &words.experiment.configurations;
    let Some(&own) = configurations.get(finding.configuration) else {
        return Strategy::ALL.len() + finding.configuration - configurations.len();
    };
    let strategy = Strategy::ALL.iter().position(|strategy| *strategy == own.strategy).unwrap_or(0);
    let twins = configurations.iter().take(finding.configuration).filter(|other| other.strategy == own.strategy);
    strategy + 4 * twins.count()
}
