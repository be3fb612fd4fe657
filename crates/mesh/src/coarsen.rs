//! Fine facets of surfaces, which are made as large as the elements of the mesh.
//!
//! Edges collapse to one of their nodes, those with the least error first (M. Garland and P. S. Heckbert,
//! *Surface simplification using quadric error metrics*, SIGGRAPH 1997). Nodes that stay do not move. A
//! collapse must keep
//! - the topology: the two nodes of the edge have exactly the two neighbours of its facets in common;
//! - the sides: no facet turns over, and none becomes thinner than the thinnest around was;
//! - the place: the nodes of the original surface, and points along its edges, are within the tolerance of
//!   the new facets. Edges between faces collapse along themselves, and their nodes are within the tolerance
//!   of the new edges.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use crate::corners::sorted;
use crate::tetrahedra::Surface;
use crate::tetrahedra::vector::{Point, cross, distance, dot, length, minus, normal, plus, times};

/// Share of the size below which edges collapse: then most edges are between 0.7 and 1.4 of it.
const SHORT: f64 = 0.7;

/// Least cosine of the angle by which a facet turns in one collapse.
const TURN: f64 = 0.5;

/// Quality of a facet, 1 for equal edges, from which it may be worse than the worst around was.
const GOOD: f64 = 0.3;

/// Points along an edge for each size, and at most.
const POINTS: [f64; 2] = [4.0, 16.0];

/// Passes over all edges, at most. Nearly all edges collapse in the first.
const PASSES: usize = 10;

/// A surface with fewer facets.
#[derive(Clone, Debug)]
pub struct Coarsened {
    /// The new surface: its nodes are among those of the original one, in their order.
    pub surface: Surface,
    /// Largest distance found of the original surface, at its nodes and at points along its edges, from the
    /// new one, in the unit of the nodes.
    pub distance: f64,
}

impl Surface {
    /// This surface with larger facets, where edges are shorter than the size of the mesh there; `None` if no
    /// edge may collapse. Nodes at which facets do not form one closed ring stay.
    ///
    /// `size`: size of the mesh at a place; `tolerance`: distance up to which the new surface may lie off the
    /// original one. Whether the new surface crosses itself is not looked at: [`Surface::check`] does.
    ///
    /// # Cost
    /// O(n log n) for n facets.
    pub fn coarsened(&self, size: &dyn Fn([f64; 3]) -> f64, tolerance: f64) -> Option<Coarsened> {
        let mut work = Work::new(self, size, tolerance);
        let mut collapsed = false;
        for _ in 0..PASSES {
            let count = work.pass();
            collapsed |= count > 0;
            if count == 0 {
                break;
            }
        }
        collapsed.then(|| work.result(self))
    }
}

/// The sum of squares of the distances from planes, each with a weight: the upper triangle of a symmetric
/// matrix of 4 by 4, and the sum of the weights.
#[derive(Clone, Copy, Default)]
struct Quadric([f64; 11]);

impl Quadric {
    /// Adds the plane of a facet, with its area as weight. `origin` keeps numbers small.
    fn add_facet(&mut self, [a, b, c]: [Point; 3], origin: Point) {
        let across = normal(a, b, c);
        let twice = length(across);
        if twice > 0.0 {
            let [x, y, z] = times(across, 1.0 / twice);
            let plane = [x, y, z, -dot([x, y, z], minus(a, origin))];
            let mut k = 0;
            for i in 0..4 {
                for j in i..4 {
                    self.0[k] += 0.5 * twice * plane[i] * plane[j];
                    k += 1;
                }
            }
            self.0[10] += 0.5 * twice;
        }
    }

    fn plus(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum += more);
        self
    }

    /// Mean square of the distances from the planes.
    fn at(&self, point: Point, origin: Point) -> f64 {
        let [x, y, z] = minus(point, origin);
        let (at, mut sum, mut k) = ([x, y, z, 1.0], 0.0, 0);
        for i in 0..4 {
            for j in i..4 {
                sum += self.0[k] * at[i] * at[j] * if i == j { 1.0 } else { 2.0 };
                k += 1;
            }
        }
        if self.0[10] > 0.0 { (sum / self.0[10]).max(0.0) } else { 0.0 }
    }
}

/// A collapse that is offered: the bits of its cost, the node that goes, the node that stays, and the changes
/// of both so far.
type Offered = (u64, u32, u32, [u32; 2]);

