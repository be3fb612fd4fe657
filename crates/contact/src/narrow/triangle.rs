//! Triangles in 3D.

use super::contact::{Contact, Measure};
use super::exact::{collinear, orient3d};
use super::polygon::{coplanar_touch, flatten, hull_hull};
use super::segment::{closest as closest_of_segments, segments_touch};
use super::shapes::Triangle;
use super::sphere::foot;
use super::vector::{
    add, before, between, cross, distance_squared, dot, middle, neg, perpendicular, sub, unit,
};

/// Two triangles in 3D: gap, or length or area of the common part.
///
/// Whether they touch, and whether they are coplanar, is decided exactly. Coplanar triangles have
/// [`Measure::Area`]; all others, and triangles without area, have [`Measure::Length`]; both may be 0. The
/// point is the middle of the common segment or the centroid of the common area; for a gap it is the middle
/// between the closest points. The normal of a touch is the normal of the first triangle (of the second if
/// the first has no area; perpendicular to both if neither has), turned to the side of the centroid of the
/// second. The normal of a gap is the direction of the gap. The errors of gap and length are 64 rounding
/// steps of the largest coordinate; for the length divided by the sine of the angle between the planes.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Measure, Triangle, triangle_triangle};
///
/// let a = Triangle::new([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]])?;
/// let b = Triangle::new([[1.0, 1.0, -1.0], [1.0, 1.0, 3.0], [9.0, 1.0, -1.0]])?;
/// let contact = triangle_triangle(&a, &b);
/// assert_eq!((contact.measure, contact.point), (Measure::Length(2.0), [2.0, 1.0, 0.0]));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn triangle_triangle(a: &Triangle<3>, b: &Triangle<3>) -> Contact<3> {
    let (p, q) = (&a.vertices, &b.vertices);
    if !triangles_touch(p, q) {
        let (from, to) = closest(p, q);
        return Contact {
            point: middle(from, to),
            normal: unit(sub(to, from)).unwrap_or_else(|| normal(p, q)),
            measure: Measure::Gap(distance_squared(from, to).sqrt()),
        };
    }
    let normal = normal(p, q);
    let flat =
        !is_collinear(p) && !is_collinear(q) && q.iter().all(|&d| orient3d(p[0], p[1], p[2], d) == 0.0);
    if flat {
        let (area, point) = coplanar_overlap(p, q);
        return Contact { point, normal, measure: Measure::Area(area) };
    }
    let [from, to] = common_segment(p, q);
    Contact { point: middle(from, to), normal, measure: Measure::Length(distance_squared(from, to).sqrt()) }
}

impl Triangle<3> {
    /// Whether the closed triangles have a point in common, decided exactly.
    pub fn touches(&self, other: &Self) -> bool {
        triangles_touch(&self.vertices, &other.vertices)
    }
}

pub(super) fn is_collinear(&[a, b, c]: &[[f64; 3]; 3]) -> bool {
    collinear(a, b, c)
}

/// The ends of a triangle without area.
fn ends(triangle: &[[f64; 3]; 3]) -> [[f64; 3]; 2] {
    let [mut low, mut high] = [triangle[0]; 2];
    for &p in triangle {
        low = if before(p, low) { p } else { low };
        high = if before(high, p) { p } else { high };
    }
    [low, high]
}

