//! Neighbour lists as ASE has them: each pair from both sides, sorted by the first atom, the second atom and
//! the shift.
//!
//! The search finds each couple once. Couples are dealt out into buckets of consecutive first atoms, from
//! both sides; a bucket fits into the cache, where its rows are sorted and written to their final place. The
//! list is the same for any number of threads, because it is sorted.

use std::sync::Mutex;

use fdem_contact::{Couple, PeriodicBox};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::elements::{Elements, Set, SetSizes};
use crate::interrupt::{self, Stop};
use crate::number::{NumberKind, entries_of};
use crate::problem::{Problem, zeros};
use crate::search::{search_open, search_periodic, threads_for};
use crate::tasks;

/// Couples that one task deals out.
const CHUNK: usize = 1 << 18;

/// No more buckets than this: each is a place in memory to which a task writes.
const MAX_BUCKETS: usize = 1 << 9;

/// Rows that a bucket has at least.
const MIN_ROWS: usize = 1 << 10;

/// Neighbours of an atom up to which they are sorted by counting smaller ones.
const RANKED: usize = 64;

/// The distance or, if requested, the vector of a neighbour. It travels with the neighbour, so that positions
/// are read only once.
trait Measure: Copy + Default + Send + Sync {
    fn new(vector: [f64; 3], distance: f64) -> Self;

    /// The measure as seen from the other atom.
    fn reversed(self) -> Self;

    fn write(self, columns: &mut ListColumns<'_>, place: usize);
}

impl Measure for f64 {
    fn new(_: [f64; 3], distance: f64) -> Self {
        distance
    }

    fn reversed(self) -> Self {
        self
    }

    #[inline]
    fn write(self, columns: &mut ListColumns<'_>, place: usize) {
        if let Some(column) = &mut columns.distance {
            column[place] = self;
        }
    }
}

impl Measure for [f64; 3] {
    fn new(vector: [f64; 3], _: f64) -> Self {
        vector
    }

    fn reversed(self) -> Self {
        // The difference of two equal coordinates is 0, never -0, from either side.
        self.map(|component| 0.0 - component)
    }

    #[inline]
    fn write(self, columns: &mut ListColumns<'_>, place: usize) {
        length(&self).write(columns, place);
        if let Some(column) = &mut columns.vector {
            column[place] = self;
        }
    }
}

/// A neighbour of the atom `row`, in the same image.
#[derive(Clone, Copy, Default)]
struct Plain<M> {
    row: u32,
    partner: u32,
    measure: M,
}

/// A neighbour of the atom `row`, displaced by `shift` edges.
#[derive(Clone, Copy, Default)]
struct Shifted<M> {
    row: u32,
    partner: u32,
    shift: [i32; 3],
    measure: M,
}

/// A couple of which `j` is displaced by `shift` edges.
#[derive(Clone, Copy, Default)]
struct ShiftedCouple {
    i: u32,
    j: u32,
    shift: [i32; 3],
}

/// A couple that is seen from both of its atoms.
trait TwoSided<M>: Copy + Send + Sync {
    type Side: Copy + Default + Send;

    /// The neighbour of the first atom, or nothing if the atoms are not closer than their limit.
    fn side(&self, atoms: &Atoms<'_>) -> Option<Self::Side>;

    /// The first atom.
    fn row(side: &Self::Side) -> u32;

    /// The neighbour of the other atom.
    fn reversed(side: &Self::Side) -> Self::Side;
}

impl<M: Measure> TwoSided<M> for Couple {
    type Side = Plain<M>;

    #[inline]
    fn side(&self, atoms: &Atoms<'_>) -> Option<Plain<M>> {
        let Self { i, j } = *self;
        let measure = atoms.measure(i, j, atoms.vector(i, j))?;
        Some(Plain { row: i, partner: j, measure })
    }

    #[inline]
    fn row(side: &Plain<M>) -> u32 {
        side.row
    }

    #[inline]
    fn reversed(&Plain { row, partner, measure }: &Plain<M>) -> Plain<M> {
        Plain { row: partner, partner: row, measure: measure.reversed() }
    }
}

impl<M: Measure> TwoSided<M> for ShiftedCouple {
    type Side = Shifted<M>;

    fn side(&self, atoms: &Atoms<'_>) -> Option<Shifted<M>> {
        let Self { i, j, shift } = *self;
        let measure = atoms.measure(i, j, atoms.shifted_vector(i, j, shift))?;
        Some(Shifted { row: i, partner: j, shift, measure })
    }

    fn row(side: &Shifted<M>) -> u32 {
        side.row
    }

