//! Packings in NumPy arrays.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use half::f16;

use crate::columns::{MOST_COLUMNS, Name, Role};
use crate::elements::Elements;
use crate::error::ReadError;
use crate::npy_header::{Dtype, Header, Scalar};
use crate::options::ReadOptions;
use crate::packing::{BadLine, Column, Format, Frame, Packing, Source};
use crate::row::{Row, SIZE, check_size, whole};
use crate::table::UnassignedColumns;

/// Number of rows between two reports of progress.
const ROWS_PER_REPORT: usize = 4096;
/// A field that is an array is read as columns `name:0`, `name:1`, … up to this many; a longer one is not a
/// vector.
const LONGEST_VECTOR: u64 = 16;

pub(crate) fn read_npy(
    bytes: &[u8],
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    let header = Header::parse(bytes).map_err(|problem| ReadError::NpyHeader { problem })?;
    read_rows(&header, &bytes[header.data..], 0, options, progress)
}

/// Reads an array with this header, whose data start with row `first` of a file.
fn read_rows(
    header: &Header,
    data: &[u8],
    first: u64,
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    let array = NpyArray::new(header, data)?;
    let (roles, unit) = array.roles(options)?;
    let chosen = array.chosen(&roles, header)?;
    array.check_size(header)?;

    let mut elements = Elements::new(&roles, array.rows)?;
    for at in 0..array.rows {
        if at % ROWS_PER_REPORT == 0 {
            progress.store((header.data + at * (array.data.len() / array.rows)) as u64, Ordering::Relaxed);
        }
        match array.row(at, &chosen) {
            Ok(row) => elements.push(&row, first + at as u64),
            Err(problem) => {
                let (row, text) = (first + at as u64, array.shown(at, &chosen));
                let problem = format!("row {row} (counted from 0): {problem}");
                elements.bad_row(BadLine { line: row, text, problem }, options.skip_bad_lines)?;
            }
        }
    }
    elements.check(false)?;
    let names: Vec<Name> = array.columns.iter().map(|column| column.name.clone()).collect();
    Ok(elements.into_packing(Frame::default(), |skipped| Source {
        columns: Column::all(&names, &roles, array.named),
        format: Format::Npy { dtype: header.descr.clone() },
        unit,
        lines: array.rows as u64,
        skipped,
    }))
}

/// A NumPy array in a file, some rows of which can be read without the others.
///
/// # Example
/// ```
/// use std::sync::atomic::AtomicU64;
/// use fdem_io::{Centres, NpyRows, ReadOptions, Table, Values, write_npy};
///
/// let mut file = Vec::new();
/// let table = Table::new(9).with("x", Values::f64(|k| k as f64)).with("y", Values::f64(|_| 0.5));
/// write_npy(&mut file, &table)?;
/// let array = NpyRows::open(&file)?.expect("an array");
/// assert_eq!(array.rows(), 9);
///
/// let place = array.bytes(3..5);
/// let part = &file[place.start as usize..place.end as usize];
/// let packing = array.read(3..5, part, &ReadOptions::default(), &AtomicU64::new(0))?;
/// assert_eq!(packing.centres, Centres::Two(vec![[3.0, 0.5], [4.0, 0.5]]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct NpyRows {
    header: Header,
    rows: u64,
    /// Number of bytes of a row.
    stride: u64,
}

impl NpyRows {
    /// Bytes at the start of a file that hold any header that NumPy writes.
    pub const START: usize = 1 << 20;

