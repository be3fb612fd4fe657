//! `fdem check`: all that can be said of a model before it runs.

use std::fs;
use std::io::{IsTerminal, Write};
use std::path::Path;

use crate::command::args::CheckArguments;
use crate::command::failure::{Failure, display_name};
use crate::model::{Drawing, ModelErrors, Preflight, Prepared, prepare, schema};

pub(crate) fn run(arguments: &CheckArguments) -> Result<(), Failure> {
    if arguments.schema {
        let text = serde_json::to_string_pretty(&schema())
            .map_err(|error| Failure::Unusable(format!("cannot write the schema: {error}")))?;
        return print(&format!("{text}\n"));
    }
    let Some(path) = &arguments.model else {
        return Err(Failure::Unusable("no model file is given".to_owned()));
    };
    let prepared = read_model(path)?;
    let preflight = Preflight::of(&prepared)
        .map_err(|why| Failure::Unusable(format!("{} cannot run: {why}", display_name(path))))?;
    if arguments.json {
        let text = serde_json::to_string_pretty(&preflight)
            .map_err(|error| Failure::Unusable(format!("cannot write the preflight: {error}")))?;
        return print(&format!("{text}\n"));
    }
    print(&preflight.to_string())
}

/// Reads, checks and meshes a model file. Files that it names are looked for beside it.
pub(crate) fn read_model(path: &Path) -> Result<Prepared, Failure> {
    let name = display_name(path);
    let text = read_text(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut load = |file: &str| fs::read(folder.join(file)).map_err(|error| error.to_string());
    prepare(&text, &name, &mut load).map_err(|errors| refused(&errors))
}

/// The text of a model file.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    let name = display_name(path);
    let bytes = fs::read(path).map_err(|error| Failure::reading(&name, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let start = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]);
        let line = start.matches('\n').count() + 1;
        Failure::Unusable(format!("{name}:{line}: this is no text in UTF-8"))
    })
}

/// Every error with its line, in colours on a terminal.
pub(crate) fn refused(errors: &ModelErrors) -> Failure {
    let drawing = if std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none() {
        Drawing::Terminal
    } else {
        Drawing::Plain
    };
    let count = match errors.faults.len() {
        1 => "1 thing is wrong".to_owned(),
        count => format!("{count} things are wrong"),
    };
    Failure::Unusable(format!("{count} with {}\n{}", errors.name, errors.render(drawing).trim_end()))
}

/// To standard output; that nobody reads on is no failure.
fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::writing(Path::new("standard output"), error))
        }
        _ => Ok(()),
    }
}
