//! Neighbour lists as ASE has them: each pair from both sides, sorted by the first atom, the second atom and the shift.
//!
//! The search finds each couple once. Couples are dealt out into buckets of consecutive first atoms, from both sides; a bucket fits into the cache, where its
//! rows are sorted and written to their final place. The list is the same for any number of threads, because it is sorted.

use std::sync::Mutex;

use fdem_contact::{Couple, Engine};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::elements::{Elements, Set, SetSizes};
use crate::interrupt::{self, Stop};
use crate::number::{Kind, entries_of};
use crate::problem::{Problem, zeros};
use crate::search::{search_open, search_periodic, threads_for};
use crate::tasks;

/// Couples that one task deals out.
const CHUNK: usize = 1 << 18;

/// No more buckets than this: each is a place in memory to which a task writes.
const MAX_BUCKETS: usize = 1 << 9;

/// Rows that a bucket has at least.
const MIN_ROWS: usize = 1 << 10;

/// A neighbour of the atom `row`, in the same image.
#[derive(Clone, Copy, Default)]
struct Plain {
    row: u32,
    partner: u32,
}

/// A neighbour of the atom `row`, displaced by `shift` edges.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Shifted {
    row: u32,
    partner: u32,
    shift: [i32; 3],
}

/// A couple that is seen from both of its atoms.
trait TwoSided: Copy + Send {
    type Side: Copy + Default + Send;

    /// Whether the atoms are closer than their limit.
    fn is_kept(&self, atoms: &Atoms<'_>) -> bool;

    /// The first atom and the neighbour, from either side.
    fn sides(&self) -> [(u32, Self::Side); 2];
}

impl TwoSided for Couple {
    type Side = Plain;

    fn is_kept(&self, atoms: &Atoms<'_>) -> bool {
        length(&atoms.vector(self.i, self.j)) < atoms.limit(self.i, self.j)
    }

    fn sides(&self) -> [(u32, Plain); 2] {
        let Self { i, j } = *self;
        [(i, Plain { row: i, partner: j }), (j, Plain { row: j, partner: i })]
    }
}

impl TwoSided for Shifted {
    type Side = Self;

    fn is_kept(&self, atoms: &Atoms<'_>) -> bool {
        length(&atoms.shifted_vector(self)) < atoms.limit(self.row, self.partner)
    }

    fn sides(&self) -> [(u32, Self); 2] {
        let Self { row, partner, shift } = *self;
        [(row, *self), (partner, Self { row: partner, partner: row, shift: shift.map(|s| -s) })]
    }
}

/// Positions, edges, and how close two atoms must be.
struct Atoms<'a> {
    points: &'a [[f64; 3]],
    edges: [[f64; 3]; 3],
    limits: Limits<'a>,
}

enum Limits<'a> {
    One(f64),
    Radii(&'a [f64]),
    /// The kind of each atom, how many kinds there are, and the limit for each two kinds.
    Kinds(&'a [u32], usize, &'a [f64]),
}

impl Atoms<'_> {
    #[inline]
    fn vector(&self, from: u32, to: u32) -> [f64; 3] {
        let (from, to) = (&self.points[from as usize], &self.points[to as usize]);
        std::array::from_fn(|axis| to[axis] - from[axis])
    }

    #[inline]
    fn shifted_vector(&self, Shifted { row, partner, shift }: &Shifted) -> [f64; 3] {
        let vector = self.vector(*row, *partner);
        let term = |edge: usize, axis: usize| f64::from(shift[edge]) * self.edges[edge][axis];
        std::array::from_fn(|axis| vector[axis] + (term(0, axis) + term(1, axis) + term(2, axis)))
    }

    #[inline]
    fn limit(&self, i: u32, j: u32) -> f64 {
        let (i, j) = (i as usize, j as usize);
        match self.limits {
            Limits::One(limit) => limit,
            Limits::Radii(radii) => radii[i] + radii[j],
            Limits::Kinds(kinds, count, table) => table[kinds[i] as usize * count + kinds[j] as usize],
        }
    }
}

