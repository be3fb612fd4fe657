//! Bodies of triangles and tetrahedra: meshes, shapes, and how shapes are meshed.
//!
//! There is no file and no physics in this crate. Lengths are in the unit of the caller.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | a shape, and its surface | `src/shapes.rs`, then the shape in `src/shapes` |
//! | lines inside of triangles' domains: joints | `src/triangles/network.rs` |
//! | polygons inside of bodies in space: joints | `src/tetrahedra/polygons.rs`, then its parts in `src/tetrahedra/polygons` |
//! | the mesher of tetrahedra | `src/tetrahedra.rs`, then its parts in `src/tetrahedra` |
//! | surfaces with fewer facets | `src/coarsen.rs` |
//! | the order of elements in memory | `src/curve.rs` |
//! | angles, measures and facets of triangles and tetrahedra | `src/corners.rs` |

pub mod curve;
mod grading;
mod mesh;
mod quality;
mod corners;
pub mod shapes;
pub mod tetrahedra;
pub mod triangles;
mod coarsen;

pub use coarsen::Coarsened;
pub use corners::{Corners, facets_of, sorted, sorted_facets};
pub use grading::{Grading, Place, Refinement};
pub use mesh::{MOST_ELEMENTS, Mesh, bounds};
pub use quality::{Quality, edges};