    fn reversed(&Shifted { row, partner, shift, measure }: &Shifted<M>) -> Shifted<M> {
        Shifted { row: partner, partner: row, shift: shift.map(|s| -s), measure: measure.reversed() }
    }
}

/// The atoms, the cell, and the condition for two of them to be neighbours.
struct Atoms<'a> {
    edges: [[f64; 3]; 3],
    limits: Limits<'a>,
    /// Spheres of which every two touch that may be neighbours.
    set: Set<'a, f64, 3>,
    /// The box of the spheres.
    periodic: Option<PeriodicBox<f64, 3>>,
    /// Whether each atom is its own neighbour, unless the limit for two of its kind is 0.
    with_self: bool,
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
        let (from, to) = (&self.set.points[from as usize], &self.set.points[to as usize]);
        std::array::from_fn(|axis| to[axis] - from[axis])
    }

    fn shifted_vector(&self, from: u32, to: u32, shift: [i32; 3]) -> [f64; 3] {
        let vector = self.vector(from, to);
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

    /// Whether an atom is its own neighbour.
    fn has_self(&self, row: u32) -> bool {
        self.with_self && !(matches!(self.limits, Limits::Kinds(..)) && self.limit(row, row) <= 0.0)
    }

    /// The measure of the neighbour `j` of `i`, or `None` if `j` is not closer than the limit.
    #[inline]
    fn measure<M: Measure>(&self, i: u32, j: u32, vector: [f64; 3]) -> Option<M> {
        let distance = length(&vector);
        (distance < self.limit(i, j)).then(|| M::new(vector, distance))
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

/// The rows of a bucket: those with the same number after a shift by `bits`.
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

/// Deals out those of `couples` that are closer than their limit.
fn deal<M: Measure, C: TwoSided<M>>(
    couples: &[C],
    atoms: &Atoms<'_>,
    buckets: Buckets,
    (threads, stop): (usize, &Stop),
) -> Result<Vec<Dealt<C::Side>>, Problem> {
    let chunks = couples.len().div_ceil(CHUNK);
    let mut dealt: Vec<_> =
        (0..chunks).map(|_| Ok(Dealt { neighbours: Vec::new(), starts: Vec::new() })).collect();
    tasks::run((threads, stop), couples.chunks(CHUNK).zip(&mut dealt), |(couples, dealt)| {
        *dealt = deal_chunk(couples, atoms, buckets);
    });
    dealt.into_iter().collect()
}

fn deal_chunk<M: Measure, C: TwoSided<M>>(
    couples: &[C],
    atoms: &Atoms<'_>,
    buckets: Buckets,
) -> Result<Dealt<C::Side>, Problem> {
    let mut starts = vec![0; buckets.count + 1];
    let mut kept = Vec::new();
    kept.try_reserve_exact(couples.len()).map_err(|_| Problem::out_of_memory::<C::Side>(couples.len()))?;
    for side in couples.iter().filter_map(|couple| couple.side(atoms)) {
        starts[buckets.of(C::row(&side)) + 1] += 1;
        starts[buckets.of(C::row(&C::reversed(&side))) + 1] += 1;
        kept.push(side);
    }
    for bucket in 0..buckets.count {
        starts[bucket + 1] += starts[bucket];
    }
    let mut neighbours = zeros(2 * kept.len())?;
    let mut next = starts.clone();
    for side in &kept {
        for side in [*side, C::reversed(side)] {
            let place = &mut next[buckets.of(C::row(&side))];
            neighbours[*place] = side;
            *place += 1;
        }
    }
    Ok(Dealt { neighbours, starts })
}

/// The columns of the list, or a stretch of them; columns that were not requested are missing.
#[derive(Default)]
struct ListColumns<'a> {
    first: Option<&'a mut [i64]>,
    second: Option<&'a mut [i64]>,
    distance: Option<&'a mut [f64]>,
    vector: Option<&'a mut [[f64; 3]]>,
    /// Zeros.
    shift: Option<&'a mut [[i64; 3]]>,
}

impl<'a> ListColumns<'a> {
    /// Splits off the first `rows` rows.
    fn split_off(&mut self, rows: usize) -> ListColumns<'a> {
        fn split<'a, V>(column: &mut Option<&'a mut [V]>, rows: usize) -> Option<&'a mut [V]> {
            column.as_mut().map(|column| column.split_off_mut(..rows).unwrap_or_default())
        }
        ListColumns {
            first: split(&mut self.first, rows),
            second: split(&mut self.second, rows),
            distance: split(&mut self.distance, rows),
            vector: split(&mut self.vector, rows),
            shift: split(&mut self.shift, rows),
        }
    }

    #[inline]
    fn write(&mut self, place: usize, row: u32, partner: u32, measure: impl Measure) {
        if let Some(column) = &mut self.first {
            column[place] = i64::from(row);
        }
        if let Some(column) = &mut self.second {
            column[place] = i64::from(partner);
        }
        measure.write(self, place);
    }
}

