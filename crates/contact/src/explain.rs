//! Predicts the cost of a search before it runs: cells, rows, memory and the expected number of couples.

use std::fmt::{self, Write};

use crate::elements::{Elements, Shape};
use crate::engine::Plan;
use crate::grid::{Grid, rows_of};
use crate::real::Real;
use crate::search::level::Level;
use crate::simd::Simd;
use crate::verify::split_mix;

/// Plan of a [`Detector`](crate::Detector) or a [`PeriodicSearch`](crate::PeriodicSearch) for a set of
/// elements, and the cost of the search. Its `Display` is text for a person.
///
/// # Example
/// ```
/// use fdem_contact::{Detector, Elements, Engine};
///
/// let centres: Vec<[f64; 2]> = (0..500).map(|k| [f64::from(k), 0.0]).collect();
/// let elements = Elements::points(&centres, 1.0)?;
/// let explanation = Detector::new().explain(&elements)?;
/// assert_eq!(explanation.couples, 499.0); // few elements: counted
/// assert_eq!(explanation.couples_error, 0.0);
/// println!("{explanation}");
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation<const D: usize> {
    /// The engine, the reason for it, and its cells.
    pub plan: Plan<D>,
    /// Number of elements.
    pub elements: usize,
    /// Exact number of periodic images that are searched in addition; `None` without a periodic box.
    pub images: Option<usize>,
    /// Number of rows of cells in the domain, including those without elements; `None` without cells. A
    /// float, because a wide domain has more rows than an integer can count.
    pub rows: Option<f64>,
    /// Upper bound on the number of rows that hold elements; only these cost anything. `None` without cells.
    pub occupied_rows: Option<u64>,
    /// Expected number of couples: an estimate from the neighbours of 1024 elements, or the exact number for
    /// up to 1024 elements.
    pub couples: f64,
    /// Standard error of `couples` from the scatter of the sample; 0 if the number is exact.
    pub couples_error: f64,
    /// Bytes that the engine will hold, including images and wrapped elements, without the caller's
    /// coordinates and couples. Exact for [`Nbs`](crate::Nbs). For [`Rows`](crate::Rows) an upper bound,
    /// unless most elements are in a few of many rows.
    pub bytes: usize,
    /// Bytes of a list of the expected couples. The spare capacity of a growing list, up to the same size
    /// again, is not included.
    pub list_bytes: f64,
    /// Threads that the engine will use.
    pub threads: usize,
    /// Vector instructions that the engine will use; `None` if it uses none.
    pub simd: Option<Simd>,
}

impl<const D: usize> Explanation<D> {
    pub(crate) fn new<T: Real>(
        plan: Plan<D>,
        elements: &Elements<'_, T, D>,
        means: Means,
        couples: Estimate,
        couple_size: usize,
    ) -> Self {
        let rows = plan.cells.as_ref().map(rows_of);
        Self {
            elements: elements.len(),
            images: None,
            rows,
            occupied_rows: rows.map(|rows| rows.min(elements.len() as f64) as u64),
            couples: couples.number,
            couples_error: couples.error,
            bytes: means.bytes,
            list_bytes: couples.number * couple_size as f64,
            threads: means.threads,
            simd: means.simd,
            plan,
        }
    }
}

/// The memory, threads and instructions of an engine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Means {
    pub(crate) bytes: usize,
    pub(crate) threads: usize,
    pub(crate) simd: Option<Simd>,
}

impl Means {
    /// The means of [`Engine::Direct`](crate::Engine::Direct).
    pub(crate) const NONE: Self = Self { bytes: 0, threads: 1, simd: None };
}

impl<const D: usize> fmt::Display for Explanation<D> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "engine    {}: {}", self.plan.engine, self.plan.reason)?;
        writeln!(out, "elements  {}", grouped(self.elements as f64))?;
        if let Some(images) = self.images {
            writeln!(out, "images    {}", grouped(images as f64))?;
        }
        if let (Some(edge), Some(cells)) = (self.plan.cell_size, self.plan.cells) {
            let cells: Vec<_> = cells.iter().map(|&cells| grouped(cells as f64)).collect();
            writeln!(out, "cells     {}, edge {edge:.6}", cells.join(" x "))?;
        }
        for level in &self.plan.levels {
            let (elements, Level { smallest, largest, cell_size, .. }) =
                (grouped(level.elements as f64), level);
            writeln!(
                out,
                "level     {elements} of size {smallest:.6} to {largest:.6}, edge of cells {cell_size:.6}"
            )?;
        }
        if let (Some(rows), Some(occupied)) = (self.rows, self.occupied_rows) {
            let occupied = grouped(occupied as f64);
            writeln!(out, "rows      {} of cells, at most {occupied} with elements", grouped(rows))?;
        }
        if self.couples_error == 0.0 {
            writeln!(out, "couples   {}", grouped(self.couples))?;
        } else {
            let (couples, error) = (grouped(self.couples), grouped(self.couples_error.ceil()));
            writeln!(out, "couples   about {couples}, standard error {error}")?;
        }
        let (engine, list) = (self.bytes as f64 / 1e6, self.list_bytes / 1e6);
        writeln!(out, "memory    {engine:.1} MB for the engine, {list:.1} MB for a list of the couples")?;
        write!(out, "threads   {}", self.threads)?;
        if let Some(simd) = self.simd {
            write!(out, ", {simd}")?;
        }
        writeln!(out)
    }
}

