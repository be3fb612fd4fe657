//! Convex polygons and triangles in 2D.
//!
//! All functions below work on hulls: one point, the two ends of a segment in ascending order, or the
//! vertices of a polygon that turns left at each of them.

use super::contact::{Contact, Measure};
use super::error::ShapeError;
use super::exact::{orient2d, project};
use super::shapes::{Triangle, check_all};
use super::vector::{before, between, distance_squared, dot, middle, neg, sub, unit, x_axis};

/// A convex polygon in 2D, in either orientation. Without area it is the segment or point that its vertices
/// span.
///
/// Repeated vertices and vertices on a straight side are allowed and removed.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{ConvexPolygon, ShapeError};
///
/// let square = ConvexPolygon::new(&[[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])?;
/// assert_eq!(square.vertices().len(), 4); // to the left now
/// let dart = ConvexPolygon::new(&[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]]);
/// assert_eq!(dart, Err(ShapeError::NotConvex { vertex: 3 }));
/// # Ok::<(), ShapeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPolygon {
    hull: Vec<[f64; 2]>,
}

impl ConvexPolygon {
    /// Makes a polygon from its vertices in order.
    ///
    /// # Shapes
    /// `vertices` `[n]` points, with `n` at least 1.
    ///
    /// # Errors
    /// [`ShapeError::NoVertices`], [`ShapeError::Coordinate`], [`ShapeError::NotConvex`]; the last is decided
    /// exactly.
    pub fn new(vertices: &[[f64; 2]]) -> Result<Self, ShapeError> {
        check_all(vertices)?;
        let mut kept: Vec<usize> = Vec::with_capacity(vertices.len());
        for (k, &p) in vertices.iter().enumerate() {
            if kept.last().is_none_or(|&last| vertices[last] != p) {
                kept.push(k);
            }
        }
        while kept.len() > 1 && vertices[kept[0]] == vertices[kept[kept.len() - 1]] {
            kept.pop();
        }
        let Some(&first) = kept.first() else { return Err(ShapeError::NoVertices) };
        let first = vertices[first];
        let turn = |a: usize, b: usize, c: usize| orient2d(vertices[a], vertices[b], vertices[c]);
        if kept.windows(2).all(|pair| orient2d(first, vertices[kept[1]], vertices[pair[1]]) == 0.0) {
            return Ok(Self { hull: ends(vertices) });
        }
        let n = kept.len();
        let mut hull = Vec::with_capacity(n);
        let mut sense = 0.0;
        for k in 0..n {
            let (a, b, c) = (kept[(k + n - 1) % n], kept[k], kept[(k + 1) % n]);
            let sign = turn(a, b, c);
            if sign == 0.0 {
                // Does the boundary go straight on, or back?
                let (to, on) = (before(vertices[a], vertices[b]), before(vertices[b], vertices[c]));
                if to != on {
                    return Err(ShapeError::NotConvex { vertex: b });
                }
                continue;
            }
            if sense != 0.0 && (sign > 0.0) != (sense > 0.0) {
                return Err(ShapeError::NotConvex { vertex: b });
            }
            sense = sign;
            hull.push(b);
        }
        // On one turn around a convex polygon, the edges go forward once and back once in the order of
        // points; on a star they do so more often.
        let m = hull.len();
        let forward = |k: usize| before(vertices[hull[k % m]], vertices[hull[(k + 1) % m]]);
        let mut changes = (0..m).filter(|&k| forward(k) != forward(k + 1));
        if let Some(third) = changes.nth(2) {
            return Err(ShapeError::NotConvex { vertex: hull[(third + 1) % m] });
        }
        let mut hull: Vec<[f64; 2]> = hull.into_iter().map(|k| vertices[k]).collect();
        if sense < 0.0 {
            hull.reverse();
        }
        Ok(Self { hull })
    }

    /// The corners, turning left; two ends or one point if the polygon has no area.
    pub fn vertices(&self) -> &[[f64; 2]] {
        &self.hull
    }

    /// Whether the closed polygons have a point in common, decided exactly. Takes time proportional to the
    /// product of their numbers of corners.
    pub fn touches(&self, other: &Self) -> bool {
        hulls_touch(&self.hull, &other.hull)
    }
}

