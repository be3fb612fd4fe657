//! Model files: from TOML to a [`Model`](fdem_simulation::Model) that can be run.
//!
//! [`prepare`] takes the text of a model file and a function that gives the bytes of the files it names;
//! there are no paths and no terminal here. Errors come back as [`ModelErrors`], all of them together, each
//! with its place in the text. The keys of model files are the types in [`file`](mod@file); [`schema`] is
//! their JSON schema, and [`STARTER`] a model to start from.
//!
//! # How it is built
//!
//! ```text
//! text: included ── document ── library ── values ── schema ── file
//!                                                               │
//!                shapes ── joints ── bodies (a mesh) <──────────┘
//!                                      │
//!                           output, stages ── Prepared ── advice
//! ```
//!
//! `Document` finds the place of every key for messages. The types of `src/text/file.rs` define the keys;
//! their comments become the descriptions of the schema and the page of the book that lists every key.
//! [`prepare`] (`src/prepare.rs`) reads top to bottom: it checks, meshes and numbers, and returns a
//! `fdem_simulation::Model`. A model is generic in the dimensions: `src/bodies/dimensions/differences.rs`
//! and `src/advice/differences.rs` hold the differences.
//!
//! # Layers
//!
//! Each folder imports only from those above it in this table, and each file only from files that do not
//! import it. A test in `crates/fdem/tests/docs/layers.rs` finds circles of files.
//!
//! | folder | content |
//! |---|---|
//! | `src/text` | the text of a model file: keys, places, expressions, schema, errors |
//! | `src/prepared.rs`, `src/prepared` | the model that is ready to run: data only |
//! | `src/shapes` | shapes of bodies, their sizes, and meshed pieces |
//! | `src/joints` | joint sets: lines, planes, bonds between bodies |
//! | `src/bodies` | meshes of bodies, and their materials |
//! | `src/grains.rs`, `src/grains` | spheres and walls |
//! | `src/output` | histories, probes, curves and settings of the output |
//! | `src/stages` | boundaries, conditions and stages |
//! | `src/advice` | warnings, mass scaling, and the output of `fdem check` |
//! | `src/vectors.rs`, `src/initial.rs`, `src/prepare.rs` | checks of the whole file, and `prepare` |
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | a key of the model file | `src/text/file.rs` and the files below `src/text/file`; then `BLESS=1 cargo test -p fdem --test docs` |
//! | expressions, units, parameters | `src/text/values.rs`; the unit of a key is `x-unit` beside it in `src/text/file` |
//! | the library of materials | `src/text/library.toml`, `src/text/library.rs`; then `BLESS=1 cargo test -p fdem --test docs` |
//! | values that are set from outside, `--set` | `src/text/set.rs` |
//! | included files; copies of a body | `src/text/included.rs`; `src/shapes/repeat.rs` |
//! | errors in a model file | `src/text/fault.rs`, `src/text/document.rs` |
//! | bounds on numbers, size and memory before meshing | `src/shapes/limits.rs`, `src/shapes/distant.rs`, `src/bodies/sizes.rs`, `src/shapes/extent.rs` |
//! | shapes of bodies, and their meshes | `src/bodies/build.rs`; flat: `src/bodies/plane.rs`, `src/shapes/packing.rs`, `crates/mesh/src/triangles.rs`; in space: `src/bodies/space.rs`, `crates/mesh/src/shapes.rs`, `crates/mesh/src/tetrahedra.rs` |
//! | smaller elements near places | `src/shapes/refine.rs`, `crates/mesh/src/grading.rs` |
//! | spheres and walls: tables, packings, surfaces of pairs, overlaps | `src/text/file/grains.rs`, `src/text/file/coming.rs`, `src/grains/assemble.rs` and the files beside it; packings: `crates/grains/src/pack.rs` |
//! | materials of bodies | `src/bodies/materials.rs` |
//! | joint sets: keys and laws, lines, files of lines | `src/joints/sets.rs`, `src/joints/lines.rs`, `src/joints/polylines.rs` |
//! | joint sets in space: polygons, files of polygons | `src/joints/planes.rs`, `src/joints/polygons.rs` |
//! | bonds between bodies | `src/joints/bonds.rs` |
//! | loads and motions of boundaries, their schedules, cavities | `src/stages/boundaries.rs`, `schedules.rs` and `cavities.rs` beside it |
//! | fluid in cracks, injections | `src/stages/fluid.rs`, `src/stages/injections.rs`; their columns: `src/output/fluid_columns.rs`; in `fdem check`: `src/advice/fluid.rs` |
//! | liquid in pores | `src/stages/pores.rs`, its surfaces: `src/stages/pore_surfaces.rs`; in `fdem check`: `src/advice/pores.rs` |
//! | places of boundaries and of surfaces of pores: sides, boxes, groups | `src/stages/places.rs` |
//! | stages of a run | `src/stages/resolve.rs`, `crates/fdem/src/command/run/stages.rs` |
//! | supports of rigid bodies that cannot be | `src/stages/supports.rs` |
//! | conditions that end a run or a stage, servos | `src/stages/conditions.rs` |
//! | histories of probes, curves | `src/output/probes.rs`, `src/output/curves.rs` |
//! | output and warnings of `fdem check` | `src/advice/preflight.rs`, `src/advice/warnings.rs` and the files beside it; with `--ranks`: `src/advice/on_ranks.rs`; with `--device`: `src/advice/device_forecast.rs`; the cost of breaking: `src/advice/rehearsal.rs` |
//! | advice for quasi-static runs | `src/advice/quasi_static.rs` |
//! | the part of a model that warnings of stress are about | `src/advice/deforming.rs` |
//! | speeds and numbers with which no run is possible | `src/advice/too_fast.rs`, `src/advice/extreme.rs` |
//! | mass scaling | `src/advice/scaling.rs`, `src/prepared/added_mass.rs`, `crates/simulation/src/mass.rs` |

