//! The network: cells, sources, and the door for callers.
//!
//! Its parts import each other in this order: `balances`, `implicit`, `explicit`.

mod balances;
mod explicit;
mod implicit;

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::cell::{Cell, Opened, Place, Shape};
use crate::error::{FluidError, check};
use crate::fluid::Fluid;
use crate::ldl::Ldl;
use crate::outlet::Outlet;
use crate::source::{Drive, Source};
use crate::state::{Balance, NetworkState};
use crate::storage::Storage;
use crate::topology::{DRY, Topology};

/// Largest number of parts of an explicit step.
const MOST_PARTS: f64 = 1e6;

/// The time integration of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scheme {
    /// Backward Euler: stable at any step.
    #[default]
    Implicit,
    /// Forward Euler in as many parts as [`Network::explicit_bound`] asks for; for rigid walls, to check the
    /// other one.
    Explicit,
}

/// The law of the flow between cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Connection {
    /// By the cubic law.
    #[default]
    CubicLaw,
    /// Without resistance: all cells that are connected, and sources at them, have one pressure.
    Cavities,
}

/// The model of a network: all that does not change during a run, but for cells and sources.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub struct FlowModel<const D: usize> {
    /// The fluid.
    pub fluid: Fluid,
    /// Gravity, m/s².
    pub gravity: [f64; D],
    /// Thickness of a model in the plane, m; ignored in space.
    pub thickness: f64,
    /// The time integration of a step.
    pub scheme: Scheme,
    /// The law of the flow between cells.
    pub connection: Connection,
}

impl<const D: usize> FlowModel<D> {
    /// Flow without gravity by the cubic law, in implicit steps, at a thickness of 1 m.
    pub fn new(fluid: Fluid) -> Self {
        let (scheme, connection) = (Scheme::Implicit, Connection::CubicLaw);
        Self { fluid, gravity: [0.0; D], thickness: 1.0, scheme, connection }
    }

    fn check(&self) -> Result<(), FluidError> {
        const { assert!(D == 2 || D == 3, "networks are in the plane or in space") };
        self.fluid.check()?;
        check(self.thickness > 0.0, "model", "thickness", self.thickness, "positive")?;
        self.gravity.iter().try_for_each(|&value| check(true, "model", "gravity", value, "finite"))
    }
}

/// The work that a step took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepReport {
    /// Number of parts in which it was taken.
    pub parts: u32,
    /// Number of linear systems that were solved.
    pub solutions: u32,
}

/// Flow between two cells, from the first one to the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Keys of the cells.
    pub cells: [u64; 2],
    /// Mean rate over the last part of the last step, m³/s at the reference density.
    pub rate: f64,
}

/// State of a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injection {
    /// Pressure in its volume and its cells, Pa.
    pub pressure: f64,
    /// Mean rate over the last step, m³/s at the reference density.
    pub rate: f64,
    /// Volume injected since the beginning, m³ at the reference density.
    pub injected: f64,
}

/// A network of cells that are filled with fluid, and flow between them.
///
/// The front page of the crate has the equations, and the order of calls in a coupled step.
///
/// # Shapes
/// Columns that go in and come out have a row for each cell, in the order in which the cells were given.
///
/// # Cost
/// A step takes a few linear systems: time `n` for cracks in the plane, `n^1.5` for cracks in space, with a
/// small factor. New cells and cells that become wet cost one analysis of the matrix, `n log n`.
#[derive(Clone, Debug)]
pub struct Network<const D: usize> {
    model: FlowModel<D>,
    /// By their keys.
    cells: Vec<Cell<D>>,
    /// The place of each of the caller's cells.
    order: Vec<u32>,
    opened: Vec<Opened<D>>,
    sources: Vec<Source>,
    /// The cells of each source.
    source_cells: Vec<Vec<u32>>,
    topology: Topology,
    solver: Ldl,
    state: NetworkState,
    /// Mass that has passed each link in the last part of the last step, kg/s.
    flows: Vec<f64>,
}

