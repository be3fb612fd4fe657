//! A meshed body with its groups.

use std::collections::BTreeMap;

use fdem_io::numbers::brief;
use fdem_mesh::triangles::{INSIDE, Triangles};
use fdem_mesh::{Corners, facets_of, sorted, sorted_facets};

/// A body of triangles or of tetrahedra.
#[derive(Debug, Clone)]
pub(crate) struct Piece<const D: usize = 2, const N: usize = 3> {
    pub(crate) nodes: Vec<[f64; D]>,
    /// In the order of [`Mesh::elements`](fdem_mesh::Mesh).
    pub(crate) elements: Vec<[u32; N]>,
    /// Material of each element.
    pub(crate) materials: Vec<u32>,
    /// Grain of each element; empty if there are no grains.
    pub(crate) grains: Vec<u32>,
    /// Facets of one element only, with their nodes as that element has them.
    pub(crate) outline: Vec<[u32; D]>,
    pub(crate) groups: BTreeMap<String, PieceGroup<D>>,
    /// Joints of joint sets.
    pub(crate) joints: Vec<JointFacet<D>>,
    /// The lines of joint sets in the body.
    pub(crate) lines: Vec<LinesInBody>,
    /// The polygons of joint sets in the body.
    pub(crate) polygons: Vec<PolygonsInBody>,
    /// Warnings about the file of the mesh or of the packing, and about joints.
    pub(crate) notes: Vec<String>,
    /// The file of the mesh, the groups in it, and the differences between its elements and those of the
    /// body, one line each; empty if there is no file.
    pub(crate) about_file: Vec<String>,
}

/// A facet on a joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointFacet<const D: usize = 2> {
    /// Nodes of the facet.
    pub(crate) facet: [u32; D],
    /// Number of its joint set.
    pub(crate) set: u32,
    /// Number of the joint in its body.
    pub(crate) trace: u32,
}

/// The lines of a joint set in a body, and how many of them the mesh does not have.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinesInBody {
    /// Number of the joint set.
    pub(crate) set: u32,
    /// Length of all lines in the body, m.
    pub(crate) length: f64,
    /// Lines that vanish, at least for a part longer than an element.
    pub(crate) vanished: usize,
    /// Length that vanishes, m.
    pub(crate) vanished_length: f64,
}

/// The polygons of a joint set in a body, and how many of them the mesh does not have.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PolygonsInBody {
    /// Number of the joint set.
    pub(crate) set: u32,
    /// Number of polygons.
    pub(crate) count: usize,
    /// Polygons that are moved onto a face, or onto another polygon.
    pub(crate) left_out: usize,
}

/// Elements, nodes and facets that have a name.
#[derive(Debug, Clone)]
pub(crate) struct PieceGroup<const D: usize = 2> {
    pub(crate) elements: Vec<u32>,
    /// Nodes besides those of its elements and facets.
    pub(crate) nodes: Vec<u32>,
    /// Facets, with their nodes in any order.
    pub(crate) facets: Vec<[u32; D]>,
}

impl<const D: usize> Default for PieceGroup<D> {
    fn default() -> Self {
        Self { elements: Vec::new(), nodes: Vec::new(), facets: Vec::new() }
    }
}

impl<const D: usize, const N: usize> Default for Piece<D, N> {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            elements: Vec::new(),
            materials: Vec::new(),
            grains: Vec::new(),
            outline: Vec::new(),
            groups: BTreeMap::new(),
            joints: Vec::new(),
            lines: Vec::new(),
            polygons: Vec::new(),
            notes: Vec::new(),
            about_file: Vec::new(),
        }
    }
}

/// Adds notes on the file of several bodies to the first of them.
pub(crate) fn with_notes<const D: usize, const N: usize>(
    mut pieces: Vec<Piece<D, N>>,
    notes: Vec<String>,
) -> Vec<Piece<D, N>> {
    if let Some(first) = pieces.first_mut() {
        first.notes.extend(notes);
    }
    pieces
}

impl Piece {
    /// A mesh that was made here, with the groups "outer", "holes", "hole-1", ….
    pub(crate) fn new(meshed: Triangles, materials: Vec<u32>) -> Result<Self, String> {
        let Triangles { nodes, elements, loops, .. } = meshed;
        let mut piece = Self { nodes, elements, materials, ..Self::default() };
        piece.find_outline()?;
        for edge in &piece.outline {
            let number = loops[edge[0] as usize];
            if number == INSIDE {
                continue;
            }
            let names = if number == 0 {
                vec!["outer".to_owned()]
            } else {
                vec!["holes".to_owned(), format!("hole-{number}")]
            };
            for name in names {
                piece.groups.entry(name).or_default().facets.push(*edge);
            }
        }
        Ok(piece)
    }
}