/// A collapse that may be done: facets around the removed node with their corners from now on, and where
/// their points go.
struct Collapse {
    /// Facets that stay, with their corners.
    facets: Vec<(u32, [u32; 3])>,
    /// Facets that vanish.
    vanish: [u32; 2],
    /// For each facet that stays, points of the original surface nearest to it.
    points: Vec<Vec<u32>>,
    /// If the edge is between faces: the other end of the new edge, and the nodes that the new edge passes.
    crease: Option<(u32, Vec<u32>)>,
}

struct Work<'a> {
    nodes: &'a [Point],
    origin: Point,
    size: &'a dyn Fn(Point) -> f64,
    tolerance: f64,
    facets: Vec<[u32; 3]>,
    /// Whether each facet is there.
    stays: Vec<bool>,
    /// Facets at each node.
    around: Vec<Vec<u32>>,
    /// Whether each node must stay.
    fixed: Vec<bool>,
    quadrics: Vec<Quadric>,
    /// Number of changes of the neighbours of each node.
    changes: Vec<u32>,
    /// Points of the original surface, and those nearest to each facet.
    samples: Vec<Point>,
    near: Vec<Vec<u32>>,
    /// Edges between faces, lower node first, with the original nodes between their ends.
    creases: BTreeMap<[u32; 2], Vec<u32>>,
}

impl<'a> Work<'a> {
    fn new(surface: &'a Surface, size: &'a dyn Fn(Point) -> f64, tolerance: f64) -> Self {
        let Surface { nodes, facets, faces, sides, .. } = surface;
        let mut work = Self {
            nodes,
            origin: nodes.first().copied().unwrap_or_default(),
            size,
            tolerance,
            facets: facets.clone(),
            stays: vec![true; facets.len()],
            around: vec![Vec::new(); nodes.len()],
            fixed: vec![false; nodes.len()],
            quadrics: vec![Quadric::default(); nodes.len()],
            changes: vec![0; nodes.len()],
            samples: nodes.clone(),
            near: vec![Vec::new(); facets.len()],
            creases: BTreeMap::new(),
        };
        let mut edges: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for (number, corners) in (0..).zip(facets) {
            let places = corners.map(|node| nodes[node as usize]);
            for (k, &node) in corners.iter().enumerate() {
                work.around[node as usize].push(number);
                work.quadrics[node as usize].add_facet(places, work.origin);
                edges.entry(sorted([node, corners[(k + 1) % 3]])).or_default().push(number);
            }
        }
        for (edge, at) in edges {
            let [a, b] = edge.map(|node| nodes[node as usize]);
            let between = |one: u32, other: u32| {
                let [one, other] = [one, other].map(|facet| facet as usize);
                if sides[one] != sides[other] {
                    return None;
                }
                Some(faces[one] != faces[other])
            };
            match at[..] {
                [one, other] if between(one, other).is_some() => {
                    if between(one, other) == Some(true) {
                        work.creases.insert(edge, Vec::new());
                    }
                }
                _ => edge.iter().for_each(|&node| work.fixed[node as usize] = true),
            }
            let parts = (POINTS[0] * distance(a, b) / size(a)).ceil().clamp(2.0, POINTS[1]);
            for part in 1..parts as usize {
                work.near[at[0] as usize].push(work.samples.len() as u32);
                work.samples.push(plus(a, times(minus(b, a), part as f64 / parts)));
            }
        }
        for node in 0..nodes.len() as u32 {
            let ring = work.neighbours(node);
            let of_crease = ring.iter().filter(|&&other| work.is_crease(node, other)).count();
            let is_ring = work.is_one_ring(node, &ring);
            work.fixed[node as usize] |= !is_ring || ![0, 2].contains(&of_crease);
        }
        work
    }

    fn is_crease(&self, one: u32, other: u32) -> bool {
        self.creases.contains_key(&sorted([one, other]))
    }

