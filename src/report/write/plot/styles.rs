//! Colours, markers and dashes.
//!
//! No line is told from another by its colour alone: each has a marker and a dash pattern of its own. Lines and markers that
//! coincide stay visible: a broad pale line under a dashed under a thin one, a large ring around a diamond around a dot.

use maud::{Markup, html};

/// How many styles there are: nine strategies, and eight for what is compared with them.
pub const STYLES: usize = 17;

/// The custom properties that plots and pages use: light, then dark. The first nine colours are those of Okabe and Ito (2008),
/// the others follow Tol (2021), "Colour Schemes"; both are made for the colour-blind, and are a little darker or lighter
/// here where the ground demands it: each has a contrast of at least 3 to the paper (WCAG 2.2, 1.4.11).
pub const LIGHT: &str = "--paper:#fff;--ink:#1c1e21;--soft:#5d6470;--rule:#d9dce1;--s0:#3a8fc4;--s1:#0060a0;--s2:#a06a00;\
--s3:#c47d00;--s4:#7a7a7a;--s5:#00815c;--s6:#b5588f;--s7:#c84b00;--s8:#1c1e21;--s9:#882255;--s10:#332288;--s11:#117733;\
--s12:#7d7a1a;--s13:#9a3fa0;--s14:#23897c;--s15:#c0485e;--s16:#6b4a2b;";
/// See [`LIGHT`].
pub const DARK: &str = "--paper:#15171a;--ink:#e8eaed;--soft:#a0a7b2;--rule:#33373d;--s0:#7cc4ee;--s1:#4aa3e0;--s2:#d0a24a;\
--s3:#f0b440;--s4:#9a9a9a;--s5:#2fc79a;--s6:#e39ac4;--s7:#ff8648;--s8:#e8eaed;--s9:#d75f98;--s10:#8f83e8;--s11:#5fbf7a;\
--s12:#c9c95a;--s13:#d68ad0;--s14:#6fd0c2;--s15:#f0909c;--s16:#c9a27e;";
/// How the parts of a plot look.
pub const STYLE: &str = ".plot{font:13px system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;display:block;width:100%;height:auto}\
.plot text{fill:var(--ink)}.plot .soft{fill:var(--soft)}.plot .head{font-weight:600}\
.plot .rule{stroke:var(--rule);stroke-width:1;fill:none}.plot .axis{stroke:var(--ink);stroke-width:1;fill:none}\
.plot .fit{fill:none;stroke:var(--c)}.plot .on{fill:none;stroke:var(--c);stroke-width:1.6;stroke-linecap:round;stroke-dasharray:.1 4.5}\
.plot .floor{fill:none;stroke:var(--c);stroke-width:1.2;stroke-linecap:round;stroke-dasharray:.1 5}\
.plot .lead{fill:none;stroke:var(--soft);stroke-width:.6}.plot .band{fill:var(--c);fill-opacity:.15;stroke:none}\
.plot .bar{stroke:var(--c);stroke-width:1.2;fill:none}.plot .solid{fill:var(--c);stroke:var(--paper);stroke-width:1}\
.plot .hollow{fill:var(--paper);stroke:var(--c);stroke-width:1.6}.plot .open{fill:none;stroke:var(--c);stroke-width:2}\
.plot.key{display:inline-block;width:44px;height:16px;flex:none}\
.legend{display:flex;flex-wrap:wrap;gap:.3rem 1.1rem;list-style:none;margin:.6rem 0;padding:0;max-width:none;\
font:.86rem system-ui,-apple-system,'Segoe UI',Roboto,sans-serif}.legend li{display:inline-flex;align-items:center;gap:.4rem}";

/// How one series is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    /// The marker: a path around the origin.
    shape: &'static str,
    /// Its class: `hollow`, `solid` or `open`.
    paint: &'static str,
    /// How far the marker reaches.
    pub reach: f64,
    /// The pattern of the line.
    dashes: &'static str,
    /// Width of the line.
    pub width: f64,
    /// Opacity of the line: broad lines are pale.
    opacity: f64,
}

const fn style(shape: &'static str, paint: &'static str, reach: f64, dashes: &'static str, width: f64) -> Style {
    Style { shape, paint, reach, dashes, width, opacity: if width > 3.0 { 0.45 } else { 1.0 } }
}

