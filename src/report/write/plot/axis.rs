//! Logarithmic axes: how far they reach, and where labels stand on them.
//!
//! A labelled tick stands at or beyond either end of the data, so that the best and the worst result can be read off. Between
//! the ends as many labels of one series of round numbers (1-2-5 over decades, finer below one) stand as fit without
//! touching.

use crate::report::write::plot::numbers::number;

/// Room that an axis has beyond its outermost ticks.
const PAD: f64 = 10.0;
/// Least distance of ticks without a label.
const MINOR_STEP: f64 = 4.0;
/// Data that spread less than by this factor are shown as if they did: an axis that magnifies more shows nothing but noise.
const LEAST_SPREAD: f64 = 1.2;
/// Steps within a decade, dense to sparse, for axes shorter than one.
const FINE: [&[f64]; 3] =
    [&[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0], &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0], &USUAL];
const USUAL: [f64; 3] = [1.0, 2.0, 5.0];
/// Steps at which an axis over decades may end.
const ENDS: [f64; 5] = [1.0, 2.0, 3.0, 5.0, 7.0];
/// Most labels of an axis shorter than a decade.
const MOST_LABELS: usize = 18;

/// How values become labels, and how much room along the axis a label takes, its distance from the next included.
#[derive(Clone, Copy)]
pub(super) struct Labels {
    /// The text of a value.
    pub text: fn(f64) -> String,
    /// The extent of a text along the axis.
    pub extent: fn(&str) -> f64,
}

/// Where values stand, in units of the drawing: from `start` to `end`, `start` being the lower value.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Decadic logarithm of the value at `start`.
    low: f64,
    /// Decadic logarithm of the value at `end`.
    high: f64,
    /// Where the drawing begins.
    pub start: f64,
    /// Where it ends.
    pub end: f64,
    /// Values with a label, ascending, and the label.
    pub labelled: Vec<(f64, String)>,
    /// Values with a short tick.
    pub minor: Vec<f64>,
}

/// The smallest and the largest of the positive finite values.
pub(super) fn hull(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let usable = values.filter(|v| *v > 0.0 && v.is_finite());
    usable.fold(None, |hull, v| hull.map_or(Some((v, v)), |(low, high): (f64, f64)| Some((low.min(v), high.max(v)))))
}

impl Axis {
    /// An axis whose labels reach all of `data`, and which holds `more` as well.
    pub fn around(data: Option<(f64, f64)>, more: Option<(f64, f64)>, start: f64, end: f64, labels: Labels) -> Axis {
        let (mut low, mut high) = data.unwrap_or((1.0, 10.0));
        if high / low < LEAST_SPREAD {
            let widen = (LEAST_SPREAD / (high / low)).sqrt();
            (low, high) = (low / widen, high * widen);
        }
        let (from, to) = more.unwrap_or((low, high));
        let of = |ticks: &[f64]| {
            let (first, last) = (ticks[0].min(from), ticks[ticks.len() - 1].max(to));
            let scale = (last.log10() - first.log10()) / ((end - start).abs() - 2.0 * PAD);
            Axis::empty(first.log10() - PAD * scale, last.log10() + PAD * scale, start, end)
        };
        let mut best: Option<Axis> = None;
        for ticks in candidates(low, high).iter().map(|ladder| covering(ladder, low, high)).filter(|t| t.len() > 1) {
            let axis = of(&ticks).with_labels(&ticks, labels);
            let fuller = best.as_ref().is_none_or(|best| axis.labelled.len() > best.labelled.len());
            if fuller && axis.labelled.len() <= MOST_LABELS && axis.labels_fit(labels) {
                best = Some(axis);
            }
        }
        let sparse = || {
            let ticks = covering(&Ladder::Decades(&USUAL), low, high);
            of(&ticks).with_sparse_labels(&ticks, labels)
        };
        best.unwrap_or_else(sparse).with_minor_ticks()
    }