impl Triangle<2> {
    /// Whether the closed triangles have a point in common, decided exactly.
    pub fn touches(&self, other: &Self) -> bool {
        hulls_touch(hull(&self.vertices).points(), hull(&other.vertices).points())
    }
}

/// Two triangles in 2D: gap, or area and overlap polygon; see [`polygon_polygon`].
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Measure, Triangle, triangle_triangle_2d};
///
/// let a = Triangle::new([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])?;
/// let b = Triangle::new([[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])?;
/// let mut overlap = Vec::new();
/// let contact = triangle_triangle_2d(&a, &b, &mut overlap);
/// assert_eq!((contact.measure, overlap.len()), (Measure::Area(0.5), 3));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn triangle_triangle_2d(a: &Triangle<2>, b: &Triangle<2>, overlap: &mut Vec<[f64; 2]>) -> Contact<2> {
    hull_hull(hull(&a.vertices).points(), hull(&b.vertices).points(), overlap)
}

/// Two convex polygons: gap, or area and overlap polygon.
///
/// Whether the polygons touch and whether the area is 0 are decided exactly. The point of a touch is the
/// centroid of the overlap, or the middle of the shared segment; for a gap it is the middle between the
/// closest points. The normal of a touch is that of the edge along which the smallest translation separates
/// the polygons; among equal ones the edges of the first polygon come first. The normal of a gap is the
/// direction of the gap, or x if the closest points coincide. `overlap` is cleared, then filled with the
/// corners of the overlap, turning left: two ends or one point if the polygons only just touch.
///
/// # Units
/// The gap has the unit of the coordinates, the area its square. Errors: 32 rounding steps of the largest
/// coordinate `m` for points and gap, `8 (n + 4) ε m l` for an area whose perimeter is `l`, with `n` corners
/// and `ε = 2^-52`.
///
/// # Cost
/// Time proportional to the product of the numbers of corners.
///
/// # Source
/// I.E. Sutherland, G.W. Hodgman, "Reentrant polygon clipping", Communications of the ACM 17 (1974) 32–42.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{ConvexPolygon, Measure, polygon_polygon};
///
/// let a = ConvexPolygon::new(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])?;
/// let b = ConvexPolygon::new(&[[1.5, 1.0], [3.0, 1.0], [3.0, 3.0], [1.5, 3.0]])?;
/// let mut overlap = Vec::new();
/// let contact = polygon_polygon(&a, &b, &mut overlap);
/// assert_eq!((contact.measure, contact.point), (Measure::Area(0.5), [1.75, 1.5]));
/// assert_eq!(contact.normal, [1.0, 0.0]);
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn polygon_polygon(a: &ConvexPolygon, b: &ConvexPolygon, overlap: &mut Vec<[f64; 2]>) -> Contact<2> {
    hull_hull(&a.hull, &b.hull, overlap)
}

/// The hull of up to three points.
pub(super) struct Hull {
    corners: [[f64; 2]; 3],
    n: usize,
}

impl Hull {
    pub(super) fn points(&self) -> &[[f64; 2]] {
        &self.corners[..self.n]
    }
}

/// The hull of one to three points, in the form described above.
pub(super) fn hull(points: &[[f64; 2]]) -> Hull {
    if let [a, b, c] = *points {
        let turn = orient2d(a, b, c);
        if turn != 0.0 {
            return Hull { corners: if turn > 0.0 { [a, b, c] } else { [a, c, b] }, n: 3 };
        }
    }
    let (mut low, mut high) = (points[0], points[0]);
    for &p in points {
        low = if before(p, low) { p } else { low };
        high = if before(high, p) { p } else { high };
    }
    Hull { corners: [low, high, high], n: if low == high { 1 } else { 2 } }
}

/// The first and last of points on one line.
fn ends(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let low = points.iter().copied().reduce(|a, b| if before(b, a) { b } else { a });
    let high = points.iter().copied().reduce(|a, b| if before(a, b) { b } else { a });
    let mut ends: Vec<_> = low.into_iter().chain(high).collect();
    ends.dedup();
    ends
}

/// The edges of a hull, counter-clockwise; a segment has two, a point has none.
fn edges(hull: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    let n = if hull.len() > 1 { hull.len() } else { 0 };
    (0..n).map(move |k| (hull[k], hull[(k + 1) % n]))
}

