//! Units with SI prefixes.

/// Returns the factor and the prefixed unit with which numbers are short. Units that take no prefix stay as
/// they are.
///
/// `largest` is the greatest magnitude of the numbers.
pub(crate) fn prefixed(unit: &str, largest: f64) -> (f64, String) {
    const PREFIXES: [(f64, f64, &str); 7] = [
        (1e9, 1e-9, "G"),
        (1e6, 1e-6, "M"),
        (1e3, 1e-3, "k"),
        (1.0, 1.0, ""),
        (1e-3, 1e3, "m"),
        (1e-6, 1e6, "µ"),
        (1e-9, 1e9, "n"),
    ];
    let largest = largest.abs();
    if !["Pa", "m", "m/s", "s", "J", "N", "N/m", "J/m"].contains(&unit) || !(1e-9..1e15).contains(&largest) {
        return (1.0, unit.to_owned());
    }
    // Lengths, velocities and times have no prefix above 1, such as megametres.
    let most = if unit.starts_with('m') || unit == "s" { 1.0 } else { f64::INFINITY };
    // With the tolerance, an axis that ends slightly below 1 by rounding does not show 999.9 of the smaller
    // unit.
    let found = PREFIXES.iter().find(|(size, ..)| *size <= most && largest * 1.000_001 >= *size);
    found.map_or_else(|| (1.0, unit.to_owned()), |(_, factor, prefix)| (*factor, format!("{prefix}{unit}")))
}

/// Splits `load [N]` into `load` and `N`. The unit is empty if the column has none.
pub(crate) fn split(name: &str) -> (&str, &str) {
    let parts = name.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    parts.map_or((name, ""), |(name, unit)| (name.trim_end(), unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_short() {
        for (unit, largest, factor, text) in [
            ("Pa", 3.2e6, 1e-6, "MPa"),
            ("Pa", 5e10, 1e-9, "GPa"),
            ("Pa", 0.0, 1.0, "Pa"),
            ("m", 0.05, 1e3, "mm"),
            ("m", 5e6, 1.0, "m"),
            ("s", 2e-5, 1e6, "µs"),
            ("", 0.5, 1.0, ""),
            ("rad", 1e-5, 1.0, "rad"),
            ("J", f64::NAN, 1.0, "J"),
        ] {
            assert_eq!(prefixed(unit, largest), (factor, text.to_owned()), "{unit} {largest}");
        }
    }
}
