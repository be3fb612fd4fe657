//! Tests of the meshers from outside, in one program.
//!
//! - `triangles`: meshes of outlines; `network`: meshes whose edges follow lines.
//! - `tetrahedra`: meshes of surfaces; `polygons`: meshes whose facets follow polygons.

mod network;
mod polygons;
mod tetrahedra;
mod triangles;