/// Length of a vector.
#[inline]
fn length([x, y, z]: &[f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// Neighbours by bucket of their first atom: those of bucket `b` are at `starts[b]..starts[b + 1]`.
struct Dealt<E> {
    neighbours: Vec<E>,
    starts: Vec<usize>,
}

impl<E> Dealt<E> {
    fn of(&self, bucket: usize) -> &[E] {
        &self.neighbours[self.starts[bucket]..self.starts[bucket + 1]]
    }
}

/// Which rows a bucket has: those with the same number after a shift by so many bits.
#[derive(Clone, Copy)]
struct Buckets {
    bits: u32,
    count: usize,
}

impl Buckets {
    fn new(rows: usize) -> Self {
        let size = rows.div_ceil(MAX_BUCKETS).max(MIN_ROWS).next_power_of_two();
        Self { bits: size.trailing_zeros(), count: rows.div_ceil(size) }
    }

    fn of(self, row: u32) -> usize {
        (row >> self.bits) as usize
    }
}

/// Deals out those of `couples` that are kept.
fn deal<C: TwoSided>(
    mut couples: Vec<C>,
    atoms: &Atoms<'_>,
    buckets: Buckets,
    threads: usize,
) -> Result<Vec<Dealt<C::Side>>, Problem> {
    let chunks = couples.len().div_ceil(CHUNK);
    let mut dealt: Vec<_> =
        (0..chunks).map(|_| Ok(Dealt { neighbours: Vec::new(), starts: Vec::new() })).collect();
    tasks::run(threads, couples.chunks_mut(CHUNK).zip(&mut dealt), |(couples, dealt)| {
        *dealt = deal_chunk(couples, atoms, buckets);
    });
    dealt.into_iter().collect()
}

fn deal_chunk<C: TwoSided>(
    couples: &mut [C],
    atoms: &Atoms<'_>,
    buckets: Buckets,
) -> Result<Dealt<C::Side>, Problem> {
    let mut starts = vec![0; buckets.count + 1];
    let mut kept = 0;
    for place in 0..couples.len() {
        let couple = couples[place];
        if couple.is_kept(atoms) {
            couples[kept] = couple;
            kept += 1;
            couple.sides().iter().for_each(|&(row, _)| starts[buckets.of(row) + 1] += 1);
        }
    }
    for bucket in 0..buckets.count {
        starts[bucket + 1] += starts[bucket];
    }
    let mut neighbours = zeros(2 * kept)?;
    let mut next = starts.clone();
    for couple in &couples[..kept] {
        for (row, neighbour) in couple.sides() {
            let place = &mut next[buckets.of(row)];
            neighbours[*place] = neighbour;
            *place += 1;
        }
    }
    Ok(Dealt { neighbours, starts })
}

/// The columns of the list, or a stretch of them; those that nobody asked for are missing.
#[derive(Default)]
struct Columns<'a> {
    first: Option<&'a mut [i64]>,
    second: Option<&'a mut [i64]>,
    distance: Option<&'a mut [f64]>,
    vector: Option<&'a mut [[f64; 3]]>,
    /// Zeros.
    shift: Option<&'a mut [[i64; 3]]>,
}

impl<'a> Columns<'a> {
    /// Splits off the first `rows` rows.
    fn split_off(&mut self, rows: usize) -> Columns<'a> {
        fn split<'a, V>(column: &mut Option<&'a mut [V]>, rows: usize) -> Option<&'a mut [V]> {
            column.as_mut().map(|column| column.split_off_mut(..rows).unwrap_or_default())
        }
        Columns {
            first: split(&mut self.first, rows),
            second: split(&mut self.second, rows),
            distance: split(&mut self.distance, rows),
            vector: split(&mut self.vector, rows),
            shift: split(&mut self.shift, rows),
        }
    }

    #[inline]
    fn set(&mut self, place: usize, row: u32, partner: u32, vector: [f64; 3], distance: f64) {
        if let Some(column) = &mut self.first {
            column[place] = i64::from(row);
        }
        if let Some(column) = &mut self.second {
            column[place] = i64::from(partner);
        }
        if let Some(column) = &mut self.distance {
            column[place] = distance;
        }
        if let Some(column) = &mut self.vector {
            column[place] = vector;
        }
    }
}

/// All neighbours, dealt out.
struct Found {
    plain: Vec<Dealt<Plain>>,
    shifted: Vec<Dealt<Shifted>>,
    buckets: Buckets,
    /// Whether each atom is its own neighbour.
    with_self: bool,
}

impl Found {
    fn rows(&self, bucket: usize, atoms: usize) -> std::ops::Range<u32> {
        let end = ((bucket + 1) << self.buckets.bits).min(atoms);
        (bucket << self.buckets.bits) as u32..end as u32
    }

    /// Neighbours in a bucket.
    fn len(&self, bucket: usize, atoms: usize) -> usize {
        self.plain.iter().map(|dealt| dealt.of(bucket).len()).sum::<usize>()
            + self.shifted.iter().map(|dealt| dealt.of(bucket).len()).sum::<usize>()
            + if self.with_self { self.rows(bucket, atoms).len() } else { 0 }
    }

