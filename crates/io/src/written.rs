//! Tables to be written: columns with names and types, the values of which are worked out where they are written.

mod csv;
mod graph;
mod npy;
mod npz;
mod parquet;
mod vtp;

use std::fmt;
use std::io::{self, Write};
use std::ops::Range;

pub use csv::{write_csv, write_csv_rows};
pub use graph::{write_graphml, write_node_link};
pub use npy::{write_npy, write_npy_header, write_npy_rows};
pub use npz::write_npz;
pub use parquet::write_parquet;
pub use vtp::write_vtp;

/// Bytes gathered before they are written: large enough that a file gets few writes, small enough for a cache.
pub(crate) const CHUNK: usize = 1 << 18;

/// The value at a place.
type At<'a, T> = Box<dyn Fn(usize) -> T + 'a>;

/// The values of a column, each worked out when it is asked for, perhaps more than once: nothing is stored.
pub enum Values<'a> {
    /// Whole numbers of 32 bits.
    I32(At<'a, i32>),
    /// Whole numbers of 64 bits.
    I64(At<'a, i64>),
    /// Whole numbers of 64 bits without sign.
    U64(At<'a, u64>),
    /// Floats.
    F64(At<'a, f64>),
    /// Texts of letters, digits and underscores.
    Text {
        /// Bytes of the longest; what is longer is cut in arrays.
        width: usize,
        /// The text at a place.
        at: At<'a, &'static str>,
    },
}

impl<'a> Values<'a> {
    /// Whole numbers of 32 bits.
    pub fn i32(at: impl Fn(usize) -> i32 + 'a) -> Self {
        Self::I32(Box::new(at))
    }

    /// Whole numbers of 64 bits.
    pub fn i64(at: impl Fn(usize) -> i64 + 'a) -> Self {
        Self::I64(Box::new(at))
    }

    /// Whole numbers of 64 bits without sign.
    pub fn u64(at: impl Fn(usize) -> u64 + 'a) -> Self {
        Self::U64(Box::new(at))
    }

    /// Floats.
    pub fn f64(at: impl Fn(usize) -> f64 + 'a) -> Self {
        Self::F64(Box::new(at))
    }

    /// Texts of `width` bytes at most.
    pub fn text(width: usize, at: impl Fn(usize) -> &'static str + 'a) -> Self {
        Self::Text { width, at: Box::new(at) }
    }

    /// The type as NumPy spells it.
    fn dtype(&self) -> String {
        match self {
            Self::I32(_) => "<i4".to_owned(),
            Self::I64(_) => "<i8".to_owned(),
            Self::U64(_) => "<u8".to_owned(),
            Self::F64(_) => "<f8".to_owned(),
            Self::Text { width, .. } => format!("|S{width}"),
        }
    }

    /// Bytes of a value in an array.
    pub(crate) fn size(&self) -> usize {
        match self {
            Self::I32(_) => 4,
            Self::I64(_) | Self::U64(_) | Self::F64(_) => 8,
            Self::Text { width, .. } => *width,
        }
    }

    /// Appends values as an array in memory has them, the lowest byte first.
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

/// A name and its values: a number for each row, or several, as a point has.
pub(crate) struct Column<'a> {
    /// Name of the whole, where a format has arrays of several columns.
    pub(crate) name: &'static str,
    /// Names of the components, where it has not; none if it is plain.
    pub(crate) components: &'static [&'static str],
    /// Component `c` of row `k` is at `k * width + c`.
    pub(crate) values: Values<'a>,
}

impl Column<'_> {
    /// Values in a row.
    pub(crate) fn width(&self) -> usize {
        self.components.len().max(1)
    }

    /// Names of its columns in a format of plain columns.
    fn names(&self) -> &[&'static str] {
        if self.components.is_empty() { std::slice::from_ref(&self.name) } else { self.components }
    }

    /// Writes all values of `rows` rows, as an array in memory has them.
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

/// Rows of named and typed columns.
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
    columns: Vec<Column<'a>>,
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

    /// With one more column: value `k` is that of row `k`.
    ///
    /// Names are letters, digits and underscores.
    #[must_use]
    pub fn with(mut self, name: &'static str, values: Values<'a>) -> Self {
        self.columns.push(Column { name, components: &[], values });
        self
    }

    /// With a column of several components, which are columns of their own where a format has no such thing: component `c` of row `k` is value
    /// `k * components.len() + c`.
    #[must_use]
    pub fn with_components(
        mut self,
        name: &'static str,
        components: &'static [&'static str],
        values: Values<'a>,
    ) -> Self {
        self.columns.push(Column { name, components, values });
        self
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn columns(&self) -> &[Column<'a>] {
        &self.columns
    }

    /// Columns as formats of plain ones have them: name, values, and the place of the value of a row.
    fn plain(&self) -> impl Iterator<Item = Plain<'_>> {
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

/// A column of one value for each row.
struct Plain<'t> {
    name: &'static str,
    values: &'t Values<'t>,
    width: usize,
    component: usize,
}

impl Plain<'_> {
    /// Where the value of a row is.
    fn place(&self, row: usize) -> usize {
        row * self.width + self.component
    }
}
