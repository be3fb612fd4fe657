//! The balance of each compartment over a step, which both schemes solve.

use super::{Connection, Network};
use crate::error::FluidError;
use crate::source::Drive;
use crate::storage::Storage;
use crate::topology::Arm;

/// One part of a step, for each compartment and each link.
#[derive(Clone, Debug, Default)]
pub(super) struct Balances {
    /// Length of the part, and the time at its end, s.
    pub(super) step: f64,
    pub(super) end: f64,
    /// Mass at its beginning, kg.
    pub(super) mass: Vec<f64>,
    /// Mass that rates inject, kg.
    pub(super) supplied: Vec<f64>,
    /// Mass that leaks off, kg.
    pub(super) leak: Vec<f64>,
    pub(super) storage: Vec<Storage>,
    /// Mass that fills the compartment at the lowest pressure, kg.
    pub(super) full: Vec<f64>,
    /// Pressure that a source prescribes, Pa, and the number of that source.
    pub(super) fixed: Vec<Option<(f64, usize)>>,
    /// Pressure at the beginning, Pa.
    pub(super) pressure: Vec<f64>,
    /// Compartments from the highest one to the lowest.
    pub(super) downwards: Vec<u32>,
    /// Mass that flows through each link for each Pa, kg/Pa.
    pub(super) weight: Vec<f64>,
    /// Pressure by gravity that drives fluid from the first end of each link to the second, Pa.
    pub(super) head: Vec<f64>,
}

impl Balances {
    /// Part of the flow that leaves a compartment that is not full: its saturation `s` at the end, of `s
    /// m_full = m + in - s m_out`, with the mass `in` that flows into it and the mass `m_out` that would
    /// leave it if it was full, kg. So it never loses more than it has.
    pub(super) fn unfilled(&self, k: usize, [inflow, outflow]: [f64; 2]) -> f64 {
        let mass = self.mass[k] + self.supplied[k] - self.leak[k] + inflow;
        if mass > 0.0 && self.full[k] > 0.0 { mass / (self.full[k] + outflow) } else { 0.0 }
    }

    /// Takes a mass that a compartment does not have off its leak, and then off the mass that is taken out of
    /// it: an empty compartment neither leaks nor yields. Returns the mass that could be spared, kg.
    fn spare(&mut self, k: usize, lacking: f64) -> f64 {
        let leak = self.leak[k].min(lacking);
        self.leak[k] -= leak;
        let taken = (-self.supplied[k]).max(0.0).min(lacking - leak);
        self.supplied[k] += taken;
        leak + taken
    }
}

/// Mass below zero that is the rounding of a sum, as a part of its terms.
const ROUNDING: f64 = 1e-14;

impl<const D: usize> Network<D> {
    /// The balances from the present time to `end`.
    pub(super) fn balances(&self, end: f64) -> Result<Balances, FluidError> {
        let count = self.topology.len();
        let mut new = Balances { step: end - self.state.time, end, ..Balances::default() };
        let fluid = &self.model.fluid.state;
        for compartment in 0..count {
            let members = self.topology.members(compartment);
            let rows = || members.iter().map(|row| *row as usize);
            let sum = |value: &dyn Fn(usize) -> f64| rows().fold(0.0, |sum, row| sum + value(row));
            let volume = sum(&|row| self.storage(row).volume);
            let compliance = sum(&|row| self.storage(row).compliance);
            // The mean over the members, by their parts.
            let mean = |part: &dyn Fn(usize) -> f64, value: &[f64], whole: f64| match members {
                [row] => value[*row as usize],
                _ => sum(&|row| part(row) * value[row]) / whole,
            };
            let pressure = mean(&|row| self.storage(row).volume, &self.state.pressure, volume);
            let reference = if compliance > 0.0 {
                mean(&|row| self.storage(row).compliance, &self.state.reference, compliance)
            } else {
                pressure
            };
            let storage = Storage { volume, compliance, reference };
            new.full.push(storage.mass(fluid, fluid.lowest_pressure())[0]);
            new.storage.push(storage);
            new.pressure.push(pressure);
            new.mass.push(sum(&|row| self.state.mass[row]));
            new.leak.push(sum(&|row| self.leak(row, end)));
        }
        new.supplied = vec![0.0; count];
        new.downwards = (0..count as u32).collect();
        new.fixed = vec![None; count];
        self.add_sources(&mut new, end)?;
        self.add_links(&mut new);
        Ok(new)
    }

