//! Tests of the simulation, by subject.

#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod common;

/// Models far from the origin of their coordinates.
mod coordinates;
/// Waves, rotation, gravity; independence of the number of threads.
mod motion;
/// Collisions and friction.
mod contact;
/// Forces and fragments in results.
mod forces;
/// Strength and fracture energy.
mod fracture;
/// Elements whose facets are not checked for failure.
mod awake;
/// Sets of joints with their own laws.
mod joint_sets;
/// Laws of the material besides the neo-Hookean one.
mod laws;
/// Runs that are saved and resumed; runs that stop by themselves.
mod resume;
/// Velocities, forces and factors that a caller sets between steps.
mod actions;
/// Fluid in holes and cracks.
mod fluid;
/// Liquid in pores: consolidation, undrained response, seepage.
mod pores;
/// Pressures in holes and cracks.
mod cavity;
/// Initial stress: stored energy and equilibrium.
mod stress;
/// Bodies of tetrahedra.
mod space;
/// Sources that must not know whether there are two or three dimensions.
mod dimensions;
/// Results on all vector instructions.
mod vectors;
/// Results on many ranks.
mod ranks;
/// Forecasts of runs on many ranks.
mod forecast;
/// Runs that continue with a changed model.
mod changed;
/// Means of stress, strain and velocity, gauges, forces between bodies, reactions.
mod probes;
/// Mass that is added for a longer time step.
mod mass;
/// Models that are refused.
mod refusal;
mod relaxation;
/// Bodies that are rigid.
mod rigid;
/// Bodies that are rigid until they are overloaded.
mod overload;
/// Spheres and walls, alone and with bodies.
mod spheres;
