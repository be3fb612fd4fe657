//! Contact detection over many processes and machines.
//!
//! A [`Communicator`] carries bytes between ranks: threads of one process ([`threads`]), or processes under MPI (`mpi`, behind the feature `mpi`).
//!
//! # Unsafe code
//! `src/mpi.rs` calls the MPI library, which is written in C.

mod communicator;
pub mod curve;
mod error;
mod launcher;
#[cfg(feature = "mpi")]
pub mod mpi;
mod search;
pub mod threads;
mod wire;

pub use communicator::{Communicator, Halo, Message, Port};
pub use error::Error;
pub use launcher::launched;
pub use search::{DistributedSearch, Shapes, Statistics};