const TABLE: [Style; STYLES] = [
    style("M-5 -5H5V5H-5Z", "hollow", 5.0, "7 4", 1.6),
    style("M-3.4 -3.4H3.4V3.4H-3.4Z", "solid", 3.4, "12 4", 1.6),
    style("M0 -6L5.4 4.6H-5.4Z", "hollow", 6.0, "4 3", 1.6),
    style("M0 -5L4.6 4H-4.6Z", "solid", 5.0, "10 3 3 3", 1.6),
    style("M0 7L6.6 -5.4H-6.6Z", "hollow", 7.0, "4 7", 1.6),
    style("M-6.5 0A6.5 6.5 0 1 1 6.5 0A6.5 6.5 0 1 1 -6.5 0Z", "hollow", 6.5, "none", 4.5),
    style("M0 -5.6L5.6 0L0 5.6L-5.6 0Z", "hollow", 5.6, "6 2 2 2 2 2", 1.6),
    style("M0 -5L5 0L0 5L-5 0Z", "solid", 4.9, "9 5", 2.6),
    style("M-2.7 0A2.7 2.7 0 1 1 2.7 0A2.7 2.7 0 1 1 -2.7 0Z", "solid", 2.7, "none", 1.1),
    style("M-6 0H6M0 -6V6", "open", 6.1, "16 4", 1.6),
    style("M-4.6 -4.6L4.6 4.6M-4.6 4.6L4.6 -4.6", "open", 4.6, "6 2", 1.6),
    style(
        "M0 -6.5L1.6 -2.2L6.2 -2L2.6 .8L3.8 5.3L0 2.7L-3.8 5.3L-2.6 .8L-6.2 -2L-1.6 -2.2Z",
        "solid",
        6.4,
        "20 3 3 3",
        1.6,
    ),
    style("M-6 0L-3 -5.2H3L6 0L3 5.2H-3Z", "hollow", 5.9, "4 2 8 2", 1.6),
    style("M0 -4.8L4.6 -1.5L2.8 3.9H-2.8L-4.6 -1.5Z", "solid", 4.7, "8 3 3 3 3 3", 1.6),
    style("M-5 -5.4H5L-5 5.4H5Z", "hollow", 5.4, "5 5", 1.6),
    style("M5 0L-4 4.6V-4.6Z", "solid", 4.8, "14 2 5 2", 1.6),
    style("M-7 0L5.4 6.4V-6.4Z", "hollow", 6.9, "3 3 9 3", 1.6),
];

impl Style {
    /// The style of a number; more than [`STYLES`] come again.
    pub fn of(number: usize) -> Style {
        TABLE[number % STYLES]
    }

    /// A line along `d`.
    pub fn line(self, d: &str) -> Markup {
        let opacity = (self.opacity < 1.0).then_some(self.opacity);
        html! {
            path class="fit" stroke-dasharray=(self.dashes) stroke-width=(self.width) stroke-opacity=[opacity] d=(d) {}
        }
    }

    /// The marker at a place, `scale` times its usual size.
    pub fn marker(self, px: f64, py: f64, scale: f64) -> Markup {
        let size = if scale == 1.0 { String::new() } else { format!("scale({scale})") };
        let place = format!("translate({} {}){size}", at(px), at(py));
        html! { path class=(self.paint) d=(self.shape) transform=(place) {} }
    }
}

/// The property that gives a group the colour of a style.
pub(super) fn color(number: usize) -> String {
    format!("--c:var(--s{})", number % STYLES)
}

/// A coordinate, short.
pub(super) fn at(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").unwrap_or(&text).to_owned()
}