impl<const D: usize> Network<D> {
    /// A network at time 0.
    ///
    /// # Shapes
    /// `shapes`: one for each of `cells`.
    ///
    /// # Errors
    /// Numbers out of their ranges, keys or corners that are there twice, sources without a place or at the
    /// same cell, lists of other lengths.
    pub fn new(
        model: FlowModel<D>,
        mut sources: Vec<Source>,
        cells: &[Cell<D>],
        shapes: &[Shape<D>],
    ) -> Result<Self, FluidError> {
        model.check()?;
        let lowest = model.fluid.state.lowest_pressure();
        sources.sort_by_key(|source| source.key);
        if let Some(pair) = sources.windows(2).find(|pair| pair[0].key == pair[1].key) {
            return Err(FluidError::SameKey { what: "source", key: pair[0].key });
        }
        let mut state = NetworkState::default();
        for source in &sources {
            source.check(lowest)?;
            state.sources.push(source.key);
            state.injected.push(0.0);
            state.rate.push(0.0);
            state.push_dry(lowest);
        }
        let mut new = Self {
            model,
            cells: Vec::new(),
            order: Vec::new(),
            opened: Vec::new(),
            source_cells: vec![Vec::new(); sources.len()],
            sources,
            topology: Topology::default(),
            solver: Ldl::of(0, &[]),
            state,
            flows: Vec::new(),
        };
        new.renew(cells, shapes)?;
        Ok(new)
    }

