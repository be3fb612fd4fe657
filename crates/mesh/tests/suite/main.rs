//! Tests of the meshers from outside, in one program.
//!
//! - `coarsen`: surfaces with fewer facets.
//! - `triangles`: meshes of outlines; `network`: meshes whose edges follow lines.
//! - `tetrahedra`: meshes of surfaces; `polygons`: meshes whose facets follow polygons.

mod coarsen;
mod network;
mod polygons;
mod tetrahedra;
mod triangles;
