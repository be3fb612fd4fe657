//! A run on many ranks that one of them leads, as if it had the run for itself.

use std::cell::RefCell;

use fdem_distributed::Communicator;
use fdem_distributed::wire::{bytes_of, value_of};

use crate::critical::CriticalStep;
use crate::energy::Energies;
use crate::error::{ModelError, Stop};
use crate::forces::Forces;
use crate::probe::Probe;
use crate::ranks::distributed::{Distributed, Traffic};
use crate::ranks::gather::Gathered;
use crate::simulation::advance::Concrete;
use crate::simulation::run::{Counts, Simulation};
use crate::simulation::saved::State;
use crate::snapshot::{Crack, Snapshot};
use crate::timings::Timings;

/// A task that the leader gives to all ranks together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LeaderOrder {
    End,
    Replace,
    Advance,
    Gather,
    Fragments,
    Counts,
    Penetrated,
    Nodes,
    CrackLengths,
    Traffic,
    SetProbes,
    Measure,
    SetFactor,
    CheckBalance,
}

impl LeaderOrder {
    const ALL: [Self; 14] = [
        Self::End,
        Self::Replace,
        Self::Advance,
        Self::Gather,
        Self::Fragments,
        Self::Counts,
        Self::Penetrated,
        Self::Nodes,
        Self::CrackLengths,
        Self::Traffic,
        Self::SetProbes,
        Self::Measure,
        Self::SetFactor,
        Self::CheckBalance,
    ];
}

/// Gives an order, with a number or with numbers.
fn give(communicator: &dyn Communicator, order: LeaderOrder, numbers: &[u64]) {
    let mut bytes = bytes_of(&(order as u8, numbers.to_vec()));
    communicator.broadcast(&mut bytes);
}

/// A run on many ranks, on rank 0. The other ranks call [`follow`].
///
/// Its methods are those of a [`Simulation`]; each is done by all ranks together.
pub struct Leader<'c, const D: usize = 2, const N: usize = 3> {
    communicator: &'c dyn Communicator,
    run: RefCell<Distributed<'c, D, N>>,
    /// The whole run after the last step, once it has been requested.
    whole: RefCell<Option<Gathered<D, N>>>,
    /// The probes that all ranks know.
    probes: RefCell<Vec<Probe<D, N>>>,
}

