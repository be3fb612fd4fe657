//! NumPy archives: several arrays with known names, or a single array.

use std::io::{Cursor, Read};

use zip::ZipArchive;

use crate::column_values::ColumnValues;
use crate::columns::Name;
use crate::error::ReadError;
use crate::excerpt;
use crate::npy::{number, read_npy, whole_number};
use crate::npy_header::{Dtype, Header, Scalar};
use crate::options::ReadOptions;
use crate::packing::{Format, Frame, Packing, SimulationBox};
use crate::place::Place;
use crate::series::values;

/// Number of bytes read between two checks of the memory.
const PIECE: usize = 1 << 18;
/// Upper bound on the length of the header of an array of numbers.
const LONGEST_HEADER: u64 = 1 << 16;
/// Largest number of columns of an array with one row per element.
const WIDEST: u64 = 16;
/// Largest number of members of a packing.
const MOST_MEMBERS: usize = 1000;

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Packing, ReadError> {
    let mut archive =
        ZipArchive::new(Cursor::new(bytes)).map_err(|error| broken(format!("zip archive: {error}")))?;
    if archive.len() > MOST_MEMBERS {
        return Err(broken(format!("an archive of {} members: a packing is a few arrays", archive.len())));
    }
    if archive.len() == 1 {
        let (_, array) = member(&mut archive, 0, true)?;
        let mut packing = read_npy(&array, options, &0.into())?;
        packing.source.format = Format::Npz;
        return Ok(packing);
    }
    let mut columns = Vec::new();
    let mut rows: Option<(u64, String)> = None;
    for at in 0..archive.len() {
        let (header, _) = member(&mut archive, at, false)?;
        let label = label(&archive, at);
        let width = match header.shape[..] {
            [_] => 1,
            [_, width @ 1..=WIDEST] => width as usize,
            _ => continue,
        };
        let Dtype::Plain(scalar) = header.dtype.clone() else { continue };
        if !matches!((scalar.kind, scalar.size), ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8)) {
            continue;
        }
        for place in 0..width {
            let name = name(&label, place, if header.shape.len() == 1 { None } else { Some(width) });
            if name.role().is_some() {
                // Arrays with a role have one row per element; others may have any length.
                match &rows {
                    Some((rows, other)) if *rows != header.shape[0] => {
                        return Err(broken(format!(
                            "array {label} has {}, array {other} {rows}: one for each element is expected",
                            excerpt::count(header.shape[0], "row")
                        )));
                    }
                    _ => rows = Some((header.shape[0], label.clone())),
                }
            }
            columns.push((name, at, place));
        }
    }
    let names: Vec<Name> = columns.iter().map(|(name, ..)| name.clone()).collect();
    // The rows are counted again when an array is read, because a header may claim any number.
    let claimed = rows.as_ref().map_or(0, |(rows, _)| *rows);
    let rows = usize::try_from(claimed).map_err(|_| broken(format!("an array of {claimed} rows")))?;
    // The latest array that was read, so that an array is not decompressed again for each of its columns.
    let mut last: Option<(usize, Header, Vec<u8>)> = None;
    let column = |place: usize| {
        let (_, at, component) = columns[place];
        let label = label(&archive, at);
        let (header, array) = match last.take() {
            Some((known, header, array)) if known == at => (header, array),
            _ => member(&mut archive, at, true)?,
        };
        let values = decode(&header, &array, component, &label, rows);
        last = Some((at, header, array));
        values
    };
    let mut packing = values::packing(&names, rows, column, Format::Npz, Frame::default(), options)?;
    packing.cell = simulation_box(&mut archive, packing.centres.dimensions())?;
    Ok(packing)
}

/// The box in the arrays `edges` (D, D), one edge per row, `origin` (D) and `periodic` (D), as `fdem` writes
/// them. Without `origin` it starts at 0; without `periodic` it is not periodic.
fn simulation_box(archive: &mut Archive<'_>, dimensions: usize) -> Result<Option<SimulationBox>, ReadError> {
    let mut numbers = |wanted: &str, shape: &[u64]| -> Result<Option<Vec<f64>>, ReadError> {
        let Some(at) = (0..archive.len()).find(|&at| label(archive, at) == wanted) else { return Ok(None) };
        let (header, array) = member(archive, at, true)?;
        if header.shape != shape {
            return Ok(None);
        }
        let width = shape.get(1).map_or(1, |&width| width as usize);
        let columns: Vec<Vec<f64>> = (0..width)
            .map(|component| {
                Ok(match decode(&header, &array, component, wanted, dimensions)? {
                    ColumnValues::Real(values) => values,
                    ColumnValues::Whole(values) => values.into_iter().map(|value| value as f64).collect(),
                })
            })
            .collect::<Result<_, ReadError>>()?;
        let values: Vec<f64> =
            (0..dimensions * width).map(|place| columns[place % width][place / width]).collect();
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(broken(format!("array {wanted}: {value} is not a finite number"))),
            None => Ok(Some(values)),
        }
    };
    let n = dimensions as u64;
    let Some(edges) = numbers("edges", &[n, n])? else { return Ok(None) };
    let origin = numbers("origin", &[n])?;
    let periodic = numbers("periodic", &[n])?;
    let of = |values: &Option<Vec<f64>>, axis: usize| {
        values.as_ref().and_then(|values| values.get(axis)).copied().unwrap_or(0.0)
    };
    Ok(Some(SimulationBox {
        origin: std::array::from_fn(|axis| of(&origin, axis)),
        edges: std::array::from_fn(|edge| {
            std::array::from_fn(|axis| {
                if edge < dimensions && axis < dimensions { edges[edge * dimensions + axis] } else { 0.0 }
            })
        }),
        repeats: std::array::from_fn(|axis| of(&periodic, axis) != 0.0),
    }))
}

