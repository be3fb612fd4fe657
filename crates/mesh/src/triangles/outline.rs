//! Closed polygons: their areas, circles as polygons, and tests of points against them.

use std::f64::consts::TAU;

use crate::grading::{Grading, stations};
use crate::mesh::{MOST_ELEMENTS, bounds};

/// A point or vector.
pub type Point = [f64; 2];

/// Distance from 0, in widths of a domain, beyond which coordinates have too few digits left for the shape of
/// elements.
const FAR: f64 = 1024.0;

/// A domain to mesh: loops, the outer one first, and lines inside that become edges of the mesh.
#[derive(Debug, Clone, Default)]
pub struct Domain {
    /// Corners in order, either way round; the outer loop first.
    pub loops: Vec<Vec<Point>>,
    /// Ends of lines; an end on a loop is a corner of it.
    pub lines: Vec<[Point; 2]>,
}

impl Domain {
    /// Least and largest coordinates.
    pub fn bounds(&self) -> [Point; 2] {
        bounds(self.loops.iter().flatten().copied())
    }

    /// The middle of the bounds along each axis on which that is far from 0 for a domain of this width; 0
    /// along others.
    ///
    /// Differences of the corners from it are exact (Sterbenz' lemma), and a mesh that is made of them is the
    /// same wherever the domain lies.
    pub fn middle_if_far(&self) -> Point {
        let [low, high] = self.bounds();
        [0, 1].map(|axis| {
            let middle = 0.5 * low[axis] + 0.5 * high[axis];
            if middle.abs() > FAR * (high[axis] - low[axis]) { middle } else { 0.0 }
        })
    }

    /// Returns the outline in coordinates about another origin.
    #[must_use]
    pub fn relative_to(&self, origin: Point) -> Self {
        let moved = |point: Point| [0, 1].map(|axis| point[axis] - origin[axis]);
        Self {
            loops: self.loops.iter().map(|corners| corners.iter().copied().map(moved).collect()).collect(),
            lines: self.lines.iter().map(|ends| ends.map(moved)).collect(),
        }
    }

    /// Area of the outer loop less the areas of the others, squared unit.
    pub fn area(&self) -> f64 {
        let mut areas = self.loops.iter().map(|corners| area(corners).abs());
        let outer = areas.next().unwrap_or(0.0);
        outer - areas.sum::<f64>()
    }
}

/// Area of a closed polygon, positive counter-clockwise. It is computed relative to the first corner, so that
/// a large distance from the origin costs no digits.
pub fn area(corners: &[Point]) -> f64 {
    let Some(&origin) = corners.first() else { return 0.0 };
    corners.windows(2).map(|pair| twice_area(origin, pair[0], pair[1])).sum::<f64>() / 2.0
}

