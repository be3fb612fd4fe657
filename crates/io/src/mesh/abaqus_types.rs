//! Types of elements of Abaqus.

use crate::mesh::shape::Shape;

/// An element type: its shape, and its number of nodes, of which the corners come first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AbaqusType {
    /// The shape; for cohesive elements that of each of the two sides.
    pub(crate) shape: Shape,
    pub(crate) nodes: usize,
    /// For cohesive elements, the node of the other side that belongs to each node of the first.
    pub(crate) opposite: Option<&'static [usize]>,
}

/// Families of element types, with their numbers of nodes.
const FAMILIES: [(&str, Shape, usize); 72] = [
    ("T2D2", Shape::Segment, 2),
    ("T3D2", Shape::Segment, 2),
    ("T2D3", Shape::Segment, 3),
    ("T3D3", Shape::Segment, 3),
    ("B21", Shape::Segment, 2),
    ("B31", Shape::Segment, 2),
    ("B23", Shape::Segment, 2),
    ("B33", Shape::Segment, 2),
    ("R2D2", Shape::Segment, 2),
    ("RAX2", Shape::Segment, 2),
    ("RB2D2", Shape::Segment, 2),
    ("RB3D2", Shape::Segment, 2),
    ("CPS3", Shape::Triangle, 3),
    ("CPE3", Shape::Triangle, 3),
    ("CPEG3", Shape::Triangle, 3),
    ("CAX3", Shape::Triangle, 3),
    ("DC2D3", Shape::Triangle, 3),
    ("AC2D3", Shape::Triangle, 3),
    ("S3", Shape::Triangle, 3),
    ("STRI3", Shape::Triangle, 3),
    ("R3D3", Shape::Triangle, 3),
    ("M3D3", Shape::Triangle, 3),
    ("SFM3D3", Shape::Triangle, 3),
    ("DS3", Shape::Triangle, 3),
    ("CPS6", Shape::Triangle, 6),
    ("CPE6", Shape::Triangle, 6),
    ("CPEG6", Shape::Triangle, 6),
    ("CAX6", Shape::Triangle, 6),
    ("DC2D6", Shape::Triangle, 6),
    ("AC2D6", Shape::Triangle, 6),
    ("STRI65", Shape::Triangle, 6),
    ("M3D6", Shape::Triangle, 6),
    ("SFM3D6", Shape::Triangle, 6),
    ("CPS4", Shape::Quadrilateral, 4),
    ("CPE4", Shape::Quadrilateral, 4),
    ("CPEG4", Shape::Quadrilateral, 4),
    ("CAX4", Shape::Quadrilateral, 4),
    ("DC2D4", Shape::Quadrilateral, 4),
    ("AC2D4", Shape::Quadrilateral, 4),
    ("S4", Shape::Quadrilateral, 4),
    ("R3D4", Shape::Quadrilateral, 4),
    ("M3D4", Shape::Quadrilateral, 4),
    ("SFM3D4", Shape::Quadrilateral, 4),
    ("DS4", Shape::Quadrilateral, 4),
    ("CPS8", Shape::Quadrilateral, 8),
    ("CPE8", Shape::Quadrilateral, 8),
    ("CPEG8", Shape::Quadrilateral, 8),
    ("CAX8", Shape::Quadrilateral, 8),
    ("DC2D8", Shape::Quadrilateral, 8),
    ("AC2D8", Shape::Quadrilateral, 8),
    ("S8", Shape::Quadrilateral, 8),
    ("M3D8", Shape::Quadrilateral, 8),
    ("C3D4", Shape::Tetrahedron, 4),
    ("DC3D4", Shape::Tetrahedron, 4),
    ("AC3D4", Shape::Tetrahedron, 4),
    ("C3D10", Shape::Tetrahedron, 10),
    ("DC3D10", Shape::Tetrahedron, 10),
    ("AC3D10", Shape::Tetrahedron, 10),
    ("C3D5", Shape::Pyramid, 5),
    ("AC3D5", Shape::Pyramid, 5),
    ("C3D6", Shape::Wedge, 6),
    ("DC3D6", Shape::Wedge, 6),
    ("AC3D6", Shape::Wedge, 6),
    ("C3D15", Shape::Wedge, 15),
    ("DC3D15", Shape::Wedge, 15),
    ("C3D8", Shape::Hexahedron, 8),
    ("DC3D8", Shape::Hexahedron, 8),
    ("AC3D8", Shape::Hexahedron, 8),
    ("C3D20", Shape::Hexahedron, 20),
    ("DC3D20", Shape::Hexahedron, 20),
    ("MASS", Shape::Point, 1),
    ("ROTARYI", Shape::Point, 1),
];

/// Families of cohesive elements: the shape of a side, and the nodes opposite to those of the first side.
const COHESIVE: [(&str, Shape, &[usize]); 4] = [
    ("COH2D4", Shape::Segment, &[3, 2]),
    ("COHAX4", Shape::Segment, &[3, 2]),
    ("COH3D6", Shape::Triangle, &[3, 4, 5]),
    ("COH3D8", Shape::Quadrilateral, &[4, 5, 6, 7]),
];

/// The element type of a name: a family, and letters for the formulation.
pub(crate) fn element_type(name: &str) -> Option<AbaqusType> {
    let is_of = |family: &str| {
        let formulation = name.strip_prefix(family);
        formulation.is_some_and(|letters| letters.bytes().all(|byte| byte.is_ascii_alphabetic()))
    };
    let solid = FAMILIES.iter().find(|(family, ..)| is_of(family));
    let solid = solid.map(|&(_, shape, nodes)| AbaqusType { shape, nodes, opposite: None });
    let cohesive = || COHESIVE.iter().find(|(family, ..)| is_of(family));
    solid.or_else(|| {
        cohesive().map(|&(_, shape, opposite)| AbaqusType {
            shape,
            nodes: 2 * opposite.len(),
            opposite: Some(opposite),
        })
    })
}
