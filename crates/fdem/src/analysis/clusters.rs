//! What hangs together by contacts, and reaches from face to face or around the box.

use serde::Serialize;

use crate::analysis::packing::Frame;
use crate::network::Network;

/// Connected components of the network.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Clusters {
    /// How many there are; an element without contact is one.
    pub count: u64,
    /// Elements of the largest.
    pub largest: u64,
    /// How many there are of each size, the smallest first.
    pub sizes: Vec<ClusterSize>,
    /// Along each axis, or each edge of a box.
    pub percolation: Vec<Percolation>,
    /// The cluster of each element, numbered in the order of their first elements. Not in the JSON.
    #[serde(skip)]
    pub of_each: Vec<u32>,
}

/// Clusters of one size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ClusterSize {
    /// Elements.
    pub elements: u64,
    /// Clusters.
    pub clusters: u64,
}

/// Whether a cluster reaches all the way along an axis.
///
/// Where the box repeats: if it winds around, that is if going along its couples leads from an element to another image of it, displaced along this edge (and
/// perhaps along others). This is exact: shifts are whole numbers. Elsewhere: if it reaches both faces of the domain, the box around all elements;
/// an element reaches a face if its surface is no farther from it than the largest radius. Across the edges of a sheared box distances are measured at
/// right angles to its faces.
///
/// # Source
/// M.E.J. Newman, R.M. Ziff, "Fast Monte Carlo algorithm for site or bond percolation", Phys. Rev. E 64 (2001) 016706; winding by displacements: J. Machta et al.,
/// Phys. Rev. E 54 (1996) 1332.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Percolation {
    /// 0 is x, or the first edge.
    pub axis: usize,
    /// Whether the box repeats along it.
    pub periodic: bool,
    /// Whether a cluster percolates.
    pub percolates: bool,
    /// How many do.
    pub clusters: u64,
    /// Elements in these.
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
            // Along a tree of couples elements have one place each; where another couple leads to another one, the cluster winds.
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
    let frame = Frame::of(network);
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

/// Trees of elements; each knows by how many edges of the box it is displaced from the one above, in the cluster put together.
struct Forest<const D: usize> {
    above: Vec<u32>,
    displaced: Vec<[i64; D]>,
    /// Elements below, of those at the top.
    sizes: Vec<u32>,
}

impl<const D: usize> Forest<D> {
    fn new(n: usize) -> Self {
        Self { above: (0..n as u32).collect(), displaced: vec![[0; D]; n], sizes: vec![1; n] }
    }

    /// The top of the tree of an element, and how the element is displaced from it.
    fn find(&mut self, element: u32) -> (u32, [i64; D]) {
        let mut top = element;
        let mut total = [0; D];
        while self.above[top as usize] != top {
            total = plus(total, self.displaced[top as usize]);
            top = self.above[top as usize];
        }
        // All on the way are put below the top.
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

    /// Element `j` is displaced by `shift` from `i`.
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

    /// The number of the tree of each element, in the order of their first elements, and the sizes of the trees.
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
    std::array::from_fn(|axis| a[axis] + b[axis])
}

fn minus<const D: usize>(a: [i64; D], b: [i64; D]) -> [i64; D] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}
