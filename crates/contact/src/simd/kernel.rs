//! The search over one row, written once for all vector instructions.

use std::mem::MaybeUninit;
use std::ops::Range;

use crate::couple::Couple;
use crate::filter::Filter;
use crate::real::Real;
use crate::simd::cluster::Patience;
use crate::simd::labels::{Label, Labels, NO_LABEL, NO_LABELS};

/// One row, as the arrays of the layout have it.
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
    /// No element touches one of this row that is farther away along it; of boxes that touch, none begins so much earlier.
    pub(crate) reach: T,
}

/// From where on along a row elements are looked for, seen from one at `x`; spheres look back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Looks {
    /// From the reach before `x` on.
    Back,
    /// From `x` on, and elements of that row look at this one from beyond their own: of two boxes the one that begins first looks for the other.
    Ahead,
    /// From beyond `x` on.
    Beyond,
}

/// The arrays of a layout.
///
/// # Shapes
/// Element `k` of a row has the coordinate `coordinates[D * start + axis * len + k]`. All arrays go on for at least one vector after
/// the last element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrays<'a, T> {
    pub(crate) coordinates: &'a [T],
    /// The upper ends of boxes, with the tolerance added, in the order of `coordinates`, which are the lower ends; empty for spheres.
    pub(crate) far: &'a [T],
    /// Empty for boxes and elements of one radius.
    pub(crate) radii: &'a [T],
    pub(crate) ids: &'a [u32],
    /// Which elements see each other, by their place in the arrays; as long as `ids`. All groups are ones of the matrix, also behind the last element.
    pub(crate) filter: Option<Filter<'a>>,
}

/// A stretch of a row, to be compared with the rest of its row and with the neighbour rows.
///
/// The neighbour rows may belong to another set of elements. Then the rest of the own row is left out, and unless both sets are numbered together couples are not
/// ordered by number: `i` is of the stretch, `j` of the other set.
pub struct Task<'a, T> {
    /// Where the row is.
    pub(crate) own: Arrays<'a, T>,
    /// Where the neighbour rows are: the same arrays, unless there are two sets. Either both have radii or none, and either both
    /// have filters of one kind, with one matrix, or none.
    pub(crate) other: Arrays<'a, T>,
    pub(crate) two_sets: bool,
    pub(crate) one_numbering: bool,
    pub(crate) row: Span,
    /// The stretch of the row whose couples are wanted, as first elements of couples.
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) neighbours: &'a [Neighbour<T>],
    /// The axis along which rows are sorted.
    pub(crate) long: usize,
    /// No two elements touch that are farther apart along an axis.
    pub(crate) reach: T,
    /// Elements of one radius: the squared contact distance.
    pub(crate) reach_squared: T,
    pub(crate) tolerance: T,
    /// Axes other than the long one: no two elements of the row and the neighbour rows are farther apart along one of them; infinite if that is not known.
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
    /// Found so far and not yet taken.
    pub(crate) couples: &'a mut Vec<Couple>,
    /// Couples in total.
    pub(crate) count: u64,
    /// Count only.
    pub(crate) count_only: bool,
    /// Makes room for at least [`ROOM`] couples: by growing, or by taking those found.
    pub(crate) make_room: &'a mut dyn FnMut(&mut Vec<Couple>),
    pub(super) patience: Patience,
}

impl<'a> Output<'a> {
    pub(crate) fn new(couples: &'a mut Vec<Couple>, make_room: &'a mut dyn FnMut(&mut Vec<Couple>)) -> Self {
        Self { couples, count: 0, count_only: false, make_room, patience: Patience::default() }
    }
}

/// A vector stores at most as many couples as it has lanes.
pub(crate) const ROOM: usize = 16;

/// The operations of a set of vector instructions on one float type.
///
/// # Safety
/// All need the instructions; those that load and store need what they say.
pub(crate) trait Vector<T>: Copy {
    const LANES: usize;

    unsafe fn splat(x: T) -> Self;

    /// `LANES` numbers from `from` on, which must be readable.
    unsafe fn load(from: *const T) -> Self;

    unsafe fn add(self, other: Self) -> Self;

    unsafe fn sub(self, other: Self) -> Self;

    unsafe fn mul(self, other: Self) -> Self;

