//! The C-grid, for bodies that span many cells: bodies enter and leave lists.

mod levels;
mod lists;
mod spans;

use crate::compiled::compiled;
use crate::couple::Couple;
use crate::elements::Elements;
use crate::error::Error;
use crate::memory::reserve;
use crate::real::Real;
use crate::search::Search;
use crate::search::level::Level;
use crate::stop::Stop;

use levels::Levels;
use lists::{Bodies, Cells, Counted};
use spans::Spans;

/// The C-grid of Williams, Perkins and Cook: bodies of any size and shape, each in all cells that its
/// bounding box covers.
///
/// The search walks slab by slab along the last axis. Bodies enter a singly connected list in the slab where
/// their bounding boxes begin ("In") and leave it after the slab where these end ("Out"). The list of a slab
/// is spread in the same way along the next axis, and so on, down to the list of a cell: one sub-divider,
/// nested once per dimension. Bodies that share a cell are compared. Bodies that share several cells are
/// compared in one of them only: on each axis, the cell of the larger of their minimum corners. Therefore no
/// table of couples is needed:
/// ```text
///       . _______ .     a enters before b on either axis:
///    ____|b  .   |.     they are compared in the cell o,
/// . |a . | o     |.     where b enters on both.
/// . |____|_______|.
/// ```
/// Slabs in which no body enters are left out, so nothing runs over empty cells, and no array has an entry
/// per cell. Neither time nor memory depends on the size of the domain.
///
/// # Levels
/// A body covers at most `5^D` cells (125 from 3D on), averaged over its possible positions: the number of
/// cells that a cube of four cell edges covers, or a longer and thinner box. A body that would cover more
/// moves to the level above, whose cells are 4 times as wide. A level is searched together with all finer
/// bodies that overlap the joint bounds of its own bodies, in its cells; of two bodies compared there, at
/// least one belongs to the level. The cells of the first level follow the median of the elements. If a class
/// of sizes has at most 64 elements, they join the level above instead of forming a level. Wider cells are
/// used where elements are so sparse that this takes less time.
///
/// # Order
/// Level by level, the smallest bodies first; inside a level cell by cell, in ascending order. The order is a
/// function of the input alone.
///
/// # Cost
/// Time proportional to N L for L levels, if the number of bounding boxes that share a cell is bounded. There
/// is at most one level per factor of 4 between the largest and the smallest size. A body makes at most `5^D`
/// (125) entries in each of its level and those above, and is tested in these cells. The bound fails where
/// cells are crowded: n bodies in one place all touch, which takes n² / 2 tests. The same number is made for
/// long thin boxes that lie crosswise in a cell without touching, and for points in one cell without size.
/// Memory: 140 to 170 bytes per element in 3D and `f64`, whatever elements span ([`CGrid::bytes`]). Runs on
/// one thread without vector instructions.
///
/// # Source
/// J.R. Williams, E. Perkins, B. Cook, "A contact algorithm for partitioning N arbitrary sized objects",
/// Engineering Computations 21 (2004) 235-248, according to the summary in its abstract and in A. Munjiza,
/// "The Combined Finite-Discrete Element Method", Wiley 2004, pp. 128-129. Published are: bodies that span
/// several cells; lists that bodies enter and leave at the minimum and maximum of their bounding boxes; the
/// sub-divider per axis, so that the dimension is a depth of nesting; time and memory linear in N. Our own
/// are: the order of the lists, which lets bodies enter without a search; the rule for the cell that reports
/// a couple; levels and cell sizes; leaving out slabs.
///
/// # Example
/// ```
/// use fdem_contact::{CGrid, Elements, Search};
///
/// // A bar that crosses 1000 plates.
/// let mut min: Vec<[f64; 2]> = (0..1000).map(|k| [f64::from(k), -5.0]).collect();
/// let mut max: Vec<[f64; 2]> = (0..1000).map(|k| [f64::from(k) + 0.5, 5.0]).collect();
/// min.push([-1.0, 0.0]);
/// max.push([1001.0, 0.1]);
/// let elements = Elements::boxes(&min, &max)?;
/// assert_eq!(CGrid::new().count(&elements)?, 1000);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CGrid<T, const D: usize> {
    bodies: Bodies<T, D>,
    /// The level of each element; empty if there is only one level.
    level_of: Vec<u16>,
    counted: Counted,
    stop: Stop,
}

impl<T: Real, const D: usize> Default for CGrid<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> CGrid<T, D> {
    /// A search that holds no memory yet.
    pub fn new() -> Self {
        Self {
            bodies: Bodies::new(),
            level_of: Vec::new(),
            counted: Counted::default(),
            stop: Stop::default(),
        }
    }

