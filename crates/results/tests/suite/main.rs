//! Tests of analysis, frames, pictures and pages from outside, in one program.
//!
//! - `analysis`: numbers of a contact network, against hand-made packings.
//! - `fragments`: the fragments of bodies that broke.
//! - `run`: frames, plots and pages of a run in the plane.
//! - `space_pictures`: pictures of a run in space.
//! - `spheres`: spheres and walls in frames, pictures, pages and files.

mod analysis;
mod fragments;
mod run;
mod space_pictures;
mod spheres;