/// All neighbours, dealt out.
struct DealtOut<M> {
    plain: Vec<Dealt<Plain<M>>>,
    shifted: Vec<Dealt<Shifted<M>>>,
    buckets: Buckets,
}

impl<M: Measure> DealtOut<M> {
    fn rows(&self, bucket: usize, atoms: &Atoms<'_>) -> std::ops::Range<u32> {
        let end = ((bucket + 1) << self.buckets.bits).min(atoms.set.points.len());
        (bucket << self.buckets.bits) as u32..end as u32
    }

    /// Neighbours in a bucket.
    fn len(&self, bucket: usize, atoms: &Atoms<'_>) -> usize {
        self.plain.iter().map(|dealt| dealt.of(bucket).len()).sum::<usize>()
            + self.shifted.iter().map(|dealt| dealt.of(bucket).len()).sum::<usize>()
            + self.rows(bucket, atoms).filter(|&row| atoms.has_self(row)).count()
    }

    /// Sorts a bucket, and writes it.
    fn write(&self, bucket: usize, atoms: &Atoms<'_>, columns: &mut ListColumns<'_>) -> Result<(), Problem> {
        let rows = self.rows(bucket, atoms);
        let local = |row: u32| (row - rows.start) as usize;
        let plain = || self.plain.iter().flat_map(|dealt| dealt.of(bucket));
        let own = rows.clone().filter(|&row| atoms.has_self(row));
        let own = own.map(|row| Plain { row, partner: row, measure: M::default() });

        // Entry `r` is where the next neighbour of row `r` goes, and in the end where those of row `r` end.
        let mut ends = zeros::<usize>(rows.len() + 1)?;
        plain().for_each(|neighbour| ends[local(neighbour.row) + 1] += 1);
        own.clone().for_each(|neighbour| ends[local(neighbour.row) + 1] += 1);
        for row in 0..rows.len() {
            ends[row + 1] += ends[row];
        }
        let mut partners = zeros::<u32>(ends[rows.len()])?;
        let mut measures = zeros::<M>(ends[rows.len()])?;
        for neighbour in plain().copied().chain(own) {
            let place = &mut ends[local(neighbour.row)];
            partners[*place] = neighbour.partner;
            measures[*place] = neighbour.measure;
            *place += 1;
        }

        let mut shifted = Vec::new();
        for dealt in &self.shifted {
            let more = dealt.of(bucket);
            shifted.try_reserve(more.len()).map_err(|_| Problem::out_of_memory::<Shifted<M>>(more.len()))?;
            shifted.extend_from_slice(more);
        }
        shifted.sort_unstable_by_key(|image| image.row);

        let mut mixed = Vec::new();
        let (mut start, mut place, mut images) = (0, 0, shifted.as_slice());
        for row in rows.clone() {
            let plain = start..ends[local(row)];
            start = plain.end;
            let (partners, measures) = (&partners[plain.clone()], &measures[plain]);
            let (of_row, rest) = images.split_at(images.iter().take_while(|image| image.row == row).count());
            images = rest;
            if of_row.is_empty() && partners.len() <= RANKED {
                // Each partner is there once, so its place is the number of smaller ones: no branch depends
                // on the data.
                for (&partner, &measure) in partners.iter().zip(measures) {
                    let rank: u32 = partners.iter().map(|&other| u32::from(other < partner)).sum();
                    columns.write(place + rank as usize, row, partner, measure);
                }
                place += partners.len();
                continue;
            }
            mixed.clear();
            mixed.extend(of_row.iter().map(|image| (image.partner, image.shift, image.measure)));
            mixed
                .extend(partners.iter().zip(measures).map(|(&partner, &measure)| (partner, [0; 3], measure)));
            mixed.sort_unstable_by_key(|&(partner, shift, _)| (partner, shift));
            for &(partner, shift, measure) in &mixed {
                columns.write(place, row, partner, measure);
                if let Some(column) = &mut columns.shift
                    && shift != [0; 3]
                {
                    column[place] = shift.map(i64::from);
                }
                place += 1;
            }
        }
        Ok(())
    }
}

