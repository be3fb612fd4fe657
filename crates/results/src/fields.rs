//! Fields of results: one table of their names, units, signs, colours and values, from which files, pictures
//! and pages are made.
//!
//! ```text
//! QUANTITIES ──┬─> files for ParaView          run/vtk.rs
//!    (table)   ├─> Field ──┬─> frames          run/frame.rs, space/frame.rs
//!              │           ├─> pictures, legends, animations, pages
//!              │           └─> model files, options of the command, their messages
//!              └─> arrays of Python, the page of the book
//! ```
//! A value is computed from a [`State`](state::State): a snapshot of triangles or of tetrahedra, and the
//! forces at its instant.

pub(crate) mod colours;
pub(crate) mod field;
pub(crate) mod liquid;
pub(crate) mod place;
pub(crate) mod quantity;
pub(crate) mod range;
pub(crate) mod sphere_counts;
pub(crate) mod state;
mod stress;
pub(crate) mod table;
mod values;

pub use field::Field;
pub use liquid::LiquidIn;
pub use place::Place;
pub use quantity::{Quantity, QuantityValues, Span};
pub use range::Range;
pub use table::QUANTITIES;

#[cfg(test)]
mod tests;
