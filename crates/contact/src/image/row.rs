//! Compares one row of an image with another: finds the differences, as runs of equal pairs.

use crate::error::Error;
use crate::image::{Label, Neighbourhood};
use crate::memory::resize;
use crate::simd::bits_of_bytes;

/// Number of directions to half of the neighbours of a voxel.
pub(super) const DIRECTIONS: usize = 13;
/// Number of these directions that lead to an edge or a vertex.
pub(super) const DIAGONALS: usize = 10;

/// The direction of a neighbour, from the earlier grid square of a pair to the later one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Direction<const D: usize> {
    pub(super) step: [i8; D],
    pub(super) kind: DirectionKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DirectionKind {
    /// Along one axis.
    Face { axis: usize },
    /// Along two of three axes; its number among all directions that are no faces.
    Edge { number: usize },
    /// Along all axes; numbered in the same way.
    Vertex { number: usize },
}

impl<const D: usize> Direction<D> {
    /// The directions to half of the neighbours: to those grid squares that come later in the array.
    pub(super) fn all(neighbourhood: Neighbourhood) -> impl Iterator<Item = Self> {
        let mut diagonals = 0..;
        let steps = (0..3_usize.pow(D as u32)).map(|code| {
            let mut rest = code;
            let mut step = [0_i8; D];
            for step in step.iter_mut().rev() {
                *step = (rest % 3) as i8 - 1;
                rest /= 3;
            }
            step
        });
        let later = steps.filter(|step| step.iter().find(|&&step| step != 0) == Some(&1));
        let all = later.filter_map(move |step| {
            let axes = step.iter().filter(|&&step| step != 0).count();
            let (kind, least) = if axes == 1 {
                (DirectionKind::Face { axis: step.iter().position(|&step| step != 0)? }, Neighbourhood::Face)
            } else if axes == D {
                (DirectionKind::Vertex { number: diagonals.next()? }, Neighbourhood::Vertex)
            } else {
                (DirectionKind::Edge { number: diagonals.next()? }, Neighbourhood::Edge)
            };
            Some((Self { step, kind }, least))
        });
        all.filter(move |(_, least)| *least <= neighbourhood).map(|(direction, _)| direction)
    }
}

/// A run: consecutive pairs of neighbouring grid squares of two rows with the same two labels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run<L> {
    /// The label in the row that comes first in the array.
    pub(super) earlier: L,
    pub(super) later: L,
    /// Place of the first grid square of the run in the later row.
    pub(super) start: usize,
    pub(super) end: usize,
}

/// Working memory of a comparison: one byte for each place of a row.
#[derive(Clone, Debug, Default)]
pub(super) struct RowScan {
    marks: Vec<u8>,
}

/// Bits of a mark. `PAIR`: there is a pair of different bodies (or a label that may be new) here. Below: the
/// next place differs, so a run ends here.
const PAIR: u8 = 1;
const ENDS: u8 = 2;

/// Number of places whose marks are examined together: one per bit of a `u64`.
const GROUP: usize = 64;

impl RowScan {
    /// Makes room for rows of this many places.
    pub(super) fn fit(&mut self, width: usize) -> Result<(), Error> {
        let room = width.next_multiple_of(GROUP);
        if self.marks.len() < room { resize(&mut self.marks, room, 0) } else { Ok(()) }
    }

    /// Reports every label that differs from those before it along all axes. Each body has at least one such
    /// grid square, its first one.
    ///
    /// `before`: the rows before it along the other axes.
    pub(super) fn new_labels<L: Label>(
        &mut self,
        row: &[L],
        before: [Option<&[L]>; 2],
        background: Option<L>,
        mut note: impl FnMut(L) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let Some((&first, rest)) = row.split_first() else { return Ok(()) };
        let body = Body::new(background);
        let is_new = |label: L, before: L| u8::from(label != before) & body.is(label);
        let marks = self.marks(row.len());
        marks[0] =
            before.iter().flatten().fold(body.is(first), |mark, before| mark & is_new(first, before[0]));
        let marks = &mut marks[1..];
        let count = marks.len();
        let left = &row[..count];
        let rest = &rest[..count];
        // One loop for each number of rows to compare.
        match before {
            [None, None] => {
                for at in 0..count {
                    marks[at] = is_new(rest[at], left[at]);
                }
            }
            [Some(before), None] | [None, Some(before)] => {
                let before = &before[1..][..count];
                for at in 0..count {
                    marks[at] = is_new(rest[at], left[at]) & u8::from(rest[at] != before[at]);
                }
            }
            [Some(above), Some(behind)] => {
                let (above, behind) = (&above[1..][..count], &behind[1..][..count]);
                for at in 0..count {
                    let differs = u8::from(rest[at] != above[at]) & u8::from(rest[at] != behind[at]);
                    marks[at] = is_new(rest[at], left[at]) & differs;
                }
            }
        }
        self.groups(row.len(), |first, mut places, _| {
            while places != 0 {
                note(row[first + places.trailing_zeros() as usize])?;
                places &= places - 1;
            }
            Ok(())
        })
    }

