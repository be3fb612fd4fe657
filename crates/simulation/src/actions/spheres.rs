//! Spheres and walls: their contacts with each other and with the surface of the bodies.
//!
//! Spheres move in a run of their own, [`GrainRun`], which takes its step where the forces on bodies are
//! added up: the spheres see the surface at the positions of the step, as contacts of bodies do, and return
//! forces on its points. Each rank moves all spheres, and applies the forces to the nodes that it owns. These
//! forces do no external work. The balance has all energies of the spheres, and so the work between spheres
//! and bodies counts once.

mod surface;

use std::time::Duration;

use fdem_distributed::wire::Wire;
use fdem_grains::{GrainModel, GrainRun, GrainState, Surface};
use serde::{Deserialize, Serialize};

use crate::action::{Acting, Action, Scene};
use crate::actions::spheres::surface::BodySurface;
use crate::energy::{Account, Ledger};
use crate::error::{ModelError, Stop};
use crate::model::Model;
use crate::rotation::lowered;
use crate::simplex::Simplex;
use crate::sum::Sum;
use crate::team::Team;
use crate::timings::Clock;
use crate::vector::Point;

/// The spheres and walls of a model; none of them if it has none.
#[derive(Debug, Default)]
pub(crate) struct SphereAction<const D: usize> {
    run: Option<GrainRun>,
    surface: BodySurface<D>,
    /// Potential energy of the weight at the beginning of the run, without the factor of gravity, J; `None`
    /// before the first step.
    weight: Option<f64>,
    /// Time that the spheres have taken.
    pub(crate) spent: Duration,
}

/// The state of spheres, from which their run is continued.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub(crate) struct SavedSpheres<const D: usize> {
    run: GrainState,
    weight: Option<f64>,
    /// Codes of the corners on the surface, with the velocities of their nodes one step earlier, m/s.
    surface: Vec<(u32, Point<D>)>,
}

impl<const D: usize> Wire for SavedSpheres<D> {
    fn put(&self, out: &mut Vec<u8>) {
        postcard::to_allocvec(&self.run).expect("a state has no values that cannot be written").put(out);
        self.weight.into_iter().collect::<Vec<f64>>().put(out);
        self.surface.put(out);
    }

    fn take(bytes: &mut &[u8]) -> Self {
        let run = postcard::from_bytes(&Vec::<u8>::take(bytes)).expect("a message from the same program");
        let weight = Vec::<f64>::take(bytes).first().copied();
        Self { run, weight, surface: Vec::take(bytes) }
    }
}

impl<const D: usize> SavedSpheres<D> {
    pub(crate) fn count(&self) -> usize {
        self.run.count()
    }

    /// The same spheres in another model: see [`GrainState::in_model`].
    pub(crate) fn in_model(
        self,
        before: &GrainModel,
        now: &GrainModel,
        material: impl Fn(u32) -> Option<u32>,
    ) -> Result<Self, ModelError> {
        Ok(Self { run: self.run.in_model(before, now, material)?, ..self })
    }

    /// The same spheres on other bodies. `number`: the new number of an element; `None` for one that is no
    /// more.
    pub(crate) fn renumbered<const N: usize>(mut self, number: impl Fn(u32) -> Option<u32>) -> Self {
        let code = |code: u32| Some(number(code / N as u32)? * N as u32 + code % N as u32);
        self.surface.retain_mut(|of| code(of.0).inspect(|&now| of.0 = now).is_some());
        self
    }
}

impl<const D: usize> SphereAction<D> {
    /// The spheres of a model, which move with its time step, s.
    pub(crate) fn new<const N: usize>(
        model: &Model<D, N>,
        step: f64,
        team: &Team,
    ) -> Result<Self, ModelError> {
        let Some(grains) = &model.grains else { return Ok(Self::default()) };
        let run = on_team(GrainModel { step: Some(step), ..grains.clone() }, team)?;
        Ok(Self { run: Some(run), ..Self::default() })
    }

    /// The run of the spheres, if there are any.
    pub(crate) fn run(&self) -> Option<&GrainRun> {
        self.run.as_ref()
    }

    /// Number of the body of each facet of the surface that spheres touch.
    pub(crate) fn bodies_of_facets(&self) -> &[u32] {
        &self.surface.bodies
    }

