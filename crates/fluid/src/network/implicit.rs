//! A step by backward Euler: all pressures at its end together.
//!
//! Unknown are the pressures of full compartments; those of the others are the lowest one, and their masses
//! follow from the flows. Newton's method on the full ones, and a compartment that is found to hold more, or
//! less, than its volume changes sides: the primal-dual active set method for the complementarity of pressure
//! and empty volume (M. Hintermüller, K. Ito and K. Kunisch, SIAM J. Optim. 13 (2002) 865-888). The matrix is
//! symmetric with a positive diagonal and no positive entry beside it, and the mass rises with the pressure,
//! for which that method converges. Derivatives leave out how the outflow of an unfilled compartment depends
//! on the pressures above it, which keeps the matrix symmetric; a step that does not converge therefore is
//! taken in parts.

use super::Network;
use super::balances::Balances;
use crate::error::FluidError;
use crate::fluid::StateEquation;

/// Largest number of linear systems for a step. A front passes one row of cells in each.
const MOST: u32 = 400;

/// Error of a mass as a part of all that is added up to it, at which one more solution reaches rounding.
const ENOUGH: f64 = 1e-12;

/// The iterate.
struct Iterate {
    pressure: Vec<f64>,
    is_full: Vec<bool>,
    /// Pressure that drives fluid through each link, Pa.
    drops: Vec<f64>,
    /// Mass that would leave each compartment if it was full, kg.
    full_out: Vec<f64>,
    /// Part of the flow that leaves each compartment.
    parts: Vec<f64>,
    /// Mass through each link, kg.
    flows: Vec<f64>,
    /// Mass that leaves each compartment through its links, kg.
    out: Vec<f64>,
}

impl Iterate {
    fn of(balances: &Balances, state: &StateEquation, links: usize) -> Self {
        let lowest = state.lowest_pressure();
        let count = balances.mass.len();
        let fixed = |k: usize| balances.fixed[k].map(|(pressure, _)| pressure);
        let is_full: Vec<bool> = (0..count)
            .map(|k| fixed(k).is_some() || balances.pressure[k] > lowest && balances.mass[k] > 0.0)
            .collect();
        let pressure = |k: usize| fixed(k).unwrap_or(if is_full[k] { balances.pressure[k] } else { lowest });
        Self {
            pressure: (0..count).map(pressure).collect(),
            is_full,
            drops: vec![0.0; links],
            full_out: vec![0.0; count],
            parts: vec![0.0; count],
            flows: vec![0.0; links],
            out: vec![0.0; count],
        }
    }

    /// Whether the pressure of a compartment is unknown.
    fn is_unknown(&self, balances: &Balances, k: usize) -> bool {
        self.is_full[k] && balances.fixed[k].is_none()
    }

    /// Adds the change of the pressures. Returns whether a compartment has ceased to be full.
    fn add(&mut self, change: &[f64], balances: &Balances, state: &StateEquation) -> bool {
        let lowest = state.lowest_pressure();
        let mut has_changed = false;
        for (k, change) in change.iter().enumerate() {
            if !self.is_unknown(balances, k) {
                continue;
            }
            let pressure = self.pressure[k] + change;
            self.pressure[k] = match *state {
                // The mass is exponential in the pressure: a change by one bulk modulus at most.
                StateEquation::Liquid { bulk_modulus, .. } => pressure.min(self.pressure[k] + bulk_modulus),
                StateEquation::Gas { .. } => pressure.max(0.1 * self.pressure[k]),
            };
            if self.pressure[k] <= lowest {
                self.pressure[k] = lowest;
                self.is_full[k] = false;
                has_changed = true;
            }
        }
        has_changed
    }
}

impl<const D: usize> Network<D> {
    /// Takes a step, and returns the number of linear systems.
    pub(super) fn step_implicitly(&mut self, balances: Balances) -> Result<u32, FluidError> {
        let state = self.model.fluid.state;
        let mut iterate = Iterate::of(&balances, &state, self.topology.links.len());
        let mut is_near = false;
        let mut solutions = 0;
        while solutions < MOST {
            self.settle(&mut iterate, &balances);
            let has_filled = fill(&mut iterate, &balances, &state);
            let (worst, error) = self.worst(&iterate, &balances);
            if !error.is_finite() {
                return Err(self.not_converged(worst, error, balances.step));
            }
            if is_near && !has_filled && error <= ENOUGH {
                return self.finish(balances, &iterate).map(|()| solutions);
            }
            let change = self.newton(&iterate, &balances, &mut solutions)?;
            let has_emptied = iterate.add(&change, &balances, &state);
            is_near = error <= ENOUGH && !has_filled && !has_emptied;
        }
        let (worst, _) = self.worst(&iterate, &balances);
        Err(self.not_converged(worst, self.residual(&iterate, &balances, worst)[0], balances.step))
    }

