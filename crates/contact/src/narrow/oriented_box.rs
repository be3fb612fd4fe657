//! Boxes in any orientation.

use super::contact::{Contact, Measure};
use super::error::ShapeError;
use super::segment::closest as closest_of_segments;
use super::shapes::check;
use super::vector::{add, cross, distance_squared, dot, middle, neg, scale, sub, unit, x_axis};

/// Largest deviation of dot products of the axes from 0 and 1.
const ORTHONORMAL: f64 = 1e-12;

/// An axis perpendicular to two edges must be better than a face by this much, relative to the size, because
/// nearly parallel boxes rest on faces.
const PREFER_FACES: f64 = 1e-12;

/// A box in any orientation. Edges of length 0 make it a rectangle, a segment or a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    half: [f64; 3],
}

impl OrientedBox {
    /// Makes a box from its centre, the unit vectors along its edges and half the lengths of the edges.
    ///
    /// # Shapes
    /// `axes[k]` is the direction of the edges of length `2 half[k]`. The axes may be right- or left-handed.
    ///
    /// # Errors
    /// [`ShapeError::Coordinate`], [`ShapeError::NegativeEdge`], [`ShapeError::NotOrthonormal`] if a dot
    /// product of axes is off by more than 1e-12.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::narrow::OrientedBox;
    ///
    /// let axes = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
    /// assert!(OrientedBox::new([0.0; 3], axes, [1.0, 2.0, 3.0]).is_ok());
    /// ```
    pub fn new(centre: [f64; 3], axes: [[f64; 3]; 3], half: [f64; 3]) -> Result<Self, ShapeError> {
        check(0, centre)?;
        check(1, half)?;
        if let Some(axis) = half.iter().position(|&x| x < 0.0) {
            return Err(ShapeError::NegativeEdge { axis, value: half[axis] });
        }
        for i in 0..3 {
            for j in i..3 {
                let product = dot(axes[i], axes[j]);
                let off = (product - if i == j { 1.0 } else { 0.0 }).abs();
                // The negated condition refuses NaN as well.
                if !matches!(off.partial_cmp(&ORTHONORMAL), Some(std::cmp::Ordering::Less)) {
                    return Err(ShapeError::NotOrthonormal { axes: [i, j], product });
                }
            }
        }
        Ok(Self { centre, axes, half })
    }

    /// The point of the box at these coordinates along its axes, in units of half its edges.
    fn at(&self, parts: [f64; 3]) -> [f64; 3] {
        (0..3).fold(self.centre, |x, k| add(x, scale(self.axes[k], parts[k] * self.half[k])))
    }

    /// Coordinates of a point along the axes, relative to the centre.
    fn local(&self, x: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, sub(x, self.centre)))
    }

    /// Half the extent of the box along a direction.
    fn reach(&self, direction: [f64; 3]) -> f64 {
        (0..3).map(|k| self.half[k] * dot(self.axes[k], direction).abs()).sum()
    }

    fn closest(&self, x: [f64; 3]) -> [f64; 3] {
        let local = self.local(x);
        (0..3).fold(self.centre, |y, k| {
            add(y, scale(self.axes[k], local[k].clamp(-self.half[k], self.half[k])))
        })
    }

    /// The distance from a point of the box to its surface in a direction.
    fn way_out(&self, x: [f64; 3], direction: [f64; 3]) -> f64 {
        let mut way = f64::INFINITY;
        for ((at, axis), half) in self.local(x).into_iter().zip(self.axes).zip(self.half) {
            let slope = dot(axis, direction);
            if slope != 0.0 {
                way = way.min((half - at * slope.signum()) / slope.abs());
            }
        }
        way.max(0.0)
    }

    fn vertices(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|k| self.at([0, 1, 2].map(|bit| if k >> bit & 1 == 1 { 1.0 } else { -1.0 })))
    }
}

/// The ends of the edges of a box, as pairs of vertex numbers.
fn edges() -> impl Iterator<Item = [usize; 2]> {
    (0..3).flat_map(|bit| (0..8).filter(move |k| k >> bit & 1 == 0).map(move |k| [k, k | 1 << bit]))
}

