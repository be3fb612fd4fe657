//! `fdem check` reports errors, warnings and estimates of a model before it runs.

mod picture;

use std::fs::{self, File};
use std::io::{IsTerminal, Read, Write};
use std::path::Path;

use serde_json::{Value, json};

use crate::command::args::CheckArguments;
use crate::command::failure::{Failure, display_name};
use crate::command::memory;
use crate::command::output::{Output, is_device, print, refuse_to_overwrite};
use crate::command::progress::Progress;
use crate::command::run::folder::{INPUTS, SUMMARY};
use fdem_io::numbers::grouped;
use fdem_model::{
    AnyPrepared, BodyBox, Drawing, ModelErrors, Preflight, Prepared, Rehearsal, Setting, prepare_any_with,
    prepare_coarse, schema, with_values,
};

/// Largest model file, bytes. The check against the schema and the errors need its text in memory.
const LARGEST: u64 = 64 << 20;

pub(crate) fn run(arguments: &CheckArguments) -> Result<(), Failure> {
    if arguments.schema {
        let text = serde_json::to_string_pretty(&schema())
            .map_err(|error| Failure::Unusable(format!("cannot write the schema: {error}")))?;
        return print(&format!("{text}\n"));
    }
    let Some(path) = &arguments.model else {
        return Err(Failure::Unusable("no model file is given".to_owned()));
    };
    refuse_to_overwrite(&[("the model", Some(path)), ("--picture", arguments.picture.as_ref())])?;
    match (preflight(path, arguments), arguments.json) {
        (Ok(preflight), false) => print(&preflight.to_string()),
        (Ok(preflight), true) => {
            let text = serde_json::to_string_pretty(&preflight)
                .map_err(|error| Failure::Unusable(format!("cannot write the preflight: {error}")))?;
            print(&format!("{text}\n"))
        }
        (Err(problem), json) => {
            if json {
                print(&format!("{:#}\n", problem.json()))?;
            }
            Err(problem.failure())
        }
    }
}

/// Why a model cannot run.
enum Problem {
    /// Errors in the file.
    Model(ModelErrors),
    /// The file cannot be read, or its model cannot be simulated.
    Other(Failure),
}

impl Problem {
    fn failure(self) -> Failure {
        match self {
            Self::Model(errors) => refused(&errors),
            Self::Other(failure) => failure,
        }
    }

    /// An object with a list `errors`. Each error has a `message`; errors in the file also have `file`,
    /// `line`, `label` and `help`.
    fn json(&self) -> Value {
        let errors: Vec<Value> = match self {
            Self::Model(errors) => errors
                .faults
                .iter()
                .map(|fault| {
                    json!({
                        "message": fault.message,
                        "file": errors.file(fault),
                        "line": errors.line(fault),
                        "label": fault.span.as_ref().map(|_| &fault.label),
                        "help": fault.help,
                    })
                })
                .collect(),
            Self::Other(failure) => vec![json!({ "message": failure.to_string() })],
        };
        json!({ "errors": errors })
    }
}

/// Boxes of bodies that are printed.
const BOXES: usize = 6;

/// Reads, checks and meshes a model file, and draws it if a picture is requested. Paths in the file are
/// relative to its folder. Prints the boxes of the bodies before they are meshed.
fn preflight(path: &Path, arguments: &CheckArguments) -> Result<Preflight, Problem> {
    let name = display_name(path);
    let CheckArguments { set, ranks, picture, picture_width, .. } = arguments;
    let text = read_text(path).and_then(|text| with_settings(text, path, set)).map_err(Problem::Other)?;
    // A folder that cannot be written is an error before the mesh.
    let output = picture.as_deref().map(|file| Output::open(Some(file)).map(|output| (file, output)));
    let output = output.transpose().map_err(Problem::Other)?;
    let watch = &mut |boxes: &[BodyBox]| {
        let mut lines: Vec<String> =
            boxes.iter().take(BOXES).map(|body| format!("box              {body}\n")).collect();
        if boxes.len() > BOXES {
            lines.push(format!("                 and {} more\n", grouped((boxes.len() - BOXES) as u64)));
        }
        if !arguments.json {
            // Standard output has the summary, and nothing if the model is refused.
            let _ = std::io::stderr().write_all(lines.concat().as_bytes());
        }
    };
    let mut load = inputs_of(path);
    let progress = Progress::new(false);
    let (prepared, _) = progress.step("meshing the model", None, |_| {
        prepare_any_with(&text, &name, &mut load, memory::free(), watch)
    });
    let prepared = prepared.map_err(Problem::Model)?;
    if let Some((file, mut output)) = output {
        let (drawn, _) = progress
            .step("drawing the model", None, |_| picture::draw(&prepared, &name, file, *picture_width));
        let bytes = drawn
            .map_err(|error| Problem::Other(Failure::Unusable(format!("{}: {error}", display_name(file)))))?;
        output.write(|out| out.write_all(&bytes)).and_then(|()| output.commit()).map_err(Problem::Other)?;
    }
    let (preflight, _) = progress.step("preparing the run", None, |_| match &prepared {
        AnyPrepared::Plane(prepared) => Preflight::with_ranks(prepared, *ranks),
        AnyPrepared::Space(prepared) => Preflight::with_ranks(prepared, *ranks),
    });
    let mut preflight =
        preflight.map_err(|why| Problem::Other(Failure::Unusable(format!("{name} cannot run: {why}"))))?;
    match &prepared {
        AnyPrepared::Plane(prepared) => rehearse(&mut preflight, prepared, (path, &text), &progress),
        AnyPrepared::Space(prepared) => rehearse(&mut preflight, prepared, (path, &text), &progress),
    }
    Ok(preflight)
}