#![allow(private_bounds, reason = "bodies are of triangles or of tetrahedra; nobody else can make others")]

mod text;
mod prepared;
mod shapes;
mod joints;
mod bodies;
mod grains;
mod output;
mod stages;
mod advice;
mod vectors;
mod initial;
mod prepare;

pub use advice::device_forecast::{Card, DeviceForecast, too_little_memory};
pub use advice::differences::Modelled;
pub use advice::fluid::{FluidForecast, FluidRegime};
pub use advice::locking;
pub use advice::on_ranks::OnRanks;
pub use advice::pores::PoreForecast;
pub use advice::preflight::{Critical, Preflight, Rehearsed, check, steps};
pub use advice::rehearsal::Rehearsal;
pub use bodies::boxes::BodyBox;
pub use bodies::gmsh::stop as stop_gmsh;
pub use fdem_mesh::Quality;
pub use output::curves::columns;
pub use prepare::{prepare, prepare_any, prepare_any_with, prepare_coarse, prepare_within};
pub use prepared::{
    AnyPrepared, Bound, Checkpoint, ComingSpheres, Entered, Group, Joints, Origin, OutputSettings, Prepared,
    PreparedBody, PreparedHistory, PreparedRemoval, PreparedServo, PreparedSpheres, PreparedStage,
    PreparedUntil, Quantity, Reached, Scaled, SphereGroup, open_from_start,
};
pub use stages::present::Present;
pub use text::document::{number, toml_tree, whole};
pub use text::fault::{Drawing, Fault, ModelErrors, nearest};
pub use text::file;
pub use text::included::Load;
pub use text::library::{FromLibrary, LibraryMaterial, library};
pub use text::schema::schema;
pub use text::set::{Setting, with_end_time, with_values};
pub use text::values::constant;

/// A small and complete model to start from, with a comment on every part.
pub const STARTER: &str = include_str!("starter.toml");

/// Like [`STARTER`], in three dimensions.
pub const STARTER_3D: &str = include_str!("starter_3d.toml");
