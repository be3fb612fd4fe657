//! A k-d tree for any number of dimensions, any Minkowski norm and boxes that repeat: the questions to
//! `SciPy`'s tree that sorted rows do not answer.
//!
//! Nodes have the smallest box around their points. The bound for a node is computed by the operations that
//! compute the distance of a point, in the same order; each of them is monotone as it rounds, so no rounding
//! makes a node seem farther (or less far) than its points.

mod count;
mod metric;
mod norm;

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use crate::problem::{Problem, zeros};
use metric::{Metric, with_metric};
pub(crate) use norm::Norm;

/// Points, sorted into a binary tree.
#[derive(Debug)]
pub(crate) struct Tree {
    dimensions: usize,
    /// Coordinates in the order of the leaves, and the number of each point.
    points: Vec<f64>,
    numbers: Vec<u32>,
    /// A node, then all nodes of its left half, then those of its right half.
    nodes: Vec<Node>,
    /// For each node the lower corner of its box, then the upper one.
    corners: Vec<f64>,
    /// Length of the box that repeats, on each axis; 0 where nothing repeats.
    sides: Vec<f64>,
    /// Whether one of them repeats.
    repeats: bool,
    /// Most points of a leaf, unless they are in one place.
    leaf: usize,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    start: u32,
    end: u32,
    /// The node of the right half; 0 for a leaf. The next node is that of the left half.
    right: u32,
}

/// A point that was found: ordered by its distance, then by its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// In the form that [`Norm`] compares.
    pub(crate) distance: f64,
    pub(crate) number: u32,
}

impl Eq for Hit {}

impl PartialOrd for Hit {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Hit {
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.number.cmp(&other.number))
    }
}

impl Tree {
    /// Sorts `points`, rows of `dimensions` finite numbers; where `sides` are positive the numbers are at
    /// least 0 and below them. Leaves have up to `leaf` points. Once `stop` is set, the rest stays unsorted,
    /// and the tree must not be used.
    pub(crate) fn new(
        points: &[f64],
        dimensions: usize,
        sides: &[f64],
        leaf: usize,
        stop: &AtomicBool,
    ) -> Result<Self, Problem> {
        let n = points.len().checked_div(dimensions).unwrap_or(0);
        let too_many = || Problem::Arguments(format!("{n} points are too many"));
        let mut numbers = zeros::<u32>(n)?;
        for (number, place) in numbers.iter_mut().zip(0..) {
            *number = place;
        }
        u32::try_from(n).map_err(|_| too_many())?;
        let mut tree = Self {
            dimensions,
            points: zeros(points.len())?,
            numbers,
            nodes: Vec::new(),
            corners: Vec::new(),
            sides: sides.to_vec(),
            repeats: sides.iter().any(|&side| side > 0.0),
            leaf: leaf.max(1),
        };
        if n > 0 {
            let mut numbers = std::mem::take(&mut tree.numbers);
            tree.split(points, &mut numbers, 0, stop);
            tree.numbers = numbers;
        }
        for (row, &number) in tree.points.chunks_exact_mut(dimensions.max(1)).zip(&tree.numbers) {
            if stop.load(Relaxed) {
                break;
            }
            row.copy_from_slice(&points[number as usize * dimensions..][..dimensions]);
        }
        Ok(tree)
    }

