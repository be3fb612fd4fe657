//! The extension module `fdem._fdem`: the functions of the Rust crates on arrays of NumPy.
//!
//! It is private. The modules of the package, in `python/fdem`, check and convert the arguments of users, and
//! hand over arrays in C order. This module borrows the arrays, searches without the interpreter's lock, and
//! moves the results into arrays of NumPy without a copy.
//!
//! ```text
//! Python ── elements ──┬─ search ──> pairs, shifts ── measure, rows, network, neighbors
//!                      └─ buffered
//! arrays ── index, kdtree, image, mesh; files ── read; words ── command
//! tables ── model ── simulation ──> arrays of the state
//! ```
//!
//! # How it is built
//!
//! `python/fdem` checks and converts arguments and holds the documented interface. The extension module in
//! `src` borrows arrays in C order, searches without the interpreter's lock, and moves its results into NumPy
//! arrays. Couples are one array of two columns, with `i` and `j` as views, because splitting them would take
//! a fifth of a search. Long work runs on another thread while the caller's thread watches for signals.
//! Ctrl-C sets a flag at which every engine stops (`crates/contact/src/stop.rs`, `src/interrupt.rs`). A
//! search reuses the memory of the last one (`src/last_search.rs`), which saves a third of the time.
//!
//! A model that is built in Python becomes the text of a model file (`src/model.rs`), so that it passes the
//! checks of files, with the same messages. A run is a `fdem::session::Session`. Its snapshot moves into
//! NumPy arrays without a copy; `python/fdem/_simulation.py` keeps them until the run changes. Ctrl-C ends
//! `advance` between two steps.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | the Python package: arguments, results | `python/fdem/_input.py`, `python/fdem/_contacts.py` |
//! | the functions of Rust that Python calls | `src/lib.rs`, and its types in `python/fdem/_fdem.pyi` |
//! | neighbour lists and the k-d tree of Python | `src/neighbors.rs`, `src/tree.rs`, `src/kdtree.rs` |
//! | the forms of ASE, SciPy and freud | `python/fdem/_ase.py`, `python/fdem/_query.py`, `python/fdem/_neighbors.py` |
//! | files that Python reads | `src/read.rs`, `python/fdem/_read.py` |
//! | models and runs in Python | `src/model.rs`, `src/simulation.rs`, `python/fdem/_model.py`, `python/fdem/_simulation.py`; below them `crates/fdem/src/command/session.rs` |
//! | spheres in Python | `src/spheres.rs`, `python/fdem/_spheres.py`; their laws: `src/sphere_law.rs`, `python/fdem/_sphere_law.py` |
//! | fields of results in Python | `src/fields.rs`, `python/fdem/_fields.py`; the table: `crates/results/src/fields/table.rs` |
//! | sweeps in Python | `src/sweep.rs`, `python/fdem/_sweep.py`; below them `crates/fdem/src/command/sweep.rs` |
//! | folders of results in Python | `python/fdem/_results.py`, `python/fdem/_vtk.py` |
//! | graphics processors in Python | `src/device.rs`; arrays that are there: `src/placed.rs`, `src/dlpack.rs`, `python/fdem/_on_device.py` |
//! | Ctrl-C during a search | `src/interrupt.rs`, `crates/contact/src/stop.rs` |
//! | analysis and pictures in Python | `src/network.rs`, `python/fdem/_analysis.py` |

#![allow(clippy::needless_pass_by_value, reason = "arguments from Python come by value")]

mod interrupt;
mod last_search;
mod number;
mod problem;
mod tasks;

mod device;
mod dlpack;
mod elements;
mod placed;
mod search;
mod shifted;
mod measure;
mod neighbors;
mod network;
mod rows;
mod buffered;

mod fields;
mod image;
mod index;
mod kdtree;
mod mesh;
mod model;
mod read;
mod simulation;
mod sphere_law;
mod spheres;
mod sweep;
mod tree;

use std::ffi::OsString;

use numpy::PyArray1;
use pyo3::prelude::*;

/// Runs the command line `arguments`, of which the first is the program's name, and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| fdem::command::run(arguments))
}

#[pymodule]
fn _fdem(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // Looks NumPy up now: at the first array, Ctrl-C would end that in a panic.
    PyArray1::<f64>::zeros(module.py(), 0, false);
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<elements::Elements>()?;
    module.add_class::<buffered::Buffered>()?;
    module.add_class::<kdtree::PyTree>()?;
    module.add_class::<dlpack::Tensor>()?;
    module.add_function(wrap_pyfunction!(dlpack::dlpack_of_rows, module)?)?;
    #[cfg(feature = "gpu")]
    module.add_class::<placed::DeviceCouples>()?;
    module.add_function(wrap_pyfunction!(placed::contacts_on_device, module)?)?;
    module.add_function(wrap_pyfunction!(search::contacts, module)?)?;
    module.add_function(wrap_pyfunction!(measure::within_cutoffs, module)?)?;
    module.add_function(wrap_pyfunction!(search::verify, module)?)?;
    module.add_function(wrap_pyfunction!(search::explain, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure, module)?)?;
    module.add_function(wrap_pyfunction!(neighbors::neighbor_list, module)?)?;
    module.add_function(wrap_pyfunction!(network::analyse, module)?)?;
    module.add_function(wrap_pyfunction!(network::file, module)?)?;
    module.add_function(wrap_pyfunction!(network::draw, module)?)?;
    module.add_function(wrap_pyfunction!(rows::csr, module)?)?;
    module.add_function(wrap_pyfunction!(rows::coordination, module)?)?;
    module.add_function(wrap_pyfunction!(rows::ascending, module)?)?;
    module.add_function(wrap_pyfunction!(index::within, module)?)?;
    module.add_function(wrap_pyfunction!(index::nearest, module)?)?;
    module.add_function(wrap_pyfunction!(image::labels, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::mesh, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::walls, module)?)?;
    module.add_class::<read::Frames>()?;
    module.add_function(wrap_pyfunction!(read::read, module)?)?;
    module.add_class::<model::PyReady>()?;
    module.add_class::<simulation::PyRun>()?;
    module.add_function(wrap_pyfunction!(fields::fields, module)?)?;
    module.add_function(wrap_pyfunction!(model::to_toml, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::materials, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    Ok(())
}
