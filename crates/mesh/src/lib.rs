//! Bodies of triangles and tetrahedra: meshes, shapes, and how shapes are meshed.
//!
//! There is no file and no physics in this crate. Lengths are in whatever unit the caller has.

mod mesh;
mod simplex;
pub mod shapes;
pub mod tetrahedra;

pub use mesh::Mesh;
pub use simplex::Simplex;
