//! Compares four elements at a time in coordinates of 32 bits, and uses the exact comparison where these
//! leave a doubt.
//!
//! A stretch of a row and its surroundings are copied: relative to a point nearby, in units of the reach,
//! rounded to 32 bits. Then most windows fit into one vector. Four neighbours in a row, a *cluster*, share
//! their windows, so fewer branches on the end of a window are mispredicted, and each loaded vector is used
//! four times.
//!
//! # Why the couples are the same
//! In units of the reach, let `M` bound the coordinates of the copy, `u = 2^-24`, and `v` half the epsilon of
//! the input type. Roundings are given to first order; the constants below leave room for the rest.
//! - A coordinate is off by at most `(u + 3 v) M`: difference, product and factor round in the type of the
//!   input, then the copy rounds. A difference of two coordinates is off by twice that and by its own
//!   rounding, `2 u M`; together by less than `e = (4 u + 8 v) M`.
//! - Therefore the sum `s` of `D <= 3` squares is off by less than `2 e sqrt(3 s) + 3 e^2`, plus
//!   `(D + 1) u s` for its own roundings and `(D + 2) v s` for the roundings in the definition of contact.
//! - The contact distance `c <= 1` is a sum of non-negative numbers and off by at most `(5 u + 12 v) c`; its
//!   square is off by twice that relative to `c^2`.
//!
//! With `E = (4 e + 2^-18) c + 4 e^2` no contact has `s > c^2 + E` here, because these bounds ascend with
//! `s`. All elements with `s <= c^2 - E` are contacts, because `s` less its bound ascends too. If any `s` of
//! a cluster lies in between, the kernel compares the cluster again. Any value that underflows in the
//! definition is smaller than `e^2` here.
//!
//! The kernel does not compute `s` but `t = s - (c^2 + E)`, the squares added to a number that is negative:
//! the sign of `t` says whether a contact is possible, and `t > -2 E` that it is not sure. Partial sums are
//! at most the larger of `s` and `c^2 + E`, so the roundings of `t` are those of `s` above or
//! `(D + 2) u (c^2 + E)`, which is less than a tenth of the `2^-18 c` in `E`. With radii, the largest `E` of
//! all serves for the second comparison: `c = 1`.
//!
//! Windows extend `4 e` beyond the reach, and rounding keeps the order of coordinates, so no window misses an
//! element. Couples are written in the order of the kernel.

use std::mem::MaybeUninit;
use std::ops::Range;

use crate::real::Real;
use crate::simd::kernel::{FEW, FEW_AHEAD, KernelRows, Window, first_from, variant};
use crate::simd::labels::NO_LABEL;
use crate::simd::task::{BOXES, EQUAL, Output, Patience, RADII, Task};
use crate::simd::vector::{CLUSTER, EstimateVector, Vector, Writer};

/// Number of elements of a row that are copied at a time: enough to make up for copying their surroundings.
const SEGMENT: usize = 128;

/// With fewer elements a copy does not pay.
const FEWEST: usize = 2 * CLUSTER;

/// Room for a copied piece of a row.
const CAPACITY: usize = 528;

/// Entries behind a copied piece that are far from everything; two of the widest vectors fit.
const PAD: usize = 32;

/// Farther away than anything that is copied; its square is finite.
const FAR: f32 = 1e18;

/// Number of lanes that are compared before the end of a window is checked; another vector is seldom needed.
const WIDTH: usize = 16;

/// Number of elements per reach along the row from which on shared windows pay.
const DENSITY: f64 = 1.5;

/// Largest number of vectors that a cluster is compared with, if there is a filter.
const VECTORS: usize = 128;

/// Number of elements near a cluster that are looked at in any case: a loop that mostly ends at the same
/// place is foreseen.
const LEAST: usize = 24;

/// Room for the elements near a cluster.
const NEAR: usize = 560;

/// Largest magnitude of a copied coordinate: larger ones would leave too much in doubt.
const LARGEST: f64 = 512.0;

