//! Boundaries, conditions and stages: what acts on the bodies, and when.

pub(crate) mod schedules;
pub(crate) mod cavities;
pub(crate) mod boundaries;
pub(crate) mod conditions;
pub(crate) mod resolve;
pub(crate) mod present;
