//! VTK files without cells: points and their data.

use crate::mesh::error::Fault;
use crate::mesh::{vtk, vtk_xml};
use crate::series::values::Values;

/// Points, and their data of one component.
#[derive(Debug, Default)]
pub(crate) struct PointCloud {
    /// Arbitrary numbers, including infinite ones.
    pub(crate) points: Vec<[f64; 3]>,
    /// Arrays with their names, in the order of the file.
    pub(crate) arrays: Vec<(String, Values)>,
    pub(crate) step: Option<i64>,
    pub(crate) time: Option<f64>,
}

impl PointCloud {
    /// Appends values to those of the same name.
    pub(crate) fn push(&mut self, name: &str, values: Values) {
        let Some((_, known)) = self.arrays.iter_mut().find(|(known, _)| known == name) else {
            self.arrays.push((name.to_owned(), values));
            return;
        };
        match (known, values) {
            (Values::Whole(known), Values::Whole(more)) => known.extend(more),
            (Values::Real(known), Values::Real(more)) => known.extend(more),
            (Values::Real(known), Values::Whole(more)) => {
                known.extend(more.into_iter().map(|value| value as f64));
            }
            (known @ Values::Whole(_), Values::Real(more)) => {
                let Values::Whole(whole) = &*known else { return };
                let whole = whole.iter().map(|&value| value as f64);
                *known = Values::Real(whole.chain(more).collect());
            }
        }
    }

    /// Takes the time or the step if this is the name of such field data.
    pub(crate) fn note(&mut self, name: &str, value: f64) {
        match name {
            "TimeValue" | "TIME" if value.is_finite() => self.time = Some(value),
            "CYCLE" => self.step = crate::row::whole(value),
            _ => {}
        }
    }
}

/// Whether field data of this name are used.
pub(crate) fn is_time(name: &str) -> bool {
    matches!(name, "TimeValue" | "TIME" | "CYCLE")
}

/// Whether a legacy file has cells other than vertices. False for a damaged file; the reader of points will
/// report the error.
pub(crate) fn is_mesh(bytes: &[u8]) -> bool {
    vtk::has_cells(bytes).unwrap_or(false)
}

/// The same for a VTU or VTP file.
pub(crate) fn is_xml_mesh(bytes: &[u8]) -> bool {
    vtk_xml::has_cells(bytes).unwrap_or(false)
}

/// The points of a legacy file.
pub(crate) fn points(bytes: &[u8]) -> Result<PointCloud, Fault> {
    vtk::points(bytes)
}

/// The points of a VTU or VTP file.
pub(crate) fn xml_points(bytes: &[u8]) -> Result<PointCloud, Fault> {
    vtk_xml::points(bytes)
}
