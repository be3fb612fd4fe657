//! Compares four elements at a time in coordinates of 32 bits, and uses the exact comparison where these leave a doubt.
//!
//! A stretch of a row and its surroundings are copied: relative to a point nearby, in units of the reach, rounded to 32 bits. Then most
//! windows fit into one vector. Four neighbours in a row, a *cluster*, share their windows, so fewer branches on the end of a window are
//! mispredicted, and each loaded vector is used four times.
//!
//! # Why the couples are the same
//! In units of the reach, let `M` bound the coordinates of the copy, `u = 2^-24`, and `v` half the epsilon of the input type. Roundings are
//! given to first order; the constants below leave room for the rest.
//! - A coordinate is off by at most `(u + 3 v) M`: difference, product and factor round in the type of the input, then the copy rounds. A
//!   difference of two coordinates is off by twice that and by its own rounding, `2 u M`; together by less than `e = (4 u + 8 v) M`.
//! - So the sum `s` of `D <= 3` squares is off by less than `2 e sqrt(3 s) + 3 e^2`, plus `(D + 1) u s` for its own roundings and
//!   `(D + 2) v s` for those in the definition of contact.
//! - The contact distance `c <= 1` is a sum of non-negative numbers and off by at most `(5 u + 12 v) c`; its square is off by twice that
//!   relative to `c^2`.
//!
//! With `E = (4 e + 2^-18) c + 4 e^2` no contact has `s > c^2 + E` here, because these bounds ascend with `s`. All elements with
//! `s <= c^2 - E` are contacts, because `s` less its bound ascends too. If any `s` of a cluster lies in between, the kernel compares the
//! cluster again. Any value that underflows in the definition is smaller than `e^2` here.
//!
//! Windows extend `4 e` beyond the reach, and rounding keeps the order of coordinates, so no window misses an element. Couples are written
//! in the order of the kernel.

use std::mem::MaybeUninit;
use std::ops::Range;

use crate::real::Real;
use crate::simd::kernel::{FEW, FEW_AHEAD, Rows, Window, first_from, variant};
use crate::simd::labels::NO_LABEL;
use crate::simd::task::{BOXES, EQUAL, Output, Patience, RADII, Task};
use crate::simd::vector::{Estimate, Vector, Writer};

/// Elements that share their windows.
const CLUSTER: usize = 4;

/// Number of elements of a row that are copied at a time: enough to make up for copying their surroundings.
const SEGMENT: usize = 128;

/// With fewer elements a copy does not pay.
const FEWEST: usize = 2 * CLUSTER;

/// Room for a copied piece of a row.
const CAPACITY: usize = 512;

/// Entries behind a copied piece that are far from everything; two of the widest vectors fit.
const PAD: usize = 32;

/// Farther away than anything that is copied; its square is finite.
const FAR: f32 = 1e18;

/// Number of lanes that are compared before the end of a window is checked; another vector is seldom needed.
const WIDTH: usize = 16;

/// Number of elements per reach along the row from which on shared windows pay.
const DENSITY: f64 = 1.5;

/// Largest number of vectors that a cluster is compared with.
const VECTORS: usize = 128;

/// Largest magnitude of a copied coordinate: larger ones would leave too much in doubt.
const LARGEST: f64 = 512.0;

/// Room for the copies of a row and its neighbours: the coordinates of up to three axes and the radii of each.
type Copies = [[[MaybeUninit<f32>; CAPACITY]; 4]; FEW + 1];

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
struct Segment<const D: usize> {
    /// The copied pieces of the row and of its neighbours.
    pieces: [MaybeUninit<Piece<D>>; FEW + 1],
    count: usize,
    /// Bound on the error of a difference of two coordinates: `e` above.
    error: f64,
    /// The inverse of the reach.
    scale: f64,
}

/// Limits of the squared distance: up to which a contact is sure, and up to which it is possible.
struct Limits<C> {
    /// The limits for elements of one radius.
    sure: C,
    possible: C,
    /// `E` above for elements with radii: its factor of the contact distance, and the rest.
    slope: C,
    rest: C,
}

/// The elements of a cluster, each in all lanes of a vector.
struct Cluster<C, const D: usize> {
    centres: [[C; D]; CLUSTER],
    /// The radii plus the tolerance.
    radii: [C; CLUSTER],
}

/// The elements of a vector and which of them touch each element of a cluster: 16 bits for each element of the cluster, those of the first
/// lowest.
#[derive(Clone, Copy)]
struct Hits {
    ids: *const u32,
    bits: u64,
}