/// Room for the copies of a row and its neighbours: the coordinates of up to three axes and the radii of
/// each. All begin with a cache line.
#[repr(align(64))]
struct Copies([[[MaybeUninit<f32>; CAPACITY]; 4]; FEW + 1]);

/// A copied piece of a row.
#[derive(Clone, Copy)]
struct Piece<const D: usize> {
    axes: [*const f32; D],
    /// The axis along which the row is sorted.
    along: *const f32,
    radii: *const f32,
    ids: *const u32,
    /// The place of its first element in the row.
    start: usize,
    /// Elements before this one, counted from `start`, are too far to the left of all clusters still to come.
    low: usize,
}

/// The copy of a segment of a row and its surroundings.
struct RowSegment<const D: usize> {
    /// The copied pieces of the row and of its neighbours.
    pieces: [MaybeUninit<Piece<D>>; FEW + 1],
    count: usize,
    /// Bound on the error of a difference of two coordinates: `e` above.
    error: f64,
    /// The inverse of the reach.
    scale: f64,
}

/// Limits of the squared distance: up to which a contact is possible, and from which on it is sure.
struct Limits<C> {
    /// `-(c^2 + E)` for elements of one radius.
    possible: C,
    /// `E` above for elements with radii: its factor of the contact distance, and the rest, which is
    /// negative.
    slope: C,
    rest: C,
    /// `2 E` for the largest contact distance.
    doubt: f32,
}

/// The elements of a cluster, each in all lanes of a vector.
struct Cluster<C, const D: usize> {
    centres: [[C; D]; CLUSTER],
    /// The radii plus the tolerance, negative.
    radii: [C; CLUSTER],
    /// The radii plus the tolerance and the factor of `E`.
    wider: [C; CLUSTER],
    /// The marks of its members: the last cluster of a segment may have fewer.
    marks: C,
}

/// The elements that touch at least one element of a cluster, and which of them.
struct Near {
    /// The marks of each element, as of [`EstimateVector::marks`].
    marks: [MaybeUninit<f32>; NEAR],
    ids: [MaybeUninit<u32>; NEAR],
    count: usize,
    /// The place of the first member in its row.
    from: usize,
    members: usize,
}

impl Near {
    #[inline(always)]
    fn new() -> Self {
        let (marks, ids) = ([MaybeUninit::uninit(); NEAR], [MaybeUninit::uninit(); NEAR]);
        Self { marks, ids, count: 0, from: 0, members: 0 }
    }
}

/// The elements of a vector, and their marks.
#[derive(Clone, Copy)]
struct Hits<C> {
    ids: *const u32,
    marks: C,
}

/// For the vector that begins behind the first element of a cluster: the marks of the elements of the cluster
/// that come before each lane. Later elements have been compared with it already.
const fn behind(marks: [u32; CLUSTER]) -> [u32; WIDTH] {
    let mut behind = [0; WIDTH];
    let mut lane = 0;
    while lane < WIDTH {
        let mut member = 0;
        while member < CLUSTER && member <= lane {
            behind[lane] |= marks[member];
            member += 1;
        }
        lane += 1;
    }
    behind
}

/// Whether clusters can be used for a stretch, and pay.
pub(super) fn pays<T: Real>(task: &Task<'_, T>) -> bool {
    let reach = task.reach.to_f64();
    !task.two_sets
        && task.shape() != BOXES
        && task.to - task.from >= FEWEST
        && task.neighbours.len() <= FEW
        // The reach is far above lengths whose squares underflow.
        && reach >= T::MIN_RESOLVED * 1_048_576.0
        && task.spread <= LARGEST * reach
}

