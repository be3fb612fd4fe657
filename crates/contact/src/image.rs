//! Contacts in labelled images: bodies that are sets of grid squares (pixels, voxels).
//!
//! Every number in the array is a body, except one, the background. Two bodies are in contact if they have
//! grid squares that are neighbours: these share a face, an edge or a vertex ([`Neighbourhood`]).
//!
//! ```
//! use fdem_contact::image::{Neighbourhood, Spacing, contacts};
//!
//! let labels: [u16; 12] = [
//!     1, 1, 2, 2, //
//!     1, 1, 2, 0, //
//!     3, 0, 2, 2,
//! ];
//! let found = contacts(&labels, [3, 4], Neighbourhood::Face)?;
//! let pairs: Vec<_> = found.iter().map(|contact| contact.labels()).collect();
//! assert_eq!(pairs, [[1, 2], [1, 3]]);
//! assert_eq!(found[0].faces(), 2);
//! assert_eq!(found[0].centroid(&Spacing::UNIT), [0.5, 1.5]); // rows, columns
//! assert_eq!(found[0].normal(&Spacing::UNIT), [0.0, 1.0]);
//! # Ok::<(), fdem_contact::Error>(())
//! ```
//!
//! [`ImageContacts`] takes an image slab by slab; it stores one plane and the contacts.
//!
//! # Counting
//! Two grid squares with different labels, neither of which is the background, form a *pair*. A pair is
//! counted once, by the kind of its common boundary: a *face* if the squares are neighbours along one axis;
//! an *edge* if they differ by one along exactly two of three axes; a *vertex* if they differ by one along
//! all axes. A pair that shares an edge counts regardless of its surroundings: at a plane interface every
//! voxel has four neighbours across edges in addition to the one across its face.
//!
//! # Coordinates
//! Coordinates are in the order of the axes of the array, as in NumPy: the slowest first. The origin is the
//! centre of the first grid square, so the centre of a grid square is its index times the [`Spacing`].

mod contact;
mod label;
mod row;
mod table;

use crate::error::Error;
use crate::memory::reserve;
use crate::pool::Pool;

pub(crate) use contact::unit;
pub use contact::{ImageContact, Spacing};
pub use label::{Label, Neighbourhood};
use row::{Direction, RowScan};
use table::ContactTable;

/// All contacts in an image in memory, with background 0, on one thread.
///
/// # Shapes
/// `labels`: the array in C order; the last axis of `shape` is the fastest. Result: `m` contacts, the smaller
/// label first, each pair of labels once, sorted by the first, then the second label.
///
/// # Cost
/// See [`ImageContacts`].
///
/// # Errors
/// The errors of [`ImageContacts::new`], [`ImageContacts::add`] and [`ImageContacts::finish`].
///
/// # Example
/// ```
/// use fdem_contact::image::{Neighbourhood, contacts};
///
/// let diagonal = [1, 0, 0, 2];
/// assert_eq!(contacts(&diagonal, [2, 2], Neighbourhood::Face)?.len(), 0);
/// assert_eq!(contacts(&diagonal, [2, 2], Neighbourhood::Vertex)?[0].vertices(), 1);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
pub fn contacts<L: Label, const D: usize>(
    labels: &[L],
    shape: [usize; D],
    neighbourhood: Neighbourhood,
) -> Result<Vec<ImageContact<L, D>>, Error> {
    let mut image = ImageContacts::new(shape, neighbourhood)?;
    image.add(labels)?;
    image.finish()
}

/// Finds the contacts in an image that is given slab by slab.
///
/// A slab is one or more planes of the slowest axis; in 2D a plane is a row of pixels. Neighbouring rows are
/// compared a vector at a time. Labels are examined only where the rows differ, in runs of equal pairs. The
/// sums are integers, so the result depends neither on the slabs nor on the threads.
///
/// # Shapes
/// `D` is 2 or 3.
///
/// # Cost
/// Time: a pass over the image for each of the 2, 4, 3, 9 or 13 directions to neighbours, some nanoseconds
/// for each run of faces, and the sorting of the contacts. Memory: one plane, 80 bytes per contact (270 with
/// edges or vertices) and 10 bytes per label. Each thread holds its own contacts and labels.
///
/// # Example
/// ```
/// use fdem_contact::image::{ImageContacts, Neighbourhood};
///
/// let mut image = ImageContacts::<u8, 3>::new([3, 1, 2], Neighbourhood::Face)?;
/// for plane in [[1, 1], [1, 2], [2, 2]] {
///     image.add(&plane)?;
/// }
/// assert_eq!(image.labels(), 2);
/// let contacts = image.finish()?;
/// assert_eq!(contacts.len(), 1);
/// assert_eq!(contacts[0].faces_along(), [2, 0, 1]);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ImageContacts<L, const D: usize> {
    shape: [usize; D],
    /// Number of grid squares in a plane.
    plane: usize,
    directions: Vec<Direction<D>>,
    background: Option<L>,
    pool: Pool,
    /// Number of planes added so far.
    planes: usize,
    /// The last of these planes.
    previous: Vec<L>,
    /// The error that ended the reading of the image: part of a slab may be missing from the sums.
    failed: Option<Error>,
    /// One part for each thread.
    parts: Vec<ThreadPart<L, D>>,
}

