//! Numbers for the cells of one axis that leave out empty stretches.

/// Maps the cells of an axis, in order, to fewer numbers if most of them are empty.
///
/// The axis is cut into stretches. In each stretch only the cells from the first to the last occupied one are
/// numbered. An element far away from the others costs one number, not one for every cell in between.
#[derive(Clone, Debug)]
pub(crate) struct AxisMap {
    cells: u64,
    stretches: Vec<Stretch>,
    /// The stretch of a cell is `cell >> shift`.
    shift: u32,
}

#[derive(Clone, Copy, Debug)]
struct Stretch {
    first: u64,
    last: u64,
    /// Number of the first cell.
    number: u64,
}

/// Largest number of stretches: they stay in the first-level cache.
const MAX_STRETCHES: u64 = 1024;

impl AxisMap {
    /// An axis with this number of `cells`, none of them occupied.
    pub(crate) fn new(cells: u64) -> Self {
        let shift = (0..64).find(|shift| (cells - 1) >> shift < MAX_STRETCHES).unwrap_or(63);
        let empty = Stretch { first: u64::MAX, last: 0, number: 0 };
        Self { cells: 0, stretches: vec![empty; ((cells - 1) >> shift) as usize + 1], shift }
    }

    /// Marks a cell as occupied.
    #[inline]
    pub(crate) fn occupy(&mut self, cell: u64) {
        let stretch = &mut self.stretches[(cell >> self.shift) as usize];
        // The condition is seldom true. A store that is skipped does not delay the next load.
        if cell < stretch.first {
            stretch.first = cell;
        }
        if cell > stretch.last {
            stretch.last = cell;
        }
    }

    /// Numbers the occupied cells. Call it after the last [`AxisMap::occupy`] and before the first look-up.
    pub(crate) fn number(&mut self) {
        self.cells = 0;
        for stretch in self.stretches.iter_mut().filter(|stretch| stretch.first != u64::MAX) {
            stretch.number = self.cells;
            self.cells += stretch.last - stretch.first + 1;
        }
    }

    /// How many numbers are in use.
    pub(crate) fn cells(&self) -> u64 {
        self.cells
    }

    /// The number of an occupied cell; ascending with the cell.
    #[inline]
    pub(crate) fn map(&self, cell: u64) -> u64 {
        let stretch = &self.stretches[(cell >> self.shift) as usize];
        stretch.number + (cell - stretch.first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(cells: u64, occupied: impl IntoIterator<Item = u64>) -> AxisMap {
        let mut map = AxisMap::new(cells);
        occupied.into_iter().for_each(|cell| map.occupy(cell));
        map.number();
        map
    }

    #[test]
    fn numbers_ascend_with_the_cells_and_skip_what_is_empty() {
        let occupied = [0, 1, 5, 70, 1_000_000_000, 1_000_000_003];
        let map = map(1_000_000_004, occupied);
        assert_eq!(map.cells(), 71 + 4);
        let numbers = occupied.map(|cell| map.map(cell));
        assert_eq!(numbers, [0, 1, 5, 70, 71, 74]);
    }

    #[test]
    fn a_full_axis_is_left_as_it_is() {
        let map = map(5000, 0..5000);
        assert_eq!(map.cells(), 5000);
        assert!((0..5000).all(|cell| map.map(cell) == cell));
    }
}