    /// Nodes that share a facet with this one, ascending.
    fn neighbours(&self, node: u32) -> Vec<u32> {
        let facets = self.around[node as usize].iter();
        let mut all: Vec<u32> = facets.flat_map(|&facet| self.facets[facet as usize]).collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|&other| other != node);
        all
    }

    /// Whether the facets at a node form one closed ring.
    fn is_one_ring(&self, node: u32, ring: &[u32]) -> bool {
        let next: BTreeMap<u32, u32> = self.around[node as usize]
            .iter()
            .map(|&facet| {
                let corners = self.facets[facet as usize];
                let k = corners.iter().position(|&corner| corner == node).unwrap_or(0);
                (corners[(k + 1) % 3], corners[(k + 2) % 3])
            })
            .collect();
        let Some(&first) = ring.first() else { return false };
        let (mut at, mut count) = (first, 0);
        loop {
            let Some(&to) = next.get(&at) else { return false };
            (at, count) = (to, count + 1);
            if at == first || count > ring.len() {
                return count == ring.len() && self.around[node as usize].len() == count;
            }
        }
    }

    /// Error of the collapse of an edge to its second node, in shares of the tolerance and of the size;
    /// `None` if the edge is too long or the first node must stay.
    fn cost(&self, from: u32, to: u32) -> Option<f64> {
        if self.fixed[from as usize] {
            return None;
        }
        let [a, b] = [from, to].map(|node| self.nodes[node as usize]);
        let share = distance(a, b) / (self.size)(a).min((self.size)(b));
        if share >= SHORT {
            return None;
        }
        let [one, other] = [from, to].map(|node| &self.quadrics[node as usize]);
        let error = one.plus(other).at(b, self.origin);
        Some(error / (self.tolerance * self.tolerance) + share * share)
    }

    /// Collapses edges as long as some may. Returns their number.
    fn pass(&mut self) -> u64 {
        let mut heap = BinaryHeap::new();
        for node in 0..self.nodes.len() as u32 {
            self.offer(node, &mut heap);
        }
        let mut count = 0;
        while let Some(Reverse((_, from, to, change))) = heap.pop() {
            let [one, other] = [from, to].map(|node| node as usize);
            if self.around[one].is_empty()
                || self.around[other].is_empty()
                || [self.changes[one], self.changes[other]] != change
            {
                continue;
            }
            if let Some(collapse) = self.plan(from, to) {
                self.collapse(from, to, collapse);
                count += 1;
                self.offer(to, &mut heap);
                for other in self.neighbours(to) {
                    self.offer_edge(other, to, &mut heap);
                }
            }
        }
        count
    }

    /// Offers the edges from a node for their collapse.
    fn offer(&self, node: u32, heap: &mut BinaryHeap<Reverse<Offered>>) {
        for to in self.neighbours(node) {
            self.offer_edge(node, to, heap);
        }
    }

    /// Offers an edge for its collapse to its second node.
    fn offer_edge(&self, from: u32, to: u32, heap: &mut BinaryHeap<Reverse<Offered>>) {
        // Costs are not negative, so their bits are in their order.
        if let Some(cost) = self.cost(from, to) {
            let change = [from, to].map(|node| self.changes[node as usize]);
            heap.push(Reverse((cost.to_bits(), from, to, change)));
        }
    }

    /// The collapse of an edge to its second node, if it keeps topology, sides and place.
    fn plan(&self, from: u32, to: u32) -> Option<Collapse> {
        let [ring, other] = [from, to].map(|node| self.neighbours(node));
        let common: Vec<u32> = ring.iter().copied().filter(|node| other.contains(node)).collect();
        let around = &self.around[from as usize];
        let (gone, left): (Vec<u32>, Vec<u32>) =
            around.iter().copied().partition(|&facet| self.facets[facet as usize].contains(&to));
        let &[first, second] = &gone[..] else { return None };
        if common.len() != 2 {
            return None;
        }
        // A tetrahedron has no collapse.
        if ring.len() <= 3 && other.len() <= 3 {
            return None;
        }
        let crease = self.crease(from, to, &ring, &other)?;
        let place = |node: u32| self.nodes[node as usize];
        let (mut worst, mut facets) = (GOOD, Vec::with_capacity(left.len()));
        for &facet in around {
            worst = f64::min(worst, quality(self.facets[facet as usize].map(place)));
        }
        for facet in left {
            let before = self.facets[facet as usize];
            let after = before.map(|node| if node == from { to } else { node });
            let [old, new] = [before, after].map(|corners| {
                let [a, b, c] = corners.map(place);
                normal(a, b, c)
            });
            let turns = dot(old, new) < TURN * length(old) * length(new);
            if turns || length(new) <= 0.0 || quality(after.map(place)) < worst {
                return None;
            }
            facets.push((facet, after));
        }
        // The removed node is a point of the original surface, too.
        let mut points = vec![Vec::new(); facets.len()];
        let all = around.iter().flat_map(|&facet| &self.near[facet as usize]).copied();
        for point in all.chain([from]) {
            let at = self.samples[point as usize];
            let off =
                |(k, (_, corners)): (usize, &(u32, [u32; 3]))| (off_triangle(at, corners.map(place)), k);
            let nearest = facets.iter().enumerate().map(off).min_by(|a, b| a.0.total_cmp(&b.0));
            let (off, k) = nearest?;
            if off > self.tolerance {
                return None;
            }
            points[k].push(point);
        }
        Some(Collapse { facets, vanish: [first, second], points, crease })
    }

    /// The edge between faces that a collapse makes; `None` if the collapse is not allowed, and nothing if
    /// the node is inside of a face.
    #[allow(clippy::option_option, reason = "no collapse, or one without such an edge")]
    fn crease(&self, from: u32, to: u32, ring: &[u32], other: &[u32]) -> Option<Option<(u32, Vec<u32>)>> {
        let mut ends = ring.iter().copied().filter(|&node| self.is_crease(from, node));
        let (Some(one), Some(two)) = (ends.next(), ends.next()) else { return Some(None) };
        let end = match [one, two] {
            [end, along] | [along, end] if along == to => end,
            _ => return None,
        };
        if other.contains(&end) {
            return None;
        }
        let mut passed = vec![from];
        for node in [end, to] {
            passed.extend(&self.creases[&sorted([from, node])]);
        }
        let [a, b] = [end, to].map(|node| self.nodes[node as usize]);
        let is_near = |&node: &u32| off_segment(self.nodes[node as usize], a, b) <= self.tolerance;
        passed.iter().all(is_near).then_some(Some((end, passed)))
    }

    fn collapse(&mut self, from: u32, to: u32, collapse: Collapse) {
        let Collapse { facets, vanish, points, crease } = collapse;
        for facet in vanish {
            self.stays[facet as usize] = false;
            self.near[facet as usize] = Vec::new();
            for node in self.facets[facet as usize] {
                self.around[node as usize].retain(|&other| other != facet);
            }
        }
        for ((facet, corners), points) in facets.into_iter().zip(points) {
            self.facets[facet as usize] = corners;
            self.near[facet as usize] = points;
            self.around[to as usize].push(facet);
        }
        self.around[from as usize] = Vec::new();
        if let Some((end, passed)) = crease {
            for node in [end, to] {
                self.creases.remove(&sorted([from, node]));
            }
            self.creases.insert(sorted([end, to]), passed);
        }
        self.quadrics[to as usize] = self.quadrics[from as usize].plus(&self.quadrics[to as usize]);
        self.changes[to as usize] += 1;
    }

    /// The new surface.
    fn result(self, before: &Surface) -> Coarsened {
        let mut number = vec![u32::MAX; self.nodes.len()];
        let mut surface = Surface { names: before.names.clone(), ..Surface::default() };
        for (node, facets) in self.around.iter().enumerate() {
            if !facets.is_empty() {
                number[node] = surface.nodes.len() as u32;
                surface.nodes.push(self.nodes[node]);
            }
        }
        let mut off = 0.0_f64;
        for facet in (0..self.facets.len()).filter(|&facet| self.stays[facet]) {
            let corners = self.facets[facet];
            let places = corners.map(|node| self.nodes[node as usize]);
            for &point in &self.near[facet] {
                off = off.max(off_triangle(self.samples[point as usize], places));
            }
            surface.facets.push(corners.map(|node| number[node as usize]));
            surface.faces.push(before.faces[facet]);
            surface.sides.push(before.sides[facet]);
        }
        for (ends, passed) in &self.creases {
            let [a, b] = ends.map(|node| self.nodes[node as usize]);
            for &node in passed {
                off = off.max(off_segment(self.nodes[node as usize], a, b));
            }
        }
        Coarsened { surface, distance: off }
    }
}

