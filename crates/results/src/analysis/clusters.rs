//! Clusters of elements in contact, and percolation from face to face or around the box.

use serde::Serialize;

use crate::analysis::placed::Placed;
use crate::arrays::each;

/// Connected components of the network.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Clusters {
    /// Number of clusters. An element without contact is a cluster.
    pub count: u64,
    /// Number of elements of the largest cluster.
    pub largest: u64,
    /// Number of clusters of each size, the smallest size first.
    pub sizes: Vec<ClusterSize>,
    /// Percolation along each axis, or along each edge of a box.
    pub percolation: Vec<Percolation>,
    /// Cluster of each element. Clusters are numbered in the order of their first elements. Not in the JSON.
    #[serde(skip)]
    pub of_each: Vec<u32>,
}

/// Clusters of one size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ClusterSize {
    /// Number of elements of each of them.
    pub elements: u64,
    /// Number of clusters of this size.
    pub clusters: u64,
}

/// Percolation along an axis.
///
/// Along a periodic edge, a cluster percolates if it winds around the box: a path along its couples leads
/// from an element to another image of this element, displaced along this edge (and perhaps along others).
/// This test is exact, because shifts are integers. Along any other axis, a cluster percolates if it reaches
/// both faces of the domain, which is the box around all elements. An element reaches a face if its surface
/// is no farther from the face than the largest radius. In a sheared box, distances are measured at right
/// angles to its faces.
///
/// # Source
/// M.E.J. Newman, R.M. Ziff, "Fast Monte Carlo algorithm for site or bond percolation", Phys. Rev. E 64
/// (2001) 016706; winding by displacements: J. Machta et al., Phys. Rev. E 54 (1996) 1332.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Percolation {
    /// Number of the axis: 0 is x, or the first edge.
    pub axis: usize,
    /// Whether the box is periodic along it.
    pub periodic: bool,
    /// Whether a cluster percolates.
    pub percolates: bool,
    /// Number of clusters that percolate.
    pub clusters: u64,
    /// Number of elements in these clusters.
    pub elements: u64,
}

impl Clusters {
    pub(crate) fn of<const D: usize>(placed: &Placed<'_, D>) -> Self {
        let network = placed.network;
        let n = network.space.centres.len();
        let periodic = network.space.cell.map_or([false; D], |cell| cell.periodic());
        let (of_each, sizes, mut percolates);
        if periodic == [false; D] {
            let mut forest = Forest::<0>::new(n);
            for couple in network.couples.iter() {
                forest.join(couple.i, couple.j, []);
            }
            (of_each, sizes) = forest.numbers();
            percolates = vec![[false; D]; sizes.len()];
        } else {
            let mut forest = Forest::<D>::new(n);
            for couple in network.couples.iter() {
                forest.join(couple.i, couple.j, couple.shift.map(i64::from));
            }
            (of_each, sizes) = forest.numbers();
            percolates = vec![[false; D]; sizes.len()];
            wind_around(placed, &forest, &of_each, &mut percolates);
        }
        placed.team.count(network.couples.len());
        for axis in (0..D).filter(|&axis| !periodic[axis]) {
            reach_faces(placed, axis, &of_each, &mut percolates);
        }

        let percolation = (0..D).map(|axis| {
            let reaching = || sizes.iter().zip(&percolates).filter(move |(_, along)| along[axis]);
            Percolation {
                axis,
                periodic: periodic[axis],
                percolates: reaching().next().is_some(),
                clusters: reaching().count() as u64,
                elements: reaching().map(|(size, _)| size).sum(),
            }
        });
        let percolation = percolation.collect();
        let (count, largest) = (sizes.len() as u64, sizes.iter().copied().max().unwrap_or(0));
        let mut sorted = sizes;
        sorted.sort_unstable();
        let sizes = sorted
            .chunk_by(|a, b| a == b)
            .map(|same| ClusterSize { elements: same[0], clusters: same.len() as u64 })
            .collect();
        Self { count, largest, sizes, percolation, of_each }
    }
}

/// Marks the clusters that wind around the box.
///
/// The trees give each element one displacement. If a couple leads to another one, the cluster winds.
fn wind_around<const D: usize>(
    placed: &Placed<'_, D>,
    forest: &Forest<D>,
    of_each: &[u32],
    percolates: &mut [[bool; D]],
) {
    let winding = placed.fold(Vec::new, |winding: &mut Vec<(u32, [bool; D])>, couple| {
        let [from, to] = [couple.i, couple.j].map(|element| forest.nodes[element as usize].displaced);
        let along = each(|axis| from[axis] + i64::from(couple.shift[axis]) != to[axis]);
        let found = (of_each[couple.i as usize], along);
        // Many couples of a cluster in a row say the same.
        if along != [false; D] && winding.last() != Some(&found) {
            winding.push(found);
        }
    });
    for (cluster, along) in winding.into_iter().flatten() {
        for axis in 0..D {
            percolates[cluster as usize][axis] |= along[axis];
        }
    }
}

