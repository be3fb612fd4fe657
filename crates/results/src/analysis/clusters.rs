//! Clusters of elements in contact, and percolation from face to face or around the box.

use serde::Serialize;

use crate::analysis::packing::DomainFrame;
use crate::arrays::each;
use crate::network::Network;

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
    pub(crate) fn of<const D: usize>(network: &Network<'_, D>) -> Self {
        let n = network.space.centres.len();
        let mut forest = Forest::<D>::new(n);
        for couple in network.couples.iter() {
            forest.join(couple.i, couple.j, couple.shift.map(i64::from));
        }
        let (of_each, sizes) = forest.numbers();

        let mut percolates: Vec<[bool; D]> = vec![[false; D]; sizes.len()];
        let periodic = network.space.cell.map_or([false; D], |cell| cell.periodic());
        for couple in network.couples.iter() {
            // The tree gives each element one displacement. If a couple leads to another one, the cluster
            // winds around the box.
            let (from, to) = (forest.find(couple.i).1, forest.find(couple.j).1);
            for axis in 0..D {
                if from[axis] + i64::from(couple.shift[axis]) != to[axis] {
                    percolates[of_each[couple.i as usize] as usize][axis] = true;
                }
            }
        }
        for axis in (0..D).filter(|&axis| !periodic[axis]) {
            reach_faces(network, axis, &of_each, &mut percolates);
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

/// Marks the clusters that reach both faces of the domain along an axis.
fn reach_faces<const D: usize>(
    network: &Network<'_, D>,
    axis: usize,
    of_each: &[u32],
    percolates: &mut [[bool; D]],
) {
    let frame = DomainFrame::of(network);
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
/// the box.
struct Forest<const D: usize> {
    above: Vec<u32>,
    displaced: Vec<[i64; D]>,
    /// Number of elements of each tree, valid for its root.
    sizes: Vec<u32>,
}

impl<const D: usize> Forest<D> {
    fn new(n: usize) -> Self {
        Self { above: (0..n as u32).collect(), displaced: vec![[0; D]; n], sizes: vec![1; n] }
    }

    /// Returns the root of the tree of an element, and the displacement of the element from it.
    fn find(&mut self, element: u32) -> (u32, [i64; D]) {
        let mut top = element;
        let mut total = [0; D];
        while self.above[top as usize] != top {
            total = plus(total, self.displaced[top as usize]);
            top = self.above[top as usize];
        }
        // Path compression: the root becomes the parent of all elements on the way.
        let (mut at, mut left) = (element, total);
        while self.above[at as usize] != top && at != top {
            let next = self.above[at as usize];
            let step = std::mem::replace(&mut self.displaced[at as usize], left);
            self.above[at as usize] = top;
            left = minus(left, step);
            at = next;
        }
        (top, total)
    }

    /// Joins the trees of two elements, where `j` is displaced from `i` by `shift`.
    fn join(&mut self, i: u32, j: u32, shift: [i64; D]) {
        let ((a, of_i), (b, of_j)) = (self.find(i), self.find(j));
        if a == b {
            return;
        }
        let b_from_a = minus(plus(of_i, shift), of_j);
        let (top, below, displaced) = if self.sizes[a as usize] >= self.sizes[b as usize] {
            (a, b, b_from_a)
        } else {
            (b, a, minus([0; D], b_from_a))
        };
        self.above[below as usize] = top;
        self.displaced[below as usize] = displaced;
        self.sizes[top as usize] += self.sizes[below as usize];
    }

    /// Returns the number of the tree of each element, and the sizes of the trees. Trees are numbered in the
    /// order of their first elements.
    fn numbers(&mut self) -> (Vec<u32>, Vec<u64>) {
        let n = self.above.len();
        let mut of_top = vec![u32::MAX; n];
        let mut sizes = Vec::new();
        let numbers = (0..n as u32).map(|element| {
            let (top, _) = self.find(element);
            if of_top[top as usize] == u32::MAX {
                of_top[top as usize] = sizes.len() as u32;
                sizes.push(u64::from(self.sizes[top as usize]));
            }
            of_top[top as usize]
        });
        (numbers.collect(), sizes)
    }
}

fn plus<const D: usize>(a: [i64; D], b: [i64; D]) -> [i64; D] {
    each(|axis| a[axis] + b[axis])
}

fn minus<const D: usize>(a: [i64; D], b: [i64; D]) -> [i64; D] {
    each(|axis| a[axis] - b[axis])
}
