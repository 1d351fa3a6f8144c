//! Log-log plots as SVG: error against samples or seconds.
//!
//! Written directly and not through a plotting crate: labels stand at their lines, every line also has a marker and a dash
//! pattern of its own, and colours come from custom properties of CSS, so that one file serves dark and light pages, print
//! without colour and the colour-blind. (plotters writes fixed colours and a legend box.)

use maud::{Markup, PreEscaped, html};

/// One measured point: a value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Samples or seconds, above 0.
    pub x: f64,
    /// Relative error, above 0.
    pub y: f64,
    /// The interval of `y`.
    pub interval: Option<(f64, f64)>,
}

/// One configuration.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name, written at its end.
    pub label: String,
    /// What stands behind the name in grey.
    pub note: String,
    /// Colour, marker and dashes, from 0 to 8.
    pub style: usize,
    /// What was measured.
    pub marks: Vec<Mark>,
    /// The fitted line, as points to be joined.
    pub line: Vec<(f64, f64)>,
    /// A level that the line approaches and never passes.
    pub floor: Option<f64>,
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What it shows, for those who cannot see it.
    pub title: String,
    /// Under the x axis.
    pub x_label: String,
    /// Above the y axis.
    pub y_label: String,
    /// What is drawn.
    pub series: Vec<Series>,
}

/// How much room a plot has, in its own units; text is 13 of them high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    width: f64,
    height: f64,
    /// Right of the drawing, for the names.
    names: f64,
    /// Brings its own styles and ground, as a file by itself needs them.
    alone: bool,
}

impl Layout {
    /// In a page on a desk.
    pub const WIDE: Layout = Layout { width: 960.0, height: 560.0, names: 240.0, alone: false };
    /// In a page on a phone.
    pub const NARROW: Layout = Layout { width: 470.0, height: 430.0, names: 198.0, alone: false };
    /// A file by itself.
    pub const FILE: Layout = Layout { alone: true, ..Layout::WIDE };

    fn right(self) -> f64 {
        self.width - self.names
    }
    fn bottom(self) -> f64 {
        self.height - 50.0
    }
}

const LEFT: f64 = 66.0;
const TOP: f64 = 34.0;
/// Units a decade needs for labels at 2 and 5 in it.
const ROOMY_DECADE: f64 = 140.0;
/// Least distance of two labels.
const LABEL_STEP: f64 = 18.0;

/// The custom properties that plots and pages use: light, then dark. The colours are those of Okabe and Ito (2008), which
/// the colour-blind tell apart, a little darker or lighter where the ground demands it.
pub const LIGHT: &str = "--paper:#fff;--ink:#1c1e21;--soft:#5d6470;--rule:#d9dce1;--s0:#3a8fc4;--s1:#0060a0;--s2:#a06a00;\
--s3:#d98c00;--s4:#7a7a7a;--s5:#00815c;--s6:#b5588f;--s7:#c84b00;--s8:#1c1e21;";
/// See [`LIGHT`].
pub const DARK: &str = "--paper:#15171a;--ink:#e8eaed;--soft:#a0a7b2;--rule:#33373d;--s0:#7cc4ee;--s1:#4aa3e0;--s2:#d0a24a;\
--s3:#f0b440;--s4:#9a9a9a;--s5:#2fc79a;--s6:#e39ac4;--s7:#ff8648;--s8:#e8eaed;";
/// How the parts of a plot look.
pub const STYLE: &str = ".plot{font:13px system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;display:block;width:100%;height:auto}\
.plot text{fill:var(--ink)}.plot .soft{fill:var(--soft)}.plot .rule{stroke:var(--rule);stroke-width:1;fill:none}\
.plot .axis{stroke:var(--ink);stroke-width:1;fill:none}.plot .fit{fill:none;stroke:var(--c);stroke-width:1.6}\
.plot .floor{fill:none;stroke:var(--c);stroke-width:1;stroke-dasharray:1 4}.plot .lead{fill:none;stroke:var(--soft);stroke-width:.6}\
.plot .band{fill:var(--c);fill-opacity:.2;stroke:none}.plot .bar{stroke:var(--c);stroke-width:1.2;fill:none}\
.plot .solid{fill:var(--c);stroke:var(--c);stroke-width:1.4}.plot .hollow{fill:var(--paper);stroke:var(--c);stroke-width:1.6}\
.plot .open{fill:none;stroke:var(--c);stroke-width:1.8}";

