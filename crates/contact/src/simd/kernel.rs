//! The search over one row, written once for all vector instructions.

use std::mem::MaybeUninit;
use std::ops::Range;

use crate::couple::Couple;
use crate::filter::Arranged;
use crate::real::Real;
use crate::simd::cluster::Patience;
use crate::simd::labels::{Label, Labels, NO_LABEL, NO_LABELS};

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
    /// The largest distance along this row between touching elements; for boxes, the largest distance by which one of two touching boxes
    /// begins earlier.
    pub(crate) reach: T,
}

/// Where along a row the search for partners of an element at `x` starts; for spheres it is always `Back`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Looks {
    /// The reach before `x`.
    Back,
    /// At `x`. The elements of the other row search from beyond their own place: of two boxes, the one that begins first looks for the
    /// other.
    Ahead,
    /// Just beyond `x`.
    Beyond,
}

/// The arrays of a layout.
///
/// # Shapes
/// Element `k` of a row has the coordinate `coordinates[D * start + axis * len + k]`. All arrays continue for at least one vector after the
/// last element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrays<'a, T> {
    pub(crate) coordinates: &'a [T],
    /// The upper ends of boxes, with the tolerance added, in the order of `coordinates`, which are the lower ends; empty for spheres.
    pub(crate) far: &'a [T],
    /// Empty for boxes and elements of one radius.
    pub(crate) radii: &'a [T],
    pub(crate) ids: &'a [u32],
    /// Which elements see each other, by their place in the arrays; as long as `ids`.
    pub(crate) filter: Option<Arranged<'a>>,
}

/// A stretch of a row, to be compared with the rest of its row and with the neighbour rows.
///
/// The neighbour rows may belong to another set of elements. Then the element is not compared with its own row. Unless both sets are
/// numbered together, couples are not ordered by number: `i` belongs to the stretch, `j` to the other set.
pub struct Task<'a, T> {
    /// The arrays that hold the row.
    pub(crate) own: Arrays<'a, T>,
    /// The arrays that hold the neighbour rows: the same ones, unless there are two sets. Both have radii or neither, and both have filters
    /// of the same kind and with the same matrix or neither.
    pub(crate) other: Arrays<'a, T>,
    pub(crate) two_sets: bool,
    pub(crate) one_numbering: bool,
    pub(crate) row: Span,
    /// The stretch of the row: couples whose first element lies in it are wanted.
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
    /// The largest distance of elements of the row and the neighbour rows along any axis but the long one; infinite if unknown.
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

/// The operations of a set of vector instructions on one float type.
///
/// Comparisons return a bit for each lane, the first lane lowest; the bits above `LANES` are 0.
///
/// # Safety
/// The processor has the instructions: every method needs them. Methods that take pointers say what else they need.
pub(crate) trait Vector<T>: Copy {
    const LANES: usize;

    /// The same number in all lanes.
    ///
    /// # Safety
    /// The processor has the instructions.
    unsafe fn splat(x: T) -> Self;

    /// The `LANES` numbers from `from` on.
    ///
    /// # Safety
    /// The processor has the instructions, and `LANES` numbers can be read from `from` on.
    unsafe fn load(from: *const T) -> Self;

    /// # Safety
    /// The processor has the instructions.
    unsafe fn add(self, other: Self) -> Self;

    /// # Safety
    /// The processor has the instructions.
    unsafe fn sub(self, other: Self) -> Self;

    /// # Safety
    /// The processor has the instructions.
    unsafe fn mul(self, other: Self) -> Self;

    /// Writes the lanes to `to`, each rounded to the nearest number of 32 bits.
    ///
    /// # Safety
    /// The processor has the instructions, and `LANES` numbers can be written from `to` on.
    unsafe fn store_short(self, to: *mut f32);

    /// Lanes with `self <= other`.
    ///
    /// # Safety
    /// The processor has the instructions.
    unsafe fn at_most(self, other: Self) -> u32;

    /// Lanes with `self < other`.
    ///
    /// # Safety
    /// The processor has the instructions.
    unsafe fn below(self, other: Self) -> u32;

    /// Lanes whose number, from `from` on, equals `number`.
    ///
    /// # Safety
    /// The processor has the instructions, and `LANES` numbers can be read from `from` on.
    unsafe fn equal(number: u32, from: *const u32) -> u32;

    /// Lanes whose number, from `from` on, has a bit in common with `bits`.
    ///
    /// # Safety
    /// That of [`Vector::equal`].
    unsafe fn overlap(bits: u32, from: *const u32) -> u32;

    /// Lanes whose number `g`, from `from` on, is the place of a 1 among the bits of `row`: bit `g % 32` of word `g / 32`.
    ///
    /// # Safety
    /// That of [`Vector::equal`], and the word `g / 32` of `row` can be read for each of these numbers.
    unsafe fn set(row: *const u32, from: *const u32) -> u32;

