//! Connectivity of elements: their corners, the nodes that they share, and the facets between them, in any
//! dimension.
//!
//! A *vertex* is a node of the given mesh; a *node* is a point that moves. A vertex has one node where the
//! mesh is intact, and several nodes where it has broken. Each of these is shared by the corners of elements
//! that are still connected there. Corner `N e + k` is the `k`-th corner of element `e`.

use fdem_mesh::Mesh;

use crate::error::ModelError;
use crate::simplex::Simplex;

/// Stands for no facet or no joint.
pub(crate) const NONE: u32 = u32::MAX;

/// A facet between two elements. Side 0 is the element with the lower number. Both sides list their corners
/// in the order in which they go around side 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Facet<const D: usize = 2> {
    pub(crate) corners: [[u32; D]; 2],
}

impl<const D: usize> Facet<D> {
    pub(crate) fn elements(&self) -> [u32; 2] {
        self.corners.map(|side| side[0] / (D as u32 + 1))
    }
}

/// Connectivity of the given mesh, which does not change when the mesh breaks.
#[derive(Clone, Debug)]
pub(crate) struct Topology<const D: usize = 2, const N: usize = 3> {
    /// Vertex of each corner.
    pub(crate) vertices: Vec<u32>,
    /// The corners of vertex `v` are `corners[offsets[v]..offsets[v + 1]]`, ascending.
    offsets: Vec<u32>,
    corners: Vec<u32>,
    /// Facets between elements.
    pub(crate) facets: Vec<Facet<D>>,
    /// The facets of each element, in the order of [`Simplex::FACETS`]; [`NONE`] on the surface.
    pub(crate) facet_of: Vec<[u32; N]>,
    /// Numbers and surface of a part of a mesh; `None` for a whole one.
    part: Option<PartOf<N>>,
}

/// Numbers of a part of a mesh in the whole mesh, and its share of the surface.
#[derive(Clone, Debug)]
pub(crate) struct PartOf<const N: usize> {
    /// Numbers of the elements in the whole mesh, ascending.
    pub(crate) numbers: Vec<u32>,
    /// Numbers of the vertices in the whole mesh, ascending.
    pub(crate) vertices: Vec<u32>,
    /// Whether each facet of each element is on the surface of the whole mesh.
    pub(crate) outer: Vec<[bool; N]>,
}

