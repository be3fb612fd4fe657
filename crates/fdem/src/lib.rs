//! fdem: contact detection and the combined finite-discrete element method.
//!
//! This crate is the library of the `fdem` command. It analyses contact networks ([`network`], [`analysis`]) and draws them ([`picture`], [`report`]). It reads
//! model files ([`model`]) and writes the results of simulations ([`results`]). It uses these crates:
//! - [`contact`] finds the couples of elements that touch (package `fdem-contact`);
//! - [`io`] reads packings and meshes and writes couples in the formats of the field (package `fdem-io`);
//! - [`scenes`] generates packings from seeds (package `fdem-scenes`);
//! - [`simulation`] simulates bodies that deform, collide and break (package `fdem-simulation`).
//!
//! A program that only needs couples can depend on `fdem-contact` alone, whose only dependency, rayon, is optional.

#![allow(private_bounds, reason = "bodies are of triangles or of tetrahedra; nobody else can make others")]

pub mod command;
pub mod model;
mod validate;

pub use fdem_contact as contact;
pub use fdem_io as io;
pub use fdem_mesh as mesh;
pub use fdem_results as results;
pub use fdem_results::page::network as report;
pub use fdem_results::{analysis, network, picture};
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
