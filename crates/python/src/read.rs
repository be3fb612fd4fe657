//! Files of packings and meshes.

use std::sync::atomic::AtomicU64;

use fdem_io::{Cells, Centres, MeshFormat, Packing, ReadError, ReadOptions};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Whether the content of a file, or else its name, is that of a mesh.
#[pyfunction]
pub(crate) fn is_mesh(bytes: &[u8], name: &str) -> bool {
    MeshFormat::of(bytes, name).is_some()
}

/// The columns of a packing.
#[pyfunction]
pub(crate) fn read_packing<'py>(
    py: Python<'py>,
    bytes: &[u8],
    name: &str,
    columns: Option<&str>,
    bodies: Option<String>,
    skip_bad_lines: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let refused = |error: String| PyValueError::new_err(format!("{name}: {error}"));
    let columns = columns.map(str::parse).transpose();
    let columns = columns.map_err(|error: fdem_io::ColumnsError| refused(error.to_string()))?;
    let options = ReadOptions { columns, skip_bad_lines, ignore_ids: false, bodies };
    let packing = py.detach(|| fdem_io::read(bytes, &options, &AtomicU64::new(0)));
    let packing = packing.map_err(|error| PyValueError::new_err(unreadable(name, &error)))?;
    let Packing { centres, radii, ids, bodies, row_numbers, source, .. } = packing;
    let found = PyDict::new(py);
    match centres {
        Centres::Two(centres) => found.set_item("positions", rows(py, centres)?)?,
        Centres::Three(centres) => found.set_item("positions", rows(py, centres)?)?,
    }
    found.set_item("radii", radii.map(|radii| radii.into_pyarray(py)))?;
    found.set_item("ids", ids.map(|ids| ids.into_pyarray(py)))?;
    found.set_item("bodies", bodies.map(|bodies| bodies.into_pyarray(py)))?;
    found.set_item("row_numbers", row_numbers.map(|numbers| numbers.into_pyarray(py)))?;
    found.set_item("format", source.format.to_string())?;
    found.set_item("unit", source.unit)?;
    found.set_item("skipped", source.skipped.count)?;
    let bad = source.skipped.first.iter();
    let bad: Vec<String> =
        bad.map(|bad| format!("{name}:{}: {}: {}", bad.line, bad.problem, bad.text)).collect();
    found.set_item("bad_lines", bad)?;
    Ok(found)
}

/// `file:line: what is wrong`, as the command has it.
fn unreadable(name: &str, error: &ReadError) -> String {
    match error.line() {
        Some(line) => format!("{name}:{line}: {error}"),
        None => format!("{name}: {error}"),
    }
}

fn rows<V: numpy::Element, const D: usize>(py: Python<'_>, rows: Vec<[V; D]>) -> PyResult<Bound<'_, PyAny>> {
    let count = rows.len();
    Ok(rows.into_flattened().into_pyarray(py).reshape([count, D])?.into_any())
}

/// The nodes and elements of a mesh.
#[pyfunction]
pub(crate) fn read_mesh<'py>(py: Python<'py>, bytes: &[u8], name: &str) -> PyResult<Bound<'py, PyDict>> {
    let mesh = py.detach(|| fdem_io::read_mesh(bytes, name));
    let mesh = mesh.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let found = PyDict::new(py);
    let names: Vec<_> = mesh.bodies.iter().map(|body| (body.number, body.name.clone())).collect();
    found.set_item("bodies", names)?;
    found.set_item("format", mesh.source.format.to_string())?;
    if mesh.dimensions == 2 {
        let points: Vec<[f64; 2]> = mesh.points.iter().map(|&[x, y, _]| [x, y]).collect();
        found.set_item("nodes", rows(py, points)?)?;
    } else {
        found.set_item("nodes", rows(py, mesh.points)?)?;
    }
    set_cells(&found, "segments", mesh.segments)?;
    set_cells(&found, "triangles", mesh.triangles)?;
    set_cells(&found, "tetrahedra", mesh.tetrahedra)?;
    Ok(found)
}

fn set_cells<const N: usize>(found: &Bound<'_, PyDict>, name: &str, cells: Cells<N>) -> PyResult<()> {
    let py = found.py();
    found.set_item(name, rows(py, cells.nodes)?)?;
    found.set_item(format!("{name}_bodies"), cells.bodies.into_pyarray(py))
}
