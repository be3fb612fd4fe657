//! Segments and capsules.

use super::contact::{Contact, Measure};
use super::exact::orient3d;
use super::polygon::coplanar_touch;
use super::shapes::{Capsule, Segment};
use super::sphere::depth_or_gap;
use super::vector::{
    add, before, between, cross, distance_squared, dot, middle, neg, perpendicular, scale, sub, unit,
};

/// Two segments: gap, or length of the common part.
///
/// Whether they touch is decided exactly. The length is 0 if they cross or meet in a point. The point is the
/// middle of the common part or of the gap. The normal of a touch is perpendicular to both segments, and x
/// for two points. The error of the gap is 16 rounding steps of the largest coordinate, also for parallel and
/// nearly parallel segments. The error of the point is such a step divided by the sine of the angle.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Measure, Segment, segment_segment};
///
/// let a = Segment::new([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]])?;
/// let b = Segment::new([[3.0, 0.0, 0.0], [9.0, 0.0, 0.0]])?;
/// let contact = segment_segment(&a, &b);
/// assert_eq!((contact.measure, contact.point), (Measure::Length(1.0), [3.5, 0.0, 0.0]));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn segment_segment(a: &Segment, b: &Segment) -> Contact<3> {
    let (p, q) = closest(a.ends, b.ends);
    if !segments_touch(a.ends, b.ends) {
        let normal = unit(sub(q, p)).unwrap_or_else(|| across(a.ends, b.ends));
        let gap = distance_squared(p, q).sqrt();
        return Contact { point: middle(p, q), normal, measure: Measure::Gap(gap) };
    }
    let common = common(a.ends, b.ends).unwrap_or([p, q]);
    let length = if common == [p, q] { 0.0 } else { distance_squared(common[0], common[1]).sqrt() };
    Contact {
        point: middle(common[0], common[1]),
        normal: across(a.ends, b.ends),
        measure: Measure::Length(length),
    }
}

/// Two capsules: gap or depth.
///
/// Let `d` be the distance of [`segment_segment`] between the axes, 0 if these touch. The capsules touch if
/// `d · d <= (r_1 + r_2)²`. The depth is `r_1 + r_2 - d`, the smallest translation that separates them. The
/// point is the middle of the overlap or gap, on the shortest line between the axes. If the axes touch, the
/// normal is that of [`segment_segment`]. The errors are as there.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Capsule, Measure, capsule_capsule};
///
/// let a = Capsule::new([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], 0.5)?;
/// let b = Capsule::new([[0.0, -1.0, 1.0], [0.0, 1.0, 1.0]], 0.75)?;
/// let contact = capsule_capsule(&a, &b);
/// assert_eq!((contact.measure, contact.normal), (Measure::Depth(0.25), [0.0, 0.0, 1.0]));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn capsule_capsule(a: &Capsule, b: &Capsule) -> Contact<3> {
    let axes = segment_segment(&a.axis, &b.axis);
    let reach = a.radius + b.radius;
    let distance = if let Measure::Gap(gap) = axes.measure { gap } else { 0.0 };
    let depth = reach - distance;
    // Moves from the middle between the axes to the middle between the surfaces.
    let shift = 0.5 * (a.radius - b.radius);
    Contact {
        point: add(axes.point, scale(axes.normal, shift)),
        normal: axes.normal,
        measure: depth_or_gap(distance * distance <= reach * reach, depth),
    }
}