/// Whether two hulls touch, decided exactly. Two convex sets are separate if and only if one has an edge with
/// the other strictly beyond it, because the difference of the sets is a polygon with the edges of both. If
/// both sets are on one line, their order on it decides.
pub(super) fn hulls_touch(p: &[[f64; 2]], q: &[[f64; 2]]) -> bool {
    let beyond =
        |p: &[[f64; 2]], q: &[[f64; 2]]| edges(p).any(|(a, b)| q.iter().all(|&c| orient2d(a, b, c) < 0.0));
    if beyond(p, q) || beyond(q, p) {
        return false;
    }
    if p.len() > 2 || q.len() > 2 {
        return true;
    }
    let (a, b) = if p.len() == 2 { (p[0], p[1]) } else { (q[0], q[q.len() - 1]) };
    if p.iter().chain(q).any(|&c| orient2d(a, b, c) != 0.0) {
        return true;
    }
    !before(p[p.len() - 1], q[0]) && !before(q[q.len() - 1], p[0])
}

/// Whether the interiors of two hulls have a point in common, decided exactly.
fn interiors_meet(p: &[[f64; 2]], q: &[[f64; 2]]) -> bool {
    let beyond =
        |p: &[[f64; 2]], q: &[[f64; 2]]| edges(p).any(|(a, b)| q.iter().all(|&c| orient2d(a, b, c) <= 0.0));
    p.len() > 2 && q.len() > 2 && !beyond(p, q) && !beyond(q, p)
}

pub(super) fn hull_hull(p: &[[f64; 2]], q: &[[f64; 2]], overlap: &mut Vec<[f64; 2]>) -> Contact<2> {
    overlap.clear();
    let normal = normal_of_least_move(p, q);
    if !hulls_touch(p, q) {
        let (a, b) = closest(p, q);
        let gap = distance_squared(a, b).sqrt();
        return Contact {
            point: middle(a, b),
            normal: unit(sub(b, a)).unwrap_or(normal),
            measure: Measure::Gap(gap),
        };
    }
    if interiors_meet(p, q) {
        clip(p, q, overlap);
        if let Some((area, centroid)) = area_and_centroid(overlap) {
            return Contact { point: centroid, normal, measure: Measure::Area(area) };
        }
    }
    // The hulls have only a segment or a point in common, or an area too small to distinguish from one.
    let common = shared(p, q).unwrap_or_else(|| {
        let (a, b) = closest(p, q);
        [middle(a, b); 2]
    });
    overlap.clear();
    overlap.extend(common);
    overlap.dedup();
    Contact { point: middle(common[0], common[1]), normal, measure: Measure::Area(0.0) }
}

/// The part of `p` to the left of all edges of `q`.
fn clip(p: &[[f64; 2]], q: &[[f64; 2]], overlap: &mut Vec<[f64; 2]>) {
    overlap.extend(p);
    let mut rest = Vec::with_capacity(p.len() + q.len());
    for (a, b) in edges(q) {
        rest.clear();
        for (c, d) in edges(overlap) {
            let (from, to) = (orient2d(a, b, c), orient2d(a, b, d));
            if from >= 0.0 {
                rest.push(c);
            }
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                // The intersection is computed from the same end for both directions of the edge.
                let cut = if from > 0.0 {
                    between(c, d, from / (from - to))
                } else {
                    between(d, c, to / (to - from))
                };
                rest.push(cut);
            }
        }
        rest.dedup();
        while rest.len() > 1 && rest[0] == rest[rest.len() - 1] {
            rest.pop();
        }
        std::mem::swap(overlap, &mut rest);
    }
}

