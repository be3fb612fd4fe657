//! Files of packings and meshes.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use fdem::pieces::FilesBeside;
use fdem_io::{
    Cells, Centres, FileKind, FrameIndex, Packing, PackingFormat, ReadError, ReadOptions, Series, unpack,
};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyDict;

use crate::interrupt;

/// The content of a file: "packing" or "mesh", and its columns.
type Read<'py> = (&'static str, Bound<'py, PyDict>);

/// Reads a file by its content.
///
/// `frame`: that of a packing, from the end if it is negative; it must be given if there are several.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one for each option")]
pub(crate) fn read<'py>(
    py: Python<'py>,
    bytes: PyBackedBytes,
    name: String,
    format: Option<&str>,
    frame: Option<isize>,
    columns: Option<&str>,
    bodies: Option<String>,
    skip_bad_lines: bool,
) -> PyResult<Read<'py>> {
    let frames = match Frames::new(py, bytes, &name, format, columns, bodies, skip_bad_lines)? {
        Err(Unopened::Mesh(bytes)) if frame.is_none() => return Ok(("mesh", read_mesh(py, bytes, name)?)),
        frames => frames.map_err(|unopened| unopened.refused(&name, CHOICES))?,
    };
    let count = frames.__len__();
    let frame = match frame {
        None if count == 1 => 0,
        None => return Err(frames.refused(&format!("{count} frames: choose one of 0 to {}", count - 1))),
        Some(frame) => {
            let place = if frame < 0 { frame.checked_add_unsigned(count) } else { Some(frame) };
            let place = place.and_then(|place| usize::try_from(place).ok()).filter(|&place| place < count);
            place.ok_or_else(|| frames.refused(&format!("there is no frame {frame} among {count}")))?
        }
    };
    Ok(("packing", frames.read(py, frame)?))
}

/// The frames of a file of packings, each of which is read when it is asked for.
#[pyclass(frozen, module = "fdem._fdem")]
#[derive(Debug)]
pub(crate) struct Frames(Arc<Content>);

/// The content of a file of packings.
#[derive(Debug)]
struct Content {
    bytes: Vec<u8>,
    index: FrameIndex,
    /// The files that it lists, if it is a collection.
    pieces: Option<FilesBeside>,
    name: String,
    options: ReadOptions,
}

/// Parts of a packing that a mesh does not have.
const CHOICES: &str = "columns, bodies or frames to choose";

/// Why there are no frames.
enum Unopened {
    /// The content is a mesh: these are its bytes.
    Mesh(Vec<u8>),
    Refused(PyErr),
}

impl Unopened {
    /// The error of the file `name`. `has_no`: the parts that a mesh does not have.
    fn refused(self, name: &str, has_no: &str) -> PyErr {
        match self {
            Self::Mesh(_) => PyValueError::new_err(format!("{name}: this is a mesh: it has no {has_no}")),
            Self::Refused(error) => error,
        }
    }
}

impl Content {
    /// Opens the bytes of a file. `format`: that of the file, if it is given.
    fn new(
        bytes: &[u8],
        name: String,
        format: Option<PackingFormat>,
        options: ReadOptions,
    ) -> Result<Self, Unopened> {
        let unread = |error: ReadError| Unopened::Refused(PyValueError::new_err(unreadable(&name, &error)));
        let has_choices = options.columns.is_some() || options.bodies.is_some();
        let bytes = unpack(bytes.into(), |_| true).map_err(unread)?.0.into_owned();
        let bare = [".gz", ".zst", ".zstd"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(&name);
        if format.is_none() && matches!(FileKind::of(&bytes, bare).map_err(unread)?, FileKind::Mesh(_)) {
            let mesh = Unopened::Mesh(bytes);
            return Err(if has_choices { Unopened::Refused(mesh.refused(&name, CHOICES)) } else { mesh });
        }
        let files = FilesBeside::new(Path::new(&name), None);
        let may_list = matches!(format, None | Some(PackingFormat::VtkXml));
        let collection = if may_list { Series::of_collection(&bytes, &files) } else { Ok(None) };
        let is_collection = matches!(collection, Ok(Some(_)));
        let index = match collection.map_err(unread)? {
            Some(series) => series.index(),
            None => Series::open(&bytes, bare, format).map_err(unread)?.index(),
        };
        Ok(Self { bytes, index, pieces: is_collection.then_some(files), name, options })
    }

    /// Reads a frame.
    fn read(&self, frame: usize) -> Result<Packing, ReadError> {
        let Self { bytes, index, pieces, options, .. } = self;
        let collection = pieces.as_ref().map(|files| Series::of_collection(bytes, files)).transpose()?;
        let series = collection.flatten().unwrap_or_else(|| Series::of_index(bytes, index.clone()));
        series.read(frame, options, &AtomicU64::new(0))
    }
}

impl Frames {
    /// Opens the bytes of a file; the outer error is the exception of a handler of signals.
    fn new(
        py: Python<'_>,
        bytes: PyBackedBytes,
        name: &str,
        format: Option<&str>,
        columns: Option<&str>,
        bodies: Option<String>,
        skip_bad_lines: bool,
    ) -> PyResult<Result<Self, Unopened>> {
        let refused = |error: &str| PyValueError::new_err(format!("{name}: {error}"));
        let format = format.map(str::parse::<PackingFormat>).transpose();
        let format = format.map_err(|error| refused(&error))?;
        let columns = columns.map(str::parse).transpose();
        let columns = columns.map_err(|error: fdem_io::ColumnsError| refused(&error.to_string()))?;
        let options = ReadOptions { columns, skip_bad_lines, ignore_ids: false, bodies, types: None };
        let name = name.to_owned();
        let content = interrupt::leave(py, move || Content::new(&bytes, name, format, options))?;
        Ok(content.map(|content| Self(Arc::new(content))))
    }

