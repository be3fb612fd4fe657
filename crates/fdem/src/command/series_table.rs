//! One table of all frames of a series.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use fdem_io::{Packing, Spool, write_csv, write_csv_rows};
use fdem_results::network::Network;

use crate::command::failure::Failure;
use crate::command::output::{Output, TABLES, TableFormat, Written};
use crate::command::progress::Position;
use crate::command::tables::{frame_table, write_table};

/// Placeholder for the number of a frame in the name of an output.
pub(crate) const PLACE: &str = "{frame}";

/// Table of the couples of all frames. The first frame decides whether it has columns for shifts.
pub(crate) struct SeriesTable {
    name: PathBuf,
    output: Output,
    /// Number of columns for shifts; `None` before the first frame.
    shifts: Option<usize>,
    format: TableFormat,
    /// Rows of all frames, for formats that are written in one piece at the end.
    rows: Option<Spool<File>>,
}

impl SeriesTable {
    pub(crate) fn open(path: Option<&Path>) -> Result<Self, Failure> {
        let format = TableFormat::of(path)?;
        if !TABLES.contains(&format) {
            return Err(Failure::Unusable(format!(
                "--output: a table of several frames must end in .csv, .npy, .npz or .parquet; for a file per frame, put {PLACE} into its name"
            )));
        }
        let output = Output::open(path)?;
        let name = path.map_or_else(|| PathBuf::from("standard output"), Path::to_owned);
        let rows = (format != TableFormat::Csv).then(Spool::new);
        Ok(Self { name, output, shifts: None, format, rows })
    }

    /// Adds the couples of a frame.
    pub(crate) fn write<const D: usize>(
        &mut self,
        packing: &Packing,
        network: &Network<'_, D>,
        position: &Position,
    ) -> Result<(), Failure> {
        let is_first = self.shifts.is_none();
        let shifts = if network.space.cell.is_some() { D } else { 0 };
        let columns = *self.shifts.get_or_insert(shifts);
        // Without a periodic box, shifts are zero, and any number of columns holds them.
        if shifts != columns && shifts != 0 {
            let difference = match columns {
                0 => "its box is periodic, and that of the first frame is not".to_owned(),
                _ => format!("it is in {D}D, and the first frame is in {columns}D"),
            };
            return Err(Failure::Unusable(format!(
                "frame {}: {difference}: one table cannot hold both. Put {PLACE} into the name of the output, or give --periodic none",
                packing.frame.index
            )));
        }
        let table = frame_table(packing, network, columns, position);
        match &mut self.rows {
            None if is_first => self.output.write(|mut out| write_csv(&mut out, &table)),
            None => self.output.write(|mut out| write_csv_rows(&mut out, &table)),
            Some(rows) => {
                let folder = self.name.parent().filter(|folder| !folder.as_os_str().is_empty());
                let file = || tempfile::tempfile_in(folder.unwrap_or(Path::new(".")));
                // Only the kind is shown, because the error itself names the temporary file.
                let failed = |error: io::Error| match error.kind() {
                    io::ErrorKind::Other => Failure::writing(&self.name, error),
                    kind => Failure::writing(&self.name, io::Error::from(kind)),
                };
                rows.add(&table, file).map_err(failed)
            }
        }
    }

    pub(crate) fn close(mut self) -> Result<Written, Failure> {
        if let Some(rows) = self.rows.take() {
            write_table(&mut self.output, self.format, &rows.table())?;
            rows.check().map_err(|error| Failure::writing(&self.name, error))?;
        }
        self.output.close()
    }
}
