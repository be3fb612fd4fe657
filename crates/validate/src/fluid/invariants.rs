//! Runs with fluid that have to be the same to the last bit.

use fdem_simulation::{Model, Simulation, Snapshot};

use super::kgd::coarse;
use crate::models::{advance, text};
use crate::{Outcome, Size};

/// All of the state that a user can see.
fn differ(one: &Simulation, other: &Simulation) -> f64 {
    let state = |run: &Simulation| run.fluid().map(|fluid| fluid.state().clone());
    let same = one.snapshot() == other.snapshot()
        && one.energies() == other.energies()
        && state(one) == state(other);
    f64::from(!same)
}

fn advanced(model: Model, threads: usize, steps: u64) -> Result<Simulation, String> {
    let mut run = Simulation::new(model, threads).map_err(text)?;
    advance(&mut run, steps)?;
    Ok(run)
}

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let half = size.choose(500, 1500);
    let mut outcomes = Vec::new();
    let mut compare = |what: &str, found: f64| {
        outcomes.push(Outcome::absolute(format!("whether {what}"), 0.0, found, 0.0, ""));
    };
    let whole = advanced(coarse(1.0), 1, 2 * half)?;
    let growth = whole
        .snapshot()
        .cracks
        .iter()
        .filter(|crack| crack.dissipated > 0.5 && !crack.open_from_start)
        .count();
    compare("no crack has grown", f64::from(growth < 3));
    compare("two threads differ from one", differ(&whole, &advanced(coarse(1.0), 2, 2 * half)?));
    let saved = advanced(coarse(1.0), 1, half)?.state();
    let mut resumed = Simulation::resume(coarse(1.0), saved, 1).map_err(text)?;
    advance(&mut resumed, half)?;
    compare("a saved run differs", differ(&whole, &resumed));
    let still = advanced(coarse(0.0), 1, half)?;
    let without = advanced(Model { fluid: None, ..coarse(0.0) }, 1, half)?;
    let motion = Snapshot { fluid: None, ..still.snapshot() };
    let same = motion == without.snapshot() && still.energies() == without.energies();
    compare("a rate of 0 differs from no fluid", f64::from(!same));
    Ok(outcomes)
}
