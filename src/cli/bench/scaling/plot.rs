//! The rows as a plot: every sweep one line, relative to its smallest size, so that slopes are exponents of growth and what
//! costs nothing is level.

use crate::cli::bench::scaling::sweep::{Row, Swept, overall};
use crate::cli::numbers::count;
use crate::report::write::numbers::exponent;
use crate::report::write::plot::{Mark, Plot, Series, Values};
use crate::simd::simd_level;

/// The plot of all sweeps; `scene` is the one given.
pub fn plot(scene: &str, rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for what in Swept::ALL {
        let rows: Vec<Row> = rows.iter().filter(|row| row.what == what).cloned().collect();
        let [first, .., last] = rows.as_slice() else { continue };
        let range = format!("{} {} to {}", what.name(), count(first.size), count(last.size));
        let note = overall(&rows).map(exponent).unwrap_or_default();
        series.push(of(
            &rows,
            |row| row.ns_per_path,
            Series { label: range, note, style: style(what), ..Series::default() },
        ));
        if what == Swept::Threads {
            let label = "threads, wall time".to_owned();
            series.push(of(&rows, |row| row.wall_s, Series { label, style: WALL, ..Series::default() }));
        }
    }
    let values = || series.iter().flat_map(|series| &series.marks).map(|mark| mark.y);
    let range = (0.9 * values().fold(Y_RANGE.0, f64::min), 1.1 * values().fold(Y_RANGE.1, f64::max));
    let proportion = vec![(1.0, 1.0), (range.1, range.1)];
    series.push(Series { extrapolated: proportion, style: PROPORTION, ..Series::default() });
    Plot {
        title: "Growth of the time of a path".to_owned(),
        heading: format!("Growth of the time of a path: {scene}, {}", simd_level()),
        x_label: "size, in multiples of the smallest of its sweep".to_owned(),
        y_label: "CPU time of a path, in multiples of that at the smallest size; dotted: growth in proportion; \
                  behind names: exponents of growth"
            .to_owned(),
        series,
        y_values: Values::Plain,
        y_range: Some(range),
    }
}

/// The values that the y axis holds at least: about as many decades a unit as the x axis of whole sweeps, so that slopes look as
/// steep as they are.
const Y_RANGE: (f64, f64) = (0.5, 8.0);

/// Styles that are told apart at a glance.
fn style(what: Swept) -> usize {
    match what {
        Swept::Triangles => 1,
        Swept::Lights => 3,
        Swept::Bounces => 7,
        Swept::Pixels => 0,
        Swept::Threads => 5,
    }
}
const WALL: usize = 9;
const PROPORTION: usize = 4;

/// `blank` with a mark for each of `rows`, relative to the first.
fn of(rows: &[Row], figure: fn(&Row) -> f64, blank: Series) -> Series {
    let mark = |row: &Row| Mark {
        x: row.size as f64 / rows[0].size as f64,
        y: figure(row) / figure(&rows[0]),
        interval: None,
    };
    let marks: Vec<Mark> = rows.iter().map(mark).collect();
    Series { line: marks.iter().map(|mark| (mark.x, mark.y)).collect(), marks, ..blank }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::bench::scaling::sweep::tests::rows;
    use crate::report::write::plot::Layout;

    #[test]
    fn every_sweep_is_a_line_that_begins_at_one() {
        let all: Vec<Row> =
            Swept::ALL.iter().flat_map(|what| rows(*what, &[(2, 100.0), (20, 150.0), (200, 200.0)])).collect();
        let plot = plot("builtin:heavy", &all);
        let (proportion, sweeps) = plot.series.split_last().unwrap();
        assert_eq!((sweeps.len(), proportion.marks.len()), (Swept::ALL.len() + 1, 0));
        for series in sweeps {
            assert_eq!((series.marks.len(), series.marks[0].x, series.marks[0].y), (3, 1.0, 1.0), "{}", series.label);
            assert_eq!(series.marks[2].x, 100.0);
        }
        assert_eq!((&plot.series[0].label[..], &plot.series[0].note[..]), ("triangles 2 to 200", "0.15"));
        let text = plot.svg(Layout::FILE).into_string();
        assert!(Swept::ALL.iter().all(|what| text.contains(what.name())) && !text.contains("NaN"));
        assert!(plot.outside().is_empty());
        assert_eq!(super::plot("x", &[]).series.len(), 1);
    }
}
