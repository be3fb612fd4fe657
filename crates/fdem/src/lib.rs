//! fdem: contact detection and the combined finite-discrete element method.
//!
//! This crate holds the `fdem` command, as a library, and what it says of contact networks ([`network`], [`analysis`]) and shows of them ([`picture`], [`report`]); the rest is in the crates below:
//! - [`contact`]: which of N elements touch (package `fdem-contact`);
//! - [`io`]: packings in, couples out, in the field's formats (package `fdem-io`);
//! - [`scenes`]: seeded packings (package `fdem-scenes`);
//! - [`simulation`]: bodies that deform, collide and break (package `fdem-simulation`), from the files that [`model`] reads.
//!
//! A program of yours that needs couples depends on `fdem-contact` alone, whose one dependency, rayon, is optional.

pub mod analysis;
pub mod command;
pub mod model;
pub mod network;
mod numbers;
pub mod picture;
pub mod report;
pub mod results;
pub mod validate;

pub use fdem_contact as contact;
pub use fdem_io as io;
pub use fdem_scenes as scenes;
pub use fdem_simulation as simulation;

/// The Rust code in the README compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct ReadmeDoctests;

/// The Rust code in the book compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../../book/src/quick-start/rust.md")]
pub struct BookDoctests;
