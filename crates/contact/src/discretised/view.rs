//! A mesh as a search reads it, and the contacts of its elements.

use crate::discretised::{DiscretisedError, MeshElement};
use crate::narrow::{Contact, MAX_MAGNITUDE, MIN_MAGNITUDE};

/// A view of a mesh: nodes, the elements between them, and the body of each element. It borrows its arrays
/// and checks them.
///
/// # Shapes
/// `points` `[n]`; `elements` `[m]` of `N` indices into `points`: 3 in 2D, 3 (surfaces) or 4 (tetrahedra) in
/// 3D, in any order; `bodies` `[m]`, any numbers. An element may name a node twice; it is then the remaining
/// segment, point or triangle.
///
/// # Example
/// ```
/// use fdem_contact::discretised::{DiscretisedError, MeshView};
///
/// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// assert_eq!(MeshView::new(&corners, &[[0, 1, 2, 3]], &[0])?.len(), 1);
/// let error = MeshView::new(&corners, &[[0, 1, 4]], &[0]).unwrap_err();
/// assert_eq!(error, DiscretisedError::UnknownNode { element: 0, node: 4, nodes: 4 });
/// # Ok::<(), DiscretisedError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct MeshView<'a, const D: usize, const N: usize> {
    pub(super) points: &'a [[f64; D]],
    pub(super) elements: &'a [[u32; N]],
    pub(super) bodies: &'a [u32],
}

impl<'a, const D: usize, const N: usize> MeshView<'a, D, N>
where
    [[f64; D]; N]: MeshElement<D>,
{
    /// Checks and borrows the arrays.
    ///
    /// # Errors
    /// [`DiscretisedError::Bodies`], [`DiscretisedError::Coordinate`], [`DiscretisedError::UnknownNode`].
    pub fn new(
        points: &'a [[f64; D]],
        elements: &'a [[u32; N]],
        bodies: &'a [u32],
    ) -> Result<Self, DiscretisedError> {
        if bodies.len() != elements.len() {
            return Err(DiscretisedError::Bodies { elements: elements.len(), found: bodies.len() });
        }
        let in_range = |x: &f64| *x == 0.0 || (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&x.abs());
        for (node, point) in points.iter().enumerate() {
            if let Some(axis) = point.iter().position(|x| !in_range(x)) {
                return Err(DiscretisedError::Coordinate { node, axis, value: point[axis] });
            }
        }
        for (element, nodes) in elements.iter().enumerate() {
            if let Some(&node) = nodes.iter().find(|&&node| node as usize >= points.len()) {
                return Err(DiscretisedError::UnknownNode { element, node, nodes: points.len() });
            }
        }
        Ok(Self { points, elements, bodies })
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// The body of each element.
    pub fn bodies(&self) -> &'a [u32] {
        self.bodies
    }

    /// The vertices of an element.
    ///
    /// # Panics
    /// When `element` is not below [`MeshView::len`].
    #[inline]
    pub fn vertices(&self, element: usize) -> [[f64; D]; N] {
        self.elements[element].map(|node| self.points[node as usize])
    }

    /// The corners of the bounding box of an element.
    pub(super) fn bounds(&self, element: usize) -> [[f64; D]; 2] {
        let vertices = self.vertices(element);
        let corner = |pick: fn(f64, f64) -> f64| {
            std::array::from_fn(|k| vertices.iter().map(|p| p[k]).fold(vertices[0][k], pick))
        };
        [corner(f64::min), corner(f64::max)]
    }

    pub(super) fn have_a_node_in_common(&self, i: usize, j: usize) -> bool {
        self.elements[i].iter().any(|node| self.elements[j].contains(node))
    }
}

/// Two elements that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementContact<const D: usize> {
    /// The element with the smaller number.
    pub i: u32,
    /// The element with the larger number.
    pub j: u32,
    /// The contact, whose normal leads from `i` to `j`, as the function of the narrow phase documents it: the
    /// area of [`triangle_triangle_2d`](crate::narrow::triangle_triangle_2d), the length (area if coplanar)
    /// of [`triangle_triangle`](crate::narrow::triangle_triangle), or the volume of
    /// [`tetrahedron_tetrahedron`](crate::narrow::tetrahedron_tetrahedron); never a gap.
    pub contact: Contact<D>,
}
