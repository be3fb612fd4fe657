//! Flat pieces: polygons, and the flat faces of a surface.

use spade::{ConstrainedDelaunayTriangulation, Point2 as Vertex, Triangulation};

use crate::tetrahedra::plane::Point2;
use crate::tetrahedra::skin::axes_of;
use crate::tetrahedra::vector::{Point, cross, distance, dot, length, minus, normal, plus, times, unit};

/// Sine of the largest angle between planes that have no common line.
const PARALLEL: f64 = 1e-6;

/// A flat piece.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) origin: Point,
    pub(super) normal: Point,
    /// Two directions of length 1 in the plane: counter-clockwise seen from the tip of the normal.
    pub(super) axes: [Point; 2],
    /// Corners of a polygon; empty for a face.
    pub(super) corners: Vec<Point>,
    /// Triangles that cover the piece.
    pub(super) triangles: Vec<[Point; 3]>,
    pub(super) bounds: [Point; 2],
}

impl Sheet {
    /// A face of a surface, by the corners of its facets.
    pub(super) fn of_face(triangles: Vec<[Point; 3]>) -> Self {
        let area = |&[a, b, c]: &[Point; 3]| length(normal(a, b, c));
        let one = triangles.iter().max_by(|one, other| area(one).total_cmp(&area(other)));
        let one = one.copied().unwrap_or_default();
        let bounds = crate::bounds(triangles.iter().flatten().copied());
        let [a, b, c] = one;
        Self {
            origin: a,
            normal: unit(normal(a, b, c)),
            axes: axes_of(one),
            corners: Vec::new(),
            triangles,
            bounds,
        }
    }

    /// A polygon, in the mean plane of its corners; `None` if it has no area. Also returns how far corners
    /// are from the plane.
    pub(super) fn of_polygon(corners: &[Point]) -> Option<(Self, f64)> {
        let first = *corners.first()?;
        let sum = corners.windows(2).fold([0.0; 3], |sum, pair| plus(sum, normal(first, pair[0], pair[1])));
        let middle = corners.iter().fold([0.0; 3], |sum, &corner| plus(sum, corner));
        let middle = times(middle, 1.0 / corners.len() as f64);
        let wide = corners.iter().map(|&corner| distance(corner, middle)).fold(0.0, f64::max);
        if length(sum).is_nan() || length(sum) <= 1e-9 * wide * wide {
            return None;
        }
        let unit_normal = unit(sum);
        let far =
            corners.iter().map(|&corner| dot(unit_normal, minus(corner, middle)).abs()).fold(0.0, f64::max);
        // A plane along the axes goes through the corners exactly.
        let exact = corners.iter().all(|&corner| dot(unit_normal, minus(corner, corners[0])) == 0.0);
        let origin = if exact { corners[0] } else { middle };
        let mut sheet = Self {
            origin,
            normal: unit_normal,
            axes: axes_of([[0.0; 3], sum_axis(unit_normal), cross(unit_normal, sum_axis(unit_normal))]),
            corners: corners.to_vec(),
            triangles: Vec::new(),
            bounds: crate::bounds(corners.iter().copied()),
        };
        sheet.flatten();
        Some((sheet, far))
    }

