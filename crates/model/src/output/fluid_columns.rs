//! Columns of the fluid, which the history of a model with a fluid has in any case.

use fdem_simulation::Probe;

use crate::prepared::{PreparedHistory, Quantity};
use crate::text::file::{self, ModelFile};

/// Name of the history of the fluid as a whole.
pub(crate) const FLUID: &str = "fluid";

/// Adds the histories of the fluid as a whole and of each injection, if there is a fluid.
pub(crate) fn add<const D: usize, const N: usize>(
    file: &ModelFile,
    histories: &mut Vec<PreparedHistory>,
    probes: &mut Vec<Probe<D, N>>,
) {
    if file.fluid.is_none() {
        return;
    }
    let injections = file.injection.iter().map(|of| (of.name.as_str(), Probe::Injection(of.name.clone())));
    for (name, probe) in std::iter::once((FLUID, Probe::Fluid)).chain(injections) {
        histories.push(PreparedHistory { name: name.to_owned(), quantity: Quantity::Probe(probes.len()) });
        probes.push(probe);
    }
}

/// Whether fluid flows in joint sets that are closed.
pub(crate) fn conducts(file: &ModelFile) -> bool {
    let aperture = |set: &file::JointSet| Some(set.aperture.unwrap_or(file.fluid.as_ref()?.aperture));
    file.joint_set.iter().any(|set| !set.open && aperture(set).is_some_and(|aperture| aperture > 0.0))
}
