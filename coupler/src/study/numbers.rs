//! Numbers as pages, figures and the terminal show them.

/// Four digits, with a power of ten where that is shorter.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string().replace("inf", "∞");
    }
    let size = value.abs().log10().floor() as i32;
    if (-3..6).contains(&size) {
        let text = format!("{value:.*}", usize::try_from(3 - size).unwrap_or(0));
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        return text.replace('-', "−");
    }
    let text = format!("{value:.3e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    let power: String = power.chars().map(superscript).collect();
    format!("{digits}·10{power}").replace('-', "−")
}

/// An error in per cent, three digits.
pub(super) fn percent(error: f64) -> String {
    let rounded: f64 = format!("{:.2e}", 100.0 * error).parse().unwrap_or(100.0 * error);
    format!("{} %", number(rounded))
}

/// A tick of a logarithmic axis.
pub(super) fn decade(value: f64) -> String {
    let power = value.log10().round();
    if (-2.0..=3.0).contains(&power) {
        return value.to_string();
    }
    format!("10{}", power.to_string().chars().map(superscript).collect::<String>())
}

/// A digit or sign, raised.
fn superscript(character: char) -> char {
    match character {
        '-' => '⁻',
        digit => digit
            .to_digit(10)
            .map_or(digit, |place| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][place as usize]),
    }
}

/// A count with its thousands apart.
pub(super) fn integer(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_four_digits() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.012345), "−0.01235");
        assert_eq!(number(123456.0), "123456");
        assert_eq!(number(1.5e-7), "1.5·10⁻⁷");
        assert_eq!(number(-2.0e9), "−2·10⁹");
        assert_eq!(number(f64::INFINITY), "∞");
        assert_eq!(integer(1234567), "1\u{202f}234\u{202f}567");
        assert_eq!([0.0123456, 1e-5, 0.5].map(percent), ["1.23 %", "0.001 %", "50 %"]);
        assert_eq!([0.01, 1e-4].map(decade), ["0.01", "10⁻⁴"]);
    }
}
