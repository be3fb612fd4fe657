//! Pairs of two sets of points, counted by distance.

use std::ops::{AddAssign, Mul};
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use super::metric::{Metric, with_metric};
use super::{Norm, Tree};
use crate::problem::{Problem, zeros};

/// Weights of the points and of the nodes of a tree.
trait Weigh {
    /// Sum of products of weights.
    type Sum: Copy + Default + AddAssign + Mul<Output = Self::Sum>;

    fn point(&self, place: usize) -> Self::Sum;

    fn node(&self, node: usize) -> Self::Sum;
}

/// Each point of a tree counts once.
struct Ones<'a>(&'a Tree);

impl Weigh for Ones<'_> {
    type Sum = u64;

    #[inline]
    fn point(&self, _: usize) -> u64 {
        1
    }

    fn node(&self, node: usize) -> u64 {
        self.0.range(node).len() as u64
    }
}

/// The weight of each point, and that of each node.
struct Weights {
    points: Vec<f64>,
    nodes: Vec<f64>,
}

impl Weigh for Weights {
    type Sum = f64;

    #[inline]
    fn point(&self, place: usize) -> f64 {
        self.points[place]
    }

    fn node(&self, node: usize) -> f64 {
        self.nodes[node]
    }
}

/// Two trees whose pairs are counted.
struct Pairs<'a, W, M> {
    trees: [&'a Tree; 2],
    weights: [W; 2],
    metric: M,
    /// Ascending, in the form that is compared.
    limits: &'a [f64],
    /// Once it is set, the rest is not counted.
    stop: &'a AtomicBool,
}

impl Tree {
    /// For each of the ascending distances `r` the weight of the pairs that are farther than the distance
    /// before it and not farther than it; the last entry is the weight of pairs that are farther than all.
    /// The weight of a pair is the product of the weights of its points, 1 where there are none. Once `stop`
    /// is set, the rest is not counted.
    pub(crate) fn count_pairs(
        &self,
        other: &Self,
        norm: Norm,
        r: &[f64],
        weights: [Option<&[f64]>; 2],
        stop: &AtomicBool,
    ) -> Result<Vec<f64>, Problem> {
        // No pair has a distance below 0.
        let limits: Vec<f64> = r.iter().map(|&r| if r < 0.0 { -1.0 } else { norm.limit(r) }).collect();
        if self.len() == 0 || other.len() == 0 {
            return zeros(limits.len() + 1);
        }
        let trees = [self, other];
        // A pair of two points of one tree is counted twice, and found once.
        let is_one = std::ptr::eq(self, other)
            && weights[0].map(<[f64]>::as_ptr_range) == weights[1].map(<[f64]>::as_ptr_range);
        with_metric!(self, norm, metric => {
            if let [None, None] = weights {
                let weights = trees.map(Ones);
                let counts = Pairs { trees, weights, metric, limits: &limits, stop }.all(is_one)?;
                Ok(counts.into_iter().map(|count| count as f64).collect())
            } else {
                let weights = [self.weigh(weights[0])?, other.weigh(weights[1])?];
                Pairs { trees, weights, metric, limits: &limits, stop }.all(is_one)
            }
        })
    }

    /// The weight of each node.
    pub(crate) fn node_weights(&self, weights: &[f64]) -> Result<Vec<f64>, Problem> {
        Ok(self.weigh(Some(weights))?.nodes)
    }

    fn weigh(&self, weights: Option<&[f64]>) -> Result<Weights, Problem> {
        let mut points = zeros(self.len())?;
        for (weight, &number) in points.iter_mut().zip(&self.numbers) {
            *weight = weights.map_or(1.0, |weights| weights[number as usize]);
        }
        let mut nodes = zeros(self.nodes.len())?;
        // Halves come after their node.
        for node in (0..nodes.len()).rev() {
            nodes[node] = match self.halves(node) {
                Some([left, right]) => nodes[left] + nodes[right],
                None => points[self.range(node)].iter().sum(),
            };
        }
        Ok(Weights { points, nodes })
    }
}

