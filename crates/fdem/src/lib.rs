//! fdem: contact detection and the combined finite-discrete element method.
//!
//! This crate is the library of the `fdem` command. It analyses contact networks ([`network`], [`analysis`])
//! and draws them ([`picture`], [`report`]). It reads model files ([`model`]) and writes the results of
//! simulations ([`results`]). It uses these crates:
//! - [`contact`] finds the couples of elements that touch (package `fdem-contact`);
//! - [`distributed`] finds them over many processes (package `fdem-distributed`);
//! - [`io`] reads packings and meshes and writes couples in the formats of the field (package `fdem-io`);
//! - [`scenes`] generates packings from seeds (package `fdem-scenes`);
//! - [`simulation`] simulates bodies that deform, collide and break (package `fdem-simulation`).
//!
//! A program that only needs couples can depend on `fdem-contact` alone, whose only dependency, rayon, is
//! optional.
//!
//! # How it is built
//!
//! `src/model` reads a model file. `Document` finds the place of every key for messages. The types of
//! `src/model/file.rs` define the keys; their comments become the descriptions of the schema and the page of
//! the book that lists every key. `prepare` checks, meshes and numbers, and returns a
//! `fdem_simulation::Model`. `src/command/run.rs` is the loop around `Simulation::advance`: frames, history,
//! checkpoints, signals. It hands results to `src/command/run/writer.rs`, a thread that writes them in the
//! order of the steps. A model and a run are generic in the dimensions as well:
//! `src/model/dimensions/differences.rs` and `src/command/run/results.rs` hold the differences.
//! `crates/results/src/run`, and for three dimensions `crates/results/src/space`, turn snapshots into bytes
//! and text and know no paths; only `src/command/run/folder.rs` writes into a folder of results.
//!
//! # Layers
//!
//! Files import only from the layers below: the command, at the top, uses `validate` and `model`, and
//! `validate` uses `model`. In `model`, from the bottom: the document, its faults and its keys (`fault`,
//! `document`, `file`); shapes and their sizes (`outline`, `limits`, `extent`); meshes of bodies
//! (`mesh_file`, `plane`, `space`); bodies put together (`bodies`, `boundaries`, `sizes`); warnings;
//! `prepare`. In `command`, from the bottom: options; input and output; searches (`detect`, `verify`); tasks.
//! A test in `tests/docs/layers.rs` finds circles.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | how `contacts` searches a packing, and writes the results | `src/command/packing.rs`, `src/command/detect.rs`, `src/command/verify.rs`, `src/command/outputs.rs` |
//! | searches on many ranks under `mpirun` | `src/command/ranks.rs`, `src/command/ranks_contacts.rs` |
//! | several files on the command line, bodies over several files | `src/command/meshes.rs`, `src/command/mesh_summary.rs` |
//! | reading and writing several frames | `src/command/series.rs`, `src/command/series_table.rs`, `src/command/frames.rs`, `src/command/tables.rs` |
//! | an option of the command | `src/command/args.rs`, then the task: `src/command/contacts.rs`, `src/command/bench.rs`, `src/command/generate.rs` |
//! | how the commands read and refuse a packing | `src/command/input.rs` |
//! | periodic boxes: the options, and the box of a file | `src/command/periodic.rs` |
//! | formats of output, and their names | `src/command/output.rs`, `src/command/tables.rs`; a format: its file in `crates/io/src/written` |
//! | files that are written aside, progress on the terminal | `src/command/aside.rs`, `src/command/progress.rs` |
//! | the summary and its JSON | `src/command/summary.rs` |
//! | options for pictures | `src/command/args/drawings.rs`, `src/command/drawings.rs` |
//! | a key of the model file | `src/model/file.rs` and the files below `src/model/file`; then `BLESS=1 cargo test -p fdem --test docs` |
//! | expressions, units, parameters | `src/model/values.rs`; the unit of a key is `x-unit` beside it in `src/model/file` |
//! | the library of materials | `src/model/library.toml`, `src/model/library.rs`, `src/command/materials.rs`; then `BLESS=1 cargo test -p fdem --test docs` |
//! | values that are set from outside, `--set` | `src/model/set.rs` |
//! | included files; copies of a body | `src/model/included.rs`; `src/model/repeat.rs` |
//! | templates of `fdem new` | `src/command/templates.rs` |
//! | bounds on numbers, size and memory before meshing | `src/model/limits.rs`, `src/model/far.rs`, `src/model/sizes.rs`, `src/model/extent.rs`, `src/command/memory.rs` |
//! | warnings of `check` | `src/model/warnings.rs`, `locking.rs`, `plausible.rs`, `joined.rs`, `connected.rs`, `slivers.rs`, `equilibrium.rs` beside it; advice for quasi-static runs: `src/model/quasi_static.rs` |
//! | mass scaling | `src/model/scaling.rs`, `src/model/scaled.rs`, `src/command/run/quasi_static.rs`; how much a node needs: `crates/simulation/src/mass.rs` |
//! | joint sets: keys and laws, lines, files of lines | `src/model/joint_sets.rs`, `src/model/joint_lines.rs`, `src/model/polylines.rs` |
//! | joint sets in space: polygons, files of polygons | `src/model/joint_planes.rs`, `src/model/polygons.rs` |
//! | errors in a model file | `src/model/fault.rs`, `src/model/document.rs` |
//! | shapes of bodies, and their meshes | `src/model/bodies.rs`; flat ones: `src/model/plane.rs`, `src/model/packing.rs`, `crates/mesh/src/triangles.rs`; in space: `src/model/space.rs`, `crates/mesh/src/shapes.rs`, `crates/mesh/src/tetrahedra.rs`; smaller elements near places: `src/model/refine.rs`, `crates/mesh/src/grading.rs` |
//! | output and warnings of `fdem check` | `src/model/preflight.rs`, `src/model/warnings.rs`; with `--ranks`: `src/model/on_ranks.rs` |
//! | the loop of a run, its folder, its messages | `src/command/run.rs`, `src/command/run/course.rs`, `src/command/run/observer.rs`, `src/command/run/writer.rs`, `src/command/run/recorder.rs`, `src/command/run/folder.rs`, `src/command/run/told.rs` |
//! | stages of a run | `src/model/stages.rs`, `src/command/run/stages.rs` |
//! | conditions that end a run or a stage, servos | `src/model/conditions.rs` |
//! | a run that begins with the end of another | `src/command/run/earlier.rs` |
//! | bonds between bodies | `src/model/bonds.rs` |
//! | sweeps: their file, values, processes, folder, table, page | `src/command/sweep/plan.rs`, `src/command/sweep/values.rs`, `src/command/sweep/children.rs`, `src/command/sweep/store.rs`, `src/command/sweep/table.rs`, `src/command/sweep/report.rs` |
//! | runs that a program holds, as the Python package does | `src/command/session.rs` |
//! | histories of probes, curves, acoustic emission | `src/model/probes.rs`, `src/model/curves.rs`, `src/command/run/emission.rs` |
//! | a case of the verification ladder, its bound | `src/validate.rs`, and its file in `src/validate` |
//!
//! There is no log by tracing: `run.log` has the few lines that a run prints.

#![allow(private_bounds, reason = "bodies are of triangles or of tetrahedra; nobody else can make others")]

pub mod command;
pub mod model;
mod state_hash;
mod validate;

pub use command::{session, sweep};
pub use fdem_contact as contact;
pub use fdem_distributed as distributed;
pub use fdem_io as io;
pub use fdem_mesh as mesh;
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
