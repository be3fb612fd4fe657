//! The neighbour rows of the contact mask.

use crate::real::Real;
use crate::search::rows::layout::Layout;

/// Finds the row at one offset of the mask. It must receive the rows in ascending order, because it only
/// moves forward.
pub(super) struct Cursor<const D: usize> {
    offset: [i64; D],
    row: usize,
    /// The cells of `row`; `None` past the last row.
    cells: Option<[i64; D]>,
}

impl<const D: usize> Cursor<D> {
    /// A cursor for rows from `first` on.
    pub(super) fn new<T: Real>(layout: &Layout<T, D>, offset: [i64; D], first: usize) -> Self {
        let wanted = add(&layout.row_cells(first), &offset);
        let (mut row, mut end) = (0, layout.rows());
        while row < end {
            let middle = usize::midpoint(row, end);
            if layout.row_cells(middle) < wanted { row = middle + 1 } else { end = middle }
        }
        Self { offset, row, cells: (row < layout.rows()).then(|| layout.row_cells(row)) }
    }

    /// The row at `cells + offset`, if it exists. `cells` must not descend from call to call.
    pub(super) fn find<T: Real>(&mut self, layout: &Layout<T, D>, cells: &[i64; D]) -> Option<usize> {
        let wanted = add(cells, &self.offset);
        while self.cells? < wanted {
            self.row += 1;
            self.cells = (self.row < layout.rows()).then(|| layout.row_cells(self.row));
        }
        (self.cells? == wanted).then_some(self.row)
    }
}

fn add<const D: usize>(cells: &[i64; D], offset: &[i64; D]) -> [i64; D] {
    std::array::from_fn(|k| cells[k] + offset[k])
}

/// The offsets of the neighbour rows of the contact mask, most significant axis first; the long axis comes
/// last and has offset 0.
///
/// These are the offsets before zero in lexicographic order, so each couple of neighbouring rows is compared
/// once.
pub(super) fn half_mask<const D: usize>() -> Vec<[i64; D]> {
    let mut offsets = vec![[0; D]];
    for level in 0..D - 1 {
        offsets = offsets
            .into_iter()
            .flat_map(|offset| {
                [-1, 0, 1].map(|step| {
                    let mut offset = offset;
                    offset[level] = step;
                    offset
                })
            })
            .collect();
    }
    offsets.retain(|offset| *offset < [0; D]);
    offsets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mask_of_rows_is_half_of_the_neighbour_rows() {
        assert_eq!(half_mask::<1>(), [[0; 1]; 0]);
        assert_eq!(half_mask::<2>(), [[-1, 0]]);
        assert_eq!(half_mask::<3>(), [[-1, -1, 0], [-1, 0, 0], [-1, 1, 0], [0, -1, 0]]);
        assert_eq!(half_mask::<6>().len(), 121);
    }
}
