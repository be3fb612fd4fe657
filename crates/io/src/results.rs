//! Results of simulations for ParaView: the state of a mesh at one time, and the list of files by time.
//!
//! Cracks are lines, written by [`write_vtp`](crate::write_vtp).

mod appended;
mod pvd;
mod vtu;

pub use pvd::pvd;
pub use vtu::write_vtu;
