//! The numbers of one column of a file.

use crate::row::whole;

/// The values of one column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ColumnValues {
    Whole(Vec<i64>),
    Real(Vec<f64>),
}

impl ColumnValues {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Whole(values) => values.len(),
            Self::Real(values) => values.len(),
        }
    }

    pub(crate) fn real(&self, row: usize) -> f64 {
        match self {
            Self::Whole(values) => values[row] as f64,
            Self::Real(values) => values[row],
        }
    }

    /// An id or a body.
    pub(crate) fn whole(&self, row: usize) -> Option<i64> {
        match self {
            Self::Whole(values) => Some(values[row]),
            Self::Real(values) => whole(values[row]),
        }
    }
}
