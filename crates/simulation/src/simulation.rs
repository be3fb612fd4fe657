//! The time step of a simulation.
//!
//! A step requests data from other ranks by [`Peers`], and does not know whether there are any.
//! ARCHITECTURE.md and the book print its lines from here; a test compares them.

pub(crate) mod advance;
mod audit;
mod breaking;
pub(crate) mod changed;
mod placed;
pub(crate) mod program;
mod relaxation;
mod release;
pub(crate) mod run;
pub(crate) mod saved;
pub(crate) mod snapshots;
pub(crate) mod totals;

use crate::action::{Event, Scene};
use crate::error::Stop;
use crate::joints::Pulling;
use crate::motion::nodes::Motion;
use crate::motion::{MotionSums, Selected};
use crate::peers::{Peers, StepReport};
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::sum::{Grains, Sum};
use crate::timings::Clock;

/// Joints that broke while the forces of a step were computed, and the reason why the run cannot continue
/// after the step, if there is one. The step is finished all the same, because the other ranks of a run
/// finish it before they hear of the reason.
struct Failures {
    joints: Vec<u32>,
    stop: Option<Stop>,
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Advances one step: from positions at its beginning, and velocities half a step earlier, to positions
    /// at its end. `energies`: whether to compute them.
    fn step(&mut self, energies: bool, peers: &mut dyn Peers<D, N>) -> Result<(), Stop> {
        let failures = self.press(energies, peers); // all forces on the corners of elements
        let failing = self.failing(); // facets on which these forces have reached the strength
        let moved = self.move_nodes(energies, peers); // every node gathers its forces, and moves
        let report = self.finish_motion(&moved, &failures, &failing, peers); // nodes of other ranks
        if report.fails {
            return Err(self.first_stop(failures.stop, peers));
        }
        self.add_works(&moved, energies, peers); // energies at the positions, works after them
        if report.parts {
            self.part(failing, &failures.joints, peers); // new joints and couples, from the next step on
        }
        if self.is_audited() {
            self.audit(peers)?; // whether the energy balance holds
        }
        if report.runs_away {
            return Err(self.first_stop(self.runaway(&moved), peers));
        }
        self.step += 1;
        Ok(())
    }

    /// Computes all forces on the corners of elements.
    fn press(&mut self, energies: bool, peers: &dyn Peers<D, N>) -> Failures {
        let inverted = self.deform(); // stress of each element: solid.rs
        let joints = self.pull(energies); // tractions of joints, and which of them broke: joints.rs
        let undetected = self.detect().err(); // couples that may touch, by fdem-contact: contacts.rs
        if undetected.is_none() {
            self.touch(energies); // couples that overlap: contacts.rs
        }
        // Other ranks wait for the surface of this one, also where it has no couples.
        let stopped = self.act(peers); // loads, surfaces under initial stress, spheres: actions.rs
        Failures { joints, stop: inverted.or(undetected).or(stopped) }
    }

    /// Computes the stresses of elements, and their forces. Returns the reason to stop if an element is
    /// inverted.
    fn deform(&mut self) -> Option<Stop> {
        let mut clock = Clock::new();
        let inverted = self.machine.deform(self.scales.time_step);
        clock.read(&mut self.timings.bulk);
        inverted.map(|(element, ratio)| Stop::Inverted {
            element: self.topology.number(element),
            step: self.step,
            ratio,
        })
    }

    /// Computes the forces of joints, and their elastic energy if `energies` are asked for. Returns the
    /// joints that broke.
    fn pull(&mut self, energies: bool) -> Vec<u32> {
        let mut clock = Clock::new();
        let (step, time) = (self.scales.time_step, self.time());
        let Pulling { broken, work, elastic } = self.machine.pull(step, time, energies);
        self.totals.cohesive.add_sum(&work);
        if let Some(elastic) = elastic {
            self.joint_elastic = elastic;
        }
        clock.read(&mut self.timings.joints);
        broken
    }

    /// Finds the couples of elements that may touch.
    fn detect(&mut self) -> Result<(), Stop> {
        let mut clock = Clock::new();
        self.machine.detect(&self.topology)?;
        clock.read(&mut self.timings.detection);
        Ok(())
    }

    /// Computes the forces between elements that touch.
    fn touch(&mut self, energies: bool) {
        let mut clock = Clock::new();
        let touching = self.machine.touch(&self.topology, self.scales.time_step, energies);
        let totals = &mut self.totals;
        totals.friction.add_sum(&touching.friction);
        totals.damping.add_sum(&touching.damping);
        totals.cohesive.subtract(&touching.handed_over);
        totals.external.add_sum(&touching.relaxed);
        self.touching = touching;
        clock.read(&mut self.timings.contact);
    }

