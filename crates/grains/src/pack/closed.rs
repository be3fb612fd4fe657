//! The inside of a closed surface of triangles.

use crate::vector::{Vector, cross, dot, minus, plus, times};

/// Cells along the longest side of the grid at most.
const MOST_CELLS: f64 = 100.0;

/// A closed surface of triangles, all seen counter-clockwise from outside or all from inside.
#[derive(Clone, Debug)]
pub struct ClosedSurface {
    triangles: Vec<[Vector; 3]>,
    low: Vector,
    high: Vector,
    /// Cells with the triangles that are within the reach of their points.
    near: CellLists<3>,
    /// Columns along z with the triangles that are above or below their points.
    columns: CellLists<2>,
}

/// Lists of triangles of the cells of a grid.
#[derive(Clone, Debug)]
struct CellLists<const D: usize> {
    low: [f64; D],
    width: f64,
    counts: [usize; D],
    first: Vec<usize>,
    members: Vec<u32>,
}

impl<const D: usize> CellLists<D> {
    /// The lists of boxes, each with a lowest and a highest corner.
    fn new(boxes: &[[[f64; D]; 2]], [low, high]: [[f64; D]; 2], width: f64) -> Self {
        let longest = (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let width = width.max(longest / MOST_CELLS).max(f64::MIN_POSITIVE);
        let counts = std::array::from_fn(|axis| ((high[axis] - low[axis]) / width) as usize + 1);
        let mut lists = Self { low, width, counts, first: Vec::new(), members: Vec::new() };
        let mut entries: Vec<(usize, u32)> = Vec::new();
        for (number, corners) in (0..).zip(boxes) {
            let [from, to] = corners.map(|corner| lists.cell(corner));
            let mut cell = from;
            loop {
                entries.push((lists.number(cell), number));
                let Some(axis) = (0..D).find(|&axis| cell[axis] < to[axis]) else { break };
                cell[axis] += 1;
                cell[..axis].copy_from_slice(&from[..axis]);
            }
        }
        entries.sort_unstable();
        let cells: usize = counts.iter().product();
        lists.first = (0..=cells).map(|cell| entries.partition_point(|entry| entry.0 < cell)).collect();
        lists.members = entries.into_iter().map(|(_, member)| member).collect();
        lists
    }

    /// The cell of a point; of one outside the grid the nearest cell.
    fn cell(&self, point: [f64; D]) -> [usize; D] {
        std::array::from_fn(|axis| {
            let place = (point[axis] - self.low[axis]) / self.width;
            (place.max(0.0) as usize).min(self.counts[axis] - 1)
        })
    }

    fn number(&self, cell: [usize; D]) -> usize {
        (0..D).rev().fold(0, |number, axis| number * self.counts[axis] + cell[axis])
    }

    /// The triangles of the cell of a point.
    fn at(&self, point: [f64; D]) -> &[u32] {
        let cell = self.number(self.cell(point));
        &self.members[self.first[cell]..self.first[cell + 1]]
    }
}

impl ClosedSurface {
    /// A surface of triangles, which the caller has checked to be closed.
    pub fn new(triangles: Vec<[[f64; 3]; 3]>) -> Self {
        let corners = || triangles.iter().flatten();
        let fold = |with: fn(f64, f64) -> f64, start: f64| {
            [0, 1, 2].map(|axis| corners().map(|corner| corner[axis]).fold(start, with))
        };
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        let flat = |corner: Vector| [corner[0], corner[1]];
        let boxes: Vec<[[f64; 2]; 2]> = triangles
            .iter()
            .map(|triangle| {
                let [low, high] = bounds(triangle);
                [flat(low), flat(high)]
            })
            .collect();
        let width = (high[0] - low[0]).max(high[1] - low[1]) / (triangles.len() as f64).sqrt();
        let columns = CellLists::new(&boxes, [flat(low), flat(high)], width);
        let near = CellLists { low, width: 1.0, counts: [1; 3], first: vec![0; 2], members: Vec::new() };
        Self { triangles, low, high, near, columns }
    }

    /// Volume inside, m³.
    pub fn volume(&self) -> f64 {
        let of = |&[a, b, c]: &[Vector; 3]| {
            let [a, b, c] = [a, b, c].map(|corner| minus(corner, self.low));
            dot(a, cross(b, c)) / 6.0
        };
        self.triangles.iter().map(of).sum::<f64>().abs()
    }

    /// The corners of a box around it, m.
    pub(crate) fn bounds(&self) -> [Vector; 2] {
        [self.low, self.high]
    }

