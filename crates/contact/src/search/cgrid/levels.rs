//! The cells of each level, and which elements move to the level above.

use std::f64::consts::SQRT_2;

use crate::elements::Shape;
use crate::real::Real;
use crate::search::cgrid::spans::Spans;
use crate::search::level::Level;

/// Largest number of axes along which lists are nested. In higher dimensions the first ones are used, which
/// separate elements well enough.
pub(super) const MOST_AXES: usize = 16;

/// Number of classes of sizes below and above the usual one. Each class has cells 4 times as wide as the
/// class below. This covers all lengths from `2^-500` to `2^501`.
const CLASSES_BELOW: i32 = 504;
const CLASSES: usize = 1009;

/// A class with at most this number of elements does not pay for separate lists: it makes at most half as
/// many tests of each element with its like.
const FEW: usize = 64;

/// With more cells than this on an axis, sorting takes longer and no more elements are separated.
const MOST_CELLS: f64 = 17_592_186_044_416.0;

/// Number of elements in the sample from which the cost of cells is estimated.
const SAMPLE: usize = 32;

/// Factors by which the cells of a level may be wider than those of its class.
const WIDER: [f64; 7] = [1.0, SQRT_2, 2.0, 2.0 * SQRT_2, 4.0, 4.0 * SQRT_2, 8.0];

/// Costs in nanoseconds on a processor of 2023; only their ratios matter. To sort an element; then to list it
/// in a cell, and to test two elements.
const SORT: f64 = 150.0;
const ENTRY: f64 = 15.0;
const TEST: f64 = 8.0;

/// The levels of a set of elements.
pub(super) struct Levels<'e, 'a, T, const D: usize> {
    spans: Spans<'e, 'a, T, D>,
    each: Vec<Level>,
    cost: f64,
    /// The level of each class.
    level_of: Vec<u16>,
    /// Edge of the cells of the usual class, for an element that covers the allowed number of cells.
    usual: f64,
    /// The smallest lower ends of all elements, axis by axis; then the largest upper ends.
    low: [f64; D],
    high: [f64; D],
}

/// The elements of a class, and the widths of a sample of them.
#[derive(Clone, Debug)]
struct Class<const D: usize> {
    elements: usize,
    smallest: f64,
    largest: f64,
    /// Every `stride`-th element is in the sample.
    stride: usize,
    widths: Vec<[f64; D]>,
}

impl<const D: usize> Class<D> {
    const EMPTY: Self =
        Self { elements: 0, smallest: f64::INFINITY, largest: 0.0, stride: 1, widths: Vec::new() };

    fn add(&mut self, elements: usize, size: f64, widths: [f64; D]) {
        if self.elements.is_multiple_of(self.stride) {
            if self.widths.len() == SAMPLE {
                self.stride *= 2;
                let mut place = 0;
                self.widths.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
            }
            if self.elements.is_multiple_of(self.stride) {
                self.widths.push(widths);
            }
        }
        self.elements += elements;
        self.smallest = self.smallest.min(size);
        self.largest = self.largest.max(size);
    }

    fn join(&mut self, other: Self) {
        self.elements += other.elements;
        self.smallest = self.smallest.min(other.smallest);
        self.largest = self.largest.max(other.largest);
        self.widths.extend(other.widths);
    }
}

/// Largest number of cells that an element may cover: that of a cube of four edges, up to 3D. Longer elements
/// may cover the same number.
fn most_cells<const D: usize>() -> f64 {
    [5.0, 25.0, 125.0][D.min(3) - 1]
}

/// Number of cells of an edge that an element covers, averaged over its positions.
fn cover<const D: usize>(widths: &[f64; D], edge: f64) -> f64 {
    widths.iter().take(MOST_AXES).map(|width| width / edge + 1.0).product()
}

fn longest<const D: usize>(widths: &[f64; D]) -> f64 {
    widths.iter().take(MOST_AXES).fold(0.0, |longest, &width| f64::max(longest, width))
}

/// The smallest edge, approximately, with which an element covers no more cells than allowed.
fn needed<const D: usize>(widths: &[f64; D]) -> f64 {
    let most = most_cells::<D>();
    // Below the normal numbers a product may be no larger than its factor.
    let mut edge = (longest(widths) / (most - 1.0)).max(f64::MIN_POSITIVE);
    while cover(widths, edge) > most {
        edge *= 1.25;
    }
    edge
}

impl<'e, 'a, T: Real, const D: usize> Levels<'e, 'a, T, D> {
    /// The levels of elements, of which there is at least one.
    pub(super) fn new(spans: Spans<'e, 'a, T, D>) -> Self {
        let elements = spans.elements();
        let n = elements.len();
        let few = n.min(2 * SAMPLE - 1);
        let mut sample: Vec<_> = (0..few).map(|k| needed(&spans.widths(k * n / few))).collect();
        sample.retain(|&edge| edge > T::MIN_RESOLVED);
        sample.sort_unstable_by(f64::total_cmp);
        let usual = sample.get(sample.len() / 2).map_or(1.0, |median| 2.0 * median);
        let mut levels = Self {
            spans,
            each: Vec::new(),
            cost: 0.0,
            level_of: Vec::new(),
            usual,
            low: [f64::INFINITY; D],
            high: [f64::NEG_INFINITY; D],
        };

        let mut classes = vec![Class::<D>::EMPTY; CLASSES];
        // Equal elements differ only in where they end, so one of them represents all.
        let each = if matches!(elements.shape, Shape::Equal(_)) { n } else { 1 };
        for index in 0..n {
            for axis in 0..D {
                let [low, high] = spans.span(index, axis);
                levels.low[axis] = levels.low[axis].min(low);
                levels.high[axis] = levels.high[axis].max(high);
            }
            if each == 1 || index == 0 {
                let widths = spans.widths(index);
                classes[levels.class(&widths)].add(each, elements.size(index), widths);
            }
        }
        levels.choose(classes);
        levels
    }

