//! The folder of a sweep.
//!
//! ```text
//! sweep.json     what the sweep is: model, names and values of its runs; it marks the folder as that of a sweep
//! runs/001, …    a folder of `fdem run` for each run
//! runs.csv       the table of results
//! report.html    the page that compares the runs
//! ```

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::Value;

use crate::command::aside;
use crate::command::failure::{Failure, display_name};
use crate::command::folder_lock::FolderLock;
use crate::command::run::folder::{CHECKPOINT, HISTORY, PATIENCE, REPORT, SUMMARY, has_results};

/// Marks a folder as that of a sweep.
const SWEEP: &str = "sweep.json";
const RUNS: &str = "runs";
pub(crate) const TABLE: &str = "runs.csv";

/// The start of the status of a run that stopped because a file could not be read or written, and not by a
/// check of the simulation.
const OUTSIDE: &str = "stopped: cannot ";

/// Contents of the folder of a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FolderContent {
    /// Nothing.
    Nothing,
    /// A run that has no checkpoint yet.
    Begun,
    /// A run that can continue.
    Interrupted,
    /// A run that has finished or stopped early, with its `run.json`.
    Ended(Value),
}

/// The folder of a sweep. It is locked while a sweep uses it.
#[derive(Debug)]
pub(crate) struct Store {
    path: PathBuf,
    /// Digits of the names of runs.
    digits: usize,
    /// `None` for a folder that is looked at only.
    lock: Option<FolderLock>,
}

/// Whether the sweep in a folder is continued, and not replaced.
struct Continues(bool);

impl Store {
    /// The folder of a sweep with the given number of runs, to be looked at only.
    pub(crate) fn unopened(path: &Path, runs: usize) -> Self {
        Self { path: path.to_owned(), digits: runs.to_string().len().max(3), lock: None }
    }

    /// Opens the folder of a sweep with the given number of runs, or makes it. `identity`: identifies the
    /// sweep; `force`: removes the runs of an earlier sweep.
    ///
    /// # Errors
    /// A folder that has something else, or another sweep.
    pub(crate) fn open(path: &Path, identity: &Value, runs: usize, force: bool) -> Result<Self, Failure> {
        let mut store = Self::unopened(path, runs);
        store.earlier(identity, force)?;
        fs::create_dir_all(path).map_err(|error| Failure::writing(path, error))?;
        store.lock = Some(FolderLock::exclusive(path, Duration::ZERO)?);
        // Another sweep may have begun, and ended, before the lock.
        match store.earlier(identity, force)? {
            Some(Continues(true)) => return Ok(store),
            Some(Continues(false)) => store.clear()?,
            None => {}
        }
        store.write(SWEEP, format!("{identity:#}\n").as_bytes())?;
        let runs = store.path.join(RUNS);
        fs::create_dir_all(&runs).map_err(|error| Failure::writing(&runs, error))?;
        Ok(store)
    }

    /// Looks for an earlier sweep in the folder. Changes nothing.
    ///
    /// # Errors
    /// A folder that has something else, or another sweep that is not to be replaced.
    fn earlier(&self, identity: &Value, force: bool) -> Result<Option<Continues>, Failure> {
        if !has_results(&self.path)? {
            return Ok(None);
        }
        let place = display_name(&self.path);
        let earlier = fs::read(self.path.join(SWEEP)).ok();
        let Some(earlier) = earlier.and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok()) else {
            return Err(Failure::Unusable(format!(
                "{place} is not empty and has no sweep: choose another folder with --output"
            )));
        };
        if earlier != *identity && !force {
            return Err(Failure::Unusable(format!(
                "{place} has another sweep: {}. Choose another folder with --output, or replace its runs with --force",
                difference(&earlier, identity)
            )));
        }
        Ok(Some(Continues(!force)))
    }

    /// Removes the results of an earlier sweep, and nothing else.
    ///
    /// # Errors
    /// A run that still works: a sweep that is killed leaves its runs to themselves.
    fn clear(&self) -> Result<(), Failure> {
        let runs = self.path.join(RUNS);
        for entry in fs::read_dir(&runs).into_iter().flatten() {
            let run = entry.map_err(|error| Failure::writing(&runs, error))?.path();
            if run.is_dir() {
                let _lock = FolderLock::exclusive(&run, PATIENCE)?;
                fs::remove_dir_all(&run).map_err(|error| Failure::writing(&run, error))?;
            }
        }
        let remove = |name: &str, how: fn(PathBuf) -> io::Result<()>| {
            let path = self.path.join(name);
            match how(path.clone()) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Failure::writing(&path, error)),
                _ => Ok(()),
            }
        };
        remove(RUNS, fs::remove_dir_all)?;
        remove(TABLE, fs::remove_file)?;
        remove(REPORT, fs::remove_file)
    }

    /// Writes a file, which is complete or absent.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path.join(name);
        aside::replace(&path, bytes).map_err(|error| Failure::writing(&path, error))
    }

    /// The name of a run's folder in that of the sweep. `number`: from 1.
    pub(crate) fn name(&self, number: usize) -> String {
        format!("{RUNS}/{number:0digits$}", digits = self.digits)
    }

    /// The folder of a run.
    pub(crate) fn run(&self, number: usize) -> PathBuf {
        self.path.join(self.name(number))
    }

    /// Looks at the contents of the folder of a run.
    pub(crate) fn found(&self, number: usize) -> FolderContent {
        let folder = self.run(number);
        let json = self.summary(number);
        let status = json.as_ref().and_then(|json| json["status"].as_str()).unwrap_or("");
        let is_drawn = folder.join(REPORT).exists();
        let is_over = status == "finished" && is_drawn
            || status.starts_with("stopped: ") && !status.starts_with(OUTSIDE);
        match json {
            Some(json) if is_over => FolderContent::Ended(json),
            _ if folder.join(CHECKPOINT).exists() => FolderContent::Interrupted,
            _ if folder.join(SUMMARY).exists() => FolderContent::Begun,
            _ => FolderContent::Nothing,
        }
    }

    /// The `run.json` of a run.
    pub(crate) fn summary(&self, number: usize) -> Option<Value> {
        serde_json::from_slice(&fs::read(self.run(number).join(SUMMARY)).ok()?).ok()
    }

    /// The history of a run.
    pub(crate) fn history(&self, number: usize) -> Option<Vec<u8>> {
        fs::read(self.run(number).join(HISTORY)).ok()
    }
}

/// Describes the difference between two sweeps.
fn difference(earlier: &Value, now: &Value) -> String {
    let differs = |key: &str| earlier.get(key) != now.get(key);
    let [version, other] =
        [&earlier["version"], &now["version"]].map(|version| version.as_str().unwrap_or("?"));
    match () {
        () if differs("version") => format!("it was made by fdem {version}, and this is {other}"),
        () if differs("parameters") => "its parameters are others".to_owned(),
        () if differs("runs") => "the values of its runs are others".to_owned(),
        () => "its model has changed".to_owned(),
    }
}
