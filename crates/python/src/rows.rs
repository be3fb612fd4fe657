//! Couples element by element.

use fdem_contact::{Couple, PeriodicCouple};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::number::rows_of;
use crate::problem::{Problem, zeros};
use crate::search::{FoundPairs, into_pairs};

fn check(elements: usize, pairs: &[[u32; 2]]) -> Result<(), Problem> {
    match pairs.as_flattened().iter().find(|&&element| element as usize >= elements) {
        None => Ok(()),
        Some(element) => Err(Problem::Arguments(format!("there is no element {element} among {elements}"))),
    }
}

/// Counts the contacts of each element. A contact with an image of itself counts twice, because it has two
/// ends.
#[pyfunction]
pub(crate) fn coordination<'py>(
    py: Python<'py>,
    elements: usize,
    pairs: PyReadonlyArray2<'py, u32>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let pairs = rows_of::<u32, 2>(&pairs)?;
    let counts = py.detach(|| {
        check(elements, pairs)?;
        let mut counts = zeros::<i64>(elements)?;
        pairs.as_flattened().iter().for_each(|&element| counts[element as usize] += 1);
        Ok::<_, Problem>(counts)
    })?;
    Ok(counts.into_pyarray(py))
}

/// The starts of the rows, the partners, and the couples: `c` in the row of its first element, `-1 - c` in
/// the row of its second.
type Csr<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<i64>>);

/// Rows of partners, ascending; equal ones in the order of the couples.
#[pyfunction]
pub(crate) fn csr<'py>(
    py: Python<'py>,
    elements: usize,
    pairs: PyReadonlyArray2<'py, u32>,
    full: bool,
) -> PyResult<Csr<'py>> {
    let pairs = rows_of::<u32, 2>(&pairs)?;
    let (offsets, partners, couples) = py.detach(|| {
        check(elements, pairs)?;
        // Two stable sorts, by the partner and then by the element, make sorted rows.
        let count = if full { 2 * pairs.len() } else { pairs.len() };
        let mut by_partner = zeros::<Entry>(count)?;
        let mut ends = offsets(elements, entries(pairs, full).map(|entry| entry.partner))?;
        for entry in entries(pairs, full) {
            by_partner[next(&mut ends, entry.partner)] = entry;
        }
        let offsets = offsets(elements, by_partner.iter().map(|entry| entry.element))?;
        let mut ends = offsets.clone();
        let (mut partners, mut couples) = (zeros::<u32>(count)?, zeros::<i64>(count)?);
        for Entry { element, partner, couple } in by_partner {
            let place = next(&mut ends, element);
            (partners[place], couples[place]) = (partner, couple);
        }
        Ok::<_, Problem>((offsets, partners, couples))
    })?;
    Ok((offsets.into_pyarray(py), partners.into_pyarray(py), couples.into_pyarray(py)))
}

#[derive(Clone, Copy, Default)]
struct Entry {
    element: u32,
    partner: u32,
    couple: i64,
}

/// Each couple once; or all couples, and then all couples seen from the other side.
fn entries(pairs: &[[u32; 2]], full: bool) -> impl Iterator<Item = Entry> {
    let there = pairs.iter().zip(0..).map(|(&[i, j], couple)| Entry { element: i, partner: j, couple });
    let back =
        pairs.iter().zip(0..).map(|(&[i, j], couple)| Entry { element: j, partner: i, couple: -1 - couple });
    there.chain(back.take(if full { pairs.len() } else { 0 }))
}

/// The starts of the entries of each key in a sorted list, and the end of the last ones.
fn offsets(keys: usize, of_entries: impl Iterator<Item = u32>) -> Result<Vec<i64>, Problem> {
    let mut offsets = zeros::<i64>(keys + 1)?;
    of_entries.for_each(|key| offsets[key as usize + 1] += 1);
    for key in 0..keys {
        offsets[key + 1] += offsets[key];
    }
    Ok(offsets)
}

/// The next place of a key.
fn next(places: &mut [i64], key: u32) -> usize {
    let place = &mut places[key as usize];
    *place += 1;
    (*place - 1) as usize
}

/// Couples in ascending order: by the first element, the second, the shift. `shifts` are those of the last
/// couples; so are those of the result, of which all but the first without shift have a row if any has one.
#[pyfunction]
pub(crate) fn ascending<'py>(
    py: Python<'py>,
    pairs: PyReadonlyArray2<'py, u32>,
    shifts: PyReadonlyArray2<'py, i32>,
) -> PyResult<FoundPairs<'py>> {
    if shifts.as_array().ncols() == 2 {
        sorted::<2>(py, &pairs, &shifts)
    } else {
        sorted::<3>(py, &pairs, &shifts)
    }
}

fn sorted<'py, const D: usize>(
    py: Python<'py>,
    pairs: &PyReadonlyArray2<'py, u32>,
    shifts: &PyReadonlyArray2<'py, i32>,
) -> PyResult<FoundPairs<'py>> {
    let (pairs, shifts) = (rows_of::<u32, 2>(pairs)?, rows_of::<i32, D>(shifts)?);
    let (couples, shifts) = py.detach(|| {
        if shifts.is_empty() {
            let mut couples: Vec<Couple> = pairs.iter().map(|&[i, j]| Couple { i, j }).collect();
            couples.sort_unstable();
            return Ok((couples, Vec::new()));
        }
        let Some(unshifted) = pairs.len().checked_sub(shifts.len()) else {
            return Err(Problem::Arguments("more shifts than couples".to_owned()));
        };
        let of = |place: usize| place.checked_sub(unshifted).map_or([0; D], |place| shifts[place]);
        let couples = pairs.iter().enumerate();
        let mut couples: Vec<_> =
            couples.map(|(place, &[i, j])| PeriodicCouple { i, j, shift: of(place) }).collect();
        couples.sort_unstable();
        let unshifted = couples.iter().take_while(|couple| couple.shift == [0; D]).count();
        let shifts: Vec<_> = couples[unshifted..].iter().map(|couple| couple.shift).collect();
        Ok((couples.iter().map(|&PeriodicCouple { i, j, .. }| Couple { i, j }).collect(), shifts))
    })?;
    let rows = shifts.len();
    let shifts: Bound<'py, PyArray2<i32>> = shifts.into_flattened().into_pyarray(py).reshape([rows, D])?;
    Ok((into_pairs(py, couples)?, shifts))
}
