//! The order of the corners of a tetrahedron, of its edges and of its faces.

/// Corners of the faces, counter-clockwise seen from outside.
pub(super) const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// Corners of the edges.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
