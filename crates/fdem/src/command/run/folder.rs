//! The folder of a run. Its files stay readable even if the run is killed.
//!
//! ```text
//! model.toml, inputs/   copies of the model and of the files that it names
//! checkpoint            the state of the run, from which `fdem resume` goes on
//! history.csv           rows of energies, cracks, fragments and recorded quantities over time
//! events.csv            acoustic emission, if it is asked for
//! fragments.csv         masses, sizes and motion of the fragments when the run ends
//! results.pvd, cracks.pvd, damaged_joints.pvd, intact_joints.pvd, contacts.pvd, frames/   for ParaView
//! spheres.pvd, sphere_contacts.pvd, walls.pvd, coarse.pvd   the same for spheres and walls
//! plots/, report.html, animation.gif   made when the run ends
//! run.json, run.log     model, machine, times and result; run.json marks a folder as that of a run
//! ```
//! Lines are appended to the history and the log. Every other file is written to a temporary file and
//! renamed, so that the folder holds complete files at any time. A checkpoint has the checksums of the frames
//! and of the history until then; later frames and rows are removed when the run continues.
//!
//! A process locks the folder before it changes anything in it, and keeps the lock until it ends.
//!
//! Files are synced before they are renamed, except those of frames: they are synced later, but before the
//! collections and the checkpoint that name them. Frames that the collections and the checkpoint name are
//! complete also after a power cut. A frame that they do not name may then be cut off; it is removed when the
//! run continues.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use sha2::{Digest, Sha256};

use crate::command::aside::{self, Hold};
use crate::command::failure::{Failure, display_name};
use crate::command::folder_lock::{FolderLock, is_lock};
use crate::command::memory;
use crate::command::run::checkpoint::Checkpoint;
use crate::command::run::frame_files::{FRAMES, FrameFile};
use crate::command::run::manifest::Manifest;
use crate::command::run::results::Results;
use fdem_model::{AnyPrepared, ModelErrors, prepare_any};

/// Waiting time for a folder that another process has locked. After a rank has died, `mpirun` may return
/// before it has ended the other ranks.
pub(crate) const PATIENCE: Duration = Duration::from_secs(3);

pub(crate) const MODEL: &str = "model.toml";
pub(crate) const HISTORY: &str = "history.csv";
pub(crate) const FRAGMENTS: &str = "fragments.csv";
pub(crate) const EVENTS: &str = "events.csv";
pub(crate) const LOG: &str = "run.log";
pub(crate) const CHECKPOINT: &str = "checkpoint";
pub(crate) const INPUTS: &str = "inputs";
pub(crate) const PLOTS: &str = "plots";
/// Written last when a run ends.
pub(crate) const REPORT: &str = "report.html";

/// Marks a folder as that of a run: this file is written first and never removed.
pub(crate) const SUMMARY: &str = "run.json";

/// Files that a run makes, besides collections of frames; `--force` removes them.
const FILES: [&str; 10] = [
    // First, so that nobody can resume a run whose other files are removed.
    CHECKPOINT,
    MODEL,
    HISTORY,
    FRAGMENTS,
    EVENTS,
    LOG,
    REPORT,
    "animation.gif",
    "picture.png",
    "picture.svg",
];
const FOLDERS: [&str; 4] = [FRAMES, INPUTS, PLOTS, "animation"];

/// First line of a checkpoint. It changes whenever the contents change.
const MAGIC: &[u8] = b"fdem checkpoint 19\n";

/// A folder of results.
#[derive(Debug, Clone)]
pub(crate) struct Folder {
    path: PathBuf,
    /// `None` for a folder that is only read, and into which no process has written.
    _lock: Option<Arc<FolderLock>>,
}

