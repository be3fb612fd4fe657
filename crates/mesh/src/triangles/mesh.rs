//! A mesh of triangles.

use super::outline::Point;

/// A meshed domain.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangles {
    /// Coordinates `[n]`.
    pub nodes: Vec<Point>,
    /// Corners of the elements `[m]`, counter-clockwise.
    pub elements: Vec<[u32; 3]>,
    /// The loop of each node `[n]`, or [`INSIDE`](crate::triangles::INSIDE).
    pub loops: Vec<u32>,
    /// Edges along the lines of the domain.
    pub lines: Vec<[u32; 2]>,
    /// For each of these edges the number of its line in the domain.
    pub line_of: Vec<u32>,
}
