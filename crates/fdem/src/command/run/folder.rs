//! The folder of a run. Its files stay readable even if the run is killed.
//!
//! ```text
//! model.toml, inputs/   copies of the model and of the files that it names
//! checkpoint            the state of the run, from which `fdem resume` goes on
//! history.csv           rows of energies, cracks, fragments and recorded quantities over time
//! events.csv            acoustic emission, if it is asked for
//! fragments.csv         masses, sizes and motion of the fragments when the run ends
//! results.pvd, cracks.pvd, damaged_joints.pvd, contacts.pvd, frames/   for ParaView
//! plots/, report.html, animation.gif   made when the run ends
//! run.json, run.log     model, machine, times and result; run.json marks a folder as that of a run
//! ```
//! Lines are appended to the history and the log. Every other file is written to a temporary file and
//! renamed, so that the folder holds complete files at any time. A checkpoint records the number of frames
//! and the length of the history; later frames and rows are removed when the run continues.
//!
//! Files are synced before they are renamed, except those of frames: they are synced later, but before the
//! collections and the checkpoint that name them. Frames that the collections and the checkpoint name are
//! complete also after a power cut. A frame that they do not name may then be cut off; it is removed when the
//! run continues.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use sha2::{Digest, Sha256};

use crate::command::aside::{self, Hold};
use crate::command::failure::{Failure, display_name};
use crate::command::memory;
use crate::command::run::checkpoint::Checkpoint;
use crate::command::run::results::Results;
use fdem_model::{AnyPrepared, ModelErrors, prepare_any};

/// Waiting time for a folder that another process has locked. After a rank has died, `mpirun` may return
/// before it has ended the other ranks.
const PATIENCE: Duration = Duration::from_secs(3);

pub(crate) const MODEL: &str = "model.toml";
pub(crate) const HISTORY: &str = "history.csv";
pub(crate) const FRAGMENTS: &str = "fragments.csv";
pub(crate) const EVENTS: &str = "events.csv";
pub(crate) const LOG: &str = "run.log";
pub(crate) const CHECKPOINT: &str = "checkpoint";
const FRAMES: &str = "frames";
pub(crate) const INPUTS: &str = "inputs";
pub(crate) const PLOTS: &str = "plots";
/// Written last when a run ends.
pub(crate) const REPORT: &str = "report.html";

/// Marks a folder as that of a run: this file is written first and never removed.
pub(crate) const SUMMARY: &str = "run.json";

/// Files that a run makes; `--force` removes them.
const FILES: [&str; 14] = [
    // First, so that nobody can resume a run whose other files are removed.
    CHECKPOINT,
    MODEL,
    HISTORY,
    FRAGMENTS,
    EVENTS,
    LOG,
    "results.pvd",
    "cracks.pvd",
    "damaged_joints.pvd",
    "contacts.pvd",
    REPORT,
    "animation.gif",
    "picture.png",
    "picture.svg",
];
const FOLDERS: [&str; 4] = [FRAMES, INPUTS, PLOTS, "animation"];

/// First line of a checkpoint. It changes whenever the contents change.
const MAGIC: &[u8] = b"fdem checkpoint 11\n";

/// A folder of results.
#[derive(Debug, Clone)]
pub(crate) struct Folder {
    path: PathBuf,
    /// The model's file. It is locked while a run uses the folder.
    lock: Option<Arc<File>>,
}

