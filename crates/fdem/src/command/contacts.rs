//! `fdem contacts` reads a packing, finds its couples, writes them and shows a summary.

use crate::command::args::ContactsArguments;
use crate::command::couples::CoupleFile;
use crate::command::device;
use crate::command::device_name::DeviceName;
use crate::command::failure::Failure;
use crate::command::frames::Selection;
use crate::command::input;
use crate::command::labels;
use crate::command::meshes;
use crate::command::output::{is_stdout, refuse_to_overwrite};
use crate::command::outputs::Outputs;
use crate::command::packing::{explain, treat};
use crate::command::progress::Progress;
use crate::command::series;

pub(crate) fn run(arguments: &ContactsArguments) -> Result<(), Failure> {
    device::refuse(arguments)?;
    if arguments.labels.labels {
        return labels::run(arguments);
    }
    refuse_types(arguments)?;
    let inputs = || std::iter::once(&arguments.input.file).chain(&arguments.more);
    if inputs().filter(|file| is_stdout(file)).count() > 1 {
        return Err(Failure::Unusable("standard input can only be read once".to_owned()));
    }
    for input in inputs() {
        let mut files = vec![
            ("the input", Some(input)),
            ("--output", arguments.output.as_ref()),
            ("--json", arguments.json.as_ref()),
        ];
        files.extend(arguments.drawings.files());
        files.push(("--couples", arguments.couples.couples.as_ref()));
        files.push(("--body-table", arguments.meshes.body_table.as_ref()));
        refuse_to_overwrite(&files)?;
    }
    let progress = Progress::new(arguments.quiet);
    let outputs = Outputs::open(arguments)?;

    let opened =
        input::open(&arguments.input.file, arguments.input.format, arguments.input.max_memory, &progress)?;
    if arguments.couples.couples.is_some() && opened.is_mesh() {
        return Err(Failure::Unusable(format!("{}: --couples is for packings, this is a mesh", opened.name)));
    }
    if opened.is_mesh() && arguments.device != DeviceName::Cpu {
        return Err(Failure::Unusable(format!(
            "{}: --device gpu is for packings, this is a mesh",
            opened.name
        )));
    }
    if opened.is_mesh() || !arguments.more.is_empty() {
        return meshes::run(arguments, opened, &progress, outputs);
    }
    let only_of_meshes = [
        ("--body-table", arguments.meshes.body_table.is_some()),
        ("--self-contact", arguments.meshes.self_contact),
    ];
    if let Some((option, _)) = only_of_meshes.into_iter().find(|(_, given)| *given) {
        return Err(Failure::Unusable(format!("{}: {option} is for meshes, this is a packing", opened.name)));
    }
    let frames = opened.series()?;
    let frame = match opened.select(&frames, arguments.input.frames)? {
        Selection::One(frame) => frame,
        Selection::Series(_) if arguments.couples.couples.is_some() => {
            return Err(Failure::Unusable(format!(
                "{}: --couples needs one frame: choose it with --frames N",
                opened.name
            )));
        }
        Selection::Series(chosen) => {
            drop(outputs);
            return series::run(arguments, &opened, &frames, &chosen, &progress);
        }
    };
    let named;
    let (arguments, mut outputs) = if series::names_frames(arguments) {
        drop(outputs);
        named = series::of_frame(arguments, frame)?;
        (&named, Outputs::open(&named)?)
    } else {
        (arguments, outputs)
    };
    let mut input = opened.frame(&frames, frame, &arguments.input, arguments.named_columns(), &progress)?;
    input.seconds += opened.seconds;
    let of_several = frames.frames() > 1;
    drop(opened);

    if arguments.explain {
        return explain(arguments, &input, outputs);
    }
    let step = input.packing.frame.step;
    let file = CoupleFile::read(&arguments.couples, step, arguments.input.max_memory, &progress)?;
    let mut summary = treat(arguments, &progress, &input, file.as_ref(), &mut outputs)?;

    summary.frame = of_several.then_some(frame);
    // The summary is the last output, because it has the times of the others.
    summary.measure_peak();
    outputs.finish(&summary, arguments.quiet)
}

/// Refuses options that do not go with cut-offs by pairs of types, or without them.
fn refuse_types(arguments: &ContactsArguments) -> Result<(), Failure> {
    let by_types = arguments.pairs().is_some();
    let problem = if by_types && arguments.explain {
        "--explain estimates a search with one cut-off: give the largest, as --cutoff D"
    } else if by_types && arguments.couples.couples.is_some() {
        "--couples takes the couples from a file, whatever their types are: leave out --cutoff by pairs of types, or give one number"
    } else if !by_types && arguments.type_column.is_some() {
        "--type-column is for --cutoff by pairs of types, such as --cutoff H-C=1.3"
    } else {
        return Ok(());
    };
    Err(Failure::Unusable(problem.to_owned()))
}
