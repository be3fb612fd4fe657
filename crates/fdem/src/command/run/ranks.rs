//! Where a run is computed: in this process, on a graphics processor, or on ranks, of which one leads and the
//! others follow.

use fdem_distributed::Communicator;
use fdem_io::numbers::grouped;
use fdem_results::{Plot, RankLoad, rank_loads};
use fdem_simulation::{Leader, ModelError, Simulation, Traffic, dismiss, follow};

use crate::command::args::RunOptions;
use crate::command::device;
use crate::command::device_name::DeviceName;
use crate::command::failure::Failure;
use crate::command::run::course::Start;
use crate::command::run::engine::Engine;
use crate::command::run::results::Results;
use crate::command::run::watch::Watch;

/// The ranks of a run, on the one that leads the others.
pub(super) struct RunRanks<'c> {
    ranks: Option<&'c dyn Communicator>,
    pub(super) threads: usize,
    device: DeviceName,
    /// Whether the others follow a run, and need no message that there is none.
    followed: bool,
}

impl<'c> RunRanks<'c> {
    /// The ranks on rank 0, or in the only process. Any other rank follows the run of rank 0 to its end; then
    /// there is nothing left to do.
    pub(super) fn of(
        ranks: Option<&'c dyn Communicator>,
        watch: &Watch,
        options: &RunOptions,
    ) -> Result<Option<Self>, Failure> {
        // A rank has one thread by default: there are as many ranks as processors.
        let threads = if ranks.is_some() { options.threads.max(1) } else { options.threads };
        if let Some(ranks) = ranks.filter(|ranks| ranks.rank() > 0) {
            // Rank 0 gets the same signals, and ends the run.
            watch.begin();
            follow(ranks, threads).map_err(|error| Failure::Unusable(error.to_string()))?;
            return Ok(None);
        }
        let this = Self { ranks, threads, device: options.device, followed: false };
        if let DeviceName::Gpu(number) = this.device {
            if ranks.is_some() {
                return Err(Failure::Unusable("--device gpu does not go with ranks".to_owned()));
            }
            device::check(number)?;
        }
        Ok(Some(this))
    }

    /// Refuses more ranks than a model has elements, several ranks for spheres alone, and ranks for pores.
    pub(super) fn check<const D: usize, const N: usize>(&self, start: &Start<D, N>) -> Result<(), String>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let elements = start.prepared.model.mesh.elements.len();
        match self.ranks.map(Communicator::size) {
            Some(ranks) if ranks > 1 && elements == 0 => Err(ModelError::GrainsOnRanks.to_string()),
            _ if elements == 0 => Ok(()),
            Some(_) if start.prepared.model.pores.is_some() => {
                Err(ModelError::Pores("the run is on many ranks").to_string())
            }
            Some(ranks) if ranks > elements => Err(ModelError::Ranks { ranks, elements }.to_string()),
            _ => Ok(()),
        }
    }

    /// Puts a simulation on its device, which may have too little memory: before anything is written.
    pub(super) fn put_on_device<const D: usize, const N: usize>(
        &self,
        run: &mut Simulation<D, N>,
    ) -> Result<(), String>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let DeviceName::Gpu(number) = self.device else { return Ok(()) };
        device::put_on(number, run).map_err(|why| format!("--device gpu: {why}"))
    }

    /// Distributes a simulation among the ranks.
    pub(super) fn distribute<const D: usize, const N: usize>(
        mut self,
        run: Simulation<D, N>,
    ) -> Result<Box<dyn Engine<D, N> + 'c>, String>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        self.followed = true;
        // Spheres alone have nothing to divide.
        let ranks = self.ranks.filter(|_| !run.model().mesh.elements.is_empty());
        let Some(ranks) = ranks else { return Ok(Box::new(run)) };
        let leader = Leader::new(ranks, run, self.threads).map_err(|error| error.to_string())?;
        Ok(Box::new(leader))
    }
}

impl Drop for RunRanks<'_> {
    fn drop(&mut self) {
        if let Some(ranks) = self.ranks.filter(|_| !self.followed && !std::thread::panicking()) {
            dismiss(ranks);
        }
    }
}

/// Draws the ranks of a run: their elements, and the bytes that they send in a step. None in one process.
pub(super) fn plots(traffic: &[Traffic]) -> Vec<Plot> {
    if traffic.is_empty() {
        return Vec::new();
    }
    let load = |rank: &Traffic| RankLoad {
        own: rank.own as f64,
        halo: rank.halo as f64,
        bytes: rank.bytes as f64 / rank.steps.max(1) as f64,
    };
    rank_loads(&traffic.iter().map(load).collect::<Vec<_>>()).into()
}

/// Describes the ranks of a run: their elements, and the bytes that they have sent in each step. `None` in
/// one process.
pub(super) fn in_ranks(traffic: &[Traffic]) -> Option<String> {
    let first = traffic.first()?;
    let sum = |of: fn(&Traffic) -> u64| traffic.iter().map(of).sum::<u64>() as f64;
    let most = |of: fn(&Traffic) -> u64| traffic.iter().map(of).max().unwrap_or_default() as f64;
    let own = sum(|rank| rank.own as u64).max(1.0);
    let each = first.steps.max(1) as f64;
    Some(format!(
        "{} ranks; the halo is {:.1} % of the elements; the rank with most elements has {:.1} % more than the mean; at most {} neighbours; \
         in a step each rank sends {} bytes in {:.1} messages; divided {}",
        traffic.len(),
        100.0 * sum(|rank| rank.halo as u64) / own,
        100.0 * (most(|rank| rank.own as u64) * traffic.len() as f64 / own - 1.0),
        most(|rank| rank.neighbours as u64),
        grouped((sum(|rank| rank.bytes) / each / traffic.len() as f64) as u64),
        sum(|rank| rank.messages) / each / traffic.len() as f64,
        if first.spreads == 0 { "once".to_owned() } else { format!("{} times", grouped(first.spreads + 1)) }
    ))
}