impl<'c, const D: usize, const N: usize> Leader<'c, D, N>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    /// Leads a run. `threads`: threads of this rank; 0 for one per processor.
    ///
    /// # Errors
    /// If threads cannot be started.
    ///
    /// # Panics
    /// On another rank than 0.
    pub fn new(
        communicator: &'c dyn Communicator,
        run: Simulation<D, N>,
        threads: usize,
    ) -> Result<Self, ModelError> {
        assert!(communicator.rank() == 0, "rank 0 leads");
        give(communicator, LeaderOrder::Advance, &[D as u64]);
        let run = Distributed::new(communicator, Some(run), threads)?;
        Ok(Self {
            communicator,
            run: RefCell::new(run),
            whole: RefCell::new(None),
            probes: RefCell::default(),
        })
    }

    fn all<T>(&self, order: LeaderOrder, numbers: &[u64], of: impl FnOnce(&Distributed<'c, D, N>) -> T) -> T {
        give(self.communicator, order, numbers);
        of(&self.run.borrow())
    }

    /// Continues with another run in place of this one, such as that of a changed model.
    ///
    /// # Errors
    /// If threads cannot be started.
    pub fn replace(&mut self, mut run: Simulation<D, N>) -> Result<(), ModelError> {
        run.go_on(self.timings(), self.counts().detections);
        *self.whole.get_mut() = None;
        give(self.communicator, LeaderOrder::Replace, &[]);
        let threads = self.run.get_mut().threads();
        *self.run.get_mut() = Distributed::new(self.communicator, Some(run), threads)?;
        Ok(())
    }

    /// Advances the run by `steps` steps.
    ///
    /// # Errors
    /// The reason why the run cannot continue.
    pub fn advance(&mut self, steps: u64) -> Result<(), Stop> {
        *self.whole.get_mut() = None;
        give(self.communicator, LeaderOrder::Advance, &[steps]);
        self.run.get_mut().advance(steps)
    }

    /// Checks the energy balance at the end of a run: see [`Simulation::check_balance`].
    ///
    /// # Errors
    /// Those of [`Simulation::check_balance`].
    pub fn check_balance(&self) -> Result<(), Stop> {
        self.all(LeaderOrder::CheckBalance, &[], Distributed::check_balance)
    }

    /// Sets the factor of a boundary from the next step on, in place of its schedule: see
    /// [`Simulation::set_factor`].
    ///
    /// # Errors
    /// The errors of [`Simulation::set_factor`].
    pub fn set_factor(&mut self, boundary: usize, factor: f64) -> Result<(), ModelError> {
        *self.whole.get_mut() = None;
        give(self.communicator, LeaderOrder::SetFactor, &[boundary as u64, factor.to_bits()]);
        self.run.get_mut().set_factor(boundary, Some(factor))
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.run.borrow().steps()
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.run.borrow().time()
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.run.borrow().time_step()
    }

    /// The longest stable time step, and the part that sets it.
    pub fn critical_step(&self) -> CriticalStep {
        self.run.borrow().critical_step()
    }

    /// Energies at the beginning of the last step, J.
    pub fn energies(&self) -> Energies {
        self.run.borrow().energies()
    }

    /// Whether forces are in equilibrium: see [`Simulation::imbalance`].
    pub fn imbalance(&self) -> f64 {
        self.run.borrow().imbalance()
    }

    /// Force of a boundary on the bodies at the beginning of the last step, N; `None` if there is no such
    /// boundary.
    pub fn force(&self, boundary: usize) -> Option<[f64; D]> {
        self.run.borrow().force(boundary)
    }

    /// Moment of a boundary on the bodies, N m: see [`Simulation::moment`].
    pub fn moment(&self, boundary: usize) -> Option<[f64; 3]> {
        self.run.borrow().moment(boundary)
    }

    /// Computing time of this rank so far, by parts of the steps.
    pub fn timings(&self) -> Timings {
        self.run.borrow().timings()
    }

    /// Number of threads of this rank.
    pub fn threads(&self) -> usize {
        self.run.borrow().threads()
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.run.borrow().elements()
    }

    /// Numbers of joints, contacts and nodes. Detections are those of the rank with most.
    pub fn counts(&self) -> Counts {
        self.all(LeaderOrder::Counts, &[], Distributed::counts)
    }

    /// The elements of the first couple in which one element reached the centroid of the other in the last
    /// step; `None` if there is no such couple.
    pub fn penetrated(&self) -> Option<[u32; 2]> {
        self.all(LeaderOrder::Penetrated, &[], Distributed::penetrated)
    }

    /// The deepest overlap of a sphere so far: see [`Simulation::deepest_overlap`]. All ranks have all
    /// spheres.
    pub fn deepest_overlap(&self) -> Option<(f64, u32)> {
        self.run.borrow().run.deepest_overlap()
    }

    /// Displacements, m, and velocities, m/s, of some nodes of the mesh: see [`Simulation::node`].
    pub fn nodes(&self, nodes: &[u32]) -> Vec<Option<([f64; D], [f64; D])>> {
        let numbers: Vec<u64> = nodes.iter().map(|&node| u64::from(node)).collect();
        self.all(LeaderOrder::Nodes, &numbers, |run| run.nodes(nodes))
    }

    /// Total lengths, m, or areas, m², of joints that broke by opening, by sliding, and by both.
    pub fn crack_lengths(&self) -> [f64; 3] {
        self.all(LeaderOrder::CrackLengths, &[], Distributed::crack_lengths)
    }

    /// Measures quantities of the run now: see [`Simulation::measure`].
    pub fn measure(&self, probes: &[Probe<D, N>]) -> Vec<Vec<f64>> {
        if probes.is_empty() {
            return Vec::new();
        }
        // Lists of elements may be long, and are sent once.
        if *self.probes.borrow() != probes {
            give(self.communicator, LeaderOrder::SetProbes, &[]);
            let known = probes.to_vec();
            self.communicator.broadcast(&mut bytes_of(&known));
            *self.probes.borrow_mut() = known;
        }
        self.all(LeaderOrder::Measure, &[], |run| run.measure(probes))
    }

    /// Fragment of each element: see [`Simulation::fragments`].
    pub fn fragments(&self) -> Vec<u32> {
        self.all(LeaderOrder::Fragments, &[], Distributed::fragments).unwrap_or_default()
    }

    /// Positions, motion, stress and cracks now.
    pub fn snapshot(&self) -> Snapshot<D, N> {
        self.look(Gathered::snapshot)
    }

    /// The whole joints now: see [`Simulation::intact_joints`].
    pub fn intact_joints(&self) -> Vec<Crack<D>> {
        self.look(Gathered::intact_joints)
    }

    /// Positions, motion, stress and cracks now, with the forces at the beginning of the last step.
    ///
    /// # Panics
    /// If rank 0 does not get them, which would be a bug.
    pub fn frame(&self) -> (Snapshot<D, N>, Forces<D>) {
        self.look(|whole| (whole.snapshot(), whole.forces()))
    }

    /// State from which the run can be resumed, on any number of ranks.
    ///
    /// # Panics
    /// If rank 0 does not get it, which would be a bug.
    pub fn state(&self) -> State<D, N> {
        self.look(Gathered::state)
    }

    /// Looks at the whole run. It is gathered once for each step.
    fn look<T>(&self, at: impl FnOnce(&Gathered<D, N>) -> T) -> T {
        let mut known = self.whole.borrow_mut();
        let whole = known.get_or_insert_with(|| {
            self.all(LeaderOrder::Gather, &[], Distributed::gathered).expect("rank 0 gets the whole run")
        });
        at(whole)
    }

    /// The elements and the traffic of each rank.
    pub fn traffic(&self) -> Vec<Traffic> {
        self.all(LeaderOrder::Traffic, &[], Distributed::traffic_of_all)
    }
}