impl<const D: usize, const N: usize> Topology<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The connectivity of a mesh.
    pub(crate) fn of(mesh: &Mesh<D, N>) -> Result<Self, ModelError> {
        Self::new(mesh.nodes.len(), &mesh.elements)
    }

    /// The connectivity of a part of a mesh.
    pub(crate) fn of_part(mesh: &Mesh<D, N>, part: PartOf<N>) -> Result<Self, ModelError> {
        Ok(Self { part: Some(part), ..Self::of(mesh)? })
    }

    /// The connectivity of elements with these of `vertices` vertices as corners.
    pub(crate) fn new(vertices: usize, elements: &[[u32; N]]) -> Result<Self, ModelError> {
        let mut offsets = vec![0_u32; vertices + 1];
        let vertices: Vec<u32> = elements.iter().flatten().copied().collect();
        for &vertex in &vertices {
            offsets[vertex as usize + 1] += 1;
        }
        for k in 1..offsets.len() {
            if offsets[k] == 0 {
                return Err(ModelError::LooseNode { node: k - 1 });
            }
            offsets[k] += offsets[k - 1];
        }
        let mut next = offsets.clone();
        let mut corners = vec![0; vertices.len()];
        for (corner, &vertex) in vertices.iter().enumerate() {
            corners[next[vertex as usize] as usize] = corner as u32;
            next[vertex as usize] += 1;
        }
        let (facets, facet_of) = facets(&vertices)?;
        Ok(Self { vertices, offsets, corners, facets, facet_of, part: None })
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { vertices, offsets, corners, facets, facet_of, part } = self;
        let of_part = |part: &PartOf<N>| {
            size_of_val(&*part.numbers) + size_of_val(&*part.vertices) + size_of_val(&*part.outer)
        };
        size_of_val(&**vertices)
            + size_of_val(&**offsets)
            + size_of_val(&**corners)
            + size_of_val(&**facets)
            + size_of_val(&**facet_of)
            + part.as_ref().map_or(0, of_part)
    }

    /// Whether a facet without another element is on the surface of the whole mesh.
    pub(crate) fn is_outer(&self, element: usize, k: usize) -> bool {
        self.part.as_ref().is_none_or(|part| part.outer[element][k])
    }

    /// The number of an element in the whole mesh.
    #[inline]
    pub(crate) fn number(&self, element: u32) -> u32 {
        self.part.as_ref().map_or(element, |part| part.numbers[element as usize])
    }

    /// Whether this is the whole mesh.
    pub(crate) fn is_whole(&self) -> bool {
        self.part.is_none()
    }

    /// The number of a vertex in the whole mesh.
    pub(crate) fn vertex(&self, vertex: u32) -> u32 {
        self.part.as_ref().map_or(vertex, |part| part.vertices[vertex as usize])
    }

    /// The vertex with a number in the whole mesh; `None` if it is not in this part.
    pub(crate) fn vertex_with(&self, number: u32) -> Option<u32> {
        match &self.part {
            Some(part) => part.vertices.binary_search(&number).ok().map(|vertex| vertex as u32),
            None => Some(number),
        }
    }

    /// Whether there is a facet between two elements with these vertices.
    pub(crate) fn has_facet(&self, vertices: &[u32; D]) -> bool {
        let of = |facet: u32| self.facets[facet as usize].corners[0].map(|at| self.vertices[at as usize]);
        let is = |facet: u32| of(facet).iter().all(|vertex| vertices.contains(vertex));
        self.facets_around(vertices[0]).any(|(facet, _)| is(facet))
    }

    /// The element with a number in the whole mesh; `None` if it is not in this part.
    pub(crate) fn element(&self, number: u32) -> Option<u32> {
        match &self.part {
            Some(part) => part.numbers.binary_search(&number).ok().map(|element| element as u32),
            None => ((number as usize) < self.facet_of.len()).then_some(number),
        }
    }

    /// The code of a corner, the same in each part of a mesh: N times the number of its element, and its
    /// place there.
    #[inline]
    pub(crate) fn code_of_corner(&self, corner: u32) -> u32 {
        self.number(corner / N as u32) * N as u32 + corner % N as u32
    }

    /// The corner with a code; `None` if its element is not in this part.
    pub(crate) fn corner(&self, code: u32) -> Option<u32> {
        self.element(code / N as u32).map(|element| element * N as u32 + code % N as u32)
    }

    /// The code of a side, an element's facet by its corners: N times the number of the element, and the
    /// place of the facet there.
    pub(crate) fn code_of_side(&self, side: &[u32; D]) -> u32 {
        self.number(side[0] / N as u32) * N as u32 + place_in_element::<D, N>(side) as u32
    }

    /// The code of a facet: that of its first side.
    pub(crate) fn code(&self, facet: u32) -> u32 {
        self.code_of_side(&self.facets[facet as usize].corners[0])
    }

    /// The facet with a code; `None` if no facet has it, or its elements are not in this part.
    pub(crate) fn facet_with(&self, code: u32) -> Option<u32> {
        let facet = self.facet_of[self.element(code / N as u32)? as usize][code as usize % N];
        (facet != NONE && self.code(facet) == code).then_some(facet)
    }

    pub(crate) fn corners_of(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.corners[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Facets on the surface, each by its corners.
    pub(crate) fn surface(&self) -> impl Iterator<Item = [u32; D]> + '_ {
        self.facet_of.iter().enumerate().flat_map(move |(element, facets)| {
            let outer = (0..N).filter(move |&k| facets[k] == NONE && self.is_outer(element, k));
            outer.map(move |k| corners_of_facet(element, k))
        })
    }

    /// Facets on the surface that meet at a vertex, each by its corners.
    pub(crate) fn surface_at(&self, vertex: u32) -> impl Iterator<Item = [u32; D]> + '_ {
        self.corners_of(vertex).iter().flat_map(move |&corner| {
            let element = corner as usize / N;
            let outer = move |k: &usize| self.facet_of[element][*k] == NONE && self.is_outer(element, *k);
            let at = <[[f64; D]; N]>::AT_CORNER[corner as usize % N];
            at.into_iter().filter(outer).map(move |k| corners_of_facet(element, k))
        })
    }

    /// Numbers the pieces whose elements are connected by facets that hold, from 0 in the order of their
    /// first elements. Returns the piece of each element.
    pub(crate) fn pieces(&self, holds: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut pieces = vec![NONE; self.facet_of.len()];
        let (mut count, mut waiting) = (0, Vec::new());
        for first in 0..pieces.len() {
            if pieces[first] != NONE {
                continue;
            }
            pieces[first] = count;
            waiting.push(first);
            while let Some(element) = waiting.pop() {
                let held = self.facet_of[element].into_iter().filter(|&facet| facet != NONE && holds(facet));
                for next in held.flat_map(|facet| self.facets[facet as usize].elements()) {
                    if pieces[next as usize] == NONE {
                        pieces[next as usize] = count;
                        waiting.push(next as usize);
                    }
                }
            }
            count += 1;
        }
        pieces
    }

    /// Returns the facets between elements that meet at a vertex, each once and with the corner of its
    /// side 0.
    pub(crate) fn facets_around(&self, vertex: u32) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.corners_of(vertex).iter().flat_map(move |&corner| {
            let own = move |facet: &u32| {
                *facet != NONE && self.facets[*facet as usize].elements()[0] == corner / N as u32
            };
            self.facets_at(corner).into_iter().filter(own).map(move |facet| (facet, corner))
        })
    }

    /// Returns the facets of an element that meet at one of its corners; [`NONE`] on the surface.
    pub(crate) fn facets_at(&self, corner: u32) -> [u32; D] {
        let facets = &self.facet_of[corner as usize / N];
        <[[f64; D]; N]>::AT_CORNER[corner as usize % N].map(|k| facets[k])
    }

    /// Returns the corner at the same vertex in the element on the other side of a facet.
    fn across(&self, facet: u32, corner: u32) -> u32 {
        let [one, other] = &self.facets[facet as usize].corners;
        let place = one.iter().position(|&own| own == corner);
        match place {
            Some(place) => other[place],
            None => other.iter().zip(one).find(|(own, _)| **own == corner).map_or(corner, |(_, &one)| one),
        }
    }

    /// Groups the corners of a vertex. Corners of elements with a common facet that holds are in the same
    /// group. `groups` gets the group of each corner, in the order of [`Self::corners_of`]. The number of a
    /// group is the place of its first corner in that order.
    pub(crate) fn groups(&self, vertex: u32, holds: impl Fn(u32) -> bool, groups: &mut Vec<u32>) {
        let corners = self.corners_of(vertex);
        // Each place points to an earlier one of its group, or to itself if it is the first.
        groups.clear();
        groups.extend(0..corners.len() as u32);
        let first = |groups: &[u32], mut place: u32| {
            while groups[place as usize] != place {
                place = groups[place as usize];
            }
            place
        };
        for (place, &corner) in (0..).zip(corners) {
            for facet in self.facets_at(corner) {
                // Once for each facet, from its side 0.
                if facet == NONE
                    || self.facets[facet as usize].elements()[0] != corner / N as u32
                    || !holds(facet)
                {
                    continue;
                }
                let Ok(other) = corners.binary_search(&self.across(facet, corner)) else { continue };
                let [one, other] = [place, other as u32].map(|place| first(groups, place));
                groups[one.max(other) as usize] = one.min(other);
            }
        }
        for place in 0..groups.len() {
            groups[place] = groups[groups[place] as usize];
        }
    }

    /// Finds the facets at a vertex without which corners that are connected there would no longer be: the
    /// bridges of the graph of its corners (R. E. Tarjan, Inf. Process. Lett. 2 (1974) 160-161). Linear in
    /// the number of corners.
    pub(crate) fn bridges(&self, vertex: u32, holds: impl Fn(u32) -> bool, bridges: &mut Vec<u32>) {
        bridges.clear();
        let corners = self.corners_of(vertex);
        // When each corner was reached, and the earliest corner that it reaches without the facet by which it
        // was reached.
        let (mut reached, mut earliest) = (vec![NONE; corners.len()], vec![NONE; corners.len()]);
        let mut path: Vec<(usize, u32, usize)> = Vec::new();
        let mut count = 0;
        for first in 0..corners.len() {
            let mut next = (reached[first] == NONE).then_some((first, NONE));
            loop {
                if let Some((place, by)) = next.take() {
                    (reached[place], earliest[place]) = (count, count);
                    count += 1;
                    path.push((place, by, 0));
                }
                let Some((place, by, slot)) = path.last_mut() else { break };
                let (place, by) = (*place, *by);
                if let Some(&facet) = self.facets_at(corners[place]).get(*slot) {
                    *slot += 1;
                    if facet == NONE || facet == by || !holds(facet) {
                        continue;
                    }
                    let Ok(other) = corners.binary_search(&self.across(facet, corners[place])) else {
                        continue;
                    };
                    if reached[other] == NONE {
                        next = Some((other, facet));
                    } else {
                        earliest[place] = earliest[place].min(reached[other]);
                    }
                } else {
                    path.pop();
                    if let Some(&(before, ..)) = path.last() {
                        earliest[before] = earliest[before].min(earliest[place]);
                        if earliest[place] > reached[before] {
                            bridges.push(by);
                        }
                    }
                }
            }
        }
    }
}

