//! Numbers as axes show them.

/// Up to four digits without needless zeros, thousands apart; powers of ten with raised exponents where many zeros would
/// stand otherwise; the minus sign is U+2212.
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { format!("{value}") };
    }
    let sign = if value < 0.0 { "\u{2212}" } else { "" };
    // Rust writes the shortest exponent, which always parses.
    let text = format!("{:.3e}", value.abs());
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let rounded: f64 = text.parse().unwrap_or(value.abs());
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    let digits = mantissa.len().saturating_sub(1).max(1) as i32;
    match (exponent, mantissa) {
        (-4..6, _) => {
            let plain = format!("{:.*}", (digits - 1 - exponent).max(0) as usize, rounded);
            format!("{sign}{}", with_thousands(&plain))
        }
        (_, "1") => format!("{sign}10{}", raised(exponent)),
        _ => format!("{sign}{mantissa}\u{a0}×\u{a0}10{}", raised(exponent)),
    }
}

/// Commas between thousands, from 10,000 on.
fn with_thousands(digits: &str) -> String {
    let whole = digits.find('.').unwrap_or(digits.len());
    match whole {
        0..5 => digits.to_owned(),
        _ => format!("{},{}", &digits[..whole - 3], &digits[whole - 3..]),
    }
}

/// An integer as an exponent.
pub fn raised(exponent: i32) -> String {
    let raise = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    exponent.to_string().chars().map(raise).collect()
}

/// How wide `text` is, in units of a font of size 13, in the widest of the usual faces (DejaVu Sans).
pub(super) fn width(text: &str) -> f64 {
    let advance = |c: char| match c {
        '.' | ',' | ' ' | '\u{a0}' | 'i' | 'l' | 'j' => 4.3,
        '⁰'..='⁹' | '¹' | '²' | '³' | '⁻' | 'f' | 't' | 'r' | '-' | '(' | ')' => 5.4,
        '%' | 'm' | 'w' | 'M' | 'W' => 12.5,
        '×' | '−' => 10.9,
        _ => 8.3,
    };
    text.chars().map(advance).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exponents_raised() {
        let plain = [0.01, 0.002, 100.0, 1500.0, 20000.0, 0.30000000000000004, 1.25, 0.0001, 999999.0, 12345.6];
        let texts = ["0.01", "0.002", "100", "1500", "20,000", "0.3", "1.25", "0.0001", "10⁶", "12,350"];
        assert_eq!(plain.map(number), texts);
        assert_eq!(
            [1e7, 2e-5, 1e-10, -2e6, -0.5].map(number),
            ["10⁷", "2\u{a0}×\u{a0}10⁻⁵", "10⁻¹⁰", "−2\u{a0}×\u{a0}10⁶", "−0.5"]
        );
        assert_eq!([0.0, -0.0].map(number), ["0", "0"]);
        assert_eq!([-12, 0, 345].map(raised), ["⁻¹²", "⁰", "³⁴⁵"]);
        for exponent in -20..20 {
            for mantissa in [1.0, 1.2, 2.5, 9.999] {
                let text = number(mantissa * 10f64.powi(exponent));
                assert!(!text.contains(['e', '-']) && text.len() < 25, "{text}");
            }
        }
    }

    #[test]
    fn widths_grow_with_the_text() {
        assert!(width("0.001") > width("0.1") && width("10⁻⁵") < width("0.00001") && width("") == 0.0);
    }
}