impl Folder {
    /// Whether the folder has an earlier run, which `force` replaces. Changes nothing.
    ///
    /// # Errors
    /// A folder that must not be replaced, or cannot be read.
    pub(crate) fn check(path: &Path, force: bool) -> Result<bool, Failure> {
        let there = has_results(path)?;
        if there && !force {
            return Err(Failure::Unusable(format!(
                "{} is not empty: choose another folder with --output, continue with `fdem resume`, or replace its results with --force",
                display_name(path)
            )));
        }
        if there && ![SUMMARY, CHECKPOINT].iter().any(|name| path.join(name).exists()) {
            return Err(Failure::Unusable(format!(
                "{} is not empty and has no run that --force could replace: choose another folder with --output",
                display_name(path)
            )));
        }
        Ok(there)
    }

    /// Makes the folder of a new run, with the text of the model and the files that it names.
    ///
    /// # Errors
    /// A folder that [`Self::check`] refuses, or that another process uses. Nothing in it is changed then.
    pub(crate) fn create(path: &Path, force: bool, text: &[u8], inputs: &[Vec<u8>]) -> Result<Self, Failure> {
        // A run that has just been interrupted may still be ending. A folder that had nothing has another
        // run that begins now.
        let patience = if Self::check(path, force)? { PATIENCE } else { Duration::ZERO };
        fs::create_dir_all(path).map_err(|error| Failure::writing(path, error))?;
        let lock = FolderLock::exclusive(path, patience)?;
        // Another run may have begun, and ended, before the lock.
        let there = Self::check(path, force)?;
        let folder = Self { path: path.to_owned(), _lock: Some(Arc::new(lock)) };
        folder.write(SUMMARY, b"{ \"status\": \"begun\" }\n")?;
        if there {
            folder.clear()?;
        }
        folder.make(FRAMES)?;
        if !inputs.is_empty() {
            folder.make(INPUTS)?;
        }
        folder.write(MODEL, text)?;
        for (number, bytes) in inputs.iter().enumerate() {
            folder.write(&input_file(number), bytes)?;
        }
        Ok(folder)
    }

    /// Opens the folder of an earlier run, to continue it.
    pub(crate) fn open(path: &Path) -> Result<(Self, SavedState), Failure> {
        // A folder that has no run is left as it is.
        if !path.join(CHECKPOINT).exists() {
            return Err(without_checkpoint(path));
        }
        let lock = FolderLock::exclusive(path, PATIENCE)?;
        let folder = Self { path: path.to_owned(), _lock: Some(Arc::new(lock)) };
        let checkpoint = folder.checkpoint()?;
        Ok((folder, checkpoint))
    }

    /// Opens the folder of an earlier run, only to read it.
    pub(crate) fn open_to_read(path: &Path) -> Result<(Self, SavedState), Failure> {
        let lock = FolderLock::shared(path, PATIENCE)?;
        let folder = Self { path: path.to_owned(), _lock: lock.map(Arc::new) };
        let checkpoint = folder.checkpoint()?;
        Ok((folder, checkpoint))
    }

    /// Whether the run has reached its end, at this step, and everything is drawn. A run with a later end
    /// that is killed just after its last checkpoint has the summary and the report of the earlier one.
    pub(crate) fn is_finished(&self, step: u64) -> bool {
        let summary = fs::read(self.path(SUMMARY)).ok();
        let summary = summary.and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
        let is_of_end = |json: serde_json::Value| json["status"] == "finished" && json["steps"] == step;
        summary.is_some_and(is_of_end) && self.path(REPORT).exists()
    }

    /// Removes the files that a run makes, and nothing else.
    fn clear(&self) -> Result<(), Failure> {
        let collections = FrameFile::ALL.into_iter().filter_map(FrameFile::collection);
        FILES.into_iter().chain(collections).try_for_each(|name| self.remove(name, fs::remove_file))?;
        FOLDERS.iter().try_for_each(|name| self.remove(name, fs::remove_dir_all))
    }