/// A path through `points`, less those that a straight line passes within a tenth of a unit.
pub(super) fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let points: Vec<(f64, f64)> = points.collect();
    let mut kept: Vec<usize> = Vec::new();
    for i in 0..points.len() {
        let from = kept.last().copied();
        let straight = |from: usize| {
            let ((ax, ay), (bx, by)) = (points[from], points[i + 1]);
            let length = (bx - ax).hypot(by - ay).max(1e-9);
            let off = |&(x, y): &(f64, f64)| ((bx - ax) * (y - ay) - (by - ay) * (x - ax)).abs() / length;
            points[from + 1..=i].iter().all(|point| off(point) < 0.1)
        };
        if i + 1 == points.len() || !from.is_some_and(straight) {
            kept.push(i);
        }
    }
    let step =
        |(n, &i): (usize, &usize)| format!("{}{} {}", if n == 0 { 'M' } else { 'L' }, at(points[i].0), at(points[i].1));
    kept.iter().enumerate().map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::linear_from_srgb;
    use std::collections::HashSet;

    #[test]
    fn every_style_can_be_told_without_its_color() {
        let markers: HashSet<&str> = TABLE.iter().map(|style| style.shape).collect();
        assert_eq!(markers.len(), STYLES);
        let lines: HashSet<String> = TABLE.iter().map(|style| format!("{} {}", style.dashes, style.width)).collect();
        assert_eq!(lines.len(), STYLES);
        // Dots are for what was not measured.
        let dotted = |style: &Style| {
            style.dashes.split(' ').filter_map(|dash| dash.parse::<f64>().ok()).step_by(2).all(|dash| dash < 3.0)
        };
        assert!(!TABLE.iter().any(|style| style.dashes != "none" && dotted(style)));
        assert_eq!(Style::of(STYLES + 3), Style::of(3));
    }

    #[test]
    fn strategies_that_coincide_are_seen_through_each_other() {
        // nee, mis-balance and mis-power: each marker and line lies well inside the one drawn before.
        let [outer, middle, inner] = [5, 7, 8].map(Style::of);
        assert!(outer.reach > middle.reach + 1.0 && middle.reach > inner.reach + 1.0);
        assert!(outer.width > middle.width + 1.0 && middle.width > inner.width + 1.0);
        assert!(outer.paint == "hollow" && outer.opacity < 0.5 && middle.dashes != "none");
    }

    /// The colours of a theme by their names.
    fn colors(theme: &str) -> Vec<(String, f64)> {
        let luminance = |hex: &str| {
            let digits = if hex.len() == 3 { hex.chars().flat_map(|c| [c, c]).collect() } else { hex.to_owned() };
            let channel = |i: usize| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).expect("a colour");
            let [r, g, b] = [0, 1, 2].map(|i| linear_from_srgb(channel(i) as f64 / 255.0));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let entry = |text: &str| {
            let (name, hex) = text.split_once(":#").expect("a colour");
            (name.to_owned(), luminance(hex))
        };
        theme.split(';').filter(|text| !text.is_empty()).map(entry).collect()
    }

    #[test]
    fn every_color_stands_out_from_the_paper() {
        for theme in [LIGHT, DARK] {
            let all = colors(theme);
            let paper = all[0].1;
            for (name, luminance) in all.iter().filter(|(name, _)| !["--paper", "--rule"].contains(&name.as_str())) {
                let contrast = (luminance.max(paper) + 0.05) / (luminance.min(paper) + 0.05);
                assert!(contrast >= 3.0, "{name}: {contrast}");
            }
            let names: HashSet<&String> = all.iter().map(|color| &color.0).collect();
            assert!((0..STYLES).all(|i| names.contains(&format!("--s{i}"))));
        }
        let names = |theme| colors(theme).into_iter().map(|color| color.0).collect::<Vec<_>>();
        assert_eq!(names(LIGHT), names(DARK));
    }

    #[test]
    fn paths_keep_their_bends_only() {
        let straight = (0..=40).map(|i| (i as f64, 2.0 * i as f64));
        assert_eq!(path(straight), "M0 0L40 80");
        assert_eq!(path([(0.0, 0.0), (1.0, 5.0), (2.0, 0.0)].into_iter()), "M0 0L1 5L2 0");
        assert_eq!(path([(1.0, 2.0)].into_iter()), "M1 2");
        assert_eq!(path([].into_iter()), "");
        let bent: Vec<(f64, f64)> = (0..=40).map(|i| (i as f64 * 5.0, (i as f64 / 8.0).exp())).collect();
        let kept = path(bent.iter().copied()).matches('L').count();
        assert!((3..30).contains(&kept), "{kept}");
    }
}
