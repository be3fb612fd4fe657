//! Errors, and the exceptions that they become.

use fdem_contact::Error;
use fdem_contact::discretised::DiscretisedError;
use pyo3::PyErr;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};

/// The reason why there is no result.
#[derive(Debug)]
pub(crate) enum Problem {
    /// Refused by a search.
    Search(Error),
    /// Refused by a search over meshes.
    Mesh(DiscretisedError),
    /// Arguments that do not fit each other.
    Arguments(String),
    /// An error that is not the fault of the arguments.
    System(String),
}

impl Problem {
    /// The error for memory that lacks room for `len` values.
    pub(crate) fn out_of_memory<V>(len: usize) -> Self {
        Error::OutOfMemory { bytes: len.saturating_mul(size_of::<V>()) }.into()
    }
}

impl From<Error> for Problem {
    fn from(error: Error) -> Self {
        Self::Search(error)
    }
}

impl From<DiscretisedError> for Problem {
    fn from(error: DiscretisedError) -> Self {
        match error {
            DiscretisedError::Search(error) => Self::Search(error),
            error => Self::Mesh(error),
        }
    }
}

impl From<Problem> for PyErr {
    fn from(problem: Problem) -> Self {
        match problem {
            Problem::Search(error @ Error::OutOfMemory { .. }) => PyMemoryError::new_err(error.to_string()),
            Problem::Search(error @ (Error::Stopped | Error::Device { .. })) => {
                PyRuntimeError::new_err(error.to_string())
            }
            Problem::Search(error) => PyValueError::new_err(error.to_string()),
            Problem::Mesh(error) => PyValueError::new_err(error.to_string()),
            Problem::Arguments(text) => PyValueError::new_err(text),
            Problem::System(text) => PyRuntimeError::new_err(text),
        }
    }
}

/// A vector of `len` zeros, or `MemoryError`.
pub(crate) fn zeros<V: Copy + Default>(len: usize) -> Result<Vec<V>, Problem> {
    let mut values = Vec::new();
    values.try_reserve_exact(len).map_err(|_| Problem::out_of_memory::<V>(len))?;
    values.resize(len, V::default());
    Ok(values)
}
