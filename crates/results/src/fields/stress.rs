//! Values of fields that follow from the stress.

/// Returns the von Mises equivalent stress of `[xx, yy, zz, xy, yz, xz]`.
pub(crate) fn von_mises([xx, yy, zz, xy, yz, xz]: [f64; 6]) -> f64 {
    let squares = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (squares / 2.0 + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_equivalent_stress_of_tension_shear_and_pressure() {
        assert_eq!(von_mises([7.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 7.0);
        for shear in [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -2.0]] {
            let [xy, yz, xz] = shear;
            assert!((von_mises([0.0, 0.0, 0.0, xy, yz, xz]) - 2.0 * 3_f64.sqrt()).abs() < 1e-15);
        }
        assert_eq!(von_mises([-5.0, -5.0, -5.0, 0.0, 0.0, 0.0]), 0.0);
    }
}
