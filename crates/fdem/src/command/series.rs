//! `fdem contacts` for several frames: one table of all frames, or a file per frame.

use std::path::{Path, PathBuf};

use fdem_io::Series;

use crate::command::args::ContactsArguments;
use crate::command::failure::{Failure, display_name};
use crate::command::input::Opened;
use crate::command::output::{Output, Written, is_stdout, refuse_to_overwrite};
use crate::command::outputs::{Outputs, show};
use crate::command::packing;
use crate::command::progress::Progress;
use crate::command::series_summary::SeriesSummary;
use crate::command::series_table::{PLACE, SeriesTable};

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
        let input = opened.frame(frames, frame, &own.input, own.named_columns(), progress)?;
        let mut of_frame = packing::treat(&own, progress, &input, None, &mut outputs)?;
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

/// Returns a line for each output: the name of a file of all frames, or the name and the frames of files per
/// frame.
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
