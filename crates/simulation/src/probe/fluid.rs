//! Probes of the fluid: its balance, and its sources.

use fdem_fluid::{Balance, Network};

use crate::simplex::Simplex;
use crate::simulation::run::Simulation;

/// Values of the fluid as a whole in the plane and in space.
pub(super) const COLUMNS: [[(&str, &str); 8]; 2] =
    [with_measure(("wet_length", "m")), with_measure(("wet_area", "m²"))];

/// Values of a source.
pub(super) const OF_SOURCE: [(&str, &str); 3] = [("pressure", "Pa"), ("rate", "m³/s"), ("injected", "m³")];

const fn with_measure(measure: (&'static str, &'static str)) -> [(&'static str, &'static str); 8] {
    [
        ("initial", "m³"),
        ("injected", "m³"),
        ("leaked", "m³"),
        ("drained", "m³"),
        ("stored", "m³"),
        ("missed", "m³"),
        measure,
        ("mass_error", "kg"),
    ]
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The fluid, on the one of all ranks that counts it.
    fn counted_fluid(&self) -> Option<&Network<D>> {
        self.fluid().filter(|_| self.scene().counts_common())
    }

    /// Visits the values of the fluid, and a 1, if there is one.
    pub(super) fn visit_fluid(&self, visit: impl FnOnce(&[f64])) {
        let (Some(network), Some(options)) = (self.counted_fluid(), &self.model.fluid) else { return };
        let balance = network.balance();
        let Balance { initial, injected, leaked, drained, stored, missed } = balance;
        let density = options.flow.fluid.state.reference_density();
        let [initial, injected, leaked, drained, stored, missed] =
            [initial, injected, leaked, drained, stored, missed].map(|mass| mass / density);
        let cells = network.areas().into_iter().zip(network.saturations());
        let area = cells.fold(0.0, |sum, (area, saturation)| sum + area * saturation);
        let wet = area / self.model.thickness;
        visit(&[initial, injected, leaked, drained, stored, missed, wet, balance.error(), 1.0]);
    }

    /// Visits the values of a source, and a 1, if there is one of this name.
    pub(super) fn visit_injection(&self, name: &str, visit: impl FnOnce(&[f64])) {
        let sources = self.model.fluid.iter().flat_map(|options| &options.sources);
        let key = (0..).zip(sources).find(|(_, source)| source.name == name).map(|(key, _)| key);
        let state = key.zip(self.counted_fluid()).and_then(|(key, network)| network.injection(key).ok());
        if let Some(state) = state {
            visit(&[state.pressure, state.rate, state.injected, 1.0]);
        }
    }
}
