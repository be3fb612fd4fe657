//! Looking at contact networks and at runs: analysis, pictures, plots, animations, files for ParaView, and pages for a browser.
//!
//! [`network`] is what [`analysis`] measures and [`picture`] draws; what a run leaves ([`Frame`], [`History`], [`Pictures`]) is made from snapshots of
//! `fdem-simulation`. [`page`] makes both into pages. This crate makes text and bytes, and knows no paths.

mod arrays;
pub mod network;
pub mod analysis;
pub mod picture;
mod run;
mod space;
pub mod page;

pub use page::run::MOST_FRAMES;
pub use page::run::flat::{MOST_ELEMENTS, Report, SAMPLE};
pub use page::run::space::SpaceReport;
pub use run::*;
pub use space::{Cut, MOST_INSIDE, Shell, Show, SpaceFrame, SpacePictures, SpaceView};