    /// The array of a file that begins with `start`, which is the whole file or at least its first
    /// [`NpyRows::START`] bytes.
    ///
    /// `None` if the file is not a NumPy array, or has its rows scattered (Fortran order).
    ///
    /// # Errors
    /// [`ReadError::NpyHeader`], [`ReadError::NpyShape`], [`ReadError::NpySize`].
    pub fn open(start: &[u8]) -> Result<Option<Self>, ReadError> {
        if !start.starts_with(b"\x93NUMPY") {
            return Ok(None);
        }
        let header = Header::parse(start).map_err(|problem| ReadError::NpyHeader { problem })?;
        let NpyArray { rows, stride, columns, .. } = NpyArray::new(&header, &[])?;
        if header.fortran_order && columns.len() > 1 && rows > 1 {
            return Ok(None);
        }
        let stride =
            if header.fortran_order { columns.iter().map(|column| column.scalar.size).sum() } else { stride };
        Ok(Some(Self { header, rows: rows as u64, stride: stride as u64 }))
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Place of these rows in the file.
    pub fn bytes(&self, rows: Range<u64>) -> Range<u64> {
        let place = |row: u64| self.header.data as u64 + row * self.stride;
        place(rows.start)..place(rows.end)
    }

    /// Checks the length of the file.
    ///
    /// # Errors
    /// [`ReadError::NpySize`].
    pub fn check_length(&self, file: u64) -> Result<(), ReadError> {
        let (expected, found) =
            (u128::from(self.rows) * u128::from(self.stride), file.saturating_sub(self.header.data as u64));
        if expected == u128::from(found) {
            return Ok(());
        }
        Err(ReadError::NpySize { expected, found, shape: self.header.shown_shape() })
    }

    /// Reads rows as [`read`](crate::read) reads a file. `bytes` is the content of the file at the place of
    /// the [rows](Self::bytes).
    ///
    /// Errors name rows of the file. Ids are compared within these rows only.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn read(
        &self,
        rows: Range<u64>,
        bytes: &[u8],
        options: &ReadOptions,
        progress: &AtomicU64,
    ) -> Result<Packing, ReadError> {
        let mut header = self.header.clone();
        if let Some(length) = header.shape.first_mut() {
            *length = rows.end - rows.start;
        }
        read_rows(&header, bytes, rows.start, options, progress)
    }
}

/// The data of an array as a table.
#[derive(Debug)]
struct NpyArray<'a> {
    data: &'a [u8],
    rows: usize,
    /// Number of bytes from one row to the next.
    stride: usize,
    columns: Vec<ArrayColumn>,
    /// Whether the columns have names, which are the fields of the dtype.
    named: bool,
    /// The shape in Python notation.
    shape: String,
}

#[derive(Debug)]
struct ArrayColumn {
    name: Name,
    scalar: Scalar,
    /// Offset of the column's value in row 0.
    offset: usize,
    /// Whether the column can have a role; a vector that is too long is skipped.
    readable: bool,
}

/// A column that is read, with its role.
type Chosen<'a> = (&'a ArrayColumn, Role);

impl<'a> NpyArray<'a> {
    fn new(header: &Header, data: &'a [u8]) -> Result<Self, ReadError> {
        const MOST: u64 = MOST_COLUMNS as u64;
        let wrong_shape = || ReadError::NpyShape { shape: header.shown_shape(), dtype: header.descr.clone() };
        let too_large = || ReadError::NpySize {
            expected: u128::MAX,
            found: data.len() as u64,
            shape: header.shown_shape(),
        };
        let (columns, rows, stride) = match (&header.dtype, &header.shape[..]) {
            (Dtype::Plain(scalar), &[rows, width @ 1..=MOST]) => {
                let rows = usize::try_from(rows).map_err(|_| too_large())?;
                let width = width as usize;
                let (step, stride) = if header.fortran_order {
                    (scalar.size.checked_mul(rows), Some(scalar.size))
                } else {
                    (Some(scalar.size), scalar.size.checked_mul(width))
                };
                let (step, stride) = (step.ok_or_else(too_large)?, stride.ok_or_else(too_large)?);
                let column = |place: usize| {
                    let name = Name::new(&(place + 1).to_string());
                    let offset = place.checked_mul(step).ok_or_else(too_large)?;
                    Ok(ArrayColumn { name, scalar: scalar.clone(), offset, readable: true })
                };
                ((0..width).map(column).collect::<Result<Vec<_>, ReadError>>()?, rows, stride)
            }
            (Dtype::Record(_), &[rows]) => {
                let (columns, stride) = record_columns(header).ok_or_else(too_large)?;
                if columns.is_empty() {
                    return Err(ReadError::NpyHeader { problem: "the dtype has no named fields".into() });
                }
                if columns.len() > MOST_COLUMNS {
                    return Err(ReadError::TooManyColumns { line: None });
                }
                (columns, usize::try_from(rows).map_err(|_| too_large())?, stride)
            }
            _ => return Err(wrong_shape()),
        };
        let named = matches!(header.dtype, Dtype::Record(_));
        Ok(Self { data, rows, stride, columns, named, shape: header.shown_shape() })
    }

