//! Makes a mesh from the data of a reader: node numbers become indices, elements become triangles or
//! tetrahedra, and bodies are counted.

use crate::mesh::cut;
use crate::mesh::error::{Fault, MeshProblem};
use crate::mesh::file::{BodiesFrom, Cells, MeshBody, MeshFile, MeshGroup, MeshSource};
use crate::mesh::format::MeshFormat;
use crate::mesh::shape::Shape;
use crate::place::Place;

/// An element in the numbering of the file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raw {
    pub(crate) shape: Shape,
    pub(crate) place: Place,
    pub(crate) number: u64,
    /// Index into [`Draft::bodies`].
    pub(crate) body: u32,
    /// The corners that the shape has, with the numbers of the file.
    pub(crate) nodes: [i64; 8],
}

/// The corners of an element, of which at most eight are kept.
pub(crate) fn corners(nodes: &[i64]) -> [i64; 8] {
    std::array::from_fn(|at| nodes.get(at).copied().unwrap_or(0))
}

/// A named set of a file.
#[derive(Debug)]
pub(crate) struct DraftGroup {
    pub(crate) body: MeshBody,
    /// Indices into [`Draft::elements`].
    pub(crate) elements: Vec<u32>,
    /// Indices into [`Draft::points`].
    pub(crate) nodes: Vec<u32>,
    /// Elements, and which of the [faces](Shape::faces) of their shape.
    pub(crate) facets: Vec<(u32, usize)>,
}

/// How a file numbers its nodes.
#[derive(Debug)]
pub(crate) enum Numbering {
    /// Consecutive numbers from this one on.
    From(i64),
    /// One number for each point, in the order of the points.
    Own(Vec<i64>),
}

/// The data that a reader collects from a file.
#[derive(Debug)]
pub(crate) struct Draft {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) numbering: Numbering,
    /// The place of each point, to report repeated numbers; empty if numbers cannot repeat.
    pub(crate) places: Vec<Place>,
    pub(crate) elements: Vec<Raw>,
    /// Corners of the polygons among the elements.
    pub(crate) polygons: Vec<Vec<i64>>,
    pub(crate) groups: Vec<DraftGroup>,
    pub(crate) bodies: Vec<MeshBody>,
    pub(crate) bodies_from: BodiesFrom,
    /// Number of elements of one node that the reader did not collect.
    pub(crate) point_elements: u64,
    pub(crate) collapsed_facets: u64,
    /// Number of elements whose nodes on edges, on faces and inside were not collected.
    pub(crate) second_order: u64,
    /// Number of cohesive elements with a thickness, which were not collected.
    pub(crate) cohesive_elements: u64,
    /// Number of cohesive elements without thickness, which were collected as facets.
    pub(crate) cohesive_facets: u64,
    /// Parts of the file that were not collected, in words.
    pub(crate) unused: Vec<String>,
}

impl Draft {
    /// An empty draft with one body.
    pub(crate) fn new(numbering: Numbering) -> Self {
        Self {
            points: Vec::new(),
            numbering,
            places: Vec::new(),
            elements: Vec::new(),
            polygons: Vec::new(),
            groups: Vec::new(),
            bodies: vec![MeshBody { number: None, name: None }],
            bodies_from: BodiesFrom::File,
            point_elements: 0,
            collapsed_facets: 0,
            second_order: 0,
            cohesive_elements: 0,
            cohesive_facets: 0,
            unused: Vec::new(),
        }
    }

    /// Adds a polygon of three or more corners.
    pub(crate) fn push_polygon(
        &mut self,
        nodes: Vec<i64>,
        (number, place, body): (u64, Place, u32),
    ) -> Result<(), MeshProblem> {
        let shape = Shape::polygon(nodes.len(), number)?;
        let first = if shape == Shape::Polygon {
            self.polygons.push(nodes);
            corners(&[self.polygons.len() as i64 - 1])
        } else {
            corners(&nodes)
        };
        self.elements.push(Raw { shape, place, number, body, nodes: first });
        Ok(())
    }

    /// Adds a point, or reports which coordinate is not finite.
    pub(crate) fn push_point(&mut self, point: [f64; 3], place: Place, node: i64) -> Result<(), Fault> {
        check_finite(point, node).map_err(|problem| (place, problem))?;
        self.points.push(point);
        Ok(())
    }