    /// Adds the forces of actions, and their works up to the positions. Returns the reason to stop if one of
    /// them cannot act.
    fn act(&mut self, peers: &dyn Peers<D, N>) -> Option<Stop> {
        let mut clock = Clock::new();
        let (time, step) = (self.time(), self.scales.time_step);
        let Self { model, topology, machine, actions, team, totals, .. } = self;
        let scene = Scene { model, topology, machine: &**machine, team, time, step };
        let (forces, stopped) = actions.act(scene, peers);
        if !forces.is_empty() {
            machine.add_forces(forces);
        }
        let machine = &**machine;
        totals.add_works(actions.half_works(machine, step));
        let works = actions.works(&Scene { model, topology, machine, team, time, step });
        totals.add_works(works.into_iter().map(|work| [work, 0.0]));
        clock.read(&mut self.timings.integration);
        stopped
    }

    /// The facets on which forces have reached the strength. They get joints, which act from the next step
    /// on.
    fn failing(&mut self) -> Vec<u32> {
        let mut clock = Clock::new();
        let failing = self.machine.failing(&self.model, &self.topology);
        clock.read(&mut self.timings.joints);
        failing
    }

    /// Moves the nodes of this rank, those first whose motions others need, and starts to send these.
    fn move_nodes(&mut self, energies: bool, peers: &mut dyn Peers<D, N>) -> MotionSums<Sum, D> {
        let mut clock = Clock::new();
        let (time, taken) = (self.time(), self.taken());
        let Self { model, machine, actions, totals, .. } = self;
        let motion = Motion {
            model,
            holds: &actions.prescribed.holds,
            schedules: &actions.schedules,
            gravity: actions.acceleration(model, time),
            time,
            step: self.scales.time_step,
            speed_limit: self.scales.speed_limit,
            grains: Grains::of(self.scales.size),
            energy: energies,
            relaxation: totals.relaxation.damping,
            taken,
        };
        let mut moved = MotionSums::default();
        machine.move_nodes(&motion, Selected::Only(peers.awaited()), &mut moved);
        peers.start_motion(&**machine);
        machine.move_nodes(&motion, Selected::Except(peers.awaited()), &mut moved);
        totals.external.add_sum(&moved.external[0]);
        totals.damping.add_sum(&moved.damping[0]);
        self.held = std::mem::take(&mut moved.held);
        self.moments = std::mem::take(&mut moved.moments);
        clock.read(&mut self.timings.integration);
        moved
    }

    /// Receives the motions of nodes that other ranks move. Returns the report of the step.
    fn finish_motion(
        &mut self,
        moved: &MotionSums<Sum, D>,
        failures: &Failures,
        failing: &[u32],
        peers: &mut dyn Peers<D, N>,
    ) -> StepReport {
        let own = StepReport {
            fastest: moved.fastest,
            parts: !failing.is_empty() || !failures.joints.is_empty(),
            fails: failures.stop.is_some(),
            runs_away: moved.runaway.is_some(),
        };
        let step = self.scales.time_step;
        let report = peers.finish_motion(&mut *self.machine, step, own, &mut self.timings.messages);
        self.machine.end_motion(step * report.fastest);
        report
    }

    /// Sums up energies at the time of the positions, where the energy balance holds, if they are asked for.
    /// Then adds the works in the second half of the step.
    fn add_works(&mut self, moved: &MotionSums<Sum, D>, energies: bool, peers: &dyn Peers<D, N>) {
        let mut clock = Clock::new();
        if energies {
            self.account(&moved.kinetic, peers);
            let mut largest = moved.largest;
            peers.largest(&mut largest);
            self.imbalance = (largest[0] / largest[1]).sqrt();
        }
        self.relax(moved, peers);
        let Self { machine, actions, totals, .. } = self;
        totals.add_works(actions.half_works(&**machine, self.scales.time_step));
        totals.external.add_sum(&moved.external[1]);
        totals.damping.add_sum(&moved.damping[1]);
        self.note(&Event::Moved, peers);
        clock.read(&mut self.timings.integration);
    }

    /// Lets the actions measure the step, on all ranks together.
    fn note(&mut self, event: &Event<'_, D>, peers: &dyn Peers<D, N>) {
        if !self.actions.follow_events() {
            return;
        }
        let (time, step) = (self.time(), self.scales.time_step);
        let Self { model, topology, machine, actions, team, totals, .. } = self;
        let scene = Scene { model, topology, machine: &**machine, team, time, step };
        let mut sums = actions.measure(event, &scene);
        peers.add_up(&mut sums.iter_mut().flatten().collect::<Vec<_>>());
        let dissipated = actions.settle(event, &sums);
        if scene.counts_common() {
            totals.damping.add(dissipated);
        }
    }

    /// The reason to stop if a node is too fast.
    fn runaway(&self, moved: &MotionSums<Sum, D>) -> Option<Stop> {
        moved.runaway.map(|(element, speed)| Stop::Runaway {
            element: self.topology.number(element),
            step: self.step,
            speed,
            limit: self.scales.speed_limit,
        })
    }

    /// The reason why the run cannot continue, the same on all ranks. `own`: that of this rank.
    fn first_stop(&self, own: Option<Stop>, peers: &dyn Peers<D, N>) -> Stop {
        peers.first_stop(own).unwrap_or(Stop::Runaway {
            element: 0,
            step: self.step,
            speed: f64::NAN,
            limit: self.scales.speed_limit,
        })
    }
}
