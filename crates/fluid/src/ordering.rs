//! The order in which unknowns are eliminated: nested dissection of a graph.

/// A graph: the neighbours of vertex `k`, in rising order, are `neighbours[starts[k]..starts[k + 1]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Graph {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Graph {
    /// The graph of the given edges between different vertices; each may be there more than once.
    pub(crate) fn of(vertices: usize, edges: impl IntoIterator<Item = [u32; 2]>) -> Self {
        let mut all: Vec<[u32; 2]> = edges.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        all.sort_unstable();
        all.dedup();
        let starts = (0..=vertices).map(|k| all.partition_point(|[from, _]| (*from as usize) < k)).collect();
        Self { starts, neighbours: all.into_iter().map(|[_, to]| to).collect() }
    }

    pub(crate) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    pub(crate) fn neighbours(&self, of: u32) -> &[u32] {
        &self.neighbours[self.starts[of as usize]..self.starts[of as usize + 1]]
    }
}

/// Parts of at most this size are not divided.
const SMALLEST: usize = 16;

/// Part of vertices that have their place.
const PLACED: u32 = u32::MAX;

/// Nested dissection: a set of vertices that divides a part in two is eliminated after both.
struct Dissection<'g> {
    graph: &'g Graph,
    /// The part in which each vertex is.
    part: Vec<u32>,
    /// The level of each vertex in the last search, valid where `searched` is the number of that search.
    level: Vec<u32>,
    searched: Vec<u32>,
    search: u32,
}

/// Returns the vertices in the order of their elimination.
///
/// Levels of a breadth-first search from a vertex at the edge divide a part: one level, near the middle,
/// separates the others. Vertices with very many neighbours, such as a borehole, come last. The order depends
/// on the graph alone, and not on coordinates, so that a run that continues from a saved state has the same.
///
/// # Cost
/// `n log n`. Chains and trees have no fill, triangulated surfaces `n log n` with `n^1.5` operations.
///
/// # Source
/// A. George, "Nested dissection of a regular finite element mesh", SIAM J. Numer. Anal. 10 (1973) 345-363;
/// A. George and J. W. H. Liu, "An automatic nested dissection algorithm for irregular finite element
/// problems", SIAM J. Numer. Anal. 15 (1978) 1053-1069.
pub(crate) fn order(graph: &Graph) -> Vec<u32> {
    let size = graph.len();
    // The bound of P. R. Amestoy, T. A. Davis and I. S. Duff for minimum degrees.
    let many = 16.max((10.0 * (size as f64).sqrt()) as usize);
    let (dense, rest): (Vec<u32>, Vec<u32>) =
        (0..size as u32).partition(|&vertex| graph.neighbours(vertex).len() > many);
    let zeros = || vec![0; size];
    let (part, level, searched) = (zeros(), zeros(), zeros());
    let mut state = Dissection { graph, part, level, searched, search: 0 };
    state.put(&dense, PLACED);
    // From the last one to the first.
    let mut order: Vec<u32> = dense.into_iter().rev().collect();
    let mut open = if rest.is_empty() { Vec::new() } else { vec![rest] };
    let mut parts = 0;
    while let Some(vertices) = open.pop() {
        parts += 1;
        state.put(&vertices, parts);
        let (placed, pieces) = state.divide(&vertices, parts).unwrap_or((vertices, Vec::new()));
        state.put(&placed, PLACED);
        order.extend(placed.into_iter().rev());
        open.extend(pieces);
    }
    order.reverse();
    order
}

impl Dissection<'_> {
    fn put(&mut self, vertices: &[u32], part: u32) {
        for &vertex in vertices {
            self.part[vertex as usize] = part;
        }
    }

    /// The separator of a part and the pieces that it leaves, each in rising order; `None` if the part is not
    /// to be divided.
    fn divide(&mut self, vertices: &[u32], part: u32) -> Option<(Vec<u32>, Vec<Vec<u32>>)> {
        if vertices.len() <= SMALLEST {
            return None;
        }
        let mut found = self.levels(vertices[0], part);
        if found.len() < vertices.len() {
            return Some((Vec::new(), self.components(vertices, part)));
        }
        // From the far side, as long as that is farther.
        loop {
            let depth = self.level[found[found.len() - 1] as usize];
            let last = found.iter().rev().take_while(|&&vertex| self.level[vertex as usize] == depth);
            let start = *last
                .min_by_key(|&&vertex| (self.graph.neighbours(vertex).len(), vertex))
                .unwrap_or(&found[0]);
            found = self.levels(start, part);
            if self.level[found[found.len() - 1] as usize] <= depth {
                break;
            }
        }
        let deepest = self.level[found[found.len() - 1] as usize];
        if deepest < 2 {
            return None;
        }
        let middle = self.level[found[found.len() / 2] as usize].clamp(1, deepest - 1);
        let is_above = |&vertex: &u32| {
            self.searched[vertex as usize] == self.search
                && self.part[vertex as usize] == part
                && self.level[vertex as usize] == middle + 1
        };
        let [mut separator, mut below, mut above] = [const { Vec::new() }; 3];
        for &vertex in vertices {
            let level = self.level[vertex as usize];
            if level > middle {
                above.push(vertex);
            } else if level == middle && self.graph.neighbours(vertex).iter().any(is_above) {
                separator.push(vertex);
            } else {
                below.push(vertex);
            }
        }
        Some((separator, vec![below, above]))
    }

    /// The vertices of a part, by the component in which they are.
    fn components(&mut self, vertices: &[u32], part: u32) -> Vec<Vec<u32>> {
        let first = self.search + 1;
        for &vertex in vertices {
            if self.searched[vertex as usize] < first {
                self.levels(vertex, part);
            }
        }
        let mut components = vec![Vec::new(); (self.search + 1 - first) as usize];
        for &vertex in vertices {
            components[(self.searched[vertex as usize] - first) as usize].push(vertex);
        }
        components
    }

    /// Vertices of a part that can be reached from one of them, by rising levels.
    fn levels(&mut self, start: u32, part: u32) -> Vec<u32> {
        self.search += 1;
        let mut found = vec![start];
        (self.searched[start as usize], self.level[start as usize]) = (self.search, 0);
        let mut next = 0;
        while let Some(&vertex) = found.get(next) {
            next += 1;
            for &other in self.graph.neighbours(vertex) {
                let at = other as usize;
                if self.part[at] == part && self.searched[at] != self.search {
                    (self.searched[at], self.level[at]) = (self.search, self.level[vertex as usize] + 1);
                    found.push(other);
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_vertex_is_there_once_and_the_separator_last() {
        let grid = |k: u32| {
            (0..k * k).flat_map(move |at| {
                let right = (at % k + 1 < k).then_some([at, at + 1]);
                let above = (at / k + 1 < k).then_some([at, at + k]);
                right.into_iter().chain(above)
            })
        };
        // A square, a chain apart from it, a lone vertex, and a hub with all of them.
        let edges = grid(30).chain((900..950).map(|k| [k, k + 1])).chain((0..951).map(|k| [k, 952]));
        let graph = Graph::of(953, edges);
        let found = order(&graph);
        let mut sorted = found.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..953).collect::<Vec<u32>>());
        assert_eq!(found[952], 952);
    }
}
