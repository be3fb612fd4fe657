//! The simulation of a run: in this process, or on many ranks that this one leads.

use fdem_distributed::Communicator;
use fdem_simulation::{
    Counts, CriticalStep, Energies, Forces, Leader, Probe, Simulation, Snapshot, State, Stop, Timings,
    Traffic,
};

use crate::command::run::results::Results;

/// A node of the mesh: its displacement, m, and its velocity, m/s.
type Moved<const D: usize> = ([f64; D], [f64; D]);

/// A simulation, wherever it is computed.
pub(crate) enum Engine<'c, const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    Alone(Box<Simulation<D, N>>),
    Leading(Box<Leader<'c, D, N>>),
}

macro_rules! both {
    ($self:expr, $run:ident => $done:expr) => {
        match $self {
            Self::Alone($run) => $done,
            Self::Leading($run) => $done,
        }
    };
}

impl<'c, const D: usize, const N: usize> Engine<'c, D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// Distributes a simulation among the ranks, if there are several. `threads`: of each rank.
    pub(crate) fn new(
        run: Simulation<D, N>,
        ranks: Option<&'c dyn Communicator>,
        threads: usize,
    ) -> Result<Self, String> {
        Ok(match ranks {
            None => Self::Alone(Box::new(run)),
            Some(ranks) => {
                let leader = Leader::new(ranks, run, threads).map_err(|error| error.to_string())?;
                Self::Leading(Box::new(leader))
            }
        })
    }

    pub(crate) fn advance(&mut self, steps: u64) -> Result<(), Stop> {
        both!(self, run => run.advance(steps))
    }

    pub(crate) fn steps(&self) -> u64 {
        both!(self, run => run.steps())
    }

    pub(crate) fn time(&self) -> f64 {
        both!(self, run => run.time())
    }

    pub(crate) fn time_step(&self) -> f64 {
        both!(self, run => run.time_step())
    }

    pub(crate) fn critical_step(&self) -> CriticalStep {
        both!(self, run => run.critical_step())
    }

    pub(crate) fn energies(&self) -> Energies {
        both!(self, run => run.energies())
    }

    pub(crate) fn imbalance(&self) -> f64 {
        both!(self, run => run.imbalance())
    }

    /// Sets the factor of a boundary from the next step on.
    pub(crate) fn set_factor(&mut self, boundary: usize, factor: f64) -> Result<(), String> {
        let set = match self {
            Self::Alone(run) => run.set_factor(boundary, Some(factor)),
            Self::Leading(run) => run.set_factor(boundary, factor),
        };
        set.map_err(|error| error.to_string())
    }

    /// Goes on with another simulation.
    pub(crate) fn replace(&mut self, with: Simulation<D, N>) -> Result<(), String> {
        match self {
            Self::Alone(run) => **run = with,
            Self::Leading(run) => run.replace(with).map_err(|error| error.to_string())?,
        }
        Ok(())
    }

    pub(crate) fn force(&self, boundary: usize) -> Option<[f64; D]> {
        both!(self, run => run.force(boundary))
    }

    pub(crate) fn timings(&self) -> Timings {
        both!(self, run => run.timings())
    }

    pub(crate) fn threads(&self) -> usize {
        both!(self, run => run.threads())
    }

    pub(crate) fn elements(&self) -> usize {
        match self {
            Self::Alone(run) => run.model().mesh.elements.len(),
            Self::Leading(run) => run.elements(),
        }
    }

    pub(crate) fn counts(&self) -> Counts {
        both!(self, run => run.counts())
    }

    pub(crate) fn penetrated(&self) -> Option<[u32; 2]> {
        both!(self, run => run.penetrated())
    }

    /// Nodes of the mesh; not numbers for those that are not there.
    pub(crate) fn nodes(&self, nodes: &[u32]) -> Vec<Moved<D>> {
        let found = both!(self, run => run.nodes(nodes));
        found.into_iter().map(|node| node.unwrap_or(([f64::NAN; D], [f64::NAN; D]))).collect()
    }

    pub(crate) fn measure(&self, probes: &[Probe<D, N>]) -> Vec<Vec<f64>> {
        both!(self, run => run.measure(probes))
    }

    pub(crate) fn crack_lengths(&self) -> [f64; 3] {
        both!(self, run => run.crack_lengths())
    }

    pub(crate) fn fragments(&self) -> Vec<u32> {
        both!(self, run => run.fragments())
    }

    pub(crate) fn snapshot(&self) -> Snapshot<D, N> {
        both!(self, run => run.snapshot())
    }

    pub(crate) fn frame(&self) -> (Snapshot<D, N>, Forces<D>) {
        match self {
            Self::Alone(run) => (run.snapshot(), run.forces()),
            Self::Leading(run) => run.frame(),
        }
    }

    pub(crate) fn state(&self) -> State<D, N> {
        both!(self, run => run.state())
    }

    /// The elements and the traffic of each rank; empty in one process.
    pub(crate) fn traffic(&self) -> Vec<Traffic> {
        match self {
            Self::Alone(_) => Vec::new(),
            Self::Leading(run) => run.traffic(),
        }
    }
}
