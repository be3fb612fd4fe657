//! The vector instructions of a simulation.
//!
//! Early versions had no choice of them. In their trees this program is built without the feature `levels`,
//! which their manifest does not have.

use fdem_contact::Simd;
use fdem_simulation::{Element, Simulation};

/// Computes on these instructions, or on the best that the processor has.
#[cfg(feature = "levels")]
pub(crate) fn choose<const D: usize, const N: usize>(run: &mut Simulation<D, N>, level: Option<Simd>)
where
    [[f64; D]; N]: Element<D, N>,
{
    run.set_simd(level.unwrap_or(Simd::best()));
}

#[cfg(not(feature = "levels"))]
pub(crate) fn choose<const D: usize, const N: usize>(_: &mut Simulation<D, N>, _: Option<Simd>)
where
    [[f64; D]; N]: Element<D, N>,
{
}

/// The instructions to compare with those that were chosen: all others of this processor.
pub(crate) fn others(level: Option<Simd>) -> Vec<Simd> {
    let chosen = level.unwrap_or(Simd::best());
    let choice = if cfg!(feature = "levels") { Simd::available() } else { Vec::new() };
    choice.into_iter().filter(|&other| other != chosen).collect()
}

/// The name of the chosen instructions in reports.
pub(crate) fn name(level: Option<Simd>) -> &'static str {
    if cfg!(feature = "levels") { level.unwrap_or(Simd::best()).name() } else { "instructions of the build" }
}

/// The level of this name, if the processor has it.
pub(crate) fn named(name: &str) -> Option<Simd> {
    Simd::available().into_iter().find(|level| level.name() == name)
}