/// Corners of facet `k` of an element.
pub(crate) fn corners_of_facet<const D: usize, const N: usize>(element: usize, k: usize) -> [u32; D]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    <[[f64; D]; N]>::FACETS[k].map(|corner| (N * element + corner) as u32)
}

/// The number of a facet in its element, as [`Simplex::FACETS`] has them.
pub(crate) fn place_in_element<const D: usize, const N: usize>(corners: &[u32; D]) -> usize
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let own = |at: &usize| corners.iter().any(|&corner| corner as usize % N == *at);
    (0..N).find(|&k| <[[f64; D]; N]>::FACETS[k].iter().all(own)).unwrap_or_default()
}

/// Finds the facets between two elements, in the order of the lower element and its facets, from the vertices
/// of all corners.
#[allow(clippy::type_complexity, reason = "two columns, named where they are used")]
fn facets<const D: usize, const N: usize>(
    vertices: &[u32],
) -> Result<(Vec<Facet<D>>, Vec<[u32; N]>), ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let corners = |side: u32| corners_of_facet::<D, N>(side as usize / N, side as usize % N);
    let vertices_of = |side: u32| corners(side).map(|corner| vertices[corner as usize]);
    let mut sides: Vec<([u32; D], u32)> = (0..vertices.len() as u32)
        .map(|side| {
            let mut key = vertices_of(side);
            key.sort_unstable();
            (key, side)
        })
        .collect();
    sides.sort_unstable();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for same in sides.chunk_by(|a, b| a.0 == b.0) {
        match *same {
            [_] => {}
            [(_, a), (_, b)] => {
                if !are_opposite(&vertices_of(a), &vertices_of(b)) {
                    return Err(ModelError::Folded { elements: [a / N as u32, b / N as u32] });
                }
                pairs.push([a, b]);
            }
            _ => {
                let elements = [same[0].1, same[1].1, same[2].1].map(|side| side / N as u32);
                return Err(ModelError::ManyOnEdge { elements });
            }
        }
    }
    pairs.sort_unstable();
    let mut facet_of = vec![[NONE; N]; vertices.len() / N];
    let facets = pairs.iter().enumerate().map(|(number, &[a, b])| {
        for side in [a, b] {
            facet_of[side as usize / N][side as usize % N] = number as u32;
        }
        // The other element has its corners in the opposite order.
        let (own, others) = (vertices_of(a), corners(b));
        let opposite = own.map(|vertex| {
            let there = |&&corner: &&u32| vertices[corner as usize] == vertex;
            others.iter().find(there).copied().unwrap_or(NONE)
        });
        Facet { corners: [corners(a), opposite] }
    });
    Ok((facets.collect(), facet_of))
}

