//! Checks that the results in a folder are those that its run wrote, before the run continues.

use std::fs;
use std::io;
use std::path::Path;

use fdem_io::numbers::grouped;

use crate::command::failure::{Failure, display_name};
use crate::command::run::folder::{Folder, HISTORY, MODEL, input_file};
use crate::command::run::manifest::{Checksum, Hashed, Manifest};

/// Damaged files that a message names.
const NAMED: usize = 8;

/// The results of a run that can continue.
pub(crate) struct Intact {
    /// The rows of the history until the checkpoint.
    pub(crate) history: Hashed,
    /// Names of files that are damaged or missing, and that the run makes again from its checkpoint.
    pub(crate) damaged: Vec<String>,
}

impl Intact {
    /// Compares all files that a checkpoint names with their checksums.
    ///
    /// # Errors
    /// Damaged or missing files that the run cannot make again, with their names.
    pub(crate) fn check(folder: &Folder, manifest: &Manifest) -> Result<Self, Failure> {
        let mut problems = Problems::of_inputs(folder, manifest)?;
        let history = problems.history(&folder.path(HISTORY), manifest.history)?;
        let mut damaged = Vec::new();
        for (number, record) in manifest.frames.iter().enumerate() {
            // The checkpoint has the state that this frame shows.
            let is_now = number + 1 == manifest.frames.len() && record.step == manifest.step;
            for (file, checksum) in &record.files {
                let name = file.of(number);
                let Some(why) = difference(&folder.path(&name), *checksum)? else { continue };
                if is_now {
                    damaged.push(name);
                } else {
                    problems.add(&folder.path(&name), &why);
                }
            }
        }
        // Tables are written when the run ends, and so once more.
        for (name, checksum) in &manifest.tables {
            damaged.extend(difference(&folder.path(name), *checksum)?.map(|_| name.clone()));
        }
        match (history, problems.files.is_empty()) {
            (Some(history), true) => Ok(Self { history, damaged }),
            _ => Err(problems.failure(folder)),
        }
    }

    /// Whether no file has to be made again.
    pub(crate) fn is_whole(&self) -> bool {
        self.damaged.is_empty()
    }
}

/// Compares the copies of the files that the model names with their checksums.
///
/// # Errors
/// Damaged or missing copies, with their names.
pub(crate) fn check_inputs(folder: &Folder, manifest: &Manifest) -> Result<(), Failure> {
    let problems = Problems::of_inputs(folder, manifest)?;
    if problems.files.is_empty() { Ok(()) } else { Err(problems.failure(folder)) }
}

/// Damaged files, with the reason for each.
#[derive(Default)]
pub(crate) struct Problems {
    files: Vec<String>,
    /// Whether a file that the model names is among them: without it, the state is of no use.
    has_inputs: bool,
}

impl Problems {
    fn of_inputs(folder: &Folder, manifest: &Manifest) -> Result<Self, Failure> {
        let mut problems = Self::default();
        for (number, checksum) in manifest.inputs.iter().enumerate() {
            let path = folder.path(&input_file(number));
            if let Some(why) = difference(&path, *checksum)? {
                problems.add(&path, &why);
                problems.has_inputs = true;
            }
        }
        Ok(problems)
    }

    /// Adds a file with the reason why it is damaged.
    pub(crate) fn add(&mut self, path: &Path, why: &str) {
        self.files.push(format!("{}: {why}", display_name(path)));
    }

    /// The failure of the run in a folder.
    pub(crate) fn failure(&self, folder: &Folder) -> Failure {
        let (named, more) = self.files.split_at(self.files.len().min(NAMED));
        let mut lines = named.to_vec();
        if !more.is_empty() {
            lines.push(format!("and {} more files", grouped(more.len() as u64)));
        }
        let lines = lines.join("\n");
        let (place, model) = (display_name(&folder.path("")), display_name(&folder.path(MODEL)));
        let otherwise = if self.has_inputs {
            "start again with `fdem run --force`".to_owned()
        } else {
            format!(
                "continue from the last checkpoint in a new folder with `fdem run {model} --from {place} --output NEW`, or start again with `fdem run --force`"
            )
        };
        Failure::Unusable(format!(
            "files in {place} are not those that its run wrote:\n{lines}\nrestore them from a copy; without one, {otherwise}"
        ))
    }

    /// Reads the beginning of the history.
    fn history(&mut self, path: &Path, expected: Checksum) -> Result<Option<Hashed>, Failure> {
        let Some(length) = length(path)? else {
            self.add(path, MISSING);
            return Ok(None);
        };
        let read = Hashed::read(path, expected.length).map_err(|error| reading(path, &error))?;
        if read.checksum() == expected {
            return Ok(Some(read));
        }
        if length < expected.length {
            let [left, all] = [length, expected.length].map(grouped);
            self.add(path, &format!("{left} of its {all} bytes are left"));
        } else {
            self.add(path, "rows until the checkpoint have changed");
        }
        Ok(None)
    }
}

const MISSING: &str = "it is missing";

/// The difference between a file and the one that was written, in words.
fn difference(path: &Path, expected: Checksum) -> Result<Option<String>, Failure> {
    let Some(length) = length(path)? else { return Ok(Some(MISSING.to_owned())) };
    if length != expected.length {
        let [now, before] = [length, expected.length].map(grouped);
        return Ok(Some(format!("it has {now} bytes, and the run wrote {before}")));
    }
    let read = Hashed::read(path, length).map_err(|error| reading(path, &error))?;
    Ok((read.checksum() != expected).then(|| "its contents have changed".to_owned()))
}

/// Length of a file, bytes; `None` if it is not there.
fn length(path: &Path) -> Result<Option<u64>, Failure> {
    match fs::metadata(path) {
        Ok(metadata) => Ok(Some(metadata.len())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(reading(path, &error)),
    }
}

fn reading(path: &Path, error: &io::Error) -> Failure {
    Failure::reading(&display_name(path), error)
}
