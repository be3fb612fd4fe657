//! Contact detection over many processes and machines.
//!
//! ```text
//! elements of each rank ─> owners along Hilbert's curve ─> ghosts ─> fdem-contact on each rank ─> couples in order over the ranks
//!                                      │
//!                    Communicator: threads of one process, or processes under MPI
//! ```
//!
//! A rank is a process with a part of the elements. [`DistributedSearch`] finds the couples that one process
//! would find, to the last bit, and no rank holds all elements or all couples.
//! `mpirun -n 8 fdem contacts big.npy --output couples.npy` runs it.
//!
//! | for | use |
//! |---|---|
//! | the couples of elements that are spread over ranks, in open space or in a periodic box | [`DistributedSearch`] |
//! | ranks that are threads, without MPI | [`threads::run`] |
//! | ranks that are processes of `mpirun` | `World` of the crate `fdem-mpi` |
//! | to exchange bytes between ranks | [`Communicator`], [`Halo`] |
//! | to exchange values | [`mod@wire`] |
//! | to divide anything that has places among ranks | [`curve`] |
//! | to know whether a launcher has started several processes, also without MPI | [`launched`] |
//!
//! # How it is built
//! A communicator carries bytes, and nothing else of this crate knows MPI. Ranks that are threads have
//! channels, which close when a rank ends, so that nobody waits for it forever. Under MPI, sparse exchanges
//! count their messages first, and halos are persistent requests.
//!
//! A search first sends each element to its owner. Each rank counts its elements by cells of a coarse grid,
//! which are divided along Hilbert's curve so that all ranks get similar numbers of elements; a few sums over
//! all ranks suffice, and no rank sees the keys of others. A cell is divided by finer keys if a splitter
//! falls into it and the cell is too large for one rank. Elements arrive in runs of neighbouring cells, which
//! keeps the search in cache. Couples are divided in the same way, by ids.
//!
//! Each rank then sends ghosts. The larger of two elements goes to the rank of the smaller one, so that large
//! elements do not attract all small ones; sizes are compared by powers of two. Between elements of one power
//! of two, one of the two ranks gets the ghosts. Therefore every couple is found on exactly one rank.
//!
//! In a periodic box, wrapped elements have owners, and ghosts are displaced by whole edges. A displaced
//! ghost is widened by more than all rounding, and each couple with it is decided again by the comparison of
//! [`PeriodicSearch`](fdem_contact::PeriodicSearch): the element with the smaller id, against the image of
//! the other.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | the messages between ranks | `src/communicator.rs`; ranks that are threads: `src/threads.rs`; MPI: `crates/mpi/src/lib.rs` |
//! | variables by which launchers are recognised | `src/launcher.rs` |
//! | which rank owns an element | `src/search/owners.rs`, `src/search/runs.rs`, `src/division.rs`, `src/curve.rs`; the curve itself: `crates/mesh/src/curve.rs` |
//! | which rank gets a ghost, groups, images | `src/search/ghosts.rs` |
//! | which rank keeps a couple | `search` in `src/search.rs` |
//! | the order of couples over the ranks | `src/search/couples.rs` |
//! | elements as bytes | `src/search/elements.rs`; any value as bytes: `src/wire.rs` |
//! | errors, which all ranks return | `src/error.rs` |
//! | the command on several ranks | `crates/fdem/src/command/ranks.rs`, `crates/fdem/src/command/ranks_contacts.rs` |
//! | tests under `mpirun` | `crates/mpi/tests/mpirun.sh`, `crates/mpi/tests/mpi.rs`; checks for threads and processes alike: `tests/common` |
//!
//! # Limits
//! Ids have 32 bits, so a search has at most 4,294,967,294 elements. Filters of `fdem-contact` (bodies,
//! groups) are not supported.

mod communicator;
pub mod curve;
mod division;
mod error;
mod launcher;
mod search;
pub mod threads;
pub mod wire;

pub use communicator::{Communicator, Halo, Message, Port, check_messages, check_other};
pub use error::Error;
pub use launcher::{launched, launched_rank};
pub use search::{DistributedSearch, Shapes, Statistics};