    /// Stores the couples of `id` with those of the next `LANES` of `ids` whose bit in `hits` is set, in order: the smaller number first,
    /// or with `TWO_SETS` that of `id` first.
    ///
    /// # Safety
    /// The processor has the instructions, `LANES` numbers can be read from `ids` on, `LANES` couples can be written from `to` on, and only the lowest
    /// `LANES` bits of `hits` are set.
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple);
}

/// A vector for estimates, whose results may differ between instruction sets.
///
/// # Safety
/// That of [`Vector`].
pub(super) trait Estimate: Vector<f32> {
    /// `self * other + sum`, rounded once or twice depending on the instruction set.
    unsafe fn mul_add(self, other: Self, sum: Self) -> Self;
}

/// The bits of the lanes before `count`, up to 31 lanes; no vector has more.
#[inline(always)]
fn first_lanes(count: usize) -> u32 {
    (1 << count.min(31)) - 1
}

/// Where the next couples go; kept in registers.
#[derive(Clone, Copy)]
pub(super) struct Writer {
    to: *mut Couple,
    /// From here on there is not enough room for a vector of couples.
    full: *mut Couple,
    /// Couples that were counted and not written.
    count: u64,
}

impl Writer {
    #[inline(always)]
    pub(super) fn new(out: &mut Output<'_>) -> Self {
        let (len, capacity) = (out.couples.len(), out.couples.capacity());
        let start = out.couples.as_mut_ptr();
        // Wraps: without any room `full` would lie before `start`. It is only compared.
        // If couples are only counted there is never room: so the loops need no variant for it, and no other test.
        let is_full = out.count_only || capacity - len < ROOM;
        let full = start.wrapping_add(if is_full { len } else { capacity - ROOM + 1 });
        Self { to: start.wrapping_add(len), full, count: 0 }
    }

    /// Hands the couples over.
    ///
    /// # Safety
    /// The writer was made from `out`, whose vector has not been used since, and only [`Writer::take`] has moved the writer on.
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
    /// That of [`Vector::store_couples`], room for couples aside, and that of [`Writer::close`].
    #[inline(always)]
    pub(super) unsafe fn take<T, V: Vector<T>, const TWO_SETS: bool>(
        &mut self,
        id: u32,
        ids: *const u32,
        hits: u32,
        out: &mut Output<'_>,
    ) {
        let found = hits.count_ones() as usize;
        // SAFETY: the contract of this function. Before `full` there is room for ROOM couples, which is at least LANES; `make_room` asserts that.
        unsafe {
            if self.to >= self.full {
                if out.count_only {
                    self.count += found as u64;
                    return;
                }
                *self = self.make_room(out);
            }
            V::store_couples::<TWO_SETS>(id, ids, hits, self.to);
            self.to = self.to.add(found);
        }
    }

    /// Hands the couples over, has room made, and returns a writer behind them.
    ///
    /// # Safety
    /// That of [`Writer::close`].
    ///
    /// # Panics
    /// If no room was made.
    #[cold]
    #[inline(never)]
    unsafe fn make_room(self, out: &mut Output<'_>) -> Self {
        // SAFETY: the contract of this function.
        unsafe { self.close(out) };
        (out.make_room)(out.couples);
        assert!(out.couples.capacity() - out.couples.len() >= ROOM);
        Self::new(out)
    }
}

/// The kinds of shapes: spheres of one radius, spheres with radii, boxes.
pub(super) const EQUAL: u8 = 0;
pub(super) const RADII: u8 = 1;
pub(super) const BOXES: u8 = 2;

/// Calls the variant of a kernel for a shape and for whether the task has a filter.
macro_rules! variant {
    ($task:expr, $out:expr, $kernel:ident::<$($generic:tt),*>, $shape:ident) => {
        if $task.own.filter.is_some() {
            $kernel::<$($generic),*, $shape, true>($task, $out)
        } else {
            $kernel::<$($generic),*, $shape, false>($task, $out)
        }
    };
}
pub(super) use variant;

/// Compares every element of the stretch with those behind it in its row and with the neighbour rows.
///
/// Each element in turn is compared with its own row, then with the neighbour rows in their order. Partners ascend along the row.
///
/// # Safety
/// The processor has the instructions of `V`, and the groups of the filters are groups of their matrix. [`Rows::new`] asserts everything else: rows are
/// inside the arrays, with `V::LANES` entries after the last element of each.
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

