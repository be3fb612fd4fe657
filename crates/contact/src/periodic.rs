//! Search in a box that repeats: wrap the elements, add the images that may touch them, search all, and name the shifts.

pub(crate) mod cell;
mod images;

use crate::couple::Couple;
use crate::elements::{Elements, Shape};
use crate::engine::{Detector, Engine};
use crate::error::Error;
use crate::periodic::cell::PeriodicBox;
use crate::periodic::images::Images;
use crate::real::Real;
use crate::search::{Search, make_room};

/// Two elements of a periodic box that touch: `i`, and `j` displaced by `shift` edges.
///
/// Element `j`, where the caller has it, plus the sum of `shift[a]` times edge `a`, touches element `i` where the caller has it; neither needs to
/// lie in the box. Seen from `j` the shift is `-shift`. Each contact has one form: `i < j` with any shift, or `i == j` with a shift whose
/// first number other than 0 is positive: an element that touches its own image. Ordered by `i`, `j`, shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C)]
pub struct PeriodicCouple<const D: usize> {
    /// The smaller number.
    pub i: u32,
    /// The larger number, or the same.
    pub j: u32,
    /// Edges by which `j` is displaced; 0 along edges that are not periodic.
    pub shift: [i32; D],
}

/// The bound on the number of images unless another is set: some 6 GB in 3D and `f64`.
pub const DEFAULT_MAX_IMAGES: usize = 1 << 26;

/// No shift of an image is larger, so that shifts fit `i32` together with twice the periods of an element.
const MOST_IMAGES: usize = 1 << 30;

/// Every contact of spheres or points in a [`PeriodicBox`], each once, with its shift; all images that touch, not only the nearest.
///
/// Elements outside the box are wrapped into it. Every image of a wrapped element that may touch a wrapped element is made, as many as
/// the reach of the elements and the heights of the box ask for, and an ordinary search runs over elements and images. So
/// the box may be sheared by any amount, and smaller than the elements. Nothing rests on the image nearest to an element, which is one
/// contact of several in a small box, and the wrong one in a sheared box.
///
/// # When do two elements touch?
/// The comparison is that of [`Elements`], closed, in the type `T`, between two rounded points:
/// - `w_i`, where [`PeriodicBox::wrap`] puts element `i`: a displacement by `-n_i`, rounded once per element, or `x_i` itself if `n_i` is 0.
/// - `p`, [`PeriodicBox::displaced`] of `w_j` by `s`: rounded once per image, or `w_j` itself if `s` is 0.
///
/// The couple is `(i, j, shift)` with `shift = s + n_i - n_j`, `i < j`, or `i == j` and the first number of `s` other than 0 positive. So it
/// is always the element of larger number whose image is compared; the image of the other one may round otherwise and decides nothing. Where all
/// sums are exact, the result does not depend on the periods in which the caller has the elements.
///
/// With a [`Filter`](crate::Filter) an image sees what its element sees. An element and its image are of one body, and of one group: whether they see
/// each other is what the filter says of the element and itself, [`Filter::admits(i, i)`](crate::Filter::admits).
///
/// # Order
/// That of the engine over the wrapped elements followed by the images, by element, then by shift. A function of the input alone.
///
/// # Cost
/// The search over `n` elements and `m` images. For an edge of height `h` and a reach `r` (largest diameter plus tolerance) there are about `2 r / h` images per
/// element: few in a large box. A tilt lowers heights: of the bases of a lattice take one with short edges.
/// Memory per element and image: `D` coordinates, `D` integers of 4 bytes, the radius if there is one for each, the numbers of a filter, 4 bytes per image, and the engine. Boxes not wider than
/// two reaches are searched by testing elements against elements and images, `n (n + m)` tests at most.
///
/// # Source
/// The ghost images of M.P. Allen, D.J. Tildesley, "Computer Simulation of Liquids", Oxford 1987, section 1.5, without the minimum image.
///
/// # Example
/// ```
/// use fdem_contact::{Elements, Engine, PeriodicBox, PeriodicCouple, PeriodicSearch};
///
/// let discs = [[0.25, 2.0], [3.75, 2.0], [2.0, 9.0]]; // the last one is two periods up
/// let elements = Elements::spheres(&discs, 0.5)?;
/// let cell = PeriodicBox::orthogonal([0.0, 0.0], [4.0, 4.0], [true, true])?;
///
/// let mut couples = Vec::new();
/// PeriodicSearch::new(Engine::Auto).couples(&elements, &cell, &mut couples)?;
/// // Disc 1, one edge to the left, is at -0.25 and touches disc 0.
/// assert_eq!(couples, [PeriodicCouple { i: 0, j: 1, shift: [-1, 0] }]);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "minimum image")]
#[doc(alias = "ghost")]
#[derive(Clone, Debug)]
pub struct PeriodicSearch<T, const D: usize> {
    engine: Engine,
    detector: Detector<T, D>,
    images: Images<T, D>,
    refuse_outside: bool,
    max_images: usize,
}

impl<T: Real, const D: usize> PeriodicSearch<T, D> {
    /// A search that holds no memory yet, with this engine over elements and images.
    pub fn new(engine: Engine) -> Self {
        Self {
            engine,
            detector: Detector::new(engine),
            images: Images::new(),
            refuse_outside: false,
            max_images: DEFAULT_MAX_IMAGES,
        }
    }

