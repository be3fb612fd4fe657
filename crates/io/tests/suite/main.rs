//! Tests of the readers and writers from outside, in one program.
//!
//! - `good_files`: packings of every format, of other programs, and at full size.
//! - `bad_files`: inputs that must be refused, and how the error names the place.
//! - `series`: files of several frames.
//! - `label_images`: images of bodies.
//! - `properties`: laws that hold for any packing (proptest).
//! - `written_files`, `results`: tables and meshes that are written.
//! - `../meshes.rs`, `../written_memory.rs`: separate programs, because they measure allocated memory.

mod bad_files;
mod collections;
mod good_files;
mod label_images;
mod properties;
mod results;
mod series;
mod written_files;