impl<W: Weigh, M: Metric> Pairs<'_, W, M> {
    /// The sums for all limits. `is_one`: both trees are one, and their weights too.
    fn all(&self, is_one: bool) -> Result<Vec<W::Sum>, Problem> {
        let mut bins = zeros(self.limits.len() + 1)?;
        if is_one {
            let mut once = zeros(bins.len())?;
            self.count_own(0, &mut bins, &mut once);
            for (bin, once) in bins.iter_mut().zip(once) {
                *bin += once;
                *bin += once;
            }
        } else {
            self.count([0, 0], [0, self.limits.len()], &mut bins);
        }
        Ok(bins)
    }

    /// The first limit of those from `first` to `last` that a distance does not exceed; `last` if it exceeds
    /// the others.
    #[inline]
    fn bin(&self, [first, last]: [usize; 2], distance: f64) -> usize {
        first + self.limits[first..last].partition_point(|&limit| limit < distance)
    }

    /// The bins of the least and of the greatest distance of the points of two nodes.
    #[inline]
    fn bins_of(&self, nodes: [usize; 2], bins: [usize; 2]) -> [usize; 2] {
        let corners = [self.trees[0].corners_of(nodes[0]), self.trees[1].corners_of(nodes[1])];
        let least = self.bin(bins, self.metric.least(corners[0], corners[1]));
        [least, self.bin([least, bins[1]], self.metric.greatest(corners[0], corners[1]))]
    }

    /// Counts the pairs of two nodes, whose bins are among `among`.
    fn count(&self, nodes: [usize; 2], among: [usize; 2], bins: &mut [W::Sum]) {
        if self.stop.load(Relaxed) {
            return;
        }
        let among = self.bins_of(nodes, among);
        if among[0] == among[1] {
            bins[among[0]] += self.weights[0].node(nodes[0]) * self.weights[1].node(nodes[1]);
            return;
        }
        let sizes = [0, 1].map(|of| self.trees[of].range(nodes[of]).len());
        match [0, 1].map(|of| self.trees[of].halves(nodes[of])) {
            [Some(halves), other] if other.is_none() || sizes[0] >= sizes[1] => {
                for half in halves {
                    self.count([half, nodes[1]], among, bins);
                }
            }
            [_, Some(halves)] => {
                for half in halves {
                    self.count([nodes[0], half], among, bins);
                }
            }
            _ => {
                for place in self.trees[0].range(nodes[0]) {
                    self.count_row(place, self.trees[1].range(nodes[1]), among, bins);
                }
            }
        }
    }

    /// Counts the pairs of a point of the first tree and of points of a leaf of the second one.
    #[inline]
    fn count_row(
        &self,
        place: usize,
        others: std::ops::Range<usize>,
        among: [usize; 2],
        bins: &mut [W::Sum],
    ) {
        let (row, weight) = (self.trees[0].row(place), self.weights[0].point(place));
        let distance = |other| self.metric.distance(row, self.trees[1].row(other));
        if among[1] == among[0] + 1 {
            // One limit decides.
            let limit = self.limits[among[0]];
            let mut sums = [W::Sum::default(); 2];
            for other in others {
                sums[usize::from(distance(other) > limit)] += self.weights[1].point(other);
            }
            bins[among[0]] += weight * sums[0];
            bins[among[1]] += weight * sums[1];
        } else {
            for other in others {
                bins[self.bin(among, distance(other))] += weight * self.weights[1].point(other);
            }
        }
    }

    /// Counts the pairs of a node of the one tree: those of a point with itself in `bins`, the pairs of two
    /// points, each once, in `once`.
    fn count_own(&self, node: usize, bins: &mut [W::Sum], once: &mut [W::Sum]) {
        let all = [0, self.limits.len()];
        if let Some([left, right]) = self.trees[0].halves(node) {
            self.count_own(left, bins, once);
            self.count_own(right, bins, once);
            self.count([left, right], all, once);
            return;
        }
        let end = self.trees[0].range(node).end;
        for place in self.trees[0].range(node) {
            let weight = self.weights[0].point(place);
            bins[self.bin(all, 0.0)] += weight * weight;
            self.count_row(place, place + 1..end, all, once);
        }
    }
}
