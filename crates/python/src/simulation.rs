//! Runs: the arrays of their state, steps without the interpreter's lock, and changes between steps.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use fdem::results::Field;
use fdem::session::{AnySession, Session};
use fdem::simulation::grains::{SphereLawOptions, Spheres};
use fdem::simulation::{ContactForce, Crack, Forces, Mode, Snapshot};
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::fields::values;
use crate::interrupt;
use crate::model::{PyReady, about, described};
use crate::number::{array_of_rows as rows, rows_of};
use crate::sphere_law::{Raised, law, taken};
use crate::spheres::{names, spheres};

/// Time between two looks for signals.
const SLICE: Duration = Duration::from_millis(50);

/// A run, and the exception that its law of spheres has raised.
#[pyclass(module = "fdem._fdem", name = "Run")]
pub(crate) struct PyRun(AnySession, Raised);

macro_rules! both {
    ($session:expr, $run:ident => $done:expr) => {
        match $session {
            AnySession::Plane($run) => $done,
            AnySession::Space($run) => $done,
        }
    };
}

fn column<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyAny> {
    values.into_pyarray(py).into_any()
}

fn snapshot<const D: usize, const N: usize>(
    py: Python<'_>,
    snapshot: Snapshot<D, N>,
) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("positions", rows(py, snapshot.positions)?)?;
    dict.set_item("displacements", rows(py, snapshot.displacements)?)?;
    dict.set_item("velocities", rows(py, snapshot.velocities)?)?;
    dict.set_item("elements", rows(py, snapshot.elements)?)?;
    dict.set_item("stress", rows(py, snapshot.stresses)?)?;
    dict.set_item("damage", column(py, snapshot.damage))?;
    dict.set_item("bodies", column(py, snapshot.bodies))?;
    dict.set_item("materials", column(py, snapshot.materials))?;
    dict.set_item("fragments", column(py, snapshot.fragments))?;
    dict.set_item("joints", joints(py, &snapshot.cracks)?)?;
    let (groups, walls) = names(&snapshot.spheres);
    dict.set_item("spheres", spheres(py, snapshot.spheres)?)?;
    dict.set_item("group_names", groups)?;
    dict.set_item("wall_names", walls)?;
    Ok(dict)
}

fn joints<'py, const D: usize>(py: Python<'py>, cracks: &[Crack<D>]) -> PyResult<Bound<'py, PyDict>> {
    let of = |value: fn(&Crack<D>) -> f64| column(py, cracks.iter().map(value).collect::<Vec<f64>>());
    let corners: Vec<[f64; D]> = cracks.iter().flat_map(|crack| crack.corners).collect();
    let mode = |crack: &Crack<D>| match crack.mode {
        Mode::Tension => 0_u8,
        Mode::Shear => 1,
        Mode::Mixed => 2,
    };
    let dict = PyDict::new(py);
    dict.set_item("elements", rows(py, cracks.iter().map(|crack| crack.elements).collect())?)?;
    let corners = corners.into_flattened().into_pyarray(py).reshape([cracks.len(), D, D])?;
    dict.set_item("corners", corners)?;
    dict.set_item("damage", of(|crack| crack.damage))?;
    dict.set_item("broken", column(py, cracks.iter().map(|crack| crack.time.is_some()).collect()))?;
    dict.set_item("mode", column(py, cracks.iter().map(mode).collect()))?;
    dict.set_item("open_from_start", column(py, cracks.iter().map(|crack| crack.open_from_start).collect()))?;
    dict.set_item("opening", of(|crack| crack.opening))?;
    dict.set_item("sliding", of(|crack| crack.sliding))?;
    dict.set_item("time", of(|crack| crack.time.unwrap_or(f64::NAN)))?;
    dict.set_item("measure", of(|crack| crack.measure))?;
    Ok(dict)
}

