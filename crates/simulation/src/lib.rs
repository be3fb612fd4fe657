//! The combined finite-discrete element method in two and three dimensions: bodies of triangles or of tetrahedra that deform, collide and break.
//!
//! A [`Model`] goes in, [`Snapshot`]s and [`Energies`] come out. There is no file, no printing and no time of day in this crate. One step reads from top to bottom in
//! `simulation.rs`; each part is a file:
//!
//! ```text
//! solid (elastic) ─> joints (cohesive) ─> contacts (detection, simplex) ─> seams ─> loads (ground) ─> motion ─> energy
//! ```
//!
//! Types have two parameters: `D` dimensions and `N = D + 1` corners of an element. They are 2 and 3 where nothing is said, so that `Model` is one of triangles and `Model<3, 4>` one
//! of tetrahedra. What differs between the two is in `simplex.rs` and its parts.
//!
//! Results do not depend on the number of threads: elements, joints and contacts store their forces, and every node adds up its forces in a fixed order.
//! A run that is saved and resumed continues bit for bit.
//!
//! # Sources
//! A. Munjiza, *The Combined Finite-Discrete Element Method* (Wiley, 2004); each module says where it departs from the book and why.

#![allow(private_bounds, reason = "elements are triangles or tetrahedra; nobody else can make others")]
#![allow(clippy::needless_range_loop, reason = "axes, ends and corners count through several arrays at once")]

mod model;
mod checks;
mod random;
mod team;
mod vector;
mod simplex;
mod topology;
mod elastic;
mod solid;
mod cohesive;
mod joints;
mod contacts;
mod seams;
mod loads;
mod ground;
mod motion;
mod critical;
mod energy;
mod forces;
mod snapshot;
mod simulation;
mod error;

pub use critical::{Cause, CriticalStep};
pub use energy::{Energies, Term, TermKind};
pub use error::{ModelError, Stop};
pub use fdem_mesh::Mesh;
pub use forces::{ContactForce, Forces};
pub use model::{
    Boundary, ContactOptions, CriticalOpening, FractureOptions, Insertion, Interface, Load, Material, Model,
    Plane, Schedule, Strength, Target, TimeOptions,
};
pub use seams::InitialContacts;
pub use simplex::Element;
pub use simulation::{Counts, Simulation, State, Timings};
pub use snapshot::{Crack, Mode, Snapshot, principal_stresses};