    /// Removes a file or a subfolder, if it is there.
    fn remove(&self, name: &str, how: fn(PathBuf) -> io::Result<()>) -> Result<(), Failure> {
        let path = self.path(name);
        match how(path.clone()) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Failure::writing(&path, error)),
            _ => Ok(()),
        }
    }

    /// Removes the report of an earlier end, if there is one. One that cannot be removed cannot be written
    /// either, which is reported then.
    pub(crate) fn remove_report(&self) {
        let _ = self.remove(REPORT, fs::remove_file);
    }

    /// Removes plots, as far as there are any.
    pub(crate) fn remove_plots(&self, names: &[&str]) -> Result<(), Failure> {
        let mut files =
            names.iter().flat_map(|name| ["svg", "png"].map(|end| format!("{PLOTS}/{name}.{end}")));
        files.try_for_each(|file| self.remove(&file, fs::remove_file))
    }

    /// Makes a subfolder.
    pub(crate) fn make(&self, name: &str) -> Result<(), Failure> {
        let path = self.path(name);
        fs::create_dir_all(&path).map_err(|error| Failure::writing(&path, error))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        if name.is_empty() { self.path.clone() } else { self.path.join(name) }
    }

    /// Writes a file, which is complete or absent.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path(name);
        aside::replace(&path, bytes).map_err(|error| Failure::writing(&path, error))
    }

    /// Writes a file, which is complete or absent for other processes, and which the disk has only after it
    /// and its folder are synced.
    pub(crate) fn write_unsynced(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path(name);
        aside::replace_unsynced(&path, bytes).map_err(|error| Failure::writing(&path, error))
    }

    /// Waits until the disk has the contents of a file.
    pub(crate) fn sync(&self, name: &str) -> Result<(), Failure> {
        let path = self.path(name);
        aside::sync(&path).map_err(|error| Failure::writing(&path, error))
    }

    /// Waits until the disk has the names of the files of frames.
    pub(crate) fn sync_frames(&self) -> Result<(), Failure> {
        let path = self.path(FRAMES);
        aside::sync_folder(&path).map_err(|error| Failure::writing(&path, error))
    }

    /// Removes the files of frames from a number on. After a power cut some numbers between them may be
    /// missing.
    pub(crate) fn remove_frames(&self, first: usize) -> Result<(), Failure> {
        let path = self.path(FRAMES);
        let failed = |error| Failure::writing(&path, error);
        for entry in fs::read_dir(&path).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            let name = name.to_string_lossy();
            let number = name.split(['.', '_']).next().and_then(|number| number.parse().ok());
            let is_later = |number: &usize| {
                *number >= first
                    && FrameFile::ALL.iter().any(|file| file.of(*number) == format!("{FRAMES}/{name}"))
            };
            if number.is_some_and(|number| is_later(&number)) {
                fs::remove_file(path.join(&*name)).map_err(failed)?;
            }
        }
        Ok(())
    }

    /// Keeps lock files in this folder and in that of the frames, so that files are written with less work.
    pub(crate) fn hold(&self) -> Result<[Hold; 2], Failure> {
        let hold = |name| {
            let path = self.path(name);
            aside::hold(&path).map_err(|error| Failure::writing(&path, error))
        };
        Ok([hold("")?, hold(FRAMES)?])
    }

    pub(crate) fn read(&self, name: &str) -> Result<Vec<u8>, Failure> {
        let path = self.path(name);
        fs::read(&path).map_err(|error| Failure::reading(&display_name(&path), &error))
    }

    /// Checks and meshes the model of the folder, whose text this is. Returns the model, and the files that
    /// it names in their order, of which the folder has copies.
    pub(crate) fn prepared(&self, text: &str) -> Result<(AnyPrepared, Vec<Vec<u8>>), ModelErrors> {
        let mut inputs = Vec::new();
        let mut load = |_: &str| {
            let path = self.path(&input_file(inputs.len()));
            let bytes = fs::read(path).map_err(|error| error.to_string())?;
            inputs.push(bytes.clone());
            Ok(bytes)
        };
        let prepared = prepare_any(text, &display_name(&self.path(MODEL)), &mut load, memory::free())?;
        Ok((prepared, inputs))
    }

    /// Writes the checkpoint. `manifest`: the finished results that belong to it.
    pub(crate) fn save<const D: usize, const N: usize>(
        &self,
        manifest: &Manifest,
        checkpoint: &Checkpoint<D, N>,
    ) -> Result<(), Failure>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let path = self.path(CHECKPOINT);
        let failed = |error| Failure::writing(&path, error);
        let mut payload = postcard::to_allocvec(manifest).map_err(failed)?;
        payload.extend(<[[f64; D]; N]>::checkpoint_bytes(checkpoint).map_err(failed)?);
        let bytes = [MAGIC, Sha256::digest(&payload).as_slice(), &payload].concat();
        self.write(CHECKPOINT, &bytes)
    }

    fn checkpoint(&self) -> Result<SavedState, Failure> {
        let path = self.path(CHECKPOINT);
        let name = display_name(&path);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Err(without_checkpoint(&self.path));
            }
            Err(error) => return Err(Failure::reading(&name, &error)),
        };
        let damaged = |why: &str| {
            Failure::Unusable(format!(
                "{name} is damaged: {why}. Restore it from a copy, or start the run again with `fdem run --force`"
            ))
        };
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err(damaged("it is not a checkpoint of this version of fdem"));
        };
        let Some((digest, payload)) = rest.split_at_checked(32) else { return Err(damaged("it is cut off")) };
        if Sha256::digest(payload).as_slice() != digest {
            return Err(damaged("its checksum is wrong"));
        }
        match postcard::take_from_bytes(payload) {
            Ok((manifest, state)) => Ok(SavedState { name, manifest, state: state.to_vec() }),
            Err(error) => Err(damaged(&error.to_string())),
        }
    }
}