    /// Mass that a cell loses through both faces until a time, kg: `4 A C_L (√(t1 - t_c) - √(t0 - t_c))`
    /// where it is full (R. D. Carter, appendix of G. C. Howard and C. R. Fast, Drilling and Production
    /// Practice, API 57-261, 1957).
    fn leak(&self, row: usize, end: f64) -> f64 {
        let Some(cell) = self.cells.get(row).filter(|cell| cell.leak_off > 0.0) else { return 0.0 };
        let since = self.state.wet_since[row];
        if since > self.state.time {
            return 0.0;
        }
        let [before, after] = [self.state.time, end].map(|time| (time - since).sqrt());
        let difference = (end - self.state.time) / (before + after);
        let volume = 4.0 * self.opened[row].area * cell.leak_off * difference;
        volume * self.model.fluid.state.reference_density() * self.saturation(row)
    }

    fn add_sources(&self, new: &mut Balances, end: f64) -> Result<(), FluidError> {
        let density = self.model.fluid.state.reference_density();
        for (k, source) in self.sources.iter().enumerate() {
            let Some(drive) = &source.drive else { continue };
            // The smallest member of a compartment may be another one: the source is one of its members.
            let compartment = self.topology.compartment[self.cells.len() + k] as usize;
            let is_dry = compartment >= self.topology.len();
            match drive {
                Drive::Rate(rate) => {
                    let volume = rate.integral(self.state.time, end);
                    if is_dry && volume != 0.0 {
                        return Err(FluidError::Unconnected { source: source.key });
                    }
                    if !is_dry {
                        new.supplied[compartment] += density * volume;
                    }
                }
                Drive::Pressure(_) if is_dry => {
                    return Err(FluidError::Unconnected { source: source.key });
                }
                Drive::Pressure(pressure) => {
                    if let Some((_, other)) = new.fixed[compartment].replace((pressure.at(end), k)) {
                        let sources = [self.sources[other].key, source.key];
                        return Err(FluidError::SharedCavity { sources });
                    }
                }
            }
        }
        Ok(())
    }

    /// Conductances of links: at a junction without volume, the arms `G_c = b K/l` of its cells are joined to
    /// links `G_c G_d/Σ G` between each two of them. For two cells that is the harmonic mean.
    fn add_links(&self, new: &mut Balances) {
        if self.model.connection == Connection::Cavities {
            return;
        }
        let topology = &self.topology;
        let viscosity = self.model.fluid.viscosity;
        let conductance =
            |arm: &Arm| self.opened[arm.cell as usize].conductance(arm.door as usize, viscosity);
        let arms: Vec<f64> = topology.arms.iter().map(conductance).collect();
        let sums: Vec<f64> = (topology.junctions.windows(2))
            .map(|ends| arms[ends[0]..ends[1]].iter().fold(0.0, |sum, arm| sum + arm))
            .collect();
        let gravity = self.model.gravity;
        // Gravity times the place, m²/s²: it grows downwards.
        let depth = |place: [f64; D]| (0..D).fold(0.0, |sum, axis| sum + gravity[axis] * place[axis]);
        let depths: Vec<f64> = (0..topology.len()).map(|k| depth(self.place(k))).collect();
        new.downwards.sort_by(|a, b| depths[*a as usize].total_cmp(&depths[*b as usize]));
        for link in &topology.links {
            let [from, to] = link.ends.map(|end| end as usize);
            let density = self.model.fluid.state.mean_density([new.pressure[from], new.pressure[to]]);
            let [a, b] = link.arms.map(|arm| arms[arm as usize]);
            let weight = new.step * density * (a * (b / sums[link.junction as usize]));
            let head = density * (depths[to] - depths[from]);
            new.weight.push(weight);
            new.head.push(head);
        }
    }

    /// Centre of the cells of a compartment, by their areas; without cells it has no links, and any place.
    fn place(&self, compartment: usize) -> [f64; D] {
        let members = self.topology.members(compartment);
        let cells = || members.iter().filter_map(|row| self.opened.get(*row as usize));
        if let [row] = members {
            return self.opened.get(*row as usize).map_or([0.0; D], |opened| opened.centre);
        }
        let area = cells().fold(0.0, |sum, cell| sum + cell.area);
        let at = |axis: usize| cells().fold(0.0, |sum, cell| sum + cell.area * cell.centre[axis]) / area;
        std::array::from_fn(|axis| if area > 0.0 { at(axis) } else { 0.0 })
    }

    /// The pressure that drives fluid through each link, Pa.
    pub(super) fn drops(&self, balances: &Balances, pressure: &[f64]) -> Vec<f64> {
        let drop =
            |(ends, head): ([u32; 2], &f64)| pressure[ends[0] as usize] - pressure[ends[1] as usize] + head;
        self.topology.links.iter().map(|link| link.ends).zip(&balances.head).map(drop).collect()
    }

