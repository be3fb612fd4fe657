//! Tests of the fluid, by subject. Numbers of groups are those of the equations on the front page.

#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

/// Flow between rigid walls against analytic solutions.
mod analytic;
/// Cavities with one pressure, gas.
mod cavities;
/// Walls on springs, as a solid would move them.
mod coupled;
/// Bits: order of the cells, saved states.
mod determinism;
/// Flow between cracks and pores.
mod exchange;
/// Fronts, lag, gravity in cells that are not full, walls that move.
mod filling;
/// Leak-off, and the balance of the mass.
mod leak_off;
/// Flow in pores: analytic solutions, mass, bits, refusals.
mod matrix;
/// Models, shapes and steps that are refused.
mod refusals;
/// Random networks and steps.
mod robustness;
/// Cells that are added, corners that have split.
mod renewal;
