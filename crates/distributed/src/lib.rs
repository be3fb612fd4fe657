//! Contact detection over many processes and machines.
//!
//! A [`Communicator`] carries bytes between ranks: threads of one process ([`threads`]), or processes under MPI (`mpi`, behind the feature `mpi`).
//!
//! # Unsafe code
//! `src/mpi.rs` calls the MPI library, which is written in C.

mod communicator;
mod launcher;
#[cfg(feature = "mpi")]
pub mod mpi;
pub mod threads;

pub use communicator::{Communicator, Halo, Message, Port};
pub use launcher::launched;
