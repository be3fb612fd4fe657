//! Tractions on planes through a point of stressed material.

use crate::vector::{Matrix, Point, dot};

/// Normal (tension positive) and tangential traction on a plane along a vector, Pa.
pub(super) fn traction_along(along: Point, [[xx, xy], [_, yy]]: &Matrix) -> [f64; 2] {
    let squared = dot(along, along);
    // With tangent t and outward normal n = (t_y, -t_x).
    let [x, y] = along;
    let normal = (xx * y * y - 2.0 * xy * x * y + yy * x * x) / squared;
    let tangential = ((xx - yy) * x * y + xy * (y * y - x * x)) / squared;
    [normal, tangential]
}

/// Tractions on the critical planes, or as near to them as a plane along a vector comes when it turns by at
/// most `reach`, with the cosines of the angles.
pub(super) fn tractions_near(
    along: Point,
    stress: &Matrix,
    friction: f64,
    reach: f64,
) -> [([f64; 2], f64); 3] {
    critical_angles(along, stress, friction).map(|angle| {
        let (sin, cos) = libm::sincos(angle.clamp(-reach, reach));
        let turned = [cos * along[0] - sin * along[1], sin * along[0] + cos * along[1]];
        (traction_along(turned, stress), cos)
    })
}

/// Angles from an edge to the plane across the largest tension and to the two on which Mohr and Coulomb's
/// strength is used most, between -90° and 90°.
fn critical_angles(along: Point, [[xx, xy], [_, yy]]: &Matrix, friction: f64) -> [f64; 3] {
    use std::f64::consts::{FRAC_PI_2, PI};
    // Directions of normals; that of an edge along t is (t_y, -t_x).
    let tension = 0.5 * libm::atan2(*xy, 0.5 * (xx - yy));
    let edge = libm::atan2(-along[0], along[1]);
    let shear = 0.5 * (FRAC_PI_2 - libm::atan(friction));
    [tension, tension + shear, tension - shear].map(|normal| {
        let angle = normal - edge;
        angle - PI * (angle / PI).round()
    })
}
