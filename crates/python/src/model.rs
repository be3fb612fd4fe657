//! Model files, and models that are built in Python: both become the text of a model file, which the
//! command's checks read.

use std::path::PathBuf;
use std::sync::Arc;

use fdem::model::{AnyPrepared, Prepared};
use fdem::session::Ready;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};

use crate::interrupt;

/// A model that has passed all checks.
#[pyclass(frozen, module = "fdem._fdem", name = "Ready")]
pub(crate) struct PyReady(pub(crate) Arc<Ready>);

/// The properties of a model in any dimension, apart from its arrays.
pub(crate) struct About {
    title: String,
    end_time: f64,
    hash: String,
    warnings: Vec<String>,
    bodies: Vec<String>,
    materials: Vec<String>,
    boundaries: Vec<String>,
    elements: usize,
    dimensions: usize,
}

/// Describes a model.
pub(crate) fn about<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> About {
    let model = &prepared.model;
    About {
        title: prepared.title.clone(),
        end_time: prepared.end_time,
        hash: prepared.hash.clone(),
        warnings: prepared.warnings.clone(),
        bodies: prepared.bodies.iter().map(|body| body.name.clone()).collect(),
        materials: model.materials.iter().map(|material| material.name.clone()).collect(),
        boundaries: model.boundaries.iter().map(|boundary| boundary.name.clone()).collect(),
        elements: model.mesh.elements.len(),
        dimensions: D,
    }
}

/// Title, end time, hash, warnings, names and sizes of a model.
pub(crate) fn described(py: Python<'_>, about: About) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("title", about.title)?;
    dict.set_item("end_time", about.end_time)?;
    dict.set_item("hash", about.hash)?;
    dict.set_item("warnings", about.warnings)?;
    dict.set_item("bodies", about.bodies)?;
    dict.set_item("materials", about.materials)?;
    dict.set_item("boundaries", about.boundaries)?;
    dict.set_item("elements", about.elements)?;
    dict.set_item("dimensions", about.dimensions)?;
    Ok(dict)
}

#[pymethods]
impl PyReady {
    /// Checks and meshes the text of a model. `place`: the model file, or where it would be; `None` for the
    /// text of `place`.
    #[new]
    #[pyo3(signature = (text, name, place))]
    fn new(py: Python<'_>, text: Option<String>, name: String, place: PathBuf) -> PyResult<Self> {
        let ready = interrupt::leave(py, move || match text {
            Some(text) => Ready::new(text, &name, &place),
            None => Ready::read(&place),
        })?;
        ready.map(|ready| Self(Arc::new(ready))).map_err(PyValueError::new_err)
    }

    /// The model file.
    #[getter]
    fn text(&self) -> &str {
        &self.0.source.text
    }

    fn about<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let about = match &self.0.prepared {
            AnyPrepared::Plane(prepared) => about(prepared),
            AnyPrepared::Space(prepared) => about(prepared),
        };
        described(py, about)
    }
}

/// The text of a model file with these tables.
#[pyfunction]
pub(crate) fn to_toml(tables: &Bound<'_, PyDict>) -> PyResult<String> {
    let tables = table_of(tables, "", 0)?;
    toml::to_string(&tables).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Most tables and lists in each other. Models have less than ten; one that contains itself has no end.
const DEEPEST: usize = 64;

/// A table of TOML. `place`: its keys, for messages. Keys whose value is `None` are left out.
fn table_of(dict: &Bound<'_, PyDict>, place: &str, depth: usize) -> PyResult<toml::Table> {
    check_depth(depth, place)?;
    let mut table = toml::Table::new();
    for (key, value) in dict {
        let Ok(key) = key.extract::<String>() else {
            return Err(PyTypeError::new_err(format!(
                "{}: keys are strings, not {}",
                shown(place),
                key.get_type()
            )));
        };
        let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
        if !value.is_none() {
            table.insert(key, value_of(&value, &place, depth + 1)?);
        }
    }
    Ok(table)
}

fn check_depth(depth: usize, place: &str) -> PyResult<()> {
    if depth <= DEEPEST {
        return Ok(());
    }
    let top = place.split(['.', '[']).next().unwrap_or_default();
    Err(PyValueError::new_err(format!(
        "{top}: more than {DEEPEST} tables and lists in each other: does one contain itself?"
    )))
}

fn shown(place: &str) -> &str {
    if place.is_empty() { "model" } else { place }
}

/// A value of TOML. Arrays and numbers of NumPy are those of Python.
fn value_of(value: &Bound<'_, PyAny>, place: &str, depth: usize) -> PyResult<toml::Value> {
    use toml::Value;
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        let too_large = |_| PyValueError::new_err(format!("{place}: {value} is too large"));
        return value.extract().map(Value::Integer).map_err(too_large);
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        return table_of(dict, place, depth).map(Value::Table);
    }
    // Arrays and scalars of NumPy.
    if let Ok(plain) = value.call_method0("tolist") {
        return value_of(&plain, place, depth + 1);
    }
    if let Ok(path) = value.call_method0("__fspath__") {
        return value_of(&path, place, depth + 1);
    }
    if let Ok(items) = value.try_iter() {
        check_depth(depth, place)?;
        let each = items
            .enumerate()
            .map(|(number, item)| value_of(&item?, &format!("{place}[{number}]"), depth + 1));
        return each.collect::<PyResult<Vec<Value>>>().map(Value::Array);
    }
    let kind = value.get_type();
    Err(PyTypeError::new_err(format!("{place}: a model has no values of {kind}")))
}