/// Twice the area of a triangle, positive counter-clockwise.
pub fn twice_area(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

/// Length of a closed polygon.
pub fn length(corners: &[Point]) -> f64 {
    (0..corners.len()).map(|k| distance(corners[k], corners[(k + 1) % corners.len()])).sum()
}

/// Distance between two points.
pub fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Points on a circle, as far from each other as the size says. There is one farthest along each axis, and
/// one between two such points at least.
pub fn circle(centre: Point, radius: f64, size: &Grading<2>) -> Vec<Point> {
    let quarters: [Vec<f64>; 4] = if size.near.is_empty() {
        let count =
            ((TAU * radius / size.size / 4.0).round() * 4.0).clamp(8.0, MOST_ELEMENTS as f64) as usize;
        let quarter: Vec<f64> = (0..count / 4).map(|k| TAU * k as f64 / count as f64).collect();
        std::array::from_fn(|_| quarter.clone())
    } else {
        let length = 0.25 * TAU * radius;
        let round = |pieces: f64| pieces.round().max(2.0) as usize;
        std::array::from_fn(|quarter| {
            let size_at = |part: f64| size.at(on_circle(centre, radius, quarter, 0.25 * TAU * part));
            let inner = stations(length, &size_at, &round).into_iter().map(|part| 0.25 * TAU * part);
            std::iter::once(0.0).chain(inner).collect()
        })
    };
    let points = quarters.iter().enumerate().flat_map(|(quarter, angles)| {
        angles.iter().map(move |&angle| on_circle(centre, radius, quarter, angle))
    });
    points.collect()
}

/// The point of a circle at an angle from the beginning of a quarter.
fn on_circle(centre: Point, radius: f64, quarter: usize, angle: f64) -> Point {
    // Exact along the axes: a side of a disc is found by comparing coordinates.
    let (sine, cosine) = libm::sincos(angle);
    let [x, y] = match quarter {
        0 => [cosine, sine],
        1 => [-sine, cosine],
        2 => [-cosine, -sine],
        _ => [sine, -cosine],
    };
    [centre[0] + radius * x, centre[1] + radius * y]
}

/// Tests whether points are inside loops: a ray from a point inside crosses an odd number of edges.
///
/// # Cost
/// Edges are sorted into rows of y. A test looks at the edges of one row.
pub struct Inside {
    bottom: f64,
    rows_per_length: f64,
    rows: Vec<Vec<[Point; 2]>>,
}

impl Inside {
    /// Mean number of rows that contain an edge, at most.
    const ROWS_OF_AN_EDGE: f64 = 64.0;

    /// Sorts the edges of loops.
    pub fn new(loops: &[Vec<Point>]) -> Self {
        let [low, high] = bounds(loops.iter().flatten().copied());
        let edges: usize = loops.iter().map(Vec::len).sum();
        let mut count = edges.clamp(1, 1 << 14);
        let height = (high[1] - low[1]).max(f64::MIN_POSITIVE);
        // Edges that go far up are in many rows: with fewer rows all have room.
        let steps: f64 = loops
            .iter()
            .flat_map(|corners| {
                (0..corners.len()).map(|k| (corners[k][1] - corners[(k + 1) % corners.len()][1]).abs())
            })
            .sum();
        let rows_of_an_edge = steps / height * count as f64 / edges.max(1) as f64;
        if rows_of_an_edge > Self::ROWS_OF_AN_EDGE {
            count = ((count as f64 * Self::ROWS_OF_AN_EDGE / rows_of_an_edge) as usize).max(1);
        }
        let mut inside =
            Self { bottom: low[1], rows_per_length: count as f64 / height, rows: vec![Vec::new(); count] };
        for corners in loops {
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                let (first, last) = (inside.row(a[1].min(b[1])), inside.row(a[1].max(b[1])));
                for row in &mut inside.rows[first..=last] {
                    row.push([a, b]);
                }
            }
        }
        inside
    }

    fn row(&self, y: f64) -> usize {
        // Below the first row and NaN become row 0: the comparison with the edges decides.
        (((y - self.bottom) * self.rows_per_length) as usize).min(self.rows.len() - 1)
    }

    /// Whether a point is inside.
    pub fn contains(&self, [x, y]: Point) -> bool {
        let mut inside = false;
        for &[a, b] in &self.rows[self.row(y)] {
            if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                inside = !inside;
            }
        }
        inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inside_of_a_square_with_a_hole() {
        let square = |low: f64, high: f64| vec![[low, low], [high, low], [high, high], [low, high]];
        let inside = Inside::new(&[square(0.0, 4.0), square(1.0, 3.0)]);
        for (point, expected) in [
            ([0.5, 0.5], true),
            ([2.0, 2.0], false),
            ([3.5, 2.0], true),
            ([5.0, 2.0], false),
            ([2.0, -1.0], false),
            ([2.0, 9.0], false),
        ] {
            assert_eq!(inside.contains(point), expected, "{point:?}");
        }
    }

    #[test]
    fn circles_reach_exactly_as_far_as_their_radius() {
        let points = circle([0.1, 0.2], 0.3, &Grading::even(0.013));
        assert_eq!(points.len() % 4, 0);
        let [low, high] = bounds(points.iter().copied());
        assert_eq!([low, high], [[0.1 - 0.3, 0.2 - 0.3], [0.1 + 0.3, 0.2 + 0.3]]);
        assert!((area(&points) - 0.09 * TAU / 2.0).abs() < 1e-3);
    }
}
