//! The size of elements from place to place.

use super::vector::{Point, distance};
use crate::grading::GROWTH;

/// Nodes of the grid along the longest edge of the bounding box.
const NODES: f64 = 100.0;

/// Nodes along it when it is found out whether the size is the same everywhere.
const FEW: f64 = 12.0;

/// Sizes that grow by at most [`GROWTH`] times the distance.
pub(crate) enum Sizes<'a> {
    Even(f64),
    /// The smaller of two: the values of a grid, which grow slowly, and the size itself, which may be smaller
    /// between the nodes of the grid.
    Graded(Grid, &'a dyn Fn(Point) -> f64),
}

impl<'a> Sizes<'a> {
    /// Samples `size` in the box from `low` to `high` and at some places, and limits how it grows. The error
    /// is the first place where it is no positive number.
    ///
    /// Whether the size varies is found out from samples, unless it `varies` for certain.
    pub(crate) fn new(
        size: &'a dyn Fn(Point) -> f64,
        low: Point,
        high: Point,
        places: &[Point],
        varies: bool,
    ) -> Result<Self, Point> {
        let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let read = |place: Point| {
            let value = size(place);
            if value > 0.0 { Ok(value.min(longest)) } else { Err(place) }
        };
        let at_places = places.iter().map(|&place| read(place)).collect::<Result<Vec<f64>, Point>>()?;
        let mut few = Grid::new(low, high, longest / FEW);
        few.fill(&read)?;
        let values = || few.values.iter().chain(&at_places);
        let first = few.values[0];
        if !varies && values().all(|&value| value == first) {
            return Ok(Self::Even(first));
        }
        let least = values().fold(f64::INFINITY, |least, &value| least.min(value));
        let mut grid = Grid::new(low, high, (longest / NODES).max(0.5 * least));
        grid.fill(&read)?;
        for (&place, &value) in places.iter().zip(&at_places) {
            grid.lower(place, value);
        }
        grid.limit();
        Ok(Self::Graded(grid, size))
    }

    /// Limits the sizes at places: nothing is changed where they are not smaller.
    pub(crate) fn lower(&mut self, limits: &[(Point, f64)], low: Point, high: Point) {
        let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        if limits.iter().all(|&(place, value)| value >= self.at(place)) {
            return;
        }
        if let Self::Even(size) = *self {
            let mut grid = Grid::new(low, high, (longest / NODES).max(0.5 * size));
            grid.values.fill(size);
            *self = Self::Graded(grid, &|_| f64::INFINITY);
        }
        if let Self::Graded(grid, _) = self {
            for &(place, value) in limits {
                grid.lower(place, value);
            }
            grid.limit();
        }
    }

    #[inline]
    pub(crate) fn at(&self, place: Point) -> f64 {
        match self {
            Self::Even(size) => *size,
            Self::Graded(grid, size) => grid.at(place).min(size(place)),
        }
    }
}

/// Values at the nodes of a grid, linear between them.
pub(crate) struct Grid {
    low: Point,
    edge: f64,
    nodes: [usize; 3],
    values: Vec<f64>,
}

