//! How near a stress is to the strength of its material.
//!
//! The envelope is that of Mohr and Coulomb with a tension cut-off. On a plane with the normal traction σ,
//! tension positive, and the tangential traction τ it is
//!
//! ```text
//! σ ≤ f_t,    |τ| + σ tan φ ≤ c.
//! ```
//!
//! The exposure of the stress is the larger of `σ/f_t` and `(|τ| + σ tan φ)/c` on the plane where it is
//! largest: the reciprocal of the factor by which the stress can grow until it reaches the envelope. It is 1
//! on the envelope, above 1 beyond, and 0 where no growth reaches it, as under equal pressure from all sides.
//! With m and r, the middle and the radius of Mohr's largest circle, it is
//!
//! ```text
//! max(0, (m + r)/f_t, (r √(1 + tan²φ) + m tan φ)/c).
//! ```
//!
//! In two dimensions the circle is that in the plane. Cracks are across the plane, so that the stress out of
//! it breaks nothing. Joints themselves fail a little earlier where a plane has both tension and shear: their
//! law (`src/cohesive.rs`) rounds the corner between cut-off and Coulomb's line by an ellipse.
//!
//! In bedded rock the strength of a plane grows with its angle to the bedding, and no formula gives the plane
//! on which the exposure is largest: it is looked for in all directions.
//!
//! # Sources
//! J. C. Jaeger, N. G. W. Cook, R. W. Zimmerman, Fundamentals of Rock Mechanics, 4th ed. (2007), ch. 4, for
//! the envelope; A. Puck, H. Schürmann, Compos. Sci. Technol. 62 (2002) 1633-1662, for the exposure and its
//! plane.

use crate::model::Strength;
use crate::simplex::Simplex;
use crate::vector::{Matrix, Point, applied, dot, unit};

/// Directions in which planes are looked for, on each half of an axis of a cube: 7° apart or less.
const DIRECTIONS: usize = 8;

/// Angle, in radians, to which the direction of the plane is then found.
const FINEST: f64 = 1e-5;

/// Exposure of a stress, Pa, to a strength: 1 where the stress reaches it.
pub(crate) fn exposure<const D: usize, const N: usize>(strength: &Strength, stress: &Matrix<D>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let [middle, radius] = <[[f64; D]; N]>::circle(stress);
    let slope = strength.friction;
    let tension = share(middle + radius, strength.tensile);
    let shear = share(radius * (1.0 + slope * slope).sqrt() + middle * slope, strength.cohesion);
    tension.max(shear)
}

/// Exposure of a stress, Pa, to a strength that depends on the plane: `strength_on` is that of a plane with
/// this normal of unit length.
///
/// # Cost
/// About 100 planes in two dimensions, 1000 in three.
pub(crate) fn exposure_of_planes<const D: usize, const N: usize>(
    stress: &Matrix<D>,
    strength_on: impl Fn(Point<D>) -> Strength,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let on = |normal: Point<D>| {
        let (traction, strength) = (applied(stress, normal), strength_on(normal));
        let across = dot(traction, normal);
        let along = (dot(traction, traction) - across * across).max(0.0).sqrt();
        share(across, strength.tensile).max(share(along + strength.friction * across, strength.cohesion))
    };
    let (mut most, mut normal) = (0.0, None);
    for direction in directions() {
        let found = on(direction);
        if found > most {
            (most, normal) = (found, Some(direction));
        }
    }
    let Some(mut normal) = normal else { return most };
    let mut angle = 1.0 / DIRECTIONS as f64;
    while angle > FINEST {
        let axes = <[[f64; D]; N]>::axes_around(normal);
        let beside = axes[1..].iter().flat_map(|axis| [angle, -angle].map(|by| (axis, by)));
        let turned = beside.map(|(axis, by)| unit(std::array::from_fn(|k| normal[k] + by * axis[k])));
        let best = turned.map(|normal| (on(normal), normal)).max_by(|a, b| a.0.total_cmp(&b.0));
        match best.filter(|(found, _)| *found > most) {
            Some(better) => (most, normal) = better,
            None => angle *= 0.5,
        }
    }
    most
}

/// Directions of unit length, of which each stands for its opposite too: to a lattice on half of a cube.
fn directions<const D: usize>() -> impl Iterator<Item = Point<D>> {
    let row = 2 * DIRECTIONS + 1;
    (0..D).flat_map(move |axis| {
        (0..row.pow(D as u32 - 1)).map(move |number| {
            let mut rest = number;
            unit(std::array::from_fn(|k| {
                if k == axis {
                    return DIRECTIONS as f64;
                }
                let place = rest % row;
                rest /= row;
                place as f64 - DIRECTIONS as f64
            }))
        })
    })
}