    /// Sorts a bucket, and writes it.
    fn write(&self, bucket: usize, atoms: &Atoms<'_>, columns: &mut Columns<'_>) -> Result<(), Problem> {
        let rows = self.rows(bucket, atoms.points.len());
        let local = |row: u32| (row - rows.start) as usize;
        let plain = || self.plain.iter().flat_map(|dealt| dealt.of(bucket));
        let own = if self.with_self { rows.clone() } else { 0..0 };
        let own = own.map(|row| Plain { row, partner: row });

        // Entry `r` is where the next neighbour of row `r` goes, and in the end where those of row `r` end.
        let mut ends = zeros::<usize>(rows.len() + 1)?;
        plain().for_each(|neighbour| ends[local(neighbour.row) + 1] += 1);
        own.clone().for_each(|neighbour| ends[local(neighbour.row) + 1] += 1);
        for row in 0..rows.len() {
            ends[row + 1] += ends[row];
        }
        let mut partners = zeros::<u32>(ends[rows.len()])?;
        for neighbour in plain().copied().chain(own) {
            let place = &mut ends[local(neighbour.row)];
            partners[*place] = neighbour.partner;
            *place += 1;
        }

        let mut shifted = Vec::new();
        for dealt in &self.shifted {
            let more = dealt.of(bucket);
            shifted.try_reserve(more.len()).map_err(|_| Problem::out_of_memory::<Shifted>(more.len()))?;
            shifted.extend_from_slice(more);
        }
        shifted.sort_unstable();
        let mut shifted = shifted.into_iter().peekable();

        let (mut start, mut place) = (0, 0);
        for row in rows.clone() {
            let end = ends[local(row)];
            let partners = &mut partners[start..end];
            partners.sort_unstable();
            start = end;
            let mut partners = partners.iter().copied().peekable();
            loop {
                let image = shifted.next_if(|image| {
                    image.row == row
                        && partners
                            .peek()
                            .is_none_or(|&partner| (image.partner, image.shift) < (partner, [0; 3]))
                });
                if let Some(image) = image {
                    let vector = atoms.shifted_vector(&image);
                    columns.set(place, row, image.partner, vector, length(&vector));
                    if let Some(column) = &mut columns.shift {
                        column[place] = image.shift.map(i64::from);
                    }
                } else if let Some(partner) = partners.next() {
                    let vector = atoms.vector(row, partner);
                    columns.set(place, row, partner, vector, length(&vector));
                } else {
                    break;
                }
                place += 1;
            }
        }
        Ok(())
    }
}

fn find(
    set: Set<'_, f64, 3>,
    cell: Option<fdem_contact::PeriodicBox<f64, 3>>,
    atoms: &Atoms<'_>,
    signs: [i32; 3],
    with_self: bool,
    threads: usize,
    stop: &Stop,
) -> Result<Found, Problem> {
    let buckets = Buckets::new(atoms.points.len());
    let (couples, shifts) = match cell {
        None => (search_open(set, Engine::Auto, threads, stop)?, Vec::new()),
        Some(cell) => search_periodic(set, &cell, Engine::Auto, threads, stop)?,
    };
    let plain = couples.len() - shifts.len();
    let mut shifted = zeros(shifts.len())?;
    for ((to, couple), shift) in shifted.iter_mut().zip(&couples[plain..]).zip(&shifts) {
        let shift = std::array::from_fn(|edge| shift[edge] * signs[edge]);
        *to = Shifted { row: couple.i, partner: couple.j, shift };
    }
    let mut couples = couples;
    couples.truncate(plain);
    Ok(Found {
        plain: deal(couples, atoms, buckets, threads)?,
        shifted: deal(shifted, atoms, buckets, threads)?,
        buckets,
        with_self,
    })
}

/// First atom, second atom, distance, vector and shift, as far as they were asked for.
type Listed<'py> = (
    Option<Bound<'py, PyArray1<i64>>>,
    Option<Bound<'py, PyArray1<i64>>>,
    Option<Bound<'py, PyArray1<f64>>>,
    Option<Bound<'py, PyArray2<f64>>>,
    Option<Bound<'py, PyArray2<i64>>>,
);

