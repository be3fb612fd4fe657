//! The energy balance of a run.

use fdem_distributed::wire;
use serde::{Deserialize, Serialize};

use crate::model::{STORED, Stored};
use crate::sum::Sum;

/// Energies and works, J. Their balance shows whether a run can be trusted.
///
/// Stored energy is counted in full: elements, joints and contacts under initial stress begin with the energy
/// of that stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Strain energy of the elements, including that of the initial stress.
    pub strain: f64,
    /// Energy stored in the potentials of contacts.
    pub contact: f64,
    /// Work against friction of contacts: dissipated, or stored while contacts stick.
    pub friction: f64,
    /// Work against joints: dissipated by fracture and by friction on cracks, or stored. It is the sum of
    /// [`joint_elastic`](Self::joint_elastic) and [`Energies::joint_dissipated`].
    pub cohesive: f64,
    /// The part of `cohesive` that joints store: their elastic energy, less that with which joints were
    /// inserted during the run. Such a joint takes over the traction that acts, with an elastic energy that
    /// is in no work; the sum becomes negative where inserted joints have given that energy to the elements.
    pub joint_elastic: f64,
    /// Energy dissipated by viscosity, local damping, damping of contacts and absorbing edges.
    pub damping: f64,
    /// Work of loads, of boundaries that move or hold nodes, and of gravity since the beginning.
    pub external: f64,
    /// Kinetic and stored energy at the beginning.
    pub initial: f64,
    /// Largest energy exchanged so far, or a negligible one: see [`Energies::scale`].
    pub exchanged: f64,
    /// Energy that each of [`STORED`] has; `None` in a run without such an action.
    pub stored: [Option<f64>; STORED.len()],
}

wire!([] Energies {
    kinetic, strain, contact, friction, cohesive, joint_elastic, damping, external, initial, exchanged, stored
});

/// An entry of a [`Ledger`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Account {
    Kinetic,
    Strain,
    Contact,
    Friction,
    Cohesive,
    Damping,
    External,
    /// The work of applied forces, which [`Account::External`] contains.
    Loads,
    /// The work of gravity, which it contains too.
    Gravity,
    /// The elastic energy of joints, which [`Account::Cohesive`] contains.
    JointElastic,
}

/// Number of accounts.
const ACCOUNTS: usize = Account::JointElastic as usize + 1;

/// Sums of energies and works at one instant, to which elements, joints, contacts and actions add theirs, J.
#[derive(Clone, Debug)]
pub(crate) struct Ledger {
    sums: [Sum; ACCOUNTS],
    /// Sums of the terms in [`STORED`].
    stored: [Option<Sum>; STORED.len()],
}

impl Default for Ledger {
    fn default() -> Self {
        Self { sums: std::array::from_fn(|_| Sum::default()), stored: std::array::from_fn(|_| None) }
    }
}

impl Ledger {
    /// Adds to an account.
    pub(crate) fn add(&mut self, account: Account, more: &Sum) {
        self.sums[account as usize].add_sum(more);
    }

    /// Adds to the energy that actions store. All ranks add to the same ones.
    pub(crate) fn store(&mut self, stored: Stored, more: &Sum) {
        self.stored[stored as usize].get_or_insert_default().add_sum(more);
    }

    /// All sums. Every rank has the same ones, in one order.
    pub(crate) fn sums_mut(&mut self) -> impl Iterator<Item = &mut Sum> {
        self.sums.iter_mut().chain(self.stored.iter_mut().flatten())
    }

    /// The value of an account, J.
    pub(crate) fn value(&self, account: Account) -> f64 {
        self.sums[account as usize].value()
    }

    /// The sum of all energies that are present or dissipated, J.
    pub(crate) fn used(&self) -> Sum {
        let mut all = Sum::default();
        let used = &self.sums[..Account::External as usize];
        used.iter().chain(self.stored.iter().flatten()).for_each(|sum| all.add_sum(sum));
        all
    }

    /// The energies, without the initial ones and the exchanged energy.
    pub(crate) fn energies(&self) -> Energies {
        let value = |account: Account| self.value(account);
        Energies {
            kinetic: value(Account::Kinetic),
            strain: value(Account::Strain),
            contact: value(Account::Contact),
            friction: value(Account::Friction),
            cohesive: value(Account::Cohesive),
            joint_elastic: value(Account::JointElastic),
            damping: value(Account::Damping),
            external: value(Account::External),
            stored: std::array::from_fn(|k| self.stored[k].as_ref().map(Sum::value)),
            ..Energies::default()
        }
    }

    /// Sum of the magnitudes of the external works that may cancel, J: of loads, of gravity, and of
    /// boundaries that move or hold nodes.
    pub(crate) fn done(&self) -> f64 {
        let [external, loads, gravity] =
            [Account::External, Account::Loads, Account::Gravity].map(|account| self.value(account));
        loads.abs() + gravity.abs() + (external - loads - gravity).abs()
    }
}

