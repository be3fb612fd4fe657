//! The memory of the fluid, as records: of each cell, of each source, and of the whole.

use std::collections::BTreeMap;

use fdem_distributed::wire;
use fdem_fluid::{NetworkState, Shape};

use crate::actions::cavity::face::Rim;
use crate::actions::fluid::cells::FluidCell;

/// The fluid of a whole run, for all ranks.
#[derive(Debug)]
pub(crate) struct SharedFluid<const D: usize> {
    pub(super) cells: Vec<FluidCell<D>>,
    saved: Vec<SavedCell<D>>,
    pub(super) places: Vec<SharedPlace<D>>,
    sources: Vec<SavedSource>,
    totals: SavedTotals,
    pub(super) left: u32,
}

wire!([const D: usize] SharedFluid<D> { cells, saved, places, sources, totals, left });

/// The place of a source, for all ranks.
#[derive(Debug)]
pub(super) struct SharedPlace<const D: usize> {
    pub(super) name: String,
    pub(super) walls: Vec<u32>,
    pub(super) rims: Vec<Rim>,
    pub(super) joints: Vec<[u32; D]>,
    /// Volume of the undeformed hole, and the volume at the last step of the fluid, m³.
    pub(super) volumes: [f64; 2],
}

wire!([const D: usize] SharedPlace<D> { name, walls, rims, joints, volumes });

impl<const D: usize> SharedFluid<D> {
    pub(super) fn new(
        cells: Vec<FluidCell<D>>,
        shapes: &[Shape<D>],
        places: Vec<SharedPlace<D>>,
        left: u32,
        state: &NetworkState,
    ) -> Self {
        let of = |(row, (cell, shape)): (usize, (&FluidCell<D>, &Shape<D>))| {
            SavedCell::of(state, row, shape, cell.slack)
        };
        let saved = cells.iter().zip(shapes).enumerate().map(of).collect();
        let source = |(key, place): (usize, &SharedPlace<D>)| SavedSource::of(state, key, place.volumes[1]);
        let sources = places.iter().enumerate().map(source).collect();
        Self { cells, saved, sources, totals: SavedTotals::of(state, left), places, left }
    }

    /// The last shapes of the cells.
    pub(super) fn shapes(&self) -> Vec<Shape<D>> {
        self.saved.iter().map(SavedCell::shape).collect()
    }

    /// The state of the network.
    pub(super) fn state(&self) -> NetworkState {
        let mut state = self.totals.state(self.cells.iter().map(FluidCell::key).collect(), self.places.len());
        self.saved.iter().for_each(|cell| cell.row.add_to(&mut state));
        self.sources.iter().for_each(|source| source.add_to(&mut state));
        state
    }
}

/// A cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct SavedCell<const D: usize> {
    pub(super) row: Row,
    corners: [[f64; D]; D],
    /// Opening, compression and compliance of its last shape.
    last: [f64; 3],
    /// See [`FluidCell::slack`].
    pub(super) slack: [f64; D],
}

wire!([const D: usize] SavedCell<D> { row, corners, last, slack });

/// A source.
#[derive(Clone, Copy, Debug)]
pub(super) struct SavedSource {
    row: Row,
    /// Injected mass, rate and volume.
    numbers: [f64; 3],
}

wire!([] SavedSource { row, numbers });

/// The numbers that cells and sources have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Mass, pressure, reference, and the time since which it is wet.
    numbers: [f64; 4],
    was_wet: bool,
}

wire!([] Row { numbers, was_wet });

/// Numbers of the whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct SavedTotals {
    /// Time; initial, leaked, drained, missed, stored and injected mass.
    numbers: [f64; 7],
    /// Steps until the next one of the fluid.
    pub(super) left: u32,
}

wire!([] SavedTotals { numbers, left });

/// All records of a run, by keys and names.
#[derive(Debug, Default)]
pub(super) struct SavedFluid<const D: usize> {
    pub(super) cells: BTreeMap<u64, SavedCell<D>>,
    pub(super) sources: BTreeMap<String, SavedSource>,
    pub(super) totals: Option<SavedTotals>,
}

