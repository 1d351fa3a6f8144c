//! Log-log plots as SVG: error or efficiency against samples or seconds.
//!
//! Written directly and not through a plotting crate: labels stand at their lines, every line also has a marker and a dash
//! pattern of its own, and colours come from custom properties of CSS, so that one file serves dark and light pages, print
//! without colour and the colour-blind. (plotters writes fixed colours and a legend box.)
//!
//! `axis` says how far axes reach and what is written on them, `styles` holds the palette, `series` draws what was
//! measured, `labels` the names. What leaves the axes is cut off by an `svg` element of its own; a `clipPath` would need an
//! id, and several plots of one page must not share ids.

mod axis;
mod labels;
mod layout;
mod numbers;
mod series;
mod styles;

pub use labels::legend;
pub use layout::Layout;
pub use numbers::{number, raised};
pub use series::{Mark, Series, focus_range};
pub use styles::{DARK, LIGHT, STYLE, STYLES};

use axis::{Axis, Labels, hull};
use labels::Name;
use maud::{Markup, PreEscaped, html};
use numbers::width;
use styles::{Style, at, color};

/// What the y axis counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Values {
    /// Shares, labelled in per cent.
    #[default]
    PerCent,
    /// Plain numbers.
    Plain,
}

/// A plot.
#[derive(Clone, Debug, Default)]
pub struct Plot {
    /// What it shows, for those who cannot see it.
    pub title: String,
    /// Above the drawing in bold; none stands there if it is empty.
    pub heading: String,
    /// Under the x axis.
    pub x_label: String,
    /// Above the y axis.
    pub y_label: String,
    /// What is drawn.
    pub series: Vec<Series>,
    /// What the y axis counts.
    pub y_values: Values,
    /// Where the y axis begins and ends, both above 0; nothing: where the data do. What lies outside is cut off, and series
    /// that end outside are not drawn ([`Plot::outside`]): they would be lines without a name.
    pub y_range: Option<(f64, f64)>,
}

/// Above the drawing: a line for the label of the y axis; one more for a heading.
const TOP: f64 = 34.0;
const HEADING: f64 = 20.0;
/// Under it: the labels of the x axis and its name.
const TICKS: f64 = 26.0;
const X_LABEL: f64 = 24.0;