/// Whether two segments have a point in common, decided exactly.
pub(super) fn segments_touch(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> bool {
    orient3d(a[0], a[1], b[0], b[1]) == 0.0 && coplanar_touch(&a, &b)
}

/// Two closest points, one of each segment.
pub(super) fn closest(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> ([f64; 3], [f64; 3]) {
    let (u, v, w) = (sub(a[1], a[0]), sub(b[1], b[0]), sub(b[0], a[0]));
    let foot = |p: [f64; 3], [low, high]: [[f64; 3]; 2]| {
        let direction = sub(high, low);
        let length = dot(direction, direction);
        let t = if length > 0.0 { dot(sub(p, low), direction) / length } else { 0.0 };
        between(low, high, t.clamp(0.0, 1.0))
    };
    let mut best = (a[0], foot(a[0], b));
    let mut least = distance_squared(best.0, best.1);
    let mut consider = |pair: ([f64; 3], [f64; 3])| {
        let squared = distance_squared(pair.0, pair.1);
        if squared < least {
            (best, least) = (pair, squared);
        }
    };
    consider((a[1], foot(a[1], b)));
    consider((foot(b[0], a), b[0]));
    consider((foot(b[1], a), b[1]));
    // Both feet are inside: the common perpendicular. It is computed from the cross product, not from
    // (u·u)(v·v) - (u·v)², which loses the small angle between nearly parallel segments to cancellation.
    let n = cross(u, v);
    let squared = dot(n, n);
    if squared > 0.0 {
        let (s, t) = (dot(cross(w, v), n) / squared, dot(cross(w, u), n) / squared);
        if s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0 {
            consider((between(a[0], a[1], s), between(b[0], b[1], t)));
        }
    }
    best
}

/// The ends of the common part of two touching segments if no division is needed: a piece of one line, or an
/// end.
fn common(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> Option<[[f64; 3]; 2]> {
    let mut points: Option<[[f64; 3]; 2]> = None;
    for (p, other) in [(a[0], b), (a[1], b), (b[0], a), (b[1], a)] {
        if coplanar_touch(&[p], &other) {
            let [first, last] = points.unwrap_or([p, p]);
            points = Some([if before(p, first) { p } else { first }, if before(last, p) { p } else { last }]);
        }
    }
    points
}

/// A direction perpendicular to two segments, from the middle of the first towards that of the second if
/// these differ along it.
fn across(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> [f64; 3] {
    let (u, v) = (sub(a[1], a[0]), sub(b[1], b[0]));
    let longer = if dot(u, u) >= dot(v, v) { u } else { v };
    let normal = unit(cross(u, v)).unwrap_or_else(|| perpendicular(longer));
    let way = sub(middle(b[0], b[1]), middle(a[0], a[1]));
    if dot(normal, way) < 0.0 { neg(normal) } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(ends: [[f64; 3]; 2]) -> Segment {
        Segment::new(ends).unwrap()
    }

    #[test]
    fn degenerate_segments_have_an_answer() {
        let point = segment([[1.0, 0.0, 0.0]; 2]);
        let line = segment([[0.0; 3], [2.0, 0.0, 0.0]]);
        for (a, b) in [(point, point), (point, line), (line, point)] {
            let contact = segment_segment(&a, &b);
            assert_eq!((contact.measure, contact.point), (Measure::Length(0.0), [1.0, 0.0, 0.0]));
            assert_eq!(dot(contact.normal, contact.normal), 1.0);
        }
        assert_eq!(segment_segment(&line, &line).measure, Measure::Length(2.0));
        let above = segment([[1.0, 0.0, 3.0]; 2]);
        let contact = segment_segment(&above, &line);
        assert_eq!((contact.measure, contact.normal), (Measure::Gap(3.0), [0.0, 0.0, -1.0]));
    }

    #[test]
    fn a_crossing_has_no_length_and_a_normal_across() {
        let a = segment([[0.0; 3], [3.0, 3.0, 0.0]]);
        let b = segment([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
        let contact = segment_segment(&a, &b);
        assert_eq!((contact.measure, contact.point), (Measure::Length(0.0), [0.5, 0.5, 0.0]));
        assert_eq!(contact.normal[2].abs(), 1.0);
    }

    #[test]
    fn segments_of_one_line_that_are_apart_do_not_touch() {
        let a = segment([[0.0; 3], [1.0; 3]]);
        let contact = segment_segment(&a, &segment([[2.0; 3], [3.0; 3]]));
        assert!(matches!(contact.measure, Measure::Gap(gap) if (gap - 3.0_f64.sqrt()).abs() < 1e-15));
    }

    #[test]
    fn a_hair_of_an_angle_does_not_spoil_the_gap() {
        // The lines cross at (0, 0), 1e-7 apart in z, at an angle of 2e-9.
        let a = segment([[-1.0, -1e-9, 0.0], [1.0, 1e-9, 0.0]]);
        let b = segment([[-1.0, 1e-9, 1e-13], [1.0, -1e-9, 1e-13]]);
        let Measure::Gap(gap) = segment_segment(&a, &b).measure else { panic!("they are apart") };
        assert!((gap - 1e-13).abs() < 1e-15, "{gap}");
    }

    #[test]
    fn capsules_without_radius_or_length_are_segments_and_spheres() {
        let ball = Capsule::new([[0.0; 3]; 2], 1.0).unwrap();
        let other = Capsule::new([[3.0, 0.0, 0.0]; 2], 2.0).unwrap();
        let contact = capsule_capsule(&ball, &other);
        assert_eq!((contact.measure, contact.point), (Measure::Depth(0.0), [1.0, 0.0, 0.0]));
        let same = capsule_capsule(&ball, &ball);
        assert_eq!((same.measure, same.normal), (Measure::Depth(2.0), [1.0, 0.0, 0.0]));
    }
}
