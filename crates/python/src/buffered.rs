//! Searches that follow moving elements.

use std::any::Any;

use fdem_contact::{Buffered as Search, Detector, Real};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::elements::Elements;
use crate::interrupt::{self, Stop};
use crate::number::{Kind, with_kind};
use crate::problem::Problem;
use crate::search::{engine_of, into_pairs, is_long, threads_for};

/// Memory and candidates that are kept between searches.
#[pyclass(module = "fdem._fdem")]
#[derive(Debug)]
pub(crate) struct Buffered {
    engine: String,
    threads: usize,
    buffer: f64,
    stop: Stop,
    /// A `Search<T, D>`, of the elements that came last.
    search: Option<(Kind, Box<dyn Any + Send + Sync>)>,
}

#[pymethods]
impl Buffered {
    #[new]
    fn new(buffer: f64, engine: String, threads: usize) -> PyResult<Self> {
        engine_of(&engine)?;
        // Refuses now what it would refuse then.
        Search::<f64, 3>::new(buffer).map_err(Problem::from)?;
        Ok(Self { engine, threads, buffer, stop: Stop::default(), search: None })
    }

    /// The couples that touch now, and why there was a new detection if there was one.
    fn update<'py>(
        &mut self,
        py: Python<'py>,
        elements: &Elements,
    ) -> PyResult<(Bound<'py, PyArray2<u32>>, Option<String>)> {
        let engine = engine_of(&self.engine)?;
        let (threads, buffer, stop) = (self.threads, self.buffer, self.stop.clone());
        with_kind!(elements.kind, T, D => {
            let held = elements.hold::<T>(py)?;
            let set = held.set::<D>(elements)?;
            let n = set.points.len();
            let search = &mut self.search;
            let (couples, reason) = interrupt::run(py, is_long(n), &self.stop, || {
                let checked = set.checked()?;
                // Taken while anything can fail.
                let follows = match search.take() {
                    Some((kind, search)) if kind == elements.kind => search.downcast::<Search<T, D>>().ok(),
                    _ => None,
                };
                let mut follows = if let Some(follows) = follows {
                    follows
                } else {
                    let threads = threads_for(threads, n);
                    let detector = Detector::new(engine).with_threads(threads)?.stopped_by(stop);
                    let new = Search::with_search(detector, T::nearest(buffer))?;
                    Box::new(new.with_threads(threads)?)
                };
                let mut couples = Vec::new();
                let update = follows.update(&checked)?;
                let reason = update.reason().map(|reason| reason.to_string());
                update.couples(&mut couples)?;
                *search = Some((elements.kind, follows));
                Ok((couples, reason))
            })?;
            Ok((into_pairs(py, couples)?, reason))
        })
    }
}
