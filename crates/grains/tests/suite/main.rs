//! Tests of spheres, by subject.

#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

/// The eight tests of Chung and Ooi (2011), and others with analytic answers.
mod impacts;
/// Rolling friction, adhesion.
mod rolling;
/// States, threads, models that are refused.
mod runs;
