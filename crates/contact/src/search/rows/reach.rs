//! Finds the rows of another layout within reach of a stretch of a row.

use crate::real::Real;
use crate::search::rows::layout::Layout;

/// Finds the rows of a layout that lie inside a box of cells, however many cells are empty.
///
/// Rows ascend by cells, so the rows in the box form runs, one for each existing combination of cells on the
/// more significant axes. Between runs the search skips to the next row that may be inside. Each skip starts
/// where the same skip of the previous call ended, because neighbouring boxes have neighbouring runs.
#[derive(Debug)]
pub(crate) struct RowsInReach<'a, T, const D: usize> {
    layout: &'a Layout<T, D>,
    hints: Vec<usize>,
}

/// Number of skips that are remembered; further ones start from the row before them.
const MAX_HINTS: usize = 64;

impl<'a, T: Real, const D: usize> RowsInReach<'a, T, D> {
    pub(crate) fn new(layout: &'a Layout<T, D>) -> Self {
        Self { layout, hints: Vec::new() }
    }

    /// Calls `found`, in ascending order, with all rows that may hold an element within `reach` of the box
    /// from `min` to `max`, on every axis but the long one. Stops, and returns `false`, once `found` returns
    /// `false`.
    ///
    /// No row is missed: cells ascend with the coordinate, whatever the rounding. If `x - reach <= y` for the
    /// number `x` of a box and `y` of an element, then the rounded left side is at most `y` too, because `y`
    /// is a float; so its cell is at most that of `y`. The same holds at the other end.
    pub(crate) fn find(
        &mut self,
        min: &[T; D],
        max: &[T; D],
        reach: f64,
        mut found: impl FnMut(usize) -> bool,
    ) -> bool {
        self.walk(min, max, reach, |row, _| found(row))
    }

    /// Calls `found`, in ascending order, with all rows that may hold an element within `reach` of the box
    /// from `min` to `max`, and with the largest possible distance along the row. Distances are Euclidean if
    /// the reach is `round`, and per axis if not.
    ///
    /// Elements of a row are at least as far from the box as the cells of the row. The quotients of the grid
    /// err by less than `2^-51` of their value, and more than that is subtracted. The root loses some `2^-52`
    /// of the reach to rounding, which is less than the margin that every reach contains.
    pub(crate) fn find_around(
        &mut self,
        min: &[T; D],
        max: &[T; D],
        reach: f64,
        round: bool,
        mut found: impl FnMut(usize, f64),
    ) {
        let grid = self.layout.grid;
        let mut lateral = [[0.0; 3]; D];
        for (lateral, &axis) in lateral.iter_mut().zip(self.layout.axes[1..].iter().rev()) {
            let [min, max] = [min, max].map(|corner| grid.quotient(axis, corner[axis].to_f64()));
            let doubt = (min.abs() + max.abs() + grid.cells()[axis] as f64) * 2.0_f64.powi(-50);
            *lateral = [min, max, 0.5 + doubt];
        }
        let cell_size = grid.cell_size();
        self.walk(min, max, reach, |row, cells| {
            if !round {
                found(row, reach);
                return true;
            }
            let mut left = reach * reach;
            for (cell, [min, max, half]) in cells.iter().zip(lateral).take(D - 1) {
                let cell = *cell as f64;
                let apart = (cell - max - half).max(min - cell - half).max(0.0) * cell_size;
                left -= apart * apart;
            }
            if left >= 0.0 {
                found(row, left.sqrt());
            }
            true
        });
    }

    fn walk(
        &mut self,
        min: &[T; D],
        max: &[T; D],
        reach: f64,
        mut found: impl FnMut(usize, &[i64; D]) -> bool,
    ) -> bool {
        let layout = self.layout;
        let (mut low, mut high) = ([0; D], [0; D]);
        for (level, &axis) in layout.axes[1..].iter().rev().enumerate() {
            let (min, max) = (min[axis].to_f64() - reach, max[axis].to_f64() + reach);
            let Some(cells) = layout.grid.cells_between(axis, min, max) else { return true };
            [low[level], high[level]] = cells.map(u64::cast_signed);
        }
        let mut wanted = low;
        let mut row = 0;
        for leap in 0.. {
            let hint = self.hints.get(leap).copied().unwrap_or(row);
            row = first_row_from(layout, &wanted, hint);
            if leap < self.hints.len() {
                self.hints[leap] = row;
            } else if leap < MAX_HINTS {
                self.hints.push(row);
            }
            loop {
                if row == layout.rows() {
                    return true;
                }
                let cells = layout.row_cells(row);
                let outside = (0..D).find(|&level| cells[level] < low[level] || cells[level] > high[level]);
                let Some(level) = outside else {
                    if !found(row, &cells) {
                        return false;
                    }
                    row += 1;
                    continue;
                };
                // The next cells inside the box, in the order of the rows.
                wanted = cells;
                if cells[level] > high[level] {
                    let Some(step) = (0..level).rev().find(|&step| cells[step] < high[step]) else {
                        return true;
                    };
                    wanted[step] += 1;
                    wanted[step + 1..].copy_from_slice(&low[step + 1..]);
                } else {
                    wanted[level..].copy_from_slice(&low[level..]);
                }
                break;
            }
        }
        true
    }
}

/// The first row whose cells are at least `wanted`; fast if `hint` is near it.
fn first_row_from<T: Real, const D: usize>(layout: &Layout<T, D>, wanted: &[i64; D], hint: usize) -> usize {
    let rows = layout.rows();
    let is_before = |row: usize| layout.row_cells(row) < *wanted;
    let (mut start, mut end);
    let mut step = 1;
    if hint < rows && is_before(hint) {
        start = hint + 1;
        while start + step < rows && is_before(start + step) {
            start += step + 1;
            step *= 2;
        }
        end = rows.min(start + step);
    } else {
        end = hint.min(rows);
        while end >= step && !is_before(end - step) {
            end -= step;
            step *= 2;
        }
        start = (end + 1).saturating_sub(step);
    }
    while start < end {
        let middle = usize::midpoint(start, end);
        if is_before(middle) {
            start = middle + 1;
        } else {
            end = middle;
        }
    }
    start
}
