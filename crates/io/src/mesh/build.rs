//! Makes a mesh from the data of a reader: node numbers become indices, quadrilaterals become triangles, and
//! bodies are counted.

use crate::mesh::error::{Fault, MeshProblem, unsupported};
use crate::mesh::file::{BodiesFrom, Cells, MeshBody, MeshFile, MeshSource};
use crate::mesh::format::MeshFormat;
use crate::place::Place;

/// Shape of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Point,
    Segment,
    Triangle,
    Quadrilateral,
    Tetrahedron,
}

impl Shape {
    pub(crate) fn nodes(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Segment => 2,
            Self::Triangle => 3,
            Self::Quadrilateral | Self::Tetrahedron => 4,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Segment => "segment",
            Self::Triangle => "triangle",
            Self::Quadrilateral => "quadrilateral",
            Self::Tetrahedron => "tetrahedron",
        }
    }

    /// The polygon with this number of corners.
    pub(crate) fn polygon(corners: usize, element: u64) -> Result<Self, MeshProblem> {
        match corners {
            3 => Ok(Self::Triangle),
            4 => Ok(Self::Quadrilateral),
            _ => Err(refused(element, &format!("a polygon of {corners} corners"))),
        }
    }
}

/// The fault for an element of an unsupported shape.
pub(crate) fn refused(element: u64, what: &str) -> MeshProblem {
    unsupported(
        format!("element {element} is {what}"),
        "segments, triangles, quadrilaterals and tetrahedra of corner nodes are read",
    )
}

/// An element in the numbering of the file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raw {
    pub(crate) shape: Shape,
    pub(crate) place: Place,
    pub(crate) number: u64,
    /// Index into [`Draft::bodies`].
    pub(crate) body: u32,
    /// The nodes that the shape has, with the numbers of the file.
    pub(crate) nodes: [i64; 4],
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
    pub(crate) bodies: Vec<MeshBody>,
    pub(crate) bodies_from: BodiesFrom,
    /// Number of elements of one node that the reader did not collect.
    pub(crate) point_elements: u64,
    pub(crate) collapsed_facets: u64,
}

impl Draft {
    /// An empty draft with one body.
    pub(crate) fn new(numbering: Numbering) -> Self {
        Self {
            points: Vec::new(),
            numbering,
            places: Vec::new(),
            elements: Vec::new(),
            bodies: vec![MeshBody { number: None, name: None }],
            bodies_from: BodiesFrom::File,
            point_elements: 0,
            collapsed_facets: 0,
        }
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
            source: MeshSource {
                format,
                bodies_from: self.bodies_from,
                point_elements: self.point_elements,
                collapsed_facets: self.collapsed_facets,
                quadrilaterals: 0,
            },
        };
        let mut renumbered = vec![u32::MAX; self.bodies.len()];
        for raw in &self.elements {
            let nodes = lookup.nodes(raw).map_err(|problem| (raw.place, problem))?;
            if raw.shape == Shape::Point {
                mesh.source.point_elements += 1;
                continue;
            }
            let body = &mut renumbered[raw.body as usize];
            if *body == u32::MAX {
                *body = mesh.bodies.len() as u32;
                mesh.bodies.push(self.bodies[raw.body as usize].clone());
            }
            mesh.push(raw, nodes, *body).map_err(|problem| (raw.place, problem))?;
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
    fn push(&mut self, raw: &Raw, nodes: [u32; 4], body: u32) -> Result<(), MeshProblem> {
        let [a, b, c, _] = nodes;
        match raw.shape {
            Shape::Point => {}
            Shape::Segment => self.segments.push([a, b], body, raw.number),
            Shape::Triangle => self.triangles.push([a, b, c], body, raw.number),
            Shape::Tetrahedron => self.tetrahedra.push(nodes, body, raw.number),
            Shape::Quadrilateral => {
                let halves = split(nodes.map(|node| self.points[node as usize]));
                let halves = halves.ok_or(MeshProblem::FoldedQuadrilateral { element: raw.number })?;
                self.source.quadrilaterals += 1;
                for half in halves {
                    self.triangles.push(half.map(|corner| nodes[corner]), body, raw.number);
                }
            }
        }
        Ok(())
    }
}

/// The corners of two triangles that form a quadrilateral and have the same orientation; `None` if neither
/// diagonal gives such triangles.
///
/// In a plane, both have the same orientation exactly if the diagonal is inside.
fn split(corners: [[f64; 3]; 4]) -> Option<[[usize; 3]; 2]> {
    // Scaled, so that products neither overflow nor underflow: the orientation of a triangle does not depend
    // on its size.
    let mut low = corners[0];
    let mut high = corners[0];
    for corner in corners {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let size = (0..3).map(|axis| high[axis] / 2.0 - low[axis] / 2.0).fold(0.0, f64::max);
    let scaled = corners.map(|corner| [0, 1, 2].map(|axis| (corner[axis] / 2.0 - low[axis] / 2.0) / size));
    let area = |[a, b, c]: [usize; 3]| {
        let edge = |to: usize| [0, 1, 2].map(|axis| scaled[to][axis] - scaled[a][axis]);
        let (p, q) = (edge(b), edge(c));
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    [[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]].into_iter().find(|[first, second]| {
        let (p, q) = (area(*first), area(*second));
        (0..3).map(|axis| p[axis] * q[axis]).sum::<f64>() > 0.0
    })
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

    fn index(&self, number: i64) -> Option<u32> {
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

    pub(crate) fn nodes(&self, raw: &Raw) -> Result<[u32; 4], MeshProblem> {
        let (element, kind) = (raw.number, raw.shape.name());
        let mut nodes = [0; 4];
        for place in 0..raw.shape.nodes() {
            let node = raw.nodes[place];
            nodes[place] = self.index(node).ok_or(MeshProblem::UnknownNode { element, kind, node })?;
            if nodes[..place].contains(&nodes[place]) {
                return Err(MeshProblem::RepeatedNode { element, kind, node });
            }
        }
        Ok(nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrilaterals_are_split_along_a_diagonal_inside() {
        let flat = |corners: [[f64; 2]; 4]| split(corners.map(|[x, y]| [x, y, 0.0]));
        let (first, second) = (Some([[0, 1, 2], [0, 2, 3]]), Some([[1, 2, 3], [1, 3, 0]]));
        assert_eq!(flat([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), first);
        // A dart with its tip at the first corner, then at the second.
        assert_eq!(flat([[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]]), first);
        assert_eq!(flat([[2.0, 1.0], [0.0, 0.0], [2.0, -1.0], [1.0, 0.0]]), second);
        // A bow tie, and corners on a line.
        assert_eq!(flat([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), None);
        assert_eq!(flat([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]), None);
        assert_eq!(flat([[7.0, 7.0]; 4]), None);
        for size in [1e-300, 1e300] {
            assert_eq!(flat([[-size, -size], [size, -size], [size, size], [-size, size]]), first, "{size}");
        }
    }

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