/// Area and centroid of a polygon that turns left; `None` if rounding leaves no area. Computed relative to
/// its first corner, so that accuracy does not depend on the distance to the origin.
fn area_and_centroid(polygon: &[[f64; 2]]) -> Option<(f64, [f64; 2])> {
    let origin = *polygon.first()?;
    let (mut double, mut moment) = (0.0, [0.0; 2]);
    for pair in polygon[1..].windows(2) {
        let (u, v) = (sub(pair[0], origin), sub(pair[1], origin));
        let part = u[0] * v[1] - u[1] * v[0];
        double += part;
        moment = [moment[0] + part * (u[0] + v[0]), moment[1] + part * (u[1] + v[1])];
    }
    if double <= 0.0 {
        return None;
    }
    let centroid = [0, 1].map(|axis| {
        let (low, high) = polygon
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])));
        // If the area is dominated by rounding, its computed centroid can be anywhere.
        (origin[axis] + moment[axis] / (3.0 * double)).clamp(low, high)
    });
    Some((0.5 * double, centroid))
}

/// The ends of the common part of two hulls that touch but do not overlap: corners of one on the other, and
/// crossings of edges.
fn shared(p: &[[f64; 2]], q: &[[f64; 2]]) -> Option<[[f64; 2]; 2]> {
    let mut ends: Option<[[f64; 2]; 2]> = None;
    let mut include = |c: [f64; 2]| {
        let [low, high] = ends.unwrap_or([c, c]);
        ends = Some([if before(c, low) { c } else { low }, if before(high, c) { c } else { high }]);
    };
    for (own, other) in [(p, q), (q, p)] {
        for &c in own {
            if hulls_touch(&[c], other) {
                include(c);
            }
        }
    }
    for (a, b) in edges(p) {
        for (c, d) in edges(q) {
            let (from, to) = (orient2d(a, b, c), orient2d(a, b, d));
            let crossed = (orient2d(c, d, a) > 0.0 && orient2d(c, d, b) < 0.0)
                || (orient2d(c, d, a) < 0.0 && orient2d(c, d, b) > 0.0);
            if crossed && from < 0.0 && to > 0.0 {
                include(between(c, d, from / (from - to)));
            }
        }
    }
    ends
}

/// The outward normal, from `p` to `q`, of the edge along which the smallest translation separates them.
fn normal_of_least_move(p: &[[f64; 2]], q: &[[f64; 2]]) -> [f64; 2] {
    let mut best = (f64::NEG_INFINITY, x_axis());
    for (own, other, second) in [(p, q, false), (q, p, true)] {
        for (a, b) in edges(own) {
            let Some(out) = unit([b[1] - a[1], a[0] - b[0]]) else { continue };
            let separation = other.iter().map(|&c| dot(out, sub(c, a))).fold(f64::INFINITY, f64::min);
            if separation > best.0 {
                best = (separation, if second { neg(out) } else { out });
            }
        }
    }
    best.1
}

/// The closest points of two separate hulls: a corner of one and a point of an edge of the other.
fn closest(p: &[[f64; 2]], q: &[[f64; 2]]) -> ([f64; 2], [f64; 2]) {
    let mut best = (p[0], q[0]);
    let mut least = f64::INFINITY;
    for (own, other, second) in [(p, q, false), (q, p, true)] {
        for &c in own {
            for k in 0..other.len() {
                let (a, b) = (other[k], other[(k + 1) % other.len()]);
                let u = sub(b, a);
                let length = dot(u, u);
                let t = if length > 0.0 { dot(sub(c, a), u) / length } else { 0.0 };
                let foot = between(a, b, t.clamp(0.0, 1.0));
                let squared = distance_squared(c, foot);
                if squared < least {
                    (best, least) = (if second { (foot, c) } else { (c, foot) }, squared);
                }
            }
        }
    }
    best
}

/// Whether two coplanar sets of one to three points each have hulls that touch.
///
/// A common point is a common point in every projection. At least one projection along an axis keeps distinct
/// points of the plane distinct, so a common point there is a common point in space.
pub(super) fn coplanar_touch(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    (0..3).all(|axis| hulls_touch(flatten(a, axis).points(), flatten(b, axis).points()))
}

