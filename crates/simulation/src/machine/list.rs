//! The machine that a new run has: threads.

use crate::machine::threads::Threads;
use crate::machine::{Columns, Machine};
use crate::simplex::Simplex;
use crate::team::Team;

/// Elements for which there are machines.
///
/// The phases of a step are compiled here, once and optimised; a generic function would be compiled in each
/// crate that calls it, with the options of that crate.
pub(crate) trait Machines<const D: usize, const N: usize>: Simplex<D, N> {
    /// The machine of a new run with these columns. `team`: the threads of the run.
    fn machine(columns: Columns<D, N>, team: &Team) -> Box<dyn Machine<D, N>>;
}

macro_rules! machines {
    ($($d:literal, $n:literal);*) => {$(
        impl Machines<$d, $n> for [[f64; $d]; $n] {
            fn machine(columns: Columns<$d, $n>, team: &Team) -> Box<dyn Machine<$d, $n>> {
                Box::new(Threads::new(columns, team.clone()))
            }
        }
    )*};
}

machines!(2, 3; 3, 4);
