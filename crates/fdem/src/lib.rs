//! fdem: contact detection and the combined finite-discrete element method.
//!
//! This crate is the library of the `fdem` command. It searches packings and meshes for contacts, runs
//! models, and writes the files of results. It uses these crates, and re-exports them:
//! - [`contact`] finds the couples of elements that touch (package `fdem-contact`);
//! - [`distributed`] finds them over many processes (package `fdem-distributed`);
//! - [`io`] reads packings and meshes and writes couples in the formats of the field (package `fdem-io`);
//! - [`scenes`] generates packings from seeds (package `fdem-scenes`);
//! - [`simulation`] simulates bodies that deform, collide and break (package `fdem-simulation`);
//! - [`model`] reads model files (package `fdem-model`);
//! - [`results`] draws and analyses contact networks and simulations (package `fdem-results`):
//!   [`network`], [`analysis`], [`picture`], [`report`].
//!
//! The cases of `fdem validate` are in the package `fdem-validate`.
//!
//! A program that only needs couples can depend on `fdem-contact` alone, whose only dependency, rayon, is
//! optional.
//!
//! # How it is built
//!
//! `src/command/contacts.rs` reads a packing, searches it and writes the couples. `src/command/run.rs` is the
//! loop around `Simulation::advance`: frames, history, checkpoints, signals. It hands results to
//! `src/command/run/writer.rs`, a thread that writes them in the order of the steps. A run is generic in the
//! dimensions: `src/command/run/results.rs` holds the differences.
//! `crates/results/src/run`, and for three dimensions `crates/results/src/space`, turn snapshots into bytes
//! and text and know no paths; only `src/command/run/folder.rs` writes into a folder of results.
//!
//! # Layers
//!
//! Files import only from the layers below. From the bottom: options; input and output; searches (`detect`,
//! `verify`); tasks. A test in `tests/docs/layers.rs` finds circles.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | how `contacts` searches a packing, and writes the results | `src/command/packing.rs`, `src/command/outputs.rs`, `crates/results/src/detection.rs` |
//! | couples that are taken from a file | `src/command/couples.rs`, `crates/io/src/series/dump_local.rs` |
//! | searches on many ranks under `mpirun` | `src/command/ranks.rs`, `src/command/ranks_contacts.rs` |
//! | several files on the command line, bodies over several files | `src/command/meshes.rs`, `src/command/mesh_summary.rs` |
//! | files that a collection lists | `src/command/pieces.rs`, `crates/io/src/series/collection.rs` |
//! | reading and writing several frames | `src/command/series.rs`, `src/command/series_table.rs`, `src/command/frames.rs`, `src/command/tables.rs` |
//! | an option of the command | `src/command/args.rs`, then the task: `src/command/contacts.rs`, `src/command/bench.rs`, `src/command/generate.rs` |
//! | how the commands read and refuse a packing | `src/command/input.rs` |
//! | periodic boxes: the options, and the box of a file | `src/command/periodic.rs` |
//! | formats of output, and their names | `src/command/output.rs`, `src/command/tables.rs`; a format: its file in `crates/io/src/written` |
//! | files that are written aside, progress on the terminal | `src/command/aside.rs`, `src/command/progress.rs` |
//! | the summary and its JSON | `src/command/summary.rs` |
//! | options for pictures | `src/command/args/drawings.rs`, `src/command/drawings.rs` |
//! | templates of `fdem new` | `src/command/templates.rs` |
//! | the loop of a run, its folder, its messages | `src/command/run.rs`, `src/command/run/course.rs`, `src/command/run/observer.rs`, `src/command/run/writer.rs`, `src/command/run/recorder.rs`, `src/command/run/folder.rs`, `src/command/run/log.rs` |
//! | model files: keys, checks, meshes | the front page of `crates/model` |
//! | a case of the verification ladder | the front page of `crates/validate` |
//! | stages of a run; conditions that end it | `src/command/run/stages.rs`, `src/command/run/course.rs` |
//! | memory of a run; the list of materials; acoustic emission | `src/command/memory.rs`; `src/command/materials.rs`; `src/command/run/emission.rs` |
//! | a run that begins with the end of another | `src/command/run/earlier.rs` |
//! | sweeps: their file, values, processes, folder, table, page | `src/command/sweep/plan.rs`, `src/command/sweep/values.rs`, `src/command/sweep/children.rs`, `src/command/sweep/store.rs`, `src/command/sweep/table.rs`, `src/command/sweep/report.rs` |
//! | runs that a program holds, as the Python package does | `src/command/session.rs` |
//!
//! There is no log by tracing: `run.log` has the few lines that a run prints.

#![allow(private_bounds, reason = "bodies are of triangles or of tetrahedra; nobody else can make others")]

pub mod command;
mod state_hash;

pub use command::device_name::DeviceName;
pub use command::{pieces, session, sweep};
pub use fdem_contact as contact;
pub use fdem_distributed as distributed;
pub use fdem_io as io;
pub use fdem_mesh as mesh;
pub use fdem_model as model;
pub use fdem_results as results;
pub use fdem_results::page::network as report;
pub use fdem_results::{analysis, network, picture};
pub use fdem_scenes as scenes;
pub use fdem_simulation as simulation;
pub use state_hash::state_hash;

/// The Rust code in the README compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct ReadmeDoctests;

/// The Rust code in the book compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../../book/src/quick-start/rust.md")]
pub struct BookDoctests;
