//! Connectivity of elements: their corners, the nodes that they share, and the edges between them.
//!
//! A *vertex* is a node of the given mesh; a *node* is a point that moves. A vertex has one node where the mesh is intact, and several nodes where it has
//! broken. Each of these is shared by the corners of elements that are still connected there. Corner `3 e + k` is the `k`-th corner of element `e`.

use crate::error::ModelError;
use crate::model::Mesh;

/// Stands for no edge or no joint.
pub(crate) const NONE: u32 = u32::MAX;

/// An edge between two elements. Side 0 is the element with the lower number. Both sides list their corners in the direction of side 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    pub(crate) corners: [[u32; 2]; 2],
}

impl Edge {
    pub(crate) fn elements(&self) -> [u32; 2] {
        self.corners.map(|side| side[0] / 3)
    }
}

/// Connectivity of the given mesh, which does not change when the mesh breaks.
#[derive(Clone, Debug)]
pub(crate) struct Topology {
    /// Vertex of each corner.
    pub(crate) vertices: Vec<u32>,
    /// The corners of vertex `v` are `corners[offsets[v]..offsets[v + 1]]`, ascending.
    offsets: Vec<u32>,
    corners: Vec<u32>,
    /// Edges between elements.
    pub(crate) edges: Vec<Edge>,
    /// The edge between corners `k` and `k + 1` of each element; [`NONE`] on the outline.
    pub(crate) edge_of: Vec<[u32; 3]>,
}

impl Topology {
    pub(crate) fn new(mesh: &Mesh) -> Result<Self, ModelError> {
        let vertices: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        let mut offsets = vec![0_u32; mesh.nodes.len() + 1];
        for &vertex in &vertices {
            offsets[vertex as usize + 1] += 1;
        }
        for k in 0..mesh.nodes.len() {
            if offsets[k + 1] == 0 {
                return Err(ModelError::LooseNode { node: k });
            }
            offsets[k + 1] += offsets[k];
        }
        let mut next = offsets.clone();
        let mut corners = vec![0; vertices.len()];
        for (corner, &vertex) in vertices.iter().enumerate() {
            corners[next[vertex as usize] as usize] = corner as u32;
            next[vertex as usize] += 1;
        }
        let (edges, edge_of) = edges(&vertices)?;
        Ok(Self { vertices, offsets, corners, edges, edge_of })
    }

