//! Connectivity in two and three dimensions: known cases, and any order of breaking facets of any mesh.

use proptest::prelude::*;
use proptest::sample::Index;

use super::*;

/// A square of four triangles around its middle, vertex 4.
const SQUARE: [[u32; 3]; 4] = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];

/// An octahedron of four tetrahedra around the edge from vertex 4 to vertex 5.
const OCTAHEDRON: [[u32; 4]; 4] = [[4, 5, 0, 1], [4, 5, 1, 2], [4, 5, 2, 3], [4, 5, 3, 0]];

#[test]
fn the_facets_of_a_simplex_and_those_at_its_corners() {
    fn check<const D: usize, const N: usize>()
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let facets = <[[f64; D]; N]>::FACETS;
        for corner in 0..N {
            let at: Vec<usize> = (0..N).filter(|&k| facets[k].contains(&corner)).collect();
            let mut told = <[[f64; D]; N]>::AT_CORNER[corner].to_vec();
            told.sort_unstable();
            assert_eq!(told, at, "{D} dimensions, corner {corner}");
        }
        // Two facets of one element traverse their common nodes in opposite directions, as the facets of two
        // elements do.
        for k in 0..N {
            for l in (0..N).filter(|&l| l != k) {
                let lonely = facets[l].into_iter().find(|corner| !facets[k].contains(corner));
                let replaced =
                    facets[k].map(|corner| if facets[l].contains(&corner) { Some(corner) } else { lonely });
                let other = facets[l].map(Some);
                let positions = replaced
                    .map(|corner| other.iter().position(|&own| own == corner).map_or(NONE, |k| k as u32));
                assert!(are_opposite(&std::array::from_fn(|k| k as u32), &positions), "{k} {l}");
            }
        }
    }
    check::<2, 3>();
    check::<3, 4>();
}

#[test]
fn facets_are_found_from_both_sides() {
    fn check<const D: usize, const N: usize>(vertices: usize, elements: &[[u32; N]]) -> Topology<D, N>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let topology = Topology::new(vertices, elements).expect("a mesh");
        assert_eq!(topology.facets.len(), 4);
        for (number, facet) in (0..).zip(&topology.facets) {
            for place in 0..D {
                let [a, b] = facet.corners.map(|side| topology.vertices[side[place] as usize]);
                assert_eq!(a, b);
            }
            let elements = facet.elements();
            assert!(elements[0] < elements[1]);
            for (side, element) in elements.into_iter().enumerate() {
                let k = topology.facet_of[element as usize].iter().position(|&own| own == number);
                let mut corners = corners_of_facet::<D, N>(element as usize, k.expect("its own facet"));
                let mut told = facet.corners[side];
                if side == 0 {
                    assert_eq!(told, corners, "side 0 goes around as the element does");
                }
                corners.sort_unstable();
                told.sort_unstable();
                assert_eq!(told, corners);
            }
        }
        let outer = topology.surface().count();
        assert_eq!(outer, 4 * N - 8);
        topology
    }
    let square = check::<2, 3>(5, &SQUARE);
    assert_eq!(square.corners_of(4), [2, 5, 8, 11]);
    assert_eq!(outer_vertices(&square), [0, 1, 2, 3]);
    let octahedron = check::<3, 4>(6, &OCTAHEDRON);
    assert_eq!(octahedron.corners_of(4), [0, 4, 8, 12]);
    assert_eq!(outer_vertices(&octahedron), [0, 1, 2, 3, 4, 5]);
}

