//! Convex pieces of a triangle, on which four functions are linear.

use crate::vector::cross;

/// Most corners of a piece: of a triangle that was cut by seven lines.
pub(super) const MOST: usize = 10;

/// Bits of the number of a corner: all pieces have three corners of the triangle, and two of each cut.
const BITS: u32 = 5;

/// Room for the corners of all pieces.
const ALL: usize = 1 << BITS;

/// A point, by the last two of its barycentric coordinates, and the values of the functions there.
#[derive(Clone, Copy, Default)]
pub(super) struct FacePoint {
    pub(super) place: [f64; 2],
    pub(super) values: [f64; 4],
}

impl FacePoint {
    /// Barycentric coordinates on the triangle.
    pub(super) fn coordinates(&self) -> [f64; 3] {
        let [one, two] = self.place;
        [1.0 - one - two, one, two]
    }

    /// The point at a share of the way to another.
    #[inline]
    fn towards(&self, other: &Self, share: f64) -> Self {
        Self {
            place: std::array::from_fn(|k| self.place[k] + share * (other.place[k] - self.place[k])),
            values: std::array::from_fn(|k| self.values[k] + share * (other.values[k] - self.values[k])),
        }
    }
}

/// A triangle that is cut into pieces.
#[derive(Default)]
pub(super) struct CutTriangle {
    corners: [FacePoint; ALL],
    count: usize,
}

/// A convex piece of the triangle: the numbers of its corners, in order, in [`BITS`] bits each.
#[derive(Clone, Copy)]
pub(super) struct ConvexPiece {
    numbers: u64,
    count: u32,
}

impl ConvexPiece {
    /// The whole triangle.
    pub(super) const WHOLE: Self = Self { numbers: 2 << (2 * BITS) | 1 << BITS, count: 3 };

    const EMPTY: Self = Self { numbers: 0, count: 0 };

    #[inline]
    fn number(&self, corner: u32) -> usize {
        (self.numbers >> (BITS * corner)) as usize % ALL
    }
}

impl CutTriangle {
    /// A triangle with these values of the functions at its corners.
    pub(super) fn of(values: &[[f64; 4]; 3]) -> Self {
        let mut pieces = Self { corners: [FacePoint::default(); ALL], count: 3 };
        pieces.begin(values);
        pieces
    }

    /// Begins again with another triangle.
    #[inline]
    pub(super) fn begin(&mut self, values: &[[f64; 4]; 3]) {
        for (corner, (place, values)) in
            self.corners.iter_mut().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().zip(values))
        {
            *corner = FacePoint { place, values: *values };
        }
        self.count = 3;
    }

    /// The corners of a piece.
    #[inline]
    pub(super) fn corners(&self, piece: &ConvexPiece) -> impl Iterator<Item = &FacePoint> {
        let mut numbers = piece.numbers;
        (0..piece.count).map(move |_| {
            let number = numbers as usize % ALL;
            numbers >>= BITS;
            &self.corners[number]
        })
    }

    /// The part of a piece where a linear function of the values is not negative.
    ///
    /// The signs at the corners are bits of a mask, and its runs give the kept corners: with a branch for
    /// each corner, a step of a heap took a third longer.
    #[inline]
    pub(super) fn cut(&mut self, piece: &ConvexPiece, function: impl Fn(&[f64; 4]) -> f64) -> ConvexPiece {
        let mut at = [0.0; MOST];
        let mut kept = 0_u32;
        for k in 0..piece.count {
            let value = function(&self.corners[piece.number(k)].values);
            at[k as usize] = value;
            kept |= u32::from(value >= 0.0) << k;
        }
        let (count, all) = (piece.count, (1 << piece.count) - 1);
        if kept == all {
            return *piece;
        }
        if kept == 0 {
            return ConvexPiece::EMPTY;
        }
        let before = (kept << 1 | kept >> (count - 1)) & all;
        let mut begins = kept & !before;
        // A line crosses the outline of a convex piece twice. Rounding can let it cross more often, near
        // corners that coincide: the longest run is kept.
        if begins.count_ones() > 1 {
            begins = longest_run(begins, kept, count);
        }
        let first = begins.trailing_zeros();
        // All that are kept, from the first on.
        let turned = (kept >> first | kept << (count - first)) & all;
        let run = turned.trailing_ones();
        let around = |k: u32| if k < count { k } else { k - count };
        let (outside, last) = (around(first + count - 1), around(first + run - 1));
        let after = around(last + 1);
        let begin = self.between(piece, [outside, first], &at);
        let end = self.between(piece, [last, after], &at);
        let numbers = (piece.numbers >> (BITS * first) | piece.numbers << (BITS * (count - first)))
            & ((1 << (BITS * run)) - 1);
        ConvexPiece { numbers: begin | numbers << BITS | end << (BITS * (run + 1)), count: run + 2 }
    }

    /// Adds the corner where the function is zero between two corners of a piece. Returns its number.
    #[inline]
    fn between(&mut self, piece: &ConvexPiece, [one, other]: [u32; 2], at: &[f64; MOST]) -> u64 {
        let [a, b] = [one, other].map(|corner| at[corner as usize]);
        let [from, to] = [one, other].map(|corner| self.corners[piece.number(corner)]);
        let number = self.count % ALL;
        self.corners[number] = from.towards(&to, a / (a - b));
        self.count += 1;
        number as u64
    }
}

/// The beginning of the longest run of bits that are set, of which the bits `begins` are the beginnings,
/// around a circle of `count` bits.
#[cold]
fn longest_run(begins: u32, kept: u32, count: u32) -> u32 {
    let length = |first: u32| (kept >> first | kept << (count - first)).trailing_ones();
    (0..count).filter(|k| begins >> k & 1 != 0).max_by_key(|&k| length(k)).map_or(0, |k| 1 << k)
}

/// Area of a triangle over the area of that on which it lies.
#[inline]
pub(super) fn share_of([a, b, c]: [&FacePoint; 3]) -> f64 {
    let from = |corner: &FacePoint| [corner.place[0] - a.place[0], corner.place[1] - a.place[1]];
    cross(from(b), from(c))
}
