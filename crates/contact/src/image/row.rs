//! One row of an image against another: where they differ, in runs of equal pairs.

use crate::error::Error;
use crate::image::{Label, Neighbourhood};
use crate::search::rows::resize;

/// Directions to half of the neighbours of a voxel.
pub(super) const DIRECTIONS: usize = 13;
/// Those of them that lead to an edge or a vertex.
pub(super) const DIAGONALS: usize = 10;

/// Where a neighbour is, from the earlier grid square of a pair to the later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Direction<const D: usize> {
    pub(super) step: [i8; D],
    pub(super) kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Along one axis.
    Face { axis: usize },
    /// Along two axes of three; its number among all that are no faces.
    Edge { number: usize },
    /// Along all axes; its number likewise.
    Vertex { number: usize },
}

impl<const D: usize> Direction<D> {
    /// Half of the neighbours: those for which a grid square comes later in the array.
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
                (Kind::Face { axis: step.iter().position(|&step| step != 0)? }, Neighbourhood::Face)
            } else if axes == D {
                (Kind::Vertex { number: diagonals.next()? }, Neighbourhood::Vertex)
            } else {
                (Kind::Edge { number: diagonals.next()? }, Neighbourhood::Edge)
            };
            Some((Self { step, kind }, least))
        });
        all.filter(move |(_, least)| *least <= neighbourhood).map(|(direction, _)| direction)
    }
}

/// Neighbouring grid squares of two rows with the same two labels, one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run<L> {
    /// In the row that comes first in the array.
    pub(super) earlier: L,
    pub(super) later: L,
    /// Place of the first in the later row.
    pub(super) start: usize,
    pub(super) end: usize,
}

/// Memory of a comparison: a byte for each place of a row, 1 where it counts.
#[derive(Clone, Debug, Default)]
pub(super) struct Scan {
    marks: Vec<u8>,
}

/// Places that are looked at together.
const WORD: usize = 8;

impl Scan {
    /// Makes room for rows of this many places.
    pub(super) fn fit(&mut self, width: usize) -> Result<(), Error> {
        let room = width.next_multiple_of(WORD);
        if self.marks.len() < room { resize(&mut self.marks, room, 0) } else { Ok(()) }
    }

    /// Hands over every label that differs from the one before it along each axis: of each body at least its first grid square does.
    ///
    /// `before`: the rows before it along the other axes.
    pub(super) fn new_labels<L: Label>(
        &mut self,
        row: &[L],
        before: [Option<&[L]>; 2],
        background: Option<L>,
        mut note: impl FnMut(L) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let marks = self.marks(row.len());
        marks[0] = 1;
        for ((mark, label), left) in marks[1..].iter_mut().zip(&row[1..]).zip(row) {
            *mark = u8::from(label != left);
        }
        for before in before.into_iter().flatten() {
            for ((mark, label), before) in marks.iter_mut().zip(row).zip(before) {
                *mark &= u8::from(label != before);
            }
        }
        if let Some(background) = background {
            for (mark, label) in marks.iter_mut().zip(row) {
                *mark &= u8::from(*label != background);
            }
        }
        self.each(row.len(), |at| note(row[at]))
    }

    /// Hands over the pairs in one direction, from the row `earlier` to the row `later`, which are of the same length.
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
        let marks = self.marks(count);
        if let Some(background) = background {
            for ((mark, a), b) in marks.iter_mut().zip(earlier).zip(later) {
                *mark = u8::from(a != b) & u8::from(*a != background) & u8::from(*b != background);
            }
        } else {
            for ((mark, a), b) in marks.iter_mut().zip(earlier).zip(later) {
                *mark = u8::from(a != b);
            }
        }
        let mut run: Option<Run<L>> = None;
        self.each(count, |at| {
            let (a, b) = (earlier[at], later[at]);
            if let Some(run) = &mut run {
                if run.end == at + to && run.earlier == a && run.later == b {
                    run.end += 1;
                    return Ok(());
                }
                hand_over(*run)?;
            }
            run = Some(Run { earlier: a, later: b, start: at + to, end: at + to + 1 });
            Ok(())
        })?;
        run.map_or(Ok(()), hand_over)
    }

    /// The marks of `count` places; those behind them, up to a whole word, are 0.
    fn marks(&mut self, count: usize) -> &mut [u8] {
        let room = count.next_multiple_of(WORD);
        self.marks[count..room].fill(0);
        &mut self.marks[..count]
    }

    /// Calls `act` with each place that is marked, in order.
    #[inline]
    fn each(&self, count: usize, mut act: impl FnMut(usize) -> Result<(), Error>) -> Result<(), Error> {
        let (words, _) = self.marks[..count.next_multiple_of(WORD)].as_chunks::<WORD>();
        for (word, marks) in words.iter().enumerate() {
            let mut bits = u64::from_le_bytes(*marks);
            while bits != 0 {
                act(word * WORD + bits.trailing_zeros() as usize / WORD)?;
                bits &= bits - 1;
            }
        }
        Ok(())
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
            if let Kind::Edge { number } | Kind::Vertex { number } = direction.kind {
                assert!(number < DIAGONALS);
                // The numbers do not depend on the neighbourhood.
                let edges = of_3d(Neighbourhood::Edge);
                assert!(edges.iter().all(|edge| edge.step != direction.step || edge.kind == direction.kind));
            }
        }
    }

    #[test]
    fn runs_end_where_labels_change() {
        let mut scan = Scan::default();
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
    fn only_first_grid_squares_are_new() {
        let mut scan = Scan::default();
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
