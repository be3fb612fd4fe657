//! The types of coordinates, and the choice among them.

use bytemuck::Pod;
use fdem_contact::Real;
use numpy::{Element, IntoPyArray, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// A coordinate type that NumPy has too.
pub(crate) trait Number: Real + Element + Default + Pod {
    fn sqrt(self) -> Self;
}

impl Number for f32 {
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Number for f64 {
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// The type and the dimension of an array of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberKind {
    Single2,
    Single3,
    Double2,
    Double3,
}

impl NumberKind {
    /// The kind of an array `[n, D]`.
    pub(crate) fn of(points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (double, columns) = if let Ok(points) = points.extract::<PyReadonlyArray2<'_, f64>>() {
            (true, points.as_array().ncols())
        } else if let Ok(points) = points.extract::<PyReadonlyArray2<'_, f32>>() {
            (false, points.as_array().ncols())
        } else {
            return Err(PyTypeError::new_err("points must be an array [n, D] of float32 or float64"));
        };
        match (double, columns) {
            (false, 2) => Ok(Self::Single2),
            (false, 3) => Ok(Self::Single3),
            (true, 2) => Ok(Self::Double2),
            (true, 3) => Ok(Self::Double3),
            _ => Err(PyValueError::new_err(format!("points have 2 or 3 coordinates, not {columns}"))),
        }
    }
}

/// Evaluates an expression with `T` and `D` standing for the type and the dimension that a [`NumberKind`]
/// names.
macro_rules! with_kind {
    ($kind:expr, $T:ident, $D:ident => $body:expr) => {
        match $kind {
            $crate::number::NumberKind::Single2 => {
                type $T = f32;
                const $D: usize = 2;
                $body
            }
            $crate::number::NumberKind::Single3 => {
                type $T = f32;
                const $D: usize = 3;
                $body
            }
            $crate::number::NumberKind::Double2 => {
                type $T = f64;
                const $D: usize = 2;
                $body
            }
            $crate::number::NumberKind::Double3 => {
                type $T = f64;
                const $D: usize = 3;
                $body
            }
        }
    };
}
pub(crate) use with_kind;

/// The rows of an array in C order.
pub(crate) fn rows_of<'a, V: Element, const D: usize>(
    array: &'a PyReadonlyArray2<'_, V>,
) -> PyResult<&'a [[V; D]]> {
    let columns = array.as_array().ncols();
    match (array.as_slice(), columns == D && array.as_array().is_standard_layout()) {
        (Ok(values), true) => Ok(values.as_chunks().0),
        _ => Err(PyValueError::new_err(format!(
            "an array must be aligned, in C order and of {D} columns; it has {columns}"
        ))),
    }
}

/// The entries of an array that is contiguous.
pub(crate) fn entries_of<'a, V: Element>(array: &'a PyReadonlyArray1<'_, V>) -> PyResult<&'a [V]> {
    array.as_slice().map_err(|_| PyValueError::new_err("an array must be aligned and contiguous"))
}

/// Returns an array of rows of NumPy. Nothing is copied.
pub(crate) fn array_of_rows<T: numpy::Element, const W: usize>(
    py: Python<'_>,
    rows: Vec<[T; W]>,
) -> PyResult<Bound<'_, PyAny>> {
    let count = rows.len();
    Ok(rows.into_flattened().into_pyarray(py).reshape([count, W])?.into_any())
}
