//! The folder of a run: what is in it, and how it stays readable whatever happens.
//!
//! ```text
//! model.toml, inputs/   the model as it was given, with the files that it names
//! checkpoint            the state of the run; `fdem resume` goes on from here
//! history.csv           a row for each instant
//! results.pvd, cracks.pvd, frames/   for ParaView
//! plots/, report.html, animation.gif   made when the run ends
//! run.json, run.log     what ran, on what, for how long; run.json tells that this is the folder of a run
//! ```
//! Every file but the two that grow, history and log, is written aside, synced and renamed: at any instant the folder holds whole files only. A checkpoint says how many frames there were
//! and up to which step the history counts; what is later than that is removed when the run goes on.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fdem_simulation::State;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::command::failure::{Failure, display_name};

pub(crate) const MODEL: &str = "model.toml";
pub(crate) const HISTORY: &str = "history.csv";
pub(crate) const LOG: &str = "run.log";
const CHECKPOINT: &str = "checkpoint";
const FRAMES: &str = "frames";
const INPUTS: &str = "inputs";
pub(crate) const PLOTS: &str = "plots";

/// What tells that a folder is of a run: made first, and never removed.
pub(crate) const SUMMARY: &str = "run.json";

/// All that a run makes, for `--force`.
const FILES: [&str; 10] = [
    // First, so that nobody goes on with a run of which the rest is gone.
    CHECKPOINT,
    MODEL,
    HISTORY,
    LOG,
    "results.pvd",
    "cracks.pvd",
    "report.html",
    "animation.gif",
    "picture.png",
    "picture.svg",
];
const FOLDERS: [&str; 4] = [FRAMES, INPUTS, PLOTS, "animation"];

/// The first line of a checkpoint: another version of its contents has another one.
const MAGIC: &[u8] = b"fdem checkpoint 2\n";

/// Where a run stands.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    /// Of the model, [`Prepared::hash`](crate::model::Prepared).
    pub(crate) model: String,
    /// Step and time of the frames that have been written.
    pub(crate) frames: Vec<(u64, f64)>,
    /// Length of the history, bytes.
    pub(crate) history: u64,
    /// Time on the clock until here, s.
    pub(crate) seconds: f64,
    pub(crate) state: State,
}

/// A folder of results.
#[derive(Debug, Clone)]
pub(crate) struct Folder {
    path: PathBuf,
    /// The model's file, locked as long as somebody is at work here.
    lock: Option<Arc<File>>,
}

impl Folder {
    /// One for a new run, with the model's text and the files that it names.
    pub(crate) fn create(path: &Path, force: bool, text: &[u8], inputs: &[Vec<u8>]) -> Result<Self, Failure> {
        let mut folder = Self { path: path.to_owned(), lock: None };
        let there = match fs::read_dir(path) {
            // The first file, if a run was killed before it was whole.
            Ok(mut entries) => {
                entries.any(|entry| entry.is_ok_and(|entry| entry.file_name() != "run.json.part"))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            Err(error) => return Err(Failure::writing(path, error)),
        };
        if there && !force {
            return Err(Failure::Unusable(format!(
                "{} is not empty: choose another folder with --output, go on with `fdem resume`, or replace its results with --force",
                display_name(path)
            )));
        }
        if there {
            if ![SUMMARY, CHECKPOINT].iter().any(|name| folder.path(name).exists()) {
                return Err(Failure::Unusable(format!(
                    "{} is not empty, and holds no run that --force could replace: choose another folder with --output",
                    display_name(path)
                )));
            }
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

    /// That of a run which has been.
    pub(crate) fn open(path: &Path) -> Result<(Self, Checkpoint), Failure> {
        let mut folder = Self { path: path.to_owned(), lock: None };
        folder.lock()?;
        let checkpoint = folder.checkpoint()?;
        Ok((folder, checkpoint))
    }

    /// Takes the folder for this process alone, until it ends. Where there is no model nobody is at work; a file system without locks has none.
    fn lock(&mut self) -> Result<(), Failure> {
        let Ok(file) = File::open(self.path(MODEL)) else { return Ok(()) };
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(Failure::Unusable(format!(
                "another fdem is at work in {}",
                display_name(&self.path)
            )));
        }
        self.lock = Some(Arc::new(file));
        Ok(())
    }

    /// Removes what a run makes, and nothing else.
    fn clear(&self) -> Result<(), Failure> {
        let remove = |name: &&str, how: fn(PathBuf) -> io::Result<()>| {
            let path = self.path(name);
            match how(path.clone()) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Failure::writing(&path, error)),
                _ => Ok(()),
            }
        };
        FILES.iter().try_for_each(|name| remove(name, fs::remove_file))?;
        FOLDERS.iter().try_for_each(|name| remove(name, fs::remove_dir_all))
    }

    /// Makes a folder in it.
    pub(crate) fn make(&self, name: &str) -> Result<(), Failure> {
        let path = self.path(name);
        fs::create_dir_all(&path).map_err(|error| Failure::writing(&path, error))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        if name.is_empty() { self.path.clone() } else { self.path.join(name) }
    }

    /// Writes a file aside, and puts it under its name when it is whole.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path(name);
        self.write_aside(&path, bytes).map_err(|error| Failure::writing(&path, error))
    }

    fn write_aside(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let folder = path.parent().unwrap_or(&self.path);
        let mut aside = path.as_os_str().to_owned();
        aside.push(".part");
        let mut file = File::create(&aside)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        drop(file);
        fs::rename(&aside, path)?;
        // The name, too, is on the disk only when the folder is.
        #[cfg(unix)]
        File::open(folder)?.sync_all()?;
        #[cfg(not(unix))]
        let _ = folder;
        Ok(())
    }

    pub(crate) fn read(&self, name: &str) -> Result<Vec<u8>, Failure> {
        let path = self.path(name);
        fs::read(&path).map_err(|error| Failure::reading(&display_name(&path), &error))
    }

    /// A file that the model names, by the order in which it does.
    pub(crate) fn input(&self, number: usize) -> io::Result<Vec<u8>> {
        fs::read(self.path(&format!("{INPUTS}/{number}")))
    }

    /// Saves where the run stands.
    pub(crate) fn save(&self, checkpoint: &Checkpoint) -> Result<(), Failure> {
        let path = self.path(CHECKPOINT);
        let payload = postcard::to_allocvec(checkpoint).map_err(|error| Failure::writing(&path, error))?;
        let bytes = [MAGIC, Sha256::digest(&payload).as_slice(), &payload].concat();
        self.write(CHECKPOINT, &bytes)
    }

    fn checkpoint(&self) -> Result<Checkpoint, Failure> {
        let path = self.path(CHECKPOINT);
        let name = display_name(&path);
        let mut bytes = Vec::new();
        match File::open(&path).and_then(|mut file| file.read_to_end(&mut bytes)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let folder = display_name(&self.path);
                return Err(Failure::Unusable(format!(
                    "{folder} holds no run: there is no checkpoint in it"
                )));
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
        postcard::from_bytes(payload).map_err(|error| damaged(&error.to_string()))
    }
}

/// Files of a frame.
pub(crate) fn mesh_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}.vtu")
}

/// Cracks of a frame.
pub(crate) fn cracks_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}_cracks.vtp")
}

/// A frame as the report needs it.
pub(crate) fn packed_file(number: usize) -> String {
    format!("{FRAMES}/{number:05}.frame")
}
