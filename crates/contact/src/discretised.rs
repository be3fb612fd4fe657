//! Contacts of bodies that are meshed with finite elements: triangles in 2D, tetrahedra and triangles of
//! surfaces in 3D.
//!
//! Detection works on elements: the bounding boxes go through a [`Detector`], then the exact narrow phase
//! ([`narrow`](crate::narrow)) tests the couples. The contacts of elements are then gathered to contacts of
//! bodies.
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
mod simplex;
mod spheres;

use crate::couple::Couple;
use crate::detector::Detector;
use crate::elements::Elements;
use crate::engine::Engine;
use crate::error::Error;
use crate::filter::Filter;
use crate::memory::{reserve, resize};
use crate::narrow::{Contact, MAX_MAGNITUDE, MIN_MAGNITUDE};
use crate::pool::Pool;
use crate::search::Search;
use crate::verify::{Mismatch, verify_with};
use simplex::sealed::Sealed as _;

pub use bodies::{BodyContact, body_contacts, gather};
pub use error::DiscretisedError;
pub use simplex::Simplex;
pub use spheres::SphereContact;

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
    points: &'a [[f64; D]],
    elements: &'a [[u32; N]],
    bodies: &'a [u32],
}

impl<'a, const D: usize, const N: usize> MeshView<'a, D, N>
where
    [[f64; D]; N]: Simplex<D>,
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
    fn bounds(&self, element: usize) -> [[f64; D]; 2] {
        let vertices = self.vertices(element);
        let corner = |pick: fn(f64, f64) -> f64| {
            std::array::from_fn(|k| vertices.iter().map(|p| p[k]).fold(vertices[0][k], pick))
        };
        [corner(f64::min), corner(f64::max)]
    }

    fn have_a_node_in_common(&self, i: usize, j: usize) -> bool {
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

/// All contacts of elements of different bodies. The engine is chosen from their boxes; one thread is used.
///
/// # Shapes
/// `m` contacts, `i < j`, each couple once, sorted by `i`, then `j`.
///
/// # Cost
/// See [`MeshSearch`].
///
/// # Errors
/// The errors of [`MeshSearch::contacts`].
///
/// # Example
/// ```
/// use fdem_contact::discretised::{MeshView, contacts};
/// use fdem_contact::narrow::Measure;
///
/// let points = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
/// let found = contacts(&MeshView::new(&points, &[[0, 1, 2], [3, 4, 5]], &[0, 1])?)?;
/// assert_eq!(found[0].contact.measure, Measure::Area(0.5));
/// # Ok::<(), fdem_contact::discretised::DiscretisedError>(())
/// ```
pub fn contacts<const D: usize, const N: usize>(
    mesh: &MeshView<'_, D, N>,
) -> Result<Vec<ElementContact<D>>, DiscretisedError>
where
    [[f64; D]; N]: Simplex<D>,
{
    let mut contacts = Vec::new();
    MeshSearch::new().contacts(mesh, &mut contacts)?;
    Ok(contacts)
}

/// Finds the contacts of elements, and those of spheres with surfaces. Its memory is kept between searches.
///
/// # Cost
/// The search over the bounding boxes, whose couples are stored (8 bytes each). Half a microsecond for each
/// of these if the elements are apart, and some microseconds if they touch. Results depend neither on the
/// engine nor on the threads.
///
/// # Example
/// ```
/// use fdem_contact::Engine;
/// use fdem_contact::discretised::{MeshView, MeshSearch};
///
/// let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.1, 0.1]];
/// let mesh = MeshView::new(&points, &[[0, 1, 2], [1, 3, 2], [4, 3, 3]], &[0, 0, 0])?;
/// let mut search = MeshSearch::new().with_threads(2)?;
/// let mut contacts = Vec::new();
/// search.contacts(&mesh, &mut contacts)?;
/// assert!(contacts.is_empty(), "all is one body");
///
/// search = search.with_self_contact(true);
/// search.contacts(&mesh, &mut contacts)?;
/// assert_eq!(contacts.len(), 1); // 0 and 1 share nodes, and so do 1 and 2
/// assert_eq!((contacts[0].i, contacts[0].j), (0, 2));
/// # Ok::<(), fdem_contact::discretised::DiscretisedError>(())
/// ```
#[derive(Debug)]
pub struct MeshSearch<const D: usize> {
    detector: Detector<f64, D>,
    self_contact: bool,
    min: Vec<[f64; D]>,
    max: Vec<[f64; D]>,
    couples: Vec<Couple>,
    pool: Pool,
}

/// Number of couples in one part of the work.
const PART: usize = 512;

impl<const D: usize> Default for MeshSearch<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const D: usize> MeshSearch<D> {
    /// A search on one thread for contacts of different bodies. It chooses the engine that searches the
    /// bounding boxes.
    pub fn new() -> Self {
        Self {
            detector: Detector::new(),
            self_contact: false,
            min: Vec::new(),
            max: Vec::new(),
            couples: Vec::new(),
            pool: Pool::default(),
        }
    }

    /// The same with this engine; `None` chooses one from the boxes.
    #[must_use]
    pub fn with_engine(mut self, engine: impl Into<Option<Engine>>) -> Self {
        self.detector = self.detector.with_engine(engine);
        self
    }

    /// The same on `threads` threads; 0 is one per processor.
    ///
    /// # Errors
    /// [`Error::NoThreads`].
    pub fn with_threads(mut self, threads: usize) -> Result<Self, DiscretisedError> {
        self.pool = Pool::new(threads)?;
        self.detector = self.detector.with_pool(self.pool.clone());
        Ok(self)
    }

    /// Sets whether elements of the same body form couples too, except those with a common node.
    #[must_use]
    pub fn with_self_contact(mut self, self_contact: bool) -> Self {
        self.self_contact = self_contact;
        self
    }

    /// Writes the contacts of elements into `contacts`, which is cleared first.
    ///
    /// # Shapes
    /// `m` contacts, `i < j`, each couple once, sorted by `i`, then `j`.
    ///
    /// # Errors
    /// [`DiscretisedError::Search`] for too many elements or no memory; `contacts` is then empty.
    pub fn contacts<const N: usize>(
        &mut self,
        mesh: &MeshView<'_, D, N>,
        contacts: &mut Vec<ElementContact<D>>,
    ) -> Result<(), DiscretisedError>
    where
        [[f64; D]; N]: Simplex<D>,
    {
        contacts.clear();
        self.clear_boxes(mesh.len())?;
        for element in 0..mesh.len() {
            let [min, max] = mesh.bounds(element);
            self.min.push(min);
            self.max.push(max);
        }
        let filter = if self.self_contact { None } else { Some(Filter::bodies(mesh.bodies)) };
        self.find_couples(filter)?;
        let self_contact = self.self_contact;
        self.in_parts(self.couples.chunks(PART), contacts, |couples, out| {
            let mut scratch = Vec::new();
            for &Couple { i, j } in couples {
                let [a, b] = [i, j].map(|k| k as usize);
                if self_contact && mesh.bodies[a] == mesh.bodies[b] && mesh.have_a_node_in_common(a, b) {
                    continue;
                }
                let (a, b) = (mesh.vertices(a), mesh.vertices(b));
                // The exact test first: computing the gap of elements that do not touch takes longer.
                if a.touch(&b) {
                    reserve_one(out)?;
                    out.push(ElementContact { i, j, contact: a.contact(&b, &mut scratch) });
                }
            }
            Ok(())
        })
    }

    /// Checks the contacts of `sample` random elements against all others, by the narrow phase alone.
    ///
    /// Returns the number of elements checked: `sample`, or all of them if there are fewer. The same `seed`
    /// picks the same elements.
    ///
    /// # Cost
    /// `sample` tests per element of the mesh.
    ///
    /// # Errors
    /// The first [`Mismatch`] found.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::Engine;
    /// use fdem_contact::discretised::{MeshView, MeshSearch, contacts};
    ///
    /// let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    /// let mesh = MeshView::new(&points, &[[0, 1, 2], [1, 2, 3]], &[0, 1])?;
    /// let found = contacts(&mesh)?;
    /// let search = MeshSearch::new();
    /// assert_eq!(search.verify(&mesh, &found, 10, 0), Ok(2));
    /// assert!(search.verify(&mesh, &[], 10, 0).is_err());
    /// # Ok::<(), fdem_contact::discretised::DiscretisedError>(())
    /// ```
    pub fn verify<const N: usize>(
        &self,
        mesh: &MeshView<'_, D, N>,
        contacts: &[ElementContact<D>],
        sample: usize,
        seed: u64,
    ) -> Result<usize, Mismatch>
    where
        [[f64; D]; N]: Simplex<D>,
    {
        let couples: Vec<Couple> =
            contacts.iter().map(|&ElementContact { i, j, .. }| Couple { i, j }).collect();
        verify_with(mesh.len(), &couples, sample, seed, |i, j| {
            let one = mesh.bodies[i] == mesh.bodies[j];
            if one && (!self.self_contact || mesh.have_a_node_in_common(i, j)) {
                return false;
            }
            mesh.vertices(i).touch(&mesh.vertices(j))
        })
    }

    fn clear_boxes(&mut self, elements: usize) -> Result<(), Error> {
        for corners in [&mut self.min, &mut self.max] {
            corners.clear();
            reserve(corners, elements)?;
        }
        Ok(())
    }

    /// The couples of the boxes, in ascending order.
    fn find_couples(&mut self, filter: Option<Filter<'_>>) -> Result<(), Error> {
        let mut boxes = Elements::boxes(&self.min, &self.max)?;
        if let Some(filter) = filter {
            boxes = boxes.with_filter(filter)?;
        }
        self.detector.couples(&boxes, &mut self.couples)?;
        self.couples.sort_unstable();
        Ok(())
    }

    /// Writes the result of `work` for each task to `all`, in the order of the tasks, on all threads.
    fn in_parts<I: Send, V: Clone + Send>(
        &self,
        tasks: impl ExactSizeIterator<Item = I>,
        all: &mut Vec<V>,
        work: impl Fn(I, &mut Vec<V>) -> Result<(), Error> + Sync + Send,
    ) -> Result<(), DiscretisedError> {
        let mut parts = Vec::new();
        resize(&mut parts, tasks.len(), Vec::new())?;
        self.pool.try_run(tasks.zip(&mut parts), |(task, out)| work(task, out))?;
        reserve(all, parts.iter().map(Vec::len).sum())?;
        for part in parts {
            all.extend(part);
        }
        Ok(())
    }
}

/// Makes room for one more entry.
fn reserve_one<V>(values: &mut Vec<V>) -> Result<(), Error> {
    let bytes = (values.len() + 1).saturating_mul(2 * size_of::<V>());
    values.try_reserve(1).map_err(|_| Error::OutOfMemory { bytes })
}
