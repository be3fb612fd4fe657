//! Invariants of a stress `[xx, yy, xy, zz]`. Tension is positive.

use fdem_simulation::principal_stresses;

/// Returns the largest and the smallest principal stress in the plane.
pub(crate) fn principal([xx, yy, xy, _]: [f64; 4]) -> [f64; 2] {
    principal_stresses([xx, yy, xy])
}

/// Returns the von Mises equivalent stress, which includes the stress out of the plane.
pub(crate) fn von_mises([xx, yy, xy, zz]: [f64; 4]) -> f64 {
    let squares = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (squares / 2.0 + 3.0 * xy * xy).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stresses_of_states_that_are_known() {
        assert_eq!(principal([3.0, -1.0, 0.0, 9.0]), [3.0, -1.0]);
        assert_eq!(principal([0.0, 0.0, 2.0, 0.0]), [2.0, -2.0]);
        assert_eq!(principal([1.0, 1.0, 0.0, 0.0]), [1.0, 1.0]);
        assert_eq!(principal([4.0, -4.0, 3.0, 0.0]), [5.0, -5.0]);
    }

    #[test]
    fn the_equivalent_stress_of_tension_shear_and_pressure() {
        assert_eq!(von_mises([7.0, 0.0, 0.0, 0.0]), 7.0);
        assert!((von_mises([0.0, 0.0, 2.0, 0.0]) - 2.0 * 3_f64.sqrt()).abs() < 1e-15);
        assert_eq!(von_mises([-5.0, -5.0, 0.0, -5.0]), 0.0);
    }
}
