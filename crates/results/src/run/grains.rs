//! Results of spheres and walls: files for ParaView, and the parts of frames that pictures and pages show.
//!
//! ```text
//! SphereColumns ──┬─> spheres, contacts, walls ── ParaView
//!                 └─> GrainFrame, a part of Frame and SpaceFrame ── pictures, pages
//! ```

mod coarse;
mod columns;
pub(crate) mod drawing;
pub(crate) mod frame;
mod vtk;
pub(crate) mod walls;

pub use coarse::{CoarseError, CoarseFields, CoarseGrid};
pub use vtk::{write_sphere_contacts_vtp, write_spheres_vtp, write_walls_vtp};