    /// Puts the corners into the plane, and makes the triangles of them. Returns whether the polygon has an
    /// area, and does not cross itself.
    pub(super) fn flatten(&mut self) -> bool {
        let (origin, unit_normal) = (self.origin, self.normal);
        for corner in &mut self.corners {
            let off = dot(unit_normal, minus(*corner, origin));
            if off != 0.0 {
                *corner = minus(*corner, times(unit_normal, off));
            }
        }
        self.corners.dedup();
        if self.corners.first() == self.corners.last() {
            self.corners.pop();
        }
        self.bounds = crate::bounds(self.corners.iter().copied());
        let count = self.corners.len();
        if count < 3 {
            self.triangles.clear();
            return false;
        }
        let points: Vec<Point2> = self.corners.iter().map(|&corner| self.flat(corner)).collect();
        let edges: Vec<[usize; 2]> = (0..count).map(|k| [k, (k + 1) % count]).collect();
        let Some(all) = triangulate(&points, &edges) else {
            self.triangles.clear();
            return false;
        };
        let is_inside = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| points[corner as usize]);
            contains(&points, [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0])
        };
        let kept = all.into_iter().filter(is_inside);
        self.triangles = kept.map(|triangle| triangle.map(|corner| self.corners[corner as usize])).collect();
        !self.triangles.is_empty()
    }

    /// The polygon, moved along its normal.
    pub(super) fn moved(&self, by: f64) -> Self {
        let mut new = self.clone();
        if by != 0.0 {
            let by = times(self.normal, by);
            new.origin = plus(new.origin, by);
            new.corners.iter_mut().for_each(|corner| *corner = plus(*corner, by));
            new.flatten();
        }
        new
    }

    /// Distance of a point from the plane, on the side of the normal.
    pub(super) fn height(&self, point: Point) -> f64 {
        dot(self.normal, minus(point, self.origin))
    }

    /// The place of a point in the plane.
    pub(super) fn flat(&self, point: Point) -> Point2 {
        // Coordinates that are 0 but for rounding are set to 0: the triangulation refuses numbers that are
        // nearly 0.
        self.axes
            .map(|axis| dot(axis, minus(point, self.origin)))
            .map(|x| if x.abs() < 1e-30 { 0.0 } else { x })
    }

    /// Whether the foot of a point is in the piece, or no farther from it than `margin`.
    pub(super) fn contains(&self, point: Point, margin: f64) -> bool {
        let p = self.flat(point);
        self.triangles.iter().any(|triangle| {
            let [a, b, c] = triangle.map(|corner| self.flat(corner));
            [[a, b], [b, c], [c, a]].iter().all(|&[a, b]| {
                let along = [b[0] - a[0], b[1] - a[1]];
                let span = along[0].hypot(along[1]);
                along[0] * (p[1] - a[1]) - along[1] * (p[0] - a[0]) >= -margin * span
            })
        })
    }

    /// Whether the boxes around two pieces are no farther from each other than `margin`.
    pub(super) fn is_near(&self, other: &Self, margin: f64) -> bool {
        let ([low, high], [least, most]) = (self.bounds, other.bounds);
        (0..3).all(|axis| low[axis] <= most[axis] + margin && least[axis] <= high[axis] + margin)
    }

    /// Sine and absolute cosine of the angle between two planes.
    pub(super) fn angle(&self, other: &Self) -> [f64; 2] {
        [length(cross(self.normal, other.normal)), dot(self.normal, other.normal).abs()]
    }

    /// The segments that two pieces have in common, longer than `least`. `None` if their planes are parallel.
    pub(super) fn meet(&self, other: &Self, least: f64) -> Vec<[Point; 2]> {
        let along = cross(self.normal, other.normal);
        if length(along) < PARALLEL || !self.is_near(other, least) {
            return Vec::new();
        }
        let (along, cosine) = (unit(along), dot(self.normal, other.normal));
        // The point of both planes that is nearest to the origin of this one.
        let by = -other.height(self.origin) / (1.0 - cosine * cosine);
        let start = plus(self.origin, times(minus(other.normal, times(self.normal, cosine)), by));
        let [one, two] = [self.on_line(other, start, along, least), other.on_line(self, start, along, least)];
        let mut common = Vec::new();
        for [from, to] in one {
            for [first, last] in &two {
                let (from, to) = (from.max(*first), to.min(*last));
                if to - from > least {
                    common.push([from, to].map(|t| plus(start, times(along, t))));
                }
            }
        }
        common
    }

    /// The parts of the line in which the plane of another piece cuts this one.
    fn on_line(&self, other: &Self, start: Point, along: Point, least: f64) -> Vec<[f64; 2]> {
        let mut parts = Vec::new();
        for triangle in &self.triangles {
            let heights =
                triangle.map(|corner| other.height(corner)).map(|h| if h.abs() < least { 0.0 } else { h });
            let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
            let mut take = |point: Point| {
                let t = dot(along, minus(point, start));
                ends = [ends[0].min(t), ends[1].max(t)];
            };
            for k in 0..3 {
                let (a, b, h, g) = (triangle[k], triangle[(k + 1) % 3], heights[k], heights[(k + 1) % 3]);
                if h == 0.0 {
                    take(a);
                } else if (h > 0.0 && g < 0.0) || (h < 0.0 && g > 0.0) {
                    take(plus(a, times(minus(b, a), h / (h - g))));
                }
            }
            if ends[1] - ends[0] > least {
                parts.push(ends);
            }
        }
        parts.sort_by(|one, other| one[0].total_cmp(&other[0]));
        let mut joined: Vec<[f64; 2]> = Vec::new();
        for part in parts {
            match joined.last_mut() {
                Some(last) if part[0] <= last[1] + least => last[1] = last[1].max(part[1]),
                _ => joined.push(part),
            }
        }
        joined
    }

    /// Leaves out the part beyond a box, if the polygon is convex.
    pub(super) fn clip(&mut self, [low, high]: [Point; 2]) {
        if !self.is_convex() {
            return;
        }
        for axis in 0..3 {
            for (limit, sign) in [(low[axis], 1.0), (high[axis], -1.0)] {
                let count = self.corners.len();
                let mut kept = Vec::with_capacity(count + 1);
                for k in 0..count {
                    let (a, b) = (self.corners[k], self.corners[(k + 1) % count]);
                    let (h, g) = (sign * (a[axis] - limit), sign * (b[axis] - limit));
                    if h >= 0.0 {
                        kept.push(a);
                    }
                    if (h > 0.0 && g < 0.0) || (h < 0.0 && g > 0.0) {
                        kept.push(plus(a, times(minus(b, a), h / (h - g))));
                    }
                }
                self.corners = kept;
            }
        }
        self.flatten();
    }

    fn is_convex(&self) -> bool {
        let count = self.corners.len();
        let points: Vec<Point2> = self.corners.iter().map(|&corner| self.flat(corner)).collect();
        let turn = |k: usize| {
            let [a, b, c] = [0, 1, 2].map(|step| points[(k + step) % count]);
            (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        };
        let wide = points.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        (0..count).all(|k| turn(k) >= -1e-12 * wide * wide)
    }
}

