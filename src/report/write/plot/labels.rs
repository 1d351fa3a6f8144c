//! Names: at the ends of lines, or once for many plots.

use crate::report::write::plot::numbers::width;
use crate::report::write::plot::series::Series;
use crate::report::write::plot::styles::{Style, at, color, path};
use maud::{Markup, html};

/// Least distance of two names.
const LABEL_STEP: f64 = 18.0;
/// Left of a name: its lead and its marker.
const BEFORE: f64 = 36.0;
const AFTER: f64 = 4.0;

/// A name at the end of a line.
pub(super) struct Name<'a> {
    /// Whose.
    pub series: &'a Series,
    /// Where its last mark stands.
    pub end: (f64, f64),
}

/// How wide a name and its note are.
fn extent(label: &str, note: &str) -> f64 {
    width(label) + if note.is_empty() { 0.0 } else { width(" ") + width(note) }
}

/// The room that the names of `series` take, at least 0.7 of `most`, so that plots above each other end alike, and at most
/// `most`.
pub(super) fn room<'a>(series: impl Iterator<Item = &'a Series>, most: f64) -> f64 {
    let widest = series.map(|series| extent(&series.label, &series.note)).fold(0.0, f64::max);
    (BEFORE + widest + AFTER).clamp(0.7 * most, most)
}

/// What fits into `room` of a name and its note: the note goes first, then the end of the name.
fn fitting(label: &str, note: &str, room: f64) -> (String, String) {
    // Sums in another order differ in their last bits.
    let room = room + 1e-6;
    if extent(label, note) <= room {
        return (label.to_owned(), note.to_owned());
    }
    let mut short: Vec<char> = label.chars().collect();
    if width(label) <= room {
        return (label.to_owned(), String::new());
    }
    while short.len() > 1 && short.iter().map(|c| width(&c.to_string())).sum::<f64>() + width("…") > room {
        short.pop();
    }
    (short.into_iter().collect::<String>() + "…", String::new())
}

/// Names right of `right`, pushed apart where they would touch, each with its marker and a line to its end.
pub(super) fn at_ends(mut names: Vec<Name>, right: f64, room: f64, top: f64, bottom: f64) -> Markup {
    names.sort_by(|a, b| a.end.1.total_cmp(&b.end.1));
    let places = spread(&names.iter().map(|name| name.end.1).collect::<Vec<_>>(), top, bottom);
    html! {
        @for (Name { series, end: (px, py) }, place) in names.into_iter().zip(places) {
            @let style = Style::of(series.style);
            @let (label, note) = fitting(&series.label, &series.note, room - BEFORE - AFTER);
            path class="lead" d=(path([(px + style.reach + 2.0, py), (right + 10.0, place)].into_iter())) {}
            g style=(color(series.style)) { (style.marker(right + 21.0, place, 1.0)) }
            text x=(at(right + BEFORE)) y=(at(place)) dy="4" {
                @if label != series.label { title { (series.label) " " (series.note) } }
                (label)
                @if !note.is_empty() { " " tspan class="soft" { (note) } }
            }
        }
    }
}

/// Names with their lines and markers in a row, once for several plots: (name, style).
pub fn legend(series: &[(&str, usize)]) -> Markup {
    html! {
        ul class="legend" {
            @for (name, style) in series {
                li {
                    svg class="plot key" viewBox="0 0 44 16" width="44" height="16" aria-hidden="true" style=(color(*style)) {
                        (Style::of(*style).line("M1 8H43"))
                        (Style::of(*style).marker(22.0, 8.0, 1.0))
                    }
                    (name)
                }
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
    fn long_names_lose_their_note_and_then_their_end() {
        let whole = |room: f64| fitting("mis-power tree sobol", "−0.57", room);
        assert_eq!(whole(400.0), ("mis-power tree sobol".into(), "−0.57".into()));
        assert_eq!(whole(width("mis-power tree sobol") + 5.0), ("mis-power tree sobol".into(), String::new()));
        let (short, note) = whole(100.0);
        assert!(short.starts_with("mis-power") && short.ends_with('…') && note.is_empty());
        assert!(width(&short) <= 100.0);
        assert_eq!(fitting("abc", "", 0.0).0, "a…");
    }

    #[test]
    fn room_follows_the_names() {
        let named = |label: &str| Series { label: label.into(), ..Series::default() };
        let all = [named("nee"), named("mis-one-sample")];
        assert!(room(all.iter(), 200.0) > room(all[..1].iter(), 200.0));
        assert_eq!([room(all.iter(), 60.0), room(all[..1].iter(), 400.0)], [60.0, 280.0]);
        // The widest name has just the room it needs.
        let names = all.map(|series| series.label);
        let most = room([named(&names[1])].iter(), 200.0);
        assert_eq!(fitting(&names[1], "", most - BEFORE - AFTER).0, names[1]);
    }

    #[test]
    fn the_legend_shows_every_name_with_its_marker() {
        let text = legend(&[("nee", 5), ("a <b>", 16)]).into_string();
        let tree = roxmltree::Document::parse(&text).unwrap();
        let count = |tag: &str| tree.descendants().filter(|node| node.has_tag_name(tag)).count();
        assert_eq!((count("li"), count("svg"), count("path")), (2, 2, 4));
        assert!(text.contains("a &lt;b&gt;") && text.contains("--c:var(--s16)"));
    }
}
