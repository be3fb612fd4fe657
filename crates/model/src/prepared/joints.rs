//! The joints of a set in the mesh.

use std::fmt;

use fdem_io::numbers::{brief, grouped};
use serde::Serialize;

/// The joints of a set in the mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Joints {
    /// Name of the set.
    pub name: String,
    /// Number of joints in the bodies.
    pub joints: usize,
    /// Number of edges of elements on them, or of faces in three dimensions.
    pub facets: usize,
    /// Length of the joints, m; in two dimensions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Area of the joints, m²; in three dimensions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
}

impl fmt::Display for Joints {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, joints, facets, length, area } = self;
        let [joints, facets] = [*joints, *facets].map(|count| grouped(count as u64));
        match (length, area) {
            (_, Some(area)) => {
                write!(out, "{name}: {joints}, {} m² together, on {facets} faces", brief(*area))
            }
            (length, None) => {
                let length = brief(length.unwrap_or(0.0));
                write!(out, "{name}: {joints}, {length} m long together, along {facets} edges")
            }
        }
    }
}
