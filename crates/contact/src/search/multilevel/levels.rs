//! The choice of levels by a model of the cost of a search.

use crate::elements::{Bounds, Elements, Shape};
use crate::grid::{Grid, edge_for};
use crate::real::Real;
use crate::search::level::Level;
use crate::search::rows::scan::PART;

/// Costs in nanoseconds on a processor of 2023; only their ratios matter. `SORT`: to sort one element.
const SORT: f64 = 25.0;
/// Within one level: to start a window on a row, and, below, to test one element in it.
const WINDOW: f64 = 4.0;
const CANDIDATE: f64 = 0.4;
/// To find a row near another one, and the place to begin in it.
const PAIR_OF_ROWS: f64 = 60.0;
const PAIR_OF_LEVELS: f64 = 5_000.0;

/// The same costs between two levels, whose elements are seldom in cache.
struct AcrossLevels {
    window: f64,
    candidate: f64,
    pair_of_rows: f64,
    /// The width of the region that an element searches from, as a fraction of the width of its row, if there
    /// are several elements in the row.
    width: f64,
}

/// Each sphere searches for the rows near it.
const SPHERES: AcrossLevels = AcrossLevels { window: 25.0, candidate: 0.5, pair_of_rows: 0.0, width: 0.0 };

/// Boxes that are near each other find rows together.
const BOXES: AcrossLevels =
    AcrossLevels { window: 8.0, candidate: 1.0, pair_of_rows: PAIR_OF_ROWS, width: 1.0 };

/// The predicted time per element among elements of one size.
const USUAL: f64 = 40.0;

/// Average number of elements in a cell where they are too sparse to fill cells of their size.
const THIN: f64 = 1.0;

/// The known properties of the elements, and the predicted time of a search among them.
pub(super) struct Model<'e, 'a, T, const D: usize> {
    elements: &'e Elements<'a, T, D>,
    bounds: Bounds<D>,
    extents: [f64; D],
    /// The level of each class of sizes.
    level_of: Vec<u16>,
    levels: Vec<Level>,
}

/// The class of a size. There are two classes per octave, given by the exponent and the first bit of the
/// fraction.
fn class(size: f64) -> usize {
    (size.to_bits() >> 51) as usize
}

/// Number of classes; sizes are not negative.
const CLASSES: usize = 1 << 12;

impl<'e, 'a, T: Real, const D: usize> Model<'e, 'a, T, D> {
    pub(super) fn new(elements: &'e Elements<'a, T, D>, limits: Option<&[f64]>) -> Self {
        let mut counts = vec![(0, f64::INFINITY, 0.0_f64); CLASSES];
        // Equal elements are counted once, all together.
        let each = if matches!(elements.shape, Shape::Equal(_)) { elements.len() } else { 1 };
        for index in (0..elements.len()).step_by(each.max(1)) {
            let size = elements.size(index);
            let (count, smallest, largest) = &mut counts[class(size)];
            *count += each;
            *smallest = smallest.min(size);
            *largest = largest.max(size);
        }
        let bounds = elements.bounds();
        let extents = std::array::from_fn(|axis| bounds.max[axis] - bounds.min[axis]);
        let mut model = Self { elements, bounds, extents, level_of: Vec::new(), levels: Vec::new() };
        let classes = counts.iter().filter(|(count, ..)| *count > 0);
        model.levels =
            classes.map(|&(count, smallest, largest)| model.level(count, smallest, largest)).collect();
        match limits {
            None => model.merge(),
            Some(limits) => model.merge_between(limits),
        }
        let mut level = 0;
        for (count, smallest, _) in counts {
            level += usize::from(
                count > 0 && level + 1 < model.levels.len() && smallest > model.levels[level].largest,
            );
            model.level_of.push(level as u16);
        }
        model
    }

    pub(super) fn levels(&self) -> &[Level] {
        &self.levels
    }

    pub(super) fn level_of(&self, size: f64) -> usize {
        self.level_of[class(size)].into()
    }

    fn level(&self, elements: usize, smallest: f64, largest: f64) -> Level {
        let reach = self.elements.reach_between(largest, largest);
        let thin = edge_for(&self.bounds, elements as f64 / THIN).unwrap_or(0.0);
        let cell_size = Grid::for_reach::<T>(self.bounds, reach, thin).cell_size();
        Level { elements, smallest, largest, cell_size }
    }

    /// The grid of a level.
    pub(super) fn grid(&self, level: &Level) -> Grid<D> {
        Grid::with_cell_size(self.bounds.min, self.bounds.max, level.cell_size)
    }

    /// The largest distance along an axis between touching elements of the two levels.
    pub(super) fn reach(&self, level: &Level, other: &Level) -> f64 {
        self.elements.reach_between(level.largest, other.largest)
    }

    /// Merges neighbouring levels as long as that saves time.
    fn merge(&mut self) {
        loop {
            let mut best = (0.0, None);
            for k in 1..self.levels.len() {
                let (one, two) = (self.levels[k - 1], self.levels[k]);
                let both = self.level(one.elements + two.elements, one.smallest, two.largest);
                let mut saved =
                    self.cost(&one) + self.cost(&two) + self.cost_of(&one, &two) - self.cost(&both);
                for other in self.levels[..k - 1].iter().chain(&self.levels[k + 1..]) {
                    saved +=
                        self.cost_of(&one, other) + self.cost_of(&two, other) - self.cost_of(&both, other);
                }
                if saved > best.0 {
                    best = (saved, Some((k, both)));
                }
            }
            let Some((k, both)) = best.1 else { break };
            self.levels[k - 1] = both;
            self.levels.remove(k);
        }
        // Merging only two levels at a time can end in a local optimum where merging all together would save
        // time.
        let [first, .., last] = self.levels[..] else { return };
        let all = self.level(self.elements.len(), first.smallest, last.largest);
        if self.cost(&all) <= self.total() {
            self.levels = vec![all];
        }
    }

