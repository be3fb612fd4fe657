//! `fdem check` reports errors, warnings and estimates of a model before it runs.

mod on_device;
mod picture;

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::command::args::CheckArguments;
use crate::command::device_name::DeviceName;
use crate::command::failure::{Failure, display_name};
use crate::command::memory;
use crate::command::model_file::{inputs_of, read_text, refused, with_settings};
use crate::command::output::{Output, print, refuse_to_overwrite};
use crate::command::progress::Progress;
use crate::command::rehearsal::rehearse;
use fdem_io::numbers::grouped;
use fdem_model::{AnyPrepared, BodyBox, ModelErrors, Preflight, prepare_any_with, schema};

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
    if let DeviceName::Gpu(number) = arguments.device {
        let (forecast, _) = progress.step("counting the memory on the device", None, |_| match &prepared {
            AnyPrepared::Plane(prepared) => on_device::forecast(number, prepared, preflight.steps),
            AnyPrepared::Space(prepared) => on_device::forecast(number, prepared, preflight.steps),
        });
        let wrong =
            |why| Problem::Other(Failure::Unusable(format!("{name} cannot run with --device gpu: {why}")));
        preflight.on_device = Some(forecast.map_err(wrong)?);
    }
    Ok(preflight)
}