    /// Mass that would leave each compartment through its links if that was full, kg.
    pub(super) fn full_outflows(&self, balances: &Balances, drops: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; balances.mass.len()];
        for ((link, weight), drop) in self.topology.links.iter().zip(&balances.weight).zip(drops) {
            out[link.along(*drop)[0] as usize] += weight * drop.abs();
        }
        out
    }

    /// Mass that leaves each compartment through its links, kg. `parts`: of the flow that leaves it.
    pub(super) fn outflows(
        &self,
        balances: &Balances,
        drops: &[f64],
        parts: &[f64],
        flows: &mut [f64],
    ) -> Vec<f64> {
        let mut out = vec![0.0; parts.len()];
        for (((link, flow), weight), drop) in
            self.topology.links.iter().zip(flows).zip(&balances.weight).zip(drops)
        {
            let [from, to] = link.ends.map(|end| end as usize);
            *flow = weight * drop * parts[link.along(*drop)[0] as usize];
            out[from] += *flow;
            out[to] -= *flow;
        }
        out
    }

    /// Closes the balance of a step whose pressures and outflows are known. Masses follow from flows, so that
    /// no mass is lost however well the pressures are known.
    pub(super) fn close(
        &mut self,
        mut balances: Balances,
        pressure: &[f64],
        out: &[f64],
    ) -> Result<(), FluidError> {
        let planned = balances.supplied.clone();
        for k in 0..self.topology.len() {
            let mut mass = balances.mass[k] + balances.supplied[k] - balances.leak[k] - out[k];
            if let Some((fixed, source)) = balances.fixed[k] {
                let held = balances.storage[k].mass(&self.model.fluid.state, fixed)[0];
                self.state.injected[source] += held - mass;
                mass = held;
            }
            if mass < 0.0 {
                let sizes = balances.mass[k] + balances.supplied[k].abs() + balances.leak[k] + out[k].abs();
                mass += balances.spare(k, -mass);
                if mass < 0.0 && mass > -ROUNDING * sizes {
                    mass = 0.0;
                }
            }
            if mass.is_nan() || mass < 0.0 {
                return Err(self.not_converged(k, mass, balances.step));
            }
            self.state.leaked += balances.leak[k];
            self.share(k, mass, pressure[k], balances.end);
        }
        self.credit(&balances, &planned);
        Ok(())
    }

    /// Adds the mass that rates have supplied to their sources. Where less could be taken out than was
    /// planned, the sources of a compartment have the same part of their rates.
    fn credit(&mut self, balances: &Balances, planned: &[f64]) {
        let density = self.model.fluid.state.reference_density();
        for (k, source) in self.sources.iter().enumerate() {
            let compartment = self.topology.compartment[self.cells.len() + k] as usize;
            let (Some(Drive::Rate(rate)), true) = (&source.drive, compartment < planned.len()) else {
                continue;
            };
            let mass = density * rate.integral(self.state.time, balances.end);
            let [supplied, planned] = [balances.supplied[compartment], planned[compartment]];
            self.state.injected[k] += if supplied == planned { mass } else { mass * (supplied / planned) };
            self.state.missed += if supplied == planned { 0.0 } else { mass * (supplied / planned) - mass };
        }
    }

    /// Shares the mass of a compartment among its members by their volumes.
    fn share(&mut self, compartment: usize, mass: f64, pressure: f64, end: f64) {
        let members: Vec<usize> =
            self.topology.members(compartment).iter().map(|row| *row as usize).collect();
        let volumes: Vec<f64> = members.iter().map(|row| self.storage(*row).volume).collect();
        let whole = volumes.iter().fold(0.0, |sum, volume| sum + volume);
        // The largest one takes the rounding of the others.
        let largest = (0..volumes.len()).fold(0, |best, k| if volumes[k] > volumes[best] { k } else { best });
        let parts: Vec<f64> = volumes.iter().map(|volume| mass * (volume / whole)).collect();
        let others = (0..parts.len()).filter(|k| *k != largest).fold(0.0, |sum, k| sum + parts[k]);
        for (k, row) in members.iter().enumerate() {
            let part = if k == largest { mass - others } else { parts[k] };
            self.state.mass[*row] = part;
            self.state.pressure[*row] = pressure;
            if part > 0.0 {
                self.state.wet_since[*row] = self.state.wet_since[*row].min(end);
            }
        }
    }

    pub(super) fn not_converged(&self, compartment: usize, mass: f64, step: f64) -> FluidError {
        let (what, key) = self.name(self.topology.members(compartment)[0] as usize);
        FluidError::NotConverged { what, key, mass, step }
    }
}
