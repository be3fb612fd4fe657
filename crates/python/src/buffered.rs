//! Searches that follow moving elements.

use std::any::Any;

use fdem_contact::{Buffered as Search, Detector, PeriodicBuffered, PeriodicSearch, Real};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;

use crate::elements::Elements;
use crate::interrupt::{self, Stop};
use crate::number::{NumberKind, with_kind};
use crate::problem::Problem;
use crate::search::{FoundPairs, engine_of, into_pairs, is_long, threads_for};
use crate::shifted::by_shift;

/// Memory and candidates that are kept between searches.
#[pyclass(module = "fdem._fdem")]
#[derive(Debug)]
pub(crate) struct Buffered {
    engine: String,
    threads: usize,
    buffer: f64,
    stop: Stop,
    /// A `Search<T, D>` or a `PeriodicBuffered<T, D>`, of the elements that came last.
    search: Option<(NumberKind, Box<dyn Any + Send + Sync>)>,
}

#[pymethods]
impl Buffered {
    #[new]
    fn new(buffer: f64, engine: String, threads: usize) -> PyResult<Self> {
        engine_of(&engine)?;
        // A bad buffer is an error now, and not at the first update.
        Search::<f64, 3>::new(buffer).map_err(Problem::from)?;
        Ok(Self { engine, threads, buffer, stop: Stop::default(), search: None })
    }

    /// The couples that touch now with their shifts, and why there was a new detection if there was one.
    fn update<'py>(
        &mut self,
        py: Python<'py>,
        elements: &Elements,
    ) -> PyResult<(FoundPairs<'py>, Option<String>)> {
        let engine = engine_of(&self.engine)?;
        let (threads, buffer, stop) = (self.threads, self.buffer, self.stop.clone());
        with_kind!(elements.kind, T, D => {
            let held = elements.hold::<T>(py)?;
            let set = held.set::<D>(elements)?;
            let cell = elements.cell::<T, D>()?;
            let n = set.points.len();
            let threads = threads_for(threads, n);
            let search = &mut self.search;
            let (couples, shifts, reason) = interrupt::run(py, is_long(n) || cell.is_some(), &self.stop, || {
                let checked = set.checked()?;
                // An update that fails leaves no search behind.
                let before = search.take().filter(|(kind, _)| *kind == elements.kind).map(|(_, search)| search);
                let (couples, shifts, reason, after) = match &cell {
                    None => {
                        let mut follows: Box<Search<T, D>> = if let Some(Ok(follows)) = before.map(<Box<dyn Any + Send + Sync>>::downcast) {
                            follows
                        } else {
                            let detector = Detector::new().with_engine(engine).with_threads(threads)?.stopped_by(stop);
                            let new = Search::with_search(detector, T::nearest(buffer))?;
                            Box::new(new.with_threads(threads)?)
                        };
                        let mut couples = Vec::new();
                        let update = follows.update(&checked)?;
                        let reason = update.reason();
                        update.couples(&mut couples)?;
                        (couples, Vec::new(), reason, follows as Box<dyn Any + Send + Sync>)
                    }
                    Some(cell) => {
                        let mut follows: Box<PeriodicBuffered<T, D>> = if let Some(Ok(follows)) = before.map(<Box<dyn Any + Send + Sync>>::downcast) {
                            follows
                        } else {
                            let search = PeriodicSearch::new().with_engine(engine).with_threads(threads)?.stopped_by(stop);
                            Box::new(PeriodicBuffered::with_search(search, T::nearest(buffer))?)
                        };
                        let mut couples = Vec::new();
                        let reason = follows.update(&checked, cell, &mut couples)?;
                        let (couples, shifts) = by_shift(couples)?;
                        (couples, shifts, reason, follows as Box<dyn Any + Send + Sync>)
                    }
                };
                *search = Some((elements.kind, after));
                Ok((couples, shifts, reason.map(|reason| reason.to_string())))
            })?;
            let rows = shifts.len();
            let shifts = shifts.into_flattened().into_pyarray(py).reshape([rows, D])?;
            Ok(((into_pairs(py, couples)?, shifts), reason))
        })
    }
}
