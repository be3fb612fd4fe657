//! Results of simulations for ParaView: the state of a mesh at one instant, and which file is of which instant.
//!
//! Cracks are lines: [`write_vtp`](crate::write_vtp) has them.

mod appended;
mod pvd;
mod vtu;

pub use pvd::pvd;
pub use vtu::write_vtu;
