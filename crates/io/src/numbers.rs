//! Numbers as text for people.

/// A number with six significant digits, without trailing zeros.
pub fn brief(x: f64) -> String {
    // Adding zero turns minus zero into zero.
    let rounded = format!("{x:.5e}").parse().unwrap_or(x) + 0.0;
    if rounded == 0.0 || (1e-4..1e6).contains(&f64::abs(rounded)) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// All digits that the number has, with an exponent where it is very small or very large.
pub fn exact(x: f64) -> String {
    if x == 0.0 || (1e-5..1e16).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// A number with its thousands grouped: `1234567` becomes `1,234,567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(grouped(number), text);
        }
    }

    #[test]
    fn no_number_has_hundreds_of_digits() {
        for (x, text) in
            [(0.5, "0.5"), (-2700.0, "-2700"), (1e300, "1e300"), (-1e-308, "-1e-308"), (0.0, "0")]
        {
            assert_eq!(exact(x), text);
        }
    }

    #[test]
    fn numbers_are_brief() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.001, "0.001"),
            (-0.049_000_316, "-0.0490003"),
            (1.198_942_518_9, "1.19894"),
            (9.011_707_7e-7, "9.01171e-7"),
            (1e12, "1e12"),
            (25_000.0, "25000"),
        ] {
            assert_eq!(brief(x), text);
        }
    }
}
