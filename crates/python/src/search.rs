//! The search over all elements, its check, and its explanation.

use fdem_contact::{Couple, Detector, Engine, PeriodicBox, PeriodicSearch, Search, verify as verify_couples};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::device::{device_of, search_on};
use crate::elements::{Elements, Set};
use crate::interrupt::{self, Stop};
use crate::last_search;
use crate::number::{Number, rows_of, with_kind};
use crate::problem::Problem;
use crate::shifted::{ShiftedCouples, joined};

/// Elements that are searched in less time than it takes to start threads and to join them.
const FEW_FOR_THREADS: usize = 1 << 15;

/// Elements that every engine searches in less than a tenth of a second.
const FEW_TO_WATCH: usize = 1 << 13;

/// Couples as rows of two numbers, and the shifts of the last of them, rows of D; all before have shift 0.
pub(crate) type FoundPairs<'py> = (Bound<'py, PyArray2<u32>>, Bound<'py, PyArray2<i32>>);

/// The engine of this name; `None` for "auto".
pub(crate) fn engine_of(name: &str) -> Result<Option<Engine>, Problem> {
    if name == "auto" {
        return Ok(None);
    }
    Engine::ALL.into_iter().find(|engine| engine.name() == name).map(Some).ok_or_else(|| {
        let names = Engine::ALL.map(Engine::name).join(", ");
        Problem::Arguments(format!("there is no engine '{name}': choose one of auto, {names}"))
    })
}

/// The number of threads for a search: 0 is one for each processor, but one thread searches few elements. The
/// result is the same.
pub(crate) fn threads_for(threads: usize, elements: usize) -> usize {
    if threads == 0 && elements <= FEW_FOR_THREADS { 1 } else { threads }
}

/// Whether a search takes long enough to be watched.
pub(crate) fn is_long(elements: usize) -> bool {
    elements > FEW_TO_WATCH
}

/// Two numbers a row, in the memory in which the search has written them.
pub(crate) fn into_pairs(py: Python<'_>, couples: Vec<Couple>) -> PyResult<Bound<'_, PyArray2<u32>>> {
    let rows = couples.len();
    flattened(couples).into_pyarray(py).reshape([rows, 2])
}

#[allow(unsafe_code, reason = "a list changes its type where it is")]
fn flattened(mut couples: Vec<Couple>) -> Vec<u32> {
    const { assert!(size_of::<Couple>() == 2 * size_of::<u32>() && align_of::<Couple>() == align_of::<u32>()) };
    // A list may have twice the memory that it needs: the rest goes back to the system.
    couples.shrink_to_fit();
    let mut couples = std::mem::ManuallyDrop::new(couples);
    let (start, len, capacity) = (couples.as_mut_ptr(), couples.len(), couples.capacity());
    // SAFETY: the memory comes from a vector that is not used again. A couple is `repr(C)` and two `u32`, of
    // which any is valid; so the layout of `2 * capacity` of these is that with which the memory was
    // allocated, and the first `2 * len` are initialised.
    unsafe { Vec::from_raw_parts(start.cast(), 2 * len, 2 * capacity) }
}

pub(crate) fn search_open<T: Number, const D: usize>(
    set: Set<'_, T, D>,
    engine: Option<Engine>,
    threads: usize,
    stop: &Stop,
) -> Result<Vec<Couple>, Problem> {
    let elements = set.checked()?;
    let detector = if engine.is_none() { last_search::take() } else { None };
    let detector = detector.unwrap_or_else(|| Detector::new().with_engine(engine));
    let mut detector = detector.with_threads(threads)?.stopped_by(stop.clone());
    let mut couples = Vec::new();
    detector.couples(&elements, &mut couples)?;
    if engine.is_none() {
        let bytes = detector.bytes();
        last_search::keep(detector.with_threads(1)?, bytes);
    }
    Ok(couples)
}

pub(crate) fn search_periodic<T: Number, const D: usize>(
    set: Set<'_, T, D>,
    cell: &PeriodicBox<T, D>,
    engine: Option<Engine>,
    threads: usize,
    stop: &Stop,
) -> Result<ShiftedCouples<D>, Problem> {
    let elements = set.checked()?;
    let search = if engine.is_none() { last_search::take() } else { None };
    let search = search.unwrap_or_else(|| PeriodicSearch::new().with_engine(engine));
    let mut search = search.with_threads(threads)?.stopped_by(stop.clone());
    let (mut couples, mut shifted) = (Vec::new(), Vec::new());
    search.couples_by_shift(&elements, cell, &mut couples, &mut shifted)?;
    if engine.is_none() {
        let bytes = search.bytes();
        last_search::keep(search.with_threads(1)?, bytes);
    }
    joined(couples, shifted)
}

/// All couples that touch.
#[pyfunction]
pub(crate) fn contacts<'py>(
    py: Python<'py>,
    elements: &Elements,
    engine: &str,
    threads: usize,
    device: &str,
) -> PyResult<FoundPairs<'py>> {
    let device = device_of(device, engine)?;
    let engine = engine_of(engine)?;
    let stop = Stop::default();
    with_kind!(elements.kind, T, D => {
        let held = elements.hold::<T>(py)?;
        let set = held.set::<D>(elements)?;
        let n = set.points.len();
        let threads = threads_for(threads, n);
        let cell = elements.cell::<T, D>()?;
        // A device opens for seconds, and a small box may have very many images.
        let is_long = is_long(n) || device.is_some() || cell.is_some();
        let search = || match (device, &cell) {
            (Some(device), cell) => search_on(device, set, cell.as_ref(), threads, &stop),
            (None, None) => Ok((search_open(set, engine, threads, &stop)?, Vec::new())),
            (None, Some(cell)) => search_periodic(set, cell, engine, threads, &stop),
        };
        let (couples, shifts) = interrupt::run(py, is_long, &stop, search)?;
        let rows = shifts.len();
        let shifts = shifts.into_flattened().into_pyarray(py).reshape([rows, D])?;
        Ok((into_pairs(py, couples)?, shifts))
    })
}

