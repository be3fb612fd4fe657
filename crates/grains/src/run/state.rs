//! Everything that a run is continued from.

use serde::{Deserialize, Serialize};

use crate::error::GrainError;
use crate::model::GrainModel;
use crate::run::balls::SavedBall;
use crate::run::by_program::SavedLaw;
use crate::run::cell::BoxMotion;
use crate::run::clumps::ClumpMotion;
use crate::run::depth::Depth;
use crate::run::energies::Gone;
use crate::run::lists::Remembered;
use crate::run::on_surface::OnFacets;
use crate::run::on_walls::OnWall;
use crate::servo::ServoMotion;
use crate::vector::Vector;
use crate::wall::{Wall, WallShape};

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
    pub(crate) deepest: Depth,
    pub(crate) clumps: Vec<ClumpMotion>,
    /// The memory of a law of the caller, if there was one.
    pub(crate) by_program: Option<SavedLaw>,
}

impl GrainState {
    /// Number of spheres.
    pub fn count(&self) -> usize {
        self.spheres.len()
    }

    /// The state with which a run of another model continues: of the same spheres, among other walls.
    ///
    /// Walls, insertions and groups are the same if they have the same name; a wall of another shape begins
    /// without contacts. `before`: the model of this state; `material`: the new number of a material.
    ///
    /// # Errors
    /// [`GrainError::Changed`]: a material or a group of spheres is missing, a group is new and has spheres,
    /// or clumps differ.
    pub fn in_model(
        mut self,
        before: &GrainModel,
        now: &GrainModel,
        material: impl Fn(u32) -> Option<u32>,
    ) -> Result<Self, GrainError> {
        let changed = |why: String| Err(GrainError::Changed(why));
        if before.clumps.len() != now.clumps.len()
            || before.clumps.iter().zip(&now.clumps).any(|(a, b)| a.spheres != b.spheres)
        {
            return changed("clumps are others than those of the earlier run".to_owned());
        }
        let group = |number: u32| {
            let name = before.groups.get(number as usize)?;
            now.groups.iter().position(|other| other == name)
        };
        for sphere in &mut self.spheres {
            let [of, in_group] = sphere.kinds();
            let Some(new) = material(*of) else {
                return changed("the material of spheres of the earlier run is missing".to_owned());
            };
            *of = new;
            if before.groups.is_empty() && now.groups.is_empty() {
                continue;
            }
            let Some(new) = group(*in_group) else {
                let name = before.groups.get(*in_group as usize).map_or("", String::as_str);
                return changed(format!("spheres of \"{name}\" go on, and no table has this name"));
            };
            *in_group = new as u32;
        }
        let is_new = |number: &&u32| {
            let name = now.groups.get(**number as usize);
            name.is_some_and(|name| !before.groups.contains(name))
        };
        if let Some(&number) = now.spheres.groups.iter().find(is_new) {
            let name = &now.groups[number as usize];
            return changed(format!(
                "spheres of \"{name}\" are new, and overlaps with those of the earlier run are not looked for: let \
                 them come in with [[insertion]]"
            ));
        }
        let earlier = |wall: &Wall| before.walls.iter().position(|other| other.name == wall.name);
        let touched = |wall: &Wall| {
            earlier(wall).filter(|&number| {
                before.walls[number].shape == wall.shape && before.walls[number].from == wall.from
            })
        };
        let meshes = |walls: &[Wall]| {
            let is_mesh = |(_, wall): &(usize, &Wall)| matches!(wall.shape, WallShape::Mesh { .. });
            walls.iter().enumerate().filter(is_mesh).map(|(number, _)| number).collect::<Vec<usize>>()
        };
        let of_meshes = meshes(&before.walls);
        let on_mesh = |&number: &usize| {
            let place = touched(&now.walls[number]).and_then(|known| of_meshes.binary_search(&known).ok());
            place.map(|place| self.on_meshes[place].clone()).unwrap_or_default()
        };
        let on_meshes = meshes(&now.walls).iter().map(on_mesh).collect();
        let on_wall = |wall: &Wall| touched(wall).map(|at| self.on_walls[at].clone()).unwrap_or_default();
        let on_walls = now.walls.iter().map(on_wall).collect();
        let servo = |wall: &Wall| touched(wall).map(|number| self.servos[number]).unwrap_or_default();
        let servos = now.walls.iter().map(servo).collect();
        let placed = now.insertions.iter().map(|of| {
            let known = before.insertions.iter().position(|other| other.name == of.name);
            let placed = known.map_or(0, |known| self.placed[known]);
            placed.min(of.radii.len() as u32)
        });
        let placed = placed.collect();
        let cell = if before.domain == now.domain { self.cell } else { BoxMotion::default() };
        Ok(Self { placed, on_walls, on_meshes, servos, cell, ..self })
    }
}
