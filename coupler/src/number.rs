//! Numbers as text: in plain letters for terminals and tables, with the signs of print for pages and figures.

use std::fmt;

pub use bedload_scene::speeds::norm;

/// Letters of the components of a vector.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A number with few digits, whatever its size, in plain letters: `0.0625`, `4.340e-4`.
#[derive(Clone, Copy, Debug)]
pub struct Short(pub f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(4);
        let size = self.0.abs();
        if self.0 == 0.0 || !self.0.is_finite() {
            return write!(f, "{}", self.0);
        }
        if !(1e-3..1e6).contains(&size) {
            return write!(f, "{:.*e}", digits - 1, self.0);
        }
        let places = (digits as i32 - 1 - size.log10().floor() as i32).max(0) as usize;
        f.write_str(trimmed(&format!("{:.places$}", self.0)))
    }
}

/// Without zeros at the end of a fraction.
fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// Four digits, with a power of ten where that is shorter: `0.0625`, `4.34·10⁻⁴`.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string().replace("inf", "∞");
    }
    let text = Short(value).to_string();
    let print = |text: &str| text.replace('-', "−");
    text.split_once('e').map_or_else(
        || print(&text),
        |(digits, power)| format!("{}·10{}", print(trimmed(digits)), raised(power)),
    )
}

/// An error in per cent, three digits.
pub fn percent(error: f64) -> String {
    format!("{} %", number(rounded(100.0 * error, 3)))
}

/// A value to so many digits.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// A measured value of a table, so that values of one kind stand with the same number of places.
pub fn measured(value: f64) -> String {
    match value.abs() {
        size if value != 0.0 && !(1e-3..1e5).contains(&size) => format!("{value:.3e}"),
        size if size >= 100.0 => format!("{value:.1}"),
        size if size >= 10.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

/// A tick of a logarithmic axis.
pub fn decade(value: f64) -> String {
    let power = value.log10().round();
    if (-2.0..=3.0).contains(&power) {
        value.to_string()
    } else {
        format!("10{}", raised(&power.to_string()))
    }
}

/// Digits and sign, raised.
fn raised(power: &str) -> String {
    let one = |character: char| match character {
        '-' => '⁻',
        digit => digit
            .to_digit(10)
            .map_or(digit, |place| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][place as usize]),
    };
    power.chars().map(one).collect()
}

/// A count with its thousands apart.
pub fn integer(value: u64) -> String {
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

    #[test]
    fn measured_values_keep_four_digits_or_so() {
        let written = [0.0, 0.1234567, 19.7412, 862.287, 2e-5].map(measured);
        assert_eq!(written, ["0.0000", "0.1235", "19.74", "862.3", "2.000e-5"]);
    }
}