/// Share of a strength that a traction uses. Pressure uses none, and a material without strength carries no
/// traction.
fn share(traction: f64, strength: f64) -> f64 {
    if traction <= 0.0 { 0.0 } else { traction / strength }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tensile strength 4, cohesion 10, and a friction angle of which the tangent is 3/4: √(1 + tan²φ) is
    /// 5/4.
    const ROCK: Strength = Strength {
        tensile: 4.0,
        cohesion: 10.0,
        friction: 0.75,
        energy_i: 1.0,
        energy_ii: 1.0,
        weibull_modulus: None,
        seed: 0,
    };

    fn plane(xx: f64, yy: f64, xy: f64) -> f64 {
        exposure::<2, 3>(&ROCK, &[[xx, xy], [xy, yy]])
    }

    #[test]
    fn tension_shear_and_pressure_of_known_states() {
        assert_eq!(plane(0.0, 0.0, 0.0), 0.0);
        // Half of the tensile strength. Shear: m = r = 1, (1.25 + 0.75)/10 = 0.2.
        assert_eq!(plane(2.0, 0.0, 0.0), 0.5);
        // Strength in compression: 2 c (tan φ + √(1 + tan²φ)) = 40.
        assert_eq!(plane(0.0, -40.0, 0.0), 1.0);
        assert_eq!(plane(-10.0, 0.0, 0.0), 0.25);
        // Pure shear: m = 0, r = 2: tension 2/4, shear 2.5/10.
        assert_eq!(plane(0.0, 0.0, 2.0), 0.5);
        // Confined: m = -20, r = 14, shear (17.5 - 15)/10.
        assert_eq!(plane(-6.0, -34.0, 0.0), 0.25);
        // On the envelope: m = -20, r = 20, and beyond.
        assert_eq!(plane(0.0, -40.0, 0.0) * 1.5, plane(0.0, -60.0, 0.0));
        assert_eq!(plane(-30.0, -30.0, 0.0), 0.0);
    }

    #[test]
    fn a_stress_that_grows_by_the_reciprocal_reaches_the_envelope() {
        for [xx, yy, xy] in [[1.0, -3.0, 0.5], [-2.0, -9.0, 3.0], [0.3, 0.2, 0.1]] {
            let factor = 1.0 / plane(xx, yy, xy);
            assert!((plane(factor * xx, factor * yy, factor * xy) - 1.0).abs() < 1e-14);
        }
    }

    /// The closed form is the largest exposure over all planes: those at whole degrees reach it nearly, and
    /// none exceeds it.
    #[test]
    fn no_plane_is_more_exposed() {
        for [xx, yy, xy] in [[1.0, -3.0, 0.5], [-2.0, -9.0, 3.0], [3.0, 2.5, -0.4], [-5.0, -25.0, 1.0]] {
            let on = |degrees: i32| {
                let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
                let normal = xx * cos * cos + yy * sin * sin + 2.0 * xy * sin * cos;
                let along = (yy - xx) * sin * cos + xy * (cos * cos - sin * sin);
                (normal / ROCK.tensile).max((along.abs() + ROCK.friction * normal) / ROCK.cohesion)
            };
            let most = (0..180).map(on).fold(0.0, f64::max);
            let found = plane(xx, yy, xy);
            assert!(most <= found + 1e-12 && most > 0.999 * found - 1e-12, "{most} {found}");
        }
    }

    #[test]
    fn in_space_the_largest_circle_counts() {
        let of = |xx, yy, zz| exposure::<3, 4>(&ROCK, &[[xx, 0.0, 0.0], [0.0, yy, 0.0], [0.0, 0.0, zz]]);
        assert!((of(0.0, -7.0, -40.0) - 1.0).abs() < 1e-14);
        assert!((of(-34.0, -6.0, -20.0) - 0.25).abs() < 1e-14);
        assert!((of(2.0, 0.0, 2.0) - 0.5).abs() < 1e-14);
    }

    /// Where all planes have one strength, the search finds the closed form.
    #[test]
    fn the_plane_that_is_found_is_the_most_exposed() {
        for [xx, yy, xy] in [[1.0, -3.0, 0.5], [-2.0, -9.0, 3.0], [3.0, 2.5, -0.4], [-5.0, -25.0, 1.0]] {
            let flat = [[xx, xy], [xy, yy]];
            let found = exposure_of_planes::<2, 3>(&flat, |_| ROCK);
            assert!((found / plane(xx, yy, xy) - 1.0).abs() < 1e-8, "{found}");
            let solid = [[xx, xy, 0.3], [xy, yy, -0.7], [0.3, -0.7, 0.5]];
            let found = exposure_of_planes::<3, 4>(&solid, |_| ROCK);
            let expected = exposure::<3, 4>(&ROCK, &solid);
            assert!(found <= expected * (1.0 + 1e-12) && found > 0.9999 * expected, "{found} {expected}");
        }
        assert_eq!(exposure_of_planes::<2, 3>(&[[-1.0, 0.0], [0.0, -1.0]], |_| ROCK), 0.0);
    }

    #[test]
    fn what_has_no_strength_bears_no_traction() {
        let sand = Strength { tensile: 0.0, cohesion: 0.0, ..ROCK };
        let of = |xx: f64, yy: f64| exposure::<2, 3>(&sand, &[[xx, 0.0], [0.0, yy]]);
        assert_eq!(of(-1.0, -1.0), 0.0);
        assert_eq!(of(1.0, 0.0), f64::INFINITY);
    }
}
