//! Results in three dimensions: compressed frames of bodies of tetrahedra, and their visible parts.
//!
//! ```text
//! Mesh ─> Shell ─┐
//!      Snapshot ─┴─> SpaceFrame ──┬─> SpaceReport ── one page
//!                                 └─> SpacePictures ── SVG, PNG, SpaceAnimation (GIF)
//! ```
//! A [`Shell`] knows which facets of a mesh are on the outside. A [`SpaceFrame`] has the elements that are
//! seen, and, of small meshes, also those inside, so that a cut shows them.

pub(crate) mod drawing;
pub(crate) mod facets;
pub(crate) mod frame;
mod opened;
mod pictures;
mod section;
mod shell;
pub(crate) mod view;

pub use frame::{MOST_INSIDE, SpaceFrame};
pub use pictures::{Cut, Show, SpacePictures};
pub use shell::Shell;
pub use view::SpaceView;

#[cfg(test)]
mod tests;
