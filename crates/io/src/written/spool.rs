//! Rows of several tables as one table, kept in files until all are there.

use std::cell::RefCell;
use std::fmt;
use std::io::{self, Read, Seek, SeekFrom, Write};

use crate::written::table::{CHUNK, Table, Values};

/// Rows of several tables with the same columns, each column in a separate file.
///
/// Formats that begin with the number of rows, or that have whole columns, get all rows as one
/// [`Spool::table`].
///
/// # Cost
/// Memory: a block of 256 KiB for each column; the rows are in the files.
///
/// # Example
/// ```
/// use std::io::Cursor;
///
/// use fdem_io::{Spool, Table, Values, write_csv};
///
/// let mut spool = Spool::new();
/// for part in 0..2 {
///     let table = Table::new(2).with("k", Values::i64(move |row| 2 * part + row as i64));
///     spool.add(&table, || Ok(Cursor::new(Vec::new())))?;
/// }
/// let mut out = Vec::new();
/// write_csv(&mut out, &spool.table())?;
/// spool.check()?;
/// assert_eq!(out, b"k\n0\n1\n2\n3\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct Spool<F> {
    rows: usize,
    columns: Vec<Kept<F>>,
}

impl<F> fmt::Debug for Spool<F> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Spool").field("rows", &self.rows).field("columns", &self.columns.len()).finish()
    }
}

/// A column and its file.
struct Kept<F> {
    name: String,
    components: &'static [&'static str],
    kind: SpooledNumber,
    file: RefCell<Blocks<F>>,
}

/// The type of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SpooledNumber {
    I32,
    I64,
    U64,
    F64,
}

/// A file that is read a block at a time.
struct Blocks<F> {
    file: F,
    /// Where the block in memory starts, in bytes.
    start: u64,
    block: Vec<u8>,
    /// The first error; values read after it are 0.
    error: Option<io::Error>,
}

impl<F: Read + Write + Seek> Spool<F> {
    /// Without rows, and without columns until the first table is added.
    pub fn new() -> Self {
        Self { rows: 0, columns: Vec::new() }
    }

    /// Adds the rows of a table. `file` opens an empty file for each column of the first one.
    ///
    /// # Errors
    /// The errors of the files; [`io::ErrorKind::InvalidInput`] if the columns are not those of the first
    /// table, or one is of text.
    pub fn add(&mut self, table: &Table<'_>, mut file: impl FnMut() -> io::Result<F>) -> io::Result<()> {
        if self.columns.is_empty() {
            for column in table.columns() {
                let kind = kind(&column.values)?;
                let file = Blocks { file: file()?, start: 0, block: Vec::new(), error: None };
                self.columns.push(Kept {
                    name: column.name.to_owned(),
                    components: column.components,
                    kind,
                    file: RefCell::new(file),
                });
            }
        }
        let differs = || io::Error::new(io::ErrorKind::InvalidInput, "the tables have different columns");
        if self.columns.len() != table.columns().len() {
            return Err(differs());
        }
        for (kept, column) in self.columns.iter_mut().zip(table.columns()) {
            let same = kept.name == column.name && kept.components == column.components;
            if !same || kept.kind != kind(&column.values)? {
                return Err(differs());
            }
            let file = &mut kept.file.get_mut().file;
            file.seek(SeekFrom::End(0))?;
            column.write_array(table.rows(), file)?;
        }
        self.rows += table.rows();
        Ok(())
    }

    /// All rows. After it has been written, [`Self::check`] reports whether they could be read.
    pub fn table(&self) -> Table<'_> {
        self.columns.iter().fold(Table::new(self.rows), |table, column| {
            let values = column.values();
            if column.components.is_empty() {
                table.with(&column.name, values)
            } else {
                table.with_components(&column.name, column.components, values)
            }
        })
    }

    /// Whether all values of the table could be read from the files.
    ///
    /// # Errors
    /// The first error.
    pub fn check(self) -> io::Result<()> {
        self.columns.into_iter().find_map(|column| column.file.into_inner().error).map_or(Ok(()), Err)
    }
}

impl<F: Read + Write + Seek> Default for Spool<F> {
    fn default() -> Self {
        Self::new()
    }
}

