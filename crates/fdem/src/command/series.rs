//! `fdem contacts` for several frames: one table of all frames, or a file per frame.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use fdem_io::{Packing, Series, Spool, write_csv, write_csv_rows};
use fdem_results::network::Network;

use crate::command::args::ContactsArguments;
use crate::command::contacts::{self, Outputs, show};
use crate::command::failure::{Failure, display_name};
use crate::command::input::Opened;
use crate::command::output::{Output, TABLES, TableFormat, Written, is_stdout, refuse_to_overwrite};
use crate::command::progress::{Position, Progress};
use crate::command::series_summary::SeriesSummary;
use crate::command::tables::{frame_table, write_table};

/// Placeholder for the number of a frame in the name of an output.
const PLACE: &str = "{frame}";

/// Treats one frame after the other. Only one packing is in memory.
pub(crate) fn run(
    arguments: &ContactsArguments,
    opened: &Opened,
    frames: &Series<'_>,
    chosen: &[usize],
    progress: &Progress,
) -> Result<(), Failure> {
    refuse_options_of_one_frame(arguments, &opened.name)?;
    let is_shared = |path: &Option<PathBuf>| !path.as_deref().is_some_and(names_frame);
    let one_table = is_shared(&arguments.output) && arguments.writes_couples();
    let mut table = one_table.then(|| SeriesTable::open(arguments.output.as_deref())).transpose()?;
    let mut json = match &arguments.json {
        Some(path) if !names_frame(path) => Some(Output::open(Some(path))?),
        _ => None,
    };
    let mut written: Vec<Written> = Vec::new();
    let mut summary = SeriesSummary::new(frames.frames(), opened.seconds);
    for &frame in chosen {
        let mut own = of_frame(arguments, frame)?;
        own.output.take_if(|_| is_shared(&arguments.output));
        own.json.take_if(|_| is_shared(&arguments.json));
        let mut outputs = Outputs::open(&own)?;
        outputs.series = table.take();
        let input = opened.frame(frames, frame, &own.input, own.bodies.as_deref(), progress)?;
        let mut of_frame = contacts::treat(&own, progress, &input, &mut outputs)?;
        of_frame.frame = Some(frame);
        of_frame.measure_peak();
        table = outputs.series.take();
        outputs.tell(&of_frame)?;
        written.extend(outputs.close()?);
        summary.push(of_frame);
    }
    summary.measure_peak();
    if let Some(table) = table {
        written.push(table.close()?);
    }
    if let Some(mut json) = json.take() {
        json.write(|out| {
            serde_json::to_writer_pretty(&mut *out, &summary.frames)?;
            out.write_all(b"\n")
        })?;
        written.push(json.close()?);
    }
    written.into_iter().try_for_each(Written::commit)?;
    if !arguments.quiet {
        show(&summary, &files(arguments, chosen));
    }
    Ok(())
}

/// Returns a line for each output: the name of a file of all frames, or the name and the frames of files per frame.
fn files(arguments: &ContactsArguments, chosen: &[usize]) -> Vec<String> {
    let frames = match chosen {
        [frame] => format!("frame {frame}"),
        [first, .., last] => format!("{} files, frame {first} to {last}", chosen.len()),
        [] => String::new(),
    };
    let paths = names(arguments).into_iter().flatten().filter(|path| !is_stdout(path));
    let named = paths.map(|path| {
        if names_frame(path) { format!("{}: {frames}", display_name(path)) } else { display_name(path) }
    });
    named.collect()
}

fn refuse_options_of_one_frame(arguments: &ContactsArguments, name: &str) -> Result<(), Failure> {
    let refused = |problem: &str| Err(Failure::Unusable(format!("{name}: {problem}")));
    if arguments.explain {
        return refused("--explain needs one frame: choose it with --frames N");
    }
    if arguments.analysis.analyse && arguments.json.is_none() {
        return refused(
            "--analyse of several frames is written only to --json: give --json FILE, or choose a frame with --frames N",
        );
    }
    for (option, path) in arguments.drawings.files() {
        if path.is_some_and(|path| !names_frame(path)) {
            return refused(&format!(
                "{option} shows one frame: choose it with --frames N, or put {{frame}} into the name of the file"
            ));
        }
    }
    Ok(())
}

fn names_frame(path: &Path) -> bool {
    path.to_str().is_some_and(|name| name.contains(PLACE))
}

/// Outputs whose names may contain the number of a frame.
fn names(arguments: &ContactsArguments) -> [&Option<PathBuf>; 5] {
    let drawings = &arguments.drawings;
    [&arguments.output, &arguments.json, &drawings.picture, &drawings.plots, &drawings.report]
}

/// Whether the name of any output contains the placeholder of a frame.
pub(crate) fn names_frames(arguments: &ContactsArguments) -> bool {
    names(arguments).into_iter().flatten().any(|path| names_frame(path))
}

/// Returns the arguments with the number of the frame inserted into the names of the outputs.
pub(crate) fn of_frame(arguments: &ContactsArguments, frame: usize) -> Result<ContactsArguments, Failure> {
    let mut own = arguments.clone();
    let drawings = &mut own.drawings;
    let names =
        [&mut own.output, &mut own.json, &mut drawings.picture, &mut drawings.plots, &mut drawings.report];
    for path in names.into_iter().flatten() {
        if let Some(name) = path.to_str().filter(|name| name.contains(PLACE)) {
            *path = name.replace(PLACE, &frame.to_string()).into();
        }
    }
    let mut files = vec![
        ("the input", Some(&own.input.file)),
        ("--output", own.output.as_ref()),
        ("--json", own.json.as_ref()),
    ];
    files.extend(own.drawings.files());
    refuse_to_overwrite(&files)?;
    Ok(own)
}

/// Table of the couples of all frames. The first frame decides whether it has columns for shifts.
pub(crate) struct SeriesTable {
    name: PathBuf,
    output: Output,
    /// Number of columns for shifts; `None` before the first frame.
    shifts: Option<usize>,
    format: TableFormat,
    /// Rows of all frames, for formats that are written at once at the end.
    rows: Option<Spool<File>>,
}

impl SeriesTable {
    fn open(path: Option<&Path>) -> Result<Self, Failure> {
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
            return Err(Failure::Unusable(format!(
                "frame {}: its box has other periodic edges than that of the first frame, or another dimension: one table cannot hold both. Put \
                 {PLACE} into the name of the output, or give --periodic",
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

    fn close(mut self) -> Result<Written, Failure> {
        if let Some(rows) = self.rows.take() {
            write_table(&mut self.output, self.format, &rows.table())?;
            rows.check().map_err(|error| Failure::writing(&self.name, error))?;
        }
        self.output.close()
    }
}
