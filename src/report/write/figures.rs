//! Findings as plots.

use crate::report::analysis::findings::Finding;
use crate::report::analysis::point::Point;
use crate::report::analysis::statistics::Interval;
use crate::report::measure::spectrum::HIGHEST;
use crate::report::write::numbers::exponent;
use crate::report::write::plot::{Mark, Plot, Series, Values, focus_range};
use crate::report::write::words::{Words, tag};
use crate::strategy::Strategy;

/// A plot of a case with the name of its file.
pub struct Figure {
    /// What is drawn.
    pub plot: Plot,
    /// The file's name without its extension.
    pub name: &'static str,
}

/// What a plot has below: CPU seconds or samples.
#[derive(Clone, Copy, PartialEq)]
enum Cost {
    Seconds,
    Samples,
}

impl Cost {
    fn name(self) -> &'static str {
        match self {
            Cost::Seconds => "CPU seconds",
            Cost::Samples => "samples a pixel",
        }
    }

    fn of(self, point: &Point) -> f64 {
        match self {
            Cost::Seconds => point.cpu_seconds,
            Cost::Samples => point.spp,
        }
    }
}

/// Error against CPU seconds and samples, efficiency against CPU seconds, and the spectrum of the error.
pub fn figures(words: &Words, case: &str) -> Vec<Figure> {
    let of_case = |title: &str| if case.is_empty() { title.to_owned() } else { format!("{title}: {case}") };
    let error = |cost: Cost, name: &'static str| {
        let title = of_case(&format!("Relative error against {}", cost.name()));
        Figure { plot: error_plot(words, title, cost), name }
    };
    let mut figures = vec![
        error(Cost::Seconds, "error-against-seconds"),
        Figure {
            plot: efficiency_plot(words, of_case("Efficiency against CPU seconds")),
            name: "efficiency-against-seconds",
        },
        error(Cost::Samples, "error-against-samples"),
    ];
    let spectrum = spectrum_plot(words, of_case("Spectrum of the error at the largest budget"));
    figures.extend(spectrum.map(|plot| Figure { plot, name: "error-spectrum" }));
    // Where nothing has an error there is nothing to draw.
    figures.retain(|figure| figure.plot.series.iter().any(|series| !series.marks.is_empty()));
    figures
}

fn error_plot(words: &Words, title: String, cost: Cost) -> Plot {
    Plot {
        title,
        x_label: cost.name().to_owned(),
        y_label: "relative error".to_owned(),
        series: words.findings.iter().map(|finding| error_series(words, finding, cost)).collect(),
        ..Plot::default()
    }
}

/// Error against CPU seconds, small: one of many.
pub fn small_error_plot(words: &Words, heading: &str) -> Plot {
    Plot {
        heading: heading.to_owned(),
        ..error_plot(words, format!("Relative error against CPU seconds: {heading}"), Cost::Seconds)
    }
}

/// Error against CPU seconds in a part of the film, small: one of many.
pub fn small_region_plot(words: &Words, region: usize) -> Plot {
    let name = &words.experiment.regions[region].name;
    let of = |finding: &&Finding| {
        let error = |point: &Point| point.regions.get(region).map(|relmse| (relmse.max(0.0).sqrt(), None));
        let marks = marks(finding, Cost::Seconds, error);
        Series { line: marks.iter().map(|mark| (mark.x, mark.y)).collect(), marks, ..blank(words, finding) }
    };
    Plot {
        title: format!("Relative error against CPU seconds in {name}"),
        heading: name.clone(),
        x_label: Cost::Seconds.name().to_owned(),
        y_label: "relative error".to_owned(),
        series: words.findings.iter().map(of).collect(),
        ..Plot::default()
    }
}

/// Efficiencies near the best: what the error hides in a line's width.
fn efficiency_plot(words: &Words, title: String) -> Plot {
    let of = |finding: &Finding| {
        let efficiency = |point: &Point| {
            let of = |relmse: f64| (relmse * point.cpu_seconds).recip();
            (point.relmse > 0.0).then(|| (of(point.relmse), point.relmse_interval.map(|interval| interval.map(of))))
        };
        let marks = marks(finding, Cost::Seconds, efficiency);
        Series { line: marks.iter().map(|mark| (mark.x, mark.y)).collect(), marks, ..blank(words, finding) }
    };
    let series: Vec<Series> = words.findings.iter().filter(|finding| tag(finding).is_none()).map(|f| of(f)).collect();
    Plot {
        title,
        x_label: Cost::Seconds.name().to_owned(),
        y_label: "efficiency, 1 / (relMSE × CPU seconds)".to_owned(),
        y_values: Values::Plain,
        y_range: focus_range(&series),
        series,
        ..Plot::default()
    }
}