/// The axis, one of fifteen, that separates two boxes best.
#[derive(Clone, Copy)]
enum Axis {
    /// The normal of a face of the first (0) or second (1) box; then its number.
    Face(usize, usize),
    /// The cross product of an edge of the first box and an edge of the second.
    Edges(usize, usize),
}

/// Two boxes in any orientation: gap or depth.
///
/// The boxes touch if none of the fifteen axes (six faces, nine pairs of edges) separates them:
/// `|n · t| - r_a - r_b <= 0`, where `t` leads from centre to centre and `r` is half the length of a box
/// along `n`. This is evaluated in `f64`, with an error of 32 rounding steps of the largest coordinate or
/// edge. The depth is the smallest translation that separates the boxes, and the normal is its direction;
/// among equal ones the first face is taken. For the normal of a face, the point is the centroid of the part
/// of the facing face of the other box, moved against the normal to the middle of the overlap there; for two
/// edges it is the middle between them. It is inside both boxes if the normal is that of a face and the depth
/// does not exceed the edges. For a gap the point is the middle between the closest points, and the gap is
/// their distance.
///
/// # Source
/// S. Gottschalk, M.C. Lin, D. Manocha, "`OBBTree`: a hierarchical structure for rapid interference
/// detection", SIGGRAPH 96, 171–180: the fifteen axes.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Measure, OrientedBox, box_box};
///
/// let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let a = OrientedBox::new([0.0; 3], upright, [1.0; 3])?;
/// let b = OrientedBox::new([1.0, 0.0, 1.75], upright, [1.0; 3])?;
/// let contact = box_box(&a, &b);
/// assert_eq!((contact.measure, contact.normal), (Measure::Depth(0.25), [0.0, 0.0, 1.0]));
/// assert_eq!(contact.point, [0.5, 0.0, 0.875]);
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn box_box(a: &OrientedBox, b: &OrientedBox) -> Contact<3> {
    let t = sub(b.centre, a.centre);
    let mut best = (f64::NEG_INFINITY, x_axis(), Axis::Face(0, 0));
    let mut consider = |n: [f64; 3], axis: Axis, bias: f64| {
        let way = dot(n, t);
        let separation = way.abs() - a.reach(n) - b.reach(n);
        // A positive separation decides, regardless of the bias.
        if separation - bias > best.0 || (separation > 0.0 && separation > best.0) {
            best = (separation, if way < 0.0 { neg(n) } else { n }, axis);
        }
    };
    for (which, own) in [a, b].into_iter().enumerate() {
        for (k, &n) in own.axes.iter().enumerate() {
            consider(n, Axis::Face(which, k), 0.0);
        }
    }
    let bias = PREFER_FACES * a.half.iter().chain(&b.half).sum::<f64>();
    for (i, &u) in a.axes.iter().enumerate() {
        for (j, &v) in b.axes.iter().enumerate() {
            if let Some(n) = unit(cross(u, v)) {
                consider(n, Axis::Edges(i, j), bias);
            }
        }
    }
    let (separation, normal, axis) = best;
    if separation > 0.0 {
        let (from, to) = closest(a, b);
        return Contact {
            point: middle(from, to),
            normal: unit(sub(to, from)).unwrap_or(normal),
            measure: Measure::Gap(distance_squared(from, to).sqrt()),
        };
    }
    let point = match axis {
        Axis::Face(0, k) => point_on_face(a, k, normal, b),
        Axis::Face(_, k) => point_on_face(b, k, neg(normal), a),
        Axis::Edges(i, j) => {
            let (from, to) = closest_of_segments(edge_towards(a, i, normal), edge_towards(b, j, neg(normal)));
            middle(from, to)
        }
    };
    Contact { point, normal, measure: Measure::Depth(-separation) }
}

/// The edge along an axis that is farthest in a direction.
fn edge_towards(own: &OrientedBox, axis: usize, direction: [f64; 3]) -> [[f64; 3]; 2] {
    [-1.0, 1.0].map(|end| {
        own.at([0, 1, 2].map(|k| {
            if k == axis {
                end
            } else if dot(own.axes[k], direction) < 0.0 {
                -1.0
            } else {
                1.0
            }
        }))
    })
}