impl<const D: usize, const N: usize> Piece<D, N>
where
    [[f64; D]; N]: Corners<D, N>,
{
    /// Finds the facets of one element only, in the order of their least nodes.
    ///
    /// # Errors
    /// Messages about facets of more than two elements, or of two on the same side.
    pub(crate) fn find_outline(&mut self) -> Result<(), String> {
        let facets = sorted_facets::<D, N>(&self.elements);
        // The nodes in the order in which the element has them.
        let of_element = |&(nodes, element): &([u32; D], u32)| {
            let facets = facets_of(&self.elements[element as usize]);
            facets.into_iter().find(|&facet| sorted(facet) == nodes).unwrap_or(nodes)
        };
        self.outline.clear();
        for alike in facets.chunk_by(|a, b| a.0 == b.0) {
            match alike {
                [only] => self.outline.push(of_element(only)),
                [one, other] if is_odd(of_element(one)) != is_odd(of_element(other)) => {}
                _ => {
                    let at = self.nodes[alike[0].0[0] as usize].map(brief).join(", ");
                    return Err(format!("elements lie on top of each other at a facet near [{at}]"));
                }
            }
        }
        Ok(())
    }

    /// The nodes that a group has: those of its set of nodes if there is one. Abaqus has sets of nodes and
    /// sets of elements of one name, and its supports and forces take those of the former.
    pub(crate) fn nodes_of(&self, group: &PieceGroup<D>) -> Vec<u32> {
        let inside = group.elements.iter().flat_map(|&element| self.elements[element as usize]);
        let mut nodes: Vec<u32> = if group.nodes.is_empty() {
            inside.chain(group.facets.iter().flatten().copied()).collect()
        } else {
            group.nodes.clone()
        };
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The facets of the outline that a group has.
    pub(crate) fn facets_of(&self, group: &PieceGroup<D>) -> Vec<[u32; D]> {
        let inside = group.elements.iter().flat_map(|&element| facets_of(&self.elements[element as usize]));
        let mut wanted: Vec<[u32; D]> = inside.chain(group.facets.iter().copied()).map(sorted).collect();
        wanted.sort_unstable();
        self.outline.iter().copied().filter(|&facet| wanted.binary_search(&sorted(facet)).is_ok()).collect()
    }

    /// The facets of a group that are between two elements.
    pub(crate) fn inner_facets_of(&self, group: &PieceGroup<D>) -> Vec<[u32; D]> {
        let facets = sorted_facets::<D, N>(&self.elements);
        let mut inner: Vec<[u32; D]> = group.facets.iter().map(|&facet| sorted(facet)).collect();
        inner.sort_unstable();
        inner.dedup();
        inner.retain(|facet| {
            let first = facets.partition_point(|(nodes, _)| nodes < facet);
            facets[first..].iter().take_while(|(nodes, _)| nodes == facet).count() == 2
        });
        inner
    }

    /// The facets between an element of a group whose name is accepted by `one`, and an element of another
    /// group whose name is accepted by `other`. An element of both groups is on neither side.
    pub(crate) fn facets_between(
        &self,
        one: impl Fn(&str) -> bool,
        other: impl Fn(&str) -> bool,
    ) -> Vec<[u32; D]> {
        // For each element, the numbers of its groups, and whether they are of the one and of the other.
        let mut groups_of: Vec<Vec<u32>> = vec![Vec::new(); self.elements.len()];
        let mut sides = Vec::new();
        for (name, group) in &self.groups {
            let accepted = [one(name), other(name)];
            if accepted != [false; 2] {
                for &element in &group.elements {
                    groups_of[element as usize].push(sides.len() as u32);
                }
                sides.push(accepted);
            }
        }
        let is_between = |a: u32, b: u32| {
            let [of_a, of_b] = [a, b].map(|element| &groups_of[element as usize]);
            let only_a = of_a.iter().filter(|group| !of_b.contains(group));
            let only_b: Vec<u32> = of_b.iter().copied().filter(|group| !of_a.contains(group)).collect();
            only_a.map(|&group| sides[group as usize]).any(|[is_one, is_other]| {
                let partner = |group: &u32| {
                    let [as_one, as_other] = sides[*group as usize];
                    is_one && as_other || is_other && as_one
                };
                only_b.iter().any(partner)
            })
        };
        let facets = sorted_facets::<D, N>(&self.elements);
        let shared = facets.chunk_by(|a, b| a.0 == b.0).filter_map(|alike| match alike {
            [(facet, a), (_, b)] if is_between(*a, *b) => Some(*facet),
            _ => None,
        });
        shared.collect()
    }

    /// The corners of an element.
    pub(crate) fn corners(&self, element: &[u32; N]) -> [[f64; D]; N] {
        element.map(|node| self.nodes[node as usize])
    }
}

/// Whether an odd number of exchanges sorts the nodes: two facets on the two sides of a face differ in this.
fn is_odd<const D: usize>(facet: [u32; D]) -> bool {
    let pairs = (0..D).flat_map(|one| (one + 1..D).map(move |other| (one, other)));
    pairs.filter(|&(one, other)| facet[one] > facet[other]).count() % 2 == 1
}
