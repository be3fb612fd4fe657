//! The exact narrow phase: whether two bodies touch, where, in which direction and by how much. It knows
//! geometry only.
//!
//! ```
//! use fdem_contact::narrow::{Measure, Sphere, Triangle, sphere_triangle};
//!
//! let ball = Sphere::new([0.2, 0.2, 0.9], 1.0)?;
//! let wall = Triangle::new([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])?;
//! let (contact, _feature) = sphere_triangle(&ball, &wall);
//! assert!(matches!(contact.measure, Measure::Depth(depth) if (depth - 0.1).abs() < 1e-15));
//! assert_eq!(contact.normal, [0.0, 0.0, -1.0]); // from the ball to the wall
//! # Ok::<(), fdem_contact::narrow::ShapeError>(())
//! ```
//!
//! | pair | function | measure of a touch |
//! |---|---|---|
//! | sphere, sphere | [`sphere_sphere`] | depth |
//! | sphere, plane | [`sphere_plane`] | depth |
//! | sphere, triangle | [`sphere_triangle`] | depth |
//! | sphere, mesh of triangles | [`sphere_mesh`] | depth, each face, edge and vertex once |
//! | segment, segment | [`segment_segment`] | length in common |
//! | capsule, capsule | [`capsule_capsule`] | depth |
//! | triangle, triangle in 2D | [`triangle_triangle_2d`] | area |
//! | convex polygon, convex polygon | [`polygon_polygon`] | area |
//! | triangle, triangle in 3D | [`triangle_triangle`] | length in common, or area if coplanar |
//! | tetrahedron, tetrahedron | [`tetrahedron_tetrahedron`] | volume |
//! | oriented box, oriented box | [`box_box`] | depth |
//!
//! # When do two bodies touch?
//! Touching counts: the comparison is closed. Segments, triangles, polygons and tetrahedra are decided
//! exactly, by the signs of [`robust`] predicates. Round bodies and oriented boxes are decided by the
//! floating-point operations that their functions document. For spheres these are the operations of
//! [`Elements`](crate::Elements), so both phases agree.
//!
//! # Degenerate bodies
//! A shape without area or volume is the point, the segment or the flat piece that its vertices span, and
//! touches as such; the measure is then 0. If the geometry gives no direction (centres that coincide,
//! segments that cross), each function documents the normal that it returns.
//!
//! # Range of numbers
//! Constructors check every coordinate once. It must be finite, and either 0 or between [`MIN_MAGNITUDE`] and
//! [`MAX_MAGNITUDE`], where no predicate overflows or underflows. After that no function fails. overflows or
//! underflows. After that no function fails.

mod contact;
mod vector;
pub(crate) mod exact;
mod error;
mod shapes;
mod sphere;
mod mesh;
mod polygon;
mod segment;
mod triangle;
mod tetrahedron;
mod oriented_box;

pub use contact::{Contact, Measure};
pub use error::ShapeError;
pub use exact::{MAX_MAGNITUDE, MIN_MAGNITUDE};
pub use mesh::{MeshContact, sphere_mesh};
pub use oriented_box::{OrientedBox, box_box};
pub use polygon::{ConvexPolygon, polygon_polygon, triangle_triangle_2d};
pub use segment::{capsule_capsule, segment_segment};
pub use shapes::{Capsule, Plane, Segment, Sphere, Tetrahedron, Triangle};
pub use sphere::{Feature, sphere_plane, sphere_sphere, sphere_triangle};
pub use tetrahedron::tetrahedron_tetrahedron;
pub use triangle::triangle_triangle;