/// The contact point on the face of `own` along `axis` that faces in the direction `out`. Takes the facing
/// face of the other box, clips it to the sides of `own` and to below its face, and moves its centroid to the
/// middle of the overlap there.
fn point_on_face(own: &OrientedBox, axis: usize, out: [f64; 3], other: &OrientedBox) -> [f64; 3] {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let sign = if dot(own.axes[axis], out) < 0.0 { -1.0 } else { 1.0 };
    // Coordinates along the two sides of the face, and above it.
    let local = |x: [f64; 3]| {
        let local = own.local(x);
        [local[j], local[k], sign * local[axis] - own.half[axis]]
    };
    let mut facing = 0;
    for l in 1..3 {
        if dot(other.axes[l], out).abs() > dot(other.axes[facing], out).abs() {
            facing = l;
        }
    }
    let back = if dot(other.axes[facing], out) > 0.0 { -1.0 } else { 1.0 };
    let mut polygon: Vec<[f64; 3]> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .into_iter()
        .map(|[p, q]| {
            let mut parts = [0.0; 3];
            parts[facing] = back;
            parts[(facing + 1) % 3] = p;
            parts[(facing + 2) % 3] = q;
            local(other.at(parts))
        })
        .collect();
    let deepest = polygon.iter().copied().reduce(|a, b| if b[2] < a[2] { b } else { a }).unwrap_or_default();
    let sides = [own.half[j], own.half[k]];
    for (side, &half) in sides.iter().enumerate() {
        polygon = below(&polygon, |x| half - x[side]);
        polygon = below(&polygon, |x| half + x[side]);
    }
    // If faces rest on each other, their heights differ by rounding alone.
    let size =
        own.centre.iter().chain(&own.half).chain(&other.half).fold(0.0_f64, |size, x| size.max(x.abs()));
    let under = below(&polygon, |x| PREFER_FACES * size - x[2]);
    let [x, y, z] = centroid(&under).or_else(|| centroid(&polygon)).unwrap_or_else(|| {
        [deepest[0].clamp(-sides[0], sides[0]), deepest[1].clamp(-sides[1], sides[1]), deepest[2].min(0.0)]
    });
    let low = add(
        add(own.centre, scale(own.axes[axis], sign * (own.half[axis] + z))),
        add(scale(own.axes[j], x), scale(own.axes[k], y)),
    );
    // Below the face of `own`, the other box begins at `low`; this is the middle of the overlap.
    let first = (-z - other.way_out(low, out)).max(0.0);
    let last = (-z).min(2.0 * own.half[axis]);
    add(low, scale(out, -z - 0.5 * (first + last)))
}

