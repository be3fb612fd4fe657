//! The search over one row, written once for all vector instructions.

use crate::couple::Couple;

/// One row, as the arrays of the layout have it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// First element.
    pub(crate) start: usize,
    /// Number of elements.
    pub(crate) len: usize,
}

/// A neighbour row and how far the search has come in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Neighbour {
    pub(crate) row: Span,
    /// Elements before this one are too far to the left of all elements still to come.
    pub(crate) low: usize,
}

/// A stretch of a row, to be compared with the rest of its row and with the neighbour rows.
///
/// # Shapes
/// As in the layout: element `k` of a row has the coordinate `coordinates[D * start + axis * len + k]`. All arrays go on for at least
/// one vector after the last element.
pub struct Task<'a, T, const D: usize> {
    pub(crate) coordinates: &'a [T],
    /// Empty for elements of one radius.
    pub(crate) radii: &'a [T],
    pub(crate) ids: &'a [u32],
    pub(crate) row: Span,
    /// The stretch of the row whose couples are wanted, as first elements of couples.
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) neighbours: &'a mut [Neighbour],
    /// The axis along which rows are sorted.
    pub(crate) long: usize,
    /// No two elements touch that are farther apart along an axis.
    pub(crate) reach: T,
    /// Elements of one radius: the squared contact distance.
    pub(crate) reach_squared: T,
    pub(crate) tolerance: T,
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
}

/// A vector stores at most as many couples as it has lanes.
pub(crate) const ROOM: usize = 16;

/// The operations of a set of vector instructions on one float type.
///
/// # Safety
/// All need the instructions; `load` and `store` need what they say.
pub(crate) trait Vector<T>: Copy {
    const LANES: usize;

    unsafe fn splat(x: T) -> Self;

    /// `LANES` numbers from `from` on, which must be readable.
    unsafe fn load(from: *const T) -> Self;

    unsafe fn add(self, other: Self) -> Self;

    unsafe fn sub(self, other: Self) -> Self;

    unsafe fn mul(self, other: Self) -> Self;

    /// A bit for each lane, the first lane lowest: `self <= other`.
    unsafe fn at_most(self, other: Self) -> u32;

    /// A bit for each lane, the first lane lowest: `self < other`.
    unsafe fn below(self, other: Self) -> u32;

    /// Stores the couples of `id` with those of the `LANES` readable `ids` whose bit in `hits` is set, in order, smaller number first.
    /// `to` must be writable for `LANES` couples.
    unsafe fn store(id: u32, ids: *const u32, hits: u32, to: *mut Couple);
}

/// The lanes before `count`; all of them for a `count` of 32 or more.
#[inline(always)]
fn first_lanes(count: usize) -> u32 {
    if count >= 32 { u32::MAX } else { (1 << count) - 1 }
}

/// Compares every element of the stretch with those behind it in its row and with the neighbour rows.
///
/// For each element, in order: its own row, then the neighbour rows in the order given; partners ascend along the row.
///
/// # Safety
/// The instructions of `V` are there, and `task` is as its fields say: rows inside the arrays, and `V::LANES` readable entries
/// after the last element of each.
#[inline(always)]
pub(crate) unsafe fn search<T, V, const D: usize>(task: &mut Task<'_, T, D>, out: &mut Output<'_>)
where
    T: crate::real::Real,
    V: Vector<T>,
{
    // SAFETY: all blocks of this function rest on its own contract; each adds why its place is inside.
    unsafe {
        if task.radii.is_empty() {
            if out.count_only {
                stretch::<T, V, D, false, true>(task, out);
            } else {
                stretch::<T, V, D, false, false>(task, out);
            }
        } else if out.count_only {
            stretch::<T, V, D, true, true>(task, out);
        } else {
            stretch::<T, V, D, true, false>(task, out);
        }
    }
}

/// One element, spread over all lanes.
struct Element<V, const D: usize> {
    centre: [V; D],
    radius: V,
    id: u32,
}

