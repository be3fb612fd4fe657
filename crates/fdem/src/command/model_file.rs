//! A model file: its text, the files that it names, and its errors in words.

use std::fs::{self, File};
use std::io::{IsTerminal, Read};
use std::path::Path;

use crate::command::failure::{Failure, display_name};
use crate::command::output::is_device;
use crate::command::run::folder::{INPUTS, SUMMARY};
use fdem_model::{Drawing, ModelErrors, Setting, with_values};

/// Largest model file, bytes. The check against the schema and the errors need its text in memory.
const LARGEST: u64 = 64 << 20;

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
