//! Writes tables as Parquet.

use std::error::Error;
use std::io::{self, Write};
use std::ops::Range;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use crate::written::table::{Plain, Table, Values};

/// Number of rows per group. Readers load a group at a time, and a column of a group is kept in memory until
/// it is complete.
const GROUP: usize = 1 << 20;
/// Number of values passed on at a time.
const BATCH: usize = 1 << 14;

/// Writes a table as Parquet, compressed with Snappy; components become separate columns, as in
/// [`write_csv`](crate::write_csv).
///
/// All columns are required: no value is absent. Texts are UTF-8.
///
/// # Cost
/// Time proportional to the values; some 10 MB of memory. `out` is not flushed.
///
/// # Errors
/// The errors of `out`.
///
/// # Source
/// The Apache Parquet format, as written by the crate parquet.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_parquet};
///
/// let mut out = Vec::new();
/// write_parquet(&mut out, &Table::new(3).with("x", Values::f64(|k| k as f64)))?;
/// assert!(out.starts_with(b"PAR1") && out.ends_with(b"PAR1"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_parquet<W: Write + Send>(out: &mut W, table: &Table<'_>) -> io::Result<()> {
    write(out, table).map_err(io_error)
}

fn write<W: Write + Send>(out: &mut W, table: &Table<'_>) -> Result<(), ParquetError> {
    let columns: Vec<Plain<'_>> = table.plain().collect();
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("table").with_fields(fields).build()?;
    let mut properties = WriterProperties::builder()
        .set_created_by(concat!("fdem-io ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_compression(Compression::SNAPPY)
        // Floats seldom repeat, and integers are encoded by their differences.
        .set_dictionary_enabled(false)
        .set_statistics_enabled(EnabledStatistics::Chunk);
    for column in &columns {
        let path = ColumnPath::from(column.name);
        properties = match column.values {
            Values::F64(_) => properties.set_column_encoding(path, Encoding::PLAIN),
            Values::Text { .. } => properties.set_column_dictionary_enabled(path, true),
            _ => properties.set_column_encoding(path, Encoding::DELTA_BINARY_PACKED),
        };
    }
    let mut file = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties.build()))?;
    for start in (0..table.rows()).step_by(GROUP) {
        let rows = start..table.rows().min(start + GROUP);
        let mut group = file.next_row_group()?;
        for column in &columns {
            let mut writer = group.next_column()?.ok_or_else(|| {
                ParquetError::General("fewer columns in the file than in the table".to_owned())
            })?;
            write_column(&mut writer, column, rows.clone())?;
            writer.close()?;
        }
        group.close()?;
    }
    file.close().map(drop)
}

fn field(column: &Plain<'_>) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.values {
        Values::I32(_) => (Physical::INT32, None),
        Values::I64(_) => (Physical::INT64, None),
        Values::U64(_) => (Physical::INT64, Some(LogicalType::integer(64, false))),
        Values::F64(_) => (Physical::DOUBLE, None),
        Values::Text { .. } => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let builder = Type::primitive_type_builder(column.name, physical).with_repetition(Repetition::REQUIRED);
    builder.with_logical_type(logical).build().map(Arc::new)
}

fn write_column(
    writer: &mut SerializedColumnWriter<'_>,
    column: &Plain<'_>,
    rows: Range<usize>,
) -> Result<(), ParquetError> {
    for start in rows.clone().step_by(BATCH) {
        let places = (start..rows.end.min(start + BATCH)).map(|row| column.place(row));
        match column.values {
            Values::I32(at) => {
                let batch: Vec<_> = places.map(at).collect();
                writer.typed::<Int32Type>().write_batch(&batch, None, None)?;
            }
            Values::I64(at) => {
                let batch: Vec<_> = places.map(at).collect();
                writer.typed::<Int64Type>().write_batch(&batch, None, None)?;
            }
            Values::U64(at) => {
                let batch: Vec<_> = places.map(|place| at(place).cast_signed()).collect();
                writer.typed::<Int64Type>().write_batch(&batch, None, None)?;
            }
            Values::F64(at) => {
                let batch: Vec<_> = places.map(at).collect();
                writer.typed::<DoubleType>().write_batch(&batch, None, None)?;
            }
            Values::Text { at, .. } => {
                let batch: Vec<_> = places.map(|place| ByteArray::from(at(place))).collect();
                writer.typed::<ByteArrayType>().write_batch(&batch, None, None)?;
            }
        }
    }
    Ok(())
}

/// The error of the output, if it was the cause.
fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other as Box<dyn Error + Send + Sync>),
        },
        other => io::Error::other(other),
    }
}