    /// Finds the flows at the pressures of an iterate. Unfilled compartments pass on a part of their inflow,
    /// from the highest one downwards.
    fn settle(&self, iterate: &mut Iterate, balances: &Balances) {
        iterate.drops = self.drops(balances, &iterate.pressure);
        iterate.full_out = self.full_outflows(balances, &iterate.drops);
        let links = &self.topology.links;
        let ends = |k: usize| links[k].along(iterate.drops[k]).map(|end| end as usize);
        let mut inflow = vec![0.0; iterate.parts.len()];
        for (k, (weight, drop)) in balances.weight.iter().zip(&iterate.drops).enumerate() {
            let [from, to] = ends(k);
            inflow[to] += if iterate.is_full[from] { weight * drop.abs() } else { 0.0 };
        }
        for &compartment in &balances.downwards {
            let at = compartment as usize;
            if iterate.is_full[at] {
                iterate.parts[at] = 1.0;
                continue;
            }
            iterate.parts[at] = balances.unfilled(at, [inflow[at], iterate.full_out[at]]);
            for &k in self.topology.links_of(at) {
                let [from, to] = ends(k as usize);
                if from == at {
                    inflow[to] +=
                        balances.weight[k as usize] * iterate.drops[k as usize].abs() * iterate.parts[at];
                }
            }
        }
        iterate.out = self.outflows(balances, &iterate.drops, &iterate.parts, &mut iterate.flows);
    }

    fn finish(&mut self, balances: Balances, iterate: &Iterate) -> Result<(), FluidError> {
        let step = balances.step;
        self.close(balances, &iterate.pressure, &iterate.out)?;
        self.flows = iterate.flows.iter().map(|mass| mass / step).collect();
        Ok(())
    }

    /// Mass of a full compartment at its pressure, less the mass by its balance, kg; its derivative by the
    /// pressure without links, kg/Pa; and the sum of the sizes of all that was added up, without links.
    fn residual(&self, iterate: &Iterate, balances: &Balances, k: usize) -> [f64; 3] {
        let left = left(iterate, balances, k);
        let [mass, slope] = balances.storage[k].mass(&self.model.fluid.state, iterate.pressure[k]);
        [mass - left, slope, mass + balances.mass[k] + balances.supplied[k].abs() + balances.leak[k]]
    }

    /// The compartment whose error is the largest part of all that is added up to its mass, and that part.
    fn worst(&self, iterate: &Iterate, balances: &Balances) -> (usize, f64) {
        let mut sizes = vec![0.0; iterate.pressure.len()];
        for ((link, weight), head) in self.topology.links.iter().zip(&balances.weight).zip(&balances.head) {
            let [from, to] = link.ends.map(|end| end as usize);
            let size = weight * (iterate.pressure[from].abs() + iterate.pressure[to].abs() + head.abs());
            sizes[from] += size;
            sizes[to] += size;
        }
        let mut worst = (0, 0.0);
        for k in (0..sizes.len()).filter(|k| iterate.is_unknown(balances, *k)) {
            let [error, _, size] = self.residual(iterate, balances, k);
            let part = error.abs() / (size + sizes[k]);
            if part > worst.1 || part.is_nan() {
                worst = (k, part);
            }
            if part.is_nan() {
                break;
            }
        }
        worst
    }

    /// The change of all pressures by Newton's method: that of the linear complementarity problem, in which
    /// no pressure falls below the lowest one. Compartments at which it would are found by solving again.
    fn newton(
        &mut self,
        iterate: &Iterate,
        balances: &Balances,
        solutions: &mut u32,
    ) -> Result<Vec<f64>, FluidError> {
        let count = iterate.pressure.len();
        let slopes = self.slopes(iterate, balances);
        let errors: Vec<f64> =
            (0..count)
                .map(|k| {
                    if iterate.is_unknown(balances, k) { self.residual(iterate, balances, k)[0] } else { 0.0 }
                })
                .collect();
        // A gas is never at its lowest pressure; a change that would take it there is shortened later.
        let lowest = match self.model.fluid.state {
            StateEquation::Liquid { cavitation_pressure, .. } => cavitation_pressure,
            StateEquation::Gas { .. } => f64::NEG_INFINITY,
        };
        let mut is_free: Vec<bool> = (0..count).map(|k| iterate.is_unknown(balances, k)).collect();
        let mut change = vec![0.0; count];
        for _ in 0..MOST {
            self.solve(&slopes, &errors, &is_free, &mut change)?;
            *solutions += 1;
            let mut has_changed = false;
            let rest = self.product(&slopes, &change);
            for k in (0..count).filter(|k| iterate.is_unknown(balances, *k)) {
                let fall = lowest - iterate.pressure[k];
                if is_free[k] && change[k] < fall {
                    (is_free[k], change[k], has_changed) = (false, fall, true);
                } else if !is_free[k] && errors[k] + rest[k] < 0.0 {
                    (is_free[k], has_changed) = (true, true);
                }
            }
            if !has_changed {
                break;
            }
        }
        Ok(change)
    }

