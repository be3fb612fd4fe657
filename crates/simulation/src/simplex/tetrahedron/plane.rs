//! Tractions on planes through a point of stressed material.

use crate::simplex::tetrahedron::eigen;
use crate::vector::{Matrix, Point, applied, cross3, dot, minus, unit};

/// Components along axes of the traction across the first of them, Pa.
pub(super) fn traction_in(axes: &Matrix<3>, stress: &Matrix<3>) -> [f64; 3] {
    let traction = applied(stress, axes[0]);
    axes.map(|axis| dot(traction, axis))
}

/// Tractions on the critical planes, or as near to them as a plane with these axes comes when it turns by at
/// most `reach`, with the cosines of the angles.
pub(super) fn tractions_near(
    axes: &Matrix<3>,
    stress: &Matrix<3>,
    friction: f64,
    reach: f64,
) -> [([f64; 3], f64); 3] {
    let (sin, cos) = libm::sincos(reach);
    critical_normals(stress, friction).map(|critical| {
        // A plane has two normals: the nearer one.
        let near = dot(critical, axes[0]);
        let critical = if near < 0.0 { critical.map(|x| -x) } else { critical };
        let normal = if near.abs() >= cos {
            critical
        } else {
            let across = unit(minus(critical, axes[0].map(|x| near.abs() * x)));
            std::array::from_fn(|axis| cos * axes[0][axis] + sin * across[axis])
        };
        // Any directions along the plane will do: only the size of its shear counts.
        (traction_in(&axes_around(normal), stress), near.abs().max(cos))
    })
}

/// Unit normals of the plane across the largest tension and of the two on which Mohr and Coulomb's strength
/// is used most.
fn critical_normals(stress: &Matrix<3>, friction: f64) -> Matrix<3> {
    let (values, vectors) = eigen::values_and_vectors(*stress);
    let by = |better: fn(&f64, &f64) -> bool| {
        (1..3).fold(0, |best, k| if better(&values[k], &values[best]) { k } else { best })
    };
    let (most, least) = (vectors[by(f64::gt)], vectors[by(f64::lt)]);
    let angle = 0.5 * (std::f64::consts::FRAC_PI_2 - libm::atan(friction));
    let (sin, cos) = libm::sincos(angle);
    let turned = |sin: f64| -> Point<3> { std::array::from_fn(|axis| cos * most[axis] + sin * least[axis]) };
    [most, turned(sin), turned(-sin)]
}

/// Unit vectors at right angles, of which this is the first.
#[inline(always)]
#[allow(
    clippy::needless_bitwise_bool,
    reason = "a lazy operator is a branch, of which the compiler makes no vectors"
)]
pub(super) fn axes_around(normal: Point<3>) -> Matrix<3> {
    // The second is at right angles to the axis of the coordinates that is least along the first, too.
    let [x, y, z] = normal.map(f64::abs);
    let last = (z < x) & (z < y);
    let middle = (y < x) & !last;
    let one = |is: bool| if is { 1.0 } else { 0.0 };
    let along = unit(cross3(normal, [one(!(last | middle)), one(middle), one(last)]));
    [normal, along, cross3(normal, along)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cohesive::tests::ROCK;
    use crate::cohesive::use_of;
    use crate::random::uniform;
    use crate::simplex::Simplex;
    use crate::simplex::Tetrahedron;
    use crate::vector::{add, length, matrix, symmetric};

    /// No plane uses a strength more than the critical planes do, if these are within reach. With no reach,
    /// all tractions are those on the facet.
    #[test]
    fn no_plane_uses_the_strength_more_than_the_critical_ones() {
        let strength = crate::model::Strength { friction: 0.6, ..ROCK };
        for seed in 0..100 {
            let stress = symmetric(&matrix::<3>(|i, k| 1e7 * (uniform(seed, (3 * i + k) as u64) - 0.6)));
            let facet: [Point<3>; 3] = matrix(|i, k| uniform(seed, 100 + (3 * i + k) as u64));
            // Everything is within reach.
            let all = Tetrahedron::tractions_near(&facet, &stress, strength.friction, 1.6);
            let best = all.iter().map(|(traction, _)| use_of(&strength, *traction)).fold(0.0, f64::max);
            let normal = unit(Tetrahedron::axes(&facet)[0]);
            for k in 0..300 {
                let mut turned = normal;
                add(
                    &mut turned,
                    matrix::<3>(|_, axis| uniform(seed, 1000 + 3 * k + axis as u64) - 0.5)[0],
                    4.0,
                );
                let turned = unit(turned);
                let traction = traction_in(&axes_around(turned), &stress);
                // Between tension and shear the ellipse has its most used plane between the critical ones.
                let bound = if traction[0] > 0.0 { 1.3 } else { 1.0 + 1e-9 };
                assert!(use_of(&strength, traction) <= bound * best, "{stress:?} {turned:?}");
            }
            let own = Tetrahedron::traction_on(&facet, &stress);
            for (traction, cos) in Tetrahedron::tractions_near(&facet, &stress, strength.friction, 0.0) {
                assert!((cos - 1.0).abs() < 1e-15);
                assert!((traction[0] - own[0]).abs() < 1e-6 * 1e7);
                let shears = [traction, own].map(|[_, x, y]| length([x, y]));
                assert!((shears[0] - shears[1]).abs() < 1e-6 * 1e7);
            }
        }
    }
}