impl Grid {
    fn new(low: Point, high: Point, edge: f64) -> Self {
        let nodes = [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / edge).ceil() as usize + 1);
        Self { low, edge, nodes, values: vec![f64::INFINITY; nodes[0] * nodes[1] * nodes[2]] }
    }

    fn fill(&mut self, read: &dyn Fn(Point) -> Result<f64, Point>) -> Result<(), Point> {
        let [columns, rows, layers] = self.nodes;
        for z in 0..layers {
            for y in 0..rows {
                for x in 0..columns {
                    let place = [0, 1, 2].map(|axis| self.low[axis] + [x, y, z][axis] as f64 * self.edge);
                    self.values[(z * rows + y) * columns + x] = read(place)?;
                }
            }
        }
        Ok(())
    }

    /// The cell of a place, and where in it the place is, from 0 to 1.
    #[inline]
    fn cell(&self, place: Point) -> ([usize; 3], Point) {
        let mut cell = [0; 3];
        let mut part = [0.0; 3];
        for axis in 0..3 {
            let last = self.nodes[axis].saturating_sub(2);
            let steps = ((place[axis] - self.low[axis]) / self.edge).max(0.0);
            cell[axis] = (steps as usize).min(last);
            part[axis] = (steps - cell[axis] as f64).min(1.0);
        }
        (cell, part)
    }

    /// The nodes around a place, with their weights.
    #[inline]
    fn around(&self, place: Point) -> [(usize, f64); 8] {
        let (cell, part) = self.cell(place);
        [0, 1, 2, 3, 4, 5, 6, 7].map(|k: usize| {
            let bit = [k & 1, k >> 1 & 1, k >> 2];
            let [x, y, z] = [0, 1, 2].map(|axis| (cell[axis] + bit[axis]).min(self.nodes[axis] - 1));
            let weight =
                (0..3).map(|axis| if bit[axis] == 1 { part[axis] } else { 1.0 - part[axis] }).product();
            ((z * self.nodes[1] + y) * self.nodes[0] + x, weight)
        })
    }

    #[inline]
    fn at(&self, place: Point) -> f64 {
        self.around(place).iter().map(|&(node, weight)| weight * self.values[node]).sum()
    }

    /// Makes the value at a place `value` at most.
    fn lower(&mut self, place: Point, value: f64) {
        let columns = self.nodes[0];
        for (node, _) in self.around(place) {
            let (x, y, z) = (node % columns, node / columns % self.nodes[1], node / columns / self.nodes[1]);
            let at = [0, 1, 2].map(|axis| self.low[axis] + [x, y, z][axis] as f64 * self.edge);
            let most = value + GROWTH * distance(at, place);
            self.values[node] = self.values[node].min(most);
        }
    }

    /// Limits the growth: sweeps over all nodes, there and back, until nothing changes.
    fn limit(&mut self) {
        let [columns, rows, layers] = self.nodes.map(usize::cast_signed);
        let mut behind = Vec::new();
        for dz in -1..=1_isize {
            for dy in -1..=1_isize {
                for dx in -1..=1_isize {
                    if (dz, dy, dx) < (0, 0, 0) {
                        let far = ((dx * dx + dy * dy + dz * dz) as f64).sqrt();
                        behind.push(([dx, dy, dz], GROWTH * self.edge * far));
                    }
                }
            }
        }
        let count = columns * rows * layers;
        for round in 0..8 {
            let forward = round % 2 == 0;
            let mut changed = false;
            for step in 0..count {
                let node = if forward { step } else { count - 1 - step };
                let (x, y, z) = (node % columns, node / columns % rows, node / columns / rows);
                let mut value = self.values[node as usize];
                for &([dx, dy, dz], growth) in &behind {
                    let sign = if forward { 1 } else { -1 };
                    let [x, y, z] = [x + sign * dx, y + sign * dy, z + sign * dz];
                    if (0..columns).contains(&x) && (0..rows).contains(&y) && (0..layers).contains(&z) {
                        value = value.min(self.values[((z * rows + y) * columns + x) as usize] + growth);
                    }
                }
                changed |= value < self.values[node as usize];
                self.values[node as usize] = value;
            }
            if !changed && round > 0 {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_grow_slowly_from_a_small_one() {
        let size = |place: Point| if place == [0.0; 3] { 0.01 } else { 1.0 };
        let sizes = Sizes::new(&size, [0.0; 3], [1.0; 3], &[[0.0; 3]], false).unwrap();
        assert!(sizes.at([0.0; 3]) < 0.0101);
        for k in 0..=10 {
            let x = f64::from(k) / 10.0;
            let right = 0.01 + 0.3 * 3.0_f64.sqrt() * x;
            assert!((sizes.at([x, x, x]) - right).abs() < 0.01, "{}", sizes.at([x, x, x]));
        }
    }

    #[test]
    fn one_size_is_one_number_and_no_size_is_an_error() {
        assert!(matches!(Sizes::new(&|_| 0.25, [0.0; 3], [1.0; 3], &[], false), Ok(Sizes::Even(0.25))));
        assert!(
            Sizes::new(&|p: Point| if p[0] > 0.5 { f64::NAN } else { 1.0 }, [0.0; 3], [1.0; 3], &[], false)
                .is_err()
        );
    }
}
