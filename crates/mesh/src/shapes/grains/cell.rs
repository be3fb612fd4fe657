//! Convex polyhedra that are cut by planes.

use std::collections::BTreeMap;

use crate::tetrahedra::vector::{Point, cross, distance, dot, minus, plus, times};

/// The neighbour behind a face of a cell.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Behind {
    /// The outside, beyond a plane of the body.
    Body(u32),
    /// Another grain.
    Grain(u32),
}

/// A convex polyhedron.
#[derive(Clone)]
pub(crate) struct Cell {
    pub(crate) points: Vec<Point>,
    /// The neighbour behind each face, and its corners, counter-clockwise seen from outside.
    pub(crate) faces: Vec<(Behind, Vec<u32>)>,
}

impl Cell {
    /// Removes the part beyond the plane through a point, in the direction of a normal.
    pub(crate) fn cut(&mut self, normal: Point, through: Point, behind: Behind) {
        let heights: Vec<f64> = self.points.iter().map(|&point| dot(normal, minus(point, through))).collect();
        let is_gone = |node: u32| heights[node as usize] > 0.0;
        if !self.faces.iter().flat_map(|(_, corners)| corners).any(|&node| is_gone(node)) {
            return;
        }
        let mut crossings: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut next: BTreeMap<u32, u32> = BTreeMap::new();
        let mut faces = Vec::with_capacity(self.faces.len() + 1);
        for (other, corners) in &self.faces {
            let mut kept = Vec::with_capacity(corners.len() + 1);
            let [mut leaves, mut enters] = [None; 2];
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                if !is_gone(a) {
                    kept.push(a);
                }
                if is_gone(a) == is_gone(b) {
                    continue;
                }
                let ends = [a.min(b), a.max(b)];
                let points = &mut self.points;
                let crossing = *crossings.entry(ends).or_insert_with(|| {
                    let [p, q] = ends.map(|end| points[end as usize]);
                    let [h, g] = ends.map(|end| heights[end as usize]);
                    points.push(plus(p, times(minus(q, p), h / (h - g))));
                    points.len() as u32 - 1
                });
                kept.push(crossing);
                if is_gone(b) {
                    leaves = Some(crossing);
                } else {
                    enters = Some(crossing);
                }
            }
            // The new face runs along this one in the other direction.
            if let (Some(leaves), Some(enters)) = (leaves, enters) {
                next.insert(enters, leaves);
            }
            if kept.len() > 2 {
                faces.push((*other, kept));
            }
        }
        if let Some((&first, _)) = next.iter().next() {
            let mut corners = vec![first];
            while let Some(&node) = corners.last().and_then(|last| next.get(last)) {
                if node == first || corners.len() > next.len() {
                    break;
                }
                corners.push(node);
            }
            if corners.len() > 2 {
                faces.push((behind, corners));
            }
        }
        self.faces = faces;
        self.compact();
    }

    /// Leaves out points without faces.
    fn compact(&mut self) {
        let mut used: Vec<u32> = self.faces.iter().flat_map(|(_, corners)| corners.iter().copied()).collect();
        used.sort_unstable();
        used.dedup();
        for node in self.faces.iter_mut().flat_map(|(_, corners)| corners) {
            *node = used.binary_search(node).unwrap_or(0) as u32;
        }
        self.points = used.iter().map(|&node| self.points[node as usize]).collect();
    }

    /// Distance of the farthest corner from a point.
    pub(crate) fn reach(&self, from: Point) -> f64 {
        self.points.iter().map(|&point| distance(point, from)).fold(0.0, f64::max)
    }

    /// Whether a point is inside.
    pub(crate) fn contains(&self, point: Point) -> bool {
        self.pyramids(point).all(|(volume, _)| volume > 0.0)
    }

    /// The triangles of all faces with a point as their common tip: volumes and centres.
    fn pyramids(&self, tip: Point) -> impl Iterator<Item = (f64, Point)> {
        self.faces.iter().flat_map(move |(_, corners)| {
            corners.windows(2).skip(1).map(move |pair| {
                let [a, b, c] = [corners[0], pair[0], pair[1]].map(|node| self.points[node as usize]);
                let volume = dot(minus(a, tip), cross(minus(b, tip), minus(c, tip))) / 6.0;
                (volume, times(plus(plus(a, b), plus(c, tip)), 0.25))
            })
        })
    }

    pub(crate) fn volume(&self) -> f64 {
        self.points.first().map_or(0.0, |&tip| self.pyramids(tip).map(|(volume, _)| volume).sum())
    }

    /// The centre of the volume.
    pub(crate) fn centre(&self) -> Point {
        let tip = self.points.first().copied().unwrap_or([0.0; 3]);
        let (mut sum, mut whole) = ([0.0; 3], 0.0);
        for (volume, centre) in self.pyramids(tip) {
            sum = plus(sum, times(centre, volume));
            whole += volume;
        }
        times(sum, 1.0 / whole)
    }
}