/// One variant of [`search`].
///
/// # Safety
/// That of [`search`].
#[inline(always)]
unsafe fn all<T, V, const D: usize, const TWO_SETS: bool, const SHAPE: u8, const FILTER: bool>(
    task: &Task<'_, T>,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
{
    let (mut few, mut many) = ([const { MaybeUninit::uninit() }; FEW_AHEAD], Vec::new());
    let mut rows = Rows::<T, D>::new::<SHAPE, FILTER>(task, V::LANES, &mut few, &mut many);
    let mut writer = Writer::new(out);
    // SAFETY: the contract of this function; `new` has asserted that the stretch is inside the row, and the writer was made from `out`.
    unsafe {
        rows.compare::<V, TWO_SETS, SHAPE, FILTER>(task.from..task.to, &mut writer, out);
        writer.close(out);
    }
}

/// One element of the row, each of its numbers in all lanes.
struct Element<V, const D: usize> {
    /// The centre, or the lower ends of a box.
    centre: [V; D],
    /// The upper ends of a box, with the tolerance.
    far: [V; D],
    radius: V,
    id: u32,
    label: Label,
}

/// Pointers to the arrays of one row, so that the inner loop computes no addresses.
#[derive(Clone, Copy)]
pub(super) struct Row<T, const D: usize> {
    pub(super) axes: [*const T; D],
    /// The axis along which the row is sorted.
    pub(super) along: *const T,
    /// As `axes`, for the upper ends of boxes.
    far: [*const T; D],
    pub(super) radii: *const T,
    pub(super) ids: *const u32,
    /// The place of the row in the arrays of a filter.
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

/// A neighbour row and the place where the search in it starts: see [`Neighbour`].
pub(super) struct Window<T, const D: usize> {
    pub(super) row: Row<T, D>,
    pub(super) low: usize,
    looks: Looks,
    reach: T,
}

/// Largest number of neighbour rows of spheres up to 3D.
pub(super) const FEW: usize = 4;

/// Largest number of neighbour rows of boxes that look ahead up to 3D. Up to here nothing is allocated.
pub(super) const FEW_AHEAD: usize = 8;

/// A task with pointers instead of places.
pub(super) struct Rows<'a, T, const D: usize> {
    task: &'a Task<'a, T>,
    pub(super) own: Row<T, D>,
    pub(super) windows: &'a mut [Window<T, D>],
    pub(super) own_labels: Labels<'a>,
    /// The labels of the neighbour rows.
    pub(super) labels: Labels<'a>,
}

impl<'a, T: Real, const D: usize> Rows<'a, T, D> {
    /// Checks the task and takes the pointers. `few` and `many` are memory for the windows.
    ///
    /// # Panics
    /// If a row is not inside the arrays with `lanes` entries after its last element, or a place is not inside its row.
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
        assert!(task.long < D);
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
            // SAFETY: one window for each neighbour has just been written, and `few` has room for them all.
            unsafe { std::slice::from_raw_parts_mut(few.as_mut_ptr().cast(), task.neighbours.len()) }
        } else {
            many.extend(windows);
            &mut many[..]
        };
        Self { task, own: Row::new(&task.own, task.long, task.row), windows, own_labels, labels }
    }

    /// Compares the elements `range` of the row.
    ///
    /// # Safety
    /// The processor has the instructions of `V`, which has at most the lanes for which this was made; `range` is inside that of the task; the groups of the
    /// filters are groups of their matrix; `writer` was made from `out`.
    #[inline(always)]
    pub(super) unsafe fn compare<V: Vector<T>, const TWO_SETS: bool, const SHAPE: u8, const FILTER: bool>(
        &mut self,
        range: Range<usize>,
        writer: &mut Writer,
        out: &mut Output<'_>,
    ) {
        let (task, own, own_labels, labels) = (self.task, self.own, self.own_labels, self.labels);
        // SAFETY: the contract of this function gives the instructions and the groups. `new` has asserted that rows are inside the arrays. `k` is an
        // element of its row. A vector starts at an element of a row, or just behind its last one with no lane counted; so it ends at most LANES
        // entries behind the row, still inside the arrays.
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
                    window::<T, V, D, TWO_SETS, SHAPE, FILTER>(
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
                    window::<T, V, D, TWO_SETS, SHAPE, FILTER>(
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

/// The place of the first element of a row, from `low` on, that is not below `lows` (`BEYOND`: that is above), or the length of the row.
///
/// # Safety
/// The processor has the instructions, `low` is at most `len`, and LANES numbers can be read from each place up to the one that is returned.
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
            // Lanes behind the row do not count.
            return first.min(len);
        }
    }
}

/// Compares one element with those of `row` from `first` on, as far as `high`.
///
/// # Safety
/// That of [`Rows::compare`]; `row` is one of its rows, and `first` is at most the length of the row.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "inlined: they stay in registers")]
unsafe fn window<T, V, const D: usize, const TWO_SETS: bool, const SHAPE: u8, const FILTER: bool>(
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
    // SAFETY: the contract of this function, and the comment in `Rows::compare`.
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
                // By definition the sum starts from zero; zero plus a square is the square.
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
            writer.take::<T, V, TWO_SETS>(element.id, row.ids.add(j), hits, out);
            j += V::LANES;
            if j >= row.len || *row.along.add(j) > high {
                return;
            }
        }
    }
}