/// The power of the error over frequency; `None` where no spectrum is known.
fn spectrum_plot(words: &Words, title: String) -> Option<Plot> {
    let of = |finding: &&Finding| {
        let spectrum = finding.last().spectrum.as_ref()?;
        // The mean, and the corners beyond what rows and columns hold, are left out.
        let rings = spectrum.frequency.iter().zip(&spectrum.power);
        let rings = rings.filter(|(frequency, power)| **frequency > 0.0 && **frequency <= HIGHEST && **power > 0.0);
        let marks: Vec<Mark> = rings.map(|(x, y)| Mark { x: *x, y: *y, interval: None }).collect();
        Some(Series { line: marks.iter().map(|mark| (mark.x, mark.y)).collect(), marks, ..blank(words, finding) })
    };
    // What is biased differs from the reference by an image, and its spectrum is that image's.
    let series: Vec<Series> = words.findings.iter().filter(|finding| !finding.biased).filter_map(of).collect();
    (!series.is_empty()).then(|| Plot {
        title,
        x_label: "frequency, cycles a pixel".to_owned(),
        y_label: "power of the error".to_owned(),
        y_values: Values::Plain,
        series,
        ..Plot::default()
    })
}

/// Nothing but a name and a style.
fn blank(words: &Words, finding: &Finding) -> Series {
    Series { label: words.label(finding), style: style(words, finding), ..Series::default() }
}

/// The budgets that have a cost and a value above 0.
fn marks(finding: &Finding, cost: Cost, value: impl Fn(&Point) -> Option<(f64, Option<Interval>)>) -> Vec<Mark> {
    let mark = |point: &Point| {
        let (x, (y, interval)) = (cost.of(point), value(point)?);
        let interval = interval.filter(|interval| interval.low > 0.0).map(|interval| (interval.low, interval.high));
        (x > 0.0 && y > 0.0).then_some(Mark { x, y, interval })
    };
    finding.points.iter().filter_map(mark).collect()
}

/// Points of a curve that bends.
const LINE_POINTS: usize = 40;
/// How much further than the measured points a line is drawn, as extrapolated.
const BEYOND: f64 = 1e3;

fn error_series(words: &Words, finding: &Finding, cost: Cost) -> Series {
    let error = |point: &Point| {
        Some((point.relmse.max(0.0).sqrt(), point.relmse_interval.map(|interval| interval.map(f64::sqrt))))
    };
    let marks = marks(finding, cost, error);
    let (first, last) = (marks.first().map_or(1.0, |mark| mark.x), marks.last().map_or(1.0, |mark| mark.x));
    let joined = marks.iter().map(|mark| (mark.x, mark.y)).collect();
    // The slope goes on from the last point that can be relied on.
    let sound = finding.points.iter().rfind(|point| !point.outliers && point.relmse > 0.0 && cost.of(point) > 0.0);
    let mut series = Series { marks, line: joined, ..blank(words, finding) };
    match (finding.level, &finding.curve, sound) {
        (Some(level), ..) => {
            let scale = if cost == Cost::Samples { 1.0 } else { finding.cpu_seconds_by_sample };
            let steps = (0..=LINE_POINTS).map(|i| first * (last / first).powf(i as f64 / LINE_POINTS as f64));
            series.line = steps.map(|step| (step, level.at(step / scale).max(0.0).sqrt())).collect();
            series.floor = Some(level.floor.sqrt());
            let interval = finding.floor_interval.map(|interval| interval.map(f64::sqrt));
            series.floor_interval = interval.filter(|i| i.low > 0.0).map(|interval| (interval.low, interval.high));
        }
        (None, Some(curve), Some(point)) if !finding.biased && finding.points.len() > 1 && curve.last_slope() < 0.0 => {
            let (from, error) = (cost.of(point), point.relmse.sqrt());
            series.extrapolated = vec![(from, error), (BEYOND * from, error * BEYOND.powf(curve.last_slope() / 2.0))];
            let slope = finding.relmse_by_samples.filter(|_| cost == Cost::Samples);
            series.note = slope.map(|slope| exponent(slope.value / 2.0)).unwrap_or_default();
        }
        _ => {}
    }
    if let Some(tag) = tag(finding) {
        series.note = tag.to_owned();
    }
    series
}

/// Names and styles of all findings, for a legend of small plots.
pub fn names(words: &Words) -> Vec<(String, usize)> {
    words.findings.iter().map(|finding| (words.label(finding), style(words, finding))).collect()
}

/// Each strategy has a style of its own; where others are varied too, configurations take styles in turn. Other renderers
/// follow the strategies.
fn style(words: &Words, finding: &Finding) -> usize {
    let configurations = &words.experiment.configurations;
    let Some(&own) = configurations.get(finding.configuration) else {
        return Strategy::ALL.len() + finding.configuration - configurations.len();
    };
    let strategy = Strategy::ALL.iter().position(|strategy| *strategy == own.strategy).unwrap_or(0);
    let twins = configurations.iter().take(finding.configuration).filter(|other| other.strategy == own.strategy);
    strategy + 4 * twins.count()
}
