//! The search over one row, written once for all vector instructions.

use crate::couple::Couple;
use crate::filter::{Filter, GroupMatrix, Sight};

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
pub(crate) struct Neighbour {
    pub(crate) row: Span,
    /// Elements before this one are too far to the left of all elements still to come.
    pub(crate) low: usize,
}

/// The arrays of a layout.
///
/// # Shapes
/// Element `k` of a row has the coordinate `coordinates[D * start + axis * len + k]`. All arrays go on for at least one vector after
/// the last element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrays<'a, T> {
    pub(crate) coordinates: &'a [T],
    /// Empty for elements of one radius.
    pub(crate) radii: &'a [T],
    pub(crate) ids: &'a [u32],
    /// Which elements see each other, by their place in the arrays; as long as `ids`. All groups are ones of the matrix, also behind the last element.
    pub(crate) filter: Option<Filter<'a>>,
}

/// A stretch of a row, to be compared with the rest of its row and with the neighbour rows.
///
/// The neighbour rows may belong to another set of elements. Then the rest of the own row is left out, and couples are not ordered by
/// number: `i` is of the stretch, `j` of the other set.
pub struct Task<'a, T, const D: usize> {
    /// Where the row is.
    pub(crate) own: Arrays<'a, T>,
    /// Where the neighbour rows are: the same arrays, unless there are two sets. Either both have radii or none, and either both
    /// have filters of one kind, with one matrix, or none.
    pub(crate) other: Arrays<'a, T>,
    pub(crate) two_sets: bool,
    pub(crate) row: Span,
    /// The stretch of the row whose couples are wanted, as first elements of couples.
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) neighbours: &'a [Neighbour],
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

    /// A bit for each lane, the first lane lowest: whether the number there is `number`. `LANES` of them are readable from `from` on.
    unsafe fn equal(number: u32, from: *const u32) -> u32;

    /// The same: whether the number there and `bits` have a bit in common.
    unsafe fn overlap(bits: u32, from: *const u32) -> u32;

    /// The same: whether bit `g` of `row`, words of 32, is set, where `g` is the number there. `row` has a word for each of the `LANES` numbers.
    unsafe fn set(row: *const u32, from: *const u32) -> u32;

    /// Stores the couples of `id` with those of the `LANES` readable `ids` whose bit in `hits` is set, in order: smaller number first,
    /// or with `TWO_SETS` that of `id`. `to` must be writable for `LANES` couples.
    unsafe fn store<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple);
}

/// The lanes before `count`: up to 31, which is more than any vector has.
#[inline(always)]
fn first_lanes(count: usize) -> u32 {
    (1 << count.min(31)) - 1
}

/// The place for the next couples, in registers.
#[derive(Clone, Copy)]
struct Writer {
    to: *mut Couple,
    /// From here on there is no room for a vector of couples.
    full: *mut Couple,
    /// Found and not written.
    count: u64,
}

