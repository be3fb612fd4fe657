//! Round numbers for axes, colour bars and scale bars.

use fdem_io::numbers::brief;

/// Largest number of the form 1, 2 or 5 times a power of ten that is not above `x`; 0 if `x` is not above 0
/// or not finite.
pub(crate) fn round_below(x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 || x.is_infinite() {
        return 0.0;
    }
    // The number is parsed from its digits: computed powers of ten are not exactly rounded, and differ
    // between machines.
    let text = format!("{x:e}");
    let (digits, exponent) = text.split_once('e').unwrap_or(("1", "0"));
    let first = match digits.as_bytes().first() {
        Some(b'5'..=b'9') => 5,
        Some(b'2'..=b'4') => 2,
        _ => 1,
    };
    format!("{first}e{exponent}").parse().unwrap_or(0.0)
}

/// Round numbers from `low` to `high`, about `count` of them.
pub(crate) fn ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let width = high - low;
    let mut step = round_below(width / count as f64 * 1.5);
    if step <= 0.0 || !step.is_finite() {
        return vec![low];
    }
    while width / step > 2.0 * count as f64 {
        step *= 2.0;
    }
    let first = (low / step - 1e-9).ceil();
    // Limits the number of ticks if low and high are neighbouring floats.
    let most = ((width / step) as usize).min(4 * count);
    (0..=most + 1).map(|k| (first + k as f64) * step).filter(|&x| x <= high + step * 1e-9).collect()
}

/// Text of a tick without rounding errors.
pub(crate) fn tick_text(x: f64) -> String {
    brief(x)
}

/// Texts of the ticks of an axis, all with the same number of decimals, and with the same power of ten if
/// they need one.
pub(crate) fn tick_texts(ticks: &[f64]) -> Vec<String> {
    let largest = ticks.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let apart = ticks.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|apart| *apart > 0.0);
    let step = apart.fold(f64::INFINITY, f64::min);
    let step = if step.is_finite() { step } else { largest };
    if largest == 0.0 || !largest.is_finite() {
        return ticks.iter().map(|&x| brief(x)).collect();
    }
    let (_, of_largest) = leading(largest);
    let power = if (1e-3..1e6).contains(&largest) { 0 } else { of_largest };
    let (digits, of_step) = leading(step);
    // At most six digits of the largest tick are shown, whatever the step.
    let decimals = (digits - 1 - of_step + power).clamp(0, 5 - of_largest + power).max(0) as usize;
    let scale: f64 = format!("1e{}", -power).parse().unwrap_or(1.0);
    let text = |&x: &f64| {
        // Adding 0.0 turns -0.0 into 0.0.
        let text = format!("{:.decimals$}", x * scale + 0.0);
        if power == 0 { text } else { format!("{text}e{power}") }
    };
    ticks.iter().map(|x| if *x == 0.0 && power != 0 { "0".to_owned() } else { text(x) }).collect()
}

/// Number of digits of a number rounded to four digits, and the power of ten of its first digit.
fn leading(x: f64) -> (i32, i32) {
    let text = format!("{x:.3e}");
    let (digits, exponent) = text.split_once('e').unwrap_or(("1", "0"));
    let digits = digits.trim_end_matches('0').bytes().filter(u8::is_ascii_digit).count();
    (i32::try_from(digits).unwrap_or(1).max(1), exponent.parse().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_round() {
        for (x, round) in
            [(1.0, 1.0), (0.3, 0.2), (7e-7, 5e-7), (19.9, 10.0), (0.0, 0.0), (-1.0, 0.0), (5e200, 5e200)]
        {
            assert_eq!(round_below(x), round);
        }
        assert_eq!(round_below(f64::NAN), 0.0);
    }

    #[test]
    fn the_ticks_of_an_axis_have_one_format() {
        for (ticks, texts) in [
            (
                &[0.0, 0.2, 0.4, 0.600_000_000_000_000_1, 0.8, 1.0][..],
                &["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"][..],
            ),
            (&[0.0, 5e-5, 1e-4, 1.5e-4], &["0", "0.5e-4", "1.0e-4", "1.5e-4"]),
            (&[0.0, 2e-7, 4e-7], &["0", "2e-7", "4e-7"]),
            (&[-1e6, 0.0, 1e6], &["-1e6", "0", "1e6"]),
            (&[5000.0, 10_000.0], &["5000", "10000"]),
            (&[0.25, 0.5], &["0.25", "0.50"]),
            (&[-0.0, 1.0], &["0", "1"]),
            (&[0.0], &["0"]),
            (&[0.002], &["0.002"]),
            (&[1e300, 2e300], &["1e300", "2e300"]),
            (&[1.0, 1.0 + f64::EPSILON], &["1.00000", "1.00000"]),
        ] {
            assert_eq!(tick_texts(ticks), texts);
        }
    }

    #[test]
    fn ticks_lie_in_their_range() {
        assert_eq!(ticks(0.0, 1.0, 5), [0.0, 0.2, 0.4, 0.600_000_000_000_000_1, 0.8, 1.0]);
        for (low, high) in
            [(0.0, 9.01e-7), (-3.0, 17.0), (5.0, 5.0), (1e300, 2e300), (1.0, 1.0 + f64::EPSILON)]
        {
            let ticks = ticks(low, high, 5);
            assert!(!ticks.is_empty() && ticks.len() <= 21, "{low} {high} {ticks:?}");
        }
    }
}
