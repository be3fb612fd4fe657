//! `fdem contacts` of several frames: one table of all, or a file for each.

use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use fdem_io::{
    CoupleRow, Frame, Series, write_frame_csv, write_frame_npy, write_series_header_csv,
    write_series_header_npy,
};

use crate::command::args::ContactsArguments;
use crate::command::contacts::{self, Outputs};
use crate::command::failure::Failure;
use crate::command::input::Opened;
use crate::command::output::{Output, Table, Written, refuse_to_overwrite};
use crate::command::progress::Progress;
use crate::command::series_summary::SeriesSummary;

/// What stands for the number of a frame in the name of an output.
const PLACE: &str = "{frame}";

/// Treats frame after frame; only one is in memory.
pub(crate) fn run(
    arguments: &ContactsArguments,
    opened: &Opened,
    frames: &Series<'_>,
    chosen: &[usize],
    progress: &Progress,
) -> Result<(), Failure> {
    refuse_options_of_one_frame(arguments, &opened.name)?;
    let is_shared = |path: &Option<PathBuf>| !path.as_deref().is_some_and(names_frame);
    let one_table = is_shared(&arguments.output) && !arguments.count;
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
        // A summary that nobody can see any more is no failure.
        let _ = write!(io::stderr(), "{summary}");
    }
    Ok(())
}

fn refuse_options_of_one_frame(arguments: &ContactsArguments, name: &str) -> Result<(), Failure> {
    let refused = |problem: &str| Err(Failure::Unusable(format!("{name}: {problem}")));
    if arguments.explain {
        return refused("--explain tells of one frame: choose it with --frames N");
    }
    if arguments.picture.as_deref().is_some_and(|path| !names_frame(path)) {
        return refused(
            "--picture draws one frame: choose it with --frames N, or put {frame} into the name of the picture",
        );
    }
    Ok(())
}

fn names_frame(path: &Path) -> bool {
    path.to_str().is_some_and(|name| name.contains(PLACE))
}

/// The outputs that may be named after frames.
fn names(arguments: &ContactsArguments) -> [&Option<PathBuf>; 3] {
    [&arguments.output, &arguments.json, &arguments.picture]
}

/// Whether any output is named after its frame.
pub(crate) fn names_frames(arguments: &ContactsArguments) -> bool {
    names(arguments).into_iter().flatten().any(|path| names_frame(path))
}

/// The arguments with the number of the frame in the names of the outputs.
pub(crate) fn of_frame(arguments: &ContactsArguments, frame: usize) -> Result<ContactsArguments, Failure> {
    let mut own = arguments.clone();
    for path in [&mut own.output, &mut own.json, &mut own.picture].into_iter().flatten() {
        if let Some(name) = path.to_str().filter(|name| name.contains(PLACE)) {
            *path = name.replace(PLACE, &frame.to_string()).into();
        }
    }
    let [output, json, picture] = names(&own).map(Option::as_ref);
    refuse_to_overwrite(&[
        ("the input", Some(&own.input.file)),
        ("--output", output),
        ("--json", json),
        ("--picture", picture),
    ])?;
    Ok(own)
}

/// One table of the couples of all frames. The first frame decides whether it has columns for shifts.
pub(crate) struct SeriesTable {
    name: PathBuf,
    output: Output,
    /// How many shifts a row has, from the first frame on.
    shifts: Option<usize>,
    /// The rows of an array, whose header tells how many there are.
    rows: Option<(File, u64)>,
}

impl SeriesTable {
    fn open(path: Option<&Path>) -> Result<Self, Failure> {
        let (table, output) = (Table::of(path)?, Output::open(path)?);
        let name = path.map_or_else(|| PathBuf::from("standard output"), Path::to_owned);
        let rows = match table {
            Table::Csv => None,
            Table::Npy => {
                let folder = name.parent().filter(|folder| !folder.as_os_str().is_empty());
                let file = tempfile::tempfile_in(folder.unwrap_or(Path::new(".")));
                let failed = |error: io::Error| Failure::writing(&name, io::Error::from(error.kind()));
                Some((file.map_err(failed)?, 0))
            }
        };
        Ok(Self { name, output, shifts: None, rows })
    }

    /// Adds the couples of a frame.
    pub(crate) fn write<const S: usize>(
        &mut self,
        frame: Frame,
        rows: impl Iterator<Item = CoupleRow<S>>,
    ) -> Result<(), Failure> {
        if self.shifts.is_none() && self.rows.is_none() {
            self.output.write(write_series_header_csv::<S>)?;
        }
        match *self.shifts.get_or_insert(S) {
            shifts if shifts == S => self.add(frame, rows),
            // What does not repeat is not displaced.
            2 if S == 0 => self.add(frame, rows.map(widened::<S, 2>)),
            3 if S == 0 => self.add(frame, rows.map(widened::<S, 3>)),
            _ => Err(Failure::Unusable(format!(
                "frame {}: its box repeats along other edges than that of the first frame, or in another dimension: one table cannot hold both. Put \
                 {PLACE} into the name of the output, or give --periodic",
                frame.index
            ))),
        }
    }

    fn add<const S: usize>(
        &mut self,
        frame: Frame,
        rows: impl Iterator<Item = CoupleRow<S>>,
    ) -> Result<(), Failure> {
        match &mut self.rows {
            None => self.output.write(|out| write_frame_csv(out, frame, rows)),
            Some((file, count)) => {
                let added = write_frame_npy(file, frame, rows);
                *count += added.map_err(|error| Failure::writing(&self.name, error))?;
                Ok(())
            }
        }
    }

    fn close(mut self) -> Result<Written, Failure> {
        if let Some((mut file, count)) = self.rows.take() {
            let shifts = self.shifts.unwrap_or(0);
            self.output.write(|out| {
                match shifts {
                    2 => write_series_header_npy::<2>(out, count),
                    3 => write_series_header_npy::<3>(out, count),
                    _ => write_series_header_npy::<0>(out, count),
                }?;
                file.rewind()?;
                io::copy(&mut file, out).map(drop)
            })?;
        }
        self.output.close()
    }
}

fn widened<const S: usize, const W: usize>(row: CoupleRow<S>) -> CoupleRow<W> {
    let CoupleRow { i, j, distance, overlap, .. } = row;
    CoupleRow { i, j, distance, overlap, shift: [0; W] }
}
