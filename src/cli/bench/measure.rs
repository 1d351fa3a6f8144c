//! Rows, rounds and medians.

use crate::cli::numbers::three_digits;
use serde::Serialize;

/// One line of the result: of one round, then the median over rounds.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// What was measured.
    pub what: String,
    /// By which code.
    pub engine: &'static str,
    /// How the engine walked the tree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walk: Option<String>,
    /// Millions of rays a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mrays_per_s: Option<f64>,
    /// Millions of paths a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mpaths_per_s: Option<f64>,
    /// Nanoseconds an item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ns_per_item: Option<f64>,
    /// `cpu`: seconds are CPU time of the one thread; `wall`: seconds on the clock.
    pub clock: &'static str,
    /// Lanes that held work by lanes that could have; `null` where there are no lanes.
    pub lanes_used: Option<f64>,
    /// The same of packets on their way through the tree, in stages that trace rays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walk_lanes_used: Option<f64>,
    /// Rays or other items in a round.
    pub items: u64,
    /// Rays that hit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hits: Option<usize>,
    /// Sum of the ids of the triangles they hit, of rays of a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sum_id: Option<u64>,
    /// Sum of the distances at which they hit, in lengths of their directions, of rays of a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sum_t: Option<f64>,
    /// Rays that the engine answers otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub differ: Option<usize>,
    /// Rounds.
    pub runs: usize,
}

/// Something to measure: each call is one round and gives the same rows in the same order.
pub type Case<'a> = Box<dyn FnMut() -> Vec<Row> + 'a>;

/// Runs every case `runs` times, in turn (so that a machine that slows down slows all cases), and keeps medians.
pub fn interleave(runs: usize, cases: &mut [Case]) -> Vec<Row> {
    let rounds: Vec<Vec<Row>> = (0..runs).map(|_| cases.iter_mut().flat_map(|case| case()).collect()).collect();
    let Some(first) = rounds.first() else { return Vec::new() };
    let row = |(index, row): (usize, &Row)| {
        let median_of = |figure: fn(&Row) -> Option<f64>| {
            median(rounds.iter().filter_map(|round| round.get(index)).filter_map(figure).collect())
        };
        Row {
            mrays_per_s: median_of(|row| row.mrays_per_s),
            mpaths_per_s: median_of(|row| row.mpaths_per_s),
            ns_per_item: median_of(|row| row.ns_per_item),
            runs,
            ..row.clone()
        }
    };
    first.iter().enumerate().map(row).collect()
}

/// The middle value, or the mean of the two in the middle.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n % 2 == 0 => Some(0.5 * (values[middle - 1] + values[middle])),
        _ => Some(values[middle]),
    }
}

/// Columns that tables may take.
pub const MOST_COLUMNS: usize = 100;

/// A figure, or a dash where there is none.
pub fn number(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), three_digits)
}

/// So many rounds, in words.
pub fn rounds(runs: usize) -> String {
    if runs == 1 { "one round".to_owned() } else { format!("medians of {runs} rounds") }
}

/// `used / possible`; `None` if nothing was possible.
pub fn share(used: u64, possible: u64) -> Option<f64> {
    (possible > 0).then(|| used as f64 / possible as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_take_turns_and_medians_are_kept() {
        let log = std::cell::RefCell::new(String::new());
        let case = |name: &'static str, values: [f64; 3]| {
            let (log, mut values) = (&log, values.into_iter());
            Box::new(move || {
                *log.borrow_mut() += name;
                vec![Row { what: name.into(), engine: "packet", ns_per_item: values.next(), ..Row::default() }]
            }) as Case
        };
        let rows = interleave(3, &mut [case("a", [5.0, 1.0, 2.0]), case("b", [0.0, 9.0, 8.0])]);
        assert_eq!(*log.borrow(), "ababab");
        assert_eq!((rows[0].ns_per_item, rows[1].ns_per_item), (Some(2.0), Some(8.0)));
        assert_eq!((rows[0].mrays_per_s, rows[0].runs, rows[1].what.as_str()), (None, 3, "b"));
        assert_eq!(median(vec![1.0, 2.0]), Some(1.5));
        assert_eq!((share(3, 4), share(0, 0)), (Some(0.75), None));
    }
}