/// A number with grouped digits: `1234567` becomes `1,234,567`. Very large numbers become `1.2e20`.
fn grouped(number: f64) -> String {
    if number >= 1e18 {
        return format!("{number:.1e}");
    }
    let digits = format!("{number:.0}");
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        let comma = if k > 0 && (digits.len() - k).is_multiple_of(3) { "," } else { "" };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{digit}");
    }
    text
}

/// Number of elements whose neighbours are counted. Enough for an error of 1 % if all have about a dozen
/// neighbours.
const SAMPLE: usize = 1024;

/// Largest number of axes for the cells around an element: with more axes there would be more cells than
/// elements in them.
const AXES: usize = 3;

/// An expected number of couples and its standard error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    number: f64,
    error: f64,
}

/// The images around a set of elements in a periodic box.
pub(crate) trait Around<T, const D: usize> {
    /// The positions of the images.
    fn points(&self) -> &[[T; D]];

    /// Whether an element touches an image.
    fn touch(&self, element: usize, image: usize) -> bool;

    /// Whether this couple is the one to report of two couples that are images of each other.
    fn is_reported(&self, element: usize, image: usize) -> bool;
}

/// A set without images.
struct Nothing;

impl<T, const D: usize> Around<T, D> for Nothing {
    fn points(&self) -> &[[T; D]] {
        &[]
    }

    fn touch(&self, _: usize, _: usize) -> bool {
        false
    }

    fn is_reported(&self, _: usize, _: usize) -> bool {
        false
    }
}

impl Estimate {
    /// The expected couples of these elements.
    pub(crate) fn of<T: Real, const D: usize>(elements: &Elements<'_, T, D>) -> Self {
        Self::with_images(elements, elements.len(), Grid::unbounded(elements), &Nothing)
    }

    /// The expected couples of the first `n` elements with all elements and images. The cells hold
    /// everything, and touching elements are at most one cell apart. The neighbours of a sample of elements
    /// are counted exactly.
    ///
    /// The sample is one random element from each of 1024 stretches of equal length. Therefore elements that
    /// are numbered cluster by cluster or row by row are all represented, and no stride can coincide with the
    /// period of a lattice. The cells around the sampled elements go into a table. One pass over all elements
    /// and images looks up the cell of each and tests it against the sampled elements around it.
    ///
    /// Every couple is counted from both of its elements; an element that touches its own image has two
    /// neighbours. Therefore the number of neighbours is halved. If all elements are in the sample, couples
    /// across a face are counted as they are reported instead, because the two views may round differently.
    pub(crate) fn with_images<T: Real, const D: usize>(
        elements: &Elements<'_, T, D>,
        n: usize,
        grid: Grid<D>,
        around: &impl Around<T, D>,
    ) -> Self {
        if n == 0 {
            return Self { number: 0.0, error: 0.0 };
        }
        let sample = n.min(SAMPLE);
        let mut state = 0;
        let picked = (0..sample).map(|k| {
            let (from, to) = (k * n / sample, (k + 1) * n / sample);
            from + (split_mix(&mut state) % (to - from) as u64) as usize
        });
        let points = match elements.shape {
            Shape::Equal(equal) => equal.points(),
            Shape::Spheres(spheres) => spheres.points(),
            Shape::Boxes(boxes) => boxes.points(),
        };
        let points = &points[..n];
        let cells = ElementCells::new(grid);
        let table = CellTable::new(&cells, points, picked.collect());

        let mut counts = vec![0_u64; sample];
        for (j, point) in points.iter().enumerate() {
            let cell = cells.of(point);
            for entry in table.at(&cell) {
                let i = table.picked[entry.sampled as usize];
                if entry.cell == cell && i != j && elements.touch(i, j) {
                    counts[entry.sampled as usize] += 1;
                }
            }
        }
        let within = counts.iter().sum::<u64>();
        let mut reported = 0_u64;
        for (image, point) in around.points().iter().enumerate() {
            let cell = cells.of(point);
            for entry in table.at(&cell) {
                let i = table.picked[entry.sampled as usize];
                if entry.cell == cell && around.touch(i, image) {
                    counts[entry.sampled as usize] += 1;
                    reported += u64::from(around.is_reported(i, image));
                }
            }
        }

        if sample == n {
            return Self { number: (within / 2 + reported) as f64, error: 0.0 };
        }
        let sum: u64 = counts.iter().sum();
        let mean = sum as f64 / sample as f64;
        let squares: f64 = counts.iter().map(|&count| (count as f64 - mean) * (count as f64 - mean)).sum();
        let variance = squares / (sample - 1) as f64;
        Self {
            number: sum as f64 * n as f64 / (2.0 * sample as f64),
            error: (variance / sample as f64).sqrt() * n as f64 / 2.0,
        }
    }
}

