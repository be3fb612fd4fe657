//! The operations that an instruction set provides, and how the couples of a vector are written.

use crate::couple::Couple;
use crate::simd::task::{Output, ROOM};

/// The operations of a set of vector instructions on one float type.
///
/// Comparisons return a bit for each lane, the first lane lowest; the bits above `LANES` are 0.
///
/// # Safety
/// The processor has the instructions: every method needs them. Methods that take pointers state further
/// conditions.
pub(crate) trait Vector<T>: Copy {
    const LANES: usize;

    /// All lanes set to one number.
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
    /// The conditions of [`Vector::equal`].
    unsafe fn overlap(bits: u32, from: *const u32) -> u32;

    /// Lanes whose number `g`, from `from` on, is the place of a 1 among the bits of `row`: bit `g % 32` of
    /// word `g / 32`.
    ///
    /// # Safety
    /// The conditions of [`Vector::equal`], and the word `g / 32` of `row` can be read for each of these
    /// numbers.
    unsafe fn set(row: *const u32, from: *const u32) -> u32;

    /// Stores the couples of `id` with the elements among the next `LANES` of `ids` whose bit in `hits` is
    /// set, in order: the smaller number first, or with `TWO_SETS` the number of `id` first.
    ///
    /// # Safety
    /// The processor has the instructions, `LANES` numbers can be read from `ids` on, `LANES` couples can be
    /// written from `to` on, and only the lowest `LANES` bits of `hits` are set.
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple);
}

/// Number of elements of a cluster, which share their windows.
pub(super) const CLUSTER: usize = 4;

/// A vector for estimates, whose results may differ between instruction sets.
///
/// Its lanes may also hold *marks*: a bit for each element of a cluster.
///
/// # Safety
/// The conditions of [`Vector`].
pub(super) trait EstimateVector: Vector<f32> {
    /// The mark of each element of a cluster.
    const MARKS: [u32; CLUSTER];

    /// `self * other + sum`, rounded once or twice depending on the instruction set.
    unsafe fn mul_add(self, other: Self, sum: Self) -> Self;

    /// The bits that both have.
    unsafe fn and(self, other: Self) -> Self;

    /// In each lane the negative number that is nearer to zero; a negative one before a positive one. These
    /// are the lesser ones of the bits as integers with a sign.
    unsafe fn least(self, other: Self) -> Self;

    /// Whether any lane is negative and at most `width` from zero.
    unsafe fn is_within(self, width: f32) -> bool;

    /// The marks of the lanes that are negative, for each of four vectors; other bits of the result are
    /// arbitrary.
    unsafe fn marks(vectors: [Self; CLUSTER]) -> Self;

    /// Lanes with any of the marks `of`.
    unsafe fn marked(self, of: Self) -> u32;

    /// Lanes with any of the marks `of`, and maybe more of those that are negative in `nearest`, as all lanes
    /// with marks are.
    #[inline(always)]
    unsafe fn marked_near(self, _nearest: Self, of: Self) -> u32 {
        // SAFETY: the contract of this function.
        unsafe { self.marked(of) }
    }

    /// Lanes with one mark.
    unsafe fn marked_by<const MEMBER: usize>(self) -> u32;

    /// Number of marks; no other bits are set.
    #[inline(always)]
    unsafe fn count_marks(self) -> u32 {
        // SAFETY: the contract of this function.
        unsafe {
            self.marked_by::<0>().count_ones()
                + self.marked_by::<1>().count_ones()
                + self.marked_by::<2>().count_ones()
                + self.marked_by::<3>().count_ones()
        }
    }

    /// Stores the marks whose bit in `lanes` is set, in order, from `marks` on, and the same numbers of `ids`
    /// from `to` on.
    ///
    /// # Safety
    /// The processor has the instructions, `LANES` numbers can be read from `ids` on and written from `marks`
    /// and `to` on, and only the lowest `LANES` bits of `lanes` are set.
    unsafe fn sift(self, ids: *const u32, lanes: u32, marks: *mut f32, to: *mut u32);
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
        // Wraps: without any room `full` would lie before `start`. It is only compared. If couples are only
        // counted there is never room: so the loops need no variant for it, and no other test.
        let is_full = out.count_only || capacity - len < ROOM;
        let full = start.wrapping_add(if is_full { len } else { capacity - ROOM + 1 });
        Self { to: start.wrapping_add(len), full, count: 0 }
    }

    /// Hands the couples over.
    ///
    /// # Safety
    /// The writer was made from `out`, whose vector has not been used since, and only [`Writer::take`] has
    /// moved the writer on.
    #[inline(always)]
    pub(super) unsafe fn close(self, out: &mut Output<'_>) {
        // SAFETY: `to` points into the vector, behind the written entries.
        unsafe {
            let len = self.to.offset_from_unsigned(out.couples.as_ptr());
            out.count += self.count + (len - out.couples.len()) as u64;
            out.couples.set_len(len);
        }
    }

    /// Counts couples that are not written.
    #[inline(always)]
    pub(super) fn count(&mut self, couples: u64) {
        self.count += couples;
    }

    /// Writes or counts the couples of `id` with those of `ids` whose bit in `hits` is set.
    ///
    /// # Safety
    /// The conditions of [`Vector::store_couples`], room for couples aside, and of [`Writer::close`].
    #[inline(always)]
    pub(super) unsafe fn take<T, V: Vector<T>, const TWO_SETS: bool>(
        &mut self,
        id: u32,
        ids: *const u32,
        hits: u32,
        out: &mut Output<'_>,
    ) {
        let found = hits.count_ones() as usize;
        // SAFETY: the contract of this function. Before `full` there is room for ROOM couples, which is at
        // least LANES; `make_room` asserts that.
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
    /// The conditions of [`Writer::close`].
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