/// The parts of the drawing.
struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Plot {
    /// The plot as an `svg` element.
    pub fn svg(&self, layout: Layout) -> Markup {
        let (frame, x, y) = self.frame(layout);
        let style = format!("svg{{{LIGHT}}}@media (prefers-color-scheme:dark){{svg{{{DARK}}}}}{STYLE}");
        let Layout { width, height, alone, .. } = layout;
        let (fixed_width, fixed_height) = (alone.then_some(width), alone.then_some(height));
        let (across, down) = (frame.right - frame.left, frame.bottom - frame.top);
        html! {
            svg class="plot" xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}"))
                width=[fixed_width] height=[fixed_height] role="img" aria-label=(self.title) {
                title { (self.title) }
                @if alone {
                    style { (PreEscaped(style)) }
                    rect width="100%" height="100%" style="fill:var(--paper)" {}
                }
                (self.axes(&frame, &x, &y))
                svg x=(at(frame.left)) y=(at(frame.top)) width=(at(across)) height=(at(down))
                    viewBox=(format!("{} {} {} {}", at(frame.left), at(frame.top), at(across), at(down))) {
                    (self.layer(|_| 0.0, |series| series.bands(&x, &y)))
                    (self.layer(|style| style.width, |series| series.lines(&x, &y)))
                    (self.layer(|_| 0.0, |series| series.bars(&x, &y)))
                }
                (self.layer(|style| style.reach, |series| series.markers(&x, &y, layout.markers)))
                @if layout.has_names() {
                    (labels::at_ends(self.names(&x, &y), frame.right, width - frame.right, frame.top, frame.bottom))
                }
            }
        }
    }

    /// The names of the series that end outside of `y_range`, and so are not drawn.
    pub fn outside(&self) -> Vec<&str> {
        self.series.iter().filter(|series| self.is_outside(series)).map(|series| series.label.as_str()).collect()
    }

    fn is_outside(&self, series: &Series) -> bool {
        series.end().is_some_and(|mark| !self.in_range(mark.y))
    }

    fn in_range(&self, y: f64) -> bool {
        self.y_range.is_none_or(|(low, high)| (low..=high).contains(&y))
    }

    /// Where the drawing stands, and its axes.
    fn frame(&self, layout: Layout) -> (Frame, Axis, Axis) {
        let heading = if self.heading.is_empty() { 0.0 } else { HEADING };
        let y_label = if self.y_label.is_empty() { TOP / 2.0 } else { 0.0 };
        let top = TOP + heading - y_label;
        let bottom = layout.height - TICKS - if self.x_label.is_empty() { 0.0 } else { X_LABEL };
        let text = if self.y_values == Values::PerCent { axis::per_cent } else { axis::plain };
        let up = Labels { text, extent: |_| 18.0 };
        let marks = || self.series.iter().flat_map(|series| series.marks.iter());
        let y = match self.y_range {
            Some(range) => Axis::within(range, bottom, top, up),
            None => {
                // Intervals too, but not so wide that they push the points together.
                let ends = |mark: &Mark| {
                    mark.interval.map_or([mark.y; 2], |(a, b)| [a.max(mark.y / 2.0), b.min(mark.y * 2.0)])
                };
                Axis::around(hull(marks().map(|mark| mark.y)), hull(marks().flat_map(ends)), bottom, top, up)
            }
        };
        let widest = y.labelled.iter().map(|(_, text)| width(text)).fold(0.0, f64::max);
        let left = layout.left.max(widest + 12.0);
        let names = || self.series.iter().filter(|series| series.end().is_some_and(|mark| self.in_range(mark.y)));
        let right = match layout.has_names() {
            true => layout.width - labels::room(names(), layout.names),
            false => layout.width - Layout::MARGIN,
        };
        let along = Labels { text: axis::plain, extent: |text| width(text) + 9.0 };
        let x = Axis::around(hull(marks().map(|mark| mark.x)), None, left, right, along);
        (Frame { left, right, top, bottom }, x, y)
    }

    /// The series that have a name in the drawing.
    fn names(&self, x: &Axis, y: &Axis) -> Vec<Name<'_>> {
        let name = |series| {
            let mark =
                Series::end(series).filter(|mark| self.in_range(mark.y) && y.holds(mark.y) && x.holds(mark.x))?;
            Some(Name { series, end: (x.position(mark.x), y.position(mark.y)) })
        };
        self.series.iter().filter_map(name).collect()
    }

    /// A part of every series, in its colour; that of the largest `size` lies lowest.
    fn layer(&self, size: fn(Style) -> f64, part: impl Fn(&Series) -> Markup) -> Markup {
        let mut series: Vec<&Series> = self.series.iter().filter(|series| !self.is_outside(series)).collect();
        let size = |series: &&Series| size(Style::of(series.style));
        series.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let parts = series.into_iter().map(|series| (color(series.style), part(series)));
        let parts: Vec<_> = parts.filter(|(_, part)| !part.0.is_empty()).collect();
        html! { @for (color, part) in parts { g style=(color) { (part) } } }
    }

    fn axes(&self, frame: &Frame, x: &Axis, y: &Axis) -> Markup {
        let Frame { left, right, top, bottom } = frame;
        let ends = format!("M{} {}V{}H{}", at(*left), at(*top), at(*bottom), at(*right));
        let over = if self.heading.is_empty() { 16.0 } else { 16.0 + HEADING };
        html! {
            @for (value, label) in &x.labelled {
                @let px = at(x.position(*value));
                path class="rule" d=(format!("M{px} {}V{}", at(*top), at(*bottom))) {}
                path class="axis" d=(format!("M{px} {}v5", at(*bottom))) {}
                text x=(px) y=(at(bottom + 18.0)) text-anchor="middle" { (label) }
            }
            @for (value, label) in &y.labelled {
                @let py = at(y.position(*value));
                path class="rule" d=(format!("M{} {py}H{}", at(*left), at(*right))) {}
                path class="axis" d=(format!("M{} {py}h-5", at(*left))) {}
                text x=(at(left - 8.0)) y=(py) dy="4" text-anchor="end" { (label) }
            }
            @let across = x.minor.iter().map(|value| format!("M{} {}v3", at(x.position(*value)), at(*bottom)));
            @let up = y.minor.iter().map(|value| format!("M{} {}h-3", at(*left), at(y.position(*value))));
            path class="axis" d=(across.chain(up).chain([ends]).collect::<String>()) {}
            @if !self.x_label.is_empty() {
                text x=(at((left + right) / 2.0)) y=(at(bottom + 42.0)) class="soft" text-anchor="middle" { (self.x_label) }
            }
            @if !self.heading.is_empty() { text class="head" x="4" y="16" { (self.heading) } }
            @if !self.y_label.is_empty() { text class="soft" x="4" y=(at(over)) { (self.y_label) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn series(style: usize, last: f64) -> Series {
        let marks = vec![
            Mark { x: 1.0, y: 2.5 * last, interval: Some((2.0 * last, 3.0 * last)) },
            Mark { x: 4.0, y: last, interval: None },
        ];
        Series {
            label: format!("a <b> & \"c\" {style}"),
            note: "−0.50".into(),
            style,
            line: vec![(1.0, 2.5 * last), (4.0, 1.1 * last)],
            extrapolated: vec![(4.0, 1.1 * last), (1e9, 1e-9)],
            marks,
            floor: (style == 4).then_some(last),
            floor_interval: (style == 4).then_some((0.9 * last, 1.1 * last)),
        }
    }

    fn plot(count: usize) -> Plot {
        let series = (0..count).map(|style| series(style, 0.2 * 1.3f64.powi(style as i32))).collect();
        let text = str::to_owned;
        Plot { title: text("error <&> time"), x_label: text("x"), y_label: text("y"), series, ..Plot::default() }
    }

    fn texts(svg: &str) -> Vec<String> {
        let tree = roxmltree::Document::parse(svg).unwrap();
        let texts = tree.descendants().filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text")));
        texts
            .map(|node| node.descendants().filter_map(|part| part.text().filter(|_| part.is_text())).collect())
            .collect()
    }

    #[test]
    fn every_layout_is_well_formed_xml_with_all_numbers_finite() {
        let small = Plot { heading: "one & another".into(), ..plot(STYLES) };
        let ranged = Plot { y_range: Some((0.1, 3.0)), y_values: Values::Plain, ..plot(STYLES) };
        for plot in [plot(0), plot(1), plot(9), plot(STYLES), small, ranged] {
            for layout in [Layout::WIDE, Layout::NARROW, Layout::SMALL, Layout::FILE] {
                let text = plot.svg(layout).into_string();
                let tree = roxmltree::Document::parse(&text).unwrap();
                assert_eq!(tree.root_element().tag_name().name(), "svg");
                assert_eq!(tree.root_element().attribute("aria-label"), Some("error <&> time"));
                assert!(!text.contains("NaN") && !text.contains("inf"));
                assert!(!text.contains(" id="), "two plots of a page must not share ids");
                let named = texts(&text).iter().filter(|text| text.starts_with("a <b> & \"c\"")).count();
                let expected = if layout == Layout::SMALL { 0 } else { plot.series.len() - plot.outside().len() };
                assert_eq!(named, expected);
            }
        }
    }

    #[test]
    fn labels_reach_the_best_and_the_worst_in_every_layout() {
        let plot = plot(9);
        let ends = hull(plot.series.iter().flat_map(|series| &series.marks).map(|mark| mark.y)).unwrap();
        for layout in [Layout::WIDE, Layout::NARROW, Layout::SMALL] {
            let (frame, x, y) = plot.frame(layout);
            let labelled = |axis: &Axis| (axis.labelled[0].0, axis.labelled[axis.labelled.len() - 1].0);
            assert!(labelled(&y).0 <= ends.0 && labelled(&y).1 >= ends.1, "{y:?}");
            assert!(labelled(&x).0 <= 1.0 && labelled(&x).1 >= 4.0, "{x:?}");
            assert!(frame.right - frame.left > 180.0 && frame.bottom - frame.top > 120.0);
        }
    }

    #[test]
    fn per_cent_and_plain_numbers() {
        let y_labels = |y_values: Values| texts(&Plot { y_values, ..plot(2) }.svg(Layout::WIDE).into_string());
        assert!(y_labels(Values::PerCent).contains(&"20\u{a0}%".to_owned()));
        let plain = y_labels(Values::Plain);
        assert!(plain.contains(&"0.2".to_owned()) && !plain.iter().any(|text| text.contains('%')), "{plain:?}");
    }

    #[test]
    fn what_lies_outside_of_the_range_is_cut_off_and_has_no_name() {
        let all = plot(9);
        let range = (1.0, 2.0);
        let plot = Plot { y_range: Some(range), ..all.clone() };
        let inside = |series: &&Series| (range.0..=range.1).contains(&series.marks[1].y);
        let expected: HashSet<String> = all.series.iter().filter(inside).map(|series| series.label.clone()).collect();
        assert!(!expected.is_empty() && expected.len() < 9);
        let text = plot.svg(Layout::WIDE).into_string();
        for series in &all.series {
            let named = texts(&text).iter().any(|text| text.starts_with(&series.label));
            assert_eq!(named, expected.contains(&series.label), "{}", series.label);
            assert_eq!(!named, plot.outside().contains(&series.label.as_str()));
        }
        // Lines lie in an inner svg, which cuts off what leaves it; markers outside are not there, nor what ends outside.
        let tree = roxmltree::Document::parse(&text).unwrap();
        let inner = tree.root_element().children().find(|node| node.tag_name().name() == "svg").unwrap();
        assert!(
            tree.descendants()
                .filter(|node| node.attribute("class") == Some("fit"))
                .all(|node| node.ancestors().any(|up| up == inner))
        );
        let (_, _, y) = plot.frame(Layout::WIDE);
        let markers = tree.descendants().filter(|node| node.has_attribute("transform")).count();
        let drawn = all.series.iter().filter(|series| expected.contains(&series.label));
        let held = drawn.flat_map(|series| &series.marks).filter(|mark| y.holds(mark.y)).count();
        assert_eq!(markers, held + expected.len());
    }

    #[test]
    fn dense_series_keep_some_markers_and_sparse_ones_all() {
        let markers = |count: usize| {
            let mark = |i: usize| Mark { x: 0.01 * (i + 1) as f64, y: 0.2, interval: None };
            let series = Series { marks: (0..count).map(mark).collect(), ..Series::default() };
            let plot = Plot { series: vec![series], ..Plot::default() };
            plot.svg(Layout::SMALL).into_string().matches("transform=").count()
        };
        assert_eq!([1, 2, 14].map(markers), [1, 2, 14]);
        assert!((5..=14).contains(&markers(60)), "{}", markers(60));
    }

    #[test]
    fn markers_of_coincident_series_lie_from_large_to_small() {
        let plot = Plot { series: vec![series(8, 0.2), series(7, 0.2), series(5, 0.2)], ..Plot::default() };
        let text = plot.svg(Layout::SMALL).into_string();
        let last = |style: usize| text.rfind(&format!("<g style=\"--c:var(--s{style})\">")).unwrap();
        assert!(last(5) < last(7) && last(7) < last(8));
    }
}
