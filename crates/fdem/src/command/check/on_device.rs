//! The forecast of a run on a graphics processor.

use fdem_model::{DeviceForecast, Prepared};

use crate::command::device;
use crate::command::run::course::{Start, StartError};
use crate::command::run::results::Results;

/// Estimates for the run of a model on a device; of a run in stages, for the first.
pub(super) fn forecast<const D: usize, const N: usize>(
    number: usize,
    prepared: &Prepared<D, N>,
    steps: u64,
) -> Result<DeviceForecast, String>
where
    [[f64; D]; N]: Results<D, N>,
{
    let start = Start::new(prepared.clone(), None).map_err(|error| match error {
        StartError::Model(why) => why,
        StartError::From(failure) => failure.to_string(),
    });
    let mut start = start?;
    let (mut run, _) = start.simulation(1)?;
    let (elements, counts) = (run.model().mesh.elements.len(), run.counts());
    let memory = device::memory_of(&mut run)?;
    let forecast = DeviceForecast::of(number, device::card(number), (elements, &counts), memory, steps);
    Ok(DeviceForecast { has_stages: start.stages.is_some(), ..forecast })
}