    pub(crate) fn finish(self, format: MeshFormat) -> Result<MeshFile, Fault> {
        if u32::try_from(self.points.len()).is_err() {
            return Err((Place::File, MeshProblem::TooManyNodes));
        }
        let lookup = Lookup::new(self.numbering, self.points.len(), &self.places)?;
        let mut mesh = MeshFile {
            points: self.points,
            dimensions: 3,
            segments: Cells::new(),
            triangles: Cells::new(),
            tetrahedra: Cells::new(),
            bodies: Vec::new(),
            groups: Vec::new(),
            source: MeshSource {
                format,
                bodies_from: self.bodies_from,
                point_elements: self.point_elements,
                collapsed_facets: self.collapsed_facets,
                quadrilaterals: 0,
                polygons: 0,
                cut_solids: 0,
                second_order: self.second_order,
                cohesive_elements: self.cohesive_elements,
                cohesive_facets: self.cohesive_facets,
                unused: self.unused,
            },
        };
        let mut renumbered = vec![u32::MAX; self.bodies.len()];
        // For each element, the first of its cells; only needed by groups.
        let mut starts: Vec<[u32; 3]> = Vec::new();
        for raw in &self.elements {
            if !self.groups.is_empty() {
                starts.push(mesh.lengths());
            }
            let corners = match raw.shape {
                Shape::Polygon => &self.polygons[raw.nodes[0] as usize],
                shape => &raw.nodes[..shape.nodes()],
            };
            let nodes = lookup.nodes(raw, corners).map_err(|problem| (raw.place, problem))?;
            if raw.shape == Shape::Point {
                mesh.source.point_elements += 1;
                continue;
            }
            let body = &mut renumbered[raw.body as usize];
            if *body == u32::MAX {
                *body = mesh.bodies.len() as u32;
                mesh.bodies.push(self.bodies[raw.body as usize].clone());
            }
            mesh.push(raw, &nodes, *body).map_err(|problem| (raw.place, problem))?;
        }
        starts.push(mesh.lengths());
        for group in self.groups {
            let group =
                group.finish(&self.elements, &starts, &lookup).map_err(|problem| (Place::File, problem))?;
            mesh.groups.push(group);
        }
        if mesh.bodies.is_empty() {
            return Err((Place::File, MeshProblem::NoElements { format, points: mesh.points.len() as u64 }));
        }
        if mesh.tetrahedra.is_empty() && mesh.points.iter().all(|point| point[2] == 0.0) {
            mesh.dimensions = 2;
        }
        Ok(mesh)
    }
}

pub(crate) fn check_finite(point: [f64; 3], node: i64) -> Result<(), MeshProblem> {
    match point.iter().zip("xyz".chars()).find(|(value, _)| !value.is_finite()) {
        Some((_, axis)) => Err(MeshProblem::NotFinite { node, axis }),
        None => Ok(()),
    }
}

impl MeshFile {
    /// Numbers of segments, triangles and tetrahedra.
    fn lengths(&self) -> [u32; 3] {
        [self.segments.len(), self.triangles.len(), self.tetrahedra.len()].map(|length| length as u32)
    }

    fn push(&mut self, raw: &Raw, nodes: &[u32], body: u32) -> Result<(), MeshProblem> {
        let number = raw.number;
        let folded = || MeshProblem::FoldedElement { element: number, kind: raw.shape.name() };
        match (raw.shape, nodes) {
            (Shape::Segment, &[a, b]) => self.segments.push([a, b], body, number),
            (Shape::Triangle, &[a, b, c]) => self.triangles.push([a, b, c], body, number),
            (Shape::Tetrahedron, &[a, b, c, d]) => self.tetrahedra.push([a, b, c, d], body, number),
            (Shape::Quadrilateral, &[a, b, c, d]) => {
                let corners = [a, b, c, d];
                let halves = cut::quadrilateral(corners, &self.points).ok_or_else(|| {
                    let fold = cut::fold(corners, &self.points);
                    fold.map_or_else(folded, |degrees| MeshProblem::FoldedQuadrilateral {
                        element: number,
                        degrees,
                    })
                })?;
                self.source.quadrilaterals += 1;
                for half in halves {
                    self.triangles.push(half, body, number);
                }
            }
            (Shape::Polygon, _) => {
                let parts = cut::polygon(nodes, &self.points).ok_or_else(folded)?;
                self.source.polygons += 1;
                for part in parts {
                    self.triangles.push(part, body, number);
                }
            }
            _ => {
                let parts = cut::tetrahedra(raw.shape, nodes, &self.points).ok_or_else(folded)?;
                self.source.cut_solids += 1;
                for part in parts {
                    self.tetrahedra.push(part, body, number);
                }
            }
        }
        Ok(())
    }
}

