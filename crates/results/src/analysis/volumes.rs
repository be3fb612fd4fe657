//! Area of a disc in a rectangle and volume of a sphere in a box, in closed form.

use std::f64::consts::PI;

use crate::arrays::each;

/// Area of the part of a disc inside a rectangle with sides along the axes. Limits may be infinite.
///
/// The area follows by inclusion and exclusion over the corners: each corner bounds a quadrant of the plane,
/// and the part of a disc in a quadrant has a closed form.
///
/// # Errors in the last digits
/// Some `1e-15` of the area of the disc.
///
/// # Example
/// ```
/// use std::f64::consts::PI;
/// let quarter = fdem_results::analysis::disc_in_rectangle([0.0, 0.0], 2.0, [[0.0, f64::INFINITY], [-9.0, 0.0]]);
/// assert!((quarter - PI).abs() < 1e-14);
/// ```
pub fn disc_in_rectangle(centre: [f64; 2], radius: f64, limits: [[f64; 2]; 2]) -> f64 {
    in_box(centre, radius, limits, PI, |[a, b]| quadrant(a, b)) * radius * radius
}

/// Volume of the part of a sphere inside a box with edges along the axes. Limits may be infinite.
///
/// The volume follows by inclusion and exclusion over the corners: each corner bounds an octant, and the part
/// of a sphere in an octant has a closed form.
///
/// # Errors in the last digits
/// Some `1e-14` of the volume of the sphere.
///
/// # Source
/// The divergence theorem over the plane faces, which are parts of discs, and the spherical face, whose area
/// follows from the theorem of Gauss and Bonnet. Other ways to the same volumes: B. Freireich, M. Kodam, C.
/// Wassgren, AIChE J. 56 (2010) 3036–3048; S. Strobl, A. Formella, T. Pöschel, J. Comput. Phys. 311 (2016)
/// 158–172.
///
/// # Example
/// ```
/// use std::f64::consts::PI;
/// let half = fdem_results::analysis::sphere_in_box([0.0; 3], 1.0, [[-9.0, 9.0], [-9.0, 9.0], [0.0, 9.0]]);
/// assert!((half - 2.0 * PI / 3.0).abs() < 1e-14);
/// ```
pub fn sphere_in_box(centre: [f64; 3], radius: f64, limits: [[f64; 2]; 3]) -> f64 {
    in_box(centre, radius, limits, 4.0 * PI / 3.0, |[a, b, c]| octant(a, b, c)) * radius.powi(3)
}

/// Area or volume of the part of a ball inside a box, in units of `radius^D`. `whole`: that of the unit ball;
/// `beyond`: that of its part beyond a corner.
fn in_box<const D: usize>(
    centre: [f64; D],
    radius: f64,
    limits: [[f64; 2]; D],
    whole: f64,
    beyond: impl Fn([f64; D]) -> f64,
) -> f64 {
    if limits.iter().any(|[low, high]| low >= high) || radius <= 0.0 {
        return 0.0;
    }
    // Limits outside of the ball have no effect.
    let scaled: [[f64; 2]; D] =
        each(|axis| each(|side| ((limits[axis][side] - centre[axis]) / radius).clamp(-1.0, 1.0)));
    if scaled.iter().all(|limits| *limits == [-1.0, 1.0]) {
        return whole;
    }
    if scaled.iter().any(|[low, high]| low == high) {
        return 0.0;
    }
    let mut sum = 0.0;
    for corner in 0..1_u32 << D {
        let at = each(|axis| scaled[axis][(corner >> axis & 1) as usize]);
        let part = beyond(at);
        sum += if corner.count_ones() % 2 == 0 { part } else { -part };
    }
    sum.clamp(0.0, whole)
}

/// Area of the part of the unit disc with `x >= a` and `y >= b`; both are in [-1, 1].
fn quadrant(a: f64, b: f64) -> f64 {
    if a < 0.0 {
        return segment(b) - quadrant(-a, b);
    }
    if b < 0.0 {
        return segment(a) - quadrant(a, -b);
    }
    corner_area(a, b, 1.0)
}

/// Area of the part of the unit disc with `x >= a`.
fn segment(a: f64) -> f64 {
    a.acos() - a * (1.0 - a * a).max(0.0).sqrt()
}

/// Area of the part of a disc with `x >= a >= 0` and `y >= b >= 0`: a sector minus two triangles.
fn corner_area(a: f64, b: f64, radius_squared: f64) -> f64 {
    if a * a + b * b >= radius_squared {
        return 0.0;
    }
    let (to_a, to_b) = ((radius_squared - a * a).sqrt(), (radius_squared - b * b).sqrt());
    (radius_squared * arc(a, b, radius_squared) - a * (to_a - b) - b * (to_b - a)) / 2.0
}

/// Angle of the arc of a circle with `x >= a >= 0` and `y >= b >= 0`.
fn arc(a: f64, b: f64, radius_squared: f64) -> f64 {
    let (to_a, to_b) = ((radius_squared - a * a).sqrt(), (radius_squared - b * b).sqrt());
    to_a.atan2(a) - b.atan2(to_b)
}