/// All pairs of atoms that are closer than their limit, from both sides, sorted.
///
/// `elements` are spheres in 3D and `f64` of which every such pair touches. The limit is the sum of the radii or the `cutoff`, or that which `table` has for
/// the `kinds` of both. `edges` are those of the cell; along edge `a` the box of the elements has `signs[a]` times this edge. `quantities` are letters as ASE
/// has them.
#[pyfunction]
#[pyo3(signature = (elements, quantities, cutoff, kinds, table, edges, signs, self_interaction, threads))]
#[allow(clippy::too_many_arguments, reason = "one for each thing that a list depends on")]
pub(crate) fn neighbor_list<'py>(
    py: Python<'py>,
    elements: &Elements,
    quantities: &str,
    cutoff: f64,
    kinds: Option<PyReadonlyArray1<'py, u32>>,
    table: Option<PyReadonlyArray2<'py, f64>>,
    edges: [[f64; 3]; 3],
    signs: [i32; 3],
    self_interaction: bool,
    threads: usize,
) -> PyResult<Listed<'py>> {
    if elements.kind != Kind::Double3 {
        return Err(Problem::Arguments("atoms must be in 3D and float64".to_owned()).into());
    }
    let held = elements.hold::<f64>(py)?;
    let set = held.set::<3>(elements)?;
    let atoms = set.points.len();
    let kinds = kinds.as_ref().map(entries_of).transpose()?;
    let limits = match (kinds, &table, set.sizes) {
        (Some(kinds), Some(table), _) => {
            let count = table.as_array().ncols();
            let table = table.as_slice().unwrap_or(&[]);
            if table.len() != count * count
                || kinds.len() != atoms
                || kinds.iter().any(|&kind| kind as usize >= count)
            {
                return Err(Problem::Arguments("kinds of other atoms".to_owned()).into());
            }
            Limits::Kinds(kinds, count, table)
        }
        (_, _, SetSizes::Each(radii)) if radii.len() == atoms => Limits::Radii(radii),
        _ => Limits::One(cutoff),
    };
    let searched = Atoms { points: set.points, edges, limits };
    let cell = elements.cell::<f64, 3>()?;
    let threads = threads_for(threads, atoms);
    let stop = Stop::default();
    let search = || find(set, cell, &searched, signs, self_interaction, threads, &stop);
    let found = interrupt::run(py, true, &stop, search)?;

    let buckets = found.buckets.count;
    let len = (0..buckets).map(|bucket| found.len(bucket, atoms)).sum::<usize>();
    // NumPy has them zeroed by the system, and says so if there is no memory.
    let zeros = py.import("numpy")?.getattr("zeros")?;
    let has = |letter: char| quantities.contains(letter);
    let column = |letter, dtype: &str| has(letter).then(|| zeros.call1((len, dtype))).transpose();
    let rows = |letter, dtype: &str| has(letter).then(|| zeros.call1(((len, 3), dtype))).transpose();
    let first = column('i', "int64")?.map(Bound::cast_into::<PyArray1<i64>>).transpose()?;
    let second = column('j', "int64")?.map(Bound::cast_into::<PyArray1<i64>>).transpose()?;
    let distance = column('d', "float64")?.map(Bound::cast_into::<PyArray1<f64>>).transpose()?;
    let vector = rows('D', "float64")?.map(Bound::cast_into::<PyArray2<f64>>).transpose()?;
    let shift = rows('S', "int64")?.map(Bound::cast_into::<PyArray2<i64>>).transpose()?;
    {
        let mut first = first.as_ref().map(PyArrayMethods::readwrite);
        let mut second = second.as_ref().map(PyArrayMethods::readwrite);
        let mut distance = distance.as_ref().map(PyArrayMethods::readwrite);
        let mut vector = vector.as_ref().map(PyArrayMethods::readwrite);
        let mut shift = shift.as_ref().map(PyArrayMethods::readwrite);
        let mut columns = Columns {
            first: first.as_mut().map(|column| column.as_slice_mut()).transpose()?,
            second: second.as_mut().map(|column| column.as_slice_mut()).transpose()?,
            distance: distance.as_mut().map(|column| column.as_slice_mut()).transpose()?,
            vector: vector
                .as_mut()
                .map(|rows| rows.as_slice_mut())
                .transpose()?
                .map(|rows| rows.as_chunks_mut().0),
            shift: shift
                .as_mut()
                .map(|rows| rows.as_slice_mut())
                .transpose()?
                .map(|rows| rows.as_chunks_mut().0),
        };
        interrupt::run(py, false, &stop, || {
            let parts: Vec<_> =
                (0..buckets).map(|bucket| (bucket, columns.split_off(found.len(bucket, atoms)))).collect();
            let problem = Mutex::new(None);
            tasks::run(threads, parts.into_iter(), |(bucket, mut columns)| {
                if let Err(error) = found.write(bucket, &searched, &mut columns) {
                    *problem.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(error);
                }
            });
            problem.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).map_or(Ok(()), Err)
        })?;
    }
    Ok((first, second, distance, vector, shift))
}
