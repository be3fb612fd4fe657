//! Spheres and walls: tables of a model file become a `GrainModel`.

pub(crate) mod assemble;
pub(crate) mod checks;
pub(crate) mod clumps;
pub(crate) mod coming;
pub(crate) mod coming_checks;
pub(crate) mod overlaps;
pub(crate) mod spheres;
pub(crate) mod surfaces;
pub(crate) mod wall_checks;
pub(crate) mod walls;