fn forces<const D: usize>(py: Python<'_>, forces: Forces<D>) -> PyResult<Bound<'_, PyDict>> {
    let contacts = &forces.contacts;
    let dict = PyDict::new(py);
    dict.set_item("elements", rows(py, contacts.iter().map(|contact| contact.elements).collect())?)?;
    dict.set_item("point", rows(py, contacts.iter().map(|contact| contact.point).collect())?)?;
    dict.set_item("force", rows(py, contacts.iter().map(ContactForce::force).collect())?)?;
    dict.set_item("normal", rows(py, contacts.iter().map(|contact| contact.normal).collect())?)?;
    dict.set_item("tangential", rows(py, contacts.iter().map(|contact| contact.tangential).collect())?)?;
    dict.set_item("reactions", rows(py, forces.reactions)?)?;
    Ok(dict)
}

fn wrong(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

impl PyRun {
    fn of(session: AnySession) -> Self {
        Self(session, Raised::default())
    }
}

#[pymethods]
impl PyRun {
    #[new]
    #[pyo3(signature = (model, threads, earlier))]
    fn new(py: Python<'_>, model: &PyReady, threads: usize, earlier: Option<PathBuf>) -> PyResult<Self> {
        let ready = model.0.clone();
        let run = interrupt::leave(py, move || ready.begin(threads, earlier.as_deref()))?;
        run.map(Self::of).map_err(PyValueError::new_err)
    }

    #[staticmethod]
    fn resume(py: Python<'_>, path: PathBuf, threads: usize) -> PyResult<Self> {
        let run = interrupt::leave(py, move || AnySession::resume(&path, threads))?;
        run.map(Self::of).map_err(PyValueError::new_err)
    }

    /// Takes the given number of steps, or fewer if the run is over before, without the interpreter's lock.
    /// Between two of them it runs the handlers of signals; where one raises, the run stays at that step.
    fn advance(&mut self, py: Python<'_>, steps: u64) -> PyResult<()> {
        let (mut left, mut slice) = (steps, 1);
        while left > 0 && !self.is_over() {
            let now = slice.min(left);
            let start = Instant::now();
            let done = py.detach(|| both!(&mut self.0, session => session.advance(now)));
            done.map_err(|why| taken(&self.1).unwrap_or_else(|| PyRuntimeError::new_err(why)))?;
            left -= now;
            let each = (start.elapsed().as_secs_f64() / now as f64).max(1e-9);
            slice = ((SLICE.as_secs_f64() / each) as u64).clamp(1, 10 * now);
            py.check_signals()?;
        }
        Ok(())
    }

    #[getter]
    fn is_over(&self) -> bool {
        both!(&self.0, session => session.is_over())
    }

    #[getter]
    fn stage(&self) -> Option<&str> {
        both!(&self.0, session => session.stage())
    }

    /// Lines of the log.
    #[getter]
    fn told(&self) -> Vec<String> {
        both!(&self.0, session => session.told().to_vec())
    }

    #[getter]
    fn text(&self) -> &str {
        both!(&self.0, session => &session.source.text)
    }

    #[getter]
    fn steps(&self) -> u64 {
        both!(&self.0, session => session.run().steps())
    }

    #[getter]
    fn total(&self) -> u64 {
        both!(&self.0, session => session.total())
    }

    #[getter]
    fn time(&self) -> f64 {
        both!(&self.0, session => session.run().time())
    }

    #[getter]
    fn time_step(&self) -> f64 {
        both!(&self.0, session => session.run().time_step())
    }

    #[getter]
    fn threads(&self) -> usize {
        both!(&self.0, session => session.run().threads())
    }

    #[getter]
    fn state_hash(&self, py: Python<'_>) -> String {
        py.detach(|| both!(&self.0, session => session.state_hash()))
    }

    fn about<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        described(py, both!(&self.0, session => about(session.prepared())))
    }

    /// Positions, motion, stress, fragments and joints now, as arrays that nothing else uses.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match &self.0 {
            AnySession::Plane(session) => snapshot(py, py.detach(|| session.snapshot())),
            AnySession::Space(session) => snapshot(py, py.detach(|| session.snapshot())),
        }
    }

    /// Forces of contacts, and of boundaries on nodes, at the beginning of the last step.
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match &self.0 {
            AnySession::Plane(session) => forces(py, py.detach(|| session.run().forces())),
            AnySession::Space(session) => forces(py, py.detach(|| session.run().forces())),
        }
    }

    fn energies(&self) -> Vec<(&'static str, f64)> {
        let energies = both!(&self.0, session => session.run().energies());
        let terms = energies.terms().into_iter().map(|term| (term.key, term.value));
        terms.chain([("balance", energies.balance()), ("error", energies.error())]).collect()
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let counts = both!(&self.0, session => session.run().counts());
        let elements = both!(&self.0, session => session.run().model().mesh.elements.len());
        vec![
            ("elements", elements as u64),
            ("nodes", counts.nodes as u64),
            ("joints", counts.joints as u64),
            ("broken_joints", counts.broken as u64),
            ("open_joints", counts.open as u64),
            ("contacts", counts.contacts as u64),
            ("detections", counts.detections),
        ]
    }

    /// The force of each boundary on the bodies at the beginning of the last step.
    fn boundary_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        both!(&self.0, session => for (number, boundary) in session.run().model().boundaries.iter().enumerate() {
            let force = session.run().force(number).map_or_else(Vec::new, |force| force.to_vec());
            dict.set_item(&boundary.name, column(py, force))?;
        });
        Ok(dict)
    }

    fn set_velocities(
        &mut self,
        nodes: PyReadonlyArray1<'_, u32>,
        vectors: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        let nodes = nodes.as_slice()?;
        both!(&mut self.0, session => session.run_mut().set_velocities(nodes, rows_of(&vectors)?))
            .map_err(wrong)
    }

    fn set_forces(
        &mut self,
        nodes: PyReadonlyArray1<'_, u32>,
        vectors: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        let nodes = nodes.as_slice()?;
        both!(&mut self.0, session => session.run_mut().set_forces(nodes, rows_of(&vectors)?)).map_err(wrong)
    }

    /// Adds spheres of a material and a group, by their numbers. Returns the numbers of the spheres.
    fn add_spheres<'py>(
        &mut self,
        py: Python<'py>,
        places: PyReadonlyArray2<'_, f64>,
        radii: PyReadonlyArray1<'_, f64>,
        motion: [PyReadonlyArray2<'_, f64>; 2],
        numbers: [u32; 2],
    ) -> PyResult<Bound<'py, PyAny>> {
        let (count, [material, group]) = (radii.len()?, numbers);
        let [velocities, spins] = &motion;
        let spheres = Spheres {
            positions: rows_of(&places)?.to_vec(),
            radii: radii.as_slice()?.to_vec(),
            velocities: rows_of(velocities)?.to_vec(),
            spins: rows_of(spins)?.to_vec(),
            materials: vec![material; count],
            groups: vec![group; count],
            held: Vec::new(),
        };
        let added = both!(&mut self.0, session => session.run_mut().add_spheres(&spheres)).map_err(wrong)?;
        Ok(column(py, added.collect()))
    }

    /// Sets a law of spheres: see [`law`]. `numbers`: its reach, m, and its columns of memory.
    fn set_sphere_law(&mut self, function: Py<PyAny>, numbers: (f64, usize), replaces: bool) -> PyResult<()> {
        let (law, (reach, columns)) = (law(function, Arc::clone(&self.1)), numbers);
        let options = SphereLawOptions { reach, columns, replaces };
        both!(&mut self.0, session => session.run_mut().set_sphere_law(law, options)).map_err(wrong)
    }

    fn clear_sphere_law(&mut self) -> PyResult<()> {
        both!(&mut self.0, session => session.run_mut().clear_sphere_law()).map_err(wrong)
    }

    /// Names of the materials, and of the groups of spheres.
    fn sphere_names(&self) -> [Vec<String>; 2] {
        both!(&self.0, session => {
            let model = session.run().model();
            let groups = model.grains.iter().flat_map(|grains| grains.groups.iter().cloned());
            [model.materials.iter().map(|of| of.name.clone()).collect(), groups.collect()]
        })
    }

    fn clear_forces(&mut self) {
        both!(&mut self.0, session => session.run_mut().clear_forces());
    }

    fn set_boundary(&mut self, number: usize, factor: Option<f64>) -> PyResult<()> {
        both!(&mut self.0, session => session.run_mut().set_factor(number, factor)).map_err(wrong)
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let done = py.detach(|| both!(&self.0, session => session.save(&path)));
        done.map_err(pyo3::exceptions::PyOSError::new_err)
    }

    /// The values of a field now: see [`values`].
    #[pyo3(signature = (name, at))]
    fn field<'py>(&self, py: Python<'py>, name: &str, at: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
        values(py, &self.0, name, at)
    }

    /// The PNG of a picture; `None`: the first field of the model's output.
    #[pyo3(signature = (field, width))]
    fn picture<'py>(
        &self,
        py: Python<'py>,
        field: Option<&str>,
        width: Option<u32>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let first = || both!(&self.0, session => session.prepared().output.fields.first().copied());
        let field = match field {
            None => first().unwrap_or(Field::MAX_PRINCIPAL),
            Some(name) => Field::named(name).ok_or_else(|| {
                let all: Vec<&str> = Field::ALL.iter().map(|field| field.key()).collect();
                PyValueError::new_err(format!("there is no field '{name}': {}", all.join(", ")))
            })?,
        };
        let png = py.detach(|| both!(&self.0, session => session.picture(field, width)));
        png.map(|png| PyBytes::new(py, &png)).map_err(PyValueError::new_err)
    }
}

// A run of either dimension can be read from any thread of Python.
const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<Session<2, 3>>();
    shared::<Session<3, 4>>();
};
