//! VTK files without cells: points and their data.

use crate::column_values::ColumnValues;

/// Points, and their data of one component.
#[derive(Debug, Default)]
pub(crate) struct PointCloud {
    /// Arbitrary numbers, including infinite ones.
    pub(crate) points: Vec<[f64; 3]>,
    /// Arrays with their names, in the order of the file.
    pub(crate) arrays: Vec<(String, ColumnValues)>,
    pub(crate) step: Option<i64>,
    pub(crate) time: Option<f64>,
}

impl PointCloud {
    /// Appends values to those of the same name.
    pub(crate) fn push(&mut self, name: &str, values: ColumnValues) {
        let Some((_, known)) = self.arrays.iter_mut().find(|(known, _)| known == name) else {
            self.arrays.push((name.to_owned(), values));
            return;
        };
        match (known, values) {
            (ColumnValues::Whole(known), ColumnValues::Whole(more)) => known.extend(more),
            (ColumnValues::Real(known), ColumnValues::Real(more)) => known.extend(more),
            (ColumnValues::Real(known), ColumnValues::Whole(more)) => {
                known.extend(more.into_iter().map(|value| value as f64));
            }
            (known @ ColumnValues::Whole(_), ColumnValues::Real(more)) => {
                let ColumnValues::Whole(whole) = &*known else { return };
                let whole = whole.iter().map(|&value| value as f64);
                *known = ColumnValues::Real(whole.chain(more).collect());
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
