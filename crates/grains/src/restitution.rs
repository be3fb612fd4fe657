//! The damping of a contact from its coefficient of restitution.
//!
//! A spring with a dashpot pulls at the end of an impact, where bodies without adhesion part. With a force
//! that cannot pull, an impact at the damping ratio `b` ends when the force is 0, and (Schwager and Pöschel
//! 2007)
//!
//! ```text
//! e = exp(-2 b arccos(b) / √(1 - b²)),    b < 1
//! e = exp(-2 b arcosh(b) / √(b² - 1)),    b > 1
//! ```
//! The same holds for Hertz's law with a dashpot that grows with its stiffness (Tsuji 1992).

/// The coefficient of restitution at a damping ratio.
fn restitution(ratio: f64) -> f64 {
    let angle = if (ratio - 1.0).abs() < 1e-9 {
        1.0
    } else if ratio < 1.0 {
        libm::acos(ratio) / (1.0 - ratio * ratio).sqrt()
    } else {
        libm::acosh(ratio) / (ratio * ratio - 1.0).sqrt()
    };
    libm::exp(-2.0 * ratio * angle)
}

/// The damping ratio of a contact with a coefficient of restitution above 0 and at most 1, if its force
/// cannot pull. It may be above 1.
pub(crate) fn damping_ratio(wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while restitution(high) > wanted {
        high *= 2.0;
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if restitution(middle) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ratios of a force that may pull, -ln e / √(ln² e + π²), and the restitution of one that cannot.
    #[test]
    fn a_force_that_cannot_pull_restores_more() {
        for (e, known) in [(0.9, 0.9020), (0.7, 0.7182), (0.5, 0.5503), (0.3, 0.3971), (0.1, 0.2527)] {
            let log = f64::ln(e);
            let ratio = -log / (log * log + std::f64::consts::PI.powi(2)).sqrt();
            assert!((restitution(ratio) - known).abs() < 5e-5, "{e} {}", restitution(ratio));
        }
    }

    #[test]
    fn the_ratio_is_found_for_all_coefficients() {
        assert!(damping_ratio(1.0) < 1e-15);
        for k in 1..100 {
            let e = f64::from(k) / 100.0;
            assert!((restitution(damping_ratio(e)) - e).abs() < 1e-13, "{e}");
        }
        assert!(damping_ratio(0.01) > 1.0);
    }
}
