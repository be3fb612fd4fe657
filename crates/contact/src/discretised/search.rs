//! The search for contacts of elements.

use crate::couple::Couple;
use crate::detector::Detector;
use crate::discretised::element::sealed::Sealed as _;
use crate::discretised::{DiscretisedError, ElementContact, MeshElement, MeshView};
use crate::elements::Elements;
use crate::engine::Engine;
use crate::error::Error;
use crate::filter::Filter;
use crate::memory::{reserve, resize};
use crate::pool::Pool;
use crate::search::Search;
use crate::verify::{Mismatch, verify_with};

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
    [[f64; D]; N]: MeshElement<D>,
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
    pub(super) detector: Detector<f64, D>,
    pub(super) self_contact: bool,
    pub(super) min: Vec<[f64; D]>,
    pub(super) max: Vec<[f64; D]>,
    pub(super) couples: Vec<Couple>,
    pub(super) pool: Pool,
}

/// Number of couples in one part of the work.
pub(super) const PART: usize = 512;

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
        [[f64; D]; N]: MeshElement<D>,
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
        [[f64; D]; N]: MeshElement<D>,
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

    pub(super) fn clear_boxes(&mut self, elements: usize) -> Result<(), Error> {
        for corners in [&mut self.min, &mut self.max] {
            corners.clear();
            reserve(corners, elements)?;
        }
        Ok(())
    }

    /// The couples of the boxes, in ascending order.
    pub(super) fn find_couples(&mut self, filter: Option<Filter<'_>>) -> Result<(), Error> {
        let mut boxes = Elements::boxes(&self.min, &self.max)?;
        if let Some(filter) = filter {
            boxes = boxes.with_filter(filter)?;
        }
        self.detector.couples(&boxes, &mut self.couples)?;
        self.couples.sort_unstable();
        Ok(())
    }

    /// Writes the result of `work` for each task to `all`, in the order of the tasks, on all threads.
    pub(super) fn in_parts<I: Send, V: Clone + Send>(
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
pub(super) fn reserve_one<V>(values: &mut Vec<V>) -> Result<(), Error> {
    let bytes = (values.len() + 1).saturating_mul(2 * size_of::<V>());
    values.try_reserve(1).map_err(|_| Error::OutOfMemory { bytes })
}