/// Quality of a triangle: 1 for equal edges, 0 for a line.
fn quality([a, b, c]: [Point; 3]) -> f64 {
    let squares: f64 = [minus(b, a), minus(c, b), minus(a, c)].map(|edge| dot(edge, edge)).iter().sum();
    2.0 * f64::sqrt(3.0) * length(normal(a, b, c)) / squares
}

/// Distance of a point from a line between two others.
fn off_segment(point: Point, a: Point, b: Point) -> f64 {
    let along = minus(b, a);
    let share = (dot(minus(point, a), along) / dot(along, along)).clamp(0.0, 1.0);
    distance(point, plus(a, times(along, share)))
}

/// Distance of a point from a triangle.
fn off_triangle(point: Point, [a, b, c]: [Point; 3]) -> f64 {
    let across = normal(a, b, c);
    let is_inside = [[a, b], [b, c], [c, a]]
        .iter()
        .all(|&[from, to]| dot(cross(minus(to, from), minus(point, from)), across) >= 0.0);
    if is_inside {
        return (dot(minus(point, a), across) / length(across)).abs();
    }
    let edges = [[a, b], [b, c], [c, a]].map(|[from, to]| off_segment(point, from, to));
    edges.into_iter().fold(f64::INFINITY, f64::min)
}
