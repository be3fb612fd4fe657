//! The extension module `fdem._fdem`: what the Python package takes from the Rust crates, array by array.
//!
//! It is private. The package's own modules, in `python/fdem`, check and convert what users give, and hand over arrays in C order; here they are
//! borrowed, searched without the interpreter's lock, and what is found is moved into arrays of NumPy without a copy.
//!
//! ```text
//! Python ── elements ──┬─ search ──> pairs, shifts ── measure, rows, network
//!                      └─ buffered
//! arrays ── index, image, mesh; files ── read; words ── command
//! ```

#![allow(clippy::needless_pass_by_value, reason = "arguments from Python come by value")]

mod interrupt;
mod kept;
mod number;
mod problem;

mod elements;
mod search;
mod measure;
mod network;
mod rows;
mod buffered;

mod image;
mod index;
mod mesh;
mod read;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line `arguments`, of which the first is the program's name, and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| fdem::command::run(arguments))
}

#[pymodule]
fn _fdem(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<elements::Elements>()?;
    module.add_class::<buffered::Buffered>()?;
    module.add_function(wrap_pyfunction!(search::contacts, module)?)?;
    module.add_function(wrap_pyfunction!(search::verify, module)?)?;
    module.add_function(wrap_pyfunction!(search::explain, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure, module)?)?;
    module.add_function(wrap_pyfunction!(network::analyse, module)?)?;
    module.add_function(wrap_pyfunction!(network::draw, module)?)?;
    module.add_function(wrap_pyfunction!(rows::csr, module)?)?;
    module.add_function(wrap_pyfunction!(rows::coordination, module)?)?;
    module.add_function(wrap_pyfunction!(rows::ascending, module)?)?;
    module.add_function(wrap_pyfunction!(index::within, module)?)?;
    module.add_function(wrap_pyfunction!(index::nearest, module)?)?;
    module.add_function(wrap_pyfunction!(image::labels, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::mesh, module)?)?;
    module.add_function(wrap_pyfunction!(read::read, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    Ok(())
}
