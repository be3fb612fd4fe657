//! Elements: arrays of the caller, kept and borrowed.

use std::sync::Arc;

use fdem::network::PairCutoffs;
use fdem_contact::{Elements as Checked, Error, Filter, PeriodicBox};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::number::{Number, NumberKind, entries_of, rows_of, with_kind};
use crate::problem::Problem;

/// Elements to be searched, in arrays of the caller.
///
/// The numbers are checked by each search. `kind` determines `size` and `others`: "radii" (array `[n]`),
/// "radius" and "cutoff" (a number), "pairs" (array `[n]` of types, with `cutoffs` of pairs of them), "upper"
/// (corners `[n, D]`, where `points` are the lower ones).
#[pyclass(frozen, module = "fdem._fdem")]
#[derive(Debug)]
pub(crate) struct Elements {
    points: Py<PyAny>,
    sizes: Sizes,
    groups: Option<Py<PyArray1<u32>>>,
    tolerance: f64,
    cell: Option<Cell>,
    pub(crate) kind: NumberKind,
    /// A hash of the coordinates when they were handed over.
    fingerprint: u64,
}

#[derive(Debug)]
enum Sizes {
    Each(Py<PyAny>),
    All(f64),
    Cutoff(f64),
    Pairs(Arc<PairCutoffs>),
    Upper(Py<PyAny>),
}

#[derive(Debug)]
struct Cell {
    origin: Vec<f64>,
    edges: Vec<Vec<f64>>,
    periodic: Vec<bool>,
}

/// Origin, edges, and which of them repeat.
type CellArgument = (Vec<f64>, Vec<Vec<f64>>, Vec<bool>);

/// The arrays of some elements, borrowed.
pub(crate) struct Held<'py, T: Number> {
    points: PyReadonlyArray2<'py, T>,
    sizes: HeldSizes<'py, T>,
    groups: Option<PyReadonlyArray1<'py, u32>>,
}

enum HeldSizes<'py, T: Number> {
    Each(PyReadonlyArray1<'py, T>),
    All(T),
    Cutoff(T),
    Pairs(Arc<PairCutoffs>),
    Upper(PyReadonlyArray2<'py, T>),
}

/// The numbers of some elements.
#[derive(Clone, Copy)]
pub(crate) struct Set<'a, T, const D: usize> {
    pub(crate) points: &'a [[T; D]],
    pub(crate) sizes: SetSizes<'a, T, D>,
    groups: Option<&'a [u32]>,
    pub(crate) tolerance: T,
}

#[derive(Clone, Copy)]
pub(crate) enum SetSizes<'a, T, const D: usize> {
    Each(&'a [T]),
    All(T),
    Cutoff(T),
    /// The search finds couples up to the largest of these.
    Pairs(&'a PairCutoffs),
    Upper(&'a [[T; D]]),
}

impl<'a, T: Number, const D: usize> Set<'a, T, D> {
    /// Checks all numbers: a pass over them.
    pub(crate) fn checked(&self) -> Result<Checked<'a, T, D>, Error> {
        let elements = match self.sizes {
            SetSizes::Each(radii) => Checked::spheres_with_radii(self.points, radii),
            SetSizes::All(radius) => Checked::spheres(self.points, radius),
            SetSizes::Cutoff(cutoff) => Checked::points(self.points, cutoff),
            SetSizes::Pairs(cutoffs) => Checked::points(self.points, T::nearest(cutoffs.largest())),
            SetSizes::Upper(upper) => Checked::boxes(self.points, upper),
        }?
        .with_tolerance(self.tolerance)?;
        let filter = match (self.sizes, self.groups) {
            (SetSizes::Pairs(cutoffs), Some(groups)) => cutoffs.filter().with_bodies(groups),
            (SetSizes::Pairs(cutoffs), None) => cutoffs.filter(),
            (_, Some(groups)) => Filter::bodies(groups),
            (_, None) => return Ok(elements),
        };
        elements.with_filter(filter)
    }
}

impl<T: Number> Held<'_, T> {
    pub(crate) fn set<const D: usize>(&self, of: &Elements) -> PyResult<Set<'_, T, D>> {
        let sizes = match &self.sizes {
            HeldSizes::Each(radii) => SetSizes::Each(entries_of(radii)?),
            HeldSizes::All(radius) => SetSizes::All(*radius),
            HeldSizes::Cutoff(cutoff) => SetSizes::Cutoff(*cutoff),
            HeldSizes::Pairs(cutoffs) => SetSizes::Pairs(cutoffs),
            HeldSizes::Upper(upper) => SetSizes::Upper(rows_of(upper)?),
        };
        let groups = self.groups.as_ref().map(entries_of).transpose()?;
        Ok(Set { points: rows_of(&self.points)?, sizes, groups, tolerance: T::nearest(of.tolerance) })
    }

    /// A hash of 2048 coordinates, spread over all of them, so that a motion of many elements changes it.
    fn fingerprint(&self) -> u64 {
        const SAMPLES: usize = 2048;
        let points = self.points.as_slice().unwrap_or(&[]);
        let others: &[T] = match &self.sizes {
            HeldSizes::Each(radii) => radii.as_slice().unwrap_or(&[]),
            HeldSizes::Upper(upper) => upper.as_slice().unwrap_or(&[]),
            HeldSizes::All(_) | HeldSizes::Cutoff(_) | HeldSizes::Pairs(_) => &[],
        };
        let sampled = [points, others]
            .into_iter()
            .flat_map(|values| values.iter().step_by(values.len().div_ceil(SAMPLES).max(1)));
        // FNV-1a, a word at a time: G. Fowler, L.C. Noll, K.-P. Vo.
        sampled.fold(0xcbf2_9ce4_8422_2325, |hash, value| {
            (hash ^ value.to_f64().to_bits()).wrapping_mul(0x0100_0000_01b3).rotate_left(23)
        })
    }
}

