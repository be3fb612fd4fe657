//! The simulation of a run: in this process, or on many ranks that this one leads.

use fdem_simulation::{
    Counts, Crack, CriticalStep, Energies, Forces, Leader, Probe, Simulation, Snapshot, State, Stop, Timings,
    Traffic,
};

use crate::command::run::results::Results;

/// A node of the mesh: its displacement, m, and its velocity, m/s.
type Moved<const D: usize> = ([f64; D], [f64; D]);

/// A simulation, wherever it is computed.
pub(crate) trait Engine<const D: usize, const N: usize> {
    /// Takes steps. Values of a run on a device stay there: those that are read one by one count after
    /// [`Engine::check_device`], all others after [`Engine::settle`].
    fn advance(&mut self, steps: u64) -> Result<(), Stop>;

    /// Reads all values from a device.
    fn settle(&self) -> Result<(), Stop>;

    /// Whether the device of the run has returned all values that have been read.
    fn check_device(&self) -> Result<(), Stop>;

    /// Checks the energy balance at the end of a run, and changes nothing.
    fn check_balance(&self) -> Result<(), Stop>;

    /// Sets the factor of a boundary from the next step on.
    fn set_factor(&mut self, boundary: usize, factor: f64) -> Result<(), String>;

    /// Continues with another simulation.
    fn replace(&mut self, with: Simulation<D, N>) -> Result<(), String>;

    fn steps(&self) -> u64;
    fn time(&self) -> f64;
    fn time_step(&self) -> f64;
    fn critical_step(&self) -> CriticalStep;
    fn threads(&self) -> usize;
    fn timings(&self) -> Timings;
    fn elements(&self) -> usize;

    /// Bodies that were rigid until they were overloaded, by their numbers.
    fn released_bodies(&self) -> Vec<u32>;
    fn counts(&self) -> Counts;
    fn penetrated(&self) -> Option<[u32; 2]>;
    fn deepest_overlap(&self) -> Option<(f64, u32)>;
    fn energies(&self) -> Energies;
    fn imbalance(&self) -> f64;
    fn force(&self, boundary: usize) -> Option<[f64; D]>;
    fn moment(&self, boundary: usize) -> Option<[f64; 3]>;
    fn measure(&self, probes: &[Probe<D, N>]) -> Vec<Vec<f64>>;
    fn crack_lengths(&self) -> [f64; 3];
    fn fragments(&self) -> Vec<u32>;
    fn snapshot(&self) -> Snapshot<D, N>;
    fn intact_joints(&self) -> Vec<Crack<D>>;
    fn state(&self) -> State<D, N>;

    /// Nodes of the mesh; not numbers for those that are not there.
    fn nodes(&self, nodes: &[u32]) -> Vec<Moved<D>>;

    fn frame(&self) -> (Snapshot<D, N>, Forces<D>);

    /// The elements and the traffic of each rank; empty in one process.
    fn traffic(&self) -> Vec<Traffic>;
}

/// Functions that a simulation and one on many ranks have under the same names.
macro_rules! of_the_same_name {
    () => {
        fn check_balance(&self) -> Result<(), Stop> {
            self.check_balance()
        }

        fn steps(&self) -> u64 {
            self.steps()
        }

        fn time(&self) -> f64 {
            self.time()
        }

        fn time_step(&self) -> f64 {
            self.time_step()
        }

        fn critical_step(&self) -> CriticalStep {
            self.critical_step()
        }

        fn threads(&self) -> usize {
            self.threads()
        }

        fn timings(&self) -> Timings {
            self.timings()
        }

        fn counts(&self) -> Counts {
            self.counts()
        }

        fn penetrated(&self) -> Option<[u32; 2]> {
            self.penetrated()
        }

        fn deepest_overlap(&self) -> Option<(f64, u32)> {
            self.deepest_overlap()
        }

        fn energies(&self) -> Energies {
            self.energies()
        }

        fn imbalance(&self) -> f64 {
            self.imbalance()
        }

        fn force(&self, boundary: usize) -> Option<[f64; D]> {
            self.force(boundary)
        }

        fn moment(&self, boundary: usize) -> Option<[f64; 3]> {
            self.moment(boundary)
        }

        fn measure(&self, probes: &[Probe<D, N>]) -> Vec<Vec<f64>> {
            self.measure(probes)
        }

        fn crack_lengths(&self) -> [f64; 3] {
            self.crack_lengths()
        }

        fn fragments(&self) -> Vec<u32> {
            self.fragments()
        }

        fn snapshot(&self) -> Snapshot<D, N> {
            self.snapshot()
        }

        fn intact_joints(&self) -> Vec<Crack<D>> {
            self.intact_joints()
        }

        fn state(&self) -> State<D, N> {
            self.state()
        }

        fn nodes(&self, nodes: &[u32]) -> Vec<Moved<D>> {
            let found = self.nodes(nodes).into_iter();
            found.map(|node| node.unwrap_or(([f64::NAN; D], [f64::NAN; D]))).collect()
        }
    };
}

impl<const D: usize, const N: usize> Engine<D, N> for Simulation<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    of_the_same_name!();

    fn advance(&mut self, steps: u64) -> Result<(), Stop> {
        self.advance_unsettled(steps)
    }

    fn settle(&self) -> Result<(), Stop> {
        self.settle()
    }

    fn check_device(&self) -> Result<(), Stop> {
        self.check_device()
    }

    fn set_factor(&mut self, boundary: usize, factor: f64) -> Result<(), String> {
        self.set_factor(boundary, Some(factor)).map_err(|error| error.to_string())
    }

    fn replace(&mut self, with: Self) -> Result<(), String> {
        // Only a device refuses a run.
        self.replace(with).map_err(|error| {
            format!("--device gpu: {error}. `fdem resume` continues the run on the processor, from its last checkpoint")
        })
    }

    fn elements(&self) -> usize {
        self.model().mesh.elements.len()
    }

    fn released_bodies(&self) -> Vec<u32> {
        self.released_bodies()
    }

    fn frame(&self) -> (Snapshot<D, N>, Forces<D>) {
        (self.snapshot(), self.forces())
    }

    fn traffic(&self) -> Vec<Traffic> {
        Vec::new()
    }
}

impl<const D: usize, const N: usize> Engine<D, N> for Leader<'_, D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    of_the_same_name!();

    fn advance(&mut self, steps: u64) -> Result<(), Stop> {
        self.advance(steps)
    }

    /// Ranks have no devices.
    fn settle(&self) -> Result<(), Stop> {
        Ok(())
    }

    fn check_device(&self) -> Result<(), Stop> {
        Ok(())
    }

    fn set_factor(&mut self, boundary: usize, factor: f64) -> Result<(), String> {
        self.set_factor(boundary, factor).map_err(|error| error.to_string())
    }

    fn replace(&mut self, with: Simulation<D, N>) -> Result<(), String> {
        self.replace(with).map_err(|error| error.to_string())
    }

    fn elements(&self) -> usize {
        self.elements()
    }

    fn released_bodies(&self) -> Vec<u32> {
        // A run on many ranks has none.
        Vec::new()
    }

    fn frame(&self) -> (Snapshot<D, N>, Forces<D>) {
        self.frame()
    }

    fn traffic(&self) -> Vec<Traffic> {
        self.traffic()
    }
}