impl DraftGroup {
    /// The group in cells and facets. `starts`: for each element, and at the end, the numbers of cells
    /// before.
    fn finish(
        self,
        elements: &[Raw],
        starts: &[[u32; 3]],
        lookup: &Lookup,
    ) -> Result<MeshGroup, MeshProblem> {
        let MeshBody { number, name } = self.body;
        let mut group = MeshGroup { number, name, nodes: self.nodes, ..MeshGroup::default() };
        for element in self.elements {
            let [from, to] = [starts[element as usize], starts[element as usize + 1]];
            group.segments.extend(from[0]..to[0]);
            group.triangles.extend(from[1]..to[1]);
            group.tetrahedra.extend(from[2]..to[2]);
        }
        for (element, face) in self.facets {
            let raw = &elements[element as usize];
            let nodes = lookup.nodes(raw, &raw.nodes[..raw.shape.nodes()])?;
            let face: Vec<u32> = raw.shape.faces()[face].iter().map(|&at| nodes[at]).collect();
            match face[..] {
                [a, b] => group.edges.push([a, b]),
                _ => group.faces.extend(cut::halves(&face)),
            }
        }
        Ok(group)
    }
}

impl<const N: usize> Cells<N> {
    fn new() -> Self {
        Self { nodes: Vec::new(), bodies: Vec::new(), numbers: Vec::new() }
    }

    fn push(&mut self, nodes: [u32; N], body: u32, number: u64) {
        self.nodes.push(nodes);
        self.bodies.push(body);
        self.numbers.push(number);
    }
}

/// Finds the index of a node from its number.
pub(crate) enum Lookup {
    /// The number is the index plus this offset; below, the number of nodes.
    From(i64, usize),
    /// Pairs of number and index, sorted by number.
    Sorted(Vec<(i64, u32)>),
}

impl Lookup {
    pub(crate) fn new(numbering: Numbering, points: usize, places: &[Place]) -> Result<Self, Fault> {
        let numbers = match numbering {
            Numbering::From(first) => return Ok(Self::From(first, points)),
            Numbering::Own(numbers) => numbers,
        };
        let consecutive = numbers.windows(2).all(|pair| pair[0].checked_add(1) == Some(pair[1]));
        if let (true, Some(&first)) = (consecutive, numbers.first()) {
            return Ok(Self::From(first, points));
        }
        let mut sorted: Vec<(i64, u32)> = numbers.into_iter().zip(0..).collect();
        sorted.sort_unstable();
        match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => {
                let place = places.get(pair[1].1 as usize).copied().unwrap_or(Place::File);
                Err((place, MeshProblem::RepeatedNumber { node: pair[0].0 }))
            }
            None => Ok(Self::Sorted(sorted)),
        }
    }

    pub(crate) fn index(&self, number: i64) -> Option<u32> {
        match self {
            Self::From(first, points) => {
                let index = usize::try_from(number.checked_sub(*first)?).ok()?;
                (index < *points).then_some(index as u32)
            }
            Self::Sorted(sorted) => {
                let at = sorted.binary_search_by_key(&number, |&(known, _)| known).ok()?;
                Some(sorted[at].1)
            }
        }
    }

    /// The indices of the corners of an element.
    pub(crate) fn nodes(&self, raw: &Raw, corners: &[i64]) -> Result<Vec<u32>, MeshProblem> {
        let (element, kind) = (raw.number, raw.shape.name());
        let mut nodes = Vec::with_capacity(corners.len());
        for &node in corners {
            let index = self.index(node).ok_or(MeshProblem::UnknownNode { element, kind, node })?;
            if nodes.contains(&index) {
                return Err(MeshProblem::RepeatedNode { element, kind, node });
            }
            nodes.push(index);
        }
        Ok(nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_gaps_and_without() {
        for (numbers, found, lost) in [
            (vec![5, 6, 7], vec![(5, 0), (7, 2)], vec![4, 8, i64::MIN, i64::MAX]),
            (vec![9, -3, 4], vec![(9, 0), (-3, 1), (4, 2)], vec![0, 5, i64::MIN]),
        ] {
            let lookup =
                Lookup::new(Numbering::Own(numbers), 3, &[]).unwrap_or_else(|_| panic!("no repeats"));
            for (number, index) in found {
                assert_eq!(lookup.index(number), Some(index));
            }
            for number in lost {
                assert_eq!(lookup.index(number), None);
            }
        }
        let twice = Lookup::new(Numbering::Own(vec![1, 2, 1]), 3, &[]).err();
        assert_eq!(twice, Some((Place::File, MeshProblem::RepeatedNumber { node: 1 })));
    }
}