/// Whether two facets with the same vertices go around them in opposite directions: whether an odd number of
/// exchanges makes one of the other.
fn are_opposite<const D: usize>(one: &[u32; D], other: &[u32; D]) -> bool {
    let (sorted, odd) = exchanged(one, other);
    odd && sorted == *one
}

/// Whether two facets have the same vertices and the same outside: whether an even number of exchanges makes
/// one of the other.
pub(crate) fn are_alike<const D: usize>(one: &[u32; D], other: &[u32; D]) -> bool {
    let (sorted, odd) = exchanged(one, other);
    !odd && sorted == *one
}

/// The other list in the order of the first, as far as they have the same members, and whether this takes an
/// odd number of exchanges.
fn exchanged<const D: usize>(one: &[u32; D], other: &[u32; D]) -> ([u32; D], bool) {
    let (mut other, mut odd) = (*other, false);
    for k in 0..D {
        if let Some(place) = (k + 1..D).find(|&place| other[k] != one[k] && other[place] == one[k]) {
            other.swap(k, place);
            odd = !odd;
        }
    }
    (other, odd)
}

/// Corners of each node, in ascending order.
#[derive(Clone, Debug)]
pub(crate) struct Nodes<const N: usize = 3> {
    /// Nodes of the corners of each element.
    pub(crate) of_corner: Vec<[u32; N]>,
    /// Corners, those of a node together.
    corners: Vec<u32>,
    /// Where the corners of each node begin and end in that list.
    ranges: Vec<[u32; 2]>,
}