pub(super) fn flatten(points: &[[f64; 3]], axis: usize) -> Hull {
    let mut flat = [[0.0; 2]; 3];
    for (to, &from) in flat.iter_mut().zip(points) {
        *to = project(from, axis);
    }
    hull(&flat[..points.len().min(3)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(vertices: &[[f64; 2]]) -> ConvexPolygon {
        ConvexPolygon::new(vertices).unwrap()
    }

    #[test]
    fn what_is_not_convex_is_named() {
        let star: Vec<[f64; 2]> = (0..5)
            .map(|k| {
                let angle = f64::from(k) * 0.8 * std::f64::consts::PI;
                [angle.cos(), angle.sin()]
            })
            .collect();
        assert!(matches!(ConvexPolygon::new(&star), Err(ShapeError::NotConvex { .. })));
        // The vertices go back along one side.
        let folded = [[0.0, 0.0], [3.0, 0.0], [2.0, 0.0], [2.0, 2.0]];
        assert_eq!(ConvexPolygon::new(&folded), Err(ShapeError::NotConvex { vertex: 1 }));
        assert_eq!(ConvexPolygon::new(&[]), Err(ShapeError::NoVertices));
        let crossed = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(matches!(ConvexPolygon::new(&crossed), Err(ShapeError::NotConvex { .. })));
        // The vertices go round twice.
        let twice = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(matches!(ConvexPolygon::new(&twice), Err(ShapeError::NotConvex { .. })));
    }

    #[test]
    fn repeated_and_straight_vertices_are_dropped() {
        let square =
            polygon(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]]);
        assert_eq!(square.vertices(), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert_eq!(polygon(&[[1.0, 1.0]; 4]).vertices(), [[1.0, 1.0]]);
        assert_eq!(polygon(&[[1.0, 1.0], [3.0, 3.0], [2.0, 2.0]]).vertices(), [[1.0, 1.0], [3.0, 3.0]]);
    }

    #[test]
    fn degenerate_and_touching_pairs_have_an_answer() {
        let square = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        let mut overlap = Vec::new();
        for (vertices, point, normal, shared) in [
            (vec![[2.0, 1.0], [3.0, 1.0], [3.0, 3.0], [2.0, 3.0]], [2.0, 1.5], [1.0, 0.0], 2),
            (vec![[2.0, 2.0], [3.0, 2.0], [2.0, 3.0]], [2.0, 2.0], [1.0, 0.0], 1),
            (vec![[2.0, 1.0]], [2.0, 1.0], [1.0, 0.0], 1),
            (vec![[-1.0, 1.75], [3.0, 1.75]], [1.0, 1.75], [0.0, 1.0], 2),
        ] {
            let contact = polygon_polygon(&square, &polygon(&vertices), &mut overlap);
            assert_eq!(contact, Contact { point, normal, measure: Measure::Area(0.0) });
            assert_eq!(overlap.len(), shared);
        }
        let same = polygon_polygon(&square, &square, &mut overlap);
        assert_eq!((same.measure, same.point, overlap.len()), (Measure::Area(4.0), [1.0, 1.0], 4));
        let cross = polygon_polygon(
            &polygon(&[[0.0, 0.0], [2.0, 2.0]]),
            &polygon(&[[0.0, 2.0], [2.0, 0.0]]),
            &mut overlap,
        );
        assert_eq!((cross.measure, cross.point), (Measure::Area(0.0), [1.0, 1.0]));
        let points = polygon_polygon(&polygon(&[[3.0, 0.0]]), &polygon(&[[3.0, 0.0]]), &mut overlap);
        assert_eq!((points.measure, points.normal), (Measure::Area(0.0), [1.0, 0.0]));
        let apart = polygon_polygon(&polygon(&[[3.0, 0.0]]), &polygon(&[[0.0, 4.0]]), &mut overlap);
        assert_eq!((apart.measure, apart.point), (Measure::Gap(5.0), [1.5, 2.0]));
        assert!(overlap.is_empty());
    }

    #[test]
    fn one_step_apart_is_seen_far_from_the_origin() {
        let a = Triangle::new([[1e9, 1e9], [1e9 + 3.0, 1e9 + 1.0], [1e9, 1e9 + 5.0]]).unwrap();
        let b = Triangle::new([[1e9 + 3.0, 1e9 + 1.0], [1e9 + 6.0, 1e9 + 2.0], [1e9 + 6.0, 1e9]]).unwrap();
        assert!(a.touches(&b));
        let right = (1e9_f64 + 3.0).next_up();
        let b = Triangle::new([[right, 1e9 + 1.0], [1e9 + 6.0, 1e9 + 2.0], [1e9 + 6.0, 1e9]]).unwrap();
        assert!(!a.touches(&b));
    }
}