/// The results of one thread, and its working memory.
#[derive(Clone, Debug)]
struct ThreadPart<L, const D: usize> {
    table: ContactTable<L, D>,
    scan: RowScan,
}

impl<L: Label, const D: usize> ImageContacts<L, D> {
    /// Starts an image of this shape, with background 0.
    ///
    /// # Shapes
    /// `shape`: number of grid squares along each axis, the slowest first.
    ///
    /// # Errors
    /// [`Error::NoEdgesIn2D`]; [`Error::ImageTooLarge`] for more than about 30,000³ grid squares.
    pub fn new(shape: [usize; D], neighbourhood: Neighbourhood) -> Result<Self, Error> {
        const { assert!(D == 2 || D == 3, "images have two or three axes") };
        if D == 2 && neighbourhood == Neighbourhood::Edge {
            return Err(Error::NoEdgesIn2D);
        }
        let product =
            |lengths: &[usize]| lengths.iter().try_fold(1, |n: usize, &length| n.checked_mul(length));
        let longest = shape.iter().copied().max().unwrap_or(0) as u128;
        // The number of terms in a sum of a contact is at most the number of neighbours of a grid square, and
        // none is larger than doubled indices.
        let bound = |n: usize| (n as u128).checked_mul(longest)?.checked_mul(2 * row::DIRECTIONS as u128);
        let in_range = |n| bound(n).is_some_and(|bound| bound <= i64::MAX as u128);
        let (Some(plane), true) = (product(&shape[1..]), product(&shape).is_some_and(in_range)) else {
            return Err(Error::ImageTooLarge { shape: shape.to_vec() });
        };
        Ok(Self {
            shape,
            plane,
            directions: Direction::all(neighbourhood).collect(),
            background: Some(L::default()),
            pool: Pool::default(),
            planes: 0,
            previous: Vec::new(),
            failed: None,
            parts: Vec::new(),
        })
    }

    /// The same with another background, or with none; then every number is a body.
    #[must_use]
    pub fn with_background(mut self, background: Option<L>) -> Self {
        self.background = background;
        self
    }