/// The vertices of the surface, ascending.
fn outer_vertices<const D: usize, const N: usize>(topology: &Topology<D, N>) -> Vec<u32>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut vertices: Vec<u32> =
        topology.surface().flatten().map(|corner| topology.vertices[corner as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

#[test]
fn a_vertex_comes_apart_when_two_facets_let_go() {
    let topology = Topology::<2, 3>::new(5, &SQUARE).expect("a mesh");
    let mut nodes = Nodes::new(SQUARE.to_vec(), 5);
    let mut groups = Vec::new();
    topology.groups(4, |facet| facet != 0, &mut groups);
    assert_eq!(groups, [0; 4]);
    assert!(!nodes.split(topology.corners_of(4), &groups, |_, _| ()));
    let (first, last) = (topology.facet_of[0][1], topology.facet_of[2][1]);
    topology.groups(4, |facet| facet != first && facet != last, &mut groups);
    assert_eq!(groups, [0, 1, 1, 0]);
    let mut added = Vec::new();
    assert!(nodes.split(topology.corners_of(4), &groups, |old, new| added.push((old, new))));
    assert_eq!((added, nodes.count()), (vec![(4, 5)], 6));
    assert_eq!([2, 5, 8, 11].map(|corner| nodes.node_at(corner)), [4, 5, 5, 4]);
    assert_eq!([nodes.of(4), nodes.of(5)], [[2, 11], [5, 8]]);
    // Splitting again by the same groups changes nothing.
    assert!(!nodes.split(topology.corners_of(4), &groups, |_, _| ()));
}

/// A facet whose vertices are all single cannot open; two facets through the middle part the octahedron in
/// two, at both ends of their common edge.
#[test]
fn an_octahedron_comes_apart_when_two_facets_let_go() {
    let topology = Topology::<3, 4>::new(6, &OCTAHEDRON).expect("a mesh");
    let between = |a: u32, b: u32| {
        let both = |facet: &&Facet<3>| facet.elements() == [a, b];
        let place = topology.facets.iter().position(|facet| both(&facet));
        place.expect("a facet") as u32
    };
    let mut groups = Vec::new();
    let broken = [between(0, 1), between(2, 3)];
    topology.groups(4, |facet| facet != broken[0], &mut groups);
    assert_eq!(groups, [0; 4]);
    let mut nodes = Nodes::new(OCTAHEDRON.to_vec(), 6);
    for vertex in 0..6 {
        topology.groups(vertex, |facet| !broken.contains(&facet), &mut groups);
        nodes.split(topology.corners_of(vertex), &groups, |_, _| ());
    }
    assert_eq!(nodes.count(), 10, "vertices 4 and 5, and those of the two facets, have two nodes each");
    assert_eq!(topology.pieces(|facet| !broken.contains(&facet)), [0, 1, 1, 0]);
}

#[test]
fn meshes_that_are_none_are_refused() {
    assert_eq!(Topology::<2, 3>::new(6, &SQUARE).err(), Some(ModelError::LooseNode { node: 5 }));
    assert_eq!(Topology::<3, 4>::new(7, &OCTAHEDRON).err(), Some(ModelError::LooseNode { node: 6 }));
    let mut square = SQUARE;
    square[1] = [2, 1, 4];
    assert!(matches!(Topology::<2, 3>::new(5, &square), Err(ModelError::Folded { .. })));
    let mut octahedron = OCTAHEDRON;
    octahedron[1] = [5, 4, 1, 2];
    assert!(matches!(Topology::<3, 4>::new(6, &octahedron), Err(ModelError::Folded { .. })));
    let mut square = SQUARE.to_vec();
    square.extend([[0, 1, 3], [1, 0, 2]]);
    assert!(matches!(Topology::<2, 3>::new(5, &square), Err(ModelError::ManyOnEdge { .. })));
    let mut octahedron = OCTAHEDRON.to_vec();
    octahedron.extend([[4, 5, 0, 2]]);
    assert!(matches!(Topology::<3, 4>::new(6, &octahedron), Err(ModelError::ManyOnEdge { .. })));
}

/// A mesh of any shape: a grid of cubes, each cut into simplices along a diagonal, of which some are missing.
#[derive(Clone, Debug)]
struct AnyMesh<const N: usize> {
    vertices: usize,
    elements: Vec<[u32; N]>,
}

/// The orders of `D` axes, each with whether it is odd.
fn orders<const D: usize>() -> Vec<([usize; D], bool)> {
    fn fill<const D: usize>(taken: usize, order: [usize; D], odd: bool, all: &mut Vec<([usize; D], bool)>) {
        if taken == D {
            return all.push((order, odd));
        }
        for place in taken..D {
            let mut next = order;
            next.swap(taken, place);
            fill(taken + 1, next, odd != (place != taken), all);
        }
    }
    let mut all = Vec::new();
    fill(0, std::array::from_fn(|axis| axis), false, &mut all);
    all
}

/// Elements of a grid of `cells` cubes along each axis, those of which `kept` holds, in the order of
/// `shuffle`.
fn mesh<const D: usize, const N: usize>(cells: u32, kept: &[bool], shuffle: &[Index]) -> AnyMesh<N> {
    let edge = cells + 1;
    let number = |at: [u32; D]| at.into_iter().rev().fold(0, |number, k| number * edge + k);
    let mut elements = Vec::new();
    for cube in 0..cells.pow(D as u32) {
        let low: [u32; D] = std::array::from_fn(|axis| cube / cells.pow(axis as u32) % cells);
        for (order, odd) in orders::<D>() {
            let mut at = low;
            let mut element = [0; N];
            for k in 0..N {
                element[k] = number(at);
                if k < D {
                    at[order[k]] += 1;
                }
            }
            if odd {
                element.swap(0, 1);
            }
            elements.push(element);
        }
    }
    let mut kept = kept.iter().cycle();
    elements.retain(|_| *kept.next().unwrap_or(&true));
    for (place, index) in (1..elements.len()).zip(shuffle.iter().cycle()) {
        elements.swap(place, index.index(place + 1));
    }
    // Vertices without elements have no number.
    let mut used: Vec<u32> = elements.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let renumbered = |vertex: u32| used.partition_point(|&other| other < vertex) as u32;
    AnyMesh {
        vertices: used.len(),
        elements: elements.iter().map(|corners| corners.map(renumbered)).collect(),
    }
}

/// Groups of the corners of a vertex by comparing all facets with each other until nothing changes.
fn flooded<const D: usize, const N: usize>(
    topology: &Topology<D, N>,
    corners: &[u32],
    held: &[bool],
) -> Vec<u32> {
    let mut groups: Vec<u32> = (0..corners.len() as u32).collect();
    loop {
        let before = groups.clone();
        for (facet, _) in topology.facets.iter().zip(held).filter(|(_, held)| **held) {
            for place in 0..D {
                let [a, b] = facet.corners.map(|side| corners.iter().position(|&own| own == side[place]));
                if let (Some(a), Some(b)) = (a, b) {
                    let least = groups[a].min(groups[b]);
                    (groups[a], groups[b]) = (least, least);
                }
            }
        }
        if groups == before {
            return groups;
        }
    }
}

/// Breaks facets one after the other. After each, nodes and groups are compared with their definition.
fn any_order_of_breaking<const D: usize, const N: usize>(mesh: &AnyMesh<N>, order: &[Index])
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let topology = Topology::<D, N>::new(mesh.vertices, &mesh.elements).expect("a mesh");
    let mut nodes = Nodes::new(mesh.elements.clone(), mesh.vertices);
    let mut held = vec![true; topology.facets.len()];
    // Mass of each node: every corner weighs something else.
    let weight = |corner: u32| 1 + u64::from(corner);
    let total: u64 = (0..topology.vertices.len() as u32).map(weight).sum();
    let (mut groups, mut bridges) = (Vec::new(), Vec::new());
    let all: Vec<u32> = (0..mesh.vertices as u32).collect();
    let mut parted = all.clone();
    for index in std::iter::once(None).chain(order.iter().map(Some)) {
        let left: Vec<usize> = (0..held.len()).filter(|&facet| held[facet]).collect();
        if let Some(index) = index {
            if left.is_empty() {
                break;
            }
            let facet = left[index.index(left.len())];
            held[facet] = false;
            parted =
                topology.facets[facet].corners[0].map(|corner| topology.vertices[corner as usize]).to_vec();
        }
        for &vertex in &parted {
            topology.groups(vertex, |facet| held[facet as usize], &mut groups);
            nodes.split(topology.corners_of(vertex), &groups, |_, _| ());
        }
        let mut mass = 0;
        for node in 0..nodes.count() {
            let mut last = None;
            assert!(!nodes.of(node).is_empty(), "a node without corners");
            for &corner in nodes.of(node) {
                assert!(last < Some(corner), "the corners of a node ascend");
                assert_eq!(nodes.node_at(corner) as usize, node);
                mass += weight(corner);
                last = Some(corner);
            }
        }
        assert_eq!(mass, total);
        for &vertex in &all {
            let corners = topology.corners_of(vertex);
            topology.groups(vertex, |facet| held[facet as usize], &mut groups);
            assert_eq!(groups, flooded(&topology, corners, &held));
            topology.bridges(vertex, |facet| held[facet as usize], &mut bridges);
            bridges.sort_unstable();
            let parts = |facet: &u32| {
                held[*facet as usize] && {
                    let mut without = Vec::new();
                    topology.groups(vertex, |other| other != *facet && held[other as usize], &mut without);
                    without != groups
                }
            };
            let mut parting: Vec<u32> =
                topology.facets_around(vertex).map(|(facet, _)| facet).filter(parts).collect();
            parting.sort_unstable();
            assert_eq!(bridges, parting);
            for (a, one) in corners.iter().enumerate() {
                for (b, other) in corners.iter().enumerate() {
                    let together = nodes.node_at(*one) == nodes.node_at(*other);
                    assert_eq!(together, groups[a] == groups[b], "corners that hang together have one node");
                }
            }
        }
        // A run that is resumed builds the lists again.
        let again = Nodes::new(nodes.of_corner.clone(), nodes.count());
        assert!((0..nodes.count()).all(|node| again.of(node) == nodes.of(node)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_order_of_breaking_edges_of_triangles(
        kept in prop::collection::vec(prop::bool::weighted(0.8), 32),
        shuffle in prop::collection::vec(any::<Index>(), 32),
        order in prop::collection::vec(any::<Index>(), 0..40),
    ) {
        any_order_of_breaking::<2, 3>(&mesh::<2, 3>(4, &kept, &shuffle), &order);
    }

    #[test]
    fn any_order_of_breaking_faces_of_tetrahedra(
        kept in prop::collection::vec(prop::bool::weighted(0.8), 48),
        shuffle in prop::collection::vec(any::<Index>(), 48),
        order in prop::collection::vec(any::<Index>(), 0..80),
    ) {
        any_order_of_breaking::<3, 4>(&mesh::<3, 4>(2, &kept, &shuffle), &order);
    }
}