/// Searches as `kernel::search` does, with clusters where they help.
///
/// # Safety
/// The processor has the instructions of `V` and `C`, the groups of the filters are groups of their matrix,
/// and [`pays`] is true of `task`. `Rows::new` asserts everything else: rows are inside the arrays, with
/// [`WIDTH`] entries after the last element of each.
#[inline(always)]
pub(super) unsafe fn search<T, V, C, const D: usize>(task: &Task<'_, T>, out: &mut Output<'_>)
where
    T: Real,
    V: Vector<T>,
    C: EstimateVector,
{
    // SAFETY: the contract of this function.
    unsafe {
        if task.shape() == RADII {
            variant!(task, out, all::<T, V, C, D>, RADII);
        } else {
            variant!(task, out, all::<T, V, C, D>, EQUAL);
        }
    }
}

/// One variant of [`search`].
///
/// # Safety
/// The conditions of [`search`].
#[inline(always)]
unsafe fn all<T, V, C, const D: usize, const SHAPE: u8, const FILTER: bool>(
    task: &Task<'_, T>,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
    C: EstimateVector,
{
    let (mut few, mut many) = ([const { MaybeUninit::uninit() }; FEW_AHEAD], Vec::new());
    let mut rows = KernelRows::<T, D>::new::<SHAPE, FILTER>(task, WIDTH.max(V::LANES), &mut few, &mut many);
    let mut copies = MaybeUninit::<Copies>::uninit();
    let mut segment =
        RowSegment { pieces: [const { MaybeUninit::uninit() }; FEW + 1], count: 0, error: 0.0, scale: 0.0 };
    let mut writer = Writer::new(out);
    let mut from = task.from;
    while from < task.to {
        let to = task.to.min(from + SEGMENT);
        // SAFETY: the contract of this function; the stretch is inside the row, the writer was made from
        // `out`, and `copies` are written again only when the segment that points to them is no longer used.
        unsafe {
            let is_copied = if out.patience.without > 0 {
                out.patience.without -= 1;
                false
            } else {
                copy::<T, V, D, SHAPE>(task, &mut rows, from..to, &mut copies, &mut segment)
            };
            if is_copied {
                clusters::<T, V, C, D, SHAPE, FILTER>(
                    task,
                    &mut rows,
                    &mut segment,
                    from..to,
                    &mut writer,
                    out,
                );
            } else {
                rows.compare::<V, false, SHAPE, FILTER>(from..to, &mut writer, out);
            }
        }
        from = to;
    }
    // SAFETY: the writer was made from `out`.
    unsafe { writer.close(out) };
}

/// Copies the elements `range` of the row and all elements that can touch them into `segment`, which is made
/// in place; `false` if that does not pay.
///
/// # Safety
/// The conditions of [`search`]; `range` is not empty and inside the row; no segment that points to `copies`
/// is used afterwards.
#[inline(always)]
unsafe fn copy<T, V, const D: usize, const SHAPE: u8>(
    task: &Task<'_, T>,
    rows: &mut KernelRows<'_, T, D>,
    range: Range<usize>,
    copies: &mut MaybeUninit<Copies>,
    segment: &mut RowSegment<D>,
) -> bool
where
    T: Real,
    V: Vector<T>,
{
    let own = rows.own;
    // SAFETY: `range` is inside the row. Vectors start inside rows, or just behind their last element, and so
    // end inside the arrays. A piece has at most CAPACITY - PAD elements, so it and PAD entries behind it fit
    // into the capacity; a vector writes fewer than PAD entries behind the piece. There are at most FEW
    // neighbours, by `pays`.
    unsafe {
        let (first, last) = (*own.along.add(range.start), *own.along.add(range.end - 1));
        let middle = usize::midpoint(range.start, range.end);
        let reach = task.reach.to_f64();
        let width = last.to_f64() - first.to_f64();
        let center = (*own.along.add(middle)).to_f64();
        let largest = ((center - first.to_f64()).max(last.to_f64() - center) + reach).max(task.spread);
        let enough = range.len() >= FEWEST && range.len() as f64 * reach >= DENSITY * width;
        if !enough || largest > LARGEST * reach {
            return false;
        }
        let scale = 1.0 / reach;
        let error = 1.01 * (scale * largest) * (4.0 / 16_777_216.0 + 4.0 * T::EPSILON);
        let scales = V::splat(T::nearest(scale));
        let mut origins = [scales; D];
        for (origin, axis) in origins.iter_mut().zip(own.axes) {
            *origin = V::splat(*axis.add(middle));
        }

        let (lows, highs) = (V::splat(first - task.reach), V::splat(last + task.reach));
        (segment.count, segment.error, segment.scale) = (1 + rows.windows.len(), error, scale);
        let copies: *mut [[MaybeUninit<f32>; CAPACITY]; 4] = (&raw mut (*copies.as_mut_ptr()).0).cast();
        for index in 0..segment.count {
            let (row, start, mut end) = if index == 0 {
                (own, range.start, range.end)
            } else {
                let Window { row, low, .. } = &mut rows.windows[index - 1];
                *low = first_from::<_, _, false>(row.along, *low, row.len, lows);
                (*row, *low, *low)
            };
            let most = row.len.min(start + CAPACITY - PAD);
            while end < most {
                let inside = V::load(row.along.add(end)).at_most(highs).trailing_ones() as usize;
                if inside < V::LANES {
                    end += inside;
                    break;
                }
                end += V::LANES;
            }
            if end >= most {
                if most < row.len {
                    return false;
                }
                end = most;
            }
            let place = copies.add(index).cast::<f32>();
            let (along, radii) = (place.add(task.long * CAPACITY), place.add(D * CAPACITY));
            let piece =
                Piece { axes: [place.cast_const(); D], along, radii, ids: row.ids.add(start), start, low: 0 };
            // The axes are set where the piece is stored: loading a value that was just stored in pieces
            // stalls for some 20 cycles.
            let piece = segment.pieces[index].write(piece);
            for (axis, copied) in piece.axes.iter_mut().enumerate() {
                *copied = place.add(axis * CAPACITY);
            }
            let (from, to) = (row.axes.map(|axis| axis.add(start)), piece.axes.map(<*const f32>::cast_mut));
            shorten::<_, _, D>(from, end - start, &origins, scales, to);
            if SHAPE == RADII {
                shorten::<_, _, 1>(
                    [row.radii.add(start)],
                    end - start,
                    &[V::splat(T::ZERO)],
                    scales,
                    [radii],
                );
            }
        }
        true
    }
}

/// Copies `n` numbers of each axis, relative to its origin and multiplied by `scale`, followed by [`FAR`].
///
/// # Safety
/// The processor has the instructions; for each axis `n` and LANES more numbers can be read from `from` on,
/// and `n` and PAD more can be written from `to` on.
#[inline(always)]
unsafe fn shorten<T, V: Vector<T>, const D: usize>(
    from: [*const T; D],
    n: usize,
    origins: &[V; D],
    scale: V,
    to: [*mut f32; D],
) {
    // SAFETY: the contract of this function.
    unsafe {
        let mut k = 0;
        while k < n {
            for axis in 0..D {
                V::load(from[axis].add(k)).sub(origins[axis]).mul(scale).store_short(to[axis].add(k));
            }
            k += V::LANES;
        }
        for to in to {
            for lane in 0..PAD {
                *to.add(n + lane) = FAR;
            }
        }
    }
}

impl<C: EstimateVector> Limits<C> {
    /// # Safety
    /// The processor has the instructions of `C`.
    #[inline(always)]
    unsafe fn new<T: Real, const D: usize>(task: &Task<'_, T>, segment: &RowSegment<D>) -> Self {
        let RowSegment { error, scale, .. } = *segment;
        let (slope, rest) = (4.0 * error + 1.0 / 262_144.0, 4.0 * error * error);
        let limit = task.reach_squared.to_f64() * scale * scale;
        // SAFETY: the contract of this function.
        unsafe {
            Self {
                possible: C::splat(-(limit + slope * limit.sqrt() + rest) as f32),
                slope: C::splat(slope as f32),
                rest: C::splat(-rest as f32),
                doubt: (2.01 * (slope + rest)) as f32,
            }
        }
    }
}

impl<C: EstimateVector, const D: usize> Cluster<C, D> {
    /// The cluster of the `members` elements of `piece` from `base` on.
    ///
    /// # Safety
    /// The processor has the instructions of `C`, and `base` is inside the piece.
    #[inline(always)]
    unsafe fn new<const SHAPE: u8>(
        piece: &Piece<D>,
        base: usize,
        members: usize,
        tolerance: C,
        limits: &Limits<C>,
    ) -> Self {
        let zeros = limits.rest;
        let (radii, wider) = ([zeros; CLUSTER], [zeros; CLUSTER]);
        let mut cluster = Self { centres: [[zeros; D]; CLUSTER], radii, wider, marks: zeros };
        // SAFETY: the contract of this function, and PAD entries behind the piece.
        unsafe {
            for i in 0..CLUSTER {
                for (x, axis) in cluster.centres[i].iter_mut().zip(piece.axes) {
                    *x = C::splat(*axis.add(base + i));
                }
                if SHAPE == RADII {
                    let radius = C::splat(*piece.radii.add(base + i)).add(tolerance);
                    cluster.radii[i] = C::splat(0.0).sub(radius);
                    cluster.wider[i] = radius.add(limits.slope);
                }
            }
            let mut marks = 0;
            for &mark in &C::MARKS[..members] {
                marks |= mark;
            }
            cluster.marks = C::splat(f32::from_bits(marks));
        }
        cluster
    }

    /// Marks the elements of `piece` from `j` on that touch elements of the cluster. `least` becomes the
    /// lesser of itself and the distances from the limit, as [`EstimateVector::least`] has it.
    ///
    /// # Safety
    /// The processor has the instructions of `C`, and the lanes from `j` on end before the PAD entries behind
    /// the piece do.
    #[inline(always)]
    unsafe fn touch<const SHAPE: u8>(
        &self,
        piece: &Piece<D>,
        j: usize,
        limits: &Limits<C>,
        least: &mut C,
    ) -> Touched<C> {
        // SAFETY: the contract of this function.
        unsafe {
            let mut others = self.centres[0];
            for (x, axis) in others.iter_mut().zip(piece.axes) {
                *x = C::load(axis.add(j));
            }
            let mut sums = [limits.possible; CLUSTER];
            for (i, to) in sums.iter_mut().enumerate() {
                let mut sum = limits.possible;
                if SHAPE == RADII {
                    let radii = C::load(piece.radii.add(j));
                    sum = self.radii[i].sub(radii).mul_add(self.wider[i].add(radii), limits.rest);
                }
                for (x, other) in self.centres[i].iter().zip(others) {
                    let difference = x.sub(other);
                    sum = difference.mul_add(difference, sum);
                }
                *to = sum;
            }
            let [a, b, c, d] = sums;
            let nearest = a.least(b).least(c).least(d);
            *least = least.least(nearest);
            Touched { marks: C::marks(sums), nearest }
        }
    }
}

/// The elements of a vector that touch a cluster.
#[derive(Clone, Copy)]
struct Touched<C> {
    marks: C,
    /// The least of the distances from the limit, as [`EstimateVector::least`] has it: negative for all
    /// elements with marks.
    nearest: C,
}

/// How [`clusters`] handles the marks of a vector.
trait Collect<C> {
    /// Takes the elements whose numbers are `ids`.
    ///
    /// # Safety
    /// The processor has the instructions of `C`, its lanes can be read from `ids` on, and there is room.
    unsafe fn take(&mut self, touched: Touched<C>, ids: *const u32);

    /// Whether there is only room for the vectors that the pieces of a segment have at least.
    fn is_full(&self) -> bool;
}

/// Counts the marks.
struct Count<C> {
    count: u64,
    /// The marks of all members.
    members: C,
}

impl<C: EstimateVector> Collect<C> for Count<C> {
    #[inline(always)]
    unsafe fn take(&mut self, Touched { marks, .. }: Touched<C>, _: *const u32) {
        // SAFETY: the contract of this function.
        self.count += u64::from(unsafe { marks.and(self.members).count_marks() });
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        false
    }
}

/// Collects the marked elements in the memory of a [`Near`]; kept in registers.
struct Sift<C> {
    marks: *mut f32,
    ids: *mut u32,
    count: usize,
    /// The marks of all members.
    members: C,
}

impl<C: EstimateVector> Collect<C> for Sift<C> {
    #[inline(always)]
    unsafe fn take(&mut self, Touched { marks, nearest }: Touched<C>, ids: *const u32) {
        // SAFETY: the contract of this function: LANES entries fit behind `count`.
        unsafe {
            let lanes = marks.marked_near(nearest, self.members);
            marks.sift(ids, lanes, self.marks.add(self.count), self.ids.add(self.count));
            self.count += lanes.count_ones() as usize;
        }
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        self.count >= NEAR - (FEW + 2) * WIDTH
    }
}

/// The vectors near a cluster.
struct AllHits<C> {
    hits: [MaybeUninit<Hits<C>>; VECTORS],
    count: usize,
}

impl<C: EstimateVector> Collect<C> for AllHits<C> {
    #[inline(always)]
    unsafe fn take(&mut self, Touched { marks, .. }: Touched<C>, ids: *const u32) {
        // SAFETY: the contract of this function.
        unsafe { self.hits.as_mut_ptr().add(self.count).write(MaybeUninit::new(Hits { ids, marks })) };
        self.count += 1;
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        self.count >= VECTORS - (FEW + 1) * WIDTH / C::LANES
    }
}

/// Compares a cluster with all pieces; `false` if any couple is in doubt or there is no room. `base` is the
/// place of the cluster in the first piece.
///
/// # Safety
/// The caller must meet the conditions of [`clusters`], and leave the room in `to` that [`Collect::is_full`]
/// checks.
#[inline(always)]
unsafe fn collect<C, const D: usize, const SHAPE: u8>(
    pieces: &mut [Piece<D>],
    base: usize,
    cluster: &Cluster<C, D>,
    limits: &Limits<C>,
    reach: f32,
    members: usize,
    to: &mut impl Collect<C>,
) -> bool
where
    C: EstimateVector,
{
    // SAFETY: the contract of this function.
    unsafe {
        let mine = pieces[0];
        let lows = C::splat(*mine.along.add(base) - reach);
        let high = *mine.along.add(base + members - 1) + reach;
        let mut least = C::splat(1.0);
        let mut j = base + 1;
        let mut touched = cluster.touch::<SHAPE>(&mine, j, limits, &mut least);
        touched.marks = touched.marks.and(C::load(const { &behind(C::MARKS) }.as_ptr().cast()));
        to.take(touched, mine.ids.add(j));
        j += C::LANES;
        while *mine.along.add(j) <= high {
            if to.is_full() {
                return false;
            }
            to.take(cluster.touch::<SHAPE>(&mine, j, limits, &mut least), mine.ids.add(j));
            j += C::LANES;
        }
        for piece in &mut pieces[1..] {
            // The entries behind a piece are far to the right.
            piece.low = first_from::<_, _, false>(piece.along, piece.low, usize::MAX, lows);
            j = piece.low;
            for _ in 0..WIDTH / C::LANES {
                to.take(cluster.touch::<SHAPE>(piece, j, limits, &mut least), piece.ids.add(j));
                j += C::LANES;
            }
            while *piece.along.add(j) <= high {
                if to.is_full() {
                    return false;
                }
                to.take(cluster.touch::<SHAPE>(piece, j, limits, &mut least), piece.ids.add(j));
                j += C::LANES;
            }
        }
        !least.is_within(limits.doubt)
    }
}

/// Compares the elements `range`; `segment` is their copy.
///
/// # Safety
/// The conditions of [`search`]; `rows` and `segment` are made from `task`, and `writer` from `out`.
#[inline(always)]
unsafe fn clusters<T, V, C, const D: usize, const SHAPE: u8, const FILTER: bool>(
    task: &Task<'_, T>,
    rows: &mut KernelRows<'_, T, D>,
    segment: &mut RowSegment<D>,
    range: Range<usize>,
    writer: &mut Writer,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
    C: EstimateVector,
{
    // In the plane there are few vectors, and a filter needs the places of the elements: their couples are
    // written from the vectors.
    let apart = FILTER || D == 2 && !out.count_only;
    let mut all = AllHits { hits: [const { MaybeUninit::uninit() }; VECTORS], count: 0 };
    // The elements near a cluster are read after the next cluster has been compared: a load of data that has
    // just been stored in pieces waits some 20 cycles.
    let mut near = [Near::new(), Near::new()];
    let mut turn = 0;
    let (mut done, mut repeated) = (0, 0);
    // SAFETY: the contract of this function. `copy` has written `count` pieces. A vector of a piece starts at
    // most WIDTH - LANES entries behind its last element, and so ends inside the PAD entries behind it; the
    // `ids` and labels of its lanes are at most WIDTH entries behind the row, inside their arrays. There is
    // room for the collected elements: when it is not yet full, each piece left writes only the vectors that
    // it must, at most WIDTH / LANES.
    unsafe {
        let limits = Limits::<C>::new(task, segment);
        let tolerance = C::splat((task.tolerance.to_f64() * segment.scale) as f32);
        let reach = (1.0 + 4.0 * segment.error) as f32;
        let pieces = segment.pieces.as_mut_ptr().cast::<Piece<D>>();
        let pieces = std::slice::from_raw_parts_mut(pieces, segment.count);
        let mine = pieces[0];
        for base in (0..range.len()).step_by(CLUSTER) {
            let members = CLUSTER.min(range.len() - base);
            let from = range.start + base;
            let cluster = Cluster::new::<SHAPE>(&mine, base, members, tolerance, &limits);
            let sure = if apart {
                all.count = 0;
                collect::<C, D, SHAPE>(pieces, base, &cluster, &limits, reach, members, &mut all)
            } else if out.count_only {
                let mut to = Count { count: 0, members: cluster.marks };
                let sure = collect::<C, D, SHAPE>(pieces, base, &cluster, &limits, reach, members, &mut to);
                writer.count(if sure { to.count } else { 0 });
                sure
            } else {
                let (marks, ids) = (near[turn].marks.as_mut_ptr().cast(), near[turn].ids.as_mut_ptr().cast());
                let mut to = Sift { marks, ids, count: 0, members: cluster.marks };
                let sure = collect::<C, D, SHAPE>(pieces, base, &cluster, &limits, reach, members, &mut to);
                near[turn].count = to.count;
                sure
            };
            done += 1;
            if !apart && !out.count_only {
                hand_over::<T, C, D>(rows, &mut near[1 - turn], writer, out);
            }
            if !sure {
                repeated += 1;
                follow(rows, pieces);
                let hopeless = repeated >= 3 && 2 * repeated > done;
                let to = if hopeless { range.end } else { from + members };
                rows.compare::<V, false, SHAPE, FILTER>(from..to, writer, out);
                if hopeless {
                    out.patience.lost();
                    return;
                }
                continue;
            }
            if apart {
                let found = std::slice::from_raw_parts(all.hits.as_ptr().cast::<Hits<C>>(), all.count);
                of_each::<T, C, D, FILTER, 0>(task, rows, found, from, members, writer, out);
                of_each::<T, C, D, FILTER, 1>(task, rows, found, from, members, writer, out);
                of_each::<T, C, D, FILTER, 2>(task, rows, found, from, members, writer, out);
                of_each::<T, C, D, FILTER, 3>(task, rows, found, from, members, writer, out);
            } else if !out.count_only {
                (near[turn].from, near[turn].members) = (from, members);
                turn = 1 - turn;
            }
        }
        if !apart && !out.count_only {
            hand_over::<T, C, D>(rows, &mut near[1 - turn], writer, out);
        }
        follow(rows, pieces);
    }
    out.patience = Patience::default();
}

/// Writes the couples of one member of a cluster, if it has that one, with the elements of `found`.
///
/// # Safety
/// The processor has the instructions of `C`; `found` was collected for members of the row, from `from` on;
/// that of [`Writer::take`].
#[inline(always)]
unsafe fn of_each<T, C, const D: usize, const FILTER: bool, const MEMBER: usize>(
    task: &Task<'_, T>,
    rows: &KernelRows<'_, T, D>,
    found: &[Hits<C>],
    from: usize,
    members: usize,
    writer: &mut Writer,
    out: &mut Output<'_>,
) where
    C: EstimateVector,
{
    if members <= MEMBER {
        return;
    }
    // SAFETY: the contract of this function.
    unsafe {
        let place = from + MEMBER;
        let label = if FILTER { rows.own_labels.of(rows.own.start + place) } else { NO_LABEL };
        let id = *rows.own.ids.add(place);
        for hits in found {
            let mut bits = hits.marks.marked_by::<MEMBER>();
            if FILTER {
                let place = hits.ids.offset_from_unsigned(task.other.ids.as_ptr());
                bits = rows.labels.admitted::<f32, C>(&label, place, bits);
            }
            writer.take::<f32, C, false>(id, hits.ids, bits, out);
        }
    }
}

/// Writes the couples of a cluster; afterwards it has no members.
///
/// # Safety
/// The processor has the instructions of `C`; `near` was collected for members of the row; that of
/// [`Writer::take`].
#[inline(always)]
unsafe fn hand_over<T, C, const D: usize>(
    rows: &KernelRows<'_, T, D>,
    near: &mut Near,
    writer: &mut Writer,
    out: &mut Output<'_>,
) where
    C: EstimateVector,
{
    let members = std::mem::take(&mut near.members);
    // SAFETY: the contract of this function.
    unsafe {
        // Marks behind the last ones are cleared.
        for k in (0..LEAST).step_by(C::LANES) {
            C::splat(0.0).store_short(near.marks.as_mut_ptr().cast::<f32>().add(near.count + k));
        }
        if members > 0 {
            of_member::<T, C, D, 0>(rows, near, writer, out);
        }
        if members > 1 {
            of_member::<T, C, D, 1>(rows, near, writer, out);
        }
        if members > 2 {
            of_member::<T, C, D, 2>(rows, near, writer, out);
        }
        if members > 3 {
            of_member::<T, C, D, 3>(rows, near, writer, out);
        }
    }
}

/// Writes the couples of one member of a cluster.
///
/// # Safety
/// The conditions of [`hand_over`].
#[inline(always)]
unsafe fn of_member<T, C, const D: usize, const MEMBER: usize>(
    rows: &KernelRows<'_, T, D>,
    near: &Near,
    writer: &mut Writer,
    out: &mut Output<'_>,
) where
    C: EstimateVector,
{
    // SAFETY: the contract of this function; `Near` has LANES entries behind the last one.
    unsafe {
        let id = *rows.own.ids.add(near.from + MEMBER);
        for k in (0..near.count.max(LEAST)).step_by(C::LANES) {
            let hits = C::load(near.marks.as_ptr().cast::<f32>().add(k)).marked_by::<MEMBER>();
            writer.take::<f32, C, false>(id, near.ids.as_ptr().cast::<u32>().add(k), hits, out);
        }
    }
}

/// Moves the windows of the kernel to where those of the clusters are.
#[inline(always)]
fn follow<T, const D: usize>(rows: &mut KernelRows<'_, T, D>, pieces: &[Piece<D>]) {
    for (window, piece) in rows.windows.iter_mut().zip(&pieces[1..]) {
        window.low = piece.start + piece.low;
    }
}