    /// The same, but an element outside the box along a periodic edge is refused, with [`Error::OutsideBox`], and not wrapped.
    ///
    /// The faces belong to the box, and so do points outside by no more than rounding.
    #[must_use]
    pub fn refuse_outside(mut self) -> Self {
        self.refuse_outside = true;
        self
    }

    /// The same with another bound on the number of images, at most `2^30`; [`DEFAULT_MAX_IMAGES`] otherwise.
    #[must_use]
    pub fn with_max_images(mut self, max_images: usize) -> Self {
        self.max_images = max_images.min(MOST_IMAGES);
        self
    }

    /// Number of images that the last search made.
    pub fn images(&self) -> usize {
        self.images.owners.len()
    }

    /// Calls `visit` with every couple that touches; nothing is stored but elements and images.
    ///
    /// # Errors
    /// [`Error::TooFarFromBox`], [`Error::OutsideBox`], [`Error::UnresolvedBox`], [`Error::TooManyImages`],
    /// [`Error::BoxesNotPeriodic`], [`Error::OutOfMemory`], and those of [`Search::for_each`]. `visit` has not been called then.
    pub fn for_each(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        mut visit: impl FnMut(PeriodicCouple<D>),
    ) -> Result<(), Error> {
        self.images.build(elements, cell, self.refuse_outside, self.max_images)?;
        let images = &self.images;
        let n = images.periods.len();
        let of_caller = |error| images.name_owner(error);
        let all = match elements.shape {
            Shape::Equal(equal) => Elements::spheres(&images.centres, equal.radius()),
            Shape::Spheres(_) => Elements::spheres_with_radii(&images.centres, &images.radii),
            Shape::Boxes(_) => Err(Error::BoxesNotPeriodic),
        };
        let mut all = all.and_then(|all| all.with_tolerance(elements.tolerance())).map_err(of_caller)?;
        if let Some(filter) = elements.filter() {
            all = all.with_filter(images.labels.filter(filter))?;
        }

        if self.engine == Engine::Direct || (self.engine == Engine::Auto && images.compact) {
            let mut image = 0;
            for i in 0..n {
                while images.owners.get(image).is_some_and(|&owner| (owner as usize) < i) {
                    image += 1;
                }
                for other in (i + 1..n).chain(n + image..all.len()) {
                    if let Some(couple) = images.named(i, other)
                        && all.touch(i, other)
                    {
                        visit(couple);
                    }
                }
            }
            return Ok(());
        }
        let visit = |couple: Couple| {
            if let Some(couple) = images.named(couple.i as usize, couple.j as usize) {
                visit(couple);
            }
        };
        self.detector.for_each(&all, visit).map_err(of_caller)
    }

    /// Writes the couples into `couples`, cleared first; the caller's memory is reused.
    ///
    /// # Errors
    /// As [`PeriodicSearch::for_each`]; [`Error::OutOfMemory`] also if the couples themselves do not fit. `couples` is empty then.
    pub fn couples(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        couples: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<(), Error> {
        couples.clear();
        let mut room = Ok(());
        self.for_each(elements, cell, |couple| {
            if couples.len() == couples.capacity() && room.is_ok() {
                room = make_room(couples);
            }
            if room.is_ok() {
                couples.push(couple);
            }
        })?;
        room.inspect_err(|_| couples.clear())
    }

    /// The number of couples; nothing is stored but elements and images.
    ///
    /// # Errors
    /// As [`PeriodicSearch::for_each`].
    pub fn count(&mut self, elements: &Elements<'_, T, D>, cell: &PeriodicBox<T, D>) -> Result<u64, Error> {
        let mut count = 0;
        self.for_each(elements, cell, |_| count += 1)?;
        Ok(count)
    }
}

impl<T: Real, const D: usize> Images<T, D> {
    /// The couple of two of the elements and images, `a < b`, with the shift between the caller's positions.
    ///
    /// `None` for the couples that are met elsewhere: of two images, of an element and an image of one with a smaller number, and of an element
    /// and the lower of two opposite images of itself. With `x = w + n . v` for either position, `x_j + shift . v` touches `x_i` if
    /// `w_j + s . v` touches `w_i` and `shift = s + n_i - n_j`. (Nothing overflows: `|s| <= 2^30`, `|n| <= 2^28`.)
    #[inline]
    fn named(&self, a: usize, b: usize) -> Option<PeriodicCouple<D>> {
        let n = self.periods.len();
        let (owner, shift) = match b.checked_sub(n) {
            None => (b, [0; D]),
            Some(_) if a >= n => return None,
            Some(image) => {
                let (owner, shift) = (self.owners[image] as usize, self.shifts[image]);
                if owner < a || (owner == a && shift < [0; D]) {
                    return None;
                }
                (owner, shift)
            }
        };
        let (of_i, of_j) = (self.periods_of(a), self.periods_of(owner));
        let shift = std::array::from_fn(|edge| shift[edge] + of_i[edge] - of_j[edge]);
        Some(PeriodicCouple { i: a as u32, j: owner as u32, shift })
    }

    /// An error about an image is an error about its owner.
    fn name_owner(&self, mut error: Error) -> Error {
        let index = match &mut error {
            Error::NonFiniteCoordinate { index, .. }
            | Error::CoordinateTooLarge { index, .. }
            | Error::DomainTooWide { stretched_by: Some((index, _)), .. } => Some(index),
            _ => None,
        };
        if let Some(index) = index
            && let Some(image) = index.checked_sub(self.periods.len())
        {
            *index = self.owners[image] as usize;
        }
        error
    }
}