/// The part of a polygon where a linear function is not negative.
fn below(polygon: &[[f64; 3]], inside: impl Fn([f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut rest = Vec::with_capacity(polygon.len() + 1);
    for (k, &from) in polygon.iter().enumerate() {
        let to = polygon[(k + 1) % polygon.len()];
        let (p, q) = (inside(from), inside(to));
        if p >= 0.0 {
            rest.push(from);
        }
        if (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0) {
            let t = p / (p - q);
            rest.push(std::array::from_fn(|axis| from[axis] + t * (to[axis] - from[axis])));
        }
    }
    rest
}

/// The centroid of a plane polygon; the mean of its corners if it has no area, `None` without corners.
fn centroid(polygon: &[[f64; 3]]) -> Option<[f64; 3]> {
    let &origin = polygon.first()?;
    let (mut total, mut moment) = (0.0, [0.0; 3]);
    for pair in polygon[1..].windows(2) {
        let n = cross(sub(pair[0], origin), sub(pair[1], origin));
        let area = dot(n, n).sqrt();
        total += area;
        moment = add(moment, scale(add(sub(pair[0], origin), sub(pair[1], origin)), area / 3.0));
    }
    if total > 0.0 {
        return Some(add(origin, scale(moment, 1.0 / total)));
    }
    let sum = polygon.iter().fold([0.0; 3], |sum, &x| add(sum, x));
    Some(scale(sum, 1.0 / polygon.len() as f64))
}

/// The closest points of two separate boxes: a vertex of one and a point of the other, or points of two
/// edges.
fn closest(a: &OrientedBox, b: &OrientedBox) -> ([f64; 3], [f64; 3]) {
    let (of_a, of_b) = (a.vertices(), b.vertices());
    let mut best = (of_a[0], of_b[0]);
    let mut least = f64::INFINITY;
    let mut consider = |pair: ([f64; 3], [f64; 3])| {
        let squared = distance_squared(pair.0, pair.1);
        if squared < least {
            (best, least) = (pair, squared);
        }
    };
    for x in of_a {
        consider((x, b.closest(x)));
    }
    for x in of_b {
        consider((a.closest(x), x));
    }
    for [i, j] in edges() {
        for [k, l] in edges() {
            consider(closest_of_segments([of_a[i], of_a[j]], [of_b[k], of_b[l]]));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn bad_boxes_are_named() {
        let mut axes = UPRIGHT;
        axes[1] = [0.1, 1.0, 0.0];
        let error = OrientedBox::new([0.0; 3], axes, [1.0; 3]).unwrap_err();
        assert_eq!(error, ShapeError::NotOrthonormal { axes: [0, 1], product: 0.1 });
        axes[1] = [0.0, f64::NAN, 0.0];
        assert!(matches!(OrientedBox::new([0.0; 3], axes, [1.0; 3]), Err(ShapeError::NotOrthonormal { .. })));
        let error = OrientedBox::new([0.0; 3], UPRIGHT, [1.0, -2.0, 1.0]).unwrap_err();
        assert_eq!(error, ShapeError::NegativeEdge { axis: 1, value: -2.0 });
    }

    #[test]
    fn identical_boxes_and_boxes_without_edges_have_an_answer() {
        let cube = OrientedBox::new([1.0; 3], UPRIGHT, [1.0, 2.0, 3.0]).unwrap();
        let same = box_box(&cube, &cube);
        assert_eq!((same.measure, same.normal), (Measure::Depth(2.0), [1.0, 0.0, 0.0]));
        let point = OrientedBox::new([2.0, 1.0, 1.0], UPRIGHT, [0.0; 3]).unwrap();
        let contact = box_box(&cube, &point);
        assert_eq!((contact.measure, contact.point), (Measure::Depth(0.0), [2.0, 1.0, 1.0]));
        let contact = box_box(&point, &point);
        assert_eq!((contact.measure, contact.point), (Measure::Depth(0.0), [2.0, 1.0, 1.0]));
    }

    #[test]
    fn two_crossed_edges_meet_between_them() {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        // An edge of the first box points up along y, an edge of the second points down along x.
        let a = OrientedBox::new([0.0; 3], [[0.0, 1.0, 0.0], [h, 0.0, h], [-h, 0.0, h]], [5.0, 1.0, 1.0])
            .unwrap();
        let b =
            OrientedBox::new([0.0, 0.0, 2.5], [[1.0, 0.0, 0.0], [0.0, h, h], [0.0, -h, h]], [5.0, 1.0, 1.0])
                .unwrap();
        let contact = box_box(&a, &b);
        let Measure::Depth(depth) = contact.measure else { panic!("{contact:?}") };
        assert!((depth - (8.0_f64.sqrt() - 2.5)).abs() < 1e-14, "{depth}");
        assert!(distance_squared(contact.point, [0.0, 0.0, 1.25]) < 1e-28, "{:?}", contact.point);
        assert!(contact.normal[2] > 0.999_999);
    }

    #[test]
    fn boxes_that_are_apart_have_the_distance_not_a_separation() {
        let a = OrientedBox::new([0.0; 3], UPRIGHT, [1.0; 3]).unwrap();
        let b = OrientedBox::new([5.0, 6.0, 2.0], UPRIGHT, [1.0; 3]).unwrap();
        let contact = box_box(&a, &b);
        assert_eq!((contact.measure, contact.normal), (Measure::Gap(5.0), [0.6, 0.8, 0.0]));
        assert_eq!(contact.point, [2.5, 3.0, 1.0]);
    }
}
