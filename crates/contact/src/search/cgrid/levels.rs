//! The cells of each level, and which elements are handed to the level above.

use std::f64::consts::SQRT_2;

use crate::elements::Shape;
use crate::real::Real;
use crate::search::cgrid::spans::Spans;
use crate::search::multilevel::Level;

/// Axes along which lists are nested: of more the first ones, which is enough to tell elements apart.
pub(super) const MOST_AXES: usize = 16;

/// Each class of sizes has cells 4 times as wide as the class below. There are so many below and above the one of usual sizes: all there can be of lengths from
/// `2^-500` to `2^501`.
const CLASSES_BELOW: i32 = 504;
const CLASSES: usize = 1009;

/// A class of so few elements is not worth lists of its own: it takes at most half as many tests of each with its like.
const FEW: usize = 64;

/// More cells than this on an axis take longer to sort and separate nothing.
const MOST_CELLS: f64 = 17_592_186_044_416.0;

/// Elements from which the cost of cells is judged.
const SAMPLE: usize = 32;

/// How many times wider than those of their class the cells of a level may be.
const WIDER: [f64; 7] = [1.0, SQRT_2, 2.0, 2.0 * SQRT_2, 4.0, 4.0 * SQRT_2, 8.0];

/// In nanoseconds on a processor of 2023; only their ratios matter: to sort an element, to list it in a cell, to test two.
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
    /// Cells of the class of usual sizes, for an element that covers as many as it may.
    usual: f64,
    /// Ends of all elements.
    low: [f64; D],
    high: [f64; D],
}

/// Elements of a class, and the widths of some of them.
#[derive(Clone, Debug)]
struct Class<const D: usize> {
    elements: usize,
    smallest: f64,
    largest: f64,
    /// Of every so many elements the widths are kept.
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

/// Cells that an element may cover: those of a cube of four edges, up to 3D; a longer one may cover as many.
fn most_cells<const D: usize>() -> f64 {
    [5.0, 25.0, 125.0][D.min(3) - 1]
}

/// Cells of an edge that an element covers, on average over where it is.
fn cover<const D: usize>(widths: &[f64; D], edge: f64) -> f64 {
    widths.iter().take(MOST_AXES).map(|width| width / edge + 1.0).product()
}

fn longest<const D: usize>(widths: &[f64; D]) -> f64 {
    widths.iter().take(MOST_AXES).fold(0.0, |longest, &width| f64::max(longest, width))
}

/// About the smallest cells of which an element covers no more than it may.
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
        // Of equal elements one speaks for all, but for where they end.
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

    /// Nanoseconds that the search is predicted to take, were the elements spread evenly.
    pub(super) fn cost(&self) -> f64 {
        self.cost
    }

    /// What it is for any elements, from below.
    pub(super) fn least_cost(elements: usize) -> f64 {
        elements as f64 * (SORT + ENTRY)
    }

    pub(super) fn each(&self) -> &[Level] {
        &self.each
    }

    pub(super) fn spans(&self) -> Spans<'e, 'a, T, D> {
        self.spans
    }

    /// Where the cells begin.
    pub(super) fn origin(&self) -> [f64; D] {
        self.low
    }

    /// The level of an element.
    pub(super) fn level_of(&self, index: usize) -> u16 {
        if self.each.len() == 1 { 0 } else { self.level_of[self.class(&self.spans.widths(index))] }
    }

    /// Cells of a class.
    fn edge(&self, class: usize) -> f64 {
        // 4 to the power of `class - CLASSES_BELOW`, by its bits.
        self.usual * f64::from_bits((2 * class as u64 + 15) << 52)
    }

    /// The first class with cells of which an element covers no more than it may.
    fn class(&self, widths: &[f64; D]) -> usize {
        let most = most_cells::<D>();
        // At least that wide, for the longest edge alone.
        let ratio = (longest(widths) / (most - 1.0)).max(T::MIN_RESOLVED) / self.usual;
        let exponent = (ratio.to_bits() >> 52) as i32 - 1023;
        let class = exponent.div_euclid(2) + CLASSES_BELOW;
        let mut class = class.clamp(0, 2 * CLASSES_BELOW) as usize;
        while class + 1 < CLASSES && cover(widths, self.edge(class)) > most {
            class += 1;
        }
        class
    }

    /// Makes levels of the classes that have elements.
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
                // The finer elements are sorted too, and listed once or twice.
                let finer = self.each.iter().map(|level| level.elements as f64).sum::<f64>();
                self.cost += cost + finer * (SORT + 2.0 * ENTRY);
                let Class { elements, smallest, largest, .. } = class;
                self.each.push(Level { elements, smallest, largest, cell_size });
            }
        }
    }

    /// The time for a level, and its cells: those of its class, or wider ones, of which elements cover fewer, if that takes less time.
    fn cell_size(&self, edge: f64, class: &Class<D>) -> (f64, f64) {
        let widest = (0..D).map(|axis| self.high[axis] - self.low[axis]).fold(0.0, f64::max);
        let least = T::MIN_RESOLVED.max(widest / MOST_CELLS);
        let mut best = (f64::INFINITY, 0.0);
        for wider in WIDER {
            let edge = (edge * wider).max(least);
            let cost = self.cost_of(edge, class);
            // Where costs are beyond floats, any will do.
            if cost < best.0 || best.1 == 0.0 {
                best = (cost, edge);
            }
        }
        best
    }

    /// The time for the elements of a level among themselves, were they spread evenly.
    fn cost_of(&self, edge: f64, class: &Class<D>) -> f64 {
        let n = class.elements as f64;
        // Where elements are, not where they end: one that covers all says nothing of the room that others have.
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
