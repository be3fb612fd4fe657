//! A table for output: columns with names and types.

use std::fmt;
use std::io::{self, Write};
use std::ops::Range;

/// Number of bytes collected before they are written: large enough for few writes, small enough for a cache.
pub(crate) const CHUNK: usize = 1 << 18;

/// The value at an index.
type At<'a, T> = Box<dyn Fn(usize) -> T + 'a>;

/// The values of a column. Each is computed when it is requested, perhaps more than once; nothing is stored.
pub enum Values<'a> {
    /// Integers of 32 bits.
    I32(At<'a, i32>),
    /// Integers of 64 bits.
    I64(At<'a, i64>),
    /// Unsigned integers of 64 bits.
    U64(At<'a, u64>),
    /// Floats.
    F64(At<'a, f64>),
    /// Texts of letters, digits and underscores.
    Text {
        /// Width in bytes; longer texts are cut in arrays.
        width: usize,
        /// The text at an index.
        at: At<'a, &'static str>,
    },
}

impl<'a> Values<'a> {
    /// Integers of 32 bits.
    pub fn i32(at: impl Fn(usize) -> i32 + 'a) -> Self {
        Self::I32(Box::new(at))
    }

    /// Integers of 64 bits.
    pub fn i64(at: impl Fn(usize) -> i64 + 'a) -> Self {
        Self::I64(Box::new(at))
    }

    /// Unsigned integers of 64 bits.
    pub fn u64(at: impl Fn(usize) -> u64 + 'a) -> Self {
        Self::U64(Box::new(at))
    }

    /// Floats.
    pub fn f64(at: impl Fn(usize) -> f64 + 'a) -> Self {
        Self::F64(Box::new(at))
    }

    /// Texts of at most `width` bytes.
    pub fn text(width: usize, at: impl Fn(usize) -> &'static str + 'a) -> Self {
        Self::Text { width, at: Box::new(at) }
    }

    /// The type in NumPy notation.
    pub(super) fn dtype(&self) -> String {
        match self {
            Self::I32(_) => "<i4".to_owned(),
            Self::I64(_) => "<i8".to_owned(),
            Self::U64(_) => "<u8".to_owned(),
            Self::F64(_) => "<f8".to_owned(),
            Self::Text { width, .. } => format!("|S{width}"),
        }
    }

    /// Number of bytes of a value in an array.
    pub(crate) fn size(&self) -> usize {
        match self {
            Self::I32(_) => 4,
            Self::I64(_) | Self::U64(_) | Self::F64(_) => 8,
            Self::Text { width, .. } => *width,
        }
    }

    /// Appends values in little-endian binary form.
    pub(crate) fn write_le(&self, places: Range<usize>, chunk: &mut Vec<u8>) {
        match self {
            Self::I32(at) => places.for_each(|k| chunk.extend_from_slice(&at(k).to_le_bytes())),
            Self::I64(at) => places.for_each(|k| chunk.extend_from_slice(&at(k).to_le_bytes())),
            Self::U64(at) => places.for_each(|k| chunk.extend_from_slice(&at(k).to_le_bytes())),
            Self::F64(at) => places.for_each(|k| chunk.extend_from_slice(&at(k).to_le_bytes())),
            Self::Text { width, at } => {
                places.for_each(|k| chunk.extend(at(k).bytes().chain(std::iter::repeat(0)).take(*width)));
            }
        }
    }
}

/// A name and its values: one number for each row, or several, as for a point.
pub(crate) struct TableColumn<'a> {
    /// Name of the column, in formats whose arrays may have several components.
    pub(crate) name: &'a str,
    /// Names of the components, for formats without them; empty for a column of single numbers.
    pub(crate) components: &'static [&'static str],
    /// Unit of the values; empty for none.
    pub(crate) unit: &'static str,
    /// Component `c` of row `k` has the index `k * width + c`.
    pub(crate) values: Values<'a>,
}

impl TableColumn<'_> {
    /// The name of its type in VTK files.
    ///
    /// # Errors
    /// If it is of text, which these files cannot have.
    pub(crate) fn vtk_type(&self) -> std::io::Result<&'static str> {
        match self.values {
            Values::I32(_) => Ok("Int32"),
            Values::I64(_) => Ok("Int64"),
            Values::U64(_) => Ok("UInt64"),
            Values::F64(_) => Ok("Float64"),
            Values::Text { .. } => {
                let problem = format!("the array {} is of text, which a VTK file cannot have", self.name);
                Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, problem))
            }
        }
    }

    /// Number of values per row.
    pub(crate) fn width(&self) -> usize {
        self.components.len().max(1)
    }

    /// Names of its columns in formats without components.
    fn names(&self) -> &[&str] {
        if self.components.is_empty() { std::slice::from_ref(&self.name) } else { self.components }
    }

    /// Writes all values of `rows` rows in binary form.
    pub(crate) fn write_array(&self, rows: usize, out: &mut impl Write) -> io::Result<()> {
        let values = rows * self.width();
        let block = (CHUNK / self.values.size().max(1)).max(1);
        let mut chunk = Vec::with_capacity(CHUNK);
        for start in (0..values).step_by(block) {
            chunk.clear();
            self.values.write_le(start..values.min(start + block), &mut chunk);
            out.write_all(&chunk)?;
        }
        Ok(())
    }
}

