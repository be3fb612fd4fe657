//! A tree of boxes, for facets near a place.

use crate::vector::Vector;

/// Facets of a leaf, at most.
const LEAF: usize = 4;

/// A box along the axes: least and greatest coordinates, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    low: Vector,
    high: Vector,
}

/// A node: a leaf if it has facets, or else its two children follow, the second at `second`.
#[derive(Clone, Debug)]
struct Node {
    bounds: Bounds,
    second: u32,
    begin: u32,
    count: u32,
}

/// A tree of boxes around facets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    facets: Vec<u32>,
}

impl Bounds {
    const NOTHING: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// The box around a facet.
    pub(crate) fn around(facet: [u32; 3], points: &[Vector]) -> Self {
        let mut bounds = Self::NOTHING;
        for point in facet.map(|p| points[p as usize]) {
            bounds.include(&Self { low: point, high: point });
        }
        bounds
    }

    fn include(&mut self, other: &Self) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    fn middle(&self, axis: usize) -> f64 {
        0.5 * (self.low[axis] + self.high[axis])
    }

    /// Square of the distance to a place, m².
    #[inline]
    fn square_distance(&self, place: Vector) -> f64 {
        let mut square = 0.0;
        for (axis, at) in place.into_iter().enumerate() {
            let out = (self.low[axis] - at).max(at - self.high[axis]).max(0.0);
            square += out * out;
        }
        square
    }
}

impl Tree {
    pub(crate) fn new(corners: &[[u32; 3]], points: &[Vector]) -> Self {
        let mut bounds: Vec<(Bounds, u32)> = corners
            .iter()
            .enumerate()
            .map(|(number, facet)| (Bounds::around(*facet, points), number as u32))
            .collect();
        let mut tree = Self { nodes: Vec::new(), facets: Vec::with_capacity(corners.len()) };
        if !bounds.is_empty() {
            tree.grow(&mut bounds);
        }
        tree
    }

    /// Adds the node of some facets: halves along the longest side of the box of their middles.
    fn grow(&mut self, of: &mut [(Bounds, u32)]) {
        let (mut bounds, mut middles) = (Bounds::NOTHING, Bounds::NOTHING);
        for (one, _) in of.iter() {
            bounds.include(one);
            let middle = [0, 1, 2].map(|axis| one.middle(axis));
            middles.include(&Bounds { low: middle, high: middle });
        }
        let (node, begin) = (self.nodes.len(), self.facets.len() as u32);
        self.nodes.push(Node { bounds, second: 0, begin, count: of.len() as u32 });
        if of.len() <= LEAF {
            self.facets.extend(of.iter().map(|(_, facet)| *facet));
            return;
        }
        let side = |axis: usize| middles.high[axis] - middles.low[axis];
        let mut axis = usize::from(side(1) > side(0));
        if side(2) > side(axis) {
            axis = 2;
        }
        let half = of.len() / 2;
        of.select_nth_unstable_by(half, |(a, i), (b, j)| {
            a.middle(axis).total_cmp(&b.middle(axis)).then(i.cmp(j))
        });
        let (first, second) = of.split_at_mut(half);
        self.grow(first);
        let next = self.nodes.len() as u32;
        self.grow(second);
        (self.nodes[node].second, self.nodes[node].count) = (next, 0);
    }

    /// Calls a function for the facets whose box is closer to a place than `reach`, m. Returns a distance
    /// that no other facet is below: at most `horizon`, m.
    pub(crate) fn visit(&self, place: Vector, [reach, horizon]: [f64; 2], mut visit: impl FnMut(u32)) -> f64 {
        let mut least = horizon * horizon;
        let mut stack = [0_u32; 64];
        let mut height = usize::from(!self.nodes.is_empty());
        while height > 0 {
            height -= 1;
            let number = stack[height] as usize;
            let node = &self.nodes[number];
            let square = node.bounds.square_distance(place);
            if square >= least {
                continue;
            }
            if node.count > 0 {
                if square < reach * reach {
                    self.facets[node.begin as usize..(node.begin + node.count) as usize]
                        .iter()
                        .for_each(|&facet| visit(facet));
                } else {
                    least = square;
                }
                continue;
            }
            stack[height] = node.second;
            stack[height + 1] = number as u32 + 1;
            height += 2;
        }
        least.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_facets_within_reach_are_visited() {
        let mut points: Vec<Vector> = Vec::new();
        let mut corners = Vec::new();
        for k in 0..500_u32 {
            let at = |n: u32| f64::from((k * n) % 101) * 0.1;
            let base = [at(17), at(31), at(59)];
            let first = points.len() as u32;
            points.extend([0, 1, 2].map(|axis| {
                let mut point = base;
                point[axis] += 0.3;
                point
            }));
            corners.push([first, first + 1, first + 2]);
        }
        let tree = Tree::new(&corners, &points);
        for k in 0..200_u32 {
            let at = |n: u32| f64::from((k * n) % 83) * 0.15 - 1.0;
            let (place, reach) = ([at(13), at(29), at(41)], 0.2 + 0.01 * f64::from(k));
            let mut found = vec![false; corners.len()];
            let rest = tree.visit(place, [reach, 3.0 * reach], |facet| found[facet as usize] = true);
            for (facet, found) in corners.iter().zip(found) {
                let distance = Bounds::around(*facet, &points).square_distance(place).sqrt();
                assert!(found || distance >= reach);
                assert!(found || distance >= rest * (1.0 - 1e-15));
            }
        }
    }
}
