//! Numbers as results show them: few digits to read, nine to compare.

/// A number in `digits` significant digits; with an exponent where it is very large or small.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let places = digits.max(1) - 1;
    // Rounded once: the exponent is that of the rounded number, so that 9.996 in three digits is 10.0.
    let scientific = format!("{value:.places$e}");
    let exponent: i32 = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    match exponent {
        -4..7 => format!("{value:.*}", (places as i32 - exponent).max(0) as usize),
        _ => scientific,
    }
}

/// A number in three significant digits.
pub fn three_digits(value: f64) -> String {
    significant(value, 3)
}

/// A number in `digits` significant digits, without zeros behind the point that say nothing.
pub fn short(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// A share in per cent, in three significant digits.
pub fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share, 3))
}

/// A number in four digits and an exponent of two, as columns of very different sizes line up.
pub fn scientific(value: f64) -> String {
    let text = format!("{value:.3e}");
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    let (sign, exponent) = exponent.strip_prefix('-').map_or(('+', exponent), |exponent| ('-', exponent));
    format!("{digits}e{sign}{exponent:0>2}")
}

/// Nine digits: enough to tell any two f32 values apart.
pub fn nine_digits(value: f64) -> String {
    match value.abs() {
        0.0 => if value.is_sign_negative() { "-0" } else { "0" }.to_owned(),
        magnitude if !magnitude.is_finite() => value.to_string(),
        magnitude if (1e-3..1e6).contains(&magnitude) => {
            let digits = (8 - magnitude.log10().floor() as i32).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.8e}"),
    }
}

/// A count with a comma every three digits.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let first = (digits.len() + 2) % 3 + 1;
    let mut text = digits[..first].to_string();
    for start in (first..digits.len()).step_by(3) {
        text.push(',');
        text += &digits[start..start + 3];
    }
    text
}

/// `1 ray`, `2 rays`.
pub fn counted(n: usize, what: &str) -> String {
    format!("{} {what}{}", count(n as u64), if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_significant_and_rounded_once() {
        let numbers = [0.0, 34.07, 0.55, 9.996, 99_960.0, 12_345_678.0, 0.000_123_4, 0.000_012_34, -2.0, 1091.378];
        let shown = ["0", "34.1", "0.550", "10.0", "99960", "1.23e7", "0.000123", "1.23e-5", "-2.00", "1091"];
        assert_eq!(numbers.map(three_digits), shown);
        assert_eq!([f64::INFINITY, f64::NAN].map(three_digits), ["inf", "NaN"]);
        assert_eq!([0.0312, 0.468, 0.0, 0.4].map(percent), ["3.12 %", "46.8 %", "0 %", "40 %"]);
        assert_eq!(significant(0.26, 1), "0.3");
        assert_eq!([1.0, 17.0, 0.5, 100.0, 1e-9].map(|x| short(x, 3)), ["1", "17", "0.5", "100", "1.00e-9"]);
    }

    #[test]
    fn columns_line_up() {
        let numbers = [0.0, 1.707768e-3, -66.92, 1e12, 1e-120].map(scientific);
        assert_eq!(numbers, ["0.000e+00", "1.708e-03", "-6.692e+01", "1.000e+12", "1.000e-120"]);
        assert_eq!([0, 999, 1000, 1_234_567].map(count), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([1, 2].map(|n| counted(n, "ray")), ["1 ray", "2 rays"]);
        assert_eq!([-0.0, 1e-9, 0.1f32.into()].map(nine_digits), ["-0", "1.00000000e-9", "0.100000001"]);
    }
}
