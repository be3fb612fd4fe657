//! Shapes of bodies before they are meshed, and meshed pieces.

pub(crate) mod limits;
pub(crate) mod outline;
pub(crate) mod holes;
pub(crate) mod inward;
pub(crate) mod packing;
pub(crate) mod extent;
pub(crate) mod coincident;
pub(crate) mod distant;
pub(crate) mod of_body;
pub(crate) mod piece;
pub(crate) mod placed;
pub(crate) mod refine;
pub(crate) mod repeat;