    /// The same on several threads; 0 is one per processor. They share the rows of each slab, so a slab
    /// should have many rows.
    ///
    /// # Errors
    /// [`Error::NoThreads`].
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?;
        Ok(self)
    }

    /// Adds the next planes.
    ///
    /// # Shapes
    /// `slab`: any number of whole planes, in C order.
    ///
    /// # Errors
    /// [`Error::PartialPlane`], [`Error::TooManyPlanes`]; nothing has been added then.
    /// [`Error::OutOfMemory`], [`Error::TooManyContacts`]; after these the image cannot be continued, and
    /// every further call returns the same error.
    pub fn add(&mut self, slab: &[L]) -> Result<(), Error> {
        if let Some(error) = &self.failed {
            return Err(error.clone());
        }
        if slab.is_empty() {
            return Ok(());
        }
        if self.plane == 0 || !slab.len().is_multiple_of(self.plane) {
            return Err(Error::PartialPlane { squares: slab.len(), plane: self.plane });
        }
        let planes = slab.len() / self.plane;
        if planes > self.shape[0] - self.planes {
            return Err(Error::TooManyPlanes {
                found: self.planes.saturating_add(planes),
                expected: self.shape[0],
            });
        }
        let taken = self.take(slab, planes);
        self.failed = taken.clone().err();
        taken
    }

    /// Compares the planes of a slab; threads share the rows.
    fn take(&mut self, slab: &[L], planes: usize) -> Result<(), Error> {
        let [height, width] = if D == 3 { [self.shape[1], self.shape[2]] } else { [1, self.shape[1]] };
        let rows = SlabRows {
            slab,
            previous: &self.previous,
            first: self.planes,
            height,
            width,
            background: self.background,
        };
        let threads = self.pool.threads();
        while self.parts.len() < threads {
            self.parts.push(ThreadPart { table: ContactTable::new(), scan: RowScan::default() });
        }
        let count = planes * height;
        let stretch = count.div_ceil(threads);
        let mut done = vec![Ok(()); threads];
        let tasks = self.parts.iter_mut().zip(&mut done).enumerate();
        self.pool.run(tasks, |(at, (part, done))| {
            let lines = (at * stretch).min(count)..((at + 1) * stretch).min(count);
            *done = part.take(&rows, lines, &self.directions);
        });
        done.into_iter().collect::<Result<(), _>>()?;

        let last = &slab[slab.len() - self.plane..];
        self.previous.clear();
        reserve(&mut self.previous, last.len())?;
        self.previous.extend_from_slice(last);
        self.planes += planes;
        Ok(())
    }

    /// Number of different labels so far, without the background.
    ///
    /// # Cost
    /// With several threads, a pass over the labels of each thread.
    pub fn labels(&self) -> usize {
        match &self.parts[..] {
            [] => 0,
            [part] => part.table.labels().len(),
            parts => {
                let mut labels: Vec<L> = parts.iter().flat_map(|part| part.table.labels()).copied().collect();
                labels.sort_unstable();
                labels.dedup();
                labels.len()
            }
        }
    }

    /// The contacts, once all planes have been added.
    ///
    /// # Shapes
    /// See [`contacts`].
    ///
    /// # Errors
    /// [`Error::MissingPlanes`]; [`Error::OutOfMemory`], [`Error::TooManyContacts`], also if
    /// [`ImageContacts::add`] returned one of these.
    pub fn finish(self) -> Result<Vec<ImageContact<L, D>>, Error> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        if self.plane > 0 && self.planes < self.shape[0] {
            return Err(Error::MissingPlanes { found: self.planes, expected: self.shape[0] });
        }
        let mut tables = self.parts.into_iter().map(|part| part.table);
        let Some(mut all) = tables.next() else { return Ok(Vec::new()) };
        for table in tables {
            all.merge(&table)?;
        }
        Ok(all.into_contacts())
    }
}

/// The rows of a slab and of the plane before it.
struct SlabRows<'a, L> {
    slab: &'a [L],
    /// The plane before the slab, if `first` is not 0.
    previous: &'a [L],
    /// Number of the first plane of the slab.
    first: usize,
    /// Number of rows in a plane.
    height: usize,
    width: usize,
    background: Option<L>,
}

impl<'a, L> SlabRows<'a, L> {
    /// Row `y` of plane `z`, counted from the first plane of the slab; plane -1 is the one before it.
    fn row(&self, z: isize, y: isize) -> Option<&'a [L]> {
        let y = usize::try_from(y).ok().filter(|&y| y < self.height)?;
        match usize::try_from(z) {
            Ok(z) => Some(&self.slab[(z * self.height + y) * self.width..][..self.width]),
            Err(_) if self.first > 0 => Some(&self.previous[y * self.width..][..self.width]),
            Err(_) => None,
        }
    }
}

impl<L: Label, const D: usize> ThreadPart<L, D> {
    /// Compares the rows `lines` of the slab, counted from its first row, with themselves and with the rows
    /// before them.
    fn take(
        &mut self,
        rows: &SlabRows<'_, L>,
        lines: std::ops::Range<usize>,
        directions: &[Direction<D>],
    ) -> Result<(), Error> {
        let Self { table, scan } = self;
        scan.fit(rows.width)?;
        for line in lines {
            // In 2D a plane consists of one row.
            let (z, y) = ((line / rows.height).cast_signed(), (line % rows.height).cast_signed());
            let Some(row) = rows.row(z, y) else { continue };
            let before = [rows.row(z, y - 1), rows.row(z - 1, y)];
            scan.new_labels(row, before, rows.background, |label| table.note(label))?;
            let plane = (rows.first as u64) + z as u64;
            let at = if D == 3 { [plane, y as u64] } else { [plane, 0] };
            for direction in directions {
                let [dz, dy, dx] = match direction.step[..] {
                    [dz, dy, dx] => [dz, dy, dx],
                    [dy, dx] => [dy, 0, dx],
                    _ => continue,
                };
                let Some(other) = rows.row(z - isize::from(dz), y - isize::from(dy)) else { continue };
                scan.pairs(other, row, dx, rows.background, |run| table.add(&run, &at, direction))?;
            }
        }
        Ok(())
    }
}
