//! The k-d tree as Python has it.

use std::sync::atomic::Ordering::Relaxed;

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::interrupt::{self, Stop};
use crate::number::entries_of;
use crate::problem::{Problem, zeros};
use crate::search::is_long;
use crate::tasks;
use crate::tree::{Hit, Norm, Tree};

/// Number of query points in one task.
const CHUNK: usize = 256;

/// A sorted copy of points of any dimension.
#[pyclass(frozen, module = "fdem._fdem", name = "Tree")]
#[derive(Debug)]
pub(crate) struct PyTree {
    tree: Tree,
    dimensions: usize,
}

/// Distances and numbers, a row for each query point.
type Nearest<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>);

/// The nodes, and the numbers of the points.
type Nodes<'py> = (Bound<'py, PyArray2<i64>>, Bound<'py, PyArray1<i64>>);

/// The starts of the rows, the numbers of the points, and their distances.
type Within<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>);

fn norm_of(p: f64) -> Result<Norm, Problem> {
    Norm::of(p).ok_or_else(|| Problem::Arguments(format!("p must be at least 1, not {p}")))
}

impl PyTree {
    /// The coordinates of one query point, in the box.
    fn point_of(&self, at: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f64>> {
        let mut at = entries_of(at)?.to_vec();
        if at.len() != self.dimensions {
            let wrong = format!("points must have {} coordinates", self.dimensions);
            return Err(Problem::Arguments(wrong).into());
        }
        if !at.iter().all(|x| x.is_finite()) {
            let wrong = "'x' must be finite, check for nan or inf values".to_owned();
            return Err(Problem::Arguments(wrong).into());
        }
        self.tree.wrap(&mut at);
        Ok(at)
    }

    /// The coordinates of the query points.
    fn rows_of<'a>(&self, at: &'a PyReadonlyArray2<'_, f64>) -> Result<&'a [f64], Problem> {
        match at.as_slice() {
            Ok(values) if at.shape()[1] == self.dimensions && self.dimensions > 0 => Ok(values),
            _ => Err(Problem::Arguments(format!("points must have {} coordinates", self.dimensions))),
        }
    }
}

#[pymethods]
impl PyTree {
    #[new]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        sides: Vec<f64>,
        leaf: usize,
    ) -> PyResult<Self> {
        let dimensions = points.shape()[1];
        let values = points.as_slice().unwrap_or(&[]);
        if values.len() != points.shape()[0] * dimensions || sides.len() != dimensions {
            return Err(Problem::Arguments(
                "points must be in C order, with a side for each axis".to_owned(),
            )
            .into());
        }
        let (stop, is_long) = (Stop::default(), is_long(points.shape()[0]));
        let tree = interrupt::run(py, is_long, &stop, || Tree::new(values, dimensions, &sides, leaf, &stop))?;
        Ok(Self { tree, dimensions })
    }

