//! The energy balance of a run.

use serde::{Deserialize, Serialize};

/// Energies and works, J. Their balance shows whether a run can be trusted.
///
/// What is stored is counted in full: elements, joints and contacts that begin under initial stress begin with the energy of that stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Strain energy of the elements, that of the initial stress included.
    pub strain: f64,
    /// Stored in the potentials of contacts.
    pub contact: f64,
    /// Work against friction of contacts: dissipated, or stored while it sticks.
    pub friction: f64,
    /// Work against joints: dissipated by fracture and by friction on cracks, or stored.
    pub cohesive: f64,
    /// Dissipated by viscosity, local damping, damping of contacts and absorbing edges.
    pub damping: f64,
    /// Work of loads, of boundaries that move or hold nodes, and of gravity since the beginning.
    pub external: f64,
    /// Kinetic and stored energy at the beginning.
    pub initial: f64,
    /// The most energy that has been exchanged so far: see [`Energies::scale`].
    pub exchanged: f64,
}

impl Energies {
    /// Energy that is there or was dissipated, less what was there at the beginning and what was put in, J. The error of the integration in time makes it differ from 0.
    pub fn balance(&self) -> f64 {
        self.kinetic + self.strain + self.contact + self.friction + self.cohesive + self.damping
            - self.external
            - self.initial
    }

    /// The measure of an error of the balance, J: the most energy that has been exchanged so far.
    ///
    /// This is the larger of two sums of magnitudes: kinetic energy, changes of the stored energies, and dissipated energies; and work of loads, of gravity and of boundaries that move or hold
    /// nodes. Terms of different signs do not cancel, the measure never falls, and energy that is stored from beginning to end does not count.
    pub fn scale(&self) -> f64 {
        self.exchanged
    }

    /// The error of the balance as a share of [`Energies::scale`]; 0 while no energy has been exchanged.
    pub fn error(&self) -> f64 {
        let scale = self.scale();
        if scale > 0.0 { self.balance() / scale } else { 0.0 }
    }

    /// Energy that could have become kinetic, J: what was there at the beginning, and what was put in.
    pub(crate) fn available(&self) -> f64 {
        self.initial + self.external
    }

    /// The sum of the magnitudes of what has changed since `first`, J, and of the kinetic energy.
    pub(crate) fn changed(&self, first: &Self) -> f64 {
        self.kinetic
            + (self.strain - first.strain).abs()
            + (self.contact - first.contact).abs()
            + (self.friction - first.friction).abs()
            + (self.cohesive - first.cohesive).abs()
            + self.damping.abs()
    }
}