fn broken(problem: String) -> ReadError {
    ReadError::Broken { place: Place::File, problem }
}

/// The name of a member without its extension.
fn label(archive: &Archive<'_>, at: usize) -> String {
    let name = archive.name_for_index(at).and_then(Result::ok).unwrap_or_default();
    excerpt::field(name.strip_suffix(".npy").unwrap_or(&name).as_bytes())
}

/// The name of a column of an array of one or two axes.
fn name(label: &str, place: usize, width: Option<usize>) -> Name {
    const POSITIONS: [&str; 9] =
        ["positions", "position", "pos", "points", "centres", "centers", "coordinates", "coords", "xyz"];
    const SIZES: [(&str, &str); 2] = [("radii", "radius"), ("diameters", "diameter")];
    let Some(width) = width else {
        let mut name = Name::unsuffixed(label);
        if let Some((_, size)) = SIZES.iter().find(|(plural, _)| name.plain == *plural) {
            (*size).clone_into(&mut name.plain);
        }
        return name;
    };
    let mut name = Name::unsuffixed(&format!("{label}:{place}"));
    name.plain = if width <= 3 && POSITIONS.contains(&Name::unsuffixed(label).plain.as_str()) {
        ["x", "y", "z"][place].to_owned()
    } else {
        format!("array {label}:{place}")
    };
    name
}

/// The header of a member and, if `whole`, all of its bytes, including the header.
fn member(archive: &mut Archive<'_>, at: usize, whole: bool) -> Result<(Header, Vec<u8>), ReadError> {
    let shown = label(archive, at);
    let failed = |problem: String| {
        broken(format!("member {shown} of the archive: {}", excerpt::line(problem.as_bytes())))
    };
    let mut file = archive.by_index(at).map_err(|error| failed(error.to_string()))?;
    let mut bytes = Vec::new();
    let read = fill(&mut file, LONGEST_HEADER, &mut bytes)?;
    read.map_err(|error| failed(error.to_string()))?;
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(failed("no NumPy array".to_owned()));
    }
    let header = Header::parse(&bytes).map_err(failed)?;
    if whole {
        // Decompresses at most the size that the array states, plus one byte that shows whether the data
        // continue.
        let claimed = claimed(&header).and_then(|claimed| u64::try_from(claimed).ok()).unwrap_or(u64::MAX);
        let rest = claimed.saturating_add(1).saturating_sub(bytes.len() as u64);
        let read = fill(&mut file, rest, &mut bytes)?;
        read.map_err(|error| failed(error.to_string()))?;
    }
    Ok((header, bytes))
}

/// Reads up to `limit` bytes; memory is allocated as they arrive.
fn fill(input: &mut dyn Read, limit: u64, bytes: &mut Vec<u8>) -> Result<std::io::Result<()>, ReadError> {
    let mut left = limit;
    while left > 0 {
        let piece = left.min(PIECE as u64);
        let size = bytes.len() as u64 + piece;
        bytes.try_reserve(piece as usize).map_err(|_| ReadError::NoMemory { bytes: size })?;
        match (&mut *input).take(piece).read_to_end(bytes) {
            Ok(0) => break,
            Ok(read) => left -= read as u64,
            Err(error) => return Ok(Err(error)),
        }
    }
    Ok(Ok(()))
}

/// Number of bytes of header and data according to the header.
fn claimed(header: &Header) -> Option<u128> {
    let size = match &header.dtype {
        Dtype::Plain(scalar) => scalar.size,
        // Structured arrays are read to the end.
        Dtype::Record(_) => return Some(u128::MAX),
    };
    let values =
        header.shape.iter().try_fold(1_u128, |product, &length| product.checked_mul(u128::from(length)))?;
    values.checked_mul(size as u128)?.checked_add(header.data as u128)
}

/// A column of an array of one or two axes.
fn decode(
    header: &Header,
    bytes: &[u8],
    component: usize,
    label: &str,
    rows: usize,
) -> Result<ColumnValues, ReadError> {
    let Dtype::Plain(scalar) = &header.dtype else {
        return Err(broken(format!("array {label} has fields")));
    };
    let data = &bytes[header.data..];
    let expected = claimed(header).map_or(u128::MAX, |all| all - header.data as u128);
    if expected != data.len() as u128 {
        return Err(ReadError::NpySize { expected, found: data.len() as u64, shape: header.shown_shape() });
    }
    let length = usize::try_from(header.shape[0]).unwrap_or(usize::MAX);
    if length != rows {
        return Err(broken(format!("array {label} has {length} rows, not {rows}")));
    }
    let width = header.shape.get(1).map_or(1, |&width| width as usize);
    let size = scalar.size;
    let place =
        |row: usize| if header.fortran_order { component * rows + row } else { row * width + component };
    let of = |row: usize| &data[place(row) * size..(place(row) + 1) * size];
    let located = |row: usize, problem: String| {
        broken(format!("array {label}, row {row} (counted from 0): the value {problem}"))
    };
    if scalar.kind == 'f' {
        return Ok(ColumnValues::Real((0..rows).map(|row| real(of(row), scalar)).collect()));
    }
    let whole = |row| whole_number(of(row), scalar).map_err(|problem| located(row, problem));
    let values = (0..rows).map(whole).collect::<Result<Vec<i64>, ReadError>>()?;
    Ok(ColumnValues::Whole(values))
}

fn real(bytes: &[u8], scalar: &Scalar) -> f64 {
    number(bytes, scalar).unwrap_or(f64::NAN)
}
