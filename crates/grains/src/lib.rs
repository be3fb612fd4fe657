//! Spheres and walls: the discrete element method (Cundall and Strack 1979) with the laws of Hertz, Mindlin
//! and Hooke, rolling friction and adhesion.
//!
//! | to change | open |
//! |---|---|
//! | the force of a contact | `src/law.rs`; damping: `src/restitution.rs`, adhesion: `src/adhesion.rs` |
//! | the shape or the motion of a wall | `src/wall.rs` |
//! | a number of the model, and its range | `src/model.rs`, `src/material.rs` |
//! | the course of a step, neighbours, threads, states that are saved | `src/run.rs` |
//!
//! Files import from those above them in this order: `vector`, `restitution`, `adhesion`, `material`, `law`,
//! `wall`, `error`, `model`, `run`.

mod adhesion;
mod error;
mod law;
mod material;
mod model;
mod restitution;
mod run;
mod vector;
mod wall;

pub use error::GrainError;
pub use law::ContactHistory;
pub use material::{ForceLaw, GrainMaterial, Surfaces};
pub use model::{GrainModel, Spheres};
pub use run::{GrainContact, GrainEnergies, GrainPartner, GrainRun, GrainState};
pub use wall::{Wall, WallRotation, WallShape};
