//! Numbers as people write them: few digits, one minus sign, units.

use crate::report::analysis::statistics::Interval;
use crate::report::write::plot::raised;

/// A value with `digits` significant digits; very large and very small ones as a power of ten.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return minus(format!("{value}"));
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..7).contains(&magnitude) {
        let text = format!("{value:.*e}", (digits - 1).max(0) as usize);
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        // Rust writes exponents that always parse.
        return minus(format!("{digits} × 10{}", raised(power.parse().unwrap_or(0))));
    }
    // Rounded once at the wanted digit, so that 9.96 with two digits is 10 and not 10.0.
    let unit = 10f64.powi(magnitude + 1 - digits);
    let rounded = (value / unit).round() * unit;
    let magnitude = rounded.abs().log10().floor() as i32;
    minus(format!("{rounded:.*}", (digits - 1 - magnitude).max(0) as usize))
}

/// With the sign that is one.
pub fn minus(text: String) -> String {
    text.replace('-', "−")
}

/// An exponent with two digits behind the point; never "−0.00".
pub fn exponent(value: f64) -> String {
    minus(format!("{:.2}", (value * 100.0).round() / 100.0 + 0.0))
}

/// A share in per cent.
pub fn percent(share: f64) -> String {
    format!("{}\u{a0}%", significant(100.0 * share, if share.abs() < 0.1 { 2 } else { 3 }))
}

/// A difference in per cent, with its sign; two digits behind the point at most.
pub fn signed_percent(share: f64) -> String {
    if !share.is_finite() {
        return "–".to_owned();
    }
    let size = 100.0 * share.abs();
    let text = if size < 0.995 { format!("{size:.2}") } else { significant(size, 3) };
    let sign = match share {
        _ if text == "0.00" => "",
        share if share < 0.0 => "−",
        _ => "+",
    };
    format!("{sign}{text}\u{a0}%")
}