    /// Writes `LANES` numbers to `to`, each the nearest of 32 bits.
    unsafe fn store_short(self, to: *mut f32);

    /// A bit for each lane, the first lane lowest: `self <= other`.
    unsafe fn at_most(self, other: Self) -> u32;

    /// A bit for each lane, the first lane lowest: `self < other`.
    unsafe fn below(self, other: Self) -> u32;

    /// A bit for each lane, the first lane lowest: whether the number there is `number`. `LANES` of them are readable from `from` on.
    unsafe fn equal(number: u32, from: *const u32) -> u32;

    /// The same: whether the number there and `bits` have a bit in common.
    unsafe fn overlap(bits: u32, from: *const u32) -> u32;

    /// The same: whether bit `g` of `row`, words of 32, is set, where `g` is the number there. `row` has a word for each of the `LANES` numbers.
    unsafe fn set(row: *const u32, from: *const u32) -> u32;

    /// Stores the couples of `id` with those of the `LANES` readable `ids` whose bit in `hits` is set, in order: smaller number first,
    /// or with `TWO_SETS` that of `id`. `to` must be writable for `LANES` couples.
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple);
}

/// A vector whose results need not be the same everywhere.
///
/// # Safety
/// As [`Vector`].
pub(super) trait Estimate: Vector<f32> {
    /// `self * other + sum`, rounded once or twice.
    unsafe fn mul_add(self, other: Self, sum: Self) -> Self;
}

/// The lanes before `count`: up to 31, which is more than any vector has.
#[inline(always)]
fn first_lanes(count: usize) -> u32 {
    (1 << count.min(31)) - 1
}

/// The place for the next couples, in registers.
#[derive(Clone, Copy)]
pub(super) struct Writer {
    to: *mut Couple,
    /// From here on there is no room for a vector of couples.
    full: *mut Couple,
    /// Found and not written.
    count: u64,
}

impl Writer {
    #[inline(always)]
    pub(super) fn new(out: &mut Output<'_>) -> Self {
        let (len, capacity) = (out.couples.len(), out.couples.capacity());
        let start = out.couples.as_mut_ptr();
        // Wrapping, because without any room `full` would lie before `start`; it is only compared.
        let full = start.wrapping_add(if capacity - len < ROOM { len } else { capacity - ROOM + 1 });
        Self { to: start.wrapping_add(len), full, count: 0 }
    }

    /// Hands the couples over.
    ///
    /// # Safety
    /// All couples before `to` have been written, to the vector that the writer was made from.
    #[inline(always)]
    pub(super) unsafe fn close(self, out: &mut Output<'_>) {
        // SAFETY: `to` points into the vector, behind what was written.
        unsafe {
            let len = self.to.offset_from_unsigned(out.couples.as_ptr());
            out.count += self.count + (len - out.couples.len()) as u64;
            out.couples.set_len(len);
        }
    }

    /// Writes or counts the couples of `id` with those of `ids` whose bit in `hits` is set.
    ///
    /// # Safety
    /// That of [`Vector::store_couples`], and as [`Writer::close`].
    #[inline(always)]
    pub(super) unsafe fn take<T, V: Vector<T>, const TWO_SETS: bool, const COUNT: bool>(
        &mut self,
        id: u32,
        ids: *const u32,
        hits: u32,
        out: &mut Output<'_>,
    ) {
        let found = hits.count_ones() as usize;
        if COUNT {
            self.count += found as u64;
            return;
        }
        // SAFETY: the contract of this function; room for LANES couples is made before they are stored.
        unsafe {
            if self.to >= self.full {
                *self = self.make_room(out);
            }
            V::store_couples::<TWO_SETS>(id, ids, hits, self.to);
            self.to = self.to.add(found);
        }
    }

    /// # Safety
    /// As [`Writer::close`].
    #[cold]
    #[inline(never)]
    unsafe fn make_room(self, out: &mut Output<'_>) -> Self {
        // SAFETY: the contract of this function.
        unsafe { self.close(out) };
        (out.make_room)(out.couples);
        Self::new(out)
    }
}

/// What is compared: spheres of one radius, spheres with radii, boxes.
pub(super) const EQUAL: u8 = 0;
pub(super) const RADII: u8 = 1;
pub(super) const BOXES: u8 = 2;

