//! A step by forward Euler, for checks.

use super::Network;
use super::balances::Balances;
use crate::error::FluidError;

impl<const D: usize> Network<D> {
    /// Longest stable part of an explicit step, s: `min_c V_c/(K Σ b T)` over the full compartments; infinite
    /// without flow.
    ///
    /// # Errors
    /// The errors of [`advance`](Self::advance).
    pub fn explicit_bound(&self) -> Result<f64, FluidError> {
        // Weights are proportional to the step.
        let step = (1e-9 * self.state.time).max(1e-9);
        let balances = self.balances(self.state.time + step)?;
        let mut sums = vec![0.0; balances.mass.len()];
        for (link, weight) in self.topology.links.iter().zip(&balances.weight) {
            link.ends.iter().for_each(|end| sums[*end as usize] += weight / balances.step);
        }
        let state = &self.model.fluid.state;
        let bound = |k: usize| {
            let pressure = balances.pressure[k].max(state.lowest_pressure());
            balances.storage[k].mass(state, pressure)[1] / sums[k]
        };
        let free = (0..sums.len()).filter(|k| sums[*k] > 0.0 && balances.fixed[*k].is_none());
        Ok(free.fold(f64::INFINITY, |least, k| least.min(bound(k))))
    }

    /// Takes a part of a step: no linear system.
    pub(super) fn step_explicitly(&mut self, balances: Balances) -> Result<u32, FluidError> {
        let state = self.model.fluid.state;
        let of_mass = |k: usize, mass: f64| state.pressure(mass / balances.storage[k].volume);
        let pressure = |k: usize| {
            balances.fixed[k].map_or_else(|| of_mass(k, balances.mass[k]), |(pressure, _)| pressure)
        };
        let pressures: Vec<f64> = (0..balances.mass.len()).map(pressure).collect();
        let drops = self.drops(&balances, &pressures);
        let full = self.full_outflows(&balances, &drops);
        let part = |k: usize| {
            if pressures[k] > state.lowest_pressure() { 1.0 } else { balances.unfilled(k, [0.0, full[k]]) }
        };
        let parts: Vec<f64> = (0..pressures.len()).map(part).collect();
        let mut flows = vec![0.0; self.topology.links.len()];
        let out = self.outflows(&balances, &drops, &parts, &mut flows);
        let after: Vec<f64> = (0..pressures.len())
            .map(|k| match balances.fixed[k] {
                Some((pressure, _)) => pressure,
                None => of_mass(k, balances.mass[k] + balances.supplied[k] - balances.leak[k] - out[k]),
            })
            .collect();
        self.flows = flows.iter().map(|mass| mass / balances.step).collect();
        self.close(balances, &after, &out)?;
        Ok(0)
    }
}