impl Elements {
    pub(crate) fn hold<'py, T: Number>(&self, py: Python<'py>) -> PyResult<Held<'py, T>> {
        let sizes = match &self.sizes {
            Sizes::Each(radii) => HeldSizes::Each(radii.bind(py).cast::<PyArray1<T>>()?.readonly()),
            Sizes::All(radius) => HeldSizes::All(T::nearest(*radius)),
            Sizes::Cutoff(cutoff) => HeldSizes::Cutoff(T::nearest(*cutoff)),
            Sizes::Pairs(cutoffs) => HeldSizes::Pairs(Arc::clone(cutoffs)),
            Sizes::Upper(upper) => HeldSizes::Upper(upper.bind(py).cast::<PyArray2<T>>()?.readonly()),
        };
        let points = self.points.bind(py).cast::<PyArray2<T>>()?.readonly();
        let groups = self.groups.as_ref().map(|groups| groups.bind(py).readonly());
        Ok(Held { points, sizes, groups })
    }

    /// The box that repeats, if there is one.
    pub(crate) fn cell<T: Number, const D: usize>(&self) -> Result<Option<PeriodicBox<T, D>>, Problem> {
        let Some(Cell { origin, edges, periodic }) = &self.cell else { return Ok(None) };
        let wrong = || Problem::Arguments(format!("the box must have {D} edges"));
        let row = |row: &Vec<f64>| -> Result<[T; D], Problem> {
            let row: [f64; D] = row.as_slice().try_into().map_err(|_| wrong())?;
            Ok(row.map(T::nearest))
        };
        let edges = edges.iter().map(row).collect::<Result<Vec<_>, _>>()?;
        let edges = edges.try_into().map_err(|_| wrong())?;
        let periodic = periodic.as_slice().try_into().map_err(|_| wrong())?;
        Ok(Some(PeriodicBox::triclinic(row(origin)?, edges, periodic)?))
    }

    /// Refuses to continue with coordinates other than those that were searched.
    pub(crate) fn check_unchanged<T: Number>(&self, held: &Held<'_, T>) -> PyResult<()> {
        if held.fingerprint() == self.fingerprint {
            return Ok(());
        }
        Err(PyRuntimeError::new_err(
            "the positions or sizes have been changed in place since the search: ask for distances and overlaps before that, or search a copy",
        ))
    }
}

#[pymethods]
impl Elements {
    #[new]
    #[pyo3(signature = (points, kind, size, others, tolerance, groups, cell, fingerprint=None, cutoffs=None))]
    #[allow(clippy::too_many_arguments, reason = "one for each thing that elements have")]
    fn new(
        py: Python<'_>,
        points: Py<PyAny>,
        kind: &str,
        size: f64,
        others: Option<Py<PyAny>>,
        tolerance: f64,
        groups: Option<Py<PyArray1<u32>>>,
        cell: Option<CellArgument>,
        fingerprint: Option<u64>,
        cutoffs: Option<Vec<(u32, u32, f64)>>,
    ) -> PyResult<Self> {
        let sizes = match (kind, others) {
            ("pairs", Some(types)) => {
                let types = types.bind(py).cast::<PyArray1<u32>>()?.readonly();
                let cutoffs = cutoffs.unwrap_or_default().into_iter().map(|(a, b, cutoff)| ([a, b], cutoff));
                let found = PairCutoffs::new(entries_of(&types)?, &cutoffs.collect::<Vec<_>>());
                Sizes::Pairs(Arc::new(found.map_err(Problem::from)?))
            }
            ("radii", Some(radii)) => Sizes::Each(radii),
            ("upper", Some(upper)) => Sizes::Upper(upper),
            ("radius", None) => Sizes::All(size),
            ("cutoff", None) => Sizes::Cutoff(size),
            _ => return Err(Problem::Arguments(format!("there are no elements with {kind}")).into()),
        };
        let cell = cell.map(|(origin, edges, periodic)| Cell { origin, edges, periodic });
        let kind = NumberKind::of(points.bind(py))?;
        let mut elements = Self { points, sizes, groups, tolerance, cell, kind, fingerprint: 0 };
        let found = with_kind!(kind, T, D => {
            let held = elements.hold::<T>(py)?;
            // An array that cannot be borrowed is an error now.
            held.set::<D>(&elements)?;
            held.fingerprint()
        });
        elements.fingerprint = fingerprint.unwrap_or(found);
        Ok(elements)
    }

    /// The hash of the coordinates when they were searched. A copy with this hash notices later changes as
    /// the original does.
    #[getter]
    fn fingerprint(&self) -> u64 {
        self.fingerprint
    }
}