type Cell = [u64; AXES];

/// The cells of elements, along the axes that have the most cells.
struct ElementCells<const D: usize> {
    grid: Grid<D>,
    axes: [usize; D],
}

impl<const D: usize> ElementCells<D> {
    fn new(grid: Grid<D>) -> Self {
        let mut axes = std::array::from_fn(|axis| axis);
        axes.sort_by_key(|&axis| std::cmp::Reverse(grid.cells()[axis]));
        Self { grid, axes }
    }

    #[inline]
    fn of<T: Real>(&self, point: &[T; D]) -> Cell {
        let mut cell = [0; AXES];
        for (cell, &axis) in cell.iter_mut().zip(&self.axes) {
            *cell = self.grid.wide_cell(axis, point[axis].to_f64());
        }
        cell
    }
}

/// The cells in which elements may touch a sampled one, in a hash table.
struct CellTable {
    picked: Vec<usize>,
    entries: Vec<Entry>,
    /// First entry of each bucket; the last number is the number of entries.
    starts: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Entry {
    cell: Cell,
    /// Number of the element in the sample.
    sampled: u32,
}

/// Number of buckets, a power of two: most are empty, and all starts fit into the second-level cache.
const BUCKETS: usize = 1 << 16;

impl CellTable {
    fn new<T: Real, const D: usize>(cells: &ElementCells<D>, points: &[[T; D]], picked: Vec<usize>) -> Self {
        let axes = D.min(AXES) as u32;
        let mut entries = Vec::with_capacity(picked.len() * 3_usize.pow(axes));
        for (sampled, &index) in (0..).zip(&picked) {
            let centre = cells.of(&points[index]);
            for offsets in 0..3_u64.pow(axes) {
                let (mut cell, mut rest, mut exists) = (centre, offsets, true);
                for number in &mut cell[..axes as usize] {
                    exists &= *number + rest % 3 > 0;
                    *number = (*number + rest % 3).wrapping_sub(1);
                    rest /= 3;
                }
                if exists {
                    entries.push(Entry { cell, sampled });
                }
            }
        }
        entries.sort_by_key(|entry| bucket(&entry.cell));
        let mut starts = vec![0; BUCKETS + 1];
        for entry in &entries {
            starts[bucket(&entry.cell) + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        Self { picked, entries, starts }
    }

    #[inline]
    fn at(&self, cell: &Cell) -> &[Entry] {
        let bucket = bucket(cell);
        &self.entries[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }
}

#[inline]
fn bucket(cell: &Cell) -> usize {
    // An odd multiplier with well-mixed bits: 2^64 divided by the golden ratio.
    let mix = |hash: u64, number: u64| (hash.rotate_left(29) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (cell.iter().fold(0, |hash, &number| mix(hash, number)) >> (64 - BUCKETS.ilog2())) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped() {
        assert_eq!(grouped(0.0), "0");
        assert_eq!(grouped(1_234_567.4), "1,234,567");
        assert_eq!(grouped(2_f64.powi(80)), "1.2e24");
    }

    /// Every cell next to that of a sampled element is found once, and no cell below the first.
    #[test]
    fn the_table_has_the_cells_around_each_element() {
        let points = [[0.0, 0.0, 0.0], [9.0, 9.0, 9.0], [4.0, 4.0, 4.0]];
        let cells = ElementCells::new(Grid::unbounded(&Elements::points(&points, 1.0).unwrap()));
        let table = CellTable::new(&cells, &points, vec![0, 2]);
        assert_eq!(table.entries.len(), 8 + 27);
        for (sampled, index) in [(0, 0), (1, 2)] {
            let cell = cells.of(&points[index]);
            for near in [cell, [cell[0] + 1, cell[1], cell[2] + 1]] {
                let found = table.at(&near).iter().filter(|entry| entry.cell == near).collect::<Vec<_>>();
                assert_eq!(found.len(), 1, "{near:?}");
                assert_eq!(found[0].sampled, sampled);
            }
        }
    }
}