    /// Derivatives of the errors of the masses by the pressures, kg/Pa.
    fn slopes(&self, iterate: &Iterate, balances: &Balances) -> Slopes {
        let is_unknown = |k: usize| iterate.is_unknown(balances, k);
        let slope = |k: usize| if is_unknown(k) { self.residual(iterate, balances, k)[1] } else { 1.0 };
        let storage: Vec<f64> = (0..iterate.pressure.len()).map(slope).collect();
        let mut slopes = Slopes {
            diagonal: storage.clone(),
            sums: storage,
            entries: vec![0.0; self.topology.entries.len()],
        };
        for ((link, weight), drop) in self.topology.links.iter().zip(&balances.weight).zip(&iterate.drops) {
            let [from, to] = link.ends.map(|end| end as usize);
            let above = link.along(*drop)[0] as usize;
            let mut slope = weight * iterate.parts[above];
            if !iterate.is_full[above] && slope > 0.0 {
                // Its saturation rises as less of it flows off.
                slope *= 1.0 - weight * drop.abs() / (balances.full[above] + iterate.full_out[above]);
            }
            let is_inside = is_unknown(from) && is_unknown(to);
            for k in [from, to].into_iter().filter(|k| is_unknown(*k)) {
                slopes.diagonal[k] += slope;
                slopes.sums[k] += if is_inside { 0.0 } else { slope };
            }
            if is_inside {
                slopes.entries[link.entry as usize] -= slope;
            }
        }
        slopes
    }

    /// Solves for the changes that are free, at which the errors vanish; the others stay.
    fn solve(
        &mut self,
        slopes: &Slopes,
        errors: &[f64],
        is_free: &[bool],
        change: &mut [f64],
    ) -> Result<(), FluidError> {
        let held: Vec<f64> = (0..change.len()).map(|k| if is_free[k] { 0.0 } else { change[k] }).collect();
        let rest = self.product(slopes, &held);
        let (mut entries, mut sums) = (slopes.entries.clone(), slopes.sums.clone());
        for (entry, [a, b]) in entries.iter_mut().zip(&self.topology.entries) {
            if !(is_free[*a as usize] && is_free[*b as usize]) {
                let slope = -std::mem::take(entry);
                sums[*a as usize] += slope;
                sums[*b as usize] += slope;
            }
        }
        for (k, change) in change.iter_mut().enumerate() {
            *change = if is_free[k] { -(errors[k] + rest[k]) } else { 0.0 };
        }
        self.solver.factor(&slopes.diagonal, &entries, Some(&sums)).map_err(|k| {
            let (what, key) = self.name(self.topology.members(k)[0] as usize);
            FluidError::Pivot { what, key }
        })?;
        self.solver.solve(change);
        (0..change.len()).filter(|k| !is_free[*k]).for_each(|k| change[k] = held[k]);
        Ok(())
    }

    /// The product of the slopes with a change of the pressures, kg.
    fn product(&self, slopes: &Slopes, change: &[f64]) -> Vec<f64> {
        let mut product: Vec<f64> = slopes.diagonal.iter().zip(change).map(|(a, b)| a * b).collect();
        for (entry, [a, b]) in slopes.entries.iter().zip(&self.topology.entries) {
            let [a, b] = [*a as usize, *b as usize];
            product[a] += entry * change[b];
            product[b] += entry * change[a];
        }
        product
    }
}

/// The matrix of a linear system.
struct Slopes {
    diagonal: Vec<f64>,
    /// Sums of the rows.
    sums: Vec<f64>,
    /// By the entries of the topology.
    entries: Vec<f64>,
}

/// Mass of a compartment by its balance, kg.
fn left(iterate: &Iterate, balances: &Balances, k: usize) -> f64 {
    balances.mass[k] + balances.supplied[k] - balances.leak[k] - iterate.out[k]
}

/// Compartments that hold more than their volume at the lowest pressure are full from now on. Returns whether
/// there are new ones.
fn fill(iterate: &mut Iterate, balances: &Balances, state: &StateEquation) -> bool {
    let mut has_changed = false;
    for k in 0..iterate.pressure.len() {
        let left = left(iterate, balances, k);
        if iterate.is_full[k] || left <= balances.full[k] {
            continue;
        }
        if let StateEquation::Gas { .. } = state {
            iterate.pressure[k] = state.pressure(left / balances.storage[k].volume);
        }
        iterate.is_full[k] = true;
        has_changed = true;
    }
    has_changed
}
