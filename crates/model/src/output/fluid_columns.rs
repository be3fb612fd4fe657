//! Columns of the fluid in cracks and of the liquid in pores, which the history of a model with them has in
//! any case.

use fdem_simulation::Probe;

use crate::prepared::{PreparedHistory, Quantity};
use crate::text::file::{self, ModelFile};

/// Name of the history of the fluid as a whole.
pub(crate) const FLUID: &str = "fluid";

/// Name of the history of the liquid in pores as a whole.
pub(crate) const PORES: &str = "pores";

/// Adds the histories of the fluid as a whole and of each injection, if there is a fluid, and of the liquid
/// in pores and of each of their surfaces, if there is one.
pub(crate) fn add<const D: usize, const N: usize>(
    file: &ModelFile,
    histories: &mut Vec<PreparedHistory>,
    probes: &mut Vec<Probe<D, N>>,
) {
    let mut all = Vec::new();
    if file.fluid.is_some() {
        all.push((FLUID, Probe::Fluid));
        all.extend(file.injection.iter().map(|of| (of.name.as_str(), Probe::Injection(of.name.clone()))));
    }
    if file.pores.is_some() {
        all.push((PORES, Probe::Pores));
        let surfaces = file.pore_surface.iter();
        all.extend(surfaces.map(|of| (of.name.as_str(), Probe::PoreSurface(of.name.clone()))));
    }
    for (name, probe) in all {
        histories.push(PreparedHistory { name: name.to_owned(), quantity: Quantity::Probe(probes.len()) });
        probes.push(probe);
    }
}

/// Whether fluid flows in joint sets that are closed.
pub(crate) fn conducts(file: &ModelFile) -> bool {
    let aperture = |set: &file::JointSet| Some(set.aperture.unwrap_or(file.fluid.as_ref()?.aperture));
    file.joint_set.iter().any(|set| !set.open && aperture(set).is_some_and(|aperture| aperture > 0.0))
}
