//! Many steps, in one process or on a rank of many.

use crate::compiled::compiled;
use crate::error::Stop;
use crate::machine::list::Machines;
use crate::model::Model;
use crate::peers::{Alone, Peers};
use crate::ranks::links::Links;
use crate::simulation::run::Simulation;

/// The corners of an element that can be simulated: `[[f64; 2]; 3]`, a triangle, and `[[f64; 3]; 4]`, a
/// tetrahedron. There are no others.
///
/// Code for both dimensions has the bound `[[f64; D]; N]: Element<D, N>`.
pub trait Element<const D: usize, const N: usize>: Concrete<D, N> {}

/// Functions that are written for the two kinds of elements, and not for all dimensions.
pub(crate) trait Concrete<const D: usize, const N: usize>: Machines<D, N> {
    /// Takes `steps` steps. `links`: messages to other ranks, if this is a part of a run; then it takes fewer
    /// if ranks must first look for elements near theirs.
    ///
    /// Steps are compiled here, once and optimised; a generic function would be compiled in each crate that
    /// calls it, with the options of that crate.
    fn take(run: &mut Simulation<D, N>, steps: u64, links: Option<&mut Links<'_>>) -> Result<(), Stop>;

    /// A model as bytes, and back. Only arrays of given lengths can be serialised.
    fn encode(model: &Model<D, N>) -> Vec<u8>;
    fn decode(bytes: &[u8]) -> Model<D, N>;
}

macro_rules! concrete {
    ($($d:literal, $n:literal);*) => {$(
        impl Concrete<$d, $n> for [[f64; $d]; $n] {
            fn take(
                run: &mut Simulation<$d, $n>,
                steps: u64,
                links: Option<&mut Links<'_>>,
            ) -> Result<(), Stop> {
                run.take(steps, links)
            }

            fn encode(model: &Model<$d, $n>) -> Vec<u8> {
                postcard::to_allocvec(model).expect("a model has no values that cannot be written")
            }

            fn decode(bytes: &[u8]) -> Model<$d, $n> {
                postcard::from_bytes(bytes).expect("a message from the same program")
            }
        }

        impl Element<$d, $n> for [[f64; $d]; $n] {}
    )*};
}

concrete!(2, 3; 3, 4);

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    /// Advances the run by `steps` steps.
    ///
    /// # Errors
    /// The reason why the run cannot continue. The run stays at the step in which this was found.
    pub fn advance(&mut self, steps: u64) -> Result<(), Stop> {
        self.advance_unsettled(steps)?;
        self.settle()
    }

    /// Advances the run as [`Simulation::advance`]. The columns of a run on a device stay there:
    /// [`Simulation::measure`], [`Simulation::nodes`] and other functions read the few values from it that
    /// they need, and [`Simulation::snapshot`], [`Simulation::forces`] and [`Simulation::state`] all of them.
    /// A device can fail then: values count once [`Simulation::check_device`] has returned after they were
    /// read, or [`Simulation::settle`] before.
    ///
    /// # Errors
    /// The reason why the run cannot continue. The run stays at the step in which this was found.
    pub fn advance_unsettled(&mut self, steps: u64) -> Result<(), Stop> {
        <[[f64; D]; N]>::take(self, steps, None)
    }

    /// Checks the energy balance after the last step of [`Simulation::advance`], which does so every 100
    /// steps only. Call it at the end of a run. The run is not changed, and can continue.
    ///
    /// # Errors
    /// The reasons for which [`Simulation::advance`] would have stopped, if it had checked the last step.
    pub fn check_balance(&self) -> Result<(), Stop> {
        let run = self;
        compiled!((run: reference [Simulation<2, 3>, Simulation<3, 4>])
            -> [Result<(), Stop>, Result<(), Stop>] = Simulation::audit_alone)
    }

    fn audit_alone(&self) -> Result<(), Stop> {
        self.audit_end(&Alone)
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    fn take(&mut self, steps: u64, links: Option<&mut Links<'_>>) -> Result<(), Stop> {
        let Some(links) = links else {
            let team = self.team.clone();
            return team.keep_awake(|| self.take_with(steps, &mut Alone));
        };
        self.take_with(steps, links)
    }

    fn take_with(&mut self, steps: u64, peers: &mut dyn Peers<D, N>) -> Result<(), Stop> {
        let last = self.step.saturating_add(steps).saturating_sub(1);
        let done = (0..steps).try_for_each(|_| {
            if peers.is_stale() {
                return Ok(());
            }
            let energies = self.is_audited() || self.step == last;
            self.step(energies, peers)?;
            self.release_overloaded()
        });
        // Energies of the step that failed. Where a step turns velocities round, their product before and
        // after it is negative, and says nothing.
        if done.is_err() {
            let kinetic = self.kinetic_of_half_step();
            self.account(&kinetic, peers);
        }
        done.and_then(|()| self.machine.check())
    }
}
