//! Everything that a run is continued from.

use serde::{Deserialize, Serialize};

use crate::run::balls::SavedBall;
use crate::run::cell::BoxMotion;
use crate::run::clumps::ClumpMotion;
use crate::run::energies::Gone;
use crate::run::lists::Remembered;
use crate::run::on_surface::OnFacets;
use crate::run::on_walls::OnWall;
use crate::servo::ServoMotion;
use crate::vector::Vector;

/// The state of a run after a step. It continues with the same bits on any number of threads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrainState {
    pub(crate) step: u64,
    /// Gravity now, m/s².
    pub(crate) gravity: Vector,
    pub(crate) spheres: Vec<SavedBall>,
    /// Number of the next sphere that comes in, and how many each insertion has placed.
    pub(crate) next: u32,
    pub(crate) placed: Vec<u32>,
    pub(crate) contacts: Remembered,
    pub(crate) on_walls: Vec<OnWall>,
    pub(crate) on_meshes: Vec<OnFacets>,
    pub(crate) on_bodies: OnFacets,
    pub(crate) has_bodies: bool,
    pub(crate) servos: Vec<ServoMotion>,
    pub(crate) cell: BoxMotion,
    pub(crate) gone: Gone,
    pub(crate) clumps: Vec<ClumpMotion>,
}
