//! The combined finite-discrete element method in two dimensions: bodies that deform, collide and break.
//!
//! A [`Model`] goes in, [`Snapshot`]s and [`Energies`] come out. There is no file, no printing and no time of day in this crate. One step reads from top to bottom in
//! `simulation.rs`; each of its lines is a file:
//!
//! ```text
//! solid (elastic) ─> joints (cohesive) ─> contacts (detection, potential) ─> loads ─> motion ─> energy
//! ```
//!
//! Results do not depend on the number of threads: what elements, joints and contacts do is written down by each, and every node gathers its forces in one order.
//! A run that was saved and resumed goes on bit for bit.
//!
//! # Sources
//! A. Munjiza, *The Combined Finite-Discrete Element Method* (Wiley, 2004); where this crate departs from it, the module says why.

#![allow(clippy::needless_range_loop, reason = "axes, ends and corners count through several arrays at once")]

mod model;
mod checks;
mod random;
mod team;
mod topology;
mod elastic;
mod solid;
mod cohesive;
mod joints;
mod potential;
mod contacts;
mod loads;
mod motion;
mod critical;
mod energy;
mod snapshot;
mod simulation;
mod error;

pub use critical::{Cause, CriticalStep};
pub use elastic::principal_stresses;
pub use energy::Energies;
pub use error::{ModelError, Stop};
pub use model::{
    Boundary, ContactOptions, CriticalOpening, FractureOptions, Insertion, Interface, Load, Material, Mesh,
    Model, Plane, Schedule, Strength, Target, TimeOptions,
};
pub use simulation::{Counts, Simulation, State, Timings};
pub use snapshot::{Crack, Mode, Snapshot};
