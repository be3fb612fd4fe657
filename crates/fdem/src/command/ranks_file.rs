//! A file that all ranks write together.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use fdem_distributed::Communicator;
use fdem_io::Table;

use crate::command::args::ContactsArguments;
use crate::command::failure::{Failure, display_name};
use crate::command::output::{Output, TableFormat};
use crate::command::ranks::{agree, gather_counts};

/// A file that all ranks write. Rank 0 creates it under another name, and renames it at the end.
pub(super) struct SharedFile {
    format: TableFormat,
    /// The output, on rank 0.
    output: Option<Output>,
    /// The partial file, on the other ranks.
    file: Option<File>,
}

impl SharedFile {
    /// Rank 0 creates the partial file, and the others open it. Therefore a folder that the machines do not
    /// share is noticed before anything is read.
    pub(super) fn open(
        arguments: &ContactsArguments,
        communicator: &dyn Communicator,
    ) -> Result<Self, Failure> {
        let Some(name) = arguments.output.as_deref() else {
            return Ok(Self { format: TableFormat::Csv, output: None, file: None });
        };
        let mut shared = Self { format: TableFormat::of(Some(name))?, output: None, file: None };
        let mut path = Vec::new();
        if communicator.rank() == 0 {
            let opened = Output::open(Some(name)).and_then(|output| {
                let part = output
                    .partial()
                    .ok_or_else(|| Failure::writing(name, "several ranks need a file, not a device"))?;
                let part = std::path::absolute(part).map_err(|error| Failure::writing(name, error))?;
                let text = part
                    .to_str()
                    .ok_or_else(|| Failure::writing(name, "its folder has a name that is not UTF-8"))?;
                path.extend(text.bytes());
                Ok(output)
            });
            shared.output = agree(communicator, opened.map(Some))?;
        } else {
            agree(communicator, Ok(()))?;
        }
        communicator.broadcast(&mut path);
        if communicator.rank() > 0 {
            let path = String::from_utf8_lossy(&path).into_owned();
            let opened = File::options().write(true).open(&path).map_err(|error| {
                let folder = Path::new(&path).parent().map(display_name).unwrap_or_default();
                let why =
                    format!("the file that rank 0 has made in {folder} cannot be opened here ({error})");
                Failure::writing(
                    name,
                    format!("{why}; the folder must be on a file system that all machines share"),
                )
            });
            shared.file = agree(communicator, opened.map(Some))?;
        } else {
            agree(communicator, Ok(()))?;
        }
        Ok(shared)
    }

    /// Writes the rows of all ranks, one rank after the other in the file, and waits until the disk has them.
    pub(super) fn write(
        &mut self,
        communicator: &dyn Communicator,
        table: &Table<'_>,
    ) -> Result<(), Failure> {
        let format = self.format;
        let rows = |mut out: &mut dyn Write| match format {
            TableFormat::Npy => fdem_io::write_npy_rows(&mut out, table),
            _ => fdem_io::write_csv_rows(&mut out, table),
        };
        let all_rows: u64 = gather_counts(communicator, table.rows() as u64).iter().sum();
        let mut header = Vec::new();
        // The text is made twice: its length says where the next rank writes.
        let mut counter = Counter(0);
        let counted = match format {
            TableFormat::Npy => {
                counter.0 = (table.npy_row() * table.rows()) as u64;
                fdem_io::write_npy_header(&mut header, table, all_rows)
            }
            _ => rows(&mut counter).and_then(|()| fdem_io::write_csv_header(&mut header, table)),
        };
        let failed = |error: io::Error| Failure::Unusable(format!("cannot write the couples: {error}"));
        agree(communicator, counted.map_err(failed))?;
        let length = counter.0;
        if communicator.rank() > 0 {
            header.clear();
        }
        let lengths = gather_counts(communicator, length + header.len() as u64);
        let start: u64 = lengths[..communicator.rank()].iter().sum();
        let written = match (&mut self.output, &mut self.file) {
            (Some(output), _) => output.write(|out| {
                out.write_all(&header)?;
                rows(out)
            }),
            (None, Some(file)) => write_at(file, start, rows).map_err(failed),
            (None, None) => Ok(()),
        };
        agree(communicator, written)
    }

    /// Closes the file on all ranks, which must be before it is renamed. Returns the output, on rank 0.
    /// Collective.
    pub(super) fn close(self, communicator: &dyn Communicator) -> Option<Output> {
        drop(self.file);
        communicator.barrier();
        self.output
    }
}

fn write_at(file: &mut File, start: u64, rows: impl Fn(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    file.seek(SeekFrom::Start(start))?;
    let mut out = BufWriter::new(&mut *file);
    rows(&mut out)?;
    out.flush()?;
    drop(out);
    file.sync_all()
}

/// Counts bytes, and keeps none.
struct Counter(u64);

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