    /// Merges all levels that lie between the same limits.
    fn merge_between(&mut self, limits: &[f64]) {
        let place = |level: &Level| limits.iter().filter(|&&limit| level.smallest > limit).count();
        let groups = self.levels.chunk_by(|one, two| place(one) == place(two)).map(|group| {
            let count = group.iter().map(|level| level.elements).sum();
            self.level(count, group[0].smallest, group[group.len() - 1].largest)
        });
        self.levels = groups.collect();
    }

    /// The predicted time of the whole search, in nanoseconds.
    pub(super) fn total(&self) -> f64 {
        let pairs = self
            .levels
            .iter()
            .enumerate()
            .flat_map(|(k, one)| self.levels[k + 1..].iter().map(move |two| self.cost_of(one, two)));
        pairs.sum::<f64>() + self.levels.iter().map(|level| self.cost(level)).sum::<f64>()
    }

    /// Predicted number of windows that elements of one level open on rows of another (half of them within
    /// one level), and of elements in these windows.
    pub(super) fn work(&self, level: &Level, other: Option<&Level>) -> [f64; 2] {
        let (windows, other) = match other {
            None => (self.rows_around(level, 2.0 * level.cell_size).midpoint(1.0), level),
            Some(other) => (self.windows(level, other), other),
        };
        let candidates = 2.0 * self.reach(level, other) * windows * self.along_rows(other);
        [windows, candidates].map(|each| each * level.elements as f64)
    }

    /// The predicted time to sort a level and to compare it with itself.
    fn cost(&self, level: &Level) -> f64 {
        let reach = self.reach(level, level);
        let n = level.elements as f64;
        // Half of the windows around an element, and half of the window in its own row.
        let windows = self.rows_around(level, 2.0 * level.cell_size).midpoint(1.0);
        let candidates = 2.0 * reach * windows * self.along_rows(level);
        n * (SORT + windows * WINDOW + candidates * CANDIDATE)
            + self.rows(level) * windows * PAIR_OF_ROWS
            + PAIR_OF_LEVELS
    }

    /// The predicted time to compare two levels.
    fn cost_of(&self, one: &Level, two: &Level) -> f64 {
        self.cost_to_look(one, two).min(self.cost_to_look(two, one))
    }

    /// Whether the elements of the first level look for those of the second, because that takes less time
    /// than the reverse.
    pub(super) fn looks(&self, level: &Level, other: &Level) -> bool {
        self.cost_to_look(level, other) <= self.cost_to_look(other, level)
    }

    fn cost_to_look(&self, level: &Level, other: &Level) -> f64 {
        level.elements as f64 * self.cost_of_element(level, other)
            + self.rows(level) * self.windows(level, other) * self.across().pair_of_rows
            + PAIR_OF_LEVELS
    }

    /// The predicted time for one element of a level to look for those of another.
    fn cost_of_element(&self, level: &Level, other: &Level) -> f64 {
        let windows = self.windows(level, other);
        let candidates = 2.0 * self.reach(level, other) * windows * self.along_rows(other);
        let AcrossLevels { window, candidate, .. } = self.across();
        windows * window + candidates * candidate
    }

    fn across(&self) -> &'static AcrossLevels {
        if matches!(self.elements.shape, Shape::Boxes(_)) { &BOXES } else { &SPHERES }
    }

    /// Number of rows of the other level near an element of this one.
    fn windows(&self, level: &Level, other: &Level) -> f64 {
        let several = 1.0 - self.rows(level) / level.elements as f64;
        let width = self.across().width * level.cell_size * several;
        self.rows_around(other, width + 2.0 * self.reach(level, other))
    }

    /// Number of elements of `level` per part of the search for those of `other`; all parts take about the
    /// same time.
    pub(super) fn part(&self, level: &Level, other: &Level) -> usize {
        let most = PART as f64;
        (most * USUAL / self.cost_of_element(level, other)).clamp(64.0, most) as usize
    }

    /// Number of rows of a level that hold elements.
    fn rows(&self, level: &Level) -> f64 {
        self.rows_around(level, f64::INFINITY).min(level.elements as f64)
    }

    /// Number of rows of a level that cross a square (cube, ...) with the given edge.
    fn rows_around(&self, level: &Level, edge: f64) -> f64 {
        let long = self.long();
        let short = self.extents.iter().enumerate().filter(|&(axis, _)| axis != long);
        short
            .map(|(_, extent)| (edge / level.cell_size).min((extent / level.cell_size).floor()) + 1.0)
            .product()
    }

    /// Elements per unit length of a row.
    fn along_rows(&self, level: &Level) -> f64 {
        let length = self.extents[self.long()].max(level.cell_size);
        level.elements as f64 / (self.rows_around(level, f64::INFINITY) * length)
    }

    /// The axis along the rows.
    fn long(&self) -> usize {
        (0..D).fold(0, |long, axis| if self.extents[axis] > self.extents[long] { axis } else { long })
    }
}