/// A direction across a normal, along an axis if the normal is.
fn sum_axis(normal: Point) -> Point {
    let least =
        (0..3).fold(0, |least, axis| if normal[axis].abs() < normal[least].abs() { axis } else { least });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    unit(minus(axis, times(normal, normal[least])))
}

/// Whether a point is inside of a polygon.
pub(super) fn contains(corners: &[Point2], [x, y]: Point2) -> bool {
    let mut inside = false;
    for k in 0..corners.len() {
        let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
        if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            inside = !inside;
        }
    }
    inside
}

/// Delaunay's triangles of points under the constraint of edges, counter-clockwise; `None` if edges cross
/// each other, or points coincide.
pub(super) fn triangulate(points: &[Point2], edges: &[[usize; 2]]) -> Option<Vec<[u32; 3]>> {
    let vertices = points.iter().map(|&[x, y]| Vertex::new(x, y)).collect();
    let mut crossing = false;
    let all =
        ConstrainedDelaunayTriangulation::<Vertex<f64>>::try_bulk_load_cdt(vertices, edges.to_vec(), |_| {
            crossing = true;
        });
    let all = all.ok().filter(|all| all.num_vertices() == points.len() && !crossing)?;
    Some(all.inner_faces().map(|face| face.vertices().map(|node| node.fix().index() as u32)).collect())
}
