//! The engines, and how a search was planned.

use std::fmt;

use crate::search::level::Level;

/// An engine of a search. All engines find the same couples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Engine {
    /// [`Direct`](crate::Direct): every element against every other.
    Direct,
    /// [`Nbs`](crate::Nbs): Munjiza-NBS as published.
    Nbs,
    /// [`Rows`](crate::Rows): the decomposition of NBS on sorted rows.
    Rows,
    /// [`Multilevel`](crate::Multilevel): the same for unlike sizes, in levels.
    Multilevel,
    /// [`CGrid`](crate::CGrid): lists that bodies enter and leave, for bodies that span many cells.
    CGrid,
}

impl Engine {
    /// All engines.
    pub const ALL: [Self; 5] = [Self::Direct, Self::Nbs, Self::Rows, Self::Multilevel, Self::CGrid];

    /// The name in lower case, as the command spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Nbs => "nbs",
            Self::Rows => "rows",
            Self::Multilevel => "multilevel",
            Self::CGrid => "cgrid",
        }
    }
}

impl fmt::Display for Engine {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// How a [`Detector`](crate::Detector) will search a set of elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan<const D: usize> {
    /// The engine that runs.
    pub engine: Engine,
    /// The reason for this engine, in words.
    pub reason: String,
    /// Edge of a cell, in the unit of the coordinates; `None` without cells.
    pub cell_size: Option<f64>,
    /// Number of cells along each axis; `None` without cells.
    pub cells: Option<[u64; D]>,
    /// The levels of [`Engine::Multilevel`] and [`Engine::CGrid`], each with its own cells, the smallest
    /// elements first; empty for other engines.
    pub levels: Vec<Level>,
}

impl<const D: usize> Plan<D> {
    /// A plan that tests all elements with all others.
    pub(crate) fn without_cells(reason: &str) -> Self {
        Self {
            engine: Engine::Direct,
            reason: reason.to_owned(),
            cell_size: None,
            cells: None,
            levels: Vec::new(),
        }
    }
}