#[inline(always)]
unsafe fn stretch<T, V, const D: usize, const RADII: bool, const COUNT: bool>(
    task: &mut Task<'_, T, D>,
    out: &mut Output<'_>,
) where
    T: crate::real::Real,
    V: Vector<T>,
{
    let row = task.row;
    debug_assert!(task.from <= task.to && task.to <= row.len);
    debug_assert!(D * (row.start + row.len) + V::LANES <= task.coordinates.len());
    debug_assert!(row.start + row.len + V::LANES <= task.ids.len());
    // SAFETY: `k` is an element of the row, and so are all starts of vectors below: `j < row.len`, or `j == row.len` with no lane valid.
    // A vector from there on ends at most LANES entries behind the row's last element.
    unsafe {
        let Task { coordinates, radii, ids, long, reach, .. } = *task;
        let [mut reach_squared, tolerance] = [task.reach_squared, task.tolerance].map(|x| V::splat(x));
        let along = coordinates.as_ptr().add(D * row.start + long * row.len);
        for k in task.from..task.to {
            let x = *along.add(k);
            let (low, high) = (x - reach, x + reach);
            let mut centre = [reach_squared; D];
            for (axis, x) in centre.iter_mut().enumerate() {
                *x = V::splat(*coordinates.get_unchecked(D * row.start + axis * row.len + k));
            }
            let mut element =
                Element { centre, radius: reach_squared, id: *ids.get_unchecked(row.start + k) };
            if RADII {
                element.radius = V::splat(*radii.get_unchecked(row.start + k));
            }
            window::<T, V, D, RADII, COUNT>(
                task,
                row,
                k + 1,
                &element,
                high,
                &mut reach_squared,
                tolerance,
                out,
            );

            let lows = V::splat(low);
            for n in 0..task.neighbours.len() {
                let Neighbour { row, low: mut first } = *task.neighbours.get_unchecked(n);
                let along = coordinates.as_ptr().add(D * row.start + long * row.len);
                loop {
                    let valid = first_lanes(row.len - first);
                    let passed = (V::load(along.add(first)).below(lows) & valid).trailing_ones() as usize;
                    first += passed;
                    if passed < V::LANES {
                        break;
                    }
                }
                task.neighbours.get_unchecked_mut(n).low = first;
                window::<T, V, D, RADII, COUNT>(
                    task,
                    row,
                    first,
                    &element,
                    high,
                    &mut reach_squared,
                    tolerance,
                    out,
                );
            }
        }
    }
}

/// One element against those of `row` from `first` on, up to the coordinate `high`.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "always inlined: these are the registers of the loop")]
unsafe fn window<T, V, const D: usize, const RADII: bool, const COUNT: bool>(
    task: &Task<'_, T, D>,
    row: Span,
    first: usize,
    element: &Element<V, D>,
    high: T,
    reach_squared: &mut V,
    tolerance: V,
    out: &mut Output<'_>,
) where
    T: crate::real::Real,
    V: Vector<T>,
{
    let Task { coordinates, radii, ids, long, .. } = *task;
    let mut j = first;
    // SAFETY: see `stretch`; room for LANES couples is made before they are stored.
    unsafe {
        let block = coordinates.as_ptr().add(D * row.start);
        loop {
            let mut sum = *reach_squared;
            for axis in 0..D {
                let difference = element.centre[axis].sub(V::load(block.add(axis * row.len + j)));
                let square = difference.mul(difference);
                // The sum starts from zero by definition, and zero plus a square is the square.
                sum = if axis == 0 { square } else { sum.add(square) };
            }
            let mut limit = *reach_squared;
            if RADII {
                let reach = element.radius.add(V::load(radii.as_ptr().add(row.start + j))).add(tolerance);
                limit = reach.mul(reach);
            }
            let hits = sum.at_most(limit) & first_lanes(row.len - j);
            let found = hits.count_ones() as usize;
            out.count += found as u64;
            if !COUNT {
                if out.couples.capacity() - out.couples.len() < ROOM {
                    (out.make_room)(out.couples);
                }
                let len = out.couples.len();
                V::store(
                    element.id,
                    ids.as_ptr().add(row.start + j),
                    hits,
                    out.couples.as_mut_ptr().add(len),
                );
                out.couples.set_len(len + found);
            }
            j += V::LANES;
            if j >= row.len || *block.add(long * row.len + j) > high {
                return;
            }
        }
    }
}
