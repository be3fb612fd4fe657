//! Elements around points, and the nearest ones.

use fdem_contact::{Csr, Elements, Index, Real};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::interrupt::{self, Stop};
use crate::number::{Number, NumberKind, rows_of, with_kind};
use crate::problem::{Problem, zeros};
use crate::search::threads_for;

/// The starts of the rows, the elements found, and their distances.
type NearRows<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyAny>);

/// Finds the `points` that are at most `r` away from each of `at`.
#[pyfunction]
pub(crate) fn within<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    at: &Bound<'py, PyAny>,
    r: f64,
    threads: usize,
) -> PyResult<NearRows<'py>> {
    with_kind!(NumberKind::of(points)?, T, D => search::<T, D>(py, points, at, threads, |index, at, found| {
        index.within_with_distances(at, T::nearest(r), found)
    }))
}

/// Finds the `k` points that are nearest to each of `at`, the nearest first.
#[pyfunction]
pub(crate) fn nearest<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    at: &Bound<'py, PyAny>,
    k: usize,
    threads: usize,
) -> PyResult<NearRows<'py>> {
    with_kind!(NumberKind::of(points)?, T, D => {
        search::<T, D>(py, points, at, threads, |index, at, found| index.nearest(at, k, found))
    })
}

fn search<'py, T: Number, const D: usize>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    at: &Bound<'py, PyAny>,
    threads: usize,
    ask: impl FnOnce(&mut Index<T, D>, &[[T; D]], &mut Csr<T>) -> Result<(), fdem_contact::Error> + Send,
) -> PyResult<NearRows<'py>> {
    let (points, at): (PyReadonlyArray2<'py, T>, PyReadonlyArray2<'py, T>) =
        (points.extract()?, at.extract()?);
    let (points, at) = (rows_of::<T, D>(&points)?, rows_of::<T, D>(&at)?);
    let threads = threads_for(threads, points.len().max(at.len()));
    let (offsets, neighbours, distances) = interrupt::run(py, false, &Stop::default(), || {
        let mut index = Index::new().with_threads(threads)?;
        index.build(&Elements::points(points, T::ZERO)?)?;
        let mut found = Csr::new();
        ask(&mut index, at, &mut found)?;
        drop(index);
        let mut offsets = zeros::<i64>(found.offsets().len())?;
        offsets.iter_mut().zip(found.offsets()).for_each(|(to, offset)| *to = offset.cast_signed() as i64);
        let mut neighbours = zeros::<u32>(found.neighbours().len())?;
        neighbours.copy_from_slice(found.neighbours());
        let mut distances = zeros::<T>(found.values().len())?;
        distances.iter_mut().zip(found.values()).for_each(|(to, square)| *to = square.sqrt());
        Ok::<_, Problem>((offsets, neighbours, distances))
    })?;
    Ok((offsets.into_pyarray(py), neighbours.into_pyarray(py), distances.into_pyarray(py).into_any()))
}
