//! Size distributions: how the radii of a scene are drawn.

use crate::error::{Error, not_negative, positive, reserved};
use crate::random::{RADII, Random};

/// Distribution of the radii.
///
/// # Units
/// All lengths in the unit of the scene; `exponent` and `sigma` are numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sizes {
    /// All radii are equal.
    Equal {
        /// The radius, positive.
        radius: f64,
    },
    /// Density proportional to `r^exponent` for `min <= r <= max`, zero elsewhere.
    PowerLaw {
        /// Smallest radius, positive.
        min: f64,
        /// Largest radius, not below `min`.
        max: f64,
        /// Any finite number; −1 distributes the logarithm of the radius uniformly, 0 the radius itself.
        exponent: f64,
    },
    /// The logarithm of the radius is normal: `r = median exp(sigma z)`.
    Lognormal {
        /// The median radius, positive.
        median: f64,
        /// Standard deviation of the logarithm, zero or positive.
        sigma: f64,
    },
}

impl Sizes {
    /// Draws `n` radii.
    ///
    /// # Cost
    /// Time and memory proportional to `n`; two elementary functions per radius unless all radii are equal.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a parameter outside its documented range, or if a `sigma` of hundreds makes
    /// a drawn radius underflow or overflow; [`Error::MinAboveMax`]; [`Error::OutOfMemory`].
    ///
    /// # Example
    /// ```
    /// let radii = fdem_scenes::Sizes::PowerLaw { min: 1.0, max: 50.0, exponent: -2.5 }.radii(100, 1)?;
    /// assert!(radii.iter().all(|r| (1.0..=50.0).contains(r)));
    /// # Ok::<(), fdem_scenes::Error>(())
    /// ```
    pub fn radii(self, n: usize, seed: u64) -> Result<Vec<f64>, Error> {
        let mut random = Random::with_stream(seed, RADII);
        self.check()?;
        let mut radii = reserved(n)?;
        match self {
            Self::Equal { radius } => radii.resize(n, radius),
            Self::PowerLaw { min, max, exponent } => {
                let law = PowerLaw::new(min, max, exponent);
                radii.extend((0..n).map(|_| law.quantile(random.uniform())));
            }
            Self::Lognormal { median, sigma } => {
                for _ in 0..n {
                    radii.push(positive("drawn radius", median * libm::exp(sigma * random.normal()))?);
                }
            }
        }
        Ok(radii)
    }

    /// Twice the mean of the drawn `radii`, without rounding if all are equal.
    pub(crate) fn mean_diameter(self, radii: &[f64]) -> Result<f64, Error> {
        let diameter = match self {
            Self::Equal { radius } => 2.0 * radius,
            _ => 2.0 * (radii.iter().sum::<f64>() / radii.len() as f64),
        };
        positive("mean diameter", diameter)
    }

    fn check(self) -> Result<(), Error> {
        match self {
            Self::Equal { radius } => positive("radius", radius).map(drop),
            Self::PowerLaw { min, max, exponent } => {
                positive("smallest radius", min)?;
                positive("largest radius", max)?;
                if min > max {
                    return Err(Error::MinAboveMax { min, max });
                }
                if exponent.is_finite() {
                    Ok(())
                } else {
                    Err(Error::OutOfRange { what: "exponent", value: exponent, limit: "finite" })
                }
            }
            Self::Lognormal { median, sigma } => {
                positive("median radius", median)?;
                not_negative("sigma", sigma).map(drop)
            }
        }
    }
}

/// Inverse of the cumulative distribution of a power law.
///
/// With `a = exponent + 1` and `q = max/min`, the fraction of radii below `r` is
/// `u = ((r/min)^a − 1) / (q^a − 1)`, so `r = min (1 + u (q^a − 1))^(1/a)`. Written with `expm1` and `log1p`,
/// this stays accurate for small `a`. For positive `a` the formula starts from `max` instead, so that
/// `q^−|a|` never overflows.
struct PowerLaw {
    min: f64,
    max: f64,
    /// `a`.
    power: f64,
    /// `ln q`.
    log_ratio: f64,
    /// `q^−|a| − 1`.
    span: f64,
}

impl PowerLaw {
    fn new(min: f64, max: f64, exponent: f64) -> Self {
        let power = exponent + 1.0;
        let log_ratio = libm::log(max) - libm::log(min);
        Self { min, max, power, log_ratio, span: libm::expm1(-power.abs() * log_ratio) }
    }

