//! Times and sizes in the units of everyday use.

use fdem_io::numbers::brief;

/// s.
pub(crate) const YEAR: f64 = 365.25 * 86_400.0;

/// Time from which durations are given in years instead of days, s.
const YEARS: f64 = 2.0 * YEAR;

/// `75` as `1 min 15 s`; at least 0.1 s.
pub(crate) fn duration(seconds: f64) -> String {
    if seconds < 0.1 {
        "0.1 s".to_owned()
    } else if seconds < 60.0 {
        format!("{seconds:.1} s")
    } else if seconds < 7200.0 {
        let seconds = seconds.round();
        format!("{:.0} min {:02.0} s", (seconds / 60.0).floor(), seconds % 60.0)
    } else if seconds < 48.0 * 3600.0 {
        format!("{:.1} h", seconds / 3600.0)
    } else if seconds < YEARS {
        format!("{:.1} days", seconds / 86_400.0)
    } else {
        format!("{} years", brief((seconds / YEAR).round()))
    }
}

/// `2500000` bytes as `2.5 MB`.
pub(crate) fn size(bytes: f64) -> String {
    if bytes < 1e5 {
        format!("{:.1} kB", bytes / 1e3)
    } else if bytes < 1e9 {
        format!("{:.1} MB", bytes / 1e6)
    } else {
        format!("{:.1} GB", bytes / 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_told_as_people_tell_them() {
        assert_eq!(
            [1e-3, 3.21, 75.0, 119.7, 7300.0, 1e6, 3.2e9].map(duration),
            ["0.1 s", "3.2 s", "1 min 15 s", "2 min 00 s", "2.0 h", "11.6 days", "101 years"]
        );
    }

    #[test]
    fn sizes_have_the_unit_that_fits() {
        assert_eq!([480.0, 2.5e6, 3e9].map(size), ["0.5 kB", "2.5 MB", "3.0 GB"]);
    }
}
