//! Results of simulations for ParaView: the state of a mesh at one time, and the list of files by time.
//!
//! Cracks are lines, contacts are points: [`write_poly_vtp`] writes both.

mod appended;
mod poly;
mod pvd;
mod vti;
mod vtu;

pub use poly::write_poly_vtp;
pub use pvd::pvd;
pub use vti::write_vti;
pub use vtu::write_vtu;