/// Volume of the part of the unit ball with `x >= a`, `y >= b` and `z >= c`; all are in [-1, 1].
fn octant(a: f64, b: f64, c: f64) -> f64 {
    if a < 0.0 {
        return wedge(b, c) - octant(-a, b, c);
    }
    if b < 0.0 {
        return wedge(a, c) - octant(a, -b, c);
    }
    if c < 0.0 {
        return wedge(a, b) - octant(a, b, -c);
    }
    corner_volume(a, b, c)
}

/// Volume of the part of the unit ball with `x >= a` and `y >= b`.
fn wedge(a: f64, b: f64) -> f64 {
    if a < 0.0 {
        return cap(b) - wedge(-a, b);
    }
    if b < 0.0 {
        return cap(a) - wedge(a, -b);
    }
    2.0 * corner_volume(a, b, 0.0)
}

/// Volume of the part of the unit ball with `x >= a`.
fn cap(a: f64) -> f64 {
    PI * (1.0 - a) * (1.0 - a) * (2.0 + a) / 3.0
}

/// Like [`octant`], for limits that are not negative: the sum over the faces of a third of their area times
/// their outward distance from the centre.
fn corner_volume(a: f64, b: f64, c: f64) -> f64 {
    if a * a + b * b + c * c >= 1.0 {
        return 0.0;
    }
    let mut flat = 0.0;
    // The spherical face is a triangle of arcs: its area is 2π minus the turning angles along its sides and
    // at its corners.
    let mut round = 2.0 * PI;
    for [x, y, z] in [[a, b, c], [b, c, a], [c, a, b]] {
        let radius_squared = 1.0 - x * x;
        flat += x * corner_area(y, z, radius_squared);
        round -= x * arc(y, z, radius_squared);
        round -= (-x * y / (radius_squared * (1.0 - y * y)).sqrt()).acos();
    }
    (round - flat) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume by exact areas of slices along x, with two Gauss-Legendre nodes in each interval.
    fn by_slices(limits: [[f64; 2]; 3]) -> f64 {
        const SLICES: usize = 20_000;
        let [low, high] = limits[0].map(|limit| limit.clamp(-1.0, 1.0));
        let width = (high - low) / SLICES as f64;
        let mut sum = 0.0;
        for slice in 0..SLICES {
            for node in [-1.0, 1.0] {
                let x = low + (slice as f64 + 0.5 + node / 12.0_f64.sqrt()) * width;
                let radius = (1.0 - x * x).max(0.0).sqrt();
                sum += disc_in_rectangle([0.0; 2], radius, [limits[1], limits[2]]) * width / 2.0;
            }
        }
        sum
    }

    #[test]
    fn volumes_are_those_of_slices() {
        let sides =
            [[-2.0, 0.3], [-0.7, 0.1], [0.2, 0.9], [-0.4, 2.0], [0.55, 3.0], [-0.95, -0.2], [-9.0, 9.0]];
        for x in sides {
            for y in sides {
                for z in sides {
                    let exact = sphere_in_box([0.0; 3], 1.0, [x, y, z]);
                    let sliced = by_slices([x, y, z]);
                    assert!((exact - sliced).abs() < 2e-7, "{x:?} {y:?} {z:?}: {exact}, {sliced}");
                }
            }
        }
    }

    #[test]
    fn parts_add_up_to_the_whole() {
        let cuts = [f64::NEG_INFINITY, 0.1, 0.25, 0.75, 1.3, f64::INFINITY];
        let (centre, radius) = ([0.31, 0.77, 0.5], 0.6);
        let (mut volume, mut area) = (0.0, 0.0);
        for x in cuts.windows(2) {
            for y in cuts.windows(2) {
                area += disc_in_rectangle([0.31, 0.77], radius, [[x[0], x[1]], [y[0], y[1]]]);
                for z in cuts.windows(2) {
                    volume += sphere_in_box(centre, radius, [[x[0], x[1]], [y[0], y[1]], [z[0], z[1]]]);
                }
            }
        }
        assert!((area / (PI * 0.36) - 1.0).abs() < 1e-14);
        assert!((volume / (4.0 / 3.0 * PI * 0.216) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn edges_of_the_ball_are_no_trouble() {
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!(sphere_in_box([0.0; 3], 1.0, [[1.0, 2.0], all, all]), 0.0);
        assert_eq!(sphere_in_box([0.0; 3], 1.0, [[-1.0, 1.0]; 3]), 4.0 * PI / 3.0);
        assert_eq!(sphere_in_box([0.0; 3], 0.0, [all; 3]), 0.0);
        assert_eq!(sphere_in_box([0.0; 3], 1.0, [[0.5, 0.5], all, all]), 0.0);
        // A cube that fits inside.
        assert!((sphere_in_box([0.0; 3], 1.0, [[-0.5, 0.5]; 3]) - 1.0).abs() < 1e-14);
        // Its corners touch the sphere.
        let side = (1.0_f64 / 3.0).sqrt();
        assert!((sphere_in_box([0.0; 3], 1.0, [[-side, side]; 3]) - 8.0 * side.powi(3)).abs() < 1e-14);
        assert!((disc_in_rectangle([0.0; 2], 1.0, [[-0.5, 0.5]; 2]) - 1.0).abs() < 1e-15);
    }
}
