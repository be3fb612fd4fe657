//! Index:
//! - `ranks`: the calls of a communicator, on threads
//! - `unsafe_code`: unsafe code is in the listed files

#[path = "../common/ranks.rs"]
mod checks;
mod ranks;
mod unsafe_code;