/// Searches, and distributes the results.
fn find<M: Measure>(atoms: &Atoms<'_>, threads: usize, stop: &Stop) -> Result<DealtOut<M>, Problem> {
    let buckets = Buckets::new(atoms.set.points.len());
    let (mut couples, shifts) = match &atoms.periodic {
        None => (search_open(atoms.set, None, threads, stop)?, Vec::new()),
        Some(periodic) => search_periodic(atoms.set, periodic, None, threads, stop)?,
    };
    let plain = couples.len() - shifts.len();
    let mut shifted = zeros(shifts.len())?;
    for ((to, couple), &shift) in shifted.iter_mut().zip(&couples[plain..]).zip(&shifts) {
        *to = ShiftedCouple { i: couple.i, j: couple.j, shift };
    }
    couples.truncate(plain);
    Ok(DealtOut {
        plain: deal::<M, _>(&couples, atoms, buckets, (threads, stop))?,
        shifted: deal::<M, _>(&shifted, atoms, buckets, (threads, stop))?,
        buckets,
    })
}

/// First atom, second atom, distance, vector and shift, if they were requested.
type Listed<'py> = (
    Option<Bound<'py, PyArray1<i64>>>,
    Option<Bound<'py, PyArray1<i64>>>,
    Option<Bound<'py, PyArray1<f64>>>,
    Option<Bound<'py, PyArray2<f64>>>,
    Option<Bound<'py, PyArray2<i64>>>,
);

/// All pairs of atoms that are closer than their limit, from both sides, sorted.
///
/// `elements` are spheres in 3D and `f64` of which every such pair touches. The limit is the sum of the radii
/// or the `cutoff`, or the value of `table` for the `kinds` of both. `edges` are those of the cell.
/// `quantities` are letters as ASE has them.
#[pyfunction]
#[pyo3(signature = (elements, quantities, cutoff, kinds, table, edges, self_interaction, threads))]
#[allow(clippy::too_many_arguments, reason = "one for each thing that a list depends on")]
pub(crate) fn neighbor_list<'py>(
    py: Python<'py>,
    elements: &Elements,
    quantities: &str,
    cutoff: f64,
    kinds: Option<PyReadonlyArray1<'py, u32>>,
    table: Option<PyReadonlyArray2<'py, f64>>,
    edges: [[f64; 3]; 3],
    self_interaction: bool,
    threads: usize,
) -> PyResult<Listed<'py>> {
    if elements.kind != NumberKind::Double3 {
        return Err(Problem::Arguments("atoms must be in 3D and float64".to_owned()).into());
    }
    let held = elements.hold::<f64>(py)?;
    let set = held.set::<3>(elements)?;
    let kinds = kinds.as_ref().map(entries_of).transpose()?;
    let limits = match (kinds, &table, set.sizes) {
        (Some(kinds), Some(table), _) => {
            let count = table.as_array().ncols();
            let table = table.as_slice().unwrap_or(&[]);
            if table.len() != count * count
                || kinds.len() != set.points.len()
                || kinds.iter().any(|&kind| kind as usize >= count)
            {
                return Err(Problem::Arguments("kinds of other atoms".to_owned()).into());
            }
            Limits::Kinds(kinds, count, table)
        }
        (_, _, SetSizes::Each(radii)) if radii.len() == set.points.len() => Limits::Radii(radii),
        _ => Limits::One(cutoff),
    };
    let atoms =
        Atoms { edges, limits, set, periodic: elements.cell::<f64, 3>()?, with_self: self_interaction };
    let threads = threads_for(threads, set.points.len());
    if quantities.contains('D') {
        listed::<[f64; 3]>(py, quantities, &atoms, threads)
    } else {
        listed::<f64>(py, quantities, &atoms, threads)
    }
}

/// Makes the columns of the list.
fn listed<'py, M: Measure>(
    py: Python<'py>,
    quantities: &str,
    atoms: &Atoms<'_>,
    threads: usize,
) -> PyResult<Listed<'py>> {
    let stop = Stop::default();
    let found = interrupt::run(py, true, &stop, || find::<M>(atoms, threads, &stop))?;

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
        let mut columns = ListColumns {
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
        interrupt::run(py, true, &stop, || {
            let parts: Vec<_> =
                (0..buckets).map(|bucket| (bucket, columns.split_off(found.len(bucket, atoms)))).collect();
            let problem = Mutex::new(None);
            tasks::run((threads, &stop), parts.into_iter(), |(bucket, mut columns)| {
                if let Err(error) = found.write(bucket, atoms, &mut columns) {
                    *problem.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(error);
                }
            });
            problem.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).map_or(Ok(()), Err)
        })?;
    }
    Ok((first, second, distance, vector, shift))
}
