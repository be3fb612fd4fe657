//! Running means of noisy curves.

use crate::run::chart::Mean;

/// Minimum number of rows for which there is a mean.
const FEWEST: usize = 50;

/// A mean covers about this fraction of all rows: one in 50.
const PART: usize = 50;

/// A noisy curve goes up and down more than this many times as far as its mean ...
const RESTLESS: f64 = 4.0;
/// ... and the root mean square of its deviations from the mean is more than this share of its range.
const AWAY: f64 = 0.01;

/// Returns the running mean of a curve, or `None` if the curve is not noisy. Each mean covers equally many
/// rows before and after its own, fewer at the ends.
pub(crate) fn mean(across: &[f64], up: &[f64]) -> Option<Mean> {
    if up.len() < FEWEST || across.iter().chain(up).any(|value| !value.is_finite()) {
        return None;
    }
    let half = (up.len() / PART / 2).max(2);
    let smooth = averaged(up, half);
    let travel = |values: &[f64]| values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>();
    let [low, high] =
        up.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)]);
    let squares: f64 = up.iter().zip(&smooth).map(|(x, mean)| (x - mean) * (x - mean)).sum();
    let away = (squares / up.len() as f64).sqrt();
    let noisy = travel(up) > RESTLESS * travel(&smooth) && away > AWAY * (high - low);
    noisy.then(|| Mean { rows: 2 * half + 1, across: averaged(across, half), up: smooth })
}

/// Returns the means over up to `half` rows before and equally many after each row.
fn averaged(values: &[f64], half: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let around = |k: usize| {
        let reach = half.min(k).min(last - k);
        let rows = &values[k - reach..=k + reach];
        rows.iter().sum::<f64>() / rows.len() as f64
    };
    (0..values.len()).map(around).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_noisy_curves_have_a_mean() {
        let time: Vec<f64> = (0..1000).map(f64::from).collect();
        let peak = |t: f64| if t < 600.0 { t } else { 0.2 * t };
        let clean: Vec<f64> = time.iter().map(|&t| peak(t)).collect();
        assert!(mean(&time, &clean).is_none());
        let slow: Vec<f64> = time.iter().map(|&t| (t / 60.0).sin()).collect();
        assert!(mean(&time, &slow).is_none(), "an oscillation longer than the mean is not noise");
        let noise = |t: f64| 40.0 * (2.1 * t).sin();
        let noisy: Vec<f64> = time.iter().map(|&t| peak(t) + noise(t)).collect();
        let found = mean(&time, &noisy).unwrap();
        assert_eq!(found.rows, 21);
        assert_eq!(found.across[500], 500.0);
        assert_eq!((found.up[0], found.up[999]), (noisy[0], noisy[999]));
        for k in (20..580).chain(620..980) {
            assert!((found.up[k] - clean[k]).abs() < 5.0, "{k}: {} {}", found.up[k], clean[k]);
        }
        assert!(mean(&time[..40], &noisy[..40]).is_none());
        assert!(mean(&time, &[&noisy[..999], &[f64::NAN]].concat()).is_none());
    }
}
