//! Laws of spheres that Python computes.

use std::sync::{Arc, Mutex, PoisonError};

use fdem::simulation::grains::{SphereLaw, SpherePairs};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::number::{array_of_rows, rows_of};

/// The exception that a law has raised in the last step.
pub(crate) type Raised = Arc<Mutex<Option<PyErr>>>;

/// Returns the exception that a law has raised, if there is one.
pub(crate) fn taken(raised: &Raised) -> Option<PyErr> {
    raised.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Makes a law of a function. It gets a dictionary of arrays, and returns forces and moments; memory is
/// changed in its array.
pub(crate) fn law(function: Py<PyAny>, raised: Raised) -> SphereLaw {
    Box::new(move |pairs| {
        Python::attach(|py| call(py, &function, pairs)).map_err(|error| {
            let text = error.to_string();
            *raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            text
        })
    })
}

fn call(py: Python<'_>, function: &Py<PyAny>, pairs: &mut SpherePairs) -> PyResult<()> {
    let count = pairs.spheres.len();
    let dict = PyDict::new(py);
    dict.set_item("time", pairs.time)?;
    dict.set_item("step", pairs.step)?;
    dict.set_item("spheres", array_of_rows(py, pairs.spheres.clone())?)?;
    dict.set_item("materials", array_of_rows(py, pairs.materials.clone())?)?;
    dict.set_item("radii", array_of_rows(py, pairs.radii.clone())?)?;
    dict.set_item("masses", array_of_rows(py, pairs.masses.clone())?)?;
    dict.set_item("normals", array_of_rows(py, pairs.normals.clone())?)?;
    dict.set_item("overlaps", pairs.overlaps.clone().into_pyarray(py))?;
    dict.set_item("velocities", array_of_rows(py, pairs.velocities.clone())?)?;
    let spins = pairs.spins.concat().into_flattened().into_pyarray(py);
    dict.set_item("spins", spins.reshape([count, 2, 3])?)?;
    let columns = pairs.memory.len() / count.max(1);
    let memory: Bound<'_, PyArray1<f64>> = pairs.memory.clone().into_pyarray(py);
    dict.set_item("memory", memory.reshape([count, columns])?)?;
    let [forces, moments]: [PyReadonlyArray2<'_, f64>; 2] = function.bind(py).call1((dict,))?.extract()?;
    pairs.forces = rows_of(&forces)?.to_vec();
    pairs.moments = rows_of(&moments)?.to_vec();
    let memory: PyReadonlyArray1<'_, f64> = memory.readonly();
    pairs.memory.copy_from_slice(memory.as_slice()?);
    Ok(())
}