    /// Reports the pairs in one direction, from the row `earlier` to the row `later`, which have the same
    /// length.
    #[inline]
    pub(super) fn pairs<L: Label>(
        &mut self,
        earlier: &[L],
        later: &[L],
        along: i8,
        background: Option<L>,
        mut hand_over: impl FnMut(Run<L>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (from, to) = (usize::from(along < 0), usize::from(along > 0));
        let count = later.len() - usize::from(along != 0);
        let (earlier, later) = (&earlier[from..][..count], &later[to..][..count]);
        mark(self.marks(count), earlier, later, background);
        // The start of a run that continues from one group into the next, and whether the group before ended
        // with the end of a run.
        let (mut open, mut ended) = (None, 1);
        self.groups(count, |first, pairs, ends| {
            let (mut starts, mut lasts) = (pairs & (ends << 1 | ended), pairs & ends);
            ended = ends >> (GROUP - 1);
            let next = |bits: &mut u64| {
                let at = first + bits.trailing_zeros() as usize;
                *bits &= bits.wrapping_sub(1);
                at
            };
            while lasts != 0 {
                let start = open.take().unwrap_or_else(|| next(&mut starts));
                let last = next(&mut lasts);
                let (a, b) = (earlier[start], later[start]);
                hand_over(Run { earlier: a, later: b, start: start + to, end: last + 1 + to })?;
            }
            if starts != 0 {
                open = Some(next(&mut starts));
            }
            Ok(())
        })
    }

    /// The marks of `count` places; further ones, up to a whole group, are 0.
    fn marks(&mut self, count: usize) -> &mut [u8] {
        let room = count.next_multiple_of(GROUP);
        self.marks[count..room].fill(0);
        &mut self.marks[..count]
    }

    /// Calls `act` with the first place of each group and, for either mark, with one bit per place.
    #[inline]
    fn groups(
        &self,
        count: usize,
        mut act: impl FnMut(usize, u64, u64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (groups, _) = self.marks[..count.next_multiple_of(GROUP)].as_chunks::<GROUP>();
        for (group, marks) in groups.iter().enumerate() {
            act(
                group * GROUP,
                bits_of_bytes::<{ 7 - PAIR.trailing_zeros().cast_signed() }>(marks),
                bits_of_bytes::<{ 7 - ENDS.trailing_zeros().cast_signed() }>(marks),
            )?;
        }
        Ok(())
    }
}

/// Marks pairs of different bodies and the ends of runs of equal pairs; all slices have the same length.
fn mark<L: Label>(marks: &mut [u8], earlier: &[L], later: &[L], background: Option<L>) {
    let body = Body::new(background);
    let Some((last, marks)) = marks.split_last_mut() else { return };
    let pair = |a: L, b: L| u8::from(a != b) & body.is(a) & body.is(b);
    let next = earlier[1..].iter().zip(&later[1..]);
    for ((mark, (&a, &b)), (&next_a, &next_b)) in marks.iter_mut().zip(earlier.iter().zip(later)).zip(next) {
        let ends = u8::from(a != next_a) | u8::from(b != next_b);
        *mark = (pair(a, b) * PAIR) | (ends * ENDS);
    }
    *last = (pair(earlier[marks.len()], later[marks.len()]) * PAIR) | ENDS;
}

/// Maps bodies to 1 and the background to 0, without branches, so that the code uses vectors.
#[derive(Clone, Copy)]
struct Body<L> {
    background: L,
    /// 1 if there is no background.
    all: u8,
}

impl<L: Label> Body<L> {
    fn new(background: Option<L>) -> Self {
        Self { background: background.unwrap_or_default(), all: u8::from(background.is_none()) }
    }

    #[inline]
    fn is(self, label: L) -> u8 {
        u8::from(label != self.background) | self.all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_as_many_directions_as_half_of_the_neighbours() {
        let of_2d = |neighbourhood| Direction::<2>::all(neighbourhood).collect::<Vec<_>>();
        let of_3d = |neighbourhood| Direction::<3>::all(neighbourhood).collect::<Vec<_>>();
        assert_eq!([of_2d(Neighbourhood::Face).len(), of_2d(Neighbourhood::Vertex).len()], [2, 4]);
        let counts = [Neighbourhood::Face, Neighbourhood::Edge, Neighbourhood::Vertex]
            .map(|neighbourhood| of_3d(neighbourhood).len());
        assert_eq!(counts, [3, 9, DIRECTIONS]);
        for direction in of_3d(Neighbourhood::Vertex) {
            let opposite = direction.step.map(|step| -step);
            assert!(of_3d(Neighbourhood::Vertex).iter().all(|other| other.step != opposite));
            if let DirectionKind::Edge { number } | DirectionKind::Vertex { number } = direction.kind {
                assert!(number < DIAGONALS);
                // The numbers do not depend on the neighbourhood.
                let edges = of_3d(Neighbourhood::Edge);
                assert!(edges.iter().all(|edge| edge.step != direction.step || edge.kind == direction.kind));
            }
        }
    }

    #[test]
    fn runs_end_where_labels_change() {
        let mut scan = RowScan::default();
        let (earlier, later) = ([1_u8, 1, 1, 2, 0, 2, 2, 2, 2, 2], [3_u8, 3, 1, 3, 3, 3, 3, 4, 4, 0]);
        scan.fit(10).unwrap();
        let mut runs = |along, background| {
            let mut runs = Vec::new();
            let found = scan.pairs(&earlier, &later, along, background, |run| {
                runs.push((run.earlier, run.later, run.start, run.end));
                Ok(())
            });
            found.unwrap();
            runs
        };
        assert_eq!(runs(0, Some(0)), [(1, 3, 0, 2), (2, 3, 3, 4), (2, 3, 5, 7), (2, 4, 7, 9)]);
        assert_eq!(runs(0, None)[2..], [(0, 3, 4, 5), (2, 3, 5, 7), (2, 4, 7, 9), (2, 0, 9, 10)]);
        assert_eq!(runs(1, Some(0)), [(1, 3, 1, 2), (1, 3, 3, 4), (2, 3, 4, 5), (2, 3, 6, 7), (2, 4, 7, 9)]);
        assert_eq!(runs(-1, Some(0)), [(1, 3, 0, 2), (2, 1, 2, 3), (2, 3, 4, 7), (2, 4, 7, 9)]);
    }

    #[test]
    fn runs_go_on_from_group_to_group() {
        // All lengths up to some groups: one long run, and runs of one place each.
        let mut scan = RowScan::default();
        for count in 0..=3 * GROUP + 1 {
            scan.fit(count).unwrap();
            let mut found = |earlier: &[u16], later: &[u16], along| {
                let mut runs = Vec::new();
                let done = scan.pairs(earlier, later, along, Some(0), |run| {
                    runs.push((run.start, run.end));
                    Ok(())
                });
                done.unwrap();
                runs
            };
            let (ones, twos) = (vec![1; count], vec![2; count]);
            let whole = if count == 0 { vec![] } else { vec![(0, count)] };
            assert_eq!(found(&ones, &twos, 0), whole);
            let numbers: Vec<u16> = (1..=count as u16).collect();
            assert_eq!(found(&numbers, &twos, 0).len(), count - usize::from(count > 1));
            if count > 0 {
                let steps: Vec<_> = (1..count).map(|at| (at, at + 1)).collect();
                assert_eq!(found(&numbers, &numbers, 1), steps);
            }
            // Label 1 up to the middle, label 2 from there on.
            let mixed: Vec<u16> = (0..count).map(|at| if at < count / 2 { 1 } else { 2 }).collect();
            let half = if count == 0 { vec![] } else { vec![(count / 2, count)] };
            assert_eq!(found(&ones, &mixed, 0), half);
        }
    }

    #[test]
    fn only_first_grid_squares_are_new() {
        let mut scan = RowScan::default();
        scan.fit(6).unwrap();
        let mut new = |before: [Option<&[u8]>; 2], background| {
            let mut new = Vec::new();
            let row = [5, 5, 0, 6, 5, 7];
            scan.new_labels(&row, before, background, |label| {
                new.push(label);
                Ok(())
            })
            .unwrap();
            new
        };
        assert_eq!(new([None, None], Some(0)), [5, 6, 5, 7]);
        assert_eq!(new([None, None], None), [5, 0, 6, 5, 7]);
        assert_eq!(new([Some(&[5, 0, 0, 0, 0, 0]), Some(&[0, 0, 0, 0, 0, 7])], Some(0)), [6, 5]);
    }
}
