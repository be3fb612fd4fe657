//! Joint sets: lines and planes that a mesh follows, and bonds between bodies.

pub(crate) mod dxf;
pub(crate) mod geojson;
pub(crate) mod shape_file;
pub(crate) mod polylines;
pub(crate) mod polygons;
pub(crate) mod off_body;
pub(crate) mod lines;
pub(crate) mod planes;
pub(crate) mod sets;
pub(crate) mod bonds;