    pub(crate) fn corners_of(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.corners[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Returns for each vertex whether it is at an end of an outer edge.
    pub(crate) fn outer_vertices(&self) -> Vec<bool> {
        let mut outer = vec![false; self.vertex_count()];
        for (element, edges) in self.edge_of.iter().enumerate() {
            for k in (0..3).filter(|&k| edges[k] == NONE) {
                for corner in [k, (k + 1) % 3] {
                    outer[self.vertices[3 * element + corner] as usize] = true;
                }
            }
        }
        outer
    }

    /// Numbers the pieces whose elements are connected by edges that hold, from 0 in the order of their first elements. Returns the piece of each element.
    pub(crate) fn pieces(&self, holds: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut pieces = vec![NONE; self.edge_of.len()];
        let (mut count, mut waiting) = (0, Vec::new());
        for first in 0..pieces.len() {
            if pieces[first] != NONE {
                continue;
            }
            pieces[first] = count;
            waiting.push(first);
            while let Some(element) = waiting.pop() {
                for edge in self.edge_of[element].into_iter().filter(|&edge| edge != NONE && holds(edge)) {
                    for next in self.edges[edge as usize].elements() {
                        if pieces[next as usize] == NONE {
                            pieces[next as usize] = count;
                            waiting.push(next as usize);
                        }
                    }
                }
            }
            count += 1;
        }
        pieces
    }

    /// Returns the edges between elements that meet at a vertex, each once and with the corner of its side 0.
    pub(crate) fn edges_around(&self, vertex: u32) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.corners_of(vertex).iter().flat_map(move |&corner| {
            let own =
                move |edge: &u32| *edge != NONE && self.edges[*edge as usize].elements()[0] == corner / 3;
            self.edges_at(corner).into_iter().filter(own).map(move |edge| (edge, corner))
        })
    }

    /// Returns the two edges of an element that meet at one of its corners.
    pub(crate) fn edges_at(&self, corner: u32) -> [u32; 2] {
        let edges = &self.edge_of[corner as usize / 3];
        let k = corner as usize % 3;
        [edges[k], edges[(k + 2) % 3]]
    }

    /// Returns the corner at the same vertex in the element on the other side of an edge.
    fn across(&self, edge: u32, corner: u32) -> u32 {
        let [one, other] = self.edges[edge as usize].corners;
        let end = |side: [u32; 2]| usize::from(side[1] == corner);
        if one.contains(&corner) { other[end(one)] } else { one[end(other)] }
    }

    /// Groups the corners of a vertex. Corners of elements with a common edge that holds are in the same group. `groups` gets the group of each corner, in the
    /// order of [`Self::corners_of`]. The number of a group is the place of its first corner in that order.
    pub(crate) fn groups(&self, vertex: u32, holds: impl Fn(u32) -> bool, groups: &mut Vec<u32>) {
        let corners = self.corners_of(vertex);
        groups.clear();
        groups.resize(corners.len(), NONE);
        for first in 0..corners.len() {
            if groups[first] != NONE {
                continue;
            }
            groups[first] = first as u32;
            // Go around the vertex in both directions, as far as the edges hold.
            for start in self.edges_at(corners[first]) {
                let (mut corner, mut edge) = (corners[first], start);
                while edge != NONE && holds(edge) {
                    corner = self.across(edge, corner);
                    let place = corners.iter().position(|&other| other == corner);
                    let Some(group) = place.map(|place| &mut groups[place]).filter(|group| **group == NONE)
                    else {
                        break;
                    };
                    *group = first as u32;
                    let [one, other] = self.edges_at(corner);
                    edge = if one == edge { other } else { one };
                }
            }
        }
    }
}

/// Finds the edges between two elements, in the order of the lower element and its corner.
fn edges(vertices: &[u32]) -> Result<(Vec<Edge>, Vec<[u32; 3]>), ModelError> {
    let mut sides: Vec<([u32; 2], u32)> = (0..vertices.len())
        .map(|corner| {
            let (a, b) = (vertices[corner], vertices[follower(corner as u32) as usize]);
            ([a.min(b), a.max(b)], corner as u32)
        })
        .collect();
    sides.sort_unstable();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for same in sides.chunk_by(|a, b| a.0 == b.0) {
        match *same {
            [_] => {}
            [(_, a), (_, b)] => {
                if vertices[a as usize] == vertices[b as usize] {
                    return Err(ModelError::Folded { elements: [a / 3, b / 3] });
                }
                pairs.push([a, b]);
            }
            _ => {
                let elements = [same[0].1 / 3, same[1].1 / 3, same[2].1 / 3];
                return Err(ModelError::ManyOnEdge { elements });
            }
        }
    }
    pairs.sort_unstable();
    let mut edge_of = vec![[NONE; 3]; vertices.len() / 3];
    let edges = pairs.iter().enumerate().map(|(number, &[a, b])| {
        for corner in [a, b] {
            edge_of[corner as usize / 3][corner as usize % 3] = number as u32;
        }
        // The other element has the edge in the opposite direction.
        Edge { corners: [[a, follower(a)], [follower(b), b]] }
    });
    Ok((edges.collect(), edge_of))
}

/// Returns the next corner of the same element.
pub(crate) fn follower(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

/// Linked lists of the corners of each node, in ascending order.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// Nodes of the corners of each element.
    pub(crate) of_corner: Vec<[u32; 3]>,
    /// First corner of each node.
    pub(crate) first: Vec<u32>,
    /// Next corner of the same node; [`NONE`] at the end.
    pub(crate) next: Vec<u32>,
}

impl Nodes {
    /// Builds the lists from the nodes of the corners of each element. `count` is the number of nodes.
    pub(crate) fn new(of_corner: Vec<[u32; 3]>, count: usize) -> Self {
        let mut nodes = Self { first: vec![NONE; count], next: vec![NONE; 3 * of_corner.len()], of_corner };
        for corner in (0..nodes.next.len() as u32).rev() {
            nodes.put_first(corner);
        }
        nodes
    }

    /// Returns the node of a corner.
    #[inline]
    pub(crate) fn node_at(&self, corner: u32) -> u32 {
        self.of_corner[corner as usize / 3][corner as usize % 3]
    }

    fn set(&mut self, corner: u32, node: u32) {
        self.of_corner[corner as usize / 3][corner as usize % 3] = node;
    }