impl<F: Read + Write + Seek> Kept<F> {
    fn values(&self) -> Values<'_> {
        let file = &self.file;
        match self.kind {
            SpooledNumber::I32 => Values::i32(|k| i32::from_le_bytes(file.borrow_mut().value(k))),
            SpooledNumber::I64 => Values::i64(|k| i64::from_le_bytes(file.borrow_mut().value(k))),
            SpooledNumber::U64 => Values::u64(|k| u64::from_le_bytes(file.borrow_mut().value(k))),
            SpooledNumber::F64 => Values::f64(|k| f64::from_le_bytes(file.borrow_mut().value(k))),
        }
    }
}

impl<F: Read + Seek> Blocks<F> {
    /// The bytes of value `k`.
    fn value<const N: usize>(&mut self, k: usize) -> [u8; N] {
        let at = (k * N) as u64;
        let held = self.start..self.start + self.block.len() as u64;
        if !held.contains(&at) {
            self.read(at);
        }
        let place = (at - self.start) as usize;
        self.block.get(place..place + N).and_then(|bytes| bytes.try_into().ok()).unwrap_or_else(|| {
            let ended =
                || io::Error::new(io::ErrorKind::UnexpectedEof, "a temporary file has become shorter");
            self.error.get_or_insert_with(ended);
            [0; N]
        })
    }

    /// Reads the block that holds the byte `at`. Blocks start at multiples of their size, which is one of
    /// that of every value.
    fn read(&mut self, at: u64) {
        self.start = at - at % CHUNK as u64;
        self.block.clear();
        let read = self
            .file
            .seek(SeekFrom::Start(self.start))
            .and_then(|_| self.file.by_ref().take(CHUNK as u64).read_to_end(&mut self.block));
        if let Err(error) = read {
            self.error.get_or_insert(error);
        }
    }
}

fn kind(values: &Values<'_>) -> io::Result<SpooledNumber> {
    match values {
        Values::I32(_) => Ok(SpooledNumber::I32),
        Values::I64(_) => Ok(SpooledNumber::I64),
        Values::U64(_) => Ok(SpooledNumber::U64),
        Values::F64(_) => Ok(SpooledNumber::F64),
        Values::Text { .. } => Err(io::Error::new(io::ErrorKind::InvalidInput, "text is not kept in files")),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::write_csv;

    /// A buffer in memory in place of a temporary file.
    fn file() -> Cursor<Vec<u8>> {
        Cursor::new(Vec::new())
    }

    /// Values on both sides of the border of a block come back, in any order.
    #[test]
    fn values_come_back_from_every_block() {
        let mut spool = Spool::new();
        let rows = CHUNK / 8;
        for part in 0..3 {
            let from = part * rows;
            let table = Table::new(rows).with("x", Values::f64(move |k| (from + k) as f64)).with_components(
                "s",
                &["a", "b", "c"],
                Values::i32(move |k| (3 * from + k).try_into().unwrap()),
            );
            spool.add(&table, || Ok(file())).unwrap();
        }
        let table = spool.table();
        assert_eq!(table.rows(), 3 * rows);
        let Values::F64(x) = &table.columns()[0].values else { panic!("no floats") };
        let Values::I32(s) = &table.columns()[1].values else { panic!("no whole numbers") };
        for k in [0, 3 * rows - 1, rows, rows - 1, 1, 2 * rows] {
            assert_eq!((x(k), s(3 * k + 2)), (k as f64, i32::try_from(3 * k + 2).unwrap()));
        }
        drop(table);
        spool.check().unwrap();
    }

    #[test]
    fn other_columns_are_refused() {
        let mut spool = Spool::new();
        spool.add(&Table::new(1).with("x", Values::f64(|_| 0.0)), || Ok(file())).unwrap();
        for other in [
            Table::new(1),
            Table::new(1).with("y", Values::f64(|_| 0.0)),
            Table::new(1).with("x", Values::i64(|_| 0)),
        ] {
            assert!(spool.add(&other, || Ok(file())).is_err());
        }
        assert!(Spool::new().add(&Table::new(1).with("t", Values::text(1, |_| "a")), || Ok(file())).is_err());
    }

    /// A file that ends too early is an error, not zeros.
    #[test]
    fn a_shorter_file_is_an_error() {
        let mut spool = Spool::new();
        spool.add(&Table::new(9).with("x", Values::f64(|_| 1.0)), || Ok(file())).unwrap();
        spool.columns[0].file.get_mut().file.get_mut().truncate(20);
        write_csv(&mut Vec::new(), &spool.table()).unwrap();
        assert_eq!(spool.check().unwrap_err().kind(), io::ErrorKind::UnexpectedEof);
    }
}
