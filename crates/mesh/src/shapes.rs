//! Surfaces of shapes in space, ready to be meshed.
//!
//! Shapes with flat faces need no size: their faces are meshed by
//! [`tetrahedra`](crate::tetrahedra::tetrahedra). Curved faces are given as triangles as large as the mesh is
//! to have them. In names of faces, x runs from left to right, y from front to back, z from bottom to top.

mod cuboid;
mod extrusion;
mod grains;
mod grains_of_sphere;
mod hull;
mod prism;
mod round;
mod soup;

pub use cuboid::cuboid;
pub use extrusion::extrusion;
pub use grains::grains;
pub use grains_of_sphere::{grains_of_sphere, onto_sphere};
pub use hull::hull;
pub use prism::Prism;
pub use round::{cylinder, sphere, tube};
