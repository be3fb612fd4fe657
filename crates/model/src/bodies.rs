//! Meshes of bodies.

pub(crate) mod materials;
pub(crate) mod gmsh;
pub(crate) mod mesh_file;
pub(crate) mod plane;
pub(crate) mod space;
pub(crate) mod dimensions;
pub(crate) mod crowded;
pub(crate) mod sizes;
pub(crate) mod boxes;
pub(crate) mod build;
