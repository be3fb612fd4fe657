//! The choice of an engine, and one search that holds them all.

use std::fmt;

use crate::couple::Couple;
use crate::elements::Elements;
use crate::error::Error;
use crate::real::Real;
use crate::search::Search;
use crate::search::direct::Direct;
use crate::search::nbs::Nbs;

/// Which search to run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Engine {
    /// Picked from the elements; [`Plan::reason`] says why.
    #[default]
    Auto,
    /// [`Direct`]: all against all.
    Direct,
    /// [`Nbs`]: Munjiza-NBS as published.
    Nbs,
}

impl Engine {
    /// Lower-case name, as the command spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Direct => "direct",
            Self::Nbs => "nbs",
        }
    }
}

impl fmt::Display for Engine {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// What a [`Detector`] does with a set of elements, known before it does it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan<const D: usize> {
    /// The engine that runs: never [`Engine::Auto`].
    pub engine: Engine,
    /// Why this engine, for a person to read.
    pub reason: String,
    /// Edge of a cell, in the unit of the coordinates; `None` where there are no cells.
    pub cell_size: Option<f64>,
    /// Cells along each axis; `None` where there are none.
    pub cells: Option<[u32; D]>,
}

/// Below this number of elements all-against-all beats any structure.
const FEW_ELEMENTS: usize = 32;

/// Up to this number of elements, where NBS cannot hold the domain, all-against-all takes some seconds at most.
const MANY_ELEMENTS: usize = 100_000;

/// The engine that fits, with the memory of all of them kept between calls.
///
/// # Example
/// ```
/// use fdem_contact::{Detector, Elements, Engine, Search};
///
/// let centres: Vec<[f64; 2]> = (0..100).map(|k| [f64::from(k), 0.0]).collect();
/// let elements = Elements::points(&centres, 1.0)?;
/// let mut detector = Detector::new(Engine::Auto);
/// println!("{}", detector.plan(&elements)?.reason);
/// assert_eq!(detector.count(&elements)?, 99);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Detector<const D: usize> {
    engine: Engine,
    nbs: Nbs<D>,
}

impl<const D: usize> Detector<D> {
    /// A detector that holds no memory yet.
    pub fn new(engine: Engine) -> Self {
        Self { engine, nbs: Nbs::new() }
    }

    /// What a search over `elements` will do.
    ///
    /// # Errors
    /// Those of [`Search::for_each`] that need no memory to be found.
    pub fn plan<T: Real>(&self, elements: &Elements<'_, T, D>) -> Result<Plan<D>, Error> {
        let n = elements.len();
        let direct = |reason| Plan { engine: Engine::Direct, reason, cell_size: None, cells: None };
        let nbs = |reason: &str| {
            let grid = self.nbs.plan(elements)?;
            let reason = reason.to_owned();
            Ok(Plan {
                engine: Engine::Nbs,
                reason,
                cell_size: Some(grid.cell_size()),
                cells: Some(grid.cells()),
            })
        };
        match self.engine {
            Engine::Direct => Ok(direct("asked for".to_owned())),
            Engine::Nbs => nbs("asked for"),
            Engine::Auto if n <= FEW_ELEMENTS => {
                Ok(direct(format!("all against all is quickest for at most {FEW_ELEMENTS} elements")))
            }
            Engine::Auto => match nbs("linear in N whatever the packing") {
                Err(Error::DomainTooWide { element, .. }) if n <= MANY_ELEMENTS => Ok(direct(format!(
                    "the domain, stretched by element {element}, is too wide for the list heads of NBS"
                ))),
                plan => plan,
            },
        }
    }
}

impl<const D: usize> Search<D> for Detector<D> {
    fn for_each<T: Real>(
        &mut self,
        elements: &Elements<'_, T, D>,
        visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        match self.plan(elements)?.engine {
            Engine::Direct => Direct.for_each(elements, visit),
            Engine::Auto | Engine::Nbs => self.nbs.for_each(elements, visit),
        }
    }
}