/// Compares the couples of `sample` elements with brute force; returns the number of elements checked, and
/// the first difference.
#[pyfunction]
pub(crate) fn verify(
    py: Python<'_>,
    elements: &Elements,
    pairs: PyReadonlyArray2<'_, u32>,
    sample: usize,
    seed: u64,
) -> PyResult<(usize, Option<String>)> {
    let pairs = rows_of::<u32, 2>(&pairs)?;
    let stop = Stop::default();
    with_kind!(elements.kind, T, D => {
        let held = elements.hold::<T>(py)?;
        elements.check_unchanged(&held)?;
        let set = held.set::<D>(elements)?;
        interrupt::run(py, false, &stop, || {
            let checked = set.checked()?;
            let couples: Vec<Couple> = pairs.iter().map(|&[i, j]| Couple { i, j }).collect();
            Ok(match verify_couples(&checked, &couples, sample, seed) {
                Ok(checked) => (checked, None),
                Err(mismatch) => (0, Some(mismatch.to_string())),
            })
        })
    })
}

/// Describes in words how a search would run.
#[pyfunction]
pub(crate) fn explain(py: Python<'_>, elements: &Elements, engine: &str, threads: usize) -> PyResult<String> {
    let engine = engine_of(engine)?;
    let stop = Stop::default();
    with_kind!(elements.kind, T, D => {
        let held = elements.hold::<T>(py)?;
        let set = held.set::<D>(elements)?;
        let cell = elements.cell::<T, D>()?;
        let threads = threads_for(threads, set.points.len());
        interrupt::run(py, false, &stop, || {
            let checked = set.checked()?;
            Ok(match cell {
                None => Detector::new().with_engine(engine).with_threads(threads)?.explain(&checked)?.to_string(),
                Some(cell) => {
                    PeriodicSearch::new().with_engine(engine).with_threads(threads)?.explain(&checked, &cell)?.to_string()
                }
            })
        })
    })
}