impl Folder {
    /// Whether the folder has an earlier run, which `force` replaces. Changes nothing.
    ///
    /// # Errors
    /// A folder that must not be replaced, or cannot be read.
    pub(crate) fn check(path: &Path, force: bool) -> Result<bool, Failure> {
        let there = match fs::read_dir(path) {
            // A run that was killed while writing its first file leaves partial files, which the next one
            // removes.
            Ok(mut entries) => entries.any(|entry| {
                entry.is_ok_and(|entry| !entry.file_name().to_str().is_some_and(aside::is_aside))
            }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            Err(error) => return Err(Failure::writing(path, error)),
        };
        if there && !force {
            return Err(Failure::Unusable(format!(
                "{} is not empty: choose another folder with --output, go on with `fdem resume`, or replace its results with --force",
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
    pub(crate) fn create(path: &Path, force: bool, text: &[u8], inputs: &[Vec<u8>]) -> Result<Self, Failure> {
        let there = Self::check(path, force)?;
        let mut folder = Self { path: path.to_owned(), lock: None };
        if there {
            folder.lock()?;
        }
        folder.make("")?;
        folder.write(SUMMARY, b"{ \"status\": \"begun\" }\n")?;
        if there {
            folder.clear()?;
        }
        folder.make(FRAMES)?;
        if !inputs.is_empty() {
            folder.make(INPUTS)?;
        }
        folder.write(MODEL, text)?;
        folder.lock()?;
        for (number, bytes) in inputs.iter().enumerate() {
            folder.write(&format!("{INPUTS}/{number}"), bytes)?;
        }
        Ok(folder)
    }

    /// Opens the folder of an earlier run.
    pub(crate) fn open(path: &Path) -> Result<(Self, SavedState), Failure> {
        let mut folder = Self { path: path.to_owned(), lock: None };
        folder.lock()?;
        let checkpoint = folder.checkpoint()?;
        Ok((folder, checkpoint))
    }

    /// Locks the folder for this process. A folder without a model has no run; a file system without locks is
    /// used unlocked.
    fn lock(&mut self) -> Result<(), Failure> {
        let Ok(file) = File::open(self.path(MODEL)) else { return Ok(()) };
        let start = Instant::now();
        while matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            if start.elapsed() > PATIENCE {
                return Err(Failure::Unusable(format!(
                    "another fdem process is using {}",
                    display_name(&self.path)
                )));
            }
            sleep(Duration::from_millis(20));
        }
        self.lock = Some(Arc::new(file));
        Ok(())
    }

    /// Whether the run has reached its end and everything is drawn.
    pub(crate) fn is_finished(&self) -> bool {
        let summary = fs::read(self.path(SUMMARY)).ok();
        let summary = summary.and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
        summary.is_some_and(|json| json["status"] == "finished") && self.path(REPORT).exists()
    }

    /// Replaces the text of the model, and keeps the folder locked.
    pub(crate) fn replace_model(&mut self, text: &[u8]) -> Result<(), Failure> {
        self.write(MODEL, text)?;
        self.lock()
    }

    /// Removes the files that a run makes, and nothing else.
    fn clear(&self) -> Result<(), Failure> {
        FILES.iter().try_for_each(|name| self.remove(name, fs::remove_file))?;
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
                *number >= first && files_of(*number).any(|file| file == format!("{FRAMES}/{name}"))
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
            let path = self.path(&format!("{INPUTS}/{}", inputs.len()));
            let bytes = fs::read(path).map_err(|error| error.to_string())?;
            inputs.push(bytes.clone());
            Ok(bytes)
        };
        let prepared = prepare_any(text, &display_name(&self.path(MODEL)), &mut load, memory::free())?;
        Ok((prepared, inputs))
    }

    /// Writes the checkpoint.
    pub(crate) fn save<const D: usize, const N: usize>(
        &self,
        checkpoint: &Checkpoint<D, N>,
    ) -> Result<(), Failure>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let path = self.path(CHECKPOINT);
        let payload =
            <[[f64; D]; N]>::checkpoint_bytes(checkpoint).map_err(|error| Failure::writing(&path, error))?;
        let bytes = [MAGIC, Sha256::digest(&payload).as_slice(), &payload].concat();
        self.write(CHECKPOINT, &bytes)
    }

    fn checkpoint(&self) -> Result<SavedState, Failure> {
        let path = self.path(CHECKPOINT);
        let name = display_name(&path);
        let mut bytes = Vec::new();
        match File::open(&path).and_then(|mut file| file.read_to_end(&mut bytes)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let folder = display_name(&self.path);
                if self.path(SUMMARY).exists() && self.path(MODEL).exists() {
                    return Err(Failure::Unusable(format!(
                        "the run in {folder} ended before its first checkpoint, and cannot go on: start it again with `fdem run --force`"
                    )));
                }
                return Err(Failure::Unusable(format!("{folder} has no run: there is no checkpoint in it")));
            }
            Err(error) => return Err(Failure::reading(&name, &error)),
            Ok(_) => {}
        }
        let damaged = |why: &str| Failure::Unusable(format!("{name} is damaged: {why}"));
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err(damaged("it is not a checkpoint of this version of fdem"));
        };
        let Some((digest, payload)) = rest.split_at_checked(32) else { return Err(damaged("it is cut off")) };
        if Sha256::digest(payload).as_slice() != digest {
            return Err(damaged("its checksum is wrong"));
        }
        Ok(SavedState { name, payload: payload.to_vec() })
    }
}

/// A checkpoint that is complete, and not opened yet.
pub(crate) struct SavedState {
    /// Name of its file.
    name: String,
    payload: Vec<u8>,
}

impl SavedState {
    /// Opens the checkpoint of a run in `D` dimensions.
    pub(crate) fn open<const D: usize, const N: usize>(&self) -> Result<Checkpoint<D, N>, Failure>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        <[[f64; D]; N]>::checkpoint(&self.payload)
            .map_err(|error| Failure::Unusable(format!("{} is damaged: {error}", self.name)))
    }
}

/// Name of the mesh file of a frame.
pub(crate) fn mesh_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}.vtu")
}

/// Name of the file of the broken joints of a frame.
pub(crate) fn cracks_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}_cracks.vtp")
}

/// Name of the file of the joints of a frame that soften and hold.
pub(crate) fn damaged_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}_damaged_joints.vtp")
}

/// Name of the file of the contact forces of a frame.
pub(crate) fn contacts_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}_contacts.vtp")
}

/// Returns the name of a file of a frame.
type FrameFile = fn(usize) -> String;

/// Collections that ParaView opens, and the names of their files by frame.
pub(crate) const COLLECTIONS: [(&str, FrameFile); 4] = [
    ("results.pvd", mesh_file),
    ("cracks.pvd", cracks_file),
    ("damaged_joints.pvd", damaged_file),
    ("contacts.pvd", contacts_file),
];

/// Name of the file of a frame for the report.
pub(crate) fn packed_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}.frame")
}

/// Returns the names of the files of a frame.
pub(crate) fn files_of(number: usize) -> impl Iterator<Item = String> {
    COLLECTIONS.into_iter().map(move |(_, file_of)| file_of(number)).chain([packed_file(number)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder that another process has locked is waited for, but not for long.
    #[test]
    fn a_locked_folder_is_waited_for() {
        let place = tempfile::tempdir().expect("a folder");
        fs::write(place.path().join(MODEL), "").expect("a model");
        let lock = || {
            let file = File::open(place.path().join(MODEL)).expect("a model");
            file.lock().expect("a lock");
            file
        };
        let mut folder = Folder { path: place.path().to_owned(), lock: None };

        let held = lock();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                sleep(Duration::from_millis(200));
                drop(held);
            });
            folder.lock().expect("the other process has ended");
        });
        folder.lock = None;

        let _held = lock();
        let Err(Failure::Unusable(why)) = folder.lock() else { panic!("the folder is in use") };
        assert!(why.starts_with("another fdem process is using "), "{why}");
    }
}
