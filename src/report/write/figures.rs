//! Findings as plots.

use crate::report::analysis::findings::{Finding, Point};
use crate::report::write::plot::{Mark, Plot, Series};
use crate::report::write::words::{Words, tag};
use crate::strategy::Strategy;

/// Error against CPU seconds and against samples a pixel.
pub fn plots(words: &Words, light: &str) -> [Plot; 2] {
    let of = |x: fn(&Point) -> f64| words.findings.iter().map(|f| series(words, f, x)).collect::<Vec<_>>();
    let title = |against: &str| format!("Relative error against {against}, light: {light}");
    let y_label = || "relative error".to_owned();
    [
        Plot {
            title: title("CPU seconds"),
            x_label: "CPU seconds".into(),
            y_label: y_label(),
            series: of(|point| point.cpu_seconds),
            ..Plot::default()
        },
        Plot {
            title: title("samples a pixel"),
            x_label: "samples a pixel".into(),
            y_label: y_label(),
            series: of(|point| point.spp),
            ..Plot::default()
        },
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
            (line, format!("{:.2}", fit.law.slope / 2.0).replace('-', "−"), None)
        }
        _ => (Vec::new(), String::new(), None),
    };
    let note = tag(finding).map_or(note, str::to_owned);
    Series { label: words.label(finding), note, style: style(words, finding), marks, line, floor, ..Series::default() }
}

/// Each strategy has a style of its own; where others are varied too, configurations take styles in turn.
fn style(words: &Words, finding: &Finding) -> usize {
    let configurations = &words.experiment.configurations;
    let own = configurations[finding.configuration];
    let strategy = Strategy::ALL.iter().position(|strategy| *strategy == own.strategy).unwrap_or(0);
    let twins = configurations.iter().take(finding.configuration).filter(|other| other.strategy == own.strategy);
    strategy + 4 * twins.count()
}