/// Rehearses the run of a model, if that is of use, for its estimate of the run time. Takes the path and the
/// text of the model file.
pub(crate) fn rehearse<const D: usize, const N: usize>(
    preflight: &mut Preflight,
    prepared: &Prepared<D, N>,
    (path, text): (&Path, &str),
    progress: &Progress,
) {
    let Some(factor) = Rehearsal::factor(prepared, preflight) else { return };
    let (rehearsal, _) = progress.step("rehearsing the run with a coarse mesh", None, |_| {
        // A mesh may be too coarse for its bodies: then the estimate stays.
        match prepare_coarse(text, &display_name(path), &mut inputs_of(path), factor).ok()? {
            AnyPrepared::Plane(coarse) => Rehearsal::of(&coarse),
            AnyPrepared::Space(coarse) => Rehearsal::of(&coarse),
        }
    });
    if let Some(rehearsal) = rehearsal {
        preflight.rehearse(&rehearsal);
    }
}

/// Reads the text of a model file.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    let name = display_name(path);
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes))
        .map_err(|error| Failure::reading(&name, &error))?;
    if bytes.len() as u64 > LARGEST {
        return Err(Failure::Unusable(format!("{name} is larger than 64 MiB: it is not a model file")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let start = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]);
        let line = start.matches('\n').count() + 1;
        Failure::Unusable(format!("{name}:{line}: this is not UTF-8 text"))
    })
}

/// The text of a model with the values of `--set`.
pub(crate) fn with_settings(text: String, path: &Path, set: &[(String, Setting)]) -> Result<String, Failure> {
    if set.is_empty() {
        return Ok(text);
    }
    let changed = with_values(&text, &mut inputs_of(path), set);
    changed.map_err(|why| Failure::Unusable(format!("{}: {why}", display_name(path))))
}

/// Returns a function that reads the files that a model names. Paths are relative to the folder of the model.
/// In a folder of results, a file that is missing there is read from `inputs/`, which numbers the files in
/// the order in which the model names them.
///
/// The function refuses devices and pipes, which may have no end.
pub(crate) fn inputs_of(model: &Path) -> impl FnMut(&str) -> Result<Vec<u8>, String> {
    let folder = model.parent().unwrap_or(Path::new("")).to_owned();
    let mut number = 0;
    move |file: &str| {
        let beside = folder.join(file);
        let kept = folder.join(format!("{INPUTS}/{number}"));
        number += 1;
        let is_kept = !beside.exists() && folder.join(SUMMARY).exists() && kept.exists();
        let path = if is_kept { kept } else { beside };
        if is_device(&path) {
            return Err("it is a device or a pipe, not a file".to_owned());
        }
        fs::read(path).map_err(|error| error.to_string())
    }
}

/// The failure that shows every error with its line, in colours on a terminal.
pub(crate) fn refused(errors: &ModelErrors) -> Failure {
    let drawing = if std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none() {
        Drawing::Terminal
    } else {
        Drawing::Plain
    };
    Failure::Unusable(refusal(errors, drawing))
}

/// Every error with its line, and their number.
pub(crate) fn refusal(errors: &ModelErrors, drawing: Drawing) -> String {
    let count = match errors.faults.len() {
        1 => "1 error".to_owned(),
        count => format!("{count} errors"),
    };
    format!("{} has {count}\n\n{}", errors.name, errors.render(drawing).trim_end())
}
