//! Cases of bodies of tetrahedra.

pub(super) mod bars;
pub(crate) mod bodies;
pub(super) mod brazilian;
pub(super) mod cantilever;
pub(super) mod cavity;
pub(super) mod compression;
pub(super) mod debris;
pub(super) mod disc;
pub(super) mod free_crack;
pub(super) mod hertz;
pub(super) mod hole;
pub(super) mod impact;
pub(super) mod incline;
pub(super) mod locking;
pub(super) mod penny;
pub(super) mod perforation;
pub(super) mod rigid;
pub(super) mod rigid_wall;
pub(super) mod rotation;
pub(super) mod shear;
pub(super) mod sphere;
pub(super) mod tension;
pub(super) mod tower;
pub(super) mod waves;