/// Calls the variant of a kernel for some shape, for what a task has (a filter) and for what is wanted of it (to count only).
macro_rules! variant {
    ($task:expr, $out:expr, $kernel:ident::<$($generic:tt),*>, $shape:ident) => {
        match ($out.count_only, $task.own.filter.is_some()) {
            (false, false) => $kernel::<$($generic),*, $shape, false, false>($task, $out),
            (true, false) => $kernel::<$($generic),*, $shape, true, false>($task, $out),
            (false, true) => $kernel::<$($generic),*, $shape, false, true>($task, $out),
            (true, true) => $kernel::<$($generic),*, $shape, true, true>($task, $out),
        }
    };
}
pub(super) use variant;

/// Compares every element of the stretch with those behind it in its row and with the neighbour rows.
///
/// For each element, in order: its own row, then the neighbour rows in the order given; partners ascend along the row.
///
/// # Safety
/// The instructions of `V` are there, and `task` is as its fields say: rows inside the arrays, and `V::LANES` readable entries
/// after the last element of each.
#[inline(always)]
pub(crate) unsafe fn search<T, V, const D: usize, const TWO_SETS: bool>(
    task: &Task<'_, T>,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
{
    // SAFETY: the contract of this function.
    unsafe {
        match task.shape() {
            BOXES => variant!(task, out, all::<T, V, D, TWO_SETS>, BOXES),
            RADII => variant!(task, out, all::<T, V, D, TWO_SETS>, RADII),
            _ => variant!(task, out, all::<T, V, D, TWO_SETS>, EQUAL),
        }
    }
}

#[inline(always)]
unsafe fn all<
    T,
    V,
    const D: usize,
    const TWO_SETS: bool,
    const SHAPE: u8,
    const COUNT: bool,
    const FILTER: bool,
>(
    task: &Task<'_, T>,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
{
    let (mut few, mut many) = ([const { MaybeUninit::uninit() }; FEW_AHEAD], Vec::new());
    let mut rows = Rows::<T, D>::new::<SHAPE, FILTER>(task, V::LANES, &mut few, &mut many);
    let mut writer = Writer::new(out);
    // SAFETY: the contract of `search`.
    unsafe {
        rows.compare::<V, TWO_SETS, SHAPE, COUNT, FILTER>(task.from..task.to, &mut writer, out);
        writer.close(out);
    }
}

/// One element, spread over all lanes.
struct Element<V, const D: usize> {
    /// The centre, or the lower ends of a box.
    centre: [V; D],
    /// The upper ends of a box, with the tolerance.
    far: [V; D],
    radius: V,
    id: u32,
    label: Label,
}

/// The arrays of one row, by address, so that the inner loop has nothing to compute.
#[derive(Clone, Copy)]
pub(super) struct Row<T, const D: usize> {
    pub(super) axes: [*const T; D],
    /// The axis along which the row is sorted.
    pub(super) along: *const T,
    /// As `axes`, of the upper ends of boxes.
    far: [*const T; D],
    pub(super) radii: *const T,
    pub(super) ids: *const u32,
    /// Where the row starts in the arrays of a filter.
    pub(super) start: usize,
    pub(super) len: usize,
}

impl<T, const D: usize> Row<T, D> {
    #[inline(always)]
    fn new(arrays: &Arrays<'_, T>, long: usize, span: Span) -> Self {
        let Span { start, len } = span;
        let axis = |axis: usize| arrays.coordinates.as_ptr().wrapping_add(D * start + axis * len);
        Self {
            axes: std::array::from_fn(axis),
            along: axis(long),
            far: std::array::from_fn(|axis| arrays.far.as_ptr().wrapping_add(D * start + axis * len)),
            radii: arrays.radii.as_ptr().wrapping_add(start),
            ids: arrays.ids.as_ptr().wrapping_add(start),
            start,
            len,
        }
    }
}

/// A neighbour row, and where the search in it starts: see [`Neighbour`].
pub(super) struct Window<T, const D: usize> {
    pub(super) row: Row<T, D>,
    pub(super) low: usize,
    looks: Looks,
    reach: T,
}

/// Up to 3D there are at most so many neighbour rows of spheres.
pub(super) const FEW: usize = 4;

/// And so many of boxes that look ahead. Nothing is allocated for these.
pub(super) const FEW_AHEAD: usize = 8;

/// A task, by address.
pub(super) struct Rows<'a, T, const D: usize> {
    task: &'a Task<'a, T>,
    pub(super) own: Row<T, D>,
    pub(super) windows: &'a mut [Window<T, D>],
    pub(super) own_labels: Labels<'a>,
    /// Those of the neighbour rows.
    pub(super) labels: Labels<'a>,
}

impl<'a, T: Real, const D: usize> Rows<'a, T, D> {
    /// `few` and `many` are memory for the windows.
    ///
    /// # Panics
    /// Unless all rows are inside the arrays, with `lanes` entries after the last element.
    #[inline(always)]
    pub(super) fn new<const SHAPE: u8, const FILTER: bool>(
        task: &'a Task<'a, T>,
        lanes: usize,
        few: &'a mut [MaybeUninit<Window<T, D>>; FEW_AHEAD],
        many: &'a mut Vec<Window<T, D>>,
    ) -> Self {
        let neighbours = task.neighbours.iter().map(|neighbour| (&task.other, neighbour.row));
        for (arrays, row) in neighbours.chain([(&task.own, task.row)]) {
            assert!(D * (row.start + row.len) + lanes <= arrays.coordinates.len());
            assert!(row.start + row.len + lanes <= arrays.ids.len());
            assert!(SHAPE != BOXES || D * (row.start + row.len) + lanes <= arrays.far.len());
            assert!(SHAPE != RADII || row.start + row.len + lanes <= arrays.radii.len());
        }
        assert!(task.neighbours.iter().all(|neighbour| neighbour.low <= neighbour.row.len));
        assert!(task.from <= task.to && task.to <= task.row.len);
        let (own_labels, labels) =
            if FILTER { (Labels::new(&task.own), Labels::new(&task.other)) } else { (NO_LABELS, NO_LABELS) };
        assert!(!FILTER || own_labels.are_like(&labels));

        let windows = task.neighbours.iter().map(|&Neighbour { row, low, looks, reach }| Window {
            row: Row::new(&task.other, task.long, row),
            low,
            looks,
            reach,
        });
        let windows = if task.neighbours.len() <= FEW_AHEAD {
            few.iter_mut().zip(windows).for_each(|(place, window)| {
                place.write(window);
            });
            // SAFETY: as many as there are neighbours have just been written.
            unsafe { std::slice::from_raw_parts_mut(few.as_mut_ptr().cast(), task.neighbours.len()) }
        } else {
            many.extend(windows);
            &mut many[..]
        };
        Self { task, own: Row::new(&task.own, task.long, task.row), windows, own_labels, labels }
    }

    /// The elements `range` of the row.
    ///
    /// # Safety
    /// The instructions of `V` are there, which has at most the lanes for which this was made, and `range` is inside that of the task.
    #[inline(always)]
    pub(super) unsafe fn compare<
        V: Vector<T>,
        const TWO_SETS: bool,
        const SHAPE: u8,
        const COUNT: bool,
        const FILTER: bool,
    >(
        &mut self,
        range: Range<usize>,
        writer: &mut Writer,
        out: &mut Output<'_>,
    ) {
        let (task, own, own_labels, labels) = (self.task, self.own, self.own_labels, self.labels);
        // SAFETY: the instructions are there by the contract of this function. Rows are inside the arrays, as has been asserted. `k` is an
        // element of its row; a vector starts at an element of a row, or behind its last one with no lane counted, and so ends at most LANES
        // entries behind the row, where the arrays still are.
        unsafe {
            let (reach_squared, tolerance) = (V::splat(task.reach_squared), V::splat(task.tolerance));
            for k in range {
                let x = *own.along.add(k);
                let mut centre = [reach_squared; D];
                for (x, axis) in centre.iter_mut().zip(own.axes) {
                    *x = V::splat(*axis.add(k));
                }
                let radius = if SHAPE == RADII { V::splat(*own.radii.add(k)) } else { tolerance };
                let label = if FILTER { own_labels.of(own.start + k) } else { NO_LABEL };
                let (mut far, mut high) = ([reach_squared; D], x + task.reach);
                if SHAPE == BOXES {
                    for (x, axis) in far.iter_mut().zip(own.far) {
                        *x = V::splat(*axis.add(k));
                    }
                    high = *own.far[task.long].add(k);
                }
                let element = Element { centre, far, radius, id: *own.ids.add(k), label };
                if !TWO_SETS && !task.two_sets {
                    window::<T, V, D, TWO_SETS, SHAPE, COUNT, FILTER>(
                        &own,
                        k + 1,
                        high,
                        &element,
                        &labels,
                        reach_squared,
                        tolerance,
                        writer,
                        out,
                    );
                }

                for Window { row, low, looks, reach } in &mut *self.windows {
                    *low = match looks {
                        Looks::Ahead if SHAPE == BOXES => {
                            first_from::<_, _, false>(row.along, *low, row.len, V::splat(x))
                        }
                        Looks::Beyond if SHAPE == BOXES => {
                            first_from::<_, _, true>(row.along, *low, row.len, V::splat(x))
                        }
                        _ => first_from::<_, _, false>(row.along, *low, row.len, V::splat(x - *reach)),
                    };
                    let high = if SHAPE == BOXES { high } else { x + *reach };
                    window::<T, V, D, TWO_SETS, SHAPE, COUNT, FILTER>(
                        row,
                        *low,
                        high,
                        &element,
                        &labels,
                        reach_squared,
                        tolerance,
                        writer,
                        out,
                    );
                }
            }
        }
    }
}

/// The first element of a row, from `low` on, that is not below `lows`, or is beyond; or the length of the row.
///
/// # Safety
/// `low` is at most `len`, and LANES entries from any element up to there are readable.
#[inline(always)]
pub(super) unsafe fn first_from<T, V: Vector<T>, const BEYOND: bool>(
    along: *const T,
    low: usize,
    len: usize,
    lows: V,
) -> usize {
    let mut first = low;
    loop {
        // SAFETY: the contract of this function.
        let passed = unsafe {
            let along = V::load(along.add(first));
            if BEYOND { along.at_most(lows) } else { along.below(lows) }
        };
        let passed = passed.trailing_ones() as usize;
        first += passed;
        if passed < V::LANES || first >= len {
            // Lanes behind the row count for nothing.
            return first.min(len);
        }
    }
}

/// One element against those of `row` from `first` on, as far as `high`.
///
/// # Safety
/// As [`search`]; `first` is at most the length of the row.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "inlined: they stay in registers")]
unsafe fn window<
    T,
    V,
    const D: usize,
    const TWO_SETS: bool,
    const SHAPE: u8,
    const COUNT: bool,
    const FILTER: bool,
>(
    row: &Row<T, D>,
    first: usize,
    high: T,
    element: &Element<V, D>,
    labels: &Labels<'_>,
    reach_squared: V,
    tolerance: V,
    writer: &mut Writer,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
{
    let mut j = first;
    // SAFETY: see `Rows::compare`.
    unsafe {
        loop {
            let mut hits = if SHAPE == BOXES {
                let mut hits = u32::MAX;
                for axis in 0..D {
                    let (low, high) = (V::load(row.axes[axis].add(j)), V::load(row.far[axis].add(j)));
                    hits &= low.at_most(element.far[axis]) & element.centre[axis].at_most(high);
                }
                hits
            } else {
                // The sum starts from zero by definition, and zero plus a square is the square.
                let mut sum = reach_squared;
                for (axis, x) in element.centre.iter().enumerate() {
                    let difference = x.sub(V::load(row.axes[axis].add(j)));
                    let square = difference.mul(difference);
                    sum = if axis == 0 { square } else { sum.add(square) };
                }
                let mut limit = reach_squared;
                if SHAPE == RADII {
                    let reach = element.radius.add(V::load(row.radii.add(j))).add(tolerance);
                    limit = reach.mul(reach);
                }
                sum.at_most(limit)
            };
            if j + V::LANES > row.len {
                hits &= first_lanes(row.len - j);
            }
            if FILTER {
                hits = labels.admitted::<T, V>(&element.label, row.start + j, hits);
            }
            writer.take::<T, V, TWO_SETS, COUNT>(element.id, row.ids.add(j), hits, out);
            j += V::LANES;
            if j >= row.len || *row.along.add(j) > high {
                return;
            }
        }
    }
}