/// For the vector that begins behind the first element of a cluster: the lanes that come after each element of the cluster. Those before it
/// have been compared with it already.
const BEHIND: u64 = 0xfff8_fffc_fffe_ffff;

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
/// The processor has the instructions of `V` and `C`, the groups of the filters are groups of their matrix, and [`pays`] is true of `task`. `Rows::new`
/// asserts everything else: rows are inside the arrays, with [`WIDTH`] entries after the last element of each.
#[inline(always)]
pub(super) unsafe fn search<T, V, C, const D: usize>(task: &Task<'_, T>, out: &mut Output<'_>)
where
    T: Real,
    V: Vector<T>,
    C: Estimate,
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
/// That of [`search`].
#[inline(always)]
unsafe fn all<T, V, C, const D: usize, const SHAPE: u8, const FILTER: bool>(
    task: &Task<'_, T>,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
    C: Estimate,
{
    let (mut few, mut many) = ([const { MaybeUninit::uninit() }; FEW_AHEAD], Vec::new());
    let mut rows = Rows::<T, D>::new::<SHAPE, FILTER>(task, WIDTH.max(V::LANES), &mut few, &mut many);
    let mut copies = MaybeUninit::<Copies>::uninit();
    let mut writer = Writer::new(out);
    let mut from = task.from;
    while from < task.to {
        let to = task.to.min(from + SEGMENT);
        // SAFETY: the contract of this function; the stretch is inside the row, the writer was made from `out`, and `copies` are written again only when the
        // segment that points to them is no longer used.
        unsafe {
            let segment = if out.patience.without > 0 {
                out.patience.without -= 1;
                None
            } else {
                copy::<T, V, D, SHAPE>(task, &mut rows, from..to, &mut copies)
            };
            match segment {
                Some(mut segment) => clusters::<T, V, C, D, SHAPE, FILTER>(
                    task,
                    &mut rows,
                    &mut segment,
                    from..to,
                    &mut writer,
                    out,
                ),
                None => rows.compare::<V, false, SHAPE, FILTER>(from..to, &mut writer, out),
            }
        }
        from = to;
    }
    // SAFETY: the writer was made from `out`.
    unsafe { writer.close(out) };
}

/// Copies the elements `range` of the row and all elements that can touch them; `None` if that does not pay.
///
/// # Safety
/// That of [`search`]; `range` is not empty and inside the row; no segment that points to `copies` is used afterwards.
#[inline(always)]
unsafe fn copy<T, V, const D: usize, const SHAPE: u8>(
    task: &Task<'_, T>,
    rows: &mut Rows<'_, T, D>,
    range: Range<usize>,
    copies: &mut MaybeUninit<Copies>,
) -> Option<Segment<D>>
where
    T: Real,
    V: Vector<T>,
{
    let own = rows.own;
    // SAFETY: `range` is inside the row. Vectors start inside rows, or just behind their last element, and so end inside the arrays. A piece has at most
    // CAPACITY - PAD elements, so it and PAD entries behind it fit into the capacity; a vector writes fewer than PAD entries behind the piece. There are at
    // most FEW neighbours, by `pays`.
    unsafe {
        let (first, last) = (*own.along.add(range.start), *own.along.add(range.end - 1));
        let middle = usize::midpoint(range.start, range.end);
        let reach = task.reach.to_f64();
        let width = last.to_f64() - first.to_f64();
        let center = (*own.along.add(middle)).to_f64();
        let largest = ((center - first.to_f64()).max(last.to_f64() - center) + reach).max(task.spread);
        let enough = range.len() >= FEWEST && range.len() as f64 * reach >= DENSITY * width;
        if !enough || largest > LARGEST * reach {
            return None;
        }
        let scale = 1.0 / reach;
        let error = 1.01 * (scale * largest) * (4.0 / 16_777_216.0 + 4.0 * T::EPSILON);
        let scales = V::splat(T::nearest(scale));

        let (lows, highs) = (V::splat(first - task.reach), V::splat(last + task.reach));
        let pieces = [const { MaybeUninit::uninit() }; FEW + 1];
        let mut segment = Segment { pieces, count: 1 + rows.windows.len(), error, scale };
        let copies: *mut [[MaybeUninit<f32>; CAPACITY]; 4] = copies.as_mut_ptr().cast();
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
                    return None;
                }
                end = most;
            }
            let place = copies.add(index).cast::<f32>();
            let (along, radii) = (place.add(task.long * CAPACITY), place.add(D * CAPACITY));
            let piece =
                Piece { axes: [place.cast_const(); D], along, radii, ids: row.ids.add(start), start, low: 0 };
            // The axes are set where the piece is stored: loading a value that was just stored in pieces stalls for some 20 cycles.
            let piece = segment.pieces[index].write(piece);
            for (axis, copied) in piece.axes.iter_mut().enumerate() {
                let (to, origin) = (place.add(axis * CAPACITY), V::splat(*own.axes[axis].add(middle)));
                shorten(row.axes[axis].add(start), end - start, origin, scales, to);
                *copied = to;
            }
            if SHAPE == RADII {
                shorten(row.radii.add(start), end - start, V::splat(T::ZERO), scales, radii);
            }
        }
        Some(segment)
    }
}