    fn quantile(&self, u: f64) -> f64 {
        let r = if self.power == 0.0 {
            self.min * libm::exp(u * self.log_ratio)
        } else if self.power < 0.0 {
            self.min * libm::exp(libm::log1p(u * self.span) / self.power)
        } else {
            self.max * libm::exp(libm::log1p((1.0 - u) * self.span) / self.power)
        };
        r.clamp(self.min, self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest distance between the empirical and the given cumulative distribution.
    fn kolmogorov_distance(mut drawn: Vec<f64>, share_below: impl Fn(f64) -> f64) -> f64 {
        drawn.sort_by(f64::total_cmp);
        let n = drawn.len() as f64;
        let distance = |(k, &r): (usize, &f64)| (share_below(r) - (k as f64 + 0.5) / n).abs();
        drawn.iter().enumerate().map(distance).fold(0.0, f64::max)
    }

    #[test]
    fn power_law_follows_its_distribution() {
        let n = 40_000;
        for exponent in [-2.5, -1.0, -1.0 + 1e-9, 0.0, 2.0] {
            let (min, max) = (1.0, 50.0);
            let radii = Sizes::PowerLaw { min, max, exponent }.radii(n, 11).unwrap();
            assert!(radii.iter().all(|r| (min..=max).contains(r)));
            let share = |r: f64| {
                let a: f64 = exponent + 1.0;
                if a.abs() < 1e-6 { r.ln() / max.ln() } else { (r.powf(a) - 1.0) / (max.powf(a) - 1.0) }
            };
            // Kolmogorov's bound at a level of about 1e-5: 2.4 / sqrt(n).
            assert!(kolmogorov_distance(radii, share) < 0.012, "exponent {exponent}");
        }
    }

    #[test]
    fn quantiles_rise_from_min_to_max() {
        for exponent in [-2.5, -1.0, 0.0, 2.0] {
            let law = PowerLaw::new(1.0, 50.0, exponent);
            let quantiles: Vec<f64> = (0..=100).map(|k| law.quantile(f64::from(k) / 100.0)).collect();
            assert!(quantiles.is_sorted(), "exponent {exponent}");
            assert!(
                (quantiles[0] - 1.0).abs() < 1e-12 && (quantiles[100] - 50.0).abs() < 1e-10,
                "{quantiles:?}"
            );
        }
        // Halves of an even and of a linear density.
        assert!((PowerLaw::new(1.0, 50.0, 0.0).quantile(0.5) - 25.5).abs() < 1e-12);
        assert!((PowerLaw::new(1.0, 7.0, 1.0).quantile(0.5) - 5.0).abs() < 1e-13);
        assert!((PowerLaw::new(1.0, 49.0, -1.0).quantile(0.5) - 7.0).abs() < 1e-13);
    }

    #[test]
    fn lognormal_has_its_median_and_its_spread() {
        let n = 40_000;
        let radii = Sizes::Lognormal { median: 3.0, sigma: 0.25 }.radii(n, 12).unwrap();
        let below = |bound: f64| radii.iter().filter(|&&r| r < bound).count() as f64 / n as f64;
        assert!((below(3.0) - 0.5).abs() < 0.0125, "{}", below(3.0));
        // One standard deviation above the median: 0.841345.
        assert!((below(3.0 * 0.25_f64.exp()) - 0.841_345).abs() < 0.0092);
        let logs: Vec<f64> = radii.iter().map(|r| (r / 3.0).ln()).collect();
        let spread = (logs.iter().map(|x| x * x).sum::<f64>() / n as f64).sqrt();
        assert!((spread - 0.25).abs() < 0.0045, "{spread}");
    }

    #[test]
    fn extreme_power_laws_stay_in_range() {
        for (min, max, exponent) in [
            (1.0, 50.0, 1e6),
            (1.0, 50.0, -1e6),
            (1e-300, 1e300, -3.0),
            (1e-300, 1e300, 3.0),
            (2.0, 2.0, -2.5),
        ] {
            let radii = Sizes::PowerLaw { min, max, exponent }.radii(1_000, 13).unwrap();
            assert!(radii.iter().all(|r| (min..=max).contains(r)), "{min} {max} {exponent}");
        }
    }

    #[test]
    fn equal_sizes_are_equal_and_none_are_none() {
        assert_eq!(Sizes::Equal { radius: 0.1 }.radii(3, 9), Ok(vec![0.1; 3]));
        assert_eq!(Sizes::Lognormal { median: 1.0, sigma: 0.3 }.radii(0, 9), Ok(vec![]));
        assert_eq!(Sizes::Lognormal { median: 1.5, sigma: 0.0 }.radii(2, 9), Ok(vec![1.5; 2]));
    }

    #[test]
    fn mean_diameter_is_twice_the_mean() {
        let sizes = Sizes::PowerLaw { min: 1.0, max: 3.0, exponent: 0.0 };
        assert_eq!(sizes.mean_diameter(&[1.0, 2.0, 3.0]), Ok(4.0));
        assert_eq!(Sizes::Equal { radius: 0.1 }.mean_diameter(&[]), Ok(0.2));
        assert!(Sizes::Equal { radius: 1e308 }.mean_diameter(&[]).is_err());
    }

    #[test]
    fn bad_parameters_are_refused() {
        let law = |min, max, exponent| Sizes::PowerLaw { min, max, exponent }.radii(1, 0);
        let lognormal = |median, sigma| Sizes::Lognormal { median, sigma }.radii(1, 0);
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Sizes::Equal { radius }.radii(1, 0).is_err(), "{radius}");
            assert!(law(radius, 1.0, -2.5).is_err() && law(1.0, radius, -2.5).is_err());
            assert!(lognormal(radius, 0.1).is_err());
        }
        assert_eq!(law(2.0, 1.0, -2.5), Err(Error::MinAboveMax { min: 2.0, max: 1.0 }));
        assert!(law(1.0, 2.0, f64::NAN).is_err());
        assert!(lognormal(1.0, -0.1).is_err() && lognormal(1.0, f64::NAN).is_err());
        assert!(Sizes::Lognormal { median: 1.0, sigma: 1e6 }.radii(9, 0).is_err());
    }
}
