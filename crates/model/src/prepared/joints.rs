//! The joints of a set in the mesh.

use std::fmt;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::tetrahedra::SNAP;
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
    /// Number of polygons of the set in the bodies, and of those that are left out, because they are so near
    /// to a face or to another polygon that they are moved onto it; in three dimensions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polygons: Option<[usize; 2]>,
    /// Whether the joints are open from the start, so that they are no cracks of the run.
    pub open: bool,
}

/// The joints that are open from the start, in words: their number, and their length or area. `None` if there
/// are none.
pub fn open_from_start(sets: &[Joints]) -> Option<String> {
    let open = || sets.iter().filter(|set| set.open && set.facets > 0);
    open().next()?;
    let count: usize = open().map(|set| set.facets).sum();
    let areas: Vec<f64> = open().filter_map(|set| set.area).collect();
    let lengths: f64 = open().filter_map(|set| set.length).sum();
    let measure = if areas.is_empty() {
        format!("{} m", brief(lengths))
    } else {
        format!("{} m²", brief(areas.iter().sum()))
    };
    let plural = if count == 1 { "" } else { "s" };
    Some(format!("{} joint{plural} open from the start, {measure}", grouped(count as u64)))
}

impl fmt::Display for Joints {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, joints, facets, length, area, polygons, open } = self;
        let [joints, facets] = [*joints, *facets].map(|count| grouped(count as u64));
        match (length, area) {
            (_, Some(area)) => {
                write!(out, "{name}: {joints}, {} m² together, on {facets} faces", brief(*area))?;
            }
            (length, None) => {
                let length = brief(length.unwrap_or(0.0));
                write!(out, "{name}: {joints}, {length} m long together, along {facets} edges")?;
            }
        }
        if *open {
            out.write_str(", open from the start")?;
        }
        match polygons {
            Some([count, left_out]) if *left_out > 0 => write!(
                out,
                "; {} of {} polygons {} left out: nearer than {SNAP} of mesh_size to a face or another polygon",
                grouped(*left_out as u64),
                grouped(*count as u64),
                if *left_out == 1 { "is" } else { "are" }
            ),
            _ => Ok(()),
        }
    }
}