/// Copies `n` numbers, relative to `origin` and multiplied by `scale`, followed by [`FAR`].
///
/// # Safety
/// The processor has the instructions; `n` and LANES more numbers can be read from `from` on, and `n` and PAD more can be written from `to` on.
#[inline(always)]
unsafe fn shorten<T, V: Vector<T>>(from: *const T, n: usize, origin: V, scale: V, to: *mut f32) {
    // SAFETY: the contract of this function.
    unsafe {
        let mut k = 0;
        while k < n {
            V::load(from.add(k)).sub(origin).mul(scale).store_short(to.add(k));
            k += V::LANES;
        }
        for lane in 0..PAD {
            *to.add(n + lane) = FAR;
        }
    }
}

impl<C: Estimate> Limits<C> {
    /// # Safety
    /// The processor has the instructions of `C`.
    #[inline(always)]
    unsafe fn new<T: Real, const D: usize>(task: &Task<'_, T>, segment: &Segment<D>) -> Self {
        let Segment { error, scale, .. } = *segment;
        let (slope, rest) = (4.0 * error + 1.0 / 262_144.0, 4.0 * error * error);
        let limit = task.reach_squared.to_f64() * scale * scale;
        let doubt = slope * limit.sqrt() + rest;
        // SAFETY: the contract of this function.
        unsafe {
            Self {
                sure: C::splat((limit - doubt) as f32),
                possible: C::splat((limit + doubt) as f32),
                slope: C::splat(slope as f32),
                rest: C::splat(rest as f32),
            }
        }
    }
}

impl<C: Estimate, const D: usize> Cluster<C, D> {
    /// The cluster of the elements of `piece` from `base` on.
    ///
    /// # Safety
    /// The processor has the instructions of `C`, and `base` is inside the piece.
    #[inline(always)]
    unsafe fn new<const SHAPE: u8>(piece: &Piece<D>, base: usize, tolerance: C) -> Self {
        let mut cluster = Self { centres: [[tolerance; D]; CLUSTER], radii: [tolerance; CLUSTER] };
        // SAFETY: the contract of this function, and PAD entries behind the piece.
        unsafe {
            for i in 0..CLUSTER {
                for (x, axis) in cluster.centres[i].iter_mut().zip(piece.axes) {
                    *x = C::splat(*axis.add(base + i));
                }
                if SHAPE == RADII {
                    cluster.radii[i] = C::splat(*piece.radii.add(base + i)).add(tolerance);
                }
            }
        }
        cluster
    }

    /// The elements of `piece` from `j` on that touch each element of the cluster, as in [`Hits`], and a bit for each lane in doubt.
    ///
    /// # Safety
    /// The processor has the instructions of `C`, and the lanes from `j` on end before the PAD entries behind the piece do.
    #[inline(always)]
    unsafe fn touch<const SHAPE: u8>(&self, piece: &Piece<D>, j: usize, limits: &Limits<C>) -> (u64, u32) {
        let (mut bits, mut doubts) = (0, 0);
        // SAFETY: the contract of this function.
        unsafe {
            let mut others = self.centres[0];
            for (x, axis) in others.iter_mut().zip(piece.axes) {
                *x = C::load(axis.add(j));
            }
            for i in 0..CLUSTER {
                let mut sum = limits.rest;
                for (axis, (x, other)) in self.centres[i].iter().zip(others).enumerate() {
                    let difference = x.sub(other);
                    sum = if axis == 0 {
                        difference.mul(difference)
                    } else {
                        difference.mul_add(difference, sum)
                    };
                }
                let Limits { mut sure, mut possible, slope, rest } = *limits;
                if SHAPE == RADII {
                    let reach = self.radii[i].add(C::load(piece.radii.add(j)));
                    let (limit, doubt) = (reach.mul(reach), reach.mul_add(slope, rest));
                    (sure, possible) = (limit.sub(doubt), limit.add(doubt));
                }
                let hits = sum.at_most(possible);
                doubts |= hits ^ sum.at_most(sure);
                bits |= u64::from(hits) << (16 * i);
            }
        }
        (bits, doubts)
    }
}

