//! The table of fields, and the values of its fields now.

use fdem::results::{Place, QUANTITIES, Quantity, QuantityValues, Span};
use fdem::session::AnySession;
use fdem::simulation::Forces;
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The rows of the table of fields, as dictionaries.
#[pyfunction]
pub(crate) fn fields(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    QUANTITIES.iter().map(|quantity| row(py, quantity)).collect()
}

fn row<'py>(py: Python<'py>, quantity: &Quantity) -> PyResult<Bound<'py, PyDict>> {
    let span = match quantity.span {
        Span::NotNegative => (0.0, f64::INFINITY),
        Span::Between(low, high) => (low, high),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    };
    let dict = PyDict::new(py);
    dict.set_item("key", quantity.key)?;
    dict.set_item("name", quantity.name)?;
    dict.set_item("about", quantity.about)?;
    dict.set_item("definition", quantity.definition)?;
    dict.set_item("unit", quantity.unit)?;
    dict.set_item("sign", quantity.sign)?;
    dict.set_item("span", span)?;
    dict.set_item("at", quantity.place.word())?;
    dict.set_item("components", quantity.components)?;
    dict.set_item("dimensions", quantity.dimensions)?;
    dict.set_item("drawn", quantity.is_drawn())?;
    Ok(dict)
}

/// Returns the values of a field now: an array with a row for each node, element, joint or contact. `at`: one
/// of these words; `None`: the first in the table.
pub(crate) fn values<'py>(
    py: Python<'py>,
    session: &AnySession,
    key: &str,
    at: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let dimensions = match session {
        AnySession::Plane(_) => 2,
        AnySession::Space(_) => 3,
    };
    let there = || {
        QUANTITIES
            .iter()
            .filter(|row| row.exists_in(dimensions) && at.is_none_or(|at| at == row.place.word()))
    };
    let Some(quantity) = there().find(|row| row.key == key) else {
        let keys: Vec<&str> = there().map(|row| row.key).collect();
        let of = at.map_or_else(String::new, |at| format!(" at \"{at}\""));
        return Err(PyValueError::new_err(format!("there is no field '{key}'{of}: {}", keys.join(", "))));
    };
    // Forces of contacts take as long as a step.
    let with_forces = matches!(quantity.place, Place::Node | Place::Contact);
    let found = py.detach(|| match session {
        AnySession::Plane(session) => {
            let forces = if with_forces { session.run().forces() } else { Forces::default() };
            quantity.values_of(&session.snapshot(), &forces)
        }
        AnySession::Space(session) => {
            let forces = if with_forces { session.run().forces() } else { Forces::default() };
            quantity.values_of(&session.snapshot(), &forces)
        }
    });
    match found.map_err(|error| PyValueError::new_err(error.to_string()))? {
        QuantityValues::Real(values) => shaped(py, values, quantity),
        QuantityValues::Whole(values) => shaped(py, values, quantity),
        _ => Err(PyValueError::new_err(format!("'{key}' has values that NumPy cannot hold"))),
    }
}

/// Returns numbers as an array of NumPy, of rows where the quantity has components. Nothing is copied.
fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    quantity: &Quantity,
) -> PyResult<Bound<'py, PyAny>> {
    if quantity.components.is_empty() {
        return Ok(values.into_pyarray(py).into_any());
    }
    let shape = [values.len() / quantity.width(), quantity.width()];
    Ok(values.into_pyarray(py).reshape(shape)?.into_any())
}