    /// Lists the triangles that are near to points, within `reach`, m.
    pub(crate) fn prepare(&mut self, reach: f64) {
        let boxes: Vec<[Vector; 2]> = self
            .triangles
            .iter()
            .map(|triangle| {
                let [low, high] = bounds(triangle);
                [low.map(|x| x - reach), high.map(|x| x + reach)]
            })
            .collect();
        self.near = CellLists::new(&boxes, [self.low, self.high], reach);
    }

    /// Visits the nearest points of all triangles that may be within reach.
    pub(crate) fn near(&self, point: Vector, visit: &mut dyn FnMut(Vector)) {
        for &triangle in self.near.at(point) {
            visit(nearest_on_triangle(point, self.triangles[triangle as usize]));
        }
    }

    /// Whether a point is inside: a line upwards from it leaves the surface once more than it enters it.
    pub(crate) fn contains(&self, point: Vector) -> bool {
        let outside = (0..3).any(|axis| point[axis] < self.low[axis] || point[axis] > self.high[axis]);
        if outside {
            return false;
        }
        let triangles = self.columns.at([point[0], point[1]]).iter();
        triangles.filter(|&&triangle| is_above(point, self.triangles[triangle as usize])).count() % 2 == 1
    }
}

/// The corners of a box around a triangle.
fn bounds(triangle: &[Vector; 3]) -> [Vector; 2] {
    let fold = |with: fn(f64, f64) -> f64| {
        [0, 1, 2].map(|axis| triangle.iter().map(|corner| corner[axis]).reduce(with).unwrap_or(0.0))
    };
    [fold(f64::min), fold(f64::max)]
}

/// Whether a triangle is above a point. An edge that is exactly above it belongs to one of its triangles.
fn is_above(point: Vector, triangle: [Vector; 3]) -> bool {
    // The edges are cut by a line along x, from the point to the right.
    let mut crossings = 0;
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let [mut a, mut b] = [triangle[from], triangle[to]];
        if a[1] > b[1] {
            (a, b) = (b, a);
        }
        if (a[1] <= point[1]) == (b[1] <= point[1]) {
            continue;
        }
        let side = (b[0] - a[0]) * (point[1] - a[1]) - (point[0] - a[0]) * (b[1] - a[1]);
        crossings += usize::from(side > 0.0);
    }
    if crossings % 2 == 0 {
        return false;
    }
    let [a, b, c] = triangle;
    let normal = cross(minus(b, a), minus(c, a));
    let distance = dot(normal, minus(a, point));
    normal[2] != 0.0 && distance / normal[2] > 0.0
}

/// The point of a triangle that is nearest to a point (Ericson, "Real-time collision detection", 2005).
pub(crate) fn nearest_on_triangle(point: Vector, [a, b, c]: [Vector; 3]) -> Vector {
    let [ab, ac, ap] = [minus(b, a), minus(c, a), minus(point, a)];
    let [d1, d2] = [dot(ab, ap), dot(ac, ap)];
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = minus(point, b);
    let [d3, d4] = [dot(ab, bp), dot(ac, bp)];
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return plus(a, times(d1 / (d1 - d3), ab));
    }
    let cp = minus(point, c);
    let [d5, d6] = [dot(ab, cp), dot(ac, cp)];
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return plus(a, times(d2 / (d2 - d6), ac));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return plus(b, times((d4 - d3) / ((d4 - d3) + (d5 - d6)), minus(c, b)));
    }
    let scale = 1.0 / (va + vb + vc);
    plus(a, plus(times(vb * scale, ab), times(vc * scale, ac)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of two triangles a side.
    fn cube() -> ClosedSurface {
        let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| bit as f64);
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        ClosedSurface::new(triangles.map(|triangle| triangle.map(corner)).collect())
    }

    #[test]
    fn a_box_has_its_volume_and_its_inside() {
        let mut cube = cube();
        assert!((cube.volume() - 1.0).abs() < 1e-14);
        cube.prepare(0.3);
        for k in 0..1000 {
            // Points on a grid, many of them above edges and diagonals.
            let point = [k % 10, k / 10 % 10, k / 100].map(|x| 0.25 * f64::from(x) - 0.625);
            let is_inside = point.iter().all(|x| (0.0..1.0).contains(x));
            assert_eq!(cube.contains(point), is_inside, "{point:?}");
        }
        let mut nearest = f64::INFINITY;
        let point = [0.5, 0.5, 0.8];
        cube.near(point, &mut |at| nearest = nearest.min(dot(minus(at, point), minus(at, point)).sqrt()));
        assert!((nearest - 0.2).abs() < 1e-15);
    }
}
