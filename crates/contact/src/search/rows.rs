//! NBS on contiguous memory: sorted rows, a moving window, and vectors.

mod axis;
mod buckets;
mod layout;
mod row_sort;

use crate::couple::Couple;
use crate::elements::{Elements, Geometry, Shape};
use crate::error::Error;
use crate::grid::Grid;
use crate::real::Real;
use crate::search::{Search, make_room};
use crate::simd::kernel::{Neighbour, Output, Span, Task};
use crate::simd::{Simd, portable};

use layout::Layout;

/// The decomposition and the contact mask of Munjiza-NBS, on sorted rows instead of lists: the default engine.
///
/// Elements are sorted by row of cells and, inside a row, by coordinate along it, the axis with the most cells. The lists of NBS
/// become runs of contiguous memory; rows without elements do not exist. A row is compared with itself and with the half mask of neighbour
/// rows (1 in 2D, 4 in 3D, `(3^(D-1) - 1)/2`). Because rows are sorted, an element's candidates in a neighbour row
/// are one window, whose lower end only moves forward; vectors of coordinates are tested at once, with
/// AVX-512, AVX2 or NEON where the processor has them. All levels give the same couples in the same order.
/// ```text
///   row below   . . [ x x x x x ] . . .      |x_j - x_i| <= reach
///   own row     . . . . i [ x x x ] . .      j > i
/// ```
///
/// # Order
/// Rows ascend by cell, the axis with the most cells left out; elements ascend along their row; the partners of an element are first those in
/// its own row, then those in the rows of the mask, each ascending. A function of the input alone.
///
/// # Cost
/// Time proportional to N for similar sizes: some tens of nanoseconds per element and core. Memory per
/// element: `D` coordinates, and the radius if there is one for each; 4 bytes of id; at most 4 of row start, 4 of row
/// number, 2 of row counts, or 16 to 20 for domains with more rows than elements. In 3D and `f64` 28 to 48 bytes, and 8 more
/// with radii. Nothing grows with the domain.
///
/// # Source
/// The decomposition: A. Munjiza, K.R.F. Andrews, Int. J. Numer. Meth. Engng 43 (1998) 131-149. Rows, windows and vectors are ours.
///
/// # Example
/// ```
/// use fdem_contact::{Elements, Rows, Search};
///
/// let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1e12]];
/// assert_eq!(Rows::new().count(&Elements::points(&centres, 1.0)?)?, 1);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rows<T, const D: usize> {
    layout: Layout<T, D>,
    /// Couples on their way to a visitor.
    visiting: Vec<Couple>,
    simd: Simd,
}

/// Couples that are handed to a visitor at once: they stay in the first-level cache.
const VISITED_AT_ONCE: usize = 1024;

impl<T: Real, const D: usize> Default for Rows<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> Rows<T, D> {
    /// A search that holds no memory yet, with the fastest instructions of this processor.
    pub fn new() -> Self {
        Self { layout: Layout::new(), visiting: Vec::new(), simd: Simd::best() }
    }

    /// The same with other vector instructions; the couples and their order are the same.
    ///
    /// # Errors
    /// [`Error::SimdUnavailable`] if this processor lacks them.
    pub fn with_simd(mut self, simd: Simd) -> Result<Self, Error> {
        if !simd.is_available() {
            return Err(Error::SimdUnavailable { simd });
        }
        self.simd = simd;
        Ok(self)
    }

    /// Bytes that the engine holds now.
    pub fn bytes(&self) -> usize {
        self.layout.bytes() + self.visiting.capacity() * size_of::<Couple>()
    }

    /// The cells that a search over `elements` would use.
    pub fn plan(&self, elements: &Elements<'_, T, D>) -> Grid<D> {
        Grid::unbounded(elements)
    }

    fn search(&mut self, elements: &Elements<'_, T, D>, out: &mut Output<'_>) -> Result<(), Error> {
        if elements.is_empty() {
            return Ok(());
        }
        let grid = self.plan(elements);
        let reach = T::at_least(elements.reach().max(T::MIN_RESOLVED));
        let mut scan =
            Scan { reach, reach_squared: T::ZERO, tolerance: elements.tolerance(), simd: self.simd };
        match elements.shape {
            Shape::Equal(equal) => {
                scan.reach_squared = equal.reach_squared();
                self.layout.build(equal.points(), &[], grid)?;
                scan.all_rows(&self.layout, out, |task, out| T::search(scan.simd, task, out));
            }
            Shape::Spheres(spheres) => {
                self.layout.build(spheres.points(), spheres.radii(), grid)?;
                scan.all_rows(&self.layout, out, |task, out| T::search(scan.simd, task, out));
            }
            Shape::Boxes(boxes) => {
                self.layout.build(boxes.points(), &[], grid)?;
                let ids = &self.layout.ids;
                scan.all_rows(&self.layout, out, |task, out| {
                    portable::scan(task, out, |row, k, other, j| {
                        boxes.touch(ids[row.start + k] as usize, ids[other.start + j] as usize)
                    });
                });
            }
        }
        Ok(())
    }
}