    /// Returns the search with a signal that stops it.
    pub(crate) fn stopped_by(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// The levels that a search over `elements` would use, the smallest elements first.
    ///
    /// # Cost
    /// Two passes over the elements.
    pub fn levels(&self, elements: &Elements<'_, T, D>) -> Vec<Level> {
        if elements.is_empty() {
            return Vec::new();
        }
        Levels::new(Spans::new(elements)).each().to_vec()
    }

    /// The same with the predicted time of the search in nanoseconds. `None` unless most elements are boxes
    /// several times longer than wide, and the time is less than `limit`.
    pub(crate) fn levels_for_long_boxes(
        elements: &Elements<'_, T, D>,
        limit: f64,
    ) -> Option<(Vec<Level>, f64)> {
        let spans = Spans::new(elements);
        if Levels::<T, D>::least_cost(elements.len()) >= limit || !spans.are_long_boxes() {
            return None;
        }
        let levels = Levels::new(spans);
        (levels.cost() < limit).then(|| (levels.each().to_vec(), levels.cost()))
    }

    /// Bytes that the engine holds now.
    pub fn bytes(&self) -> usize {
        self.bodies.bytes() + self.level_of.capacity() * size_of::<u16>()
    }

    /// The value of [`CGrid::bytes`] after a search over `elements`.
    pub(crate) fn expected_bytes(&self, elements: &Elements<'_, T, D>) -> usize {
        let n = elements.len();
        let numbers = if self.levels(elements).len() > 1 { n * size_of::<u16>() } else { 0 };
        Bodies::<T, D>::expected_bytes(elements, n) + numbers
    }

    /// Number of entries that the latest search made in lists of slabs and cells, on all axes. It grows with
    /// the number of cells that bodies cover.
    pub fn entries(&self) -> u64 {
        self.counted.entries
    }

    /// Number of tests of two bodies that the latest search made. It grows with the number of bodies that
    /// share a cell.
    pub fn tests(&self) -> u64 {
        self.counted.tests
    }

    /// Collects the bodies of a level, and the finer bodies that overlap their joint bounds.
    fn fill(&mut self, levels: &Levels<'_, '_, T, D>, level: u16) {
        let Self { bodies, level_of, .. } = self;
        let spans = levels.spans();
        if level_of.is_empty() {
            bodies.fill((0..spans.elements().len() as u32).map(|number| (number, true)));
            return;
        }
        let mut joint = [[f64::INFINITY, f64::NEG_INFINITY]; D];
        let own = level_of.iter().enumerate().filter(|&(_, &of)| of == level);
        for (index, _) in own {
            for (axis, [low, high]) in joint.iter_mut().enumerate() {
                let [own_low, own_high] = spans.span(index, axis);
                (*low, *high) = (low.min(own_low), high.max(own_high));
            }
        }
        let overlaps = |index| {
            (0..D).all(|axis| {
                let [low, high] = spans.span(index, axis);
                low <= joint[axis][1] && joint[axis][0] <= high
            })
        };
        let numbers = level_of.iter().enumerate();
        let near = numbers.filter(|&(index, &of)| of == level || (of < level && overlaps(index)));
        bodies.fill(near.map(|(index, &of)| (index as u32, of == level)));
    }
}

impl<T: Real, const D: usize> Search<T, D> for CGrid<T, D> {
    fn for_each(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        search(self, elements, &mut visit)
    }
}

compiled!(fn search = CGrid<T, D>, CGrid<f64, 2>, CGrid<f64, 3>: all(&mut dyn FnMut(Couple)));

impl<T: Real, const D: usize> CGrid<T, D> {
    fn all(&mut self, elements: &Elements<'_, T, D>, visit: &mut dyn FnMut(Couple)) -> Result<(), Error> {
        self.counted = Counted::default();
        if elements.is_empty() {
            return Ok(());
        }
        let levels = Levels::new(Spans::new(elements));
        let (each, n) = (levels.each(), elements.len());
        self.level_of.clear();
        if each.len() > 1 {
            reserve(&mut self.level_of, n)?;
            self.level_of.extend((0..n).map(|index| levels.level_of(index)));
        }
        self.bodies.reserve(elements, n)?;
        for (number, level) in (0..).zip(each) {
            self.fill(&levels, number);
            let cells = Cells { origin: levels.origin(), inverse: 1.0 / level.cell_size };
            self.bodies.sort(levels.spans(), &cells);
            let counted = self.bodies.search(elements, &self.stop, visit)?;
            self.counted.entries += counted.entries;
            self.counted.tests += counted.tests;
        }
        Ok(())
    }
}