/// A score: standard errors, one digit behind the point while it is small.
pub fn score(z: f64) -> String {
    if z.is_infinite() {
        return if z > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    let text = if z.abs() < 99.95 { format!("{:.1}", z + 0.0) } else { format!("{z:.0}") };
    minus(if text == "-0.0" { "0.0".to_owned() } else { text })
}

/// An error that was asked for, in per cent, without zeros behind the point.
pub fn target(error: f64) -> String {
    format!("{}\u{a0}%", (error * 1e6).round() / 1e4)
}

/// The unit in which a person would tell so many seconds, and its seconds.
fn unit_of_time(seconds: f64) -> (f64, &'static str) {
    match seconds {
        v if v < 0.001 => (1e-6, "µs"),
        v if v < 0.1 => (1e-3, "ms"),
        v if v < 180.0 => (1.0, "s"),
        v if v < 10_800.0 => (60.0, "min"),
        v if v < 259_200.0 => (3600.0, "h"),
        _ => (86_400.0, "days"),
    }
}

/// Seconds in the unit a person would use.
pub fn seconds(value: f64) -> String {
    let (unit, name) = unit_of_time(value);
    format!("{}\u{a0}{name}", significant(value / unit, 2))
}

/// The digits of `value` that are worth telling where it is known within `interval`: down to a third of the interval's width,
/// at least two, at most five.
fn worth(interval: Interval, value: f64) -> i32 {
    let width = (interval.high - interval.low).abs();
    let magnitude = |of: f64| of.abs().log10().floor();
    let digits = if width > 0.0 { magnitude(value) - magnitude(width / 3.0) + 1.0 } else { 5.0 };
    digits.clamp(2.0, 5.0) as i32
}

/// A value with so many digits behind the point; fewer than none: rounded to a power of ten.
fn at_places(value: f64, places: i32) -> String {
    let unit = 10f64.powi(-places);
    let rounded = if places < 0 { (value / unit).round() * unit } else { value };
    minus(format!("{:.*}", places.max(0) as usize, rounded + 0.0))
}

/// A value and the ends of its interval, with the digits that this interval is worth: all three end at the same decimal place.
pub fn known(value: f64, interval: Option<Interval>) -> (String, Option<String>) {
    let Some(interval) = interval else { return (significant(value, 3), None) };
    let magnitude = |of: f64| of.abs().log10().floor() as i32;
    let digits = worth(interval, value);
    let plain = |of: f64| of != 0.0 && of.is_finite() && (-5..7).contains(&magnitude(of));
    let text = |of: f64| match plain(value) && (of == 0.0 || plain(of)) {
        true => at_places(of, digits - 1 - magnitude(value)),
        false => significant(of, digits),
    };
    (text(value), Some(format!("{} to {}", text(interval.low), text(interval.high))))
}

/// A share and its interval in per cent, with the digits that this interval is worth.
pub fn known_percent(share: f64, interval: Option<Interval>) -> (String, Option<String>) {
    let (value, range) = known(100.0 * share, interval.map(|interval| interval.map(|end| 100.0 * end)));
    (format!("{value}\u{a0}%"), range.map(|range| format!("{range}\u{a0}%")))
}

/// Seconds and their interval in one unit, with the digits that this interval is worth.
pub fn known_seconds(value: f64, interval: Option<Interval>) -> (String, Option<String>) {
    let (unit, name) = unit_of_time(value);
    match interval {
        Some(_) => {
            let (value, range) = known(value / unit, interval.map(|interval| interval.map(|end| end / unit)));
            (format!("{value}\u{a0}{name}"), range.map(|range| format!("{range}\u{a0}{name}")))
        }
        None => (seconds(value), None),
    }
}

/// An exponent and its interval, two digits behind the point or as many more as tell the ends apart.
pub fn known_exponent(value: f64, interval: Option<Interval>) -> (String, Option<String>) {
    let width = interval.map_or(1.0, |interval| interval.high - interval.low);
    let places = if width < 0.015 { 3 } else { 2 };
    let text = |end: f64| minus(format!("{:.places$}", end + 0.0));
    (text(value), interval.map(|interval| format!("{} to {}", text(interval.low), text(interval.high))))
}

/// "1 sample", "4 samples".
pub fn count(number: u64, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_people_write_them() {
        assert_eq!(
            [1.234, 9.96, 123.4, 0.01234, -5.67].map(|v| significant(v, 2)),
            ["1.2", "10", "120", "0.012", "−5.7"]
        );
        assert_eq!([-0.001, -1.0, 0.5].map(exponent), ["0.00", "−1.00", "0.50"]);
        assert_eq!(
            [0.0, 1e9, 3.0e-7, -4e12].map(|v| significant(v, 2)),
            ["0", "1.0 × 10⁹", "3.0 × 10⁻⁷", "−4.0 × 10¹²"]
        );
        assert_eq!([0.0213, 0.3335, 1.5].map(percent), ["2.1\u{a0}%", "33.4\u{a0}%", "150\u{a0}%"]);
        assert_eq!(
            [0.0213, -0.3335, -0.00004, 0.0031].map(signed_percent),
            ["+2.13\u{a0}%", "−33.4\u{a0}%", "0.00\u{a0}%", "+0.31\u{a0}%"]
        );
        assert_eq!([-0.04, 0.0, -1.25, 1170.4].map(score), ["0.0", "0.0", "−1.2", "1170"]);
        assert_eq!(
            [0.00021, 0.021, 0.5, 61.0, 300.0, 20000.0, 1e6].map(|v| seconds(v).replace('\u{a0}', " ")),
            ["210 µs", "21 ms", "0.50 s", "61 s", "5.0 min", "5.6 h", "12 days"]
        );
        assert_eq!([0.1, 0.05, 0.005].map(target), ["10\u{a0}%", "5\u{a0}%", "0.5\u{a0}%"]);
        let around = |value: f64, half: f64| (value, Some(Interval::around(value, half)));
        let pair =
            |(value, range): (String, Option<String>)| [value, range.unwrap()].join(" / ").replace('\u{a0}', " ");
        let texts =
            [(84.96, 0.4), (1017.0, 14.0), (0.5, 0.4)].map(|(v, half)| around(v, half)).map(|(v, i)| pair(known(v, i)));
        assert_eq!(texts, ["85.0 / 84.6 to 85.4", "1017 / 1003 to 1031", "0.50 / 0.10 to 0.90"]);
        let wide = [(5.2, 1.04, 27.0), (1234.0, 900.0, 5600.0), (1e9, 5e8, 2e9)];
        let texts = wide.map(|(value, low, high)| pair(known(value, Some(Interval { low, high }))));
        let expected = ["5.2 / 1.0 to 27.0", "1200 / 900 to 5600", "1.0 × 10⁹ / 5.0 × 10⁸ to 2.0 × 10⁹"];
        assert_eq!(texts, expected);
        assert_eq!([f64::INFINITY, f64::NEG_INFINITY].map(score), ["∞", "−∞"]);
        assert_eq!([f64::NAN, f64::INFINITY].map(signed_percent), ["–", "–"]);
        let (value, interval) = around(0.0634, 0.0002);
        assert_eq!(pair(known_percent(value, interval)), "6.34 % / 6.32 to 6.36 %");
        let (value, interval) = around(300.0, 30.0);
        assert_eq!(pair(known_seconds(value, interval)), "5.0 min / 4.5 to 5.5 min");
        let (value, interval) = around(-0.5, 0.02);
        assert_eq!(pair(known_exponent(value, interval)), "−0.50 / −0.52 to −0.48");
        let (value, interval) = around(-0.5, 0.002);
        assert_eq!(pair(known_exponent(value, interval)), "−0.500 / −0.502 to −0.498");
        assert_eq!([known(4.444, None), known_seconds(4.444, None)].map(|(text, _)| text), ["4.44", "4.4\u{a0}s"]);
        assert_eq!([1, 0, 4].map(|n| count(n, "sample")), ["1 sample", "0 samples", "4 samples"]);
    }
}
