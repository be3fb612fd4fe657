//! What a simulation must do, by what could go wrong.

#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

/// Waves, spin; the same for any number of threads.
mod motion;
/// Collisions, friction.
mod contact;
/// Strength, energy of fracture.
mod fracture;
/// Runs that stop and go on; runs that cannot go on.
mod resume;
/// Models that cannot be.
mod refusal;
