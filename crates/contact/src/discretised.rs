//! Contacts of bodies that are meshed with finite elements: triangles in 2D, tetrahedra and triangles of
//! surfaces in 3D.
//!
//! Detection works on elements: the bounding boxes go through a [`Detector`](crate::Detector), then the exact
//! narrow phase ([`narrow`](crate::narrow)) tests the couples. The contacts of elements are then gathered to
//! contacts of bodies.
//!
//! ```
//! use fdem_contact::discretised::{MeshView, body_contacts, contacts};
//!
//! // Two squares of two triangles each, side by side; they have the nodes 1 and 2 in common.
//! let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0]];
//! let triangles = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
//! let mesh = MeshView::new(&points, &triangles, &[0, 0, 7, 7])?;
//! let found = contacts(&mesh)?;
//! assert_eq!(found.len(), 3); // one along the side, two at its ends
//!
//! let bodies = body_contacts(&mesh, &found)?;
//! assert_eq!(bodies.len(), 1);
//! assert_eq!(bodies[0].bodies, [0, 7]);
//! assert_eq!((bodies[0].overlap, bodies[0].shared), (0.0, 1.0));
//! assert_eq!((bodies[0].point, bodies[0].normal), ([1.0, 0.5], [1.0, 0.0]));
//! # Ok::<(), fdem_contact::discretised::DiscretisedError>(())
//! ```
//!
//! | for | use |
//! |---|---|
//! | the contacts of elements, once | [`contacts`] |
//! | to search again, on threads, with another engine, or for contacts of a body with itself | [`MeshSearch`] |
//! | which bodies touch, where, and how much | [`body_contacts`], [`gather`] |
//! | spheres against walls of triangles | [`MeshSearch::sphere_contacts`] |
//!
//! # When do two elements touch?
//! Touching counts. Elements of two bodies with a common node touch there, and so do bodies with conforming
//! meshes, with an overlap of 0. [`BodyContact`] distinguishes bodies that overlap, bodies that share a piece
//! of boundary, and bodies that meet in points or edges only. Elements of the same body form no couple,
//! unless [`MeshSearch::with_self_contact`] is set.

mod bodies;
mod error;
mod search;
mod element;
mod spheres;
mod view;

pub use bodies::{BodyContact, body_contacts, gather};
pub use element::MeshElement;
pub use error::DiscretisedError;
pub use search::{MeshSearch, contacts};
pub use spheres::SphereContact;
pub use view::{ElementContact, MeshView};
