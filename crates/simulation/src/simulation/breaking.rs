//! Insertion of joints, and the splitting of nodes where joints have broken: between the phases of a step.

use crate::action::Event;
use crate::faces::BrokenSides;
use crate::joints::Joints;
use crate::machine::Columns;
use crate::peers::Peers;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::timings::Clock;
use crate::topology::Topology;

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Inserts joints on facets that fail, and lets elements of joints that broke touch, from the next step
    /// on.
    pub(super) fn part(&mut self, mut failing: Vec<u32>, broken: &[u32], peers: &mut dyn Peers<D, N>) {
        let mut clock = Clock::new();
        let Self { model, topology, machine, totals, team, .. } = self;
        peers.add_failing(&mut failing, topology);
        let mut sides = Vec::new();
        machine.change_at(&failing, topology, &mut |columns| {
            let Columns { solid, joints, contacts } = columns;
            let split = joints.insert(&failing, solid, model, topology, team);
            let vertices = contacts.surface.part(broken, joints, topology, solid.share());
            peers.exchange_splits(&split, &vertices, columns, topology);
            totals.inserted.add_sum(&columns.joints.take_inserted());
            peers.note_bared(&columns.contacts.surface.bared);
            sides = sides_of(broken, &columns.joints, topology);
        });
        clock.read(&mut self.timings.joints);
        let all = if self.actions.follow_events() { peers.all_broken(sides) } else { Vec::new() };
        self.note(&Event::Broke(&all), peers);
    }
}

/// The joints that have broken and that this rank counts, with the names that are the same on all ranks.
fn sides_of<const D: usize, const N: usize>(
    broken: &[u32],
    joints: &Joints<D>,
    topology: &Topology<D, N>,
) -> Vec<BrokenSides<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let counted = broken.iter().map(|&joint| &joints.all[joint as usize]).filter(|joint| joint.counted);
    counted.map(|joint| BrokenSides::of(&topology.facets[joint.facet as usize], topology)).collect()
}
