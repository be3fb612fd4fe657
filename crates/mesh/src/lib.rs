//! Bodies of triangles and tetrahedra: meshes, shapes, and how shapes are meshed.
//!
//! There is no file and no physics in this crate. Lengths are in whatever unit the caller has.

mod grading;
mod mesh;
mod quality;
mod simplex;
pub mod shapes;
pub mod tetrahedra;
pub mod triangles;

pub use grading::{Grading, Place, Refinement};
pub use mesh::{Mesh, bounds};
pub use quality::{Quality, edges};
pub use simplex::{Simplex, facets_of, sorted};