    fn roles(&self, options: &ReadOptions) -> Result<(Vec<Option<Role>>, Option<String>), ReadError> {
        let names: Vec<Name> = self.columns.iter().map(|column| column.name.clone()).collect();
        let row = format!("array of shape {}", self.shape);
        let table = UnassignedColumns { names: &names, header: self.named, line: None, row: &row };
        let roles = table.all_roles(options)?;
        let unit = table.unit(&roles)?;
        Ok((roles, unit))
    }

    /// The columns with a role, after checking that their dtypes fit it.
    fn chosen(&self, roles: &[Option<Role>], header: &Header) -> Result<Vec<Chosen<'_>>, ReadError> {
        let chosen =
            self.columns.iter().zip(roles).filter_map(|(column, role)| role.map(|role| (column, role)));
        let checked = chosen.map(|(column, role)| {
            let Scalar { kind, size, .. } = &column.scalar;
            let number = matches!((kind, size), ('f', 2 | 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8));
            if column.readable && number {
                return Ok((column, role));
            }
            Err(ReadError::NpyDtype {
                what: if self.named {
                    format!("field {} of the array", column.name.shown())
                } else {
                    "the array".into()
                },
                dtype: column.scalar.descr.clone(),
                shape: header.shown_shape(),
                wanted: "float16, float32, float64 or an integer of at most 64 bits",
            })
        });
        checked.collect()
    }

    /// Compares the size that the shape implies with the actual size, before anything is allocated.
    fn check_size(&self, header: &Header) -> Result<(), ReadError> {
        let row: u128 = if self.named {
            self.stride as u128
        } else {
            self.columns.iter().map(|column| column.scalar.size as u128).sum()
        };
        let expected = row.saturating_mul(self.rows as u128);
        let found = self.data.len() as u64;
        if expected == u128::from(found) {
            return Ok(());
        }
        Err(ReadError::NpySize { expected, found, shape: header.shown_shape() })
    }

    #[inline]
    fn bytes_of(&self, column: &ArrayColumn, row: usize) -> &[u8] {
        let at = column.offset + row * self.stride;
        &self.data[at..at + column.scalar.size]
    }

    #[inline]
    fn row(&self, at: usize, chosen: &[Chosen<'_>]) -> Result<Row<'static>, String> {
        let mut row = Row::default();
        for (column, role) in chosen {
            let bytes = self.bytes_of(column, at);
            let label = || column.name.shown();
            if matches!(role, Role::Id | Role::Body | Role::Type) {
                let number = whole_number(bytes, &column.scalar)
                    .map_err(|problem| format!("the {role} in column {} {problem}", label()))?;
                row.set_whole(*role, number);
                continue;
            }
            let value = number(bytes, &column.scalar)
                .map_err(|problem| format!("{role} (column {}) {problem}", label()))?;
            if !value.is_finite() {
                return Err(format!("{role} (column {}) is {value}, not a finite number", label()));
            }
            row.values[match role {
                Role::X => 0,
                Role::Y => 1,
                Role::Z => 2,
                _ => SIZE,
            }] = value;
            if value < 0.0 && matches!(role, Role::Radius | Role::Diameter) {
                check_size(value, *role, &label())?;
            }
        }
        Ok(row)
    }

    /// The values of a row, for a message.
    fn shown(&self, at: usize, chosen: &[Chosen<'_>]) -> String {
        let value = |(column, role): &Chosen<'_>| {
            let bytes = self.bytes_of(column, at);
            match column.scalar.kind {
                'f' => format!("{role} {}", float(bytes, column.scalar.big_endian)),
                _ => format!("{role} {}", integer(bytes, &column.scalar)),
            }
        };
        crate::excerpt::line(chosen.iter().map(value).collect::<Vec<_>>().join(", ").as_bytes())
    }
}

/// The fields of a structured dtype as columns, and the number of bytes per row; `None` if that exceeds any
/// memory.
fn record_columns(header: &Header) -> Option<(Vec<ArrayColumn>, usize)> {
    let Dtype::Record(fields) = &header.dtype else { return None };
    let mut columns = Vec::new();
    let mut offset = 0_usize;
    for field in fields {
        let scalar = &field.scalar;
        let size = field
            .shape
            .iter()
            .try_fold(scalar.size, |size, &n| size.checked_mul(usize::try_from(n).ok()?))?;
        let mut column = |name: &str, offset, readable| {
            columns.push(ArrayColumn { name: Name::new(name), scalar: scalar.clone(), offset, readable });
        };
        match field.shape[..] {
            // A field without a name is padding.
            [] if field.name.is_empty() => {}
            [] => column(&field.name, offset, true),
            [length @ 1..=LONGEST_VECTOR] => {
                for place in 0..length as usize {
                    column(
                        &format!("{}:{place}", field.name),
                        offset.checked_add(place * scalar.size)?,
                        true,
                    );
                }
            }
            _ => column(&field.name, offset, false),
        }
        offset = offset.checked_add(size)?;
    }
    let names = Name::all(columns.iter().map(|column| column.name.written.as_str()));
    columns.iter_mut().zip(names).for_each(|(column, name)| column.name = name);
    Some((columns, offset))
}

/// The bytes of a number as 8 bytes in little-endian order, padded with 0.
#[inline]
fn little_endian(bytes: &[u8], big_endian: bool) -> [u8; 8] {
    let mut ordered = [0; 8];
    for (to, from) in ordered.iter_mut().zip(0..bytes.len()) {
        *to = bytes[if big_endian { bytes.len() - 1 - from } else { from }];
    }
    ordered
}

#[inline]
fn float(bytes: &[u8], big_endian: bool) -> f64 {
    match *bytes {
        [a, b] => f64::from(f16::from_le_bytes(if big_endian { [b, a] } else { [a, b] })),
        [a, b, c, d] => f64::from(f32::from_le_bytes(if big_endian { [d, c, b, a] } else { [a, b, c, d] })),
        _ => f64::from_le_bytes(little_endian(bytes, big_endian)),
    }
}

/// Any number as a float; the conversion must be exact.
#[inline]
pub(crate) fn number(bytes: &[u8], scalar: &Scalar) -> Result<f64, String> {
    if scalar.kind == 'f' {
        return Ok(float(bytes, scalar.big_endian));
    }
    let whole = integer(bytes, scalar);
    let value = whole as f64;
    // The number has at most 64 bits, so the conversion back from the float fits.
    if value as i128 == whole {
        Ok(value)
    } else {
        Err(format!("is {whole}, which a 64-bit float cannot hold exactly"))
    }
}

/// An integer of 1, 2, 4 or 8 bytes, signed or unsigned.
fn integer(bytes: &[u8], scalar: &Scalar) -> i128 {
    let value = u64::from_le_bytes(little_endian(bytes, scalar.big_endian));
    let unused = 64 - 8 * scalar.size.clamp(1, 8);
    match scalar.kind {
        'i' => i128::from((value << unused).cast_signed() >> unused),
        _ => i128::from(value),
    }
}

/// An id or a body.
pub(crate) fn whole_number(bytes: &[u8], scalar: &Scalar) -> Result<i64, String> {
    if scalar.kind == 'f' {
        let value = float(bytes, scalar.big_endian);
        return whole(value).ok_or_else(|| format!("is {value}, not a whole number up to 2^53"));
    }
    let value = integer(bytes, scalar);
    i64::try_from(value).map_err(|_| format!("is {value}, which does not fit 64 bits with a sign"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(descr: &str) -> Scalar {
        let big_endian = descr.starts_with('>');
        Scalar {
            kind: descr.chars().nth(1).unwrap(),
            size: descr[2..].parse().unwrap(),
            big_endian,
            descr: descr.into(),
        }
    }

    /// Rows that are read alone are those of the whole file, and errors name rows of the file.
    #[test]
    fn rows_are_read_without_the_others() {
        let mut file = crate::npy_header::header("'<f8'", "(6, 3)");
        let numbers = (0..18).map(|k| if k == 13 { f64::NAN } else { f64::from(k) });
        file.extend(numbers.flat_map(f64::to_le_bytes));
        let array = NpyRows::open(&file).unwrap().unwrap();
        assert_eq!(array.rows(), 6);
        assert_eq!(array.check_length(file.len() as u64), Ok(()));
        assert!(array.check_length(file.len() as u64 - 1).is_err());
        let read = |rows: Range<u64>| {
            let place = array.bytes(rows.clone());
            let part = &file[place.start as usize..place.end as usize];
            array.read(rows, part, &ReadOptions::default(), &AtomicU64::new(0))
        };
        let centres = |rows| read(rows).unwrap().centres;
        assert_eq!(centres(2..4), crate::Centres::Three(vec![[6.0, 7.0, 8.0], [9.0, 10.0, 11.0]]));
        assert_eq!(centres(6..6), crate::Centres::Three(Vec::new()));
        let Err(ReadError::BadRow { row: 4, problem, .. }) = read(3..6) else {
            panic!("row 4 has no number")
        };
        assert!(problem.starts_with("row 4 "), "{problem}");

        let mut fortran = file.clone();
        let place = fortran.windows(5).position(|text| text == b"False").unwrap();
        fortran[place..place + 5].copy_from_slice(b"True ");
        assert!(NpyRows::open(&fortran).unwrap().is_none());
        assert!(NpyRows::open(b"x,y\n0,0\n").unwrap().is_none());
    }

    #[test]
    fn whole_numbers_keep_sign_and_order() {
        assert_eq!(integer(&[0xfe], &scalar("|i1")), -2);
        assert_eq!(integer(&[0xfe], &scalar("|u1")), 254);
        assert_eq!(integer(&[0xff, 0xfe], &scalar(">i2")), -2);
        assert_eq!(integer(&[1, 0, 0, 0], &scalar("<u4")), 1);
        assert_eq!(integer(&[0, 0, 0, 1], &scalar(">u4")), 1);
        assert_eq!(whole_number(&i64::MIN.to_le_bytes(), &scalar("<i8")), Ok(i64::MIN));
        let error = whole_number(&u64::MAX.to_le_bytes(), &scalar("<u8")).unwrap_err();
        assert!(error.contains("18446744073709551615"));
    }

    #[test]
    fn integers_become_floats_only_exactly() {
        assert_eq!(number(&[0xfe], &scalar("|i1")), Ok(-2.0));
        assert_eq!(number(&(1_i64 << 53).to_be_bytes(), &scalar(">i8")), Ok(9_007_199_254_740_992.0));
        assert_eq!(number(&i64::MIN.to_le_bytes(), &scalar("<i8")), Ok(-9_223_372_036_854_775_808.0));
        for (bytes, descr) in [
            (((1_i64 << 53) + 1).to_le_bytes(), "<i8"),
            (i64::MAX.to_le_bytes(), "<i8"),
            (u64::MAX.to_le_bytes(), "<u8"),
        ] {
            assert!(number(&bytes, &scalar(descr)).unwrap_err().contains("cannot hold exactly"));
        }
    }

    #[test]
    fn floats_are_widened_exactly() {
        assert_eq!(float(&0.1_f32.to_be_bytes(), true), f64::from(0.1_f32));
        assert_eq!(float(&0.1_f64.to_le_bytes(), false), 0.1);
        assert_eq!(float(&[0x00, 0xb4], false), -0.25);
        assert_eq!(float(&[0x3c, 0x01], true), 1.000_976_562_5);
        assert!(whole_number(&0.5_f64.to_le_bytes(), &scalar("<f8")).unwrap_err().contains("0.5"));
        assert_eq!(whole_number(&7_f32.to_le_bytes(), &scalar("<f4")), Ok(7));
    }
}
