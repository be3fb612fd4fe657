//! The verification ladder: cases with known answers, and the answers of the simulation.
//!
//! Each [`Case`] runs one or more models and compares quantities with theory; a [`CaseReport`] holds the
//! comparison. [`table`] and [`html`] show reports.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | a case, its bound | `src/cases.rs`, which lists the cases, and the file of the case beside it; in three dimensions in `src/space` |
//! | a case of spheres and walls | `src/grains/list.rs`, which lists them, and the files beside it |
//! | a case of fluid in cracks | `src/fluid/list.rs`, which lists them, and the files beside it |
//! | published data that cases read | `src/grains/data.rs` |
//! | models that several cases share | `src/models.rs`, `src/rocks.rs` |
//! | the definition of a case, and its verdict | `src/outcome.rs` |
//! | the table and the page of reports | `src/page.rs` |
//! | the tests of the harness | `tests/ladder.rs` |
//!
//! The command `fdem validate` (`crates/fdem/src/command/validate.rs`) runs the cases.

mod arch;
mod bedding;
mod brazilian;
mod cantilever;
mod cases;
mod cavity;
mod compliance;
mod compression;
mod debris;
mod disc;
mod excavation;
mod fluid;
mod free_crack;
mod free_shear;
mod grains;
mod ground;
mod heaps;
mod hertz;
mod hole;
mod impact;
mod incline;
mod models;
mod outcome;
mod page;
mod rigid_heap;
mod ring;
mod rocking;
mod rocks;
mod rotation;
mod shear;
mod space;
mod tension;
mod wave;

pub use cases::cases;
pub use outcome::{Case, CaseReport, Measure, Outcome, Size};
pub use page::{html, table};
