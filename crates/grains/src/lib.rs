//! Spheres and walls: the discrete element method (Cundall and Strack 1979) with the laws of Hertz, Mindlin
//! and Hooke, rolling friction and adhesion.
//!
//! | to change | open |
//! |---|---|
//! | the force of a contact | `src/law.rs`; damping: `src/restitution.rs`, adhesion: `src/adhesion.rs` |
//! | the shape or the motion of a wall | `src/wall.rs`; walls that keep up a force: `src/servo.rs` |
//! | clumps | `src/clump.rs`: mass and inertia, `src/clump_shape.rs`: many of one shape, `src/clump_checks.rs`, `src/run/clumps.rs`: motion, `src/rotation.rs` |
//! | contacts with triangles and segments | `src/sheets.rs`: how many; `src/run/on_facet.rs`: forces and histories of one sphere; `src/run/on_surface.rs`: lists, threads, sums; `src/run/on_meshes.rs`: walls that are meshes |
//! | geometry of facets | `src/facet.rs`, `src/ridges.rs`: neighbours, `src/tree.rs`: facets near a place |
//! | spheres that come in and boxes that remove them | `src/insertion.rs`, their ranges: `src/insertion_checks.rs` |
//! | forces by a law of the caller | `src/sphere_law.rs`; in a step: `src/run/by_program.rs` |
//! | a number of the model, and its range | `src/model.rs`, `src/material.rs` |
//! | packings: random places, sizes of spheres, regions | `src/pack.rs` and the files below `src/pack` |
//! | overlaps at the beginning | `src/gaps.rs` |
//! | the time step | `src/time_step.rs` |
//! | the course of a step, neighbours, threads, states that are saved | `src/run.rs`; walls in it: `src/run/on_walls.rs` |
//! | the box and its servo | `src/domain.rs`, its ranges: `src/domain_checks.rs`; `src/run/cell.rs`, `src/run/box_servo.rs` |
//! | vector instructions | `src/run/level.rs`; the law in them: `src/run/batch.rs` |
//!
//! Files import from those above them in this order: `vector`, `rotation`, `restitution`, `adhesion`,
//! `material`, `law`, `servo`, `wall`, `columns`, `clump`, `clump_shape`, `error`, `sphere_law`, `insertion`,
//! `model`, `clump_checks`, `domain_checks`, `insertion_checks`, `time_step`, `facet`, `ridges`, `sheets`,
//! `tree`, `surface`, `pack`, `gaps`, `run`; the front page of `run` lists the files below it.

mod adhesion;
mod clump;
mod clump_checks;
mod clump_shape;
mod columns;
mod domain;
mod domain_checks;
mod error;
mod facet;
mod gaps;
mod insertion;
mod insertion_checks;
mod law;
mod material;
mod model;
mod pack;
mod restitution;
mod ridges;
mod rotation;
mod run;
mod servo;
mod sheets;
mod sphere_law;
mod surface;
mod time_step;
mod tree;
mod vector;
mod wall;

pub use clump::{Clump, ClumpInertia};
pub use clump_shape::{ClumpShape, random_turns};
pub use columns::{GrainContact, GrainPartner, SphereColumns};
pub use domain::{BoxServo, Domain, Outside};
pub use error::GrainError;
pub use gaps::{spheres_in_box, worst_in_body, worst_on_wall, worst_overlap};
pub use insertion::{Insertion, Removal};
pub use law::ContactHistory;
pub use material::{ForceLaw, GrainMaterial, Surfaces};
pub use model::{GrainModel, Spheres};
pub use pack::closed::ClosedSurface;
pub use pack::region::PackRegion;
pub use pack::sizes::SphereSizes;
pub use pack::{PackAmount, PackError, PackRequest, Packed, pack};
pub use run::GrainRun;
pub use run::energies::GrainEnergies;
pub use run::state::GrainState;
pub use servo::Servo;
pub use sphere_law::{SphereLaw, SphereLawOptions, SpherePairs};
pub use surface::Surface;
pub use wall::{Wall, WallRotation, WallShape};
