//! The energies of a run, and the check of their balance.

use std::collections::BTreeMap;

use crate::energy::{Account, Energies, Ledger};
use crate::error::Stop;
use crate::forces::Reaction;
use crate::machine::{Columns, Wanted};
use crate::peers::{Peers, first_of_largest};
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::simulation::totals::Totals;
use crate::sum::Sum;
use crate::topology::NONE;
use crate::vector::dot;

/// Steps between two checks of the energy balance.
const AUDIT: u64 = 100;

/// A violation of the balance of energy.
#[derive(Debug, PartialEq)]
enum Imbalance {
    /// The error of the balance, as a share of the energy exchanged.
    Energy { error: f64 },
    /// More kinetic energy than is available, J: negative dissipation may cancel it in the balance.
    Kinetic { available: f64 },
    /// Share of the energy that joints had dissipated and have returned.
    Returned { share: f64 },
}

impl Imbalance {
    /// The first violation among `energies`. `most_dissipated`: the largest energy that joints had dissipated
    /// in any step, J; `negligible`: the energy whose errors are ignored, J.
    fn of(energies: &Energies, most_dissipated: f64, bound: f64, negligible: f64) -> Option<Self> {
        let (error, scale, available) = (energies.error(), energies.scale(), energies.available());
        if scale <= negligible {
            return None;
        }
        if error.abs() > bound || error.is_nan() {
            return Some(Self::Energy { error });
        }
        if energies.kinetic > available + bound * scale {
            return Some(Self::Kinetic { available });
        }
        // Energy that joints store is returned, as that of elements.
        let share = (most_dissipated - energies.joint_dissipated()) / scale;
        (share > bound).then_some(Self::Returned { share })
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Whether the energy balance is checked in this step.
    pub(super) fn is_audited(&self) -> bool {
        self.step.is_multiple_of(AUDIT)
    }

    /// Sums up the energies and the reactions at the beginning of this step. `kinetic`: the kinetic energy,
    /// J.
    pub(super) fn account(&mut self, kinetic: &Sum, peers: &dyn Peers<D, N>) {
        let [strain, viscous] = self.machine.energies();
        let Totals { friction, cohesive, inserted, damping, external, loads, .. } = &self.totals;
        let mut ledger = Ledger::default();
        let contact = self.touching.energy.clone().unwrap_or_default();
        let mut joint_elastic = self.joint_elastic.clone();
        joint_elastic.subtract(inserted);
        for (account, sum) in [
            (Account::Kinetic, kinetic),
            (Account::Strain, &strain),
            (Account::Contact, &contact),
            (Account::Friction, friction),
            (Account::Cohesive, cohesive),
            (Account::Damping, &viscous),
            (Account::Damping, damping),
            (Account::External, external),
            (Account::Loads, loads),
            (Account::JointElastic, &joint_elastic),
        ] {
            ledger.add(account, sum);
        }
        self.actions.add_energies(&self.scene(), &mut ledger);
        let mut reactions = self.reactions_of_boundaries();
        let mut moments = self.moments_of_boundaries();
        let mut sums: Vec<&mut Sum> = ledger.sums_mut().collect();
        sums.extend(reactions.iter_mut().flatten());
        sums.extend(moments.values_mut().flatten());
        peers.add_up(&mut sums);
        let now = ledger.energies();
        let first = *self.totals.first.get_or_insert(now);
        let changed = now.changed(&first).max(ledger.done());
        let exchanged = changed.max(self.totals.exchanged).max(self.scales.negligible);
        self.energies = Energies { initial: first.balance(), exchanged, ..now };
        let reaction = |(number, force): (u32, &[Sum; D])| Reaction {
            force: std::array::from_fn(|axis| force[axis].value()),
            moment: moments
                .get(&number)
                .map_or([0.0; 3], |sums| std::array::from_fn(|axis| sums[axis].value())),
        };
        self.reactions = (0..).zip(&reactions).map(reaction).collect();
    }

    /// Checks the energy balance during a run, and keeps the largest energies.
    pub(super) fn audit(&mut self, peers: &dyn Peers<D, N>) -> Result<(), Stop> {
        self.totals.exchanged = self.energies.exchanged;
        self.totals.most_dissipated = self.totals.most_dissipated.max(self.energies.joint_dissipated());
        self.balanced(self.step, || self.hottest(peers))
    }

    /// Checks the energy balance at the end of a run, with the energies of its last step.
    ///
    /// It keeps nothing: a run that continues from here must be as one that never ended here. All ranks look
    /// for the element, so that their calls are the same, and the answer of rank 0 counts.
    pub(crate) fn audit_end(&self, peers: &dyn Peers<D, N>) -> Result<(), Stop> {
        let element = self.hottest(peers);
        self.balanced(self.step.saturating_sub(1), || element)
    }

    /// Whether the energies of a step are in balance. `hottest`: finds the element that an error names.
    fn balanced(&self, step: u64, hottest: impl Fn() -> u32) -> Result<(), Stop> {
        let (bound, negligible) = (self.model.time.energy_bound, self.scales.negligible);
        let Some(imbalance) = Imbalance::of(&self.energies, self.totals.most_dissipated, bound, negligible)
        else {
            return Ok(());
        };
        let element = hottest();
        Err(match imbalance {
            Imbalance::Energy { error } => Stop::Energy { element, step, error, bound },
            Imbalance::Kinetic { available } => {
                Stop::Kinetic { element, step, kinetic: self.energies.kinetic, available }
            }
            Imbalance::Returned { share } => Stop::Returned { element, step, share, bound },
        })
    }

    /// Force of each boundary on the bodies in this step, N.
    fn reactions_of_boundaries(&self) -> Vec<[Sum; D]> {
        self.looked_at(&Wanted::default(), |Columns { solid, .. }| {
            let mut sums = vec![[(); D].map(|()| Sum::default()); self.model.boundaries.len()];
            for (node, reaction) in &self.held {
                let hold = self.actions.prescribed.holds[solid.hold(*node as usize) as usize];
                for axis in 0..D {
                    if let Some(hold) = hold[axis] {
                        sums[hold.boundary as usize][axis].add(reaction[axis]);
                    }
                }
            }
            for ([boundary, _], force) in self.actions.applied(solid) {
                // Forces of the caller belong to no boundary.
                let Some(sums) = sums.get_mut(boundary as usize) else { continue };
                for axis in 0..D {
                    sums[axis].add(force[axis]);
                }
            }
            sums
        })
    }

    /// Moments in this step of the boundaries that turn nodes or bodies, N m: see [`Self::moments`].
    fn moments_of_boundaries(&self) -> BTreeMap<u32, [Sum; 3]> {
        let turning = (0..).zip(&self.model.boundaries).filter(|(_, boundary)| boundary.load.is_rotation());
        let mut sums: BTreeMap<u32, [Sum; 3]> =
            turning.map(|(number, _)| (number, [(); 3].map(|()| Sum::default()))).collect();
        for (boundary, moment) in &self.moments {
            for (sum, part) in sums.get_mut(boundary).into_iter().flatten().zip(moment) {
                sum.add(*part);
            }
        }
        sums
    }

    /// The element with the most energy per mass: the first of them; [`NONE`] if there are no elements.
    pub(super) fn hottest(&self, peers: &dyn Peers<D, N>) -> u32 {
        let density = |number: u32| {
            let element = self.solid().element(number as usize);
            let square = |node: u32| {
                let velocity = self.solid().velocity(node as usize);
                dot(velocity, velocity)
            };
            let fastest = self.solid().nodes_of(number).into_iter().map(square).fold(0.0, f64::max);
            let density = self.model.materials[element.material as usize].density;
            0.5 * fastest + self.solid().energy(number as usize) / (density * element.volume)
        };
        let all =
            (0..self.solid().element_count() as u32).filter(|&element| self.solid().share().element(element));
        let of_all = all.map(|element| (density(element), self.topology.number(element)));
        let own = of_all.reduce(first_of_largest);
        peers.first_of_largest(own).map_or(NONE, |(_, element)| element)
    }

    /// Kinetic energy with the velocities half a step after the positions, J.
    pub(super) fn kinetic_of_half_step(&self) -> Sum {
        let solid = self.solid();
        let of = |node: usize| {
            let velocity = solid.velocity(node);
            0.5 * solid.constants(node).mass * dot(velocity, velocity)
        };
        let rigid = (0..solid.rigid.all.len()).filter(|&body| solid.moves_rigid(body));
        let own = |node: &usize| solid.share().node(*node) && !solid.rigid.has_node(*node);
        let nodes = (0..solid.node_count()).filter(own).map(of);
        nodes.chain(rigid.map(|body| solid.rigid.kinetic(body))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body at 10 J that has lost 1 J of them to damping, and whose joints have dissipated 2 J.
    fn sound() -> Energies {
        Energies {
            kinetic: 7.0,
            damping: 1.0,
            cohesive: 2.0,
            initial: 10.0,
            exchanged: 10.0,
            ..Energies::default()
        }
    }

    fn imbalance(energies: Energies) -> Option<Imbalance> {
        Imbalance::of(&energies, 2.0, 1e-2, 1e-6)
    }

    #[test]
    fn energies_in_balance_pass() {
        assert_eq!(imbalance(sound()), None);
    }

    /// Kinetic energy out of nothing is found although the balance holds: negative dissipation cancels it,
    /// but it exceeds the energy available.
    #[test]
    fn kinetic_energy_out_of_nothing_is_found() {
        let found = imbalance(Energies { kinetic: 28.0, damping: -20.0, ..sound() });
        assert_eq!(found, Some(Imbalance::Kinetic { available: 10.0 }));
    }

    #[test]
    fn energy_that_joints_return_is_found() {
        let found = imbalance(Energies { kinetic: 8.0, cohesive: 1.0, ..sound() });
        assert_eq!(found, Some(Imbalance::Returned { share: 0.1 }));
    }

    #[test]
    fn an_error_of_the_balance_is_found_and_so_is_nan() {
        let found = imbalance(Energies { kinetic: 8.0, ..sound() });
        assert_eq!(found, Some(Imbalance::Energy { error: 0.1 }));
        assert!(imbalance(Energies { kinetic: f64::NAN, ..sound() }).is_some());
        assert_eq!(Imbalance::of(&Energies { kinetic: 8.0, ..sound() }, 2.0, 1e-2, 20.0), None);
    }
}
