//! Sweeps: many runs of one model, each in a separate process, while other threads of Python run.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use fdem::sweep::{MOST_RUNS, Request};
use pyo3::prelude::*;

use crate::interrupt::{self, Stop};
use crate::problem::Problem;

/// The number of the signal of Ctrl-C.
const INTERRUPT: i32 = 2;

/// Runs a sweep, and returns its folder. When a handler of a signal raises, the runs write their checkpoints
/// and end, and the exception is raised. `text`: the sweep file; `place`: where it is, or would be;
/// `program`: the command `fdem`, a program and its first arguments.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "they are options of the command")]
pub(crate) fn sweep(
    py: Python<'_>,
    text: String,
    name: String,
    place: PathBuf,
    output: Option<PathBuf>,
    processes: Option<usize>,
    threads: Option<usize>,
    most: Option<usize>,
    force: bool,
    skip_refused: bool,
    quiet: bool,
    program: Vec<OsString>,
) -> PyResult<PathBuf> {
    let most = most.unwrap_or(MOST_RUNS);
    let request =
        Request { text, name, place, output, processes, threads, most, force, skip_refused, quiet, program };
    let stop = Stop::default();
    let flag = Stop::clone(&stop);
    interrupt::run(py, true, &stop, move || {
        let mut asked = || flag.load(Ordering::Relaxed).then_some(INTERRUPT);
        let done = fdem::sweep::sweep(&request, &mut asked).map_err(Problem::Arguments)?;
        Ok(done.folder)
    })
}

/// A material by its name, with its keys and their values.
type Named = (String, Vec<(String, f64)>);

/// The library of materials.
#[pyfunction]
pub(crate) fn materials() -> Vec<Named> {
    fdem::model::library().iter().map(|material| (material.name.clone(), material.keys.clone())).collect()
}