const DASHES: [&str; 9] = ["7 4", "12 4", "2 3", "10 3 2 3", "1 4", "none", "5 2 1 2 1 2", "14 3 4 3", "none"];

/// Marker shapes: a path around the origin and how it is painted.
const MARKERS: [(&str, &str); 9] = [
    ("M-4 -4H4V4H-4Z", "hollow"),
    ("M-4 -4H4V4H-4Z", "solid"),
    ("M0 -5L4.6 4H-4.6Z", "hollow"),
    ("M0 -5L4.6 4H-4.6Z", "solid"),
    ("M0 5L4.6 -4H-4.6Z", "hollow"),
    ("M-4 0A4 4 0 1 1 4 0A4 4 0 1 1 -4 0Z", "solid"),
    ("M0 -5.2L5.2 0L0 5.2L-5.2 0Z", "hollow"),
    ("M0 -5.2L5.2 0L0 5.2L-5.2 0Z", "solid"),
    ("M-4.5 -4.5L4.5 4.5M-4.5 4.5L4.5 -4.5M-5.5 0H5.5", "open"),
];

/// A logarithmic axis: from 10^`low` to 10^`high`, over `start` to `end` in pixels.
#[derive(Clone, Copy, Debug)]
struct Axis {
    low: f64,
    high: f64,
    start: f64,
    end: f64,
}

impl Axis {
    /// Wide enough for `values`, with some room; a decade about 1 if there are none.
    fn around(values: impl Iterator<Item = f64>, start: f64, end: f64) -> Axis {
        let (low, high) = values
            .filter(|v| *v > 0.0 && v.is_finite())
            .fold((f64::MAX, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        if high == 0.0 {
            return Axis { low: -0.5, high: 0.5, start, end };
        }
        let (low, high) = (low.log10(), high.log10());
        let room = (0.04 * (high - low)).max(0.08);
        Axis { low: low - room, high: high + room, start, end }
    }

    fn position(self, value: f64) -> f64 {
        let share = (value.log10() - self.low) / (self.high - self.low);
        self.start + share.clamp(-0.5, 1.5) * (self.end - self.start)
    }

    fn holds(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value.log10())
    }

    /// Ticks and whether they are labelled: decades, and 2 and 5 between them where there is room.
    fn ticks(self) -> Vec<(f64, bool)> {
        let dense = (self.end - self.start).abs() / (self.high - self.low) > ROOMY_DECADE;
        let mut ticks = Vec::new();
        for decade in self.low.floor() as i32..=self.high.ceil() as i32 {
            for step in 1..10 {
                let value = step as f64 * 10f64.powi(decade);
                if (self.low..=self.high).contains(&value.log10()) {
                    ticks.push((value, step == 1 || dense && (step == 2 || step == 5)));
                }
            }
        }
        ticks
    }
}

/// A coordinate, short.
fn at(value: f64) -> String {
    format!("{value:.1}")
}

/// A number without needless zeros.
fn number(value: f64) -> String {
    match value {
        v if !(1e-5..1e6).contains(&v) => format!("{v:e}"),
        v => format!("{}", (v * 1e7).round() / 1e7),
    }
}

fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let steps = points.enumerate().map(|(i, (x, y))| format!("{}{} {}", if i == 0 { 'M' } else { 'L' }, at(x), at(y)));
    steps.collect()
}