    /// The `k` nearest points to each of `at` that are nearer than `bound`; where there are fewer, the
    /// distance is infinite and the number that of the points.
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        at: PyReadonlyArray2<'py, f64>,
        k: usize,
        p: f64,
        bound: f64,
        threads: usize,
    ) -> PyResult<Nearest<'py>> {
        let (norm, values, rows) = (norm_of(p)?, self.rows_of(&at)?, at.shape()[0]);
        let stop = Stop::default();
        let (distances, numbers) = interrupt::run(py, is_long(rows), &stop, || {
            let mut distances = zeros::<f64>(rows.saturating_mul(k))?;
            let mut numbers = zeros::<i64>(rows.saturating_mul(k))?;
            let parts = values
                .chunks(CHUNK * self.dimensions)
                .zip(distances.chunks_mut((CHUNK * k).max(1)).zip(numbers.chunks_mut((CHUNK * k).max(1))));
            tasks::run((threads, &stop), parts, |(at, (distances, numbers))| {
                distances.fill(f64::INFINITY);
                numbers.fill(self.tree.len().cast_signed() as i64);
                let rows = distances.chunks_mut(k.max(1)).zip(numbers.chunks_mut(k.max(1)));
                for (at, (distances, numbers)) in at.chunks(self.dimensions).zip(rows) {
                    let hits = self.tree.nearest(norm, at, k, bound);
                    for ((distance, number), hit) in distances.iter_mut().zip(numbers).zip(hits) {
                        (*distance, *number) = (norm.distance(hit.distance), i64::from(hit.number));
                    }
                }
            });
            Ok((distances, numbers))
        })?;
        Ok((distances.into_pyarray(py).reshape([rows, k])?, numbers.into_pyarray(py).reshape([rows, k])?))
    }

    /// The point nearest to one point, if it is nearer than `bound`, and its distance; else the number of
    /// points, infinitely far.
    fn nearest_one(&self, at: PyReadonlyArray1<'_, f64>, p: f64, bound: f64) -> PyResult<(f64, usize)> {
        let (norm, at) = (norm_of(p)?, self.point_of(&at)?);
        let hit = self.tree.nearest(norm, &at, 1, bound).first().copied();
        Ok(hit.map_or((f64::INFINITY, self.tree.len()), |hit| {
            (norm.distance(hit.distance), hit.number as usize)
        }))
    }

    /// The points at most `r` away from one point, ascending. Without threads and arrays, which would take
    /// longer than the search.
    fn within_one(&self, at: PyReadonlyArray1<'_, f64>, r: f64, p: f64) -> PyResult<Vec<u32>> {
        let (norm, at) = (norm_of(p)?, self.point_of(&at)?);
        let mut found = Vec::new();
        self.tree.within(norm, &at, r, &mut |hit| found.push(hit.number));
        found.sort_unstable();
        Ok(found)
    }

    /// The number of the points at most `r` away from one point.
    fn count_within_one(&self, at: PyReadonlyArray1<'_, f64>, r: f64, p: f64) -> PyResult<usize> {
        Ok(self.tree.count_within(norm_of(p)?, &self.point_of(&at)?, r))
    }

    /// For each node the places of its first and last point and the node of its right half, 0 for a leaf; and
    /// the number of the point at each place. A node comes before its left half, and that before the right.
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Nodes<'py>> {
        let nodes: Vec<_> = self.tree.nodes().flatten().map(i64::from).collect();
        let numbers: Vec<_> = self.tree.numbers().iter().map(|&number| i64::from(number)).collect();
        let rows = nodes.len() / 3;
        Ok((nodes.into_pyarray(py).reshape([rows, 3])?, numbers.into_pyarray(py)))
    }

    /// The sum of the weights of the points of each node.
    fn node_weights<'py>(
        &self,
        py: Python<'py>,
        weights: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let weights = entries_of(&weights)?;
        if weights.len() != self.tree.len() {
            return Err(Problem::Arguments("there must be a weight for each point".to_owned()).into());
        }
        Ok(self.tree.node_weights(weights)?.into_pyarray(py))
    }

    /// All points at most `r[q]` away from point `q` of `at`, ascending by number.
    fn within<'py>(
        &self,
        py: Python<'py>,
        at: PyReadonlyArray2<'py, f64>,
        r: PyReadonlyArray1<'py, f64>,
        p: f64,
        threads: usize,
    ) -> PyResult<Within<'py>> {
        let (norm, values, radii) = (norm_of(p)?, self.rows_of(&at)?, entries_of(&r)?);
        let (stop, is_long) = (Stop::default(), is_long(radii.len().max(self.tree.len())));
        let (offsets, numbers, distances) = interrupt::run(py, is_long, &stop, || {
            let mut found: Vec<(Vec<usize>, Vec<Hit>)> =
                vec![Default::default(); radii.len().div_ceil(CHUNK)];
            let parts = values.chunks(CHUNK * self.dimensions).zip(radii.chunks(CHUNK)).zip(&mut found);
            tasks::run((threads, &stop), parts, |((at, radii), (counts, hits))| {
                for (at, &r) in at.chunks(self.dimensions).zip(radii) {
                    if stop.load(Relaxed) {
                        break;
                    }
                    let start = hits.len();
                    self.tree.within(norm, at, r, &mut |hit| hits.push(hit));
                    hits[start..].sort_unstable_by_key(|hit| hit.number);
                    counts.push(hits.len() - start);
                }
            });
            if stop.load(Relaxed) {
                return Ok(<(Vec<i64>, Vec<i64>, Vec<f64>)>::default());
            }
            let len = found.iter().map(|(_, hits)| hits.len()).sum();
            let (mut offsets, mut end) = (zeros::<i64>(radii.len() + 1)?, 0);
            let counts = found.iter().flat_map(|(counts, _)| counts);
            for (offset, count) in offsets[1..].iter_mut().zip(counts) {
                end += count.cast_signed() as i64;
                *offset = end;
            }
            let (mut numbers, mut distances) = (zeros::<i64>(len)?, zeros::<f64>(len)?);
            let hits = found.iter().flat_map(|(_, hits)| hits);
            for ((number, distance), hit) in numbers.iter_mut().zip(&mut distances).zip(hits) {
                (*number, *distance) = (i64::from(hit.number), norm.distance(hit.distance));
            }
            Ok((offsets, numbers, distances))
        })?;
        Ok((offsets.into_pyarray(py), numbers.into_pyarray(py), distances.into_pyarray(py)))
    }

    /// The number of points at most `r[q]` away from point `q` of `at`.
    fn count_within<'py>(
        &self,
        py: Python<'py>,
        at: PyReadonlyArray2<'py, f64>,
        r: PyReadonlyArray1<'py, f64>,
        p: f64,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let (norm, values, radii) = (norm_of(p)?, self.rows_of(&at)?, entries_of(&r)?);
        let (stop, is_long) = (Stop::default(), is_long(radii.len().max(self.tree.len())));
        let counts = interrupt::run(py, is_long, &stop, || {
            let mut counts = zeros::<i64>(radii.len())?;
            let parts =
                values.chunks(CHUNK * self.dimensions).zip(radii.chunks(CHUNK)).zip(counts.chunks_mut(CHUNK));
            tasks::run((threads, &stop), parts, |((at, radii), counts)| {
                for ((at, &r), count) in at.chunks(self.dimensions).zip(radii).zip(counts) {
                    *count = self.tree.count_within(norm, at, r).cast_signed() as i64;
                }
            });
            Ok(counts)
        })?;
        Ok(counts.into_pyarray(py))
    }

    /// The weight of the pairs of this tree and another one between each of the ascending distances `r` and
    /// the one before it.
    #[pyo3(signature = (other, r, p, weights, other_weights))]
    fn count_pairs<'py>(
        &self,
        py: Python<'py>,
        other: &Self,
        r: PyReadonlyArray1<'py, f64>,
        p: f64,
        weights: Option<PyReadonlyArray1<'py, f64>>,
        other_weights: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (norm, radii) = (norm_of(p)?, entries_of(&r)?);
        let weights = weights.as_ref().map(entries_of).transpose()?;
        let other_weights = other_weights.as_ref().map(entries_of).transpose()?;
        let fits = |tree: &Self, weights: Option<&[f64]>| {
            weights.is_none_or(|weights| weights.len() == tree.tree.len())
        };
        if self.dimensions != other.dimensions || !fits(self, weights) || !fits(other, other_weights) {
            return Err(Problem::Arguments(
                "trees and weights must have the same dimensions and lengths".to_owned(),
            )
            .into());
        }
        let (stop, is_long) = (Stop::default(), is_long(self.tree.len().max(other.tree.len())));
        let mut counts = interrupt::run(py, is_long, &stop, || {
            self.tree.count_pairs(&other.tree, norm, radii, [weights, other_weights], &stop)
        })?;
        counts.truncate(radii.len());
        Ok(counts.into_pyarray(py))
    }
}
