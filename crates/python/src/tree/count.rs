//! Pairs of two sets of points, counted by distance.

use super::{Far, NearSide, Norm, Tree, along};
use crate::problem::{Problem, zeros};

/// The weight of each point, and that of each node.
struct Weights {
    points: Vec<f64>,
    nodes: Vec<f64>,
}

/// Two trees whose pairs are counted.
struct Pairs<'a> {
    trees: [&'a Tree; 2],
    weights: [Weights; 2],
    norm: Norm,
    /// Ascending, in the form that is compared.
    limits: &'a [f64],
}

impl Tree {
    /// For each of the ascending distances `r` the weight of the pairs that are farther than the distance
    /// before it and not farther than it; the last entry is the weight of pairs that are farther than all.
    /// The weight of a pair is the product of the weights of its points, 1 where there are none.
    pub(crate) fn count_pairs(
        &self,
        other: &Self,
        norm: Norm,
        r: &[f64],
        weights: [Option<&[f64]>; 2],
    ) -> Result<Vec<f64>, Problem> {
        // No pair has a distance below 0.
        let limits: Vec<f64> = r.iter().map(|&r| if r < 0.0 { -1.0 } else { norm.limit(r) }).collect();
        let mut bins = zeros(limits.len() + 1)?;
        if self.len() > 0 && other.len() > 0 {
            let weights = [self.weigh(weights[0])?, other.weigh(weights[1])?];
            let pairs = Pairs { trees: [self, other], weights, norm, limits: &limits };
            pairs.count([0, 0], &mut bins);
        }
        Ok(bins)
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

impl Pairs<'_> {
    /// The first limit that a distance does not exceed.
    fn bin(&self, distance: f64) -> usize {
        self.limits.partition_point(|&limit| limit < distance)
    }

    /// The least and the greatest distance of the points of two nodes.
    fn extremes(&self, nodes: [usize; 2]) -> [f64; 2] {
        let [(low, high), (other_low, other_high)] =
            [self.trees[0].corners_of(nodes[0]), self.trees[1].corners_of(nodes[1])];
        let sides = &self.trees[0].sides;
        let ends = |axis: usize| (low[axis] - other_high[axis], high[axis] - other_low[axis], sides[axis]);
        let axes = || (0..low.len()).map(ends);
        [
            self.norm.sum(axes().map(|(from, to, side)| NearSide { from, to, side }.value())),
            self.norm.sum(axes().map(|(from, to, side)| Far { from, to, side }.value())),
        ]
    }

    fn count(&self, nodes: [usize; 2], bins: &mut [f64]) {
        let [least, greatest] = self.extremes(nodes).map(|distance| self.bin(distance));
        if least == greatest {
            bins[least] += self.weights[0].nodes[nodes[0]] * self.weights[1].nodes[nodes[1]];
            return;
        }
        let sizes = [0, 1].map(|of| self.trees[of].range(nodes[of]).len());
        match [0, 1].map(|of| self.trees[of].halves(nodes[of])) {
            [Some(halves), other] if other.is_none() || sizes[0] >= sizes[1] => {
                for half in halves {
                    self.count([half, nodes[1]], bins);
                }
            }
            [_, Some(halves)] => {
                for half in halves {
                    self.count([nodes[0], half], bins);
                }
            }
            _ => {
                for place in self.trees[0].range(nodes[0]) {
                    let row = self.trees[0].row(place);
                    for other in self.trees[1].range(nodes[1]) {
                        let axes = row.iter().zip(self.trees[1].row(other)).zip(&self.trees[0].sides);
                        let distance = self.norm.sum(axes.map(|((&x, &y), &side)| along(x - y, side)));
                        bins[self.bin(distance)] +=
                            self.weights[0].points[place] * self.weights[1].points[other];
                    }
                }
            }
        }
    }
}