impl<const N: usize> Nodes<N> {
    /// Builds the lists from the nodes of the corners of each element. `count` is the number of nodes.
    pub(crate) fn new(of_corner: Vec<[u32; N]>, count: usize) -> Self {
        // Counting sort.
        let all = of_corner.as_flattened();
        let mut ranges = vec![[0; 2]; count];
        for &node in all {
            ranges[node as usize][1] += 1;
        }
        let mut end = 0;
        for range in &mut ranges {
            let count = range[1];
            *range = [end, end];
            end += count;
        }
        let mut corners = vec![0; all.len()];
        for (corner, &node) in (0..).zip(all) {
            let next = &mut ranges[node as usize][1];
            corners[*next as usize] = corner;
            *next += 1;
        }
        Self { of_corner, corners, ranges }
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { of_corner, corners, ranges } = self;
        size_of_val(&**of_corner) + size_of_val(&**corners) + size_of_val(&**ranges)
    }

    /// Reserves memory for `more` further nodes.
    pub(crate) fn reserve(&mut self, more: usize) {
        self.ranges.reserve_exact(more);
    }

    /// Number of nodes.
    #[cfg(test)]
    pub(crate) fn count(&self) -> usize {
        self.ranges.len()
    }

    /// Corners of a node, ascending.
    #[inline]
    pub(crate) fn of(&self, node: usize) -> &[u32] {
        let [first, end] = self.ranges[node];
        &self.corners[first as usize..end as usize]
    }

    /// The corners of all nodes, those of a node together.
    pub(crate) fn list(&self) -> &[u32] {
        &self.corners
    }

    /// Where the corners of a node begin and end in that list.
    pub(crate) fn range(&self, node: usize) -> [u32; 2] {
        self.ranges[node]
    }

    /// Returns the node of a corner.
    #[inline]
    pub(crate) fn node_at(&self, corner: u32) -> u32 {
        self.of_corner[corner as usize / N][corner as usize % N]
    }

    fn set(&mut self, corner: u32, node: u32) {
        self.of_corner[corner as usize / N][corner as usize % N] = node;
    }

    /// Gives each group of the corners `of` a vertex a separate node. The first group of each node keeps the
    /// node, the others get new nodes. Calls `added` with the old node and the new one for each new node.
    /// Returns whether there are any.
    ///
    /// The corners of a group must have one node.
    pub(crate) fn split(&mut self, of: &[u32], groups: &[u32], mut added: impl FnMut(u32, u32)) -> bool {
        let mut split = Vec::new();
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
                let new = self.ranges.len() as u32;
                self.ranges.push([0; 2]);
                self.set(corner, new);
                split.push(node);
                added(node, new);
            }
        }
        for &node in &split {
            self.divide(node);
        }
        !split.is_empty()
    }

    /// Divides the list of a node among the nodes that its corners have now.
    fn divide(&mut self, node: u32) {
        let [first, end] = self.ranges[node as usize];
        let of_corner = &self.of_corner;
        let node_at = |corner: u32| of_corner[corner as usize / N][corner as usize % N];
        let list = &mut self.corners[first as usize..end as usize];
        // A stable sort: the corners of each node stay ascending.
        list.sort_by_key(|&corner| node_at(corner));
        let mut begin = first;
        for same in list.chunk_by(|&a, &b| node_at(a) == node_at(b)) {
            let end = begin + same.len() as u32;
            self.ranges[node_at(same[0]) as usize] = [begin, end];
            begin = end;
        }
    }
}

#[cfg(test)]
mod tests;
