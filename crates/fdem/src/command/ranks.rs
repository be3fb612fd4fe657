//! Processes that an MPI launcher has started together: how they start, and how they agree on a failure.

use fdem_distributed::{Communicator, launched, launched_rank};

use crate::command::failure::Failure;

/// The processes of this run. MPI ends when this is dropped.
pub(crate) struct Ranks {
    several: Option<Box<dyn Communicator>>,
}

impl Ranks {
    /// Starts MPI if a launcher has started several processes.
    ///
    /// # Errors
    /// If this program was built without MPI, or with another MPI library than the launcher's.
    pub(crate) fn start() -> Result<Self, Failure> {
        Ok(Self { several: launched().map(start_mpi).transpose()? })
    }

    /// The ranks, if there are several.
    pub(crate) fn communicator(&self) -> Option<&dyn Communicator> {
        self.several.as_deref()
    }

    /// Whether this process prints the lines that are the same on all ranks.
    pub(crate) fn prints(&self) -> bool {
        self.communicator().is_none_or(|communicator| communicator.rank() == 0)
    }

    /// Returns the value if all ranks have one, and otherwise the failure of the first rank that has one.
    /// Collective.
    pub(crate) fn agree<V>(&self, result: Result<V, Failure>) -> Result<V, Failure> {
        match self.communicator() {
            Some(communicator) => agree(communicator, result),
            None => result,
        }
    }

    /// Refuses a task that works in one process.
    pub(crate) fn refuse_several(&self, task: &str) -> Result<(), Failure> {
        let Some(communicator) = self.communicator() else { return Ok(()) };
        let ranks = communicator.size();
        let advice = "start it without the launcher";
        Err(Failure::Unusable(format!("fdem {task} runs in one process, not on {ranks} ranks: {advice}")))
    }
}

/// Whether a launcher has started this process as another rank than the first: also known before MPI is
/// started, and without it.
pub(crate) fn is_another_rank() -> bool {
    launched_rank().is_some_and(|rank| rank > 0)
}

#[cfg(not(feature = "mpi"))]
fn start_mpi(processes: usize) -> Result<Box<dyn Communicator>, Failure> {
    let advice = "build it with `--features mpi`, or start it without the launcher";
    Err(Failure::Unusable(format!(
        "an MPI launcher has started {processes} processes, but this fdem was built without MPI: {advice}"
    )))
}

#[cfg(feature = "mpi")]
fn start_mpi(processes: usize) -> Result<Box<dyn Communicator>, Failure> {
    let world = fdem_mpi::World::start().map_err(|error| Failure::Unusable(error.to_string()))?;
    if world.size() == 1 {
        return Err(Failure::Unusable(format!(
            "a launcher has started {processes} processes, but they do not find each other. fdem was built with {}: use its launcher",
            fdem_mpi::library_version()
        )));
    }
    Ok(Box::new(world))
}

/// Version of the program, with the MPI library that it was built with.
pub(crate) fn version() -> &'static str {
    #[cfg(feature = "mpi")]
    {
        static VERSION: std::sync::OnceLock<String> = std::sync::OnceLock::new();
        let library = fdem_mpi::library_version;
        VERSION.get_or_init(|| format!("{} with MPI: {}", env!("CARGO_PKG_VERSION"), library()))
    }
    #[cfg(not(feature = "mpi"))]
    env!("CARGO_PKG_VERSION")
}

/// Returns the value if all ranks have one. Otherwise every rank returns the failure of the first rank that
/// has one, with its number. Collective.
pub(crate) fn agree<V>(communicator: &dyn Communicator, result: Result<V, Failure>) -> Result<V, Failure> {
    let told = match &result {
        Ok(_) => Vec::new(),
        Err(failure) => [&[failure.exit_code()], failure.to_string().as_bytes()].concat(),
    };
    let all = communicator.all_gather(&told);
    let failed = all.iter().enumerate().find_map(|(rank, told)| Some((rank, told.split_first()?)));
    let Some((rank, (code, text))) = failed else { return result };
    let message = format!("rank {rank}: {}", String::from_utf8_lossy(text));
    Err(if *code == 1 { Failure::Wrong(message) } else { Failure::Unusable(message) })
}

/// The first rank whose bytes are not those of rank 0. Collective.
pub(crate) fn first_unlike(communicator: &dyn Communicator, bytes: &[u8]) -> Option<usize> {
    let all = communicator.all_gather(bytes);
    all.iter().position(|other| *other != all[0])
}

/// The number of each rank. Collective.
pub(crate) fn gather_counts(communicator: &dyn Communicator, own: u64) -> Vec<u64> {
    let all = communicator.all_gather(&own.to_le_bytes());
    all.iter().map(|bytes| u64_from(bytes)).collect()
}

pub(crate) fn u64_from(bytes: &[u8]) -> u64 {
    bytes.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes))
}