/// The failure for a folder that has no checkpoint.
fn without_checkpoint(path: &Path) -> Failure {
    let folder = display_name(path);
    if path.join(SUMMARY).exists() && path.join(MODEL).exists() {
        return Failure::Unusable(format!(
            "the run in {folder} has no checkpoint, and cannot continue: either the file was deleted, or the run ended before its first checkpoint. Restore it from a copy, or start the run again with `fdem run --force`"
        ));
    }
    Failure::Unusable(format!("{folder} has no run: there is no checkpoint in it"))
}

/// A checkpoint that is complete, and not opened yet.
pub(crate) struct SavedState {
    /// Name of its file.
    name: String,
    /// The finished results that belong to it.
    pub(crate) manifest: Manifest,
    state: Vec<u8>,
}

impl SavedState {
    /// Opens the checkpoint of a run in `D` dimensions.
    pub(crate) fn open<const D: usize, const N: usize>(&self) -> Result<Checkpoint<D, N>, Failure>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        <[[f64; D]; N]>::checkpoint(&self.state)
            .map_err(|error| Failure::Unusable(format!("{} is damaged: {error}", self.name)))
    }
}

/// Whether there is anything in a folder but lock files and partial files, which a run leaves that is killed
/// while it writes its first file.
///
/// # Errors
/// A folder that cannot be read.
pub(crate) fn has_results(path: &Path) -> Result<bool, Failure> {
    let is_result = |entry: io::Result<fs::DirEntry>| {
        entry.is_ok_and(|entry| {
            !entry.file_name().to_str().is_some_and(|name| aside::is_aside(name) || is_lock(name))
        })
    };
    match fs::read_dir(path) {
        Ok(mut entries) => Ok(entries.any(is_result)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(Failure::writing(path, error)),
    }
}

/// Name of the copy of a file that the model names.
pub(crate) fn input_file(number: usize) -> String {
    format!("{INPUTS}/{number}")
}