    /// Puts a corner in front of the list of its node.
    fn put_first(&mut self, corner: u32) {
        let node = self.node_at(corner) as usize;
        self.next[corner as usize] = self.first[node];
        self.first[node] = corner;
    }

    /// Gives each group of the corners `of` a vertex a node of its own. The first group of each node keeps the node, the others get new nodes. Calls `added`
    /// with the old node and the new one for each new node. Returns whether there are any.
    pub(crate) fn split(&mut self, of: &[u32], groups: &[u32], mut added: impl FnMut(u32, u32)) -> bool {
        let mut split = false;
        for (place, &corner) in of.iter().enumerate() {
            let leader = groups[place] as usize;
            if leader < place {
                self.set(corner, self.node_at(of[leader]));
                continue;
            }
            // This corner is the first of its group. It keeps its node unless an earlier group has the node.
            let node = self.node_at(corner);
            let taken = (0..place).any(|k| self.node_at(of[k]) == node);
            if taken {
                let new = self.first.len() as u32;
                self.first.push(NONE);
                self.set(corner, new);
                split = true;
                added(node, new);
            }
        }
        if split {
            for &corner in of {
                let node = self.node_at(corner) as usize;
                self.first[node] = NONE;
            }
            for &corner in of.iter().rev() {
                self.put_first(corner);
            }
        }
        split
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of four triangles around its middle, node 4.
    fn square() -> Mesh {
        Mesh {
            nodes: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]],
            triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
            bodies: vec![0; 4],
            materials: vec![0; 4],
        }
    }

    #[test]
    fn edges_are_found_from_both_sides() {
        let topology = Topology::new(&square()).expect("a mesh");
        assert_eq!(topology.edges.len(), 4);
        for edge in &topology.edges {
            for end in 0..2 {
                let [a, b] = edge.corners.map(|side| topology.vertices[side[end] as usize]);
                assert_eq!(a, b);
            }
            assert!(edge.elements()[0] < edge.elements()[1]);
            assert_eq!(follower(edge.corners[0][0]), edge.corners[0][1]);
            assert_eq!(follower(edge.corners[1][1]), edge.corners[1][0]);
        }
        assert_eq!(topology.edge_of.iter().filter(|edges| edges[0] == NONE).count(), 4);
        assert_eq!(topology.corners_of(4), [2, 5, 8, 11]);
    }

    #[test]
    fn a_vertex_comes_apart_when_two_edges_let_go() {
        let topology = Topology::new(&square()).expect("a mesh");
        let mut nodes = Nodes::new(square().triangles, 5);
        let mut groups = Vec::new();
        topology.groups(4, |edge| edge != 0, &mut groups);
        assert_eq!(groups, [0; 4]);
        assert!(!nodes.split(topology.corners_of(4), &groups, |_, _| ()));
        let (first, last) = (topology.edge_of[0][1], topology.edge_of[2][1]);
        topology.groups(4, |edge| edge != first && edge != last, &mut groups);
        assert_eq!(groups, [0, 1, 1, 0]);
        let mut added = Vec::new();
        assert!(nodes.split(topology.corners_of(4), &groups, |old, new| added.push((old, new))));
        assert_eq!((added, nodes.first.len()), (vec![(4, 5)], 6));
        assert_eq!([2, 5, 8, 11].map(|corner| nodes.node_at(corner)), [4, 5, 5, 4]);
        assert_eq!((nodes.first[4], nodes.next[2], nodes.next[11]), (2, 11, NONE));
        assert_eq!((nodes.first[5], nodes.next[5], nodes.next[8]), (5, 8, NONE));
        // Splitting again by the same groups changes nothing.
        assert!(!nodes.split(topology.corners_of(4), &groups, |_, _| ()));
    }

    #[test]
    fn meshes_that_are_none_are_refused() {
        let mut mesh = square();
        mesh.nodes.push([9.0, 9.0]);
        assert_eq!(Topology::new(&mesh).err(), Some(ModelError::LooseNode { node: 5 }));
        let mut mesh = square();
        mesh.triangles[1] = [2, 1, 4];
        assert!(matches!(Topology::new(&mesh), Err(ModelError::Folded { .. })));
        let mut mesh = square();
        mesh.triangles.push([0, 1, 3]);
        mesh.triangles.push([1, 0, 2]);
        assert!(Topology::new(&mesh).is_err());
    }
}