fn edges(&[a, b, c]: &[[f64; 3]; 3]) -> [[[f64; 3]; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Whether two closed triangles have a point in common. If they do, an edge of one touches the other.
pub(super) fn triangles_touch(p: &[[f64; 3]; 3], q: &[[f64; 3]; 3]) -> bool {
    // All vertices are strictly on one side of the plane of the other. For a triangle without area, all
    // points are in its planes.
    let sides = |p: &[[f64; 3]; 3], q: &[[f64; 3]; 3]| q.map(|d| orient3d(p[0], p[1], p[2], d));
    let apart = |s: [f64; 3]| s.iter().all(|&x| x > 0.0) || s.iter().all(|&x| x < 0.0);
    let of_q = sides(p, q);
    if apart(of_q) {
        return false;
    }
    let of_p = sides(q, p);
    if apart(of_p) {
        return false;
    }
    match (of_q == [0.0; 3] && is_collinear(p), of_p == [0.0; 3] && is_collinear(q)) {
        (true, true) => segments_touch(ends(p), ends(q)),
        (true, false) => edge_touches(ends(p), q),
        (false, true) => edge_touches(ends(q), p),
        (false, false) => {
            edges(p).into_iter().any(|edge| edge_touches(edge, q))
                || edges(q).into_iter().any(|edge| edge_touches(edge, p))
        }
    }
}

/// Whether a closed segment, or point, touches a closed triangle with area.
fn edge_touches([p, q]: [[f64; 3]; 2], triangle: &[[f64; 3]; 3]) -> bool {
    let &[a, b, c] = triangle;
    let (from, to) = (orient3d(a, b, c, p), orient3d(a, b, c, q));
    edge_touches_sides([p, q], [from, to], triangle)
}

/// The same for ends whose sides of the plane of the triangle are known.
pub(super) fn edge_touches_sides(
    [p, q]: [[f64; 3]; 2],
    [from, to]: [f64; 2],
    triangle: &[[f64; 3]; 3],
) -> bool {
    let &[a, b, c] = triangle;
    if (from > 0.0 && to > 0.0) || (from < 0.0 && to < 0.0) {
        return false;
    }
    if from == 0.0 && to == 0.0 {
        return coplanar_touch(&[p, q], triangle);
    }
    // The line crosses the plane once. The point is inside the triangle if all edges pass the line on the
    // same side.
    let turns = [orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)];
    turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
}

/// The normal of a touch.
fn normal(p: &[[f64; 3]; 3], q: &[[f64; 3]; 3]) -> [f64; 3] {
    let of = |t: &[[f64; 3]; 3]| {
        if is_collinear(t) { None } else { unit(cross(sub(t[1], t[0]), sub(t[2], t[0]))) }
    };
    let normal = of(p).or_else(|| of(q)).unwrap_or_else(|| {
        let ([a, b], [c, d]) = (ends(p), ends(q));
        let (u, v) = (sub(b, a), sub(d, c));
        unit(cross(u, v)).unwrap_or_else(|| perpendicular(if dot(u, u) >= dot(v, v) { u } else { v }))
    });
    // Relative to a vertex of the first triangle, because the side of its plane matters.
    let way = q.iter().fold([0.0; 3], |sum, &d| add(sum, sub(d, p[0])));
    let way = if of(p).is_some() {
        way
    } else {
        sub(way, p.iter().fold([0.0; 3], |sum, &d| add(sum, sub(d, p[0]))))
    };
    if dot(normal, way) < 0.0 { neg(normal) } else { normal }
}

/// Area and centroid of the common part of two coplanar triangles, in the projection in which the first is
/// largest.
fn coplanar_overlap(p: &[[f64; 3]; 3], q: &[[f64; 3]; 3]) -> (f64, [f64; 3]) {
    let n = cross(sub(p[1], p[0]), sub(p[2], p[0]));
    let mut axis = 0;
    for k in 1..3 {
        if n[k].abs() > n[axis].abs() {
            axis = k;
        }
    }
    let mut overlap = Vec::new();
    let flat = hull_hull(flatten(p, axis).points(), flatten(q, axis).points(), &mut overlap);
    // The coordinate that was left out, from the plane n · (x - p) = 0.
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let (u, v) = (flat.point[0] - p[0][j], flat.point[1] - p[0][k]);
    let mut point = [0.0; 3];
    point[j] = flat.point[0];
    point[k] = flat.point[1];
    point[axis] = p[0][axis] - (n[j] / n[axis]) * u - (n[k] / n[axis]) * v;
    let (y, z) = (n[j] / n[axis], n[k] / n[axis]);
    (flat.measure.value() * (1.0 + y * y + z * z).sqrt(), point)
}

/// The ends of the common part of two touching triangles that are not coplanar: the points where edges of one
/// meet the other.
fn common_segment(p: &[[f64; 3]; 3], q: &[[f64; 3]; 3]) -> [[f64; 3]; 2] {
    let mut points: Vec<[f64; 3]> = Vec::with_capacity(12);
    for (own, other) in [(p, q), (q, p)] {
        let flat = is_collinear(other);
        for [a, b] in edges(own) {
            if flat {
                let [c, d] = ends(other);
                if segments_touch([a, b], [c, d]) {
                    for (end, of) in [(a, [c, d]), (b, [c, d]), (c, [a, b]), (d, [a, b])] {
                        points.extend(segments_touch([end, end], of).then_some(end));
                    }
                    let (from, to) = closest_of_segments([a, b], [c, d]);
                    points.push(middle(from, to));
                }
                continue;
            }
            let (from, to) =
                (orient3d(other[0], other[1], other[2], a), orient3d(other[0], other[1], other[2], b));
            if !edge_touches_sides([a, b], [from, to], other) {
                continue;
            }
            if from != to {
                points.push(if to == 0.0 { b } else { between(a, b, from / (from - to)) });
                continue;
            }
            // In the plane of the other triangle: ends of the edge inside it, and crossings with its edges.
            for end in [a, b] {
                points.extend(coplanar_touch(&[end], other).then_some(end));
            }
            for [c, d] in edges(other) {
                if segments_touch([a, b], [c, d]) {
                    let (from, to) = closest_of_segments([a, b], [c, d]);
                    points.push(middle(from, to));
                }
            }
        }
    }
    let first = points.first().copied().unwrap_or_else(|| {
        let (from, to) = closest(p, q);
        middle(from, to)
    });
    let mut farthest = [first, first];
    let mut most = 0.0;
    for (k, &from) in points.iter().enumerate() {
        for &to in &points[k + 1..] {
            let squared = distance_squared(from, to);
            if squared > most {
                (farthest, most) = ([from, to], squared);
            }
        }
    }
    farthest
}

/// The closest points of two separate triangles: points of two edges, or a vertex of one and a point of the
/// other.
pub(super) fn closest(p: &[[f64; 3]; 3], q: &[[f64; 3]; 3]) -> ([f64; 3], [f64; 3]) {
    let mut best = (p[0], q[0]);
    let mut least = f64::INFINITY;
    let mut consider = |pair: ([f64; 3], [f64; 3]), squared: f64| {
        if squared < least {
            (best, least) = (pair, squared);
        }
    };
    for &c in p {
        let foot = foot(c, q);
        consider((c, foot.point), foot.squared);
    }
    for &c in q {
        let foot = foot(c, p);
        consider((foot.point, c), foot.squared);
    }
    for own in edges(p) {
        for other in edges(q) {
            let pair = closest_of_segments(own, other);
            consider(pair, distance_squared(pair.0, pair.1));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(vertices: [[f64; 3]; 3]) -> Triangle<3> {
        Triangle::new(vertices).unwrap()
    }

    #[test]
    fn shared_vertices_and_edges_touch() {
        let a = triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let edge = triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        let contact = triangle_triangle(&a, &edge);
        assert_eq!((contact.measure, contact.point), (Measure::Length(1.0), [0.5, 0.0, 0.0]));
        assert_eq!(contact.normal, [0.0, 0.0, 1.0]);
        let vertex = triangle([[1.0, 0.0, 0.0], [2.0, 0.0, 1.0], [2.0, 1.0, 1.0]]);
        let contact = triangle_triangle(&a, &vertex);
        assert_eq!((contact.measure, contact.point), (Measure::Length(0.0), [1.0, 0.0, 0.0]));
        let same = triangle_triangle(&a, &a);
        assert_eq!(same.measure, Measure::Area(0.5));
        assert!(distance_squared(same.point, [1.0 / 3.0, 1.0 / 3.0, 0.0]) < 1e-30);
    }

    #[test]
    fn coplanar_triangles_have_an_area() {
        // In the plane x + y + z = 6.
        let a = triangle([[6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]]);
        let b = triangle([[2.0, 2.0, 2.0], [4.0, 2.0, 0.0], [2.0, 4.0, 0.0]]);
        let contact = triangle_triangle(&a, &b);
        let Measure::Area(area) = contact.measure else { panic!("{contact:?}") };
        assert!((area - 2.0 * 3.0_f64.sqrt()).abs() < 1e-14, "{area}");
        assert!(
            distance_squared(contact.point, [8.0 / 3.0, 8.0 / 3.0, 2.0 / 3.0]) < 1e-28,
            "{:?}",
            contact.point
        );
        let far = triangle([[7.0, 0.0, -1.0], [8.0, 0.0, -2.0], [7.0, 1.0, -2.0]]);
        assert!(!a.touches(&far));
    }

    #[test]
    fn triangles_without_area_are_segments_and_points() {
        let a = triangle([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let through = triangle([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]]);
        let along = triangle([[-1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
        let point = triangle([[2.0, 2.0, 0.0]; 3]);
        for (b, length, at) in
            [(through, 0.0, [1.0, 1.0, 0.0]), (along, 3.0, [1.5, 1.0, 0.0]), (point, 0.0, [2.0, 2.0, 0.0])]
        {
            for contact in [triangle_triangle(&a, &b), triangle_triangle(&b, &a)] {
                assert_eq!((contact.measure, contact.point), (Measure::Length(length), at));
                assert_eq!(contact.normal[2].abs(), 1.0);
            }
        }
        let contact = triangle_triangle(&through, &along);
        assert_eq!((contact.measure, contact.point), (Measure::Length(0.0), [1.0, 1.0, 0.0]));
        assert!(!point.touches(&triangle([[2.0, 2.0, 1.0]; 3])));
        assert!(point.touches(&point));
    }
}
