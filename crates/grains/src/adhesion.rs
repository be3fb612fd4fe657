//! Adhesion of soft spheres (Johnson, Kendall and Roberts 1971).
//!
//! With the radius `a` of the contact, the reduced radius `R` and modulus `E`, and the work of adhesion `w`:
//!
//! ```text
//! F = 4 E a³ / (3 R) - √(8 π w E a³),    overlap = a² / R - √(2 π w a / E)
//! ```
//! The spheres stick from the overlap 0 on, and part where the contact is no longer stable: at
//! `a = (π w R² / (8 E))^(1/3)` and the overlap `-3 a² / R`. The largest pull is `3/2 π w R`.

use std::f64::consts::PI;

/// Radius of the contact at which two spheres part, m.
fn last_radius(radius: f64, modulus: f64, work: f64) -> f64 {
    libm::cbrt(PI * work * radius * radius / (8.0 * modulus))
}

/// The overlap, m and negative, at which two spheres that stick to each other part.
pub(crate) fn last_overlap(radius: f64, modulus: f64, work: f64) -> f64 {
    let last = last_radius(radius, modulus, work);
    -3.0 * last * last / radius
}

/// Radius of the contact at an overlap, m: by Newton's method from above, where the function is convex.
pub(crate) fn contact_radius(overlap: f64, radius: f64, modulus: f64, work: f64) -> f64 {
    let pull = (2.0 * PI * work / modulus).sqrt();
    let last = last_radius(radius, modulus, work);
    // The overlap as a function of √a rises from √`last` on: x⁴ / R - pull x.
    let least = last.sqrt();
    let bound = (radius * overlap.max(0.0)).sqrt() + libm::cbrt(pull * pull * radius * radius) + last;
    let mut x = bound.sqrt().max(least);
    for _ in 0..50 {
        let cube = x * x * x;
        let change = (cube * x / radius - pull * x - overlap) / (4.0 * cube / radius - pull);
        let next = (x - change).max(least);
        if (next - x).abs() <= 1e-15 * x {
            return next * next;
        }
        x = next;
    }
    x * x
}

/// The force at a radius of the contact, N; negative for a pull.
pub(crate) fn force(contact: f64, radius: f64, modulus: f64, work: f64) -> f64 {
    let cube = contact * contact * contact;
    4.0 * modulus * cube / (3.0 * radius) - (8.0 * PI * work * modulus * cube).sqrt()
}

/// The largest pull, N.
pub(crate) fn pull_off(radius: f64, work: f64) -> f64 {
    1.5 * PI * work * radius
}

/// Energy of a contact over that at which it begins, J: the work of the force from an overlap of 0 on, where
/// the surfaces jump into contact.
///
/// With `s = √(2 π w/E)`, force times the derivative of the overlap is
/// `8 E a⁴/(3 R²) - 14 E s a^{5/2}/(3 R) + E s² a`.
pub(crate) fn energy(contact: f64, radius: f64, modulus: f64, work: f64) -> f64 {
    let square = 2.0 * PI * work / modulus;
    let root = square.sqrt();
    let integral = |a: f64| {
        let odd = a * a * a * a.sqrt();
        modulus
            * (8.0 / 15.0 * a * a * a * a * a / (radius * radius) - 4.0 / 3.0 * root * odd / radius
                + 0.5 * square * a * a)
    };
    integral(contact) - integral(contact_radius(0.0, radius, modulus, work))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE: (f64, f64, f64) = (1e-3, 1e8, 0.05);

    #[test]
    fn the_numbers_of_a_soft_sphere() {
        let (radius, modulus, work) = CASE;
        assert!((pull_off(radius, work) / 2.3562e-4 - 1.0).abs() < 1e-4);
        let free = contact_radius(0.1228e-6, radius, modulus, work);
        assert!((free / 19.19e-6 - 1.0).abs() < 1e-3, "{free}");
        assert!(force(free, radius, modulus, work).abs() < 1e-3 * pull_off(radius, work));
        assert!((last_overlap(radius, modulus, work) / -0.1013e-6 - 1.0).abs() < 1e-3);
        let last = contact_radius(last_overlap(radius, modulus, work), radius, modulus, work);
        let parting = force(last, radius, modulus, work);
        assert!((parting / (-5.0 / 6.0 * PI * work * radius) - 1.0).abs() < 1e-6, "{parting}");
    }

    #[test]
    fn the_energy_is_the_work_of_the_force() {
        let (radius, modulus, work) = CASE;
        let at = |overlap: f64| contact_radius(overlap, radius, modulus, work);
        let (from, to, steps) = (0.0, 3e-6, 30_000);
        let width = (to - from) / f64::from(steps);
        let mut sum = 0.0;
        for k in 0..steps {
            sum += width * force(at(from + width * (f64::from(k) + 0.5)), radius, modulus, work);
        }
        let energy = energy(at(to), radius, modulus, work);
        assert!((energy / sum - 1.0).abs() < 1e-6, "{energy} {sum}");
    }

    #[test]
    fn the_radius_belongs_to_the_overlap() {
        let (radius, modulus, work) = CASE;
        let mut most = 0.0_f64;
        for k in 0..2000 {
            let overlap = last_overlap(radius, modulus, work) * (1.0 - f64::from(k) / 200.0);
            let contact = contact_radius(overlap, radius, modulus, work);
            let back = contact * contact / radius - (2.0 * PI * work * contact / modulus).sqrt();
            assert!((back - overlap).abs() < 1e-14 * radius, "{overlap} {back}");
            most = most.max(-force(contact, radius, modulus, work));
        }
        assert!((most / pull_off(radius, work) - 1.0).abs() < 1e-3, "{most}");
    }
}
