//! The memory of the liquid in pores, as records: of the vertices of each element, of each surface, and of
//! the whole.

use std::collections::BTreeMap;

use fdem_distributed::wire;
use fdem_fluid::{MatrixState, PorousMatrix};

/// Content, storage and pressure of a vertex: m³, m³/Pa, Pa.
pub(super) type SavedVertex = [f64; 3];

/// Numbers of the whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoreTotals {
    /// Time, initial content, volume out of cracks, moved volume, content now, and inflow through all
    /// surfaces.
    numbers: [f64; 6],
    /// Steps until the next one of the flow.
    pub(super) left: u32,
}

wire!([] PoreTotals { numbers, left });

/// All records of a run.
#[derive(Debug, Default)]
pub(super) struct SavedPores {
    /// By the vertices of the mesh.
    pub(super) vertices: BTreeMap<u32, SavedVertex>,
    /// Inflow through each surface, m³, by its name.
    pub(super) surfaces: BTreeMap<String, f64>,
    pub(super) totals: Option<PoreTotals>,
}

impl PoreTotals {
    /// A value of which only the size counts.
    pub(super) const LIKE: Self = Self { numbers: [0.0; 6], left: 0 };

    pub(super) fn of(state: &MatrixState, left: u32) -> Self {
        let sum = |values: &[f64]| values.iter().fold(0.0, |sum, value| sum + value);
        let MatrixState { time, initial, exchanged, moved, .. } = *state;
        Self { numbers: [time, initial, exchanged, moved, sum(&state.content), sum(&state.inflow)], left }
    }
}

impl SavedPores {
    /// The state of pores that have the present volumes of their elements. `surfaces`: names, in the order of
    /// their keys.
    ///
    /// Vertices that had other elements before keep their pressure, not their content. The liquid of elements
    /// that are no more, or new, counts as initial.
    pub(super) fn state<const D: usize, const N: usize>(
        &self,
        matrix: &PorousMatrix<D, N>,
        surfaces: &[&str],
    ) -> Option<MatrixState> {
        let totals = self.totals.as_ref()?;
        let [time, initial, exchanged, moved, stored, inflow] = totals.numbers;
        let mut state = MatrixState {
            inflow: surfaces.iter().map(|name| self.surfaces.get(*name).copied().unwrap_or(0.0)).collect(),
            time,
            initial,
            exchanged,
            moved,
            ..matrix.state().clone()
        };
        for (vertex, &storage) in matrix.storages().iter().enumerate().filter(|(_, storage)| **storage > 0.0)
        {
            let saved = self.vertices.get(&(vertex as u32));
            if let Some([content, _, pressure]) = saved.filter(|saved| saved[1] == storage).copied() {
                (state.content[vertex], state.pressure[vertex]) = (content, pressure);
                continue;
            }
            let pressure = saved.map_or(state.pressure[vertex], |saved| saved[2]);
            state.content[vertex] = storage * pressure + matrix.growths()[vertex];
            state.pressure[vertex] = pressure;
        }
        // Exactly 0 where the elements are those of before.
        let [.., has_stored, has_inflow] = PoreTotals::of(&state, 0).numbers;
        state.initial += has_stored - stored;
        state.initial += inflow - has_inflow;
        Some(state)
    }
}