/// A table: rows of named and typed columns.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_csv};
///
/// let couples = [(0, 7, 0.5), (3, 4, 0.25)];
/// let table = Table::new(2)
///     .with("i", Values::i64(|k| couples[k].0))
///     .with("j", Values::i64(|k| couples[k].1))
///     .with("overlap", Values::f64(|k| couples[k].2));
/// let mut out = Vec::new();
/// write_csv(&mut out, &table)?;
/// assert_eq!(out, b"i,j,overlap\n0,7,0.5\n3,4,0.25\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct Table<'a> {
    rows: usize,
    columns: Vec<TableColumn<'a>>,
}

impl fmt::Debug for Table<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns: Vec<_> = self.columns.iter().map(|column| column.name).collect();
        out.debug_struct("Table").field("rows", &self.rows).field("columns", &columns).finish()
    }
}

impl<'a> Table<'a> {
    /// A table of `rows` rows without columns.
    pub fn new(rows: usize) -> Self {
        Self { rows, columns: Vec::new() }
    }

    /// Adds a column; value `k` belongs to row `k`.
    ///
    /// Names consist of ASCII letters, digits and `_ . - [ ]`, which no format has to escape.
    #[must_use]
    pub fn with(mut self, name: &'a str, values: Values<'a>) -> Self {
        self.columns.push(TableColumn { name, components: &[], unit: "", values });
        self
    }

    /// Adds a column of several components: component `c` of row `k` has the index
    /// `k * components.len() + c`. Formats without components write them as separate columns.
    #[must_use]
    pub fn with_components(
        mut self,
        name: &'a str,
        components: &'static [&'static str],
        values: Values<'a>,
    ) -> Self {
        self.columns.push(TableColumn { name, components, unit: "", values });
        self
    }

    /// With the unit of the column that was added last: [`write_vtu`](crate::write_vtu) and
    /// [`write_poly_vtp`](crate::write_poly_vtp) write it, other formats leave it out.
    #[must_use]
    pub fn in_unit(mut self, unit: &'static str) -> Self {
        if let Some(last) = self.columns.last_mut() {
            last.unit = unit;
        }
        self
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of bytes of a row of a NumPy array.
    pub fn npy_row(&self) -> usize {
        self.plain().map(|column| column.values.size()).sum()
    }

    pub(crate) fn columns(&self) -> &[TableColumn<'a>] {
        &self.columns
    }

    /// The columns for formats without components: name, values, and the index of the value of a row.
    pub(super) fn plain(&self) -> impl Iterator<Item = Plain<'_>> {
        self.columns.iter().flat_map(|column| {
            let (values, width) = (&column.values, column.width());
            column.names().iter().enumerate().map(move |(component, name)| Plain {
                name,
                values,
                width,
                component,
            })
        })
    }
}

/// A column of one value per row.
pub(super) struct Plain<'t> {
    pub(super) name: &'t str,
    pub(super) values: &'t Values<'t>,
    pub(super) width: usize,
    pub(super) component: usize,
}

impl Plain<'_> {
    /// The index of the value of a row.
    pub(super) fn place(&self, row: usize) -> usize {
        row * self.width + self.component
    }
}
