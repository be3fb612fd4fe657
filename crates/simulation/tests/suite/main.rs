//! Tests of the simulation, by the kind of failure.

#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

/// Models far from the origin of their coordinates.
mod coordinates;
/// Waves, rotation, gravity; independence of the number of threads.
mod motion;
/// Collisions, friction.
mod contact;
/// Forces and fragments for results.
mod forces;
/// Strength, energy of fracture.
mod fracture;
/// Runs that are saved and resumed; runs that stop by themselves.
mod resume;
/// Models that are refused.
mod refusal;