impl Writer {
    #[inline(always)]
    fn new(out: &mut Output<'_>) -> Self {
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
    unsafe fn close(self, out: &mut Output<'_>) {
        // SAFETY: `to` points into the vector, behind what was written.
        unsafe {
            let len = self.to.offset_from_unsigned(out.couples.as_ptr());
            out.count += self.count + (len - out.couples.len()) as u64;
            out.couples.set_len(len);
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

/// Compares every element of the stretch with those behind it in its row and with the neighbour rows.
///
/// For each element, in order: its own row, then the neighbour rows in the order given; partners ascend along the row.
///
/// # Safety
/// The instructions of `V` are there, and `task` is as its fields say: rows inside the arrays, and `V::LANES` readable entries
/// after the last element of each.
#[inline(always)]
pub(crate) unsafe fn search<T, V, const D: usize, const TWO_SETS: bool>(
    task: &Task<'_, T, D>,
    out: &mut Output<'_>,
) where
    T: crate::real::Real,
    V: Vector<T>,
{
    // SAFETY: all blocks of this function rest on its own contract; each adds why its place is inside.
    unsafe {
        match (task.own.radii.is_empty(), out.count_only, task.own.filter.is_some()) {
            (true, false, false) => stretch::<T, V, D, TWO_SETS, false, false, false>(task, out),
            (true, true, false) => stretch::<T, V, D, TWO_SETS, false, true, false>(task, out),
            (false, false, false) => stretch::<T, V, D, TWO_SETS, true, false, false>(task, out),
            (false, true, false) => stretch::<T, V, D, TWO_SETS, true, true, false>(task, out),
            (true, false, true) => stretch::<T, V, D, TWO_SETS, false, false, true>(task, out),
            (true, true, true) => stretch::<T, V, D, TWO_SETS, false, true, true>(task, out),
            (false, false, true) => stretch::<T, V, D, TWO_SETS, true, false, true>(task, out),
            (false, true, true) => stretch::<T, V, D, TWO_SETS, true, true, true>(task, out),
        }
    }
}

/// One element, spread over all lanes.
struct Element<T, V, const D: usize> {
    centre: [V; D],
    radius: V,
    id: u32,
    /// Elements beyond this coordinate do not touch it.
    high: T,
    label: Label,
}

/// The arrays of one row, by address, so that the inner loop has nothing to compute.
#[derive(Clone, Copy)]
struct Row<T, const D: usize> {
    axes: [*const T; D],
    /// The axis along which the row is sorted.
    along: *const T,
    radii: *const T,
    ids: *const u32,
    /// Where the row starts in the arrays of a filter.
    start: usize,
    len: usize,
}

impl<T, const D: usize> Row<T, D> {
    #[inline(always)]
    fn new(arrays: &Arrays<'_, T>, long: usize, span: Span) -> Self {
        let Span { start, len } = span;
        let axis = |axis: usize| arrays.coordinates.as_ptr().wrapping_add(D * start + axis * len);
        Self {
            axes: std::array::from_fn(axis),
            along: axis(long),
            radii: arrays.radii.as_ptr().wrapping_add(start),
            ids: arrays.ids.as_ptr().wrapping_add(start),
            start,
            len,
        }
    }
}

/// The arrays of a filter, by address; null for those that it does not have.
#[derive(Clone, Copy)]
struct Labels<'a> {
    bodies: *const u32,
    /// Categories, or groups of more than fit a word.
    categories: *const u32,
    masks: *const u32,
    matrix: Option<&'a GroupMatrix>,
}

/// What a filter says of one element.
#[derive(Clone, Copy)]
struct Label {
    body: u32,
    category: u32,
    mask: u32,
    /// The groups that the element sees, a bit each.
    groups: *const u32,
}

const NO_LABELS: Labels<'_> =
    Labels { bodies: std::ptr::null(), categories: std::ptr::null(), masks: std::ptr::null(), matrix: None };

const NO_LABEL: Label = Label { body: 0, category: 0, mask: 0, groups: std::ptr::null() };

impl<'a> Labels<'a> {
    #[inline(always)]
    fn new<T>(arrays: &Arrays<'a, T>) -> Self {
        let mut labels = NO_LABELS;
        let Some(Filter { bodies, sight }) = arrays.filter else { return labels };
        let len = arrays.ids.len();
        if let Some(bodies) = bodies {
            labels.bodies = bodies[..len].as_ptr();
        }
        match sight {
            Sight::All => {}
            Sight::Masks { categories, masks } => {
                labels.categories = categories[..len].as_ptr();
                labels.masks = masks[..len].as_ptr();
            }
            Sight::Groups { groups, matrix } => {
                labels.categories = groups[..len].as_ptr();
                labels.matrix = Some(matrix);
            }
        }
        labels
    }

    /// Whether the two are of one kind, and of one number of groups.
    fn are_like(&self, other: &Self) -> bool {
        [self.bodies, self.categories, self.masks].map(<*const u32>::is_null)
            == [other.bodies, other.categories, other.masks].map(<*const u32>::is_null)
            && self.matrix.map(GroupMatrix::groups) == other.matrix.map(GroupMatrix::groups)
    }

    /// The numbers of one element.
    ///
    /// # Safety
    /// `place` is inside the arrays.
    #[inline(always)]
    unsafe fn of(&self, place: usize) -> Label {
        let mut label = NO_LABEL;
        // SAFETY: the contract of this function.
        unsafe {
            if !self.bodies.is_null() {
                label.body = *self.bodies.add(place);
            }
            if !self.categories.is_null() {
                label.category = *self.categories.add(place);
            }
            if !self.masks.is_null() {
                label.mask = *self.masks.add(place);
            }
        }
        if let Some(matrix) = self.matrix {
            label.groups = matrix.row(label.category).as_ptr();
        }
        label
    }

    /// Those of `hits` that the element sees, among the elements from `place` on.
    ///
    /// # Safety
    /// The instructions of `V` are there, `place` and the next `V::LANES` are inside the arrays, and all groups are ones of the matrix.
    #[inline(always)]
    unsafe fn admitted<T, V: Vector<T>>(&self, label: &Label, place: usize, mut hits: u32) -> u32 {
        // SAFETY: the contract of this function. A row of the matrix has a bit for each group.
        unsafe {
            if !self.bodies.is_null() {
                hits &= !V::equal(label.body, self.bodies.add(place));
            }
            if !self.masks.is_null() {
                hits &= V::overlap(label.mask, self.categories.add(place))
                    & V::overlap(label.category, self.masks.add(place));
            } else if self.matrix.is_some() {
                hits &= V::set(label.groups, self.categories.add(place));
            }
        }
        hits
    }
}

#[inline(always)]
unsafe fn stretch<
    T,
    V,
    const D: usize,
    const TWO_SETS: bool,
    const RADII: bool,
    const COUNT: bool,
    const FILTER: bool,
>(
    task: &Task<'_, T, D>,
    out: &mut Output<'_>,
) where
    T: crate::real::Real,
    V: Vector<T>,
{
    let neighbours = task.neighbours.iter().map(|neighbour| (&task.other, neighbour.row));
    for (arrays, row) in neighbours.chain([(&task.own, task.row)]) {
        assert!(D * (row.start + row.len) + V::LANES <= arrays.coordinates.len());
        assert!(row.start + row.len + V::LANES <= arrays.ids.len());
        assert!(!RADII || row.start + row.len + V::LANES <= arrays.radii.len());
    }
    assert!(task.neighbours.iter().all(|neighbour| neighbour.low <= neighbour.row.len));
    assert!(task.from <= task.to && task.to <= task.row.len);
    let (own_labels, labels) =
        if FILTER { (Labels::new(&task.own), Labels::new(&task.other)) } else { (NO_LABELS, NO_LABELS) };
    assert!(!FILTER || own_labels.are_like(&labels));
    let own = Row::new(&task.own, task.long, task.row);
    // Up to 3D there are at most four neighbour rows, and nothing is allocated.
    let mut few = [(own, 0); 4];
    let mut many = Vec::new();
    let neighbours =
        task.neighbours.iter().map(|&Neighbour { row, low }| (Row::new(&task.other, task.long, row), low));
    let windows = if task.neighbours.len() <= few.len() {
        few.iter_mut().zip(neighbours).for_each(|(window, neighbour)| *window = neighbour);
        &mut few[..task.neighbours.len()]
    } else {
        many.extend(neighbours);
        &mut many[..]
    };
    let mut writer = Writer::new(out);
    // SAFETY: the instructions are there by the contract of this function. Rows are inside the arrays, as has been asserted. `k` is an
    // element of its row; a vector starts at an element of a row, or behind its last one with no lane counted, and so ends at most LANES
    // entries behind the row, where the arrays still are.
    unsafe {
        let (reach_squared, tolerance) = (V::splat(task.reach_squared), V::splat(task.tolerance));
        for k in task.from..task.to {
            let x = *own.along.add(k);
            let mut centre = [reach_squared; D];
            for (x, axis) in centre.iter_mut().zip(own.axes) {
                *x = V::splat(*axis.add(k));
            }
            let radius = if RADII { V::splat(*own.radii.add(k)) } else { tolerance };
            let label = if FILTER { own_labels.of(own.start + k) } else { NO_LABEL };
            let element = Element { centre, radius, id: *own.ids.add(k), high: x + task.reach, label };
            if !TWO_SETS {
                window::<T, V, D, TWO_SETS, RADII, COUNT, FILTER>(
                    &own,
                    k + 1,
                    &element,
                    &labels,
                    reach_squared,
                    tolerance,
                    &mut writer,
                    out,
                );
            }

            let lows = V::splat(x - task.reach);
            for (row, low) in &mut *windows {
                let mut first = *low;
                loop {
                    let passed = V::load(row.along.add(first)).below(lows).trailing_ones() as usize;
                    first += passed;
                    if passed < V::LANES || first >= row.len {
                        break;
                    }
                }
                // Lanes behind the row count for nothing.
                first = first.min(row.len);
                *low = first;
                window::<T, V, D, TWO_SETS, RADII, COUNT, FILTER>(
                    row,
                    first,
                    &element,
                    &labels,
                    reach_squared,
                    tolerance,
                    &mut writer,
                    out,
                );
            }
        }
        writer.close(out);
    }
}

/// One element against those of `row` from `first` on.
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
    const RADII: bool,
    const COUNT: bool,
    const FILTER: bool,
>(
    row: &Row<T, D>,
    first: usize,
    element: &Element<T, V, D>,
    labels: &Labels<'_>,
    reach_squared: V,
    tolerance: V,
    writer: &mut Writer,
    out: &mut Output<'_>,
) where
    T: crate::real::Real,
    V: Vector<T>,
{
    let mut j = first;
    // SAFETY: see `stretch`; room for LANES couples is made before they are stored.
    unsafe {
        loop {
            // The sum starts from zero by definition, and zero plus a square is the square.
            let mut sum = reach_squared;
            for (axis, x) in element.centre.iter().enumerate() {
                let difference = x.sub(V::load(row.axes[axis].add(j)));
                let square = difference.mul(difference);
                sum = if axis == 0 { square } else { sum.add(square) };
            }
            let mut limit = reach_squared;
            if RADII {
                let reach = element.radius.add(V::load(row.radii.add(j))).add(tolerance);
                limit = reach.mul(reach);
            }
            let mut hits = sum.at_most(limit);
            if j + V::LANES > row.len {
                hits &= first_lanes(row.len - j);
            }
            if FILTER {
                hits = labels.admitted::<T, V>(&element.label, row.start + j, hits);
            }
            let found = hits.count_ones() as usize;
            if COUNT {
                writer.count += found as u64;
            } else {
                if writer.to >= writer.full {
                    *writer = writer.make_room(out);
                }
                V::store::<TWO_SETS>(element.id, row.ids.add(j), hits, writer.to);
                writer.to = writer.to.add(found);
            }
            j += V::LANES;
            if j >= row.len || *row.along.add(j) > element.high {
                return;
            }
        }
    }
}
