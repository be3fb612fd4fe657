//! Boundaries, conditions and stages: the actions on the bodies, and their times.

pub(crate) mod schedules;
pub(crate) mod cavities;
pub(crate) mod fluid;
pub(crate) mod injections;
pub(crate) mod acting;
pub(crate) mod places;
pub(crate) mod boundaries;
pub(crate) mod pores;
pub(crate) mod pore_surfaces;
pub(crate) mod conditions;
pub(crate) mod resolve;
pub(crate) mod present;
pub(crate) mod supports;
