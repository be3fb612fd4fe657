//! What becomes of the energy.

use serde::{Deserialize, Serialize};

/// Energies and works since the beginning, J. Their balance is the instrument that shows whether a run can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Of motion.
    pub kinetic: f64,
    /// Stored in the elements.
    pub strain: f64,
    /// Stored in the potentials of contacts.
    pub contact: f64,
    /// Work against friction of contacts: dissipated, or stored while it sticks.
    pub friction: f64,
    /// Work against joints: dissipated by fracture and by friction on cracks, or stored.
    pub cohesive: f64,
    /// Dissipated by viscosity, local damping, damping of contacts and absorbing edges.
    pub damping: f64,
    /// Work of loads, of what moves boundaries, and of gravity.
    pub external: f64,
    /// What was there at the beginning, of motion and of strain.
    pub initial: f64,
}

impl Energies {
    /// What is there or was dissipated, less what was put in, J: 0 but for the error of the integration in time.
    pub fn balance(&self) -> f64 {
        self.kinetic + self.strain + self.contact + self.friction + self.cohesive + self.damping
            - self.external
            - self.initial
    }

    /// What has been in the system, J: the measure of an error of the balance.
    pub fn scale(&self) -> f64 {
        let stored = self.kinetic + self.strain + self.contact;
        let spent = self.friction.abs() + self.cohesive.abs() + self.damping.abs();
        (stored + spent).max(self.initial).max(self.external.abs())
    }

    /// The error of the balance as a share of what has been in the system; 0 if nothing has.
    pub fn error(&self) -> f64 {
        let scale = self.scale();
        if scale > 0.0 { self.balance() / scale } else { 0.0 }
    }
}
