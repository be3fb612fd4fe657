//! Cases of spheres and walls: the laws of their contacts, and the flow of many of them.

mod data;
mod models;

pub(super) mod adhesion;
pub(super) mod chain;
pub(super) mod collapse;
pub(super) mod conservation;
pub(super) mod hopper;
pub(super) mod impacts;
pub(super) mod list;
pub(super) mod oblique;
pub(super) mod rolling;
pub(super) mod round_robin;
pub(super) mod silo;
pub(super) mod walls;