impl<const D: usize, const N: usize> Drop for Leader<'_, D, N> {
    fn drop(&mut self) {
        // After a panic the other ranks are ended, and nobody listens.
        if !std::thread::panicking() {
            give(self.communicator, LeaderOrder::End, &[]);
        }
    }
}

/// Informs the other ranks that there will be no run, so that [`follow`] returns.
pub fn dismiss(communicator: &dyn Communicator) {
    give(communicator, LeaderOrder::End, &[]);
}

/// Does a rank's part of a run that rank 0 leads, until it ends. `threads`: threads of this rank; 0 for one
/// per processor.
///
/// # Errors
/// If threads cannot be started.
pub fn follow(communicator: &dyn Communicator, threads: usize) -> Result<(), ModelError> {
    match next(communicator) {
        (LeaderOrder::Advance, dimensions) if dimensions == [2] => follow_in::<2, 3>(communicator, threads),
        (LeaderOrder::Advance, _) => follow_in::<3, 4>(communicator, threads),
        _ => Ok(()),
    }
}

/// The next order.
fn next(communicator: &dyn Communicator) -> (LeaderOrder, Vec<u64>) {
    let mut bytes = Vec::new();
    communicator.broadcast(&mut bytes);
    let (order, numbers) = value_of::<(u8, Vec<u64>)>(&bytes);
    (LeaderOrder::ALL[order as usize], numbers)
}

fn follow_in<const D: usize, const N: usize>(
    communicator: &dyn Communicator,
    threads: usize,
) -> Result<(), ModelError>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    let mut run = Distributed::<D, N>::new(communicator, None, threads)?;
    let mut probes = Vec::new();
    loop {
        let (order, numbers) = next(communicator);
        match order {
            LeaderOrder::End => return Ok(()),
            LeaderOrder::Replace => run = Distributed::new(communicator, None, threads)?,
            // The leader gets the same error, and reports it.
            LeaderOrder::Advance => drop(run.advance(numbers[0])),
            LeaderOrder::Gather => drop(run.gathered()),
            LeaderOrder::Fragments => drop(run.fragments()),
            LeaderOrder::Counts => _ = run.counts(),
            LeaderOrder::Penetrated => _ = run.penetrated(),
            LeaderOrder::Nodes => {
                drop(run.nodes(&numbers.iter().map(|&node| node as u32).collect::<Vec<u32>>()));
            }
            LeaderOrder::CrackLengths => _ = run.crack_lengths(),
            LeaderOrder::Traffic => drop(run.traffic_of_all()),
            LeaderOrder::SetProbes => {
                let mut bytes = Vec::new();
                communicator.broadcast(&mut bytes);
                probes = value_of::<Vec<Probe<D, N>>>(&bytes);
            }
            // The leader gets the same error, and reports it.
            LeaderOrder::CheckBalance => drop(run.check_balance()),
            LeaderOrder::Measure => drop(run.measure(&probes)),
            // The leader gets the same error, and reports it.
            LeaderOrder::SetFactor => {
                drop(run.set_factor(numbers[0] as usize, Some(f64::from_bits(numbers[1]))));
            }
        }
    }
}