impl Plot {
    /// The plot as an `svg` element.
    pub fn svg(&self, layout: Layout) -> Markup {
        let marks = || self.series.iter().flat_map(|series| series.marks.iter());
        let x = Axis::around(marks().map(|mark| mark.x), LEFT, layout.right());
        // Intervals too, but not so wide that they push the points together.
        let ends = |mark: &Mark| mark.interval.map_or([mark.y; 2], |(a, b)| [a.max(mark.y / 2.0), b.min(mark.y * 2.0)]);
        let y = Axis::around(marks().flat_map(ends), layout.bottom(), TOP);
        let style = format!("svg{{{LIGHT}}}@media (prefers-color-scheme:dark){{svg{{{DARK}}}}}{STYLE}");
        let Layout { width, height, alone, .. } = layout;
        let (fixed_width, fixed_height) = (alone.then_some(width), alone.then_some(height));
        html! {
            svg class="plot" xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}"))
                width=[fixed_width] height=[fixed_height] role="img" aria-label=(self.title) {
                title { (self.title) }
                @if alone {
                    style { (PreEscaped(style)) }
                    rect width="100%" height="100%" style="fill:var(--paper)" {}
                }
                (self.axes(layout, x, y))
                @for series in &self.series { (draw(series, x, y)) }
                (self.labels(layout, x, y))
            }
        }
    }

    fn axes(&self, layout: Layout, x: Axis, y: Axis) -> Markup {
        let (bottom, right) = (layout.bottom(), layout.right());
        html! {
            @for (value, labelled) in x.ticks() {
                @let px = at(x.position(value));
                @if labelled {
                    path class="rule" d=(format!("M{px} {TOP}V{bottom}")) {}
                    text x=(px) y=(at(bottom + 18.0)) text-anchor="middle" { (number(value)) }
                }
                path class="axis" d=(format!("M{px} {bottom}v{}", if labelled { 5 } else { 3 })) {}
            }
            @for (value, labelled) in y.ticks() {
                @let py = at(y.position(value));
                @if labelled {
                    path class="rule" d=(format!("M{LEFT} {py}H{right}")) {}
                    text x=(at(LEFT - 8.0)) y=(py) dy="4" text-anchor="end" { (number(value * 100.0)) " %" }
                }
                path class="axis" d=(format!("M{LEFT} {py}h-{}", if labelled { 5 } else { 3 })) {}
            }
            path class="axis" d=(format!("M{LEFT} {TOP}V{bottom}H{right}")) {}
            text x=(at((LEFT + right) / 2.0)) y=(at(bottom + 42.0)) text-anchor="middle" { (self.x_label) }
            text x="4" y="16" { (self.y_label) }
        }
    }

    /// Names at the ends of their lines, pushed apart where they would touch, each with its marker.
    fn labels(&self, layout: Layout, x: Axis, y: Axis) -> Markup {
        let end = |series: &Series| series.marks.last().map(|mark| (x.position(mark.x), y.position(mark.y)));
        let mut ends: Vec<(usize, f64, f64)> =
            self.series.iter().enumerate().filter_map(|(i, series)| end(series).map(|(px, py)| (i, px, py))).collect();
        ends.sort_by(|a, b| a.2.total_cmp(&b.2));
        let places = spread(&ends.iter().map(|end| end.2).collect::<Vec<_>>(), TOP, layout.bottom());
        let left = layout.right() + 18.0;
        html! {
            @for (&(i, px, py), place) in ends.iter().zip(places) {
                @let series = &self.series[i];
                path class="lead" d=(path([(px + 7.0, py), (left - 6.0, place)].into_iter())) {}
                g style=(color(series.style)) { (marker(series.style, left + 4.0, place)) }
                text x=(at(left + 16.0)) y=(at(place)) dy="4" {
                    (series.label) " "
                    tspan class="soft" { (series.note) }
                }
            }
        }
    }
}

fn color(style: usize) -> String {
    format!("--c:var(--s{})", style % 9)
}

fn marker(style: usize, px: f64, py: f64) -> Markup {
    let (shape, class) = MARKERS[style % 9];
    html! { path class=(class) d=(shape) transform=(format!("translate({} {})", at(px), at(py))) {} }
}

fn draw(series: &Series, x: Axis, y: Axis) -> Markup {
    let place = |(vx, vy): (f64, f64)| (x.position(vx), y.position(vy));
    let with_interval = series.marks.iter().filter_map(|mark| Some((mark.x, mark.interval?)));
    let with_interval: Vec<(f64, (f64, f64))> = with_interval.collect();
    let upper = with_interval.iter().map(|(vx, (_, high))| place((*vx, *high)));
    let lower = with_interval.iter().rev().map(|(vx, (low, _))| place((*vx, *low)));
    html! {
        g style=(color(series.style)) {
            @if with_interval.len() > 1 {
                path class="band" d=(path(upper.chain(lower)) + "Z") {}
            }
            path class="fit" stroke-dasharray=(DASHES[series.style % 9]) d=(path(series.line.iter().copied().map(place))) {}
            @if let Some(level) = series.floor.filter(|level| y.holds(*level)) {
                path class="floor" d=(format!("M{LEFT} {}H{}", at(y.position(level)), x.end)) {}
            }
            @for (vx, (low, high)) in &with_interval {
                @let ((px, top), (_, bottom)) = (place((*vx, *high)), place((*vx, *low)));
                path class="bar" d=(path([(px, top), (px, bottom)].into_iter())) {}
            }
            @for mark in &series.marks {
                @let (px, py) = place((mark.x, mark.y));
                (marker(series.style, px, py))
            }
        }
    }
}