/// Compares the elements `range`; `segment` is their copy.
///
/// # Safety
/// That of [`search`]; `rows` and `segment` are made from `task`, and `writer` from `out`.
#[inline(always)]
unsafe fn clusters<T, V, C, const D: usize, const SHAPE: u8, const FILTER: bool>(
    task: &Task<'_, T>,
    rows: &mut Rows<'_, T, D>,
    segment: &mut Segment<D>,
    range: Range<usize>,
    writer: &mut Writer,
    out: &mut Output<'_>,
) where
    T: Real,
    V: Vector<T>,
    C: Estimate,
{
    let mut found = [const { MaybeUninit::<Hits>::uninit() }; VECTORS];
    let first_hits = found.as_mut_ptr().cast::<Hits>();
    let (mut done, mut repeated) = (0, 0);
    // SAFETY: the contract of this function. `copy` has written `count` pieces. A vector of a piece starts at most WIDTH - LANES entries behind its last
    // element, and so ends inside the PAD entries behind it; the `ids` and labels of its lanes are at most WIDTH entries behind the row, inside their arrays.
    // `found` has room: after `most`, each piece left writes only the vectors that it must, at most WIDTH / LANES.
    unsafe {
        let limits = Limits::<C>::new(task, segment);
        let tolerance = C::splat((task.tolerance.to_f64() * segment.scale) as f32);
        let reach = (1.0 + 4.0 * segment.error) as f32;
        let most = first_hits.add(VECTORS - (FEW + 1) * WIDTH / C::LANES);
        let pieces = segment.pieces.as_mut_ptr().cast::<Piece<D>>();
        let pieces = std::slice::from_raw_parts_mut(pieces, segment.count);
        let mine = pieces[0];
        for base in (0..range.len()).step_by(CLUSTER) {
            let members = CLUSTER.min(range.len() - base);
            let cluster = Cluster::new::<SHAPE>(&mine, base, tolerance);
            let lows = C::splat(*mine.along.add(base) - reach);
            let high = *mine.along.add(base + members - 1) + reach;
            let (mut hits, mut doubts) = (first_hits, 0);
            'pieces: for (index, piece) in pieces.iter_mut().enumerate() {
                let own = index == 0;
                let mut j = base + 1;
                if !own {
                    // The entries behind a piece are far to the right.
                    piece.low = first_from::<_, _, false>(piece.along, piece.low, usize::MAX, lows);
                    j = piece.low;
                }
                let least = j + if own { 1 } else { WIDTH };
                loop {
                    let (bits, doubt) = cluster.touch::<SHAPE>(piece, j, &limits);
                    doubts |= doubt;
                    hits.write(Hits { ids: piece.ids.add(j), bits });
                    hits = hits.add(1);
                    j += C::LANES;
                    if j >= least {
                        if *piece.along.add(j) > high {
                            break;
                        }
                        if hits >= most {
                            doubts = u32::MAX;
                            break 'pieces;
                        }
                    }
                }
            }

            done += 1;
            let from = range.start + base;
            if doubts != 0 {
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
            let found = std::slice::from_raw_parts_mut(first_hits, hits.offset_from_unsigned(first_hits));
            found[0].bits &= BEHIND;
            for i in 0..members {
                let label = if FILTER { rows.own_labels.of(rows.own.start + from + i) } else { NO_LABEL };
                let id = *rows.own.ids.add(from + i);
                for hits in &*found {
                    let mut bits = (hits.bits >> (16 * i)) as u32 & 0xffff;
                    if FILTER {
                        let place = hits.ids.offset_from_unsigned(task.other.ids.as_ptr());
                        bits = rows.labels.admitted::<f32, C>(&label, place, bits);
                    }
                    writer.take::<f32, C, false>(id, hits.ids, bits, out);
                }
            }
        }
        follow(rows, pieces);
    }
    out.patience = Patience::default();
}

/// Moves the windows of the kernel to where those of the clusters are.
#[inline(always)]
fn follow<T, const D: usize>(rows: &mut Rows<'_, T, D>, pieces: &[Piece<D>]) {
    for (window, piece) in rows.windows.iter_mut().zip(&pieces[1..]) {
        window.low = piece.start + piece.low;
    }
}
