//! What was measured, as marks, lines and bands.

use crate::report::write::plot::axis::Axis;
use crate::report::write::plot::styles::{Style, at, path};
use maud::{Markup, html};

/// Series of more marks than this are dense.
const MANY: usize = 14;
/// Least distance of the markers of a dense series.
const MARKER_STEP: f64 = 22.0;

/// One measured point: a value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Samples or seconds, above 0.
    pub x: f64,
    /// Relative error or efficiency, above 0.
    pub y: f64,
    /// The interval of `y`.
    pub interval: Option<(f64, f64)>,
}

/// One configuration.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Its name, written at its end.
    pub label: String,
    /// What stands behind the name in grey.
    pub note: String,
    /// Colour, marker and dashes, below [`super::STYLES`].
    pub style: usize,
    /// What was measured.
    pub marks: Vec<Mark>,
    /// The fitted line, as points to be joined.
    pub line: Vec<(f64, f64)>,
    /// The line beyond what was measured, dotted; it is cut off where the axes end, which it does not move.
    pub extrapolated: Vec<(f64, f64)>,
    /// A level that the line approaches and never passes, dotted; it does not move the axes.
    pub floor: Option<f64>,
    /// The interval of `floor`.
    pub floor_interval: Option<(f64, f64)>,
}

impl Series {
    /// The last mark.
    pub(super) fn end(&self) -> Option<&Mark> {
        self.marks.last()
    }

    /// Bands of intervals and levels: what lies under everything.
    pub(super) fn bands(&self, x: &Axis, y: &Axis) -> Markup {
        let with_interval = self.intervals();
        let upper = with_interval.iter().map(|(vx, (_, high))| (x.position(*vx), y.position(*high)));
        let lower = with_interval.iter().rev().map(|(vx, (low, _))| (x.position(*vx), y.position(*low)));
        html! {
            @if with_interval.len() > 1 { path class="band" d=(path(upper.chain(lower)) + "Z") {} }
            @if let Some((low, high)) = self.floor_interval {
                path class="band" d=(rectangle(x, y.position(high), y.position(low))) {}
            }
            @if let Some(level) = self.floor.filter(|level| y.holds(*level)) {
                path class="floor" d=(format!("M{} {}H{}", at(x.start), at(y.position(level)), at(x.end))) {}
            }
        }
    }

    /// The line and what it foresees.
    pub(super) fn lines(&self, x: &Axis, y: &Axis) -> Markup {
        let along = |points: &[(f64, f64)]| path(points.iter().map(|(vx, vy)| (x.position(*vx), y.position(*vy))));
        html! {
            @if self.line.len() > 1 { (Style::of(self.style).line(&along(&self.line))) }
            @if self.extrapolated.len() > 1 { path class="on" d=(along(&self.extrapolated)) {} }
        }
    }

    /// Bars of intervals.
    pub(super) fn bars(&self, x: &Axis, y: &Axis) -> Markup {
        html! {
            @for (vx, (low, high)) in self.intervals() {
                path class="bar" d=(format!("M{} {}V{}", at(x.position(vx)), at(y.position(high)), at(y.position(low)))) {}
            }
        }
    }

    /// Markers, those that lie inside, `scale` times their usual size. A dense series is seen by its line: of its markers some
    /// stay, a distance apart, and the last.
    pub(super) fn markers(&self, x: &Axis, y: &Axis, scale: f64) -> Markup {
        let inside: Vec<&Mark> = self.marks.iter().filter(|mark| x.holds(mark.x) && y.holds(mark.y)).collect();
        let step = if inside.len() > MANY { MARKER_STEP * scale } else { 0.0 };
        let mut kept: Vec<&Mark> = Vec::new();
        // From the last one on, which a name points at.
        for mark in inside.into_iter().rev() {
            if kept.last().is_none_or(|last| (x.position(last.x) - x.position(mark.x)).abs() >= step) {
                kept.push(mark);
            }
        }
        html! {
            @for mark in kept.into_iter().rev() {
                (Style::of(self.style).marker(x.position(mark.x), y.position(mark.y), scale))
            }
        }
    }

    fn intervals(&self) -> Vec<(f64, (f64, f64))> {
        self.marks.iter().filter_map(|mark| Some((mark.x, mark.interval?))).collect()
    }
}

/// The whole width of the drawing between two heights.
fn rectangle(x: &Axis, top: f64, bottom: f64) -> String {
    format!("M{} {}H{}V{}H{}Z", at(x.start), at(top), at(x.end), at(bottom), at(x.start))
}

/// How much below and above the best a view of the best reaches, as factors.
const FOCUS: (f64, f64) = (4.0, 1.2);
/// Earlier marks may lift the upper end to this multiple of the best.
const MOST_LIFT: f64 = 2.0;

/// Limits of the y axis for a quantity that is the better the larger (efficiency): from a quarter of the best series' last
/// value to a little above it, so that what lies within some per cent of the best is told apart. Earlier marks of those that
/// end inside lift the upper end, to twice the best at most. Nothing if nothing was measured.
pub fn focus_range(series: &[Series]) -> Option<(f64, f64)> {
    let usable = |y: f64| y.is_finite() && y > 0.0;
    let last = |series: &Series| series.end().map(|mark| mark.y).filter(|y| usable(*y));
    let best = series.iter().filter_map(last).fold(0.0, f64::max);
    if best == 0.0 {
        return None;
    }
    let low = best / FOCUS.0;
    let inside = series.iter().filter(|series| last(series).is_some_and(|y| y >= low));
    let marks = inside.flat_map(|series| &series.marks).map(|mark| mark.y).filter(|y| usable(*y));
    let highest = marks.fold(best, f64::max).min(MOST_LIFT * best);
    Some((low, (FOCUS.1 * best).max(1.05 * highest)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(values: &[f64]) -> Series {
        let marks = values.iter().enumerate().map(|(i, y)| Mark { x: i as f64 + 1.0, y: *y, interval: None }).collect();
        Series { marks, ..Series::default() }
    }

    #[test]
    fn the_focus_is_on_the_best() {
        let all = [series(&[100.0, 40.0]), series(&[1500.0, 2900.0]), series(&[2000.0, 3000.0]), series(&[])];
        assert_eq!(focus_range(&all), Some((750.0, 3600.0)));
        // An early mark of a good one lifts the end, one of a bad one does not, nor does an outlier for ever.
        assert_eq!(focus_range(&[series(&[4000.0, 3000.0])]), Some((750.0, 4200.0)));
        assert_eq!(focus_range(&[series(&[9000.0, 10.0]), series(&[3000.0])]), Some((750.0, 3600.0)));
        assert_eq!(focus_range(&[series(&[1e9, 3000.0])]), Some((750.0, 6300.0)));
        assert_eq!(focus_range(&[]), None);
        assert_eq!(focus_range(&[series(&[]), series(&[0.0]), series(&[f64::NAN])]), None);
    }
}