    /// An axis from `low` to `high` and no further.
    pub fn within((low, high): (f64, f64), start: f64, end: f64, labels: Labels) -> Axis {
        let empty = Axis::empty(low.log10(), high.log10(), start, end);
        let mut best = empty.clone().with_sparse_labels(&[], labels);
        for ladder in candidates(low, high) {
            let mut ticks = covering(&ladder, low, high);
            ticks.retain(|tick| (low..=high).contains(tick));
            let axis = empty.clone().with_labels(&ticks, labels);
            let count = axis.labelled.len();
            if count > best.labelled.len() && count <= MOST_LABELS && axis.labels_fit(labels) {
                best = axis;
            }
        }
        best.with_minor_ticks()
    }

    fn empty(low: f64, high: f64, start: f64, end: f64) -> Axis {
        Axis { low, high, start, end, labelled: Vec::new(), minor: Vec::new() }
    }

    /// Where `value` stands; what lies far outside stands far outside, but not infinitely far.
    pub fn position(&self, value: f64) -> f64 {
        let share = (value.max(0.0).log10() - self.low) / (self.high - self.low);
        self.start + share.clamp(-50.0, 50.0) * (self.end - self.start)
    }

    /// Whether `value` lies inside.
    pub fn holds(&self, value: f64) -> bool {
        value > 0.0 && (self.low - 1e-9..=self.high + 1e-9).contains(&value.log10())
    }

    fn with_labels(mut self, ticks: &[f64], labels: Labels) -> Axis {
        self.labelled = ticks.iter().map(|&tick| (tick, (labels.text)(tick))).collect();
        self
    }

    /// Whether labels at `a` and `b` keep apart.
    fn apart(&self, a: &(f64, String), b: &(f64, String), labels: Labels) -> bool {
        let room = ((labels.extent)(&a.1) + (labels.extent)(&b.1)) / 2.0;
        (self.position(a.0) - self.position(b.0)).abs() >= room
    }

    fn labels_fit(&self, labels: Labels) -> bool {
        self.labelled.windows(2).all(|pair| self.apart(&pair[0], &pair[1], labels))
    }

    /// Labels at the outermost of `ends`, and between them at whole decades, and at 2 and 5 or at least at 3 in each, if
    /// those have room.
    fn with_sparse_labels(self, ends: &[f64], labels: Labels) -> Axis {
        let outermost: &[f64] = if ends.is_empty() { &[] } else { &[ends[0], ends[ends.len() - 1]] };
        let mut axis = self.with_labels(outermost, labels);
        let (first, last) = (10f64.powf(axis.low), 10f64.powf(axis.high));
        let inside = |steps: &[f64]| {
            let mut ticks = covering(&Ladder::Decades(steps), first, last);
            ticks.retain(|tick| axis.holds(*tick));
            ticks
        };
        let decades = inside(&[1.0]);
        // Whole classes of numbers, so that the spacing stays even: if the members of one touch each other none is taken.
        let every = [1, 2, 3, 5, 10, 20, 50, 100].into_iter().map(|step| {
            let mut some = decades.clone();
            some.retain(|tick| (tick.log10().round() as i32).rem_euclid(step) == 0);
            (step, some)
        });
        let fits = |ticks: &[f64]| axis.clone().with_labels(ticks, labels).labels_fit(labels);
        let Some((step, decades)) = every.into_iter().find(|(_, some)| fits(some)) else { return axis };
        let finer = [&USUAL[..], &[1.0, 3.0]].into_iter().map(inside).find(|ticks| step == 1 && fits(ticks));
        for tick in decades.iter().chain(finer.iter().flatten()) {
            let new = (*tick, (labels.text)(*tick));
            if axis.labelled.iter().all(|old| axis.apart(old, &new, labels)) {
                axis.labelled.push(new);
            }
        }
        axis.labelled.sort_by(|a, b| a.0.total_cmp(&b.0));
        axis
    }