/// Ascending `wanted` positions moved apart to at least [`LABEL_STEP`], as little as it takes, within `top` and `bottom`.
fn spread(wanted: &[f64], top: f64, bottom: f64) -> Vec<f64> {
    let step = LABEL_STEP.min((bottom - top) / wanted.len().max(1) as f64);
    // Groups that touch share the error: (first index, members, mean position they want).
    let mut groups: Vec<(usize, f64)> = Vec::new();
    for &position in wanted {
        groups.push((1, position));
        while groups.len() > 1 {
            let ((n, a), (m, b)) = (groups[groups.len() - 2], groups[groups.len() - 1]);
            if b - a >= step * (n + m) as f64 / 2.0 {
                break;
            }
            groups.truncate(groups.len() - 2);
            groups.push((n + m, (a * n as f64 + b * m as f64) / (n + m) as f64));
        }
    }
    let mut places: Vec<f64> = Vec::new();
    for (members, center) in groups {
        let first = center - step * (members as f64 - 1.0) / 2.0;
        places.extend((0..members).map(|i| first + step * i as f64));
    }
    // At the ends everything shifts inwards.
    for (i, place) in places.iter_mut().enumerate() {
        *place = place.max(top + step * i as f64);
    }
    let count = places.len();
    for (i, place) in places.iter_mut().enumerate() {
        *place = place.min(bottom - step * (count - 1 - i) as f64);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_never_touch_and_stay_near() {
        assert_eq!(spread(&[100.0, 200.0], 0.0, 500.0), [100.0, 200.0]);
        assert_eq!(spread(&[100.0, 100.0, 100.0], 0.0, 500.0), [82.0, 100.0, 118.0]);
        assert_eq!(spread(&[0.0, 1.0], 0.0, 500.0), [0.0, 18.0]);
        assert_eq!(spread(&[500.0, 500.0], 0.0, 500.0), [482.0, 500.0]);
        let many = spread(&[50.0; 40], 0.0, 400.0);
        assert!(many.windows(2).all(|pair| pair[1] - pair[0] > 9.99) && many[39] <= 400.0);
        assert!(spread(&[], 0.0, 1.0).is_empty());
    }

    #[test]
    fn axes_hold_their_values_and_label_some() {
        let axis = Axis::around([1.0, 256.0].into_iter(), 0.0, 100.0);
        assert!(axis.position(1.0) > 0.0 && axis.position(256.0) < 100.0 && axis.position(1.0) < axis.position(2.0));
        let labels = |axis: Axis| axis.ticks().iter().filter(|tick| tick.1).map(|tick| tick.0).collect::<Vec<_>>();
        assert_eq!(labels(axis), [1.0, 10.0, 100.0]);
        let roomy = Axis { end: 600.0, ..axis };
        assert_eq!(labels(roomy), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0]);
        assert!(axis.holds(16.0) && !axis.holds(1e4) && !axis.holds(0.0));
        assert!(!labels(Axis::around([].into_iter(), 0.0, 1.0)).is_empty());
        assert_eq!([0.01, 0.002, 100.0, 20000.0, 1e7].map(number), ["0.01", "0.002", "100", "20000", "1e7"]);
    }

    #[test]
    fn the_file_is_well_formed_xml() {
        let marks = vec![Mark { x: 1.0, y: 0.5, interval: Some((0.4, 0.6)) }, Mark { x: 4.0, y: 0.2, interval: None }];
        let series = |style: usize| Series {
            label: "a <b> & \"c\"".into(),
            note: "-0.50".into(),
            style,
            marks: marks.clone(),
            line: vec![(1.0, 0.5), (4.0, 0.25)],
            floor: (style == 4).then_some(0.2),
        };
        let axis = |text: &str| text.to_owned();
        let title = axis("error <&> time");
        let plot = Plot { title, x_label: axis("x"), y_label: axis("y"), series: (0..9).map(series).collect() };
        let text = plot.svg(Layout::FILE).into_string();
        let tree = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(tree.root_element().tag_name().name(), "svg");
        let texts: Vec<&str> =
            tree.descendants().filter(|node| node.is_text()).filter_map(|node| node.text()).collect();
        assert_eq!(texts.iter().filter(|text| text.contains("a <b> & \"c\"")).count(), 9);
        let shapes: std::collections::HashSet<_> =
            MARKERS.iter().zip(DASHES).map(|(marker, dash)| format!("{marker:?}{dash}")).collect();
        assert_eq!(shapes.len(), 9, "each can be told without its colour");
        // Nothing outside the drawing area, nothing that is not a number.
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }
}