    /// The predicted time of the search in nanoseconds, assuming that elements are spread evenly.
    pub(super) fn cost(&self) -> f64 {
        self.cost
    }

    /// Lower bound on [`Levels::cost`] for any elements.
    pub(super) fn least_cost(elements: usize) -> f64 {
        elements as f64 * (SORT + ENTRY)
    }

    pub(super) fn each(&self) -> &[Level] {
        &self.each
    }

    pub(super) fn spans(&self) -> Spans<'e, 'a, T, D> {
        self.spans
    }

    /// The corner where the cells begin.
    pub(super) fn origin(&self) -> [f64; D] {
        self.low
    }

    /// The level of an element.
    pub(super) fn level_of(&self, index: usize) -> u16 {
        if self.each.len() == 1 { 0 } else { self.level_of[self.class(&self.spans.widths(index))] }
    }

    /// The edge of the cells of a class.
    fn edge(&self, class: usize) -> f64 {
        // 4 to the power of `class - CLASSES_BELOW`, from its bits.
        self.usual * f64::from_bits((2 * class as u64 + 15) << 52)
    }

    /// The first class whose cells are so wide that an element covers no more of them than allowed.
    fn class(&self, widths: &[f64; D]) -> usize {
        let most = most_cells::<D>();
        // Lower bound on the edge, from the longest edge of the element alone.
        let ratio = (longest(widths) / (most - 1.0)).max(T::MIN_RESOLVED) / self.usual;
        let exponent = (ratio.to_bits() >> 52) as i32 - 1023;
        let class = exponent.div_euclid(2) + CLASSES_BELOW;
        let mut class = class.clamp(0, 2 * CLASSES_BELOW) as usize;
        while class + 1 < CLASSES && cover(widths, self.edge(class)) > most {
            class += 1;
        }
        class
    }

    /// Makes levels from the classes that have elements.
    fn choose(&mut self, classes: Vec<Class<D>>) {
        let mut above = classes.iter().map(|class| class.elements).sum::<usize>();
        let mut waiting = Class::EMPTY;
        for (number, mut class) in classes.into_iter().enumerate() {
            self.level_of.push(self.each.len() as u16);
            if class.elements == 0 {
                continue;
            }
            above -= class.elements;
            class.join(std::mem::replace(&mut waiting, Class::EMPTY));
            if class.elements <= FEW && above > 0 {
                waiting = class;
            } else {
                let (cost, cell_size) = self.cell_size(self.edge(number), &class);
                // The finer elements are sorted too, and each is listed once or twice.
                let finer = self.each.iter().map(|level| level.elements as f64).sum::<f64>();
                self.cost += cost + finer * (SORT + 2.0 * ENTRY);
                let Class { elements, smallest, largest, .. } = class;
                self.each.push(Level { elements, smallest, largest, cell_size });
            }
        }
    }

    /// The predicted time for a level and the edge of its cells: that of its class, or a wider one if that
    /// takes less time because elements cover fewer cells.
    fn cell_size(&self, edge: f64, class: &Class<D>) -> (f64, f64) {
        let widest = (0..D).map(|axis| self.high[axis] - self.low[axis]).fold(0.0, f64::max);
        let least = T::MIN_RESOLVED.max(widest / MOST_CELLS);
        let mut best = (f64::INFINITY, 0.0);
        for wider in WIDER {
            let edge = (edge * wider).max(least);
            let cost = self.cost_of(edge, class);
            // If no cost fits into a float, any edge will do.
            if cost < best.0 || best.1 == 0.0 {
                best = (cost, edge);
            }
        }
        best
    }

    /// The predicted time for the elements of a level among themselves, assuming that they are spread evenly.
    fn cost_of(&self, edge: f64, class: &Class<D>) -> f64 {
        let n = class.elements as f64;
        // The bounds of the anchors, not of the ends: an element that covers everything says nothing about
        // the space that the others have.
        let bounds = self.spans.elements().bounds();
        let (mut entries, mut tests) = (0.0, 0.0);
        for (k, one) in class.widths.iter().enumerate() {
            entries += cover(one, edge);
            for two in &class.widths[k..] {
                tests += (0..D.min(MOST_AXES))
                    .map(|axis| {
                        let extent = (bounds.max[axis] - bounds.min[axis]).max(edge);
                        ((one[axis] + two[axis] + edge) / extent).min(1.0)
                    })
                    .product::<f64>();
            }
        }
        let kept = class.widths.len() as f64;
        let pairs = kept * (kept + 1.0) / 2.0;
        n * (SORT + ENTRY * entries / kept) + TEST * n * n / 2.0 * tests / pairs
    }
}
