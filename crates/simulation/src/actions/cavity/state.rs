//! A cavity: its pressure, its volume, and the joints that are connected with it.

use std::collections::{BTreeMap, BTreeSet};

use fdem_distributed::wire;

use crate::actions::cavity::face::{Face, Rim, rims};
use crate::faces::BrokenSides;

/// Numbers of a cavity, the same on all ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CavityNumbers {
    /// Volume of the undeformed hole, m³, by which a changed hole is recognised.
    pub(super) hole: f64,
    /// Volume in the beginning, and now, m³.
    pub(super) first: f64,
    pub(super) volume: f64,
    /// Sum of `p dV`, J, but for the half that the next pressure adds: `swept` is its volume, m³.
    pub(super) work: f64,
    pub(super) swept: f64,
    /// Area of all faces, m².
    pub(super) area: f64,
    /// Pressure in the last step, Pa.
    pub(super) pressure: f64,
    /// Energy of a gas in the last step, J.
    pub(super) stored: f64,
}

wire!([] CavityNumbers { hole, first, volume, work, swept, area, pressure, stored });

/// Pressure, volume and work of a cavity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CavityState {
    /// Pressure at the beginning of the last step, Pa.
    pub pressure: f64,
    /// Volume, m³.
    pub volume: f64,
    /// Area of its faces, m².
    pub area: f64,
    /// Work of the pressure since the beginning, J: the sum of `p dV`.
    pub work: f64,
    /// Energy that a gas stores, J; 0 for a prescribed pressure.
    pub stored: f64,
}

/// A cavity.
#[derive(Debug)]
pub(super) struct Cavity<const D: usize> {
    pub(super) boundary: u32,
    pub(super) name: String,
    pub(super) pressure: f64,
    /// Ratio of the specific heats of a gas; `None` for a prescribed pressure.
    pub(super) gas: Option<f64>,
    /// Rims of all of its faces.
    pub(super) rims: BTreeSet<Rim>,
    /// Codes of the joints that have joined.
    pub(super) joined: BTreeSet<u32>,
    /// Broken joints elsewhere, by their rims.
    pub(super) elsewhere: BTreeMap<Rim, Vec<u32>>,
    /// In the order of their corners.
    pub(super) faces: Vec<Face<D>>,
    pub(super) numbers: Option<CavityNumbers>,
}

impl<const D: usize> Cavity<D> {
    /// Pressure at a volume, Pa. `factor`: of the schedule.
    pub(super) fn pressure_at(&self, numbers: &CavityNumbers, factor: f64) -> f64 {
        match self.gas {
            Some(exponent) => self.pressure * libm::pow(numbers.first / numbers.volume, exponent),
            None => self.pressure * factor,
        }
    }

    /// Energy that a gas stores at a volume, J.
    pub(super) fn stored(&self, numbers: &CavityNumbers) -> f64 {
        let Some(exponent) = self.gas else { return 0.0 };
        let ratio = libm::pow(numbers.first / numbers.volume, exponent - 1.0);
        self.pressure * numbers.first * ratio / (exponent - 1.0)
    }

    /// Takes a broken joint in, if it is connected, with all that it connects. Returns the joints that have
    /// joined, by their codes.
    pub(super) fn reach(
        &mut self,
        joint: &BrokenSides<D>,
        known: &BTreeMap<u32, BrokenSides<D>>,
    ) -> Vec<u32> {
        let code = joint.sides[0];
        if self.joined.contains(&code) {
            return Vec::new();
        }
        if !rims(joint.vertices).any(|rim| self.rims.contains(&rim)) {
            for rim in rims(joint.vertices) {
                self.elsewhere.entry(rim).or_default().push(code);
            }
            return Vec::new();
        }
        let (mut new, mut waiting) = (Vec::new(), vec![*joint]);
        while let Some(joint) = waiting.pop() {
            if !self.joined.insert(joint.sides[0]) {
                continue;
            }
            new.push(joint.sides[0]);
            for rim in rims(joint.vertices) {
                self.rims.insert(rim);
                let connected = self.elsewhere.remove(&rim).unwrap_or_default();
                waiting.extend(connected.iter().filter_map(|code| known.get(code)));
            }
        }
        new
    }
}