/// Marks the clusters that reach both faces of the domain along an axis.
fn reach_faces<const D: usize>(
    placed: &Placed<'_, D>,
    axis: usize,
    of_each: &[u32],
    percolates: &mut [[bool; D]],
) {
    let (network, frame) = (placed.network, &placed.frame);
    let [low, high] = frame.domain[axis];
    let reach = frame.largest_radius;
    let mut reached = vec![[false; 2]; percolates.len()];
    for (element, &cluster) in of_each.iter().enumerate() {
        let (x, r) = (frame.coordinates(network, element)[axis], network.sizes.radius(element));
        let faces = &mut reached[cluster as usize];
        faces[0] |= x - r <= low + reach;
        faces[1] |= x + r >= high - reach;
    }
    for (along, faces) in percolates.iter_mut().zip(reached) {
        along[axis] = faces == [true; 2];
    }
}

/// Trees of connected elements (union-find). Each element has its displacement from its parent, in edges of
/// the box. In open space nothing is displaced, and `E` is 0.
struct Forest<const E: usize> {
    nodes: Vec<Node<E>>,
}

/// An element of a tree. All of it is used together, and is together in memory.
#[derive(Clone, Copy)]
struct Node<const E: usize> {
    above: u32,
    /// Number of elements of the tree, valid for its root.
    size: u32,
    displaced: [i64; E],
}

impl<const E: usize> Forest<E> {
    fn new(n: usize) -> Self {
        Self { nodes: (0..n as u32).map(|above| Node { above, size: 1, displaced: [0; E] }).collect() }
    }

    /// Returns the root of the tree of an element, and the displacement of the element from it.
    fn find(&mut self, element: u32) -> (u32, [i64; E]) {
        let mut top = element;
        let mut total = [0; E];
        loop {
            let node = &self.nodes[top as usize];
            if node.above == top {
                break;
            }
            add(&mut total, &node.displaced);
            top = node.above;
        }
        // Path compression: the root becomes the parent of all elements on the way.
        let (mut at, mut left) = (element, total);
        while at != top && self.nodes[at as usize].above != top {
            let node = &mut self.nodes[at as usize];
            let (next, step) = (node.above, node.displaced);
            (node.above, node.displaced) = (top, left);
            subtract(&mut left, &step);
            at = next;
        }
        (top, total)
    }

    /// Joins the trees of two elements, where `j` is displaced from `i` by `shift`.
    fn join(&mut self, i: u32, j: u32, shift: [i64; E]) {
        let ((a, of_i), (b, of_j)) = (self.find(i), self.find(j));
        if a == b {
            return;
        }
        // Of the root `b` from the root `a`.
        let mut displaced = of_i;
        add(&mut displaced, &shift);
        subtract(&mut displaced, &of_j);
        let (mut top, mut below) = (a, b);
        if self.nodes[a as usize].size < self.nodes[b as usize].size {
            (top, below) = (b, a);
            displaced = displaced.map(|x| -x);
        }
        self.nodes[below as usize].above = top;
        self.nodes[below as usize].displaced = displaced;
        self.nodes[top as usize].size += self.nodes[below as usize].size;
    }

    /// Returns the number of the tree of each element, and the sizes of the trees. Trees are numbered in the
    /// order of their first elements. After this, each element has its displacement from its root.
    fn numbers(&mut self) -> (Vec<u32>, Vec<u64>) {
        let n = self.nodes.len();
        let mut of_top = vec![u32::MAX; n];
        let mut sizes = Vec::new();
        let numbers = (0..n as u32).map(|element| {
            let (top, _) = self.find(element);
            if of_top[top as usize] == u32::MAX {
                of_top[top as usize] = sizes.len() as u32;
                sizes.push(u64::from(self.nodes[top as usize].size));
            }
            of_top[top as usize]
        });
        (numbers.collect(), sizes)
    }
}

fn add<const E: usize>(to: &mut [i64; E], other: &[i64; E]) {
    for axis in 0..E {
        to[axis] += other[axis];
    }
}

fn subtract<const E: usize>(from: &mut [i64; E], other: &[i64; E]) {
    for axis in 0..E {
        from[axis] -= other[axis];
    }
}