/// Meaning of a term of the energy balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TermKind {
    /// Present or dissipated: a function of time.
    Used,
    /// Supplied from outside: a function of time.
    Supplied,
    /// Supplied at the beginning: constant.
    Initial,
}

/// A term of the energy balance: see [`Energies::terms`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Name of the field of [`Energies`], which files use.
    pub key: &'static str,
    /// Name for people.
    pub name: &'static str,
    /// Meaning of the term.
    pub kind: TermKind,
    /// Energy or work, J.
    pub value: f64,
}

impl Energies {
    /// The terms that the balance of every run has.
    fn common(&self) -> [Term; 9] {
        use TermKind::{Initial, Supplied, Used};
        let term = |key, name, kind, value| Term { key, name, kind, value };
        [
            term("kinetic", "kinetic", Used, self.kinetic),
            term("strain", "strain", Used, self.strain),
            term("contact", "contact", Used, self.contact),
            term("friction", "friction", Used, self.friction),
            term("joint_elastic", "elastic, of joints", Used, self.joint_elastic),
            term("joint_dissipated", "fracture", Used, self.joint_dissipated()),
            term("damping", "damping", Used, self.damping),
            term("external", "external work", Supplied, self.external),
            term("initial", "initial", Initial, self.initial),
        ]
    }

    /// All terms of the balance: those that every run has, then the energies that actions store. Tables and
    /// files list them in this order.
    pub fn terms(&self) -> Vec<Term> {
        let stored = STORED.iter().zip(self.stored).filter_map(|(&(key, name), value)| {
            Some(Term { key, name, kind: TermKind::Used, value: value? })
        });
        self.common().into_iter().chain(stored).collect()
    }

    /// The terms that every run has and that change with time: all of them but the initial energy.
    pub fn changing(&self) -> impl Iterator<Item = Term> {
        self.common().into_iter().filter(|term| term.kind != TermKind::Initial)
    }

    /// The part of `cohesive` that joints have dissipated, J: by softening, breaking, friction and dilation.
    pub fn joint_dissipated(&self) -> f64 {
        self.cohesive - self.joint_elastic
    }

    /// Error of the energy balance, J: present and dissipated energy, less initial energy and external work.
    /// The error of the time integration makes it differ from 0.
    pub fn balance(&self) -> f64 {
        let used = [self.kinetic, self.strain, self.contact, self.friction, self.cohesive, self.damping];
        let present = used.iter().sum::<f64>() - self.external - self.initial;
        self.stored.iter().flatten().fold(present, |sum, stored| sum + stored)
    }

    /// Energy, J, with which an error of the balance is compared: the largest energy exchanged so far.
    ///
    /// The exchanged energy is the larger of two sums of magnitudes. The first has kinetic energy, changes of
    /// the stored energies, and dissipated energies. The second has the work of loads, of gravity, and of
    /// boundaries that move or hold nodes. Terms of different signs do not cancel, the scale never falls, and
    /// energy that stays stored from beginning to end does not count. The scale is at least a negligible
    /// energy, the sum of that of a uniform strain of 1e-8 and the work of the initial stress at a strain of
    /// 1e-7: in a body at rest, rounding would be compared with rounding.
    pub fn scale(&self) -> f64 {
        self.exchanged
    }

    /// Error of the balance as a share of [`Energies::scale`]; 0 while no energy has been exchanged.
    pub fn error(&self) -> f64 {
        let scale = self.scale();
        if scale > 0.0 { self.balance() / scale } else { 0.0 }
    }

    /// Energy that can have become kinetic, J: initial energy and external work.
    pub(crate) fn available(&self) -> f64 {
        self.initial + self.external
    }

    /// Sum, J, of the kinetic energy, the magnitude of the energy dissipated by damping, and the magnitudes
    /// of the changes of all other energies since `first`.
    pub(crate) fn changed(&self, first: &Self) -> f64 {
        self.kinetic
            + (self.strain - first.strain).abs()
            + (self.contact - first.contact).abs()
            + (self.friction - first.friction).abs()
            + (self.cohesive - first.cohesive).abs()
            + self.damping.abs()
            + self.stored.iter().zip(&first.stored).fold(0.0, |sum, (now, first)| {
                sum + (now.unwrap_or_default() - first.unwrap_or_default()).abs()
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_shares_of_the_exchanged_energy() {
        let moved =
            Energies { strain: 1e3 + 2.0, kinetic: 2.0, initial: 1e3, exchanged: 4.0, ..Energies::default() };
        assert_eq!(moved.error(), 1.0);
        assert_eq!(Energies::default().error(), 0.0);
    }
}
