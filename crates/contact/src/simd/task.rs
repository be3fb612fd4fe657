//! Input and output of a kernel: a stretch of a row to compare, the couples that were found, and the proof
//! that the processor has the instructions.

use crate::couple::Couple;
use crate::error::Error;
use crate::filter::Arranged;
use crate::simd::level::Simd;

/// A level that this processor has: the proof that its instructions may be used.
#[derive(Clone, Copy, Debug)]
pub struct Available(Simd);

impl Available {
    /// # Errors
    /// [`Error::SimdUnavailable`] if this processor lacks the level.
    pub(crate) fn new(simd: Simd) -> Result<Self, Error> {
        if simd.is_available() { Ok(Self(simd)) } else { Err(Error::SimdUnavailable { simd }) }
    }

    /// The fastest level that this processor has.
    pub(crate) fn best() -> Self {
        Self(Simd::best())
    }

    pub(crate) fn level(self) -> Simd {
        self.0
    }
}

/// The kernels of one float type; the sealed half of [`Real`](crate::Real).
pub trait Kernels: Copy {
    /// Searches one stretch of a row in `D` dimensions.
    ///
    /// # Panics
    /// If rows of `task` are not inside its arrays.
    #[doc(hidden)]
    fn search<const D: usize>(level: Available, task: &Task<'_, Self>, out: &mut Output<'_>);
}

/// The kinds of shapes: spheres of one radius, spheres with radii, boxes.
pub(super) const EQUAL: u8 = 0;
pub(super) const RADII: u8 = 1;
pub(super) const BOXES: u8 = 2;

/// The place of a row in the arrays of the layout.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// First element.
    pub(crate) start: usize,
    /// Number of elements.
    pub(crate) len: usize,
}

/// A neighbour row and where the search in it starts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Neighbour<T> {
    pub(crate) row: Span,
    /// Elements before this one are too far to the left of all elements still to come.
    pub(crate) low: usize,
    pub(crate) looks: Looks,
    /// The largest distance along this row between touching elements; for boxes, the largest distance by
    /// which one of two touching boxes begins earlier.
    pub(crate) reach: T,
}

/// Where along a row the search for partners of an element at `x` starts; for spheres it is always `Back`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Looks {
    /// The reach before `x`.
    Back,
    /// At `x`. The elements of the other row search from beyond their own place: of two boxes, the one that
    /// begins first looks for the other.
    Ahead,
    /// Just beyond `x`.
    Beyond,
}

/// The arrays of a layout.
///
/// # Shapes
/// Element `k` of a row has the coordinate `coordinates[D * start + axis * len + k]`. All arrays continue for
/// at least one vector after the last element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrays<'a, T> {
    pub(crate) coordinates: &'a [T],
    /// The upper ends of boxes, with the tolerance added, in the order of `coordinates`, which are the lower
    /// ends; empty for spheres.
    pub(crate) far: &'a [T],
    /// Empty for boxes and elements of one radius.
    pub(crate) radii: &'a [T],
    pub(crate) ids: &'a [u32],
    /// Which elements see each other, by their place in the arrays; as long as `ids`.
    pub(crate) filter: Option<Arranged<'a>>,
}

/// A stretch of a row, to be compared with the rest of its row and with the neighbour rows.
///
/// The neighbour rows may belong to another set of elements. Then the element is not compared with its own
/// row. Unless both sets are numbered together, couples are not ordered by number: `i` belongs to the
/// stretch, `j` to the other set.
pub struct Task<'a, T> {
    /// The arrays that hold the row.
    pub(crate) own: Arrays<'a, T>,
    /// The arrays that hold the neighbour rows: the same ones, unless there are two sets. Both have radii or
    /// neither, and both have filters of the same kind and with the same matrix or neither.
    pub(crate) other: Arrays<'a, T>,
    pub(crate) two_sets: bool,
    pub(crate) one_numbering: bool,
    pub(crate) row: Span,
    /// The stretch of the row: couples whose first element lies in it are reported.
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) neighbours: &'a [Neighbour<T>],
    /// The axis along which rows are sorted.
    pub(crate) long: usize,
    /// The largest distance along an axis between touching elements.
    pub(crate) reach: T,
    /// The squared contact distance of elements of one radius.
    pub(crate) reach_squared: T,
    pub(crate) tolerance: T,
    /// The largest distance of elements of the row and the neighbour rows along any axis but the long one;
    /// infinite if unknown.
    pub(crate) spread: f64,
}

impl<T> Task<'_, T> {
    #[inline(always)]
    pub(super) fn shape(&self) -> u8 {
        match (self.own.far.is_empty(), self.own.radii.is_empty()) {
            (false, _) => BOXES,
            (true, false) => RADII,
            (true, true) => EQUAL,
        }
    }
}

/// Where the couples go.
pub struct Output<'a> {
    /// Couples found so far and not yet taken.
    pub(crate) couples: &'a mut Vec<Couple>,
    /// Number of couples found in total.
    pub(crate) count: u64,
    /// Whether couples are only counted.
    pub(crate) count_only: bool,
    /// Makes room for at least [`ROOM`] couples, by growing the vector or by taking the couples found.
    pub(crate) make_room: &'a mut dyn FnMut(&mut Vec<Couple>),
    pub(super) patience: Patience,
}

impl<'a> Output<'a> {
    pub(crate) fn new(couples: &'a mut Vec<Couple>, make_room: &'a mut dyn FnMut(&mut Vec<Couple>)) -> Self {
        Self { couples, count: 0, count_only: false, make_room, patience: Patience::default() }
    }
}

/// Largest number of couples that a vector stores at once: one per lane.
pub(crate) const ROOM: usize = 16;

/// Skips clusters for a while where they do not help: on a lattice all contacts are in doubt.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patience {
    /// Number of segments still to be compared without clusters.
    pub(super) without: u32,
    /// Number of segments to skip after the next failure.
    pub(super) next: u32,
}

impl Patience {
    pub(super) fn lost(&mut self) {
        self.next = (2 * self.next).clamp(1, 64);
        self.without = self.next;
    }
}
