//! Counts and times that the model of scaling begins with.

use std::error::Error;
use std::time::Instant;

use fdem_simulation::{Forecast, Model, Simulation};

/// Steps before any timing.
const SETTLE: u64 = 10;

/// A mesh, divided among several numbers of ranks.
pub(crate) struct Pattern {
    pub(crate) elements: usize,
    pub(crate) nodes: usize,
    pub(crate) forecasts: Vec<Forecast>,
}

impl Pattern {
    pub(crate) fn of(model: Model<3, 4>, ranks: &[usize]) -> Result<Self, Box<dyn Error>> {
        let mut run = Simulation::new(model, 1)?;
        let forecasts: Vec<Forecast> =
            ranks.iter().map(|&ranks| Forecast::of(&mut run, ranks)).collect::<Result<_, _>>()?;
        let first = forecasts.first().ok_or("no number of ranks")?;
        Ok(Self { elements: first.elements, nodes: first.nodes, forecasts })
    }

    /// The forecast for most ranks: its ranks have most neighbours on all sides, as those of a large run
    /// have.
    pub(crate) fn last(&self) -> &Forecast {
        &self.forecasts[self.forecasts.len() - 1]
    }
}

/// Time that this thread has run, s: without the time in which other programs had its core. `None` if the
/// system does not provide it.
fn busy() -> Option<f64> {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    told.split_whitespace().next()?.parse::<f64>().ok().map(|nanoseconds| 1e-9 * nanoseconds)
}

/// Time of an element in a step on one core, s: in the fastest of some rounds with `work` element-steps each,
/// which other programs have disturbed least. A slower one would make messages look cheaper.
pub(crate) fn seconds(model: Model<3, 4>, work: f64, rounds: usize) -> Result<f64, Box<dyn Error>> {
    let mut run = Simulation::new(model, 1)?;
    let elements = run.model().mesh.elements.len() as f64;
    let steps = ((work / elements) as u64).max(2);
    run.advance(SETTLE)?;
    let mut least = f64::INFINITY;
    for _ in 0..rounds {
        let (clock, start) = (Instant::now(), busy());
        run.advance(steps)?;
        let ran = start.zip(busy()).map(|(start, end)| end - start);
        least = least.min(ran.unwrap_or(clock.elapsed().as_secs_f64()));
    }
    Ok(least / (steps as f64 * elements))
}