impl Row {
    const DRY: Self = Self { numbers: [0.0, 0.0, 0.0, f64::INFINITY], was_wet: false };

    fn of(state: &NetworkState, row: usize) -> Self {
        let numbers = [state.mass[row], state.pressure[row], state.reference[row], state.wet_since[row]];
        Self { numbers, was_wet: state.was_wet[row] }
    }

    fn add_to(&self, state: &mut NetworkState) {
        let [mass, pressure, reference, wet_since] = self.numbers;
        state.mass.push(mass);
        state.pressure.push(pressure);
        state.reference.push(reference);
        state.wet_since.push(wet_since);
        state.was_wet.push(self.was_wet);
    }
}

impl<const D: usize> SavedCell<D> {
    /// A value of which only the size counts.
    pub(super) const LIKE: Self =
        Self { row: Row::DRY, corners: [[0.0; D]; D], last: [0.0; 3], slack: [0.0; D] };

    pub(super) fn of(state: &NetworkState, row: usize, shape: &Shape<D>, slack: [f64; D]) -> Self {
        let last = [shape.opening, shape.compression, shape.compliance];
        Self { row: Row::of(state, row), corners: shape.corners, last, slack }
    }

    /// Shape at the last step of the fluid.
    pub(super) fn shape(&self) -> Shape<D> {
        let [opening, compression, compliance] = self.last;
        Shape { corners: self.corners, opening, compression, compliance, is_wet: true }
    }
}

impl SavedSource {
    /// A value of which only the size counts.
    pub(super) const LIKE: Self = Self { row: Row::DRY, numbers: [0.0; 3] };

    pub(super) fn of(state: &NetworkState, source: usize, volume: f64) -> Self {
        let row = Row::of(state, state.cells.len() + source);
        Self { row, numbers: [state.injected[source], state.rate[source], volume] }
    }

    fn add_to(&self, state: &mut NetworkState) {
        let [injected, rate, _] = self.numbers;
        self.row.add_to(state);
        state.injected.push(injected);
        state.rate.push(rate);
    }

    /// Volume at the last step of the fluid, m³.
    pub(super) fn volume(&self) -> f64 {
        self.numbers[2]
    }
}

impl SavedTotals {
    /// A value of which only the size counts.
    pub(super) const LIKE: Self = Self { numbers: [0.0; 7], left: 0 };

    pub(super) fn of(state: &NetworkState, left: u32) -> Self {
        let sum = |masses: &[f64]| masses.iter().fold(0.0, |sum, mass| sum + mass);
        let NetworkState { time, initial, leaked, drained, missed, .. } = *state;
        let numbers = [time, initial, leaked, drained, missed, sum(&state.mass), sum(&state.injected)];
        Self { numbers, left }
    }

    /// A state with these cells and this number of sources, without their values.
    fn state(&self, cells: Vec<u64>, sources: usize) -> NetworkState {
        let [time, initial, leaked, drained, missed, ..] = self.numbers;
        let sources = (0..sources as u64).collect();
        NetworkState { cells, sources, time, initial, leaked, drained, missed, ..NetworkState::default() }
    }
}

impl<const D: usize> SavedFluid<D> {
    /// The state of a network with these cells and sources, by their keys and names. Fluid of cells that are
    /// no more is drained. `lowest`: pressure of new sources, Pa.
    pub(super) fn state(&self, cells: &[u64], sources: &[&str], lowest: f64) -> Option<NetworkState> {
        let totals = self.totals.as_ref()?;
        let mut state = totals.state(cells.to_vec(), sources.len());
        for key in cells {
            self.cells.get(key)?.row.add_to(&mut state);
        }
        let dry = Row { numbers: [0.0, lowest, lowest, f64::INFINITY], was_wet: false };
        let new = SavedSource { row: dry, numbers: [0.0; 3] };
        for name in sources {
            self.sources.get(*name).unwrap_or(&new).add_to(&mut state);
        }
        // The fluid of cells and sources that are no more; exactly 0 where there are none.
        let [.., stored, injected] = totals.numbers;
        let [.., has_stored, has_injected] = SavedTotals::of(&state, 0).numbers;
        state.drained += stored - has_stored;
        state.initial += injected - has_injected;
        Some(state)
    }
}
