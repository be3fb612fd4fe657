//! Scatter of strengths. It is a function of the seed and the number of an edge only, and the same on every
//! platform.

/// Random number, uniform in (0, 1), from the seed and the number, by a variant of `SplitMix64` (Steele, Lea
/// and Flood, 2014) whose second shift is 30 instead of 27. Results of runs with scatter depend on it.
pub(crate) fn uniform(seed: u64, number: u64) -> f64 {
    let mut x = seed ^ number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for factor in [0xbf58_476d_1ce4_e5b9_u64, 0x94d0_49bb_1331_11eb] {
        x = (x ^ (x >> 30)).wrapping_mul(factor);
    }
    x ^= x >> 31;
    ((x >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
}

/// Random number of a Weibull distribution with this modulus and a mean of 1.
pub(crate) fn weibull(seed: u64, number: u64, modulus: f64) -> f64 {
    libm::pow(-libm::log(uniform(seed, number)), 1.0 / modulus) / libm::tgamma(1.0 + 1.0 / modulus)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weibull_has_its_mean_and_spread() {
        for modulus in [1.0, 2.0, 10.0] {
            let n = 200_000;
            let values: Vec<f64> = (0..n).map(|k| weibull(7, k, modulus)).collect();
            let mean = values.iter().sum::<f64>() / n as f64;
            let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
            let (one, two) = (libm::tgamma(1.0 + 1.0 / modulus), libm::tgamma(1.0 + 2.0 / modulus));
            assert!((mean - 1.0).abs() < 0.01, "{modulus} {mean}");
            assert!((variance / (two / (one * one) - 1.0) - 1.0).abs() < 0.03, "{modulus} {variance}");
        }
        assert_ne!(weibull(1, 0, 5.0), weibull(2, 0, 5.0));
    }
}