    fn with_minor_ticks(mut self) -> Axis {
        let nines = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        let unit = (self.end - self.start).abs() / (self.high - self.low);
        let steps = if unit * (10f64 / 9.0).log10() >= MINOR_STEP { &nines[..] } else { &nines[..1] };
        let mut minor = covering(&Ladder::Decades(steps), 10f64.powf(self.low), 10f64.powf(self.high));
        let labelled = |tick: f64| self.labelled.iter().any(|(value, _)| (value / tick - 1.0).abs() < 1e-9);
        minor.retain(|tick| self.holds(*tick) && !labelled(*tick) && unit >= MINOR_STEP);
        self.minor = minor;
        self
    }
}

/// A series of round numbers.
enum Ladder<'a> {
    /// These in every decade.
    Decades(&'a [f64]),
    /// The usual ones in every decade, and ends of [`ENDS`].
    CloseEnds,
    /// All multiples.
    Multiples(f64),
}

/// Series for values from `low` to `high`, finer than usual where they spread over less than a decade.
fn candidates(low: f64, high: f64) -> Vec<Ladder<'static>> {
    if high / low >= 10.0 {
        // Where both fit they have as many labels, and the first leaves less of the axis empty.
        return vec![Ladder::CloseEnds, Ladder::Decades(&USUAL)];
    }
    let exponent = high.log10().floor() as i32;
    let steps = (exponent - 2..=exponent).flat_map(|e| USUAL.map(|step| Ladder::Multiples(step * 10f64.powi(e))));
    steps.chain(FINE.map(Ladder::Decades)).collect()
}

/// The numbers of `ladder` from the last at or below `low` to the first at or above `high`; none if they would start at 0.
fn covering(ladder: &Ladder, low: f64, high: f64) -> Vec<f64> {
    let (low, high) = (low * (1.0 + 1e-9), high * (1.0 - 1e-9));
    match ladder {
        Ladder::Multiples(step) => {
            let (first, last) = ((low / step).floor(), (high / step).ceil());
            if first < 1.0 { Vec::new() } else { (first as i64..=last as i64).map(|i| i as f64 * step).collect() }
        }
        Ladder::CloseEnds => {
            let ends = covering(&Ladder::Decades(&ENDS), low, high);
            let (first, last) = (ends[0], ends[ends.len() - 1]);
            let mut all = covering(&Ladder::Decades(&USUAL), low, high);
            all.retain(|tick| first < *tick && *tick < last);
            [vec![first], all, vec![last]].concat()
        }
        Ladder::Decades(steps) => {
            let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
            let all: Vec<f64> = decades.flat_map(|e| steps.iter().map(move |step| step * 10f64.powi(e))).collect();
            let first = all.iter().rposition(|tick| *tick <= low).unwrap_or(0);
            let last = all.iter().position(|tick| *tick >= high).unwrap_or(all.len() - 1);
            all[first.min(last)..=last.max(first)].to_vec()
        }
    }
}

/// A value as it is.
pub(super) fn plain(value: f64) -> String {
    number(value)
}

