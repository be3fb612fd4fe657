//! The search over one row, written once for all vector instructions.

use std::mem::MaybeUninit;
use std::ops::Range;

use crate::real::Real;
use crate::simd::labels::{ElementLabel, LabelPointers, NO_LABEL, NO_LABELS};
use crate::simd::task::{Arrays, BOXES, EQUAL, Looks, Neighbour, Output, RADII, Span, Task};
use crate::simd::vector::{Vector, Writer};

/// The bits of the lanes before `count`, up to 31 lanes; no vector has more.
#[inline(always)]
fn first_lanes(count: usize) -> u32 {
    (1 << count.min(31)) - 1
}

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
/// Each element in turn is compared with its own row, then with the neighbour rows in their order. Partners
/// ascend along the row.
///
/// # Safety
/// The processor has the instructions of `V`, and the groups of the filters are groups of their matrix.
/// [`KernelRows::new`] asserts everything else: rows are inside the arrays, with `V::LANES` entries after the
/// last element of each.
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
/// The conditions of [`search`].
#[inline(always)]
unsafe fn all<T, V, const D: usize, const TWO_SETS: bool, const SHAPE: u8, const FILTER: bool>(
    task: &Task<'_, T>,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
{
    let (mut few, mut many) = ([const { MaybeUninit::uninit() }; FEW_AHEAD], Vec::new());
    let mut rows = KernelRows::<T, D>::new::<SHAPE, FILTER>(task, V::LANES, &mut few, &mut many);
    let mut writer = Writer::new(out);
    // SAFETY: the contract of this function; `new` has asserted that the stretch is inside the row, and the
    // writer was made from `out`.
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
    label: ElementLabel,
}

/// Pointers to the arrays of one row, so that the inner loop computes no addresses.
#[derive(Clone, Copy)]
pub(super) struct Row<T, const D: usize> {
    pub(super) axes: [*const T; D],
    /// The axis along which the row is sorted.
    pub(super) along: *const T,
    /// Like `axes`, for the upper ends of boxes.
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
pub(super) struct KernelRows<'a, T, const D: usize> {
    task: &'a Task<'a, T>,
    pub(super) own: Row<T, D>,
    pub(super) windows: &'a mut [Window<T, D>],
    pub(super) own_labels: LabelPointers<'a>,
    /// The labels of the neighbour rows.
    pub(super) labels: LabelPointers<'a>,
}

impl<'a, T: Real, const D: usize> KernelRows<'a, T, D> {
    /// Checks the task and takes the pointers. `few` and `many` are memory for the windows.
    ///
    /// # Panics
    /// If a row is not inside the arrays with `lanes` entries after its last element, or a place is not
    /// inside its row.
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
        let (own_labels, labels) = if FILTER {
            (LabelPointers::new(&task.own), LabelPointers::new(&task.other))
        } else {
            (NO_LABELS, NO_LABELS)
        };
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
    /// The processor has the instructions of `V`, which has at most the lanes for which this was made;
    /// `range` is inside that of the task; the groups of the filters are groups of their matrix; `writer` was
    /// made from `out`.
    #[inline(always)]
    pub(super) unsafe fn compare<V: Vector<T>, const TWO_SETS: bool, const SHAPE: u8, const FILTER: bool>(
        &mut self,
        range: Range<usize>,
        writer: &mut Writer,
        out: &mut Output<'_>,
    ) {
        let (task, own, own_labels, labels) = (self.task, self.own, self.own_labels, self.labels);
        // SAFETY: the contract of this function gives the instructions and the groups. `new` has asserted
        // that rows are inside the arrays. `k` is an element of its row. A vector starts at an element of a
        // row, or just behind its last one with no lane counted; so it ends at most LANES entries behind the
        // row, still inside the arrays.
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

/// The place of the first element of a row, from `low` on, that is not below `lows` (`BEYOND`: that is
/// above), or the length of the row.
///
/// # Safety
/// The processor has the instructions, `low` is at most `len`, and LANES numbers can be read from each place
/// up to the one that is returned.
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
/// The conditions of [`KernelRows::compare`]; `row` is one of its rows, and `first` is at most the length of
/// the row.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "inlined: they stay in registers")]
unsafe fn window<T, V, const D: usize, const TWO_SETS: bool, const SHAPE: u8, const FILTER: bool>(
    row: &Row<T, D>,
    first: usize,
    high: T,
    element: &Element<V, D>,
    labels: &LabelPointers<'_>,
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
