//! Tests of spheres, by subject.

#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

/// Boxes that keep up a pressure.
mod boxes;
/// Forces between spheres by a law of the caller.
mod by_program;
/// Clumps of spheres.
mod clumps;

/// Contacts with triangles and segments.
mod facets;
/// The eight tests of Chung and Ooi (2011), and others with analytic answers.
mod impacts;
mod packings;
/// Rolling friction, adhesion.
mod rolling;
/// States, threads, models that are refused.
mod runs;
/// Shapes and motions of walls, servos.
mod walls;