/// A share in per cent.
pub(super) fn per_cent(value: f64) -> String {
    format!("{}\u{a0}%", number(100.0 * value))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACROSS: Labels = Labels { text: plain, extent: |text| 8.0 * text.len() as f64 + 8.0 };
    const UPWARDS: Labels = Labels { text: per_cent, extent: |_| 18.0 };

    fn values(axis: &Axis) -> Vec<f64> {
        axis.labelled.iter().map(|tick| tick.0).collect()
    }

    #[test]
    fn labels_reach_both_ends_and_never_touch() {
        let mut ranges = Vec::new();
        for decade in [-9, -1, 0, 5] {
            for mantissa in [1.0, 1.07, 2.0, 3.3, 4.99, 9.99] {
                for spread in [1.0, 1.01, 1.1, 1.3, 1.9, 3.0, 4.8, 9.0, 10.0, 14.0, 40.0, 300.0, 1e4, 1e7, 1e13] {
                    let low = mantissa * 10f64.powi(decade);
                    ranges.push((low, low * spread));
                }
            }
        }
        for (low, high) in ranges {
            for length in [150.0, 200.0, 400.0, 650.0] {
                for labels in [ACROSS, UPWARDS] {
                    let axis = Axis::around(Some((low, high)), None, 0.0, length, labels);
                    let all = values(&axis);
                    let case = format!("{low} to {high} on {length}: {:?}", axis.labelled);
                    assert!(all.len() >= 2 && all.is_sorted(), "{case}");
                    assert!(all[0] <= low * 1.000001 && all[all.len() - 1] >= high * 0.999999, "{case}");
                    // Where the ends are all that is labelled they may be as close as they like.
                    assert!(all.len() == 2 || axis.labels_fit(labels), "{case}");
                    assert!(axis.position(low) > 0.0 && axis.position(high) < length, "{case}");
                    assert!(all.len() <= 40 && axis.minor.len() < 150, "{case}");
                    let texts: std::collections::HashSet<&String> = axis.labelled.iter().map(|tick| &tick.1).collect();
                    assert_eq!(texts.len(), all.len(), "{case}");
                }
            }
        }
    }

    #[test]
    fn labels_are_as_dense_as_they_fit() {
        let labels =
            |low: f64, high: f64, length: f64| values(&Axis::around(Some((low, high)), None, 0.0, length, ACROSS));
        assert_eq!(labels(1.0, 256.0, 500.0), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 300.0]);
        let texts: Vec<String> = labels(0.0099, 0.28, 500.0).into_iter().map(number).collect();
        assert_eq!(texts, ["0.007", "0.01", "0.02", "0.05", "0.1", "0.2", "0.3"]);
        assert_eq!(labels(1.0, 200.0, 150.0), [1.0, 10.0, 200.0], "the ends come before the decades");
        assert_eq!(labels(1.0, 100.0, 150.0), [1.0, 3.0, 10.0, 30.0, 100.0]);
        assert_eq!(labels(1.0, 1e6, 240.0), [1.0, 100.0, 1e4, 1e6], "evenly every second decade");
        let narrow = labels(0.15, 0.167, 500.0);
        assert!(narrow.len() >= 6, "{narrow:?}");
        let percents = Axis::around(Some((0.149, 1.22)), None, 500.0, 0.0, UPWARDS);
        assert!(percents.labelled[0].0 <= 0.149 && percents.labelled[0].0 >= 0.1, "{percents:?}");
    }

    #[test]
    fn limits_are_kept_and_labelled_inside() {
        let axis = Axis::within((750.0, 3540.0), 500.0, 0.0, Labels { text: plain, ..UPWARDS });
        assert!((axis.position(750.0) - 500.0).abs() < 1e-9 && axis.position(3540.0).abs() < 1e-9);
        let all = values(&axis);
        assert!(all.len() >= 8 && all.iter().all(|v| (750.0..=3540.0).contains(v)), "{all:?}");
        assert!(axis.holds(750.0) && axis.holds(3540.0) && !axis.holds(749.0) && !axis.holds(0.0) && !axis.holds(-1.0));
        // Five per cent are seen.
        assert!(axis.position(2850.0) - axis.position(3000.0) > 14.0);
        let wide = Axis::within((1.0, 1e9), 0.0, 300.0, ACROSS);
        assert!(wide.labelled.len() >= 3 && wide.labels_fit(ACROSS), "{wide:?}");
    }

    #[test]
    fn no_data_still_make_an_axis_and_nothing_is_infinite() {
        let axis = Axis::around(None, None, 0.0, 400.0, ACROSS);
        assert!(values(&axis).len() > 1);
        assert!([0.0, -1.0, f64::INFINITY, 1e300].map(|v| axis.position(v)).iter().all(|p| p.is_finite()));
        assert_eq!(hull([f64::NAN, 0.0, -1.0, 3.0, f64::INFINITY, 2.0].into_iter()), Some((2.0, 3.0)));
        assert_eq!(hull([0.0].into_iter()), None);
    }

    #[test]
    fn intervals_widen_an_axis_without_moving_its_last_labels_off_it() {
        let axis = Axis::around(Some((2.0, 50.0)), Some((1.1, 90.0)), 0.0, 400.0, ACROSS);
        assert!(axis.holds(1.1) && axis.holds(90.0) && !axis.holds(0.5));
        assert!(values(&axis).iter().all(|tick| axis.holds(*tick)));
    }
}
