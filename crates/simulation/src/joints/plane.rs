//! Tractions on edges and on planes near them, and the plane for which a joint stands.
//!
//! Material fails on the plane that its stress uses most. An unstructured mesh has edges near that plane, not on it. An edge that had to reach the strength by
//! its own traction would fail later than the material: a tension by 1/cos² of the angle between the two, a compression by more, because facets aslant to a
//! shear plane interlock. So an edge fails as soon as a plane within [`REACH`] of it does, and its joint stands for that plane: it begins with the traction that
//! acts, which is then its strength, and its fracture energy is that of its projection on the plane.

use crate::cohesive::{Plane, use_of};
use crate::model::Strength;
use crate::solid::Solid;
use crate::topology::Facet;
use crate::vector::{Matrix, Point, dot, matrix, minus};

/// Largest angle between an edge and the plane for which its joint stands. Six edges meet at a vertex on average, so the nearest one is 15° off on average, and
/// at most 30°. With a larger reach edges fail that the crack does not take; `bench/NOTES.md` has the table.
const REACH: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Largest ratio of the uses of the strength on the plane and on the edge.
const MOST: f64 = 2.0;

/// The plane within reach of an edge along a vector on which a stress, `[xx, yy, xy]` in Pa, uses the strength most.
pub(crate) fn plane_near(along: Point, stress: Matrix, strength: &Strength) -> Plane {
    let own = use_of(strength, traction_on(stress, along));
    let mut best = (own, 1.0);
    for angle in critical_angles(along, stress, strength) {
        let (sin, cos) = libm::sincos(angle.clamp(-REACH, REACH));
        let turned = [cos * along[0] - sin * along[1], sin * along[0] + cos * along[1]];
        let used = use_of(strength, traction_on(stress, turned));
        if used > best.0 {
            best = (used, cos);
        }
    }
    let (used, area) = best;
    let excess = if used < MOST * own { used / own } else { MOST };
    // No strength, or no stress.
    if used > own && used.is_finite() { Plane { excess, area } } else { Plane::OWN }
}

/// Whether a use of the strength of an edge breaks it or a plane near it. `plane`: that plane; it is found only if it can decide.
pub(crate) fn breaks(used: f64, plane: impl FnOnce() -> Plane) -> bool {
    used >= 1.0 || (MOST * used >= 1.0 && used * plane().excess >= 1.0)
}

/// Angles from an edge to the plane across the largest tension and to the two on which Mohr and Coulomb's strength is used most, between -90° and 90°.
fn critical_angles(along: Point, [[xx, xy], [_, yy]]: Matrix, strength: &Strength) -> [f64; 3] {
    use std::f64::consts::{FRAC_PI_2, PI};
    // Directions of normals; that of an edge along t is (t_y, -t_x).
    let tension = 0.5 * libm::atan2(xy, 0.5 * (xx - yy));
    let edge = libm::atan2(-along[0], along[1]);
    let shear = 0.5 * (FRAC_PI_2 - libm::atan(strength.friction));
    [tension, tension + shear, tension - shear].map(|normal| {
        let angle = normal - edge;
        angle - PI * (angle / PI).round()
    })
}

/// Normal (tension positive) and tangential traction across an edge, Pa, from the mean stress of its two elements.
pub(crate) fn traction(solid: &Solid, edge: &Facet) -> [f64; 2] {
    traction_on(mean_stress(solid, edge), along(solid, edge))
}

/// Mean stress of the two elements at an edge, Pa.
pub(crate) fn mean_stress(solid: &Solid, edge: &Facet) -> Matrix {
    let [one, two] = edge.elements().map(|element| solid.strained[element as usize].stress);
    matrix(|i, k| 0.5 * (one[i][k] + two[i][k]))
}

/// Vector along an edge in the direction of side 0, m.
pub(crate) fn along(solid: &Solid, edge: &Facet) -> Point {
    let [a, b] = edge.corners[0].map(|corner| solid.at_corner(corner).position);
    minus(b, a)
}

/// Normal (tension positive) and tangential traction on a plane along a vector, Pa.
fn traction_on([[xx, xy], [_, yy]]: Matrix, along: Point) -> [f64; 2] {
    let squared = dot(along, along);
    // With tangent t and outward normal n = (t_y, -t_x).
    let [x, y] = along;
    let normal = (xx * y * y - 2.0 * xy * x * y + yy * x * x) / squared;
    let tangential = ((xx - yy) * x * y + xy * (y * y - x * x)) / squared;
    [normal, tangential]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cohesive::tests::ROCK;

    fn edge(degrees: f64) -> Point {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [2.0 * cos, 2.0 * sin]
    }

    /// Under tension along y, edges along x and up to the reach beside it fail together; farther ones later.
    #[test]
    fn edges_near_the_plane_of_tension_fail_with_it() {
        let stress = [[0.0, 0.0], [0.0, 1e6]];
        for (degrees, expected) in [(0.0, 1.0), (7.0, 1.0), (-14.0, 1.0), (30.0, 0.95), (-45.0, 0.78)] {
            let plane = plane_near(edge(degrees), stress, &ROCK);
            let used = use_of(&ROCK, traction_on(stress, edge(degrees))) * plane.excess;
            assert!((used - expected).abs() < 0.04, "{degrees} {used}");
            assert!((plane.area - degrees.abs().min(15.0).to_radians().cos()).abs() < 1e-9, "{degrees}");
        }
    }

    /// In compression, edges near the plane of Mohr and Coulomb fail under its strength, 2 c cos φ/(1 - sin φ).
    #[test]
    fn edges_near_the_plane_of_shear_fail_with_it() {
        let angle = ROCK.friction.atan();
        let stress = [[0.0, 0.0], [0.0, -2.0 * ROCK.cohesion * angle.cos() / (1.0 - angle.sin())]];
        let steepest = 45.0 + 0.5 * angle.to_degrees();
        for off in [0.0, 10.0, -14.0] {
            for degrees in [steepest + off, -steepest - off] {
                let plane = plane_near(edge(degrees), stress, &ROCK);
                let used = use_of(&ROCK, traction_on(stress, edge(degrees))) * plane.excess;
                assert!((used - 1.0).abs() < 1e-9, "{degrees} {used}");
            }
        }
        let across = plane_near(edge(0.0), stress, &ROCK);
        assert!(use_of(&ROCK, traction_on(stress, edge(0.0))) * across.excess < 0.5);
    }

    #[test]
    fn without_stress_or_strength_a_joint_stands_for_itself() {
        assert_eq!(plane_near(edge(20.0), [[0.0; 2]; 2], &ROCK), Plane::OWN);
        let open = Strength { tensile: 0.0, cohesion: 0.0, ..ROCK };
        assert_eq!(plane_near(edge(20.0), [[1e6, 3e5], [3e5, -1e6]], &open), Plane::OWN);
    }
}
