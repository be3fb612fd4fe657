//! Mass that has been added to a model.

use fdem_io::numbers::{brief, grouped};
use serde::Serialize;

/// Mass that has been added to a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scaled {
    /// Number of elements that have got mass.
    pub elements: usize,
    /// Mass of the model without it, kg.
    pub true_mass: f64,
    /// Added mass, kg.
    pub added_mass: f64,
    /// Time step, s.
    pub step: f64,
    /// Time step without the added mass, s.
    pub step_without: f64,
    /// Kinetic over strain energy up to which the run is quasi-static.
    pub kinetic_bound: f64,
}

impl Scaled {
    /// Added mass as a share of that of the model.
    pub fn share(&self) -> f64 {
        self.added_mass / self.true_mass
    }

    /// The added mass in words.
    pub fn in_words(&self) -> String {
        format!(
            "{} kg of added mass, {} % of that of the model, on {}: steps of {} s instead of {} s",
            brief(self.added_mass),
            brief(100.0 * self.share()),
            counted(self.elements),
            brief(self.step),
            brief(self.step_without)
        )
    }
}

/// `2 elements` and `1 element`.
pub(crate) fn counted(elements: usize) -> String {
    if elements == 1 { "1 element".to_owned() } else { format!("{} elements", grouped(elements as u64)) }
}
