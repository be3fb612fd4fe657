//! Shapes of elements: their corners, names and faces.

use crate::mesh::error::{MeshProblem, unsupported};

/// Most corners of a polygon: the time to cut one grows with their square.
const CORNERS: usize = 1000;

/// Shape of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Point,
    Segment,
    Triangle,
    Quadrilateral,
    /// More than four corners. They are in [`Draft::polygons`](crate::mesh::build::Draft), at the index that
    /// stands in place of the first node.
    Polygon,
    Tetrahedron,
    Pyramid,
    Wedge,
    Hexahedron,
}

impl Shape {
    /// Number of corners; 0 for polygons, which have their own.
    pub(crate) fn nodes(self) -> usize {
        match self {
            Self::Polygon => 0,
            Self::Point => 1,
            Self::Segment => 2,
            Self::Triangle => 3,
            Self::Quadrilateral | Self::Tetrahedron => 4,
            Self::Pyramid => 5,
            Self::Wedge => 6,
            Self::Hexahedron => 8,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Segment => "segment",
            Self::Triangle => "triangle",
            Self::Quadrilateral => "quadrilateral",
            Self::Polygon => "polygon",
            Self::Tetrahedron => "tetrahedron",
            Self::Pyramid => "pyramid",
            Self::Wedge => "wedge",
            Self::Hexahedron => "hexahedron",
        }
    }

    /// The polygon with this number of corners.
    pub(crate) fn polygon(corners: usize, element: u64) -> Result<Self, MeshProblem> {
        match corners {
            3 => Ok(Self::Triangle),
            4 => Ok(Self::Quadrilateral),
            5..=CORNERS => Ok(Self::Polygon),
            _ => Err(refused(element, &format!("a polygon of {corners} corners"))),
        }
    }

    /// The edges of a flat shape, or the faces of a solid one, by their corners: in the order of Abaqus,
    /// where they are S1, S2, …. The normals of faces point inward.
    pub(crate) fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Point | Self::Segment | Self::Polygon => &[],
            Self::Triangle => &[&[0, 1], &[1, 2], &[2, 0]],
            Self::Quadrilateral => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
            Self::Tetrahedron => &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]],
            Self::Pyramid => &[&[0, 1, 2, 3], &[0, 4, 1], &[1, 4, 2], &[2, 4, 3], &[3, 4, 0]],
            Self::Wedge => &[&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]],
            Self::Hexahedron => {
                &[&[0, 1, 2, 3], &[4, 7, 6, 5], &[0, 4, 5, 1], &[1, 5, 6, 2], &[2, 6, 7, 3], &[3, 7, 4, 0]]
            }
        }
    }
}

/// The fault for an element of an unsupported shape.
pub(crate) fn refused(element: u64, what: &str) -> MeshProblem {
    unsupported(
        format!("element {element} is {what}"),
        "segments, polygons of 3 to 1000 corners, tetrahedra, pyramids, wedges and hexahedra of first and second order are read",
    )
}
