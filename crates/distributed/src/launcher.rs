//! Launchers of MPI, recognised by the variables that they set for each process.

use std::env;

/// Number of processes that an MPI launcher (`mpirun`, `mpiexec`, `srun`) has started this one among, if
/// there are several.
///
/// Reads the environment only, so that it works without MPI. A program that was built without MPI can refuse
/// to run once for each process.
pub fn launched() -> Option<usize> {
    ranks_by(|name| env::var(name).ok())
}

/// The number of this process among those, as the launcher gives it, if it does. A program that cannot start
/// MPI can say why once.
pub fn launched_rank() -> Option<usize> {
    launched()?;
    rank_by(|name| env::var(name).ok())
}

fn rank_by(variable: impl Fn(&str) -> Option<String>) -> Option<usize> {
    let names = ["OMPI_COMM_WORLD_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK", "SLURM_PROCID"];
    names.into_iter().find_map(|name| variable(name)?.trim().parse().ok())
}

fn ranks_by(variable: impl Fn(&str) -> Option<String>) -> Option<usize> {
    let number = |name: &str| variable(name)?.trim().parse::<usize>().ok();
    // Open MPI; MPICH and Intel MPI (Hydra); MVAPICH; Slurm, for which the variable of a step is set by
    // `srun` and not by `sbatch`.
    let of_mpi = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE", "MPI_LOCALNRANKS"].map(number);
    // Inside a batch script itself, `SLURM_PROCID` is 0 and `SLURM_STEP_NUM_TASKS` is missing.
    let of_slurm = number("SLURM_PROCID").and(number("SLURM_STEP_NUM_TASKS"));
    of_mpi.into_iter().chain([of_slurm]).flatten().find(|&size| size > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(variables: &[(&str, &str)]) -> Option<usize> {
        ranks_by(|name| variables.iter().find(|(set, _)| *set == name).map(|(_, value)| (*value).to_owned()))
    }

    #[test]
    fn launchers_are_recognised_by_their_variables() {
        assert_eq!(with(&[("OMPI_COMM_WORLD_SIZE", "4"), ("OMPI_COMM_WORLD_RANK", "1")]), Some(4));
        assert_eq!(with(&[("PMI_SIZE", "3")]), Some(3));
        assert_eq!(with(&[("SLURM_PROCID", "1"), ("SLURM_STEP_NUM_TASKS", "8")]), Some(8));
    }

    #[test]
    fn launchers_number_their_processes() {
        let with = |name| rank_by(|set| (set == name).then(|| "3".to_owned()));
        assert_eq!(with("OMPI_COMM_WORLD_RANK"), Some(3));
        assert_eq!(with("SLURM_PROCID"), Some(3));
        assert_eq!(with("HOME"), None);
    }

    #[test]
    fn one_process_and_batch_scripts_are_not_launched() {
        assert_eq!(with(&[]), None);
        assert_eq!(with(&[("OMPI_COMM_WORLD_SIZE", "1")]), None);
        assert_eq!(with(&[("PMI_SIZE", "many")]), None);
        assert_eq!(with(&[("SLURM_PROCID", "0"), ("SLURM_NTASKS", "8")]), None);
    }
}
