//! Probes of the liquid in pores: its pressure at a point, its balance, and its surfaces.

use crate::simplex::Simplex;
use crate::simulation::run::Simulation;

/// The value at a point.
pub(super) const AT_POINT: [(&str, &str); 1] = [("pressure", "Pa")];

/// Values of the liquid as a whole.
pub(super) const COLUMNS: [(&str, &str); 5] =
    [("initial", "m³"), ("inflow", "m³"), ("exchanged", "m³"), ("stored", "m³"), ("volume_error", "m³")];

/// The value of a surface.
pub(super) const OF_SURFACE: [(&str, &str); 1] = [("inflow", "m³")];

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Visits the pressure at a point of an element and a 1, if the element has pores. `weights`: shares of
    /// its corners.
    pub(super) fn visit_pore_pressure(&self, element: u32, weights: [f64; N], visit: impl FnOnce(&[f64])) {
        let Some(matrix) = self.pores() else { return };
        if self.pore_elements().binary_search(&element).is_err() {
            return;
        }
        let corners = (element as usize * N..).zip(weights);
        let pressure = |corner: usize| matrix.pressures()[self.topology.vertices[corner] as usize];
        visit(&[corners.fold(0.0, |sum, (corner, weight)| sum + weight * pressure(corner)), 1.0]);
    }

    /// Visits the balance of the liquid, and a 1, if there are pores.
    pub(super) fn visit_pores(&self, visit: impl FnOnce(&[f64])) {
        let Some(matrix) = self.pores() else { return };
        let balance = matrix.balance();
        visit(&[balance.initial, balance.inflow, balance.exchanged, balance.stored, balance.error(), 1.0]);
    }

    /// Visits the inflow through a surface, and a 1, if there is one of this name.
    pub(super) fn visit_pore_surface(&self, name: &str, visit: impl FnOnce(&[f64])) {
        let surfaces = self.model.pores.iter().flat_map(|options| &options.surfaces);
        let key = (0..).zip(surfaces).find(|(_, surface)| surface.name == name).map(|(key, _)| key);
        if let Some(inflow) = key.zip(self.pores()).and_then(|(key, matrix)| matrix.inflow(key).ok()) {
            visit(&[inflow, 1.0]);
        }
    }
}
