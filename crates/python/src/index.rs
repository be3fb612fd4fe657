//! Elements around points, and the nearest ones.

use std::sync::atomic::Ordering;

use fdem_contact::{Csr, Elements, Error, Index, Real};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::interrupt::{self, Stop};
use crate::number::{Number, NumberKind, rows_of, with_kind};
use crate::problem::{Problem, zeros};
use crate::search::{is_long, threads_for};

/// Points that are asked about between two looks at the flag of Ctrl-C: they take a small part of a second.
const ASKED: usize = 1 << 18;

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
    ask: impl Fn(&mut Index<T, D>, &[[T; D]], &mut Csr<T>) -> Result<(), Error> + Sync,
) -> PyResult<NearRows<'py>> {
    let (points, at): (PyReadonlyArray2<'py, T>, PyReadonlyArray2<'py, T>) =
        (points.extract()?, at.extract()?);
    let (points, at) = (rows_of::<T, D>(&points)?, rows_of::<T, D>(&at)?);
    let threads = threads_for(threads, points.len().max(at.len()));
    let stop = Stop::default();
    let is_long = is_long(points.len().max(at.len()));
    let (offsets, neighbours, distances) = interrupt::run(py, is_long, &stop, || {
        let mut index = Index::new().with_threads(threads)?.stopped_by(stop.clone());
        index.build(&Elements::points(points, T::ZERO)?)?;
        let mut offsets = zeros::<i64>(at.len() + 1)?;
        let (mut neighbours, mut distances) = (Vec::<u32>::new(), Vec::<T>::new());
        let mut found = Csr::new();
        for (some, ends) in at.chunks(ASKED).zip(offsets[1..].chunks_mut(ASKED)) {
            if stop.load(Ordering::Relaxed) {
                return Err(Error::Stopped.into());
            }
            if let Err(error) = ask(&mut index, some, &mut found) {
                // The number of a point in its error is that among all.
                return Err(ask(&mut index, at, &mut found).err().unwrap_or(error).into());
            }
            let start = neighbours.len();
            let count = found.neighbours().len();
            neighbours.try_reserve(count).map_err(|_| Problem::out_of_memory::<u32>(start + count))?;
            neighbours.extend_from_slice(found.neighbours());
            distances.try_reserve(count).map_err(|_| Problem::out_of_memory::<T>(start + count))?;
            distances.extend(found.values().iter().map(|square| square.sqrt()));
            for (end, offset) in ends.iter_mut().zip(&found.offsets()[1..]) {
                *end = (start + offset).cast_signed() as i64;
            }
        }
        neighbours.shrink_to_fit();
        distances.shrink_to_fit();
        Ok::<_, Problem>((offsets, neighbours, distances))
    })?;
    Ok((offsets.into_pyarray(py), neighbours.into_pyarray(py), distances.into_pyarray(py).into_any()))
}