impl<T: Real, const D: usize> Search<T, D> for Rows<T, D> {
    fn for_each(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        let mut found = std::mem::take(&mut self.visiting);
        found.clear();
        layout::reserve(&mut found, VISITED_AT_ONCE)?;
        let mut hand_over = |found: &mut Vec<Couple>| found.drain(..).for_each(&mut visit);
        let mut out = Output { couples: &mut found, count: 0, count_only: false, make_room: &mut hand_over };
        self.search(elements, &mut out)?;
        hand_over(&mut found);
        self.visiting = found;
        Ok(())
    }

    fn couples(&mut self, elements: &Elements<'_, T, D>, couples: &mut Vec<Couple>) -> Result<(), Error> {
        couples.clear();
        layout::reserve(couples, VISITED_AT_ONCE)?;
        let mut room = Ok(());
        let mut grow = |found: &mut Vec<Couple>| {
            if room.is_ok() {
                room = make_room(found);
            }
            if room.is_err() {
                // The search goes on into memory that it has, and its result is refused.
                found.clear();
            }
        };
        self.search(elements, &mut Output { couples, count: 0, count_only: false, make_room: &mut grow })?;
        room.inspect_err(|_| couples.clear())
    }

    fn count(&mut self, elements: &Elements<'_, T, D>) -> Result<u64, Error> {
        let mut out = Output { couples: &mut Vec::new(), count: 0, count_only: true, make_room: &mut |_| {} };
        self.search(elements, &mut out)?;
        Ok(out.count)
    }
}

/// What a search over sorted rows needs besides them.
struct Scan<T> {
    reach: T,
    reach_squared: T,
    tolerance: T,
    simd: Simd,
}

impl<T: Real> Scan<T> {
    /// Calls `search` with every row and the rows of the contact mask that exist.
    fn all_rows<const D: usize>(
        &self,
        layout: &Layout<T, D>,
        out: &mut Output<'_>,
        search: impl Fn(&Task<'_, T, D>, &mut Output<'_>),
    ) {
        let span = |row: usize| {
            let row = layout.row(row);
            Span { start: row.start, len: row.len() }
        };
        let mut cursors: Vec<_> =
            half_mask::<D>().into_iter().map(|offset| Cursor::new(layout, offset)).collect();
        let mut neighbours = Vec::with_capacity(cursors.len());
        for row in 0..layout.rows() {
            let cells = layout.row_cells(row);
            neighbours.clear();
            for cursor in &mut cursors {
                if let Some(row) = cursor.find(layout, &cells) {
                    neighbours.push(Neighbour { row: span(row), low: 0 });
                }
            }
            let row = span(row);
            let task = Task {
                coordinates: &layout.coordinates,
                radii: &layout.radii,
                ids: &layout.ids,
                row,
                from: 0,
                to: row.len,
                neighbours: &neighbours,
                long: layout.axes[0],
                reach: self.reach,
                reach_squared: self.reach_squared,
                tolerance: self.tolerance,
            };
            search(&task, out);
        }
    }
}

/// Finds the row at one offset of the mask, for rows in ascending order: it only moves forward.
struct Cursor<const D: usize> {
    offset: [i64; D],
    row: usize,
    /// The cells of `row`; none past the last row.
    cells: Option<[i64; D]>,
}

impl<const D: usize> Cursor<D> {
    fn new<T: Real>(layout: &Layout<T, D>, offset: [i64; D]) -> Self {
        Self { offset, row: 0, cells: Some(layout.row_cells(0)) }
    }

    /// The row at `cells + offset`, if it exists. `cells` must not descend from call to call.
    fn find<T: Real>(&mut self, layout: &Layout<T, D>, cells: &[i64; D]) -> Option<usize> {
        let wanted: [i64; D] = std::array::from_fn(|k| cells[k] + self.offset[k]);
        while self.cells? < wanted {
            self.row += 1;
            self.cells = (self.row < layout.rows()).then(|| layout.row_cells(self.row));
        }
        (self.cells? == wanted).then_some(self.row)
    }
}

/// The offsets of the neighbour rows of the contact mask, most significant axis first; the long axis, last, is 0.
///
/// These are the offsets before zero in lexicographic order: each couple of neighbouring rows is met once.
fn half_mask<const D: usize>() -> Vec<[i64; D]> {
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