    fn refused(&self, error: &str) -> PyErr {
        PyValueError::new_err(format!("{}: {error}", self.0.name))
    }
}

#[pymethods]
impl Frames {
    #[new]
    fn opened(
        py: Python<'_>,
        bytes: PyBackedBytes,
        name: &str,
        format: Option<&str>,
        columns: Option<&str>,
        bodies: Option<String>,
        skip_bad_lines: bool,
    ) -> PyResult<Self> {
        let frames = Self::new(py, bytes, name, format, columns, bodies, skip_bad_lines)?;
        frames.map_err(|unopened| unopened.refused(name, "frames"))
    }

    fn __len__(&self) -> usize {
        self.0.index.frames()
    }

    /// The columns of a frame, counted from 0.
    fn read<'py>(&self, py: Python<'py>, frame: usize) -> PyResult<Bound<'py, PyDict>> {
        let Content { index, name, options, .. } = &*self.0;
        if frame >= index.frames() {
            return Err(self.refused(&format!("there is no frame {frame} among {}", index.frames())));
        }
        let content = Arc::clone(&self.0);
        let packing = interrupt::leave(py, move || content.read(frame))?;
        let mut packing = packing.map_err(|error| PyValueError::new_err(unreadable(name, &error)))?;
        let unused = packing.source.unused_axis().filter(|_| options.columns.is_none());
        let diameter = packing.radii.iter().flatten().copied().reduce(f64::max).map(|radius| 2.0 * radius);
        let flat = diameter.and_then(|diameter| packing.flatten(diameter));
        let remarks: Vec<_> =
            unused.into_iter().chain(flat).map(|remark| format!("{name}: {remark}")).collect();
        let found = packing_columns(py, name, packing)?;
        found.set_item("frames", index.frames())?;
        found.set_item("remarks", remarks)?;
        Ok(found)
    }
}

/// The columns of a packing.
fn packing_columns<'py>(py: Python<'py>, name: &str, packing: Packing) -> PyResult<Bound<'py, PyDict>> {
    let Packing { centres, radii, ids, bodies, types: _, row_numbers, cell, frame, source } = packing;
    let found = PyDict::new(py);
    match centres {
        Centres::Two(centres) => found.set_item("positions", rows(py, centres)?)?,
        Centres::Three(centres) => found.set_item("positions", rows(py, centres)?)?,
    }
    found.set_item("radii", radii.map(|radii| radii.into_pyarray(py)))?;
    found.set_item("ids", ids.map(|ids| ids.into_pyarray(py)))?;
    found.set_item("bodies", bodies.map(|bodies| bodies.into_pyarray(py)))?;
    found.set_item("row_numbers", row_numbers.map(|numbers| numbers.into_pyarray(py)))?;
    found.set_item("cell", cell.map(|cell| (cell.origin, cell.edges, cell.repeats)))?;
    found.set_item("frame", frame.index)?;
    found.set_item("step", frame.step)?;
    found.set_item("time", frame.time)?;
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
fn read_mesh(py: Python<'_>, bytes: Vec<u8>, name: String) -> PyResult<Bound<'_, PyDict>> {
    let mut load = |path: &str| std::fs::read(path).map_err(|error| error.to_string());
    let mesh = interrupt::leave(py, move || fdem_io::read_mesh_with(&bytes, &name, &mut load))?;
    let mesh = mesh.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let found = PyDict::new(py);
    let names: Vec<_> = mesh.bodies.iter().map(|body| (body.number, body.name.clone())).collect();
    found.set_item("bodies", names)?;
    found.set_item("format", mesh.source.format.to_string())?;
    found.set_item("notes", mesh.source.notes())?;
    let groups = PyDict::new(py);
    for group in mesh.groups {
        let of = PyDict::new(py);
        for (kind, members) in [
            ("nodes", group.nodes),
            ("segments", group.segments),
            ("triangles", group.triangles),
            ("tetrahedra", group.tetrahedra),
        ] {
            of.set_item(kind, members.into_pyarray(py))?;
        }
        of.set_item("edges", rows(py, group.edges)?)?;
        of.set_item("faces", rows(py, group.faces)?)?;
        let name = group.name.or_else(|| group.number.map(|number| number.to_string()));
        groups.set_item(name, of)?;
    }
    found.set_item("groups", groups)?;
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
