//! The files that `fdem contacts` writes.

use std::fmt;
use std::io::{self, Write};

use serde::Serialize;

use crate::command::args::ContactsArguments;
use crate::command::drawings::Drawings;
use crate::command::failure::Failure;
use crate::command::output::{Output, TABLES, TableFormat, Written};
use crate::command::series_table::SeriesTable;

/// The files that the command writes. All appear together at the end.
pub(crate) struct Outputs {
    /// The table of all frames of a series, in place of `couples`.
    pub(crate) series: Option<SeriesTable>,
    pub(crate) table: TableFormat,
    /// `None` if only drawings are requested.
    pub(crate) couples: Option<Output>,
    pub(crate) json: Option<Output>,
    pub(crate) drawings: Drawings,
    /// Table of the bodies that touch, for meshes.
    pub(crate) bodies: Option<(TableFormat, Output)>,
}

impl Outputs {
    pub(crate) fn open(arguments: &ContactsArguments) -> Result<Self, Failure> {
        let output = arguments.output.as_deref();
        let optional = |path: &Option<_>| path.as_deref().map(|path| Output::open(Some(path))).transpose();
        Ok(Self {
            series: None,
            table: TableFormat::of(output)?,
            couples: match output {
                None if !arguments.writes_couples() && !arguments.count => None,
                output => Some(Output::open(output)?),
            },
            json: optional(&arguments.json)?,
            drawings: Drawings::open(&arguments.drawings)?,
            bodies: match &arguments.meshes.body_table {
                Some(path) => Some((TableFormat::among(&TABLES, Some(path))?, Output::open(Some(path))?)),
                None => None,
            },
        })
    }

    /// Writes the number of couples in place of the couples.
    pub(crate) fn count(&mut self, couples: u64) -> Result<(), Failure> {
        self.couples.as_mut().map_or(Ok(()), |output| output.write(|out| writeln!(out, "{couples}")))
    }

    /// Writes the summary as JSON, puts all files in place, and shows the summary with their names.
    pub(crate) fn finish(
        mut self,
        summary: &(impl Serialize + fmt::Display),
        quiet: bool,
    ) -> Result<(), Failure> {
        self.tell(summary)?;
        let files = self.all();
        let names: Vec<_> = files.iter().filter_map(Output::file_name).collect();
        files.into_iter().try_for_each(Output::commit)?;
        if !quiet {
            show(summary, &names);
        }
        Ok(())
    }

    /// Writes the summary as JSON.
    pub(crate) fn tell(&mut self, summary: &impl Serialize) -> Result<(), Failure> {
        let Some(json) = &mut self.json else { return Ok(()) };
        json.write(|out| {
            serde_json::to_writer_pretty(&mut *out, summary)?;
            out.write_all(b"\n")
        })
    }

    /// Closes all files. They appear at [`Written::commit`].
    pub(crate) fn close(self) -> Result<Vec<Written>, Failure> {
        self.all().into_iter().map(Output::close).collect()
    }

    /// Puts all files in place.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        self.all().into_iter().try_for_each(Output::commit)
    }

    /// Returns all outputs. The summary as JSON comes last, because it has the times of the others.
    fn all(self) -> Vec<Output> {
        let bodies = self.bodies.map(|(_, output)| output);
        self.couples.into_iter().chain(bodies).chain(self.drawings.outputs()).chain(self.json).collect()
    }
}

/// Shows a summary, and the names of the files that were written, on standard error.
pub(crate) fn show(summary: &impl fmt::Display, files: &[String]) {
    let mut text = summary.to_string();
    for (k, file) in files.iter().enumerate() {
        let label = if k == 0 { "written" } else { "" };
        text.extend([&format!("{label:<16} {file}"), "\n"]);
    }
    // A summary that cannot be shown is not an error.
    let _ = io::stderr().write_all(text.as_bytes());
}