    /// The same, to change it between steps.
    pub(crate) fn run_mut(&mut self) -> Option<&mut GrainRun> {
        self.run.as_mut()
    }

    /// Takes the law of the caller over from the spheres that these continue.
    pub(crate) fn keep_law(&mut self, before: &mut Self) {
        if let (Some(run), Some(before)) = (&mut self.run, &mut before.run) {
            run.keep_law(before);
        }
    }

    /// The state, from which [`SphereAction::restore`] continues.
    pub(crate) fn save(&self) -> Option<SavedSpheres<D>> {
        self.save_with(self.surface.motion())
    }

    /// The state with the motion of the whole surface, of which this rank has a part.
    pub(crate) fn save_with(&self, mut surface: Vec<(u32, Point<D>)>) -> Option<SavedSpheres<D>> {
        surface.sort_unstable_by_key(|(code, _)| *code);
        Some(SavedSpheres { run: self.run.as_ref()?.state(), weight: self.weight, surface })
    }

    /// The part of the motion of the surface that this rank has: codes of corners, with the velocities of
    /// their nodes one step earlier, m/s.
    pub(crate) fn surface_motion(&self) -> Vec<(u32, Point<D>)> {
        self.surface.motion()
    }

    /// The same spheres, among other elements. `motion`: of the surface, of all ranks.
    pub(crate) fn among_others(self, motion: Vec<(u32, Point<D>)>) -> Self {
        Self { surface: BodySurface::with_motion(motion), ..self }
    }

    /// Continues from a state of the same spheres.
    pub(crate) fn restore(&mut self, saved: SavedSpheres<D>) -> Result<(), ModelError> {
        let Some(run) = &mut self.run else { return Ok(()) };
        run.take(saved.run)?;
        self.weight = saved.weight;
        self.surface = BodySurface::with_motion(saved.surface);
        Ok(())
    }
}

/// A run of spheres on the threads of a team.
fn on_team(model: GrainModel, team: &Team) -> Result<GrainRun, ModelError> {
    Ok(match team.pool() {
        Some(pool) => GrainRun::on_pool(model, pool)?,
        None => GrainRun::new(model, 1)?,
    })
}

impl<const D: usize, const N: usize> Action<D, N> for SphereAction<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        let Self { run: Some(run), surface, weight, spent } = self else { return };
        let mut clock = Clock::new();
        let Scene { model, time, .. } = acting.scene;
        let gravity = model.grains.as_ref().map_or([0.0; 3], |grains| grains.gravity);
        let factor = model.gravity_schedule.factor(time);
        if weight.is_none() {
            *weight = Some(run.energies().weight);
        }
        run.set_gravity(gravity.map(|g| factor * g));
        // Spheres alone have no bodies to look at; a rank without elements sees those of others.
        if model.mesh.elements.is_empty() && acting.peers.are_none() {
            if let Err(error) = run.advance(1) {
                acting.fail(Stop::Grains(error));
            }
            clock.read(spent);
            return;
        }
        surface.update(&acting.scene, acting.peers);
        let BodySurface { points, velocities, facets, materials, .. } = &*surface;
        if let Err(error) = run.step_on(&Surface { points, velocities, facets, materials }) {
            acting.fail(Stop::Grains(error));
            return;
        }
        for &(point, force) in run.surface_forces() {
            let corners = surface.corners_of(point); // none of a point of another rank
            let share = 1.0 / corners.len() as f64;
            let force = lowered(force.map(|f| share * f));
            for corner in corners {
                acting.add_force(corner, force);
            }
        }
        clock.read(spent);
    }

    fn add_energies(&self, scene: &Scene<'_, D, N>, ledger: &mut Ledger) {
        // All ranks have all spheres.
        let Some(run) = self.run.as_ref().filter(|_| scene.counts_common()) else { return };
        let energies = run.energies();
        let fallen = self.weight.map_or(0.0, |initial| initial - energies.weight);
        for (account, energy) in [
            (Account::Kinetic, energies.kinetic + energies.rotational),
            (Account::Contact, energies.elastic),
            (Account::Damping, energies.dissipated),
            (Account::External, energies.external + fallen),
        ] {
            ledger.add(account, &Sum::from(energy));
        }
    }
}
