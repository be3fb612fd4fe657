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
/// Initial stress: what it stores, and what keeps it.
mod stress;
/// Models that are refused.
mod refusal;