    /// Adds the node of these points, which start at `start`, and all nodes below it. Every split halves the
    /// points, so the depth is that of a logarithm.
    fn split(&mut self, points: &[f64], numbers: &mut [u32], start: usize, stop: &AtomicBool) {
        if stop.load(Relaxed) {
            return;
        }
        let dimensions = self.dimensions;
        let at = |number: u32, axis: usize| points[number as usize * dimensions + axis];
        let corner = self.corners.len();
        let first = &points[numbers[0] as usize * dimensions..][..dimensions];
        self.corners.extend_from_slice(first);
        self.corners.extend_from_slice(first);
        let (lower, upper) = self.corners[corner..].split_at_mut(dimensions);
        for &number in &*numbers {
            for axis in 0..dimensions {
                lower[axis] = lower[axis].min(at(number, axis));
                upper[axis] = upper[axis].max(at(number, axis));
            }
        }
        let widest = (0..dimensions).max_by(|&a, &b| (upper[a] - lower[a]).total_cmp(&(upper[b] - lower[b])));
        let widest = widest.filter(|&axis| numbers.len() > self.leaf && lower[axis] < upper[axis]);

        let node = self.nodes.len();
        self.nodes.push(Node { start: start as u32, end: (start + numbers.len()) as u32, right: 0 });
        if let Some(axis) = widest {
            let half = numbers.len() / 2;
            // Equal coordinates are ordered by the number of the point: the tree is a function of the points
            // alone.
            numbers
                .select_nth_unstable_by(half, |&a, &b| at(a, axis).total_cmp(&at(b, axis)).then(a.cmp(&b)));
            let (left, right) = numbers.split_at_mut(half);
            self.split(points, left, start, stop);
            self.nodes[node].right = self.nodes.len() as u32;
            self.split(points, right, start + half, stop);
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.numbers.len()
    }

    fn corners_of(&self, node: usize) -> [&[f64]; 2] {
        let (lower, upper) =
            self.corners[2 * node * self.dimensions..][..2 * self.dimensions].split_at(self.dimensions);
        [lower, upper]
    }

    fn range(&self, node: usize) -> Range<usize> {
        self.nodes[node].start as usize..self.nodes[node].end as usize
    }

    fn halves(&self, node: usize) -> Option<[usize; 2]> {
        let right = self.nodes[node].right as usize;
        (right > 0).then_some([node + 1, right])
    }

    fn row(&self, place: usize) -> &[f64] {
        &self.points[place * self.dimensions..][..self.dimensions]
    }

    /// The places of the first and the last point of each node, and the node of its right half, 0 for a leaf.
    pub(crate) fn nodes(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + '_ {
        self.nodes.iter().map(|node| [node.start, node.end, node.right])
    }

    /// The number of the point at each place.
    pub(crate) fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// The image of a point in the box, where that repeats.
    pub(crate) fn wrap(&self, at: &mut [f64]) {
        for (x, &side) in at.iter_mut().zip(&self.sides).filter(|(_, side)| **side > 0.0) {
            *x -= (*x / side).floor() * side;
            // Rounding may leave a point just outside.
            if *x < 0.0 {
                *x += side;
            }
            if *x >= side {
                *x -= side;
            }
        }
    }

    /// The `k` points nearest to `at` that are nearer than `bound`, the nearest first.
    pub(crate) fn nearest(&self, norm: Norm, at: &[f64], k: usize, bound: f64) -> Vec<Hit> {
        let mut hits = BinaryHeap::new();
        if self.len() > 0 && k > 0 {
            let bound = norm.limit(bound);
            with_metric!(self, norm, metric => self.look(metric, at, k, bound, 0, &mut hits));
        }
        hits.into_sorted_vec()
    }

    fn look(
        &self,
        metric: impl Metric,
        at: &[f64],
        k: usize,
        bound: f64,
        node: usize,
        hits: &mut BinaryHeap<Hit>,
    ) {
        let Some(halves) = self.halves(node) else {
            for place in self.range(node) {
                let hit = Hit { distance: metric.distance(at, self.row(place)), number: self.numbers[place] };
                if hit.distance < bound && (hits.len() < k || hits.peek().is_some_and(|worst| hit < *worst)) {
                    if hits.len() == k {
                        hits.pop();
                    }
                    hits.push(hit);
                }
            }
            return;
        };
        let mut halves = halves.map(|half| (metric.least([at, at], self.corners_of(half)), half));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (least, half) in halves {
            // Up to and including the distance of the worst hit: there may be a point of smaller number.
            let worst = if hits.len() < k { None } else { hits.peek() };
            if least < bound && worst.is_none_or(|worst| least <= worst.distance) {
                self.look(metric, at, k, bound, half, hits);
            }
        }
    }

    /// Calls `visit` with each point at most `r` away from `at`.
    pub(crate) fn within(&self, norm: Norm, at: &[f64], r: f64, visit: &mut impl FnMut(Hit)) {
        if self.len() > 0 && r >= 0.0 {
            let limit = norm.limit(r);
            with_metric!(self, norm, metric => self.visit_within(metric, at, limit, 0, visit));
        }
    }

    fn visit_within(
        &self,
        metric: impl Metric,
        at: &[f64],
        limit: f64,
        node: usize,
        visit: &mut impl FnMut(Hit),
    ) {
        if metric.least([at, at], self.corners_of(node)) > limit {
            return;
        }
        if let Some(halves) = self.halves(node) {
            for half in halves {
                self.visit_within(metric, at, limit, half, visit);
            }
            return;
        }
        for place in self.range(node) {
            let distance = metric.distance(at, self.row(place));
            if distance <= limit {
                visit(Hit { distance, number: self.numbers[place] });
            }
        }
    }

    /// The number of points at most `r` away from `at`.
    pub(crate) fn count_within(&self, norm: Norm, at: &[f64], r: f64) -> usize {
        if self.len() == 0 || r.is_nan() || r < 0.0 {
            return 0;
        }
        let limit = norm.limit(r);
        with_metric!(self, norm, metric => self.counted_within(metric, at, limit, 0))
    }

    fn counted_within(&self, metric: impl Metric, at: &[f64], limit: f64, node: usize) -> usize {
        let corners = self.corners_of(node);
        if metric.least([at, at], corners) > limit {
            return 0;
        }
        if metric.greatest([at, at], corners) <= limit {
            return self.range(node).len();
        }
        match self.halves(node) {
            Some(halves) => halves.into_iter().map(|half| self.counted_within(metric, at, limit, half)).sum(),
            None => self.range(node).filter(|&place| metric.distance(at, self.row(place)) <= limit).count(),
        }
    }
}