    /// Replaces the cells, because new ones have opened or corners have other numbers. Cells keep their fluid
    /// by their keys.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), and cells with fluid that are missing: [`drain`](Self::drain) them
    /// before.
    pub fn renew(&mut self, cells: &[Cell<D>], shapes: &[Shape<D>]) -> Result<(), FluidError> {
        let lowest = self.model.fluid.state.lowest_pressure();
        cells.iter().try_for_each(|cell| cell.check(lowest))?;
        let mut by_key: Vec<u32> = (0..cells.len() as u32).collect();
        by_key.sort_by_key(|of| cells[*of as usize].key);
        let sorted: Vec<Cell<D>> = by_key.iter().map(|of| cells[*of as usize]).collect();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].key == pair[1].key) {
            return Err(FluidError::SameKey { what: "cell", key: pair[0].key });
        }
        let mut order = vec![0; cells.len()];
        by_key.iter().enumerate().for_each(|(place, of)| order[*of as usize] = place as u32);
        let mut new = self.clone();
        new.source_cells = places(&self.sources, &sorted)?;
        new.state = self.state_of(&sorted)?;
        (new.cells, new.order) = (sorted, order);
        new.opened = vec![Opened::DRY; cells.len()];
        new.take_shapes(shapes)?;
        new.connect();
        *self = new;
        Ok(())
    }

    /// The state with the rows of other cells.
    fn state_of(&self, cells: &[Cell<D>]) -> Result<NetworkState, FluidError> {
        let lowest = self.model.fluid.state.lowest_pressure();
        let old = &self.state;
        let mut state = NetworkState {
            mass: Vec::new(),
            pressure: Vec::new(),
            reference: Vec::new(),
            wet_since: Vec::new(),
            was_wet: Vec::new(),
            cells: cells.iter().map(|cell| cell.key).collect(),
            ..old.clone()
        };
        let lost = (0..old.cells.len())
            .find(|row| old.mass[*row] > 0.0 && state.cells.binary_search(&old.cells[*row]).is_err());
        if let Some(row) = lost {
            let (key, mass) = (old.cells[row], old.mass[row]);
            return Err(FluidError::MassLost { what: "cell", key, mass });
        }
        for cell in cells {
            match old.cells.binary_search(&cell.key) {
                Ok(row) => state.push_row(old, row),
                Err(_) => state.push_dry(lowest),
            }
        }
        (old.cells.len()..old.mass.len()).for_each(|row| state.push_row(old, row));
        Ok(state)
    }

    /// Takes the fluid out of cells, which may then be missing or dry. Returns its mass, kg. Cells that are
    /// wet again later are empty.
    ///
    /// # Errors
    /// Keys of cells that do not exist.
    pub fn drain(&mut self, keys: &[u64]) -> Result<f64, FluidError> {
        let row = |key: &u64| {
            let unknown = || FluidError::State(format!("there is no cell {key} to drain"));
            self.state.cells.binary_search(key).map_err(|_| unknown())
        };
        let rows = keys.iter().map(row).collect::<Result<BTreeSet<usize>, FluidError>>()?;
        let mut drained = 0.0;
        for row in rows {
            drained += std::mem::take(&mut self.state.mass[row]);
            self.state.pressure[row] = self.model.fluid.state.lowest_pressure();
            self.state.wet_since[row] = f64::INFINITY;
        }
        self.state.drained += drained;
        Ok(drained)
    }

    /// Takes over the shapes of all cells, before a step.
    ///
    /// # Errors
    /// Numbers out of their ranges, and cells with fluid that are no longer wet.
    pub fn update(&mut self, shapes: &[Shape<D>]) -> Result<(), FluidError> {
        if self.take_shapes(shapes)? {
            self.connect();
        }
        Ok(())
    }

    /// Takes over the shapes. Returns whether other cells are wet than before.
    fn take_shapes(&mut self, shapes: &[Shape<D>]) -> Result<bool, FluidError> {
        let (found, expected) = (shapes.len(), self.cells.len());
        if found != expected {
            return Err(FluidError::Length { what: "shapes", found, expected });
        }
        let mut opened = vec![Opened::DRY; expected];
        for (&place, shape) in self.order.iter().zip(shapes) {
            let place = place as usize;
            let cell = &self.cells[place];
            opened[place] = cell.opened(shape, self.model.thickness)?;
            let mass = self.state.mass[place];
            if !shape.is_wet && mass > 0.0 {
                return Err(FluidError::MassLost { what: "cell", key: cell.key, mass });
            }
            if self.model.scheme == Scheme::Explicit {
                let (compliance, range) = (shape.compliance, "zero in the explicit scheme");
                check(compliance == 0.0, Place(cell.key), "compliance", compliance, range)?;
            }
        }
        let is_other = opened.iter().zip(&self.opened).any(|(new, old)| new.is_wet != old.is_wet);
        self.opened = opened;
        self.state.reference.clone_from(&self.state.pressure);
        self.fill_new();
        Ok(is_other)
    }

    /// Fills cells and sources that are wet for the first time to their initial pressures.
    fn fill_new(&mut self) {
        let fluid = &self.model.fluid.state;
        let cells = self.cells.iter().zip(&self.opened).map(|(cell, opened)| {
            (opened.is_wet, cell.initial_pressure.map(|pressure| (pressure, opened.volume())))
        });
        let sources = self.sources.iter().map(|source| {
            (source.volume > 0.0, source.initial_pressure.map(|pressure| (pressure, source.volume)))
        });
        for (row, (is_wet, initial)) in cells.chain(sources).enumerate() {
            if !is_wet || std::mem::replace(&mut self.state.was_wet[row], true) {
                continue;
            }
            if let Some((pressure, volume)) = initial {
                let mass = fluid.density(pressure) * volume;
                self.state.mass[row] = mass;
                self.state.initial += mass;
                (self.state.pressure[row], self.state.reference[row]) = (pressure, pressure);
                self.state.wet_since[row] = self.state.time;
            }
        }
    }

    /// Finds out which wet cells are connected.
    fn connect(&mut self) {
        let is_wet: Vec<bool> = self.opened.iter().map(|opened| opened.is_wet).collect();
        let volumes = self.sources.iter().map(|source| source.volume > 0.0);
        let sources: Vec<(Vec<u32>, bool)> = self.source_cells.iter().cloned().zip(volumes).collect();
        let is_cavities = self.model.connection == Connection::Cavities;
        self.topology = Topology::of(&self.cells, &is_wet, &sources, is_cavities);
        self.solver = Ldl::of(self.topology.len(), &self.topology.entries);
        self.flows = vec![0.0; self.topology.links.len()];
    }

    /// Sets the volume of a source, m³, such as that of a hole whose wall has moved.
    ///
    /// # Errors
    /// A source that does not exist, and a volume that is negative, or zero with fluid in it or without
    /// before.
    pub fn set_source_volume(&mut self, key: u64, volume: f64) -> Result<(), FluidError> {
        let at = self.source(key)?;
        let is_alike = (volume > 0.0) == (self.sources[at].volume > 0.0);
        check(volume >= 0.0 && is_alike, format!("source {key}"), "volume", volume, {
            "positive if it was positive, and zero if it was zero"
        })?;
        self.sources[at].volume = volume;
        Ok(())
    }

    /// Sets the keys of the cells of a source, such as those of new cracks at the wall of a hole. The next
    /// [`renew`](Self::renew) connects them.
    ///
    /// # Errors
    /// A source that does not exist.
    pub fn set_source_cells(&mut self, key: u64, cells: Vec<u64>) -> Result<(), FluidError> {
        let at = self.source(key)?;
        self.sources[at].cells = cells;
        Ok(())
    }

    /// Sets the quantity that a source prescribes, such as none when pumps stop.
    ///
    /// # Errors
    /// A source that does not exist, and values out of their range.
    pub fn set_drive(&mut self, key: u64, drive: Option<Drive>) -> Result<(), FluidError> {
        let at = self.source(key)?;
        let source = Source { drive, ..self.sources[at].clone() };
        source.check(self.model.fluid.state.lowest_pressure())?;
        self.sources[at] = source;
        Ok(())
    }

    fn source(&self, key: u64) -> Result<usize, FluidError> {
        let unknown = |_| FluidError::State(format!("there is no source {key}"));
        self.sources.binary_search_by_key(&key, |source| source.key).map_err(unknown)
    }

    /// Advances by a step, s. Where pressures are not found, it is taken in 2, 4, up to 64 parts.
    ///
    /// # Errors
    /// [`FluidError::NotConverged`] and [`FluidError::Pivot`], which name a cell; [`FluidError::Unconnected`]
    /// and [`FluidError::SharedCavity`] about sources; a step that is not positive. The network is unchanged
    /// then.
    pub fn advance(&mut self, step: f64) -> Result<StepReport, FluidError> {
        let is_later = self.state.time + step / 64.0 > self.state.time;
        check(step > 0.0 && is_later, "network", "step", step, "positive, and not lost beside the time")?;
        let before = (self.state.clone(), self.flows.clone());
        let mut parts = match self.model.scheme {
            Scheme::Implicit => 1,
            Scheme::Explicit => {
                let parts = (step / (0.9 * self.explicit_bound()?)).ceil().max(1.0);
                check(parts <= MOST_PARTS, "network", "number of parts of an explicit step", parts, {
                    "at most a million"
                })?;
                parts as u32
            }
        };
        loop {
            let failed = match self.advance_in(step, parts) {
                Ok(solutions) => return Ok(StepReport { parts, solutions }),
                Err(failed) => failed,
            };
            (self.state, self.flows) = before.clone();
            let is_hard = matches!(failed, FluidError::NotConverged { .. } | FluidError::Pivot { .. });
            if !is_hard || parts >= 64 {
                return Err(failed);
            }
            parts *= 2;
        }
    }

    /// Takes a step in parts, and returns the number of linear systems.
    fn advance_in(&mut self, step: f64, parts: u32) -> Result<u32, FluidError> {
        let begin = self.state.time;
        let injected = self.state.injected.clone();
        let mut solutions = 0;
        for part in 1..=parts {
            let end = begin + step * (f64::from(part) / f64::from(parts));
            let balances = self.balances(end)?;
            solutions += match self.model.scheme {
                Scheme::Implicit => self.step_implicitly(balances)?,
                Scheme::Explicit => self.step_explicitly(balances)?,
            };
            self.state.time = end;
        }
        for ((rate, after), before) in self.state.rate.iter_mut().zip(&self.state.injected).zip(injected) {
            *rate = (after - before) / step;
        }
        Ok(solutions)
    }

    /// The state, to save it.
    pub fn state(&self) -> &NetworkState {
        &self.state
    }

    /// Continues from a saved state. Cells, shapes and sources, with their volumes and drives, are those at
    /// which it was saved: the network was made with them.
    ///
    /// # Errors
    /// A state of other cells or sources, or with columns of other lengths.
    pub fn restore(&mut self, state: &NetworkState) -> Result<(), FluidError> {
        if state.cells != self.state.cells || state.sources != self.state.sources {
            return Err(FluidError::State(
                "the state has other cells or sources than the network".to_owned(),
            ));
        }
        if !state.is_sound() {
            return Err(FluidError::State(
                "the state has columns of other lengths or bad numbers".to_owned(),
            ));
        }
        let is_dry = |row: usize| self.topology.compartment[row] == DRY;
        if let Some(row) = (0..state.mass.len()).find(|row| is_dry(*row) && state.mass[*row] > 0.0) {
            let (what, key) = self.name(row);
            return Err(FluidError::MassLost { what, key, mass: state.mass[row] });
        }
        self.state = state.clone();
        self.flows.iter_mut().for_each(|flow| *flow = 0.0);
        Ok(())
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Pressure of each cell, Pa: the lowest one where it is dry or not full.
    pub fn pressures(&self) -> Vec<f64> {
        self.column(|row| self.state.pressure[row])
    }

    /// Mass of fluid in each cell, kg.
    pub fn masses(&self) -> Vec<f64> {
        self.column(|row| self.state.mass[row])
    }

    /// Hydraulic aperture of each cell, m: that of the last shapes; zero where it is not wet.
    pub fn apertures(&self) -> Vec<f64> {
        self.column(|row| if self.opened[row].is_wet { self.opened[row].aperture } else { 0.0 })
    }

    /// Area of one face of each cell, m², on which its pressure acts; zero where it is not wet.
    pub fn areas(&self) -> Vec<f64> {
        self.column(|row| if self.opened[row].is_wet { self.opened[row].area } else { 0.0 })
    }

    /// The part of each cell that is full, from 0 to 1.
    pub fn saturations(&self) -> Vec<f64> {
        self.column(|row| if self.opened[row].is_wet { self.saturation(row) } else { 0.0 })
    }

    /// Time at which fluid has reached each cell, s; infinite where there was none.
    pub fn wet_since(&self) -> Vec<f64> {
        self.column(|row| self.state.wet_since[row])
    }

    /// Flows between cells, by their compartments and keys.
    pub fn flows(&self) -> Vec<Flow> {
        let topology = &self.topology;
        let density = self.model.fluid.state.reference_density();
        let key = |arm: u32| self.cells[topology.arms[arm as usize].cell as usize].key;
        let links = topology.links.iter().zip(&self.flows);
        links.map(|(link, flow)| Flow { cells: link.arms.map(key), rate: flow / density }).collect()
    }

    /// State of a source.
    ///
    /// # Errors
    /// A source that does not exist.
    pub fn injection(&self, key: u64) -> Result<Injection, FluidError> {
        let at = self.source(key)?;
        let density = self.model.fluid.state.reference_density();
        let pressure = self.state.pressure[self.cells.len() + at];
        let [rate, injected] = [self.state.rate[at], self.state.injected[at]].map(|mass| mass / density);
        Ok(Injection { pressure, rate, injected })
    }

    /// Balance of the mass since the beginning. Sums are in the order of keys.
    pub fn balance(&self) -> Balance {
        let state = &self.state;
        let sum = |values: &[f64]| values.iter().fold(0.0, |sum, value| sum + value);
        Balance {
            initial: state.initial,
            injected: sum(&state.injected),
            leaked: state.leaked,
            drained: state.drained,
            stored: sum(&state.mass),
            missed: state.missed,
        }
    }

    /// Wet cells, in the order of their keys, as pores see them.
    pub(crate) fn outlets(&self) -> Vec<Outlet<D>> {
        let fluid = &self.model.fluid.state;
        let (lowest, density) = (fluid.lowest_pressure(), fluid.reference_density());
        let of = |row: usize| {
            let (pressure, mass, storage) =
                (self.state.pressure[row], self.state.mass[row], self.storage(row));
            let [full, slope] = storage.mass(fluid, pressure);
            let empty = if pressure > lowest { 0.0 } else { (full - mass).max(0.0) / density };
            let (vertices, capacity, held) = (self.cells[row].corners, slope / density, mass / density);
            Outlet { row, vertices, pressure, capacity, held, empty }
        };
        (0..self.cells.len()).filter(|row| self.opened[*row].is_wet).map(of).collect()
    }

    /// Takes volumes out of wet cells into pores, m³ at the reference density: no more than they have. The
    /// volume is part of the mass that has leaked.
    pub(crate) fn lose(&mut self, losses: &[(Outlet<D>, f64)]) {
        let fluid = self.model.fluid.state;
        let lowest = fluid.lowest_pressure();
        for (outlet, volume) in losses {
            let row = outlet.row;
            let lost = fluid.reference_density() * volume;
            self.state.mass[row] -= lost;
            self.state.leaked += lost;
            if outlet.pressure > lowest {
                // The next step finds it by the mass.
                self.state.pressure[row] = (outlet.pressure - volume / outlet.capacity).max(lowest);
            }
            if self.state.mass[row] > 0.0 {
                self.state.wet_since[row] = self.state.wet_since[row].min(self.state.time);
            }
        }
    }

    /// A column in the caller's order.
    fn column<T>(&self, value: impl Fn(usize) -> T) -> Vec<T> {
        self.order.iter().map(|row| value(*row as usize)).collect()
    }

    /// Volume of a member as a function of its pressure.
    fn storage(&self, row: usize) -> Storage {
        let reference = self.state.reference[row];
        let Some(opened) = self.opened.get(row) else {
            let volume = self.sources[row - self.cells.len()].volume;
            return Storage { volume, compliance: 0.0, reference };
        };
        Storage { volume: opened.volume(), compliance: opened.area * opened.compliance, reference }
    }

    /// The part of a wet member that is full.
    fn saturation(&self, row: usize) -> f64 {
        let (state, pressure) = (&self.model.fluid.state, self.state.pressure[row]);
        let full = state.density(state.lowest_pressure()) * self.storage(row).volume(pressure)[0];
        let mass = self.state.mass[row];
        if mass == 0.0 || mass >= full { f64::from(mass > 0.0) } else { mass / full }
    }

    /// "cell" or "source", and the key of a member.
    fn name(&self, row: usize) -> (&'static str, u64) {
        match self.cells.get(row) {
            Some(cell) => ("cell", cell.key),
            None => ("source", self.sources[row - self.cells.len()].key),
        }
    }
}

/// The places of the cells of each source.
fn places<const D: usize>(sources: &[Source], cells: &[Cell<D>]) -> Result<Vec<Vec<u32>>, FluidError> {
    let mut taken: Vec<Option<u64>> = vec![None; cells.len()];
    let mut places = Vec::new();
    for source in sources {
        let mut of = Vec::new();
        for &cell in &source.cells {
            let key = source.key;
            let at = cells.binary_search_by_key(&cell, |of| of.key);
            let at = at.map_err(|_| FluidError::NoCell { source: key, cell })?;
            match taken[at].replace(key) {
                Some(other) if other != key => {
                    return Err(FluidError::SharedCell { cell, sources: [other, key] });
                }
                _ => of.push(at as u32),
            }
        }
        of.sort_unstable();
        of.dedup();
        places.push(of);
    }
    Ok(places)
}
